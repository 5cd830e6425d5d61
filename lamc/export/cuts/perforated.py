"""Perforations: a line as dashes that are cut, with bridges between them and at both ends."""

from shapely.geometry import LineString
from shapely.ops import substring

_CUT = 0.5  # of the line


def dashes_of(line: LineString, pitch: float) -> list[LineString]:
    """A whole number of dashes, as near to the pitch, m, as their number allows; at least one."""
    count = max(1, round(line.length / pitch))
    ends = [((k + 0.5 - 0.5 * _CUT) / count, (k + 0.5 + 0.5 * _CUT) / count) for k in range(count)]
    return [substring(line, start, end, normalized=True) for start, end in ends]

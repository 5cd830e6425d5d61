"""Perforations: a line as dashes that are cut, with bridges between them and at both ends."""

from shapely.geometry import LineString
from shapely.ops import substring

from lamc.basics.errors import ExportError

_CUT = 0.5  # of the line


def dashes_of(line: LineString, pitch: float, kerf: float, where: str) -> list[LineString]:
    """A whole number of dashes, as near to the pitch, m, as their number allows; at least one. Each is drawn shorter by
    the kerf, m, which the cutter takes at its ends.

    Raises ExportError where the kerf is as long as what a dash is to cut. where: the line is, for it."""
    count = max(1, round(line.length / pitch))
    cut = _CUT * line.length / count
    if kerf >= cut and count == 1:
        raise ExportError(
            f"{where} one perforation would cut {1e3 * cut:.3g} mm of {1e3 * line.length:.3g} mm, and the kerf alone "
            f"takes {1e3 * kerf:.3g} mm: the line is too short for it; score it, or take a finer cutter"
        )
    if kerf >= cut:
        raise ExportError(
            f"{where} perforations cut {1e3 * cut:.3g} mm and leave as much, and the kerf alone takes "
            f"{1e3 * kerf:.3g} mm: take a longer pitch than {1e3 * line.length / count:.3g} mm, or a finer cutter"
        )
    half = 0.5 * (cut - kerf) / line.length
    return [
        substring(line, (k + 0.5) / count - half, (k + 0.5) / count + half, normalized=True)
        for k in range(count)
    ]

"""Lines for cutters and drawing programs: what each is for, and where it goes.

In: points, m. Out: records that `svg` and `dxf` write. Never: rounds a coordinate; 17 digits leave here.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from shapely.geometry import LineString, Polygon

from lamc.records.mechanism import Array


@dataclass(frozen=True)
class Pen:
    """A layer of a file, and the colour that its lines have: for SVG, and its number in AutoCAD's index for DXF.

    about  what programs show of the layer beside its name
    """

    name: str
    colour: str
    index: int
    about: str = ""


# Cutters run layers by name: what lies within a part goes before the line that lets it fall out.
HOLES, SCORES, SLITS, OUTLINE, FRAME = (
    Pen("1_holes", "#000000", 7),
    Pen("2_creases", "#ff00ff", 6),
    Pen("2_slits", "#00ff00", 3),
    Pen("3_outline", "#000000", 7),
    Pen("4_reference", "#808080", 8),
)
# Of sheets of creases: names and colours as the readers of drawings know them.
ROLES: Mapping[str, Pen] = MappingProxyType(
    {
        "hole": Pen("hole", "#000000", 7),
        "mountain": Pen("mountain", "#ff0000", 1),
        "valley": Pen("valley", "#0000ff", 5),
        "hinge": Pen("hinge", "#ff0000", 1),
        "undriven": Pen("undriven", "#ff00ff", 6),
        "flat": Pen("flat", "#ffff00", 2),
        "cut": Pen("cut", "#00ff00", 3),
        "border": Pen("border", "#000000", 7),
    }
)


@dataclass(frozen=True, eq=False)
class CutLine:
    """One path.

    points  (n, 2), m; a closed one does not repeat its first point
    angle   rad, at which a crease rests, without its sign, which the pen has; None: it is no crease
    """

    points: Array
    closed: bool
    pen: Pen
    angle: float | None = None


def rings_of(parts: Sequence[Polygon], outline: Pen = OUTLINE, holes: Pen = HOLES) -> list[CutLine]:
    """Outlines and holes of parts, holes first."""
    inner = [closed(ring.coords, holes) for part in parts for ring in part.interiors]
    return inner + [closed(part.exterior.coords, outline) for part in parts]


def closed(coords: Sequence[Sequence[float]], pen: Pen) -> CutLine:
    """The line of a ring that ends where it begins."""
    return CutLine(np.array(coords, dtype=np.float64)[:-1, :2], True, pen)


def open_line(line: LineString, pen: Pen) -> CutLine:
    return CutLine(np.array(line.coords, dtype=np.float64)[:, :2], False, pen)


def bounds_of(lines: Sequence[CutLine]) -> tuple[Array, Array]:
    """Lowest and highest corner of the box around all lines, m."""
    points = np.concatenate([line.points for line in lines])
    return points.min(axis=0), points.max(axis=0)


def pens_of(lines: Sequence[CutLine]) -> list[Pen]:
    """The pens that are used, by name."""
    return sorted({line.pen for line in lines}, key=lambda pen: pen.name)

"""The `Drawing` record: lines of an SVG or DXF file as polylines with a role each, in m, before they are a sheet.

Readers of drawings make it; `lamc/readers/drawings` heals it and makes a sheet of creases of it, or a layer's shape.
x to the right, y up, seen from the side that the drawing shows; curves are flattened where the file was read.
"""

from dataclasses import dataclass
from typing import Literal, get_args

from lamc.basics.checks import Array

Role = Literal["border", "hole", "cut", "mountain", "valley", "hinge", "undriven", "flat", "ignore"]
ROLES: tuple[Role, ...] = get_args(Role)
"""What a line is for.

border    an outline of material: the rim of a sheet, or of a layer; outlines within outlines are holes, by turns
hole      an outline of what is taken away
cut       a line along which the sheet is cut
mountain  a crease that rests at a negative angle; valley: at a positive one
hinge     a crease with a spring that rests flat
undriven  a crease without a spring
flat      a line along which the facets stay one body
ignore    text, dimensions, marks: nothing
"""


@dataclass(frozen=True)
class Stroke:
    """One line, curve or outline.

    points  (n, 2), m, n at least 2; a closed stroke does not repeat its first point
    role    what it is for
    angle   rad, at which a crease rests, positive for a valley; None: the drawing does not say
    layer   the layer or group that it is on; "" for none
    source  what the file calls it, for messages: "path #fold3", "LWPOLYLINE 2F"
    full    its angle, 180 degrees, is of an opacity of 1, which lines have that say none
    groups  names of all groups that it is in, the outermost first: a layer is of each of them
    """

    points: Array
    closed: bool
    role: Role
    angle: float | None = None
    layer: str = ""
    source: str = ""
    full: bool = False
    groups: tuple[str, ...] = ()


@dataclass(frozen=True)
class Drawing:
    """One file's strokes, in the order of the file.

    name     title of the drawing, else the file's stem
    scale    m, of one unit of the file's coordinates; messages give places in both
    notes    a line for everything that was assumed or left out
    """

    name: str
    strokes: tuple[Stroke, ...]
    scale: float
    notes: tuple[str, ...] = ()
    file: str = ""


STRAY = "line that bounds nothing"  # of a `Mend`: what was drawn, and is no part of the design


@dataclass(frozen=True)
class Mend:
    """One thing that healing changed.

    what    "end points joined", "doubled line", "T-junction", "gap in an outline", "hinge extended", `STRAY`, …
    at      m, where
    moved   m, how far; 0 where nothing moved
    source  strokes that it is about
    """

    what: str
    at: tuple[float, float]
    moved: float
    source: str

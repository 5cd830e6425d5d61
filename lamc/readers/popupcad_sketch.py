"""popupCAD sketches and shapes: drawn geometry in metres.

In: nodes of sketches and of shapes (GenericPoly, GenericTwoPointRect, …), coordinates in mm. Out: shapely
geometry, and straight hinge lines. Construction geometry is left out; a malformed shape is an error.

Units of vertices changed over the years: a tag with a version (`!ShapeVertex_1`) and the attribute `_position` are mm;
what came before (`!ShapeVertex`, `_pos`, `_Vertex__pos`) are thousandths of it, as popupCAD's own reader takes them
(`deprecated_internal_argument_scaling` of its `geometry/vertex.py`). Lists without a tag are mm.
"""

import math
import re
from itertools import pairwise

from shapely.geometry import LineString, Point
from shapely.geometry.base import BaseGeometry

from lamc.basics.errors import DesignError, UnsupportedError
from lamc.design import shapes
from lamc.design.shapes import Points
from lamc.design.work import Account
from lamc.readers.inert import ListNode, MapNode, Node, ScalarNode
from lamc.readers.objects import MM, attribute, flag, items, number, optional
from lamc.records.design import HingeLine, Line

_LINES = ("GenericLine", "GenericPolyline")
_UM = 1000.0 * MM  # µm per m
_OLD_TAGS = ("!ShapeVertex", "!DrawnPoint", "!ReferenceVertex")
_OLD_NAMES = ("_pos", "_BaseVertex__pos", "_Vertex__pos")


def sketch_shapes(sketch: Node) -> list[tuple[Node, BaseGeometry]]:
    """The drawn shapes of a sketch with their nodes, construction geometry and texts left out. Raises DesignError."""
    drawn = items(attribute(sketch, "operationgeometry", "the sketch"), "the sketch's geometry")
    return [(node, shape(node)) for node in drawn if not (is_text(node) or is_construction(node))]


def is_text(node: Node) -> bool:
    """True for engraved text. Its letters are in no file: popupCAD draws them again from a font of its machine."""
    return isinstance(node, MapNode) and kind_of(node) == "GenericText"


def texts_left_out(sketch: Node) -> tuple[str, ...]:
    """One line for each text of a sketch whose letters are missing from what `sketch_shapes` gives."""
    drawn = items(attribute(sketch, "operationgeometry", "the sketch"), "the sketch's geometry")
    said = [(node, optional(node, "text", "the text")) for node in drawn if is_text(node)]
    return tuple(
        f"{node.place}: left out the text {text.text[:40]!r}: the file has no outlines of its letters, only the name "
        "of a font; draw them as polygons where their material matters"
        for node, text in said
        if isinstance(text, ScalarNode) and text.text.strip()
    )


def hinge_lines(sketch: Node, account: Account) -> tuple[HingeLine, ...]:
    """The straight lines of a joint sketch, parted where they cross as popupCAD does, each drawn once.

    Raises DesignError for an area in the sketch, since a hinge is a line, and for more crossings than are computed.
    """
    runs: list[tuple[Node, Line]] = []
    for node, geometry in sketch_shapes(sketch):
        if isinstance(geometry, LineString):
            runs += [(node, run) for run in straight_runs([(x, y) for x, y in geometry.coords])]
        elif not isinstance(geometry, Point):
            raise node.error(f"a joint sketch holds a {kind_of(node)}; hinges are lines, so draw lines")
    try:
        account.overlay([LineString(run) for _, run in runs], "the hinge lines")
    except DesignError as error:
        raise sketch.error(error.message) from error
    found: list[HingeLine] = []
    seen: set[frozenset[tuple[float, float]]] = set()
    for index, line in shapes.cut_where_lines_cross([run for _, run in runs]) if runs else ():
        if frozenset(line) not in seen:
            seen.add(frozenset(line))
            found.append(HingeLine(line, None, runs[index][0].place))
    return tuple(found)


def shape(node: Node) -> BaseGeometry:
    """One shape in metres. Raises DesignError where it is malformed, UnsupportedError for an unknown kind."""
    kind = kind_of(node)
    try:
        if kind == "DrawnPoint":
            return Point(vertex(node))
        exterior = _points(node, "exterior")
        if kind == "GenericPoly":
            holes = optional(node, "interiors", kind)
            rings = items(holes, "the interiors") if holes is not None else ()
            return shapes.polygon(
                exterior, [[vertex(v) for v in items(ring, "an interior")] for ring in rings]
            )
        if kind in _LINES:
            if len(set(exterior)) < 2:
                raise DesignError(f"the {kind} has {len(set(exterior))} different points; a line needs two")
            return LineString(exterior)
        if kind in ("GenericTwoPointRect", "GenericCircle"):
            if len(exterior) != 2:
                raise DesignError(f"the {kind} has {len(exterior)} points; it is given by two")
            (x0, y0), (x1, y1) = exterior
            if kind == "GenericTwoPointRect":
                return shapes.rectangle(x0, y0, x1, y1)
            return shapes.circle(x0, y0, math.hypot(x1 - x0, y1 - y0))
    except DesignError as error:
        raise (node.error(error.message) if error.place is None else error) from error
    raise UnsupportedError(
        f"the sketch holds a shape of kind {kind[:60]!r}, which lamc cannot read", node.place
    )


def is_construction(node: Node) -> bool:
    """True for geometry that helps drawing and is no material."""
    if isinstance(node, ListNode):
        flags = node.items[3:4]
        return flag(flags[0], "the mark of a construction point", default=True) if flags else True
    return flag(
        optional(node, "construction", "the shape"), "the mark of construction geometry", default=False
    )


def kind_of(node: Node) -> str:
    """The shape's class; local tags carry a version (`!ShapeVertex_1`)."""
    return re.sub(r"_[0-9]+\Z", "", node.class_name)


def vertex(node: Node) -> tuple[float, float]:
    """A vertex, m: [id, x, y, …] or an object with a position, in the unit of its class. Raises DesignError."""
    unit = MM
    if isinstance(node, MapNode):
        position = optional(node, "_position", "the vertex")
        for name in () if position is not None else _OLD_NAMES:
            position = optional(node, name, "the vertex")
            unit = _UM
            if position is not None:
                break
        if position is None:
            raise node.error("the vertex has no '_position'; the file is damaged or of another kind")
        pair = items(position, "the vertex's position")
    else:
        unit = _UM if node.tag in _OLD_TAGS else MM
        pair = items(node, "a vertex")[1:3]
    if len(pair) != 2:
        raise node.error("a vertex needs an id, x and y")
    x, y = number(pair[0], "the vertex's x") / unit, number(pair[1], "the vertex's y") / unit
    shapes.check_coordinates([x, y], "the vertex")
    return x, y


def straight_runs(points: Points) -> list[Line]:
    """The straight stretches of a polyline; corners within 1e-9 rad of straight are no corners."""
    stops = [points[0]]
    for point in points[1:]:
        if point != stops[-1]:
            stops.append(point)
    runs: list[Line] = []
    for start, end in pairwise(stops):
        if runs and _goes_on(runs[-1], end):
            runs[-1] = (runs[-1][0], end)
        else:
            runs.append((start, end))
    return runs


def _goes_on(line: Line, end: tuple[float, float]) -> bool:
    (x0, y0), (x1, y1) = line
    ax, ay, bx, by = x1 - x0, y1 - y0, end[0] - x1, end[1] - y1
    return (
        abs(ax * by - ay * bx) <= 1e-9 * math.hypot(ax, ay) * math.hypot(bx, by) and ax * bx + ay * by > 0.0
    )


def _points(node: Node, name: str) -> list[tuple[float, float]]:
    return [vertex(v) for v in items(attribute(node, name, f"the {kind_of(node)}"), f"the {name}")]

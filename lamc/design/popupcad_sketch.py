"""popupCAD sketches and shapes: drawn geometry in metres.

In: nodes of sketches and of shapes (GenericPoly, GenericTwoPointRect, …), coordinates in mm. Out: shapely
geometry, and straight hinge lines. Construction geometry is left out; a malformed shape is an error.
"""

import math
import re
from itertools import pairwise

from shapely.geometry import LineString, Point
from shapely.geometry.base import BaseGeometry

from lamc.design import shapes
from lamc.design.inert import ListNode, MapNode, Node
from lamc.design.objects import MM, attribute, flag, items, number, optional
from lamc.design.records import HingeLine, Line
from lamc.design.shapes import Points
from lamc.errors import DesignError, UnsupportedError

_LINES = ("GenericLine", "GenericPolyline")


def sketch_shapes(sketch: Node) -> list[tuple[Node, BaseGeometry]]:
    """The drawn shapes of a sketch with their nodes, construction geometry left out. Raises DesignError."""
    drawn = items(attribute(sketch, "operationgeometry", "the sketch"), "the sketch's geometry")
    return [(node, shape(node)) for node in drawn if not is_construction(node)]


def hinge_lines(sketch: Node) -> tuple[HingeLine, ...]:
    """The straight lines of a joint sketch, parted where they cross as popupCAD does, each drawn once.

    Raises DesignError for an area in the sketch, since a hinge is a line.
    """
    runs: list[tuple[Node, Line]] = []
    for node, geometry in sketch_shapes(sketch):
        if isinstance(geometry, LineString):
            runs += [(node, run) for run in straight_runs([(x, y) for x, y in geometry.coords])]
        elif not isinstance(geometry, Point):
            raise node.error(f"a joint sketch holds a {kind_of(node)}; hinges are lines, so draw lines")
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
    """A vertex, m: [id, x, y, …] or an object with a position, mm. Raises DesignError."""
    if isinstance(node, MapNode):
        position = optional(node, "_pos", "the vertex") or attribute(node, "_Vertex__pos", "the vertex")
        pair = items(position, "the vertex's position")
    else:
        pair = items(node, "a vertex")[1:3]
    if len(pair) != 2:
        raise node.error("a vertex needs an id, x and y")
    x, y = number(pair[0], "the vertex's x") / MM, number(pair[1], "the vertex's y") / MM
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

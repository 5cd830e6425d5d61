"""Polygons from drawn shapes, checked.

In: coordinates in metres. Out: valid shapely polygons and straight hinge lines. A shape that crosses itself
or encloses nothing is a DesignError; nothing is repaired, since a repaired drawing is another drawing.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import shapely
from shapely.geometry import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.validation import explain_validity

from lamc.basics.errors import DesignError
from lamc.records.design import Line

Points = Sequence[tuple[float, float]]

_POLYGON = 3  # GEOS
CIRCLE_SEGMENTS = 128
FARTHEST = 1e6  # m; overlays of what lies beyond it lose digits, and nobody folds it


def polygon(exterior: Points, holes: Sequence[Points] = ()) -> Polygon:
    """The polygon, its rings as drawn.

    Raises DesignError for fewer than three different points, a coordinate that is not finite, an outline that
    crosses or touches itself, a hole outside, and a shape without area.
    """
    for ring in (exterior, *holes):
        _check_ring(ring)
    return _checked(Polygon(exterior, holes), "polygon")


def rectangle(x0: float, y0: float, x1: float, y1: float) -> Polygon:
    """The rectangle between two opposite corners, in any order. Raises DesignError where it has no area."""
    check_coordinates([x0, y0, x1, y1], "the rectangle")
    if x0 == x1 or y0 == y1:
        raise DesignError("the rectangle encloses no area; its corners must differ in x and in y")
    left, right, low, high = min(x0, x1), max(x0, x1), min(y0, y1), max(y0, y1)
    corners = [(left, low), (right, low), (right, high), (left, high), (left, low)]
    return _checked(shapely.polygons(corners), "rectangle")


def circle(x: float, y: float, radius: float, segments: int = CIRCLE_SEGMENTS) -> Polygon:
    """A regular polygon of 128 corners, or of `segments`, with the area of the circle, so that discs have their true
    mass.

    With 128 its corners lie 0.02 % of the radius outside the circle, the middles of its edges 0.01 % inside.
    Raises DesignError unless the radius is positive and all is finite.
    """
    check_coordinates([x, y, radius], "the circle")
    if not radius > 0.0:
        raise DesignError(f"the circle at ({x:g}, {y:g}) m has radius {radius:g} m; it must be above 0")
    angle = 2.0 * math.pi / segments
    corner = radius * math.sqrt(angle / math.sin(angle))
    angles = angle * np.arange(segments)
    points = np.column_stack([x + corner * np.cos(angles), y + corner * np.sin(angles)])
    return _checked(Polygon(points), "circle")


def line(start: tuple[float, float], end: tuple[float, float]) -> Line:
    """A hinge line. Raises DesignError where its ends coincide or are not finite."""
    check_coordinates([*start, *end], "the hinge line")
    if start == end:
        raise DesignError(
            f"the hinge line starts and ends at ({start[0]:g}, {start[1]:g}) m; it needs two different ends"
        )
    return (start, end)


def areas(geometry: BaseGeometry) -> MultiPolygon:
    """The two-dimensional parts of any geometry."""
    if isinstance(geometry, Polygon) and not geometry.is_empty:
        return shapely.multipolygons([geometry])
    parts = shapely.get_parts(shapely.get_parts(geometry))
    flat = (shapely.get_type_id(parts) == _POLYGON) & ~shapely.is_empty(parts)
    found: MultiPolygon = shapely.multipolygons(parts[flat])
    return found


def cut_where_lines_cross(lines: Sequence[Line]) -> tuple[tuple[int, Line], ...]:
    """The lines with every one cut where it crosses or touches another: (index of the line, piece), in order.

    A crossing of two creases parts each of them into two hinges, since four plates meet there.
    """
    drawn = shapely.linestrings([list(item) for item in lines])
    tree = shapely.STRtree(drawn)
    pieces: list[tuple[int, Line]] = []
    for index, (start, end) in enumerate(lines):
        near = [int(j) for j in sorted(tree.query(drawn[index], predicate="intersects")) if j != index]
        meets = shapely.intersection(drawn[index], drawn[near]) if near else []
        stops = _stops(start, end, [p for meet in meets for p in shapely.get_coordinates(meet)])
        pieces += [(index, (a, b)) for a, b in pairwise(stops)]
    return tuple(pieces)


def _stops(
    start: tuple[float, float], end: tuple[float, float], points: Sequence[np.ndarray]
) -> list[tuple[float, float]]:
    """The ends and the points well inside the line, in order from start to end."""
    length = math.dist(start, end)
    along = np.subtract(end, start) / length
    inside: list[tuple[float, tuple[float, float]]] = []
    for point in points:
        distance = float(np.dot(point - start, along))
        # A billionth of the line: a piece that short is round-off of lines that meet at an end.
        if 1e-9 * length < distance < (1.0 - 1e-9) * length:
            inside.append((distance, (float(point[0]), float(point[1]))))
    stops = [start]
    last = 0.0
    for distance, at in sorted(inside):
        if distance - last > 1e-9 * length:
            stops.append(at)
            last = distance
    return [*stops, end]


def _checked(shape: Polygon, what: str) -> Polygon:
    if not shape.is_valid:
        raise DesignError(f"the {what} is not simple: {_reason(shape)}; redraw it so that no edges cross")
    if not shape.area > 0.0:
        raise DesignError(f"the {what} encloses no area; its corners lie on one line, or are too close")
    return shape


def check_coordinates(values: npt.ArrayLike, what: str) -> None:
    """Raises DesignError where a coordinate, m, is not finite or farther away than any design."""
    array = np.asarray(values, dtype=np.float64)
    wrong = array[~(np.abs(array) <= FARTHEST)]
    if len(wrong):
        raise DesignError(
            f"{what} has a coordinate of {wrong[0]:g} m; it must be finite and within {FARTHEST:g} m"
        )


def _check_ring(ring: Points) -> None:
    if len(ring) == 0:
        raise DesignError("the polygon is empty; it needs at least three corners")
    array = np.asarray(ring, dtype=np.float64)
    check_coordinates(array, "the polygon")
    # Not np.unique, which imports numpy.ma when it is first called: a fifth of reading the first polygon's file.
    count = len(set(map(tuple, array.reshape(len(array), -1).tolist())))
    if count < 3:
        raise DesignError(f"the polygon has {count} different corners; it needs at least three")


def _reason(shape: Polygon) -> str:
    text = str(explain_validity(shape))
    kind, _, at = text.partition("[")
    where = at.rstrip("]").split()
    return f"{kind.lower()} at ({', '.join(where)}) m" if where else kind.lower()

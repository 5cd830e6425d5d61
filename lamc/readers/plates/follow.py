"""What the mesh of a plate file follows without being reported: the places of supports and of loads along edges.

In: places, and the lines that are meshed anyhow. Out: lines and points for the mesher, which meet these in corners.
Never: meshes.

A place that runs along what is there already, within round-off, gives only its ends: two lines that nearly coincide
would be meshed as a gap between them.
"""

from collections.abc import Sequence

import numpy as np
import shapely
import shapely.ops
from shapely.geometry import LineString, MultiPoint, Point
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.plates.supports import Where

_NEAR = 1e-7  # of the plate's size, a tenth of a Problem's tolerance: lines so near are one
MOST_STEPS = 200_000  # every place is cut at all that is there, some 20 µs for a corner
_ALONG = 10.0  # times that: what lies longer in the other's band runs along it, what lies shorter crosses it


def to_follow(
    wheres: Sequence[Where], outline: BaseGeometry, drawn: Sequence[BaseGeometry]
) -> list[BaseGeometry]:
    """Lines and points of `wheres` within `outline`: of areas their borders.

    drawn  lines, points and areas that the mesh follows besides, such as regions and hinge lines

    Raises DesignError where places times corners are too many.
    """
    parts = [
        part
        for where in wheres
        if not isinstance(where, str)
        for part in shapely.get_parts(shapely.get_parts(where))
    ]
    corners = int(shapely.get_num_coordinates([outline, *drawn, *parts]).sum())
    if len(parts) * corners > MOST_STEPS:
        raise DesignError(
            f"{len(parts)} places that hold the plate or load its edges, times {corners} corners of what is drawn, are "
            f"more than {MOST_STEPS} steps for the mesh to follow them: draw with fewer corners, join places, or take "
            "a grid"
        )
    x0, y0, x1, y1 = outline.bounds
    near = _NEAR * float(np.hypot(x1 - x0, y1 - y0))
    lines = [_as_line(place) for place in (outline, *drawn)]
    found: list[BaseGeometry] = []
    for part in parts:
        made = _new(_as_line(part), outline, lines, near)
        found += made
        lines += made
    return found


def _as_line(place: BaseGeometry) -> BaseGeometry:
    """The border of an area; lines and points as they are."""
    return place.boundary if shapely.get_dimensions(place) == 2 else place


def _new(
    place: BaseGeometry, outline: BaseGeometry, lines: Sequence[BaseGeometry], near: float
) -> list[BaseGeometry]:
    """What `place` adds to `lines`."""
    inside = shapely.intersection(place, shapely.buffer(outline, near))
    there = shapely.union_all(lines)
    corners = MultiPoint(np.unique(shapely.get_coordinates(lines), axis=0))
    band = shapely.buffer(there, near)
    made: list[BaseGeometry] = []
    ends: list[Array] = []
    for part in _chains(shapely.difference(inside, band)):
        points = shapely.get_coordinates(part)
        if len(points) > 1 and part.length > _ALONG * near:
            points[[0, -1]] = [_joined(point, there, corners, near) for point in points[[0, -1]]]
            made.append(LineString(points))
        elif len(points) == 1:
            made.append(part)
    for part in _chains(shapely.intersection(inside, band)):
        points = shapely.get_coordinates(part)
        if len(points) > 1 and part.length > _ALONG * near and not part.is_ring:
            ends += [points[0], points[-1]]
        elif len(points) == 1:
            ends.append(points[0])
    taken = shapely.get_coordinates([corners, *made])
    for end in ends:
        at = _joined(end, there, corners, near)
        if np.hypot(*(taken - at).T).min() > _ALONG * near:
            made.append(Point(at))
            taken = np.concatenate([taken, at[None]])
    return made


def _chains(place: BaseGeometry) -> list[BaseGeometry]:
    """Lines as long as they go on without a fork, and points."""
    parts = shapely.get_parts(place)
    lines = parts[shapely.get_dimensions(parts) == 1]
    return [
        *shapely.get_parts(shapely.line_merge(shapely.union_all(lines))),
        *parts[shapely.get_dimensions(parts) == 0],
    ]


def _joined(point: Array, there: BaseGeometry, corners: BaseGeometry, near: float) -> Array:
    """The corner at `point`, or else the place on `there` beside it; where nothing is near, the point itself."""
    here = Point(point)
    for other, reach in ((corners, 8.0 * near), (there, 2.0 * near)):
        if other.distance(here) <= reach:
            return np.asarray(shapely.get_coordinates(shapely.ops.nearest_points(other, here)[0])[0])
    return point

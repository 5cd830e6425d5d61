"""What the mesh of a plate file follows without being reported: the places of supports and of loads along edges.

In: places, and the lines that are meshed anyhow. Out: lines and points for the mesher, which meet these in corners.
Never: meshes.

A place that runs along what is there already, within round-off, gives only its ends: two lines that nearly coincide
would be meshed as a gap between them.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import LineString, Point
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.plates.supports import Where
from lamc.readers.plates.bands import Band

_NEAR = 1e-7  # of the plate's size, a tenth of a Problem's tolerance: lines so near are one
MOST_STEPS = 200_000  # every place is held against all that is there
MOST_PARTS = 5_000  # of places, cut where they meet: some 0.4 ms each
_ALONG = 10.0  # times that: what lies longer in the other's band runs along it, what lies shorter crosses it


def to_follow(
    wheres: Sequence[Where], outline: BaseGeometry, drawn: Sequence[BaseGeometry]
) -> list[BaseGeometry]:
    """Lines and points of `wheres` within `outline`: of areas their borders.

    drawn  lines, points and areas that the mesh follows besides, such as regions and hinge lines

    Raises DesignError where places times corners are too many, or parts into which they are cut.
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
    plate = shapely.buffer(outline, near)
    there = np.concatenate([_segments(_as_line(place)) for place in (outline, *drawn)])
    found: list[BaseGeometry] = []
    for part in parts:
        inside = shapely.intersection(_as_line(part), plate)
        made = [] if inside.is_empty else _new(inside, there, near)
        found += made
        _check_count(len(found))
        there = np.concatenate([there, *map(_segments, made)])
    return found


def _as_line(place: BaseGeometry) -> BaseGeometry:
    """The border of an area; lines and points as they are."""
    return place.boundary if shapely.get_dimensions(place) == 2 else place


def _segments(place: BaseGeometry) -> Array:
    """Ends of its segments, (k, 2, 2), m; of a point twice the same."""
    lines = [shapely.get_coordinates(part) for part in shapely.get_parts(shapely.get_parts(place))]
    pairs = [np.stack([line[:-1], line[1:]] if len(line) > 1 else [line, line], axis=1) for line in lines]
    return np.concatenate([np.zeros((0, 2, 2)), *pairs])


def _check_count(parts: int) -> None:
    if parts > MOST_PARTS:
        raise DesignError(
            f"places that hold the plate or load its edges are cut into more than {MOST_PARTS} parts where they meet "
            "each other and what is drawn: let fewer of them cross, or take a grid"
        )


def _new(place: BaseGeometry, there: Array, near: float) -> list[BaseGeometry]:
    """What `place`, which is on the plate, adds to the segments `there` (k, 2, 2)."""
    reach = 2.0 * _ALONG * near
    x0, y0, x1, y1 = place.bounds
    beside = (there.min(axis=1) <= (x1 + reach, y1 + reach)) & (there.max(axis=1) >= (x0 - reach, y0 - reach))
    band = Band(there[beside.all(axis=1)], near)
    corners = np.unique(band.segments.reshape(-1, 2), axis=0)
    apart, along = (_chains(parts) for parts in band.cut(shapely.get_parts(place)))
    _check_count(len(apart))
    made: list[BaseGeometry] = []
    for part in apart:
        line = shapely.get_coordinates(part)
        if len(line) == 1:
            made.append(part)
        elif part.length > _ALONG * near:
            line[[0, -1]] = [_joined(point, band, corners) for point in line[[0, -1]]]
            made.append(LineString(line))
    ends: list[Array] = []
    for part in along:
        line = shapely.get_coordinates(part)
        if len(line) == 1 or (part.length > _ALONG * near and not part.is_closed):
            ends += [line[0], line[-1]]
    taken = np.concatenate([corners, shapely.get_coordinates(made)])
    for end in ends:
        at = _joined(end, band, corners)
        if np.hypot(*(taken - at).T).min(initial=np.inf) > _ALONG * near:
            made.append(Point(at))
            taken = np.concatenate([taken, at[None]])
    return made


def _chains(parts: Sequence[BaseGeometry]) -> list[BaseGeometry]:
    """Lines as long as they go on without a fork, and points."""
    lines = [part for part in parts if shapely.get_dimensions(part) == 1]
    points = [part for part in parts if shapely.get_dimensions(part) == 0]
    return [*shapely.get_parts(shapely.line_merge(shapely.union_all(lines))), *points]


def _joined(point: Array, band: Band, corners: Array) -> Array:
    """The corner at `point`, or else the place on the segments beside it; where nothing is near, the point itself."""
    far = np.hypot(*(corners - point).T)
    if far.min(initial=np.inf) <= 8.0 * band.near:
        return np.asarray(corners[np.argmin(far)])
    place, away = band.nearest(point)
    return place if away <= 2.0 * band.near else point

"""Which parts of a mesh's edges a line covers, so that what acts along a line may begin and end within an edge.

In: places and a shapely geometry. Out: edges, and from where to where on each. Never: loads, supports.
"""

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.plates.locator import MeshLocator
from lamc.plates.meshing.mesh import Integers
from lamc.plates.supports import Where, where_text

_FEW = 40  # segments of a line


@dataclass(frozen=True, eq=False)
class EdgeParts:
    """Parts of edges, none twice.

    edges  (k, 2): cell and local edge
    ends   (k, 2): where the part begins and ends, 0 at the edge's first corner and 1 at the next
    """

    edges: Integers
    ends: Array


def edge_parts_on(places: MeshLocator, where: Where, what: str) -> EdgeParts:
    """Of the edges on `where`: what lines cover of each; for areas and "boundary", whole edges of the plate's boundary.

    Raises DesignError, naming `what`, if there is none, and for a line that leaves the edges within the plate.
    """
    if isinstance(where, str) or shapely.get_dimensions(where) != 1:
        edges = places.checked_edges_on(where, what)
        mesh = places.dofs.mesh
        outer = places.on_boundary[mesh.cell_edges[edges[:, 0], edges[:, 1]]]
        if not outer.any():
            raise DesignError(
                f"{what} at {where_text(where)} is an area without an edge of the plate's boundary in it, and inner "
                "edges are the mesh's own: give a line"
            )
        edges = edges[outer]
        return EdgeParts(edges, np.tile([0.0, 1.0], (len(edges), 1)))
    segments = _segments(where)
    near = _near(places, segments)
    cells, local = places.edges[near].T
    cell_points = places.dofs.mesh.cells
    after = (local + 1) % cell_points.shape[1]
    sides = places.dofs.mesh.points[np.stack([cell_points[cells, local], cell_points[cells, after]], axis=1)]
    tree = shapely.STRtree(shapely.linestrings(sides))
    segment, edge = tree.query(shapely.linestrings(segments), predicate="dwithin", distance=places.tolerance)
    low, high = _overlap(sides[edge], segments[segment])
    on = high > low
    for t in (low, high):
        there = shapely.points(sides[edge, 0] + t[:, None] * (sides[edge, 1] - sides[edge, 0]))
        on &= shapely.distance(there, shapely.linestrings(segments[segment])) <= places.tolerance
    segment, edge = segment[on], edge[on]
    length = np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1)
    covered, ends = _union(edge, low[on], high[on], places.tolerance / length)
    if not len(covered):
        places.checked_edges_on(where, what)  # raises, as the middle of an edge is on no part
        raise DesignError(
            f"{what} at {where_text(where)} is shorter than the tolerance, {places.tolerance:.3g} m"
        )
    _check_whole(places, where, what, segments, segment, sides[edge])
    slack = (places.tolerance / length[covered])[:, None]
    ends = np.where(
        ends < slack, 0.0, np.where(ends > 1.0 - slack, 1.0, ends)
    )  # whole edges are exactly whole
    return EdgeParts(places.edges[near[covered]], ends)


def _segments(where: BaseGeometry) -> Array:
    """Of all lines, shape (k, 2, 2): begin and end."""
    coordinates, line = shapely.get_coordinates(
        shapely.get_parts(shapely.get_parts(where)), return_index=True
    )
    follows = np.flatnonzero((line[1:] == line[:-1]) & (coordinates[1:] != coordinates[:-1]).any(axis=1))
    return np.stack([coordinates[follows], coordinates[follows + 1]], axis=1)


def _near(places: MeshLocator, segments: Array) -> NDArray[np.intp]:
    """Edges whose bounding box touches that of a segment, or, of many segments, that of all."""
    least, most = places.edge_boxes
    boxes = segments if len(segments) <= _FEW else segments.reshape(1, -1, 2)
    touched = np.zeros(least.shape[1], dtype=bool)
    for box in boxes:
        low, high = box.min(axis=0) - places.tolerance, box.max(axis=0) + places.tolerance
        across, up = (most >= low[:, None]) & (least <= high[:, None])
        touched |= across & up
    return np.flatnonzero(touched)


def _overlap(sides: Array, segments: Array) -> tuple[Array, Array]:
    """Where the projections of `segments` (k, 2, 2) on the lines of `sides` begin and end, from 0 to 1 on the side."""
    along = sides[:, 1] - sides[:, 0]
    t = np.einsum("kpi,ki->kp", segments - sides[:, :1], along) / np.sum(along**2, axis=1)[:, None]
    return np.clip(t.min(axis=1), 0.0, 1.0), np.clip(t.max(axis=1), 0.0, 1.0)


def _union(
    group: NDArray[np.integer], low: Array, high: Array, tolerance: Array
) -> tuple[NDArray[np.int64], Array]:
    """Intervals of each group joined where they meet within `tolerance` (groups,); shorter ones are left out."""
    found: list[tuple[int, float, float]] = []
    for k in np.lexsort((high, low, group)).tolist():
        g, a, b = int(group[k]), float(low[k]), float(high[k])
        if found and found[-1][0] == g and a <= found[-1][2] + tolerance[g]:
            found[-1] = (g, found[-1][1], max(found[-1][2], b))
        else:
            found.append((g, a, b))
    kept = [item for item in found if item[2] - item[1] > tolerance[item[0]]]
    return np.array([item[0] for item in kept], dtype=np.int64), np.array(
        [item[1:] for item in kept]
    ).reshape(-1, 2)


def _check_whole(
    places: MeshLocator, where: Where, what: str, segments: Array, segment: NDArray[np.integer], sides: Array
) -> None:
    """Raises DesignError where a part of the line lies in the plate and on none of its edges."""
    length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    every, zero = np.arange(len(segments)), np.zeros(len(segments))
    low, high = _overlap(segments[segment], sides)
    group = np.concatenate([segment, every, every])  # the ends of each segment close what is left open
    low, high = np.concatenate([low, zero, zero + 1.0]), np.concatenate([high, zero, zero + 1.0])
    order = np.lexsort((high, low, group))
    group, low, high = group[order], low[order], high[order]
    reached = np.maximum.accumulate(high + 2.0 * group) - 2.0 * group  # of all before, on the same segment
    slack = 2.0 * places.tolerance / length[group[1:]]
    gap = np.flatnonzero((group[1:] == group[:-1]) & (low[1:] - reached[:-1] > slack))
    middle = 0.5 * (low[1:] + reached[:-1])[gap]
    a, b = segments[group[gap]].swapaxes(0, 1)
    points = a + middle[:, None] * (b - a)
    inside = points[places.dofs.mesh.locate(points)[0] >= 0]
    if len(inside):
        x, y = inside[0]
        raise DesignError(
            f"{what} at {where_text(where)} leaves the edges of the mesh at ({x:.6g}, {y:.6g}), inside the plate; what "
            "acts along a line must run along edges: mesh along it, as by a region that it bounds"
        )

"""Facets of a healed drawing: rings of vertices, with what lies amid a facet linked to its rim.

In: a planar graph of edges that part something. Out: more edges, which join facets, and faces counterclockwise.
A facet has no hole in the records of a sheet: two level links from each island to what is left and right of it part
the facet about it in two, which are one body.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely
from shapely import STRtree

from lamc.basics.errors import DesignError
from lamc.readers.drawings.outlines import islands_of, nesting
from lamc.readers.fold_faces import NEAR, Edge, Face, area_of, rings_of
from lamc.records.mechanism import Array


def linked(points: Array, edges: Sequence[Edge]) -> tuple[Array, list[Edge], list[int | None]]:
    """points, edges and for each edge the one that it is of: None for a link. Edges that links meet are parted."""
    islands = islands_of(points, edges)
    inner = [island for island, depth in zip(islands, nesting(islands), strict=True) if depth]
    if not inner:
        return points, list(edges), list(range(len(edges)))
    ends = np.array(edges)
    tree = STRtree(shapely.linestrings(points[ends]))
    within = NEAR * float(np.ptp(points, axis=0).max())
    places = [*points]
    cuts: dict[int, dict[int, None]] = {}
    links: dict[Edge, None] = {}
    met: dict[tuple[int, float], int] = {}
    for island in inner:
        own = np.unique(np.array(island.edges))
        order = own[np.lexsort((points[own, 1], points[own, 0]))]
        for start, sign in ((int(order[0]), -1.0), (int(order[-1]), 1.0)):
            hit = _beyond(points, ends, tree, start, sign)
            if hit is None:  # it touches what it lies in where that ends
                continue
            edge, x = hit
            y = float(points[start, 1])
            near = [int(v) for v in ends[edge] if np.hypot(*(points[v] - (x, y))) <= within]
            if not near and (edge, y) not in met:
                met[(edge, y)] = len(places)
                places.append(np.array([x, y]))
                cuts.setdefault(edge, {})[met[(edge, y)]] = None
            end = near[0] if near else met[(edge, y)]
            links[(min(start, end), max(start, end))] = None
    found, origin = _parted(np.array(places), edges, cuts)
    known = set(found)
    new = [link for link in links if link not in known]
    return np.array(places), [*found, *new], [*origin, *([None] * len(new))]


def faces_within(points: Array, edges: Sequence[Edge], region: shapely.MultiPolygon) -> list[Face]:
    """Bounded faces with a point inside the region. Raises DesignError for one that meets itself at a vertex."""
    rings = [ring for ring in rings_of(points, edges) if area_of(points, ring) > 0.0]
    shapely.prepare(region)
    inside = shapely.contains(
        region, shapely.point_on_surface([shapely.Polygon(points[list(r)]) for r in rings])
    )
    found = [ring for ring, kept in zip(rings, inside, strict=True) if kept]
    pinched = next((ring for ring in found if len(set(ring)) < len(ring)), None)
    if pinched is not None:
        vertex = next(v for v in pinched if pinched.count(v) > 1)
        raise DesignError(
            f"a facet meets itself at ({1e3 * points[vertex, 0]:.6g}, {1e3 * points[vertex, 1]:.6g}) mm, where "
            "outlines or cuts touch at a point; draw them apart, or overlapping"
        )
    return found


def _beyond(points: Array, ends: Array, tree: STRtree, start: int, sign: float) -> tuple[int, float] | None:
    """The first edge to the left (-1) or right of a vertex, none of its own, and where, x; None for none."""
    place = points[start]
    width = float(np.ptp(points[:, 0]))
    reach = width / math.sqrt(len(ends))
    while True:
        near = np.sort(tree.query(shapely.LineString([place, (place[0] + sign * reach, place[1])])))
        near = near[(ends[near] != start).all(axis=1)]
        x = _level_at(points[ends[near, 0]], points[ends[near, 1]], place[1], sign)
        far = sign * (x - place[0])
        ahead = np.flatnonzero((far > 0.0) & (far <= reach))
        if len(ahead):
            chosen = ahead[np.argmin(far[ahead])]
            return int(near[chosen]), float(x[chosen])
        if reach > width:
            return None
        reach *= 4.0


def _level_at(p: Array, q: Array, y: float, sign: float) -> Array:
    """x where lines from p to q, (n, 2), are at y: the first place of a level one; nan for those that are not."""
    rise = q[:, 1] - p[:, 1]
    level = rise == 0.0
    share = (y - p[:, 1]) / np.where(level, 1.0, rise)
    nearest = np.minimum if sign > 0.0 else np.maximum
    x = np.where(level, nearest(p[:, 0], q[:, 0]), p[:, 0] + share * (q[:, 0] - p[:, 0]))
    reached = (np.minimum(p[:, 1], q[:, 1]) <= y) & (y <= np.maximum(p[:, 1], q[:, 1]))
    return np.where(reached, x, np.nan)


def _parted(
    places: Array, edges: Sequence[Edge], cuts: dict[int, dict[int, None]]
) -> tuple[list[Edge], list[int | None]]:
    found: list[Edge] = []
    origin: list[int | None] = []
    for k, (a, b) in enumerate(edges):
        along = places[b] - places[a]
        inner = sorted(cuts.get(k, ()), key=lambda v: float((places[v] - places[a]) @ along))
        stops = [a, *inner, b]
        for pair in pairwise(stops):
            found.append((min(pair), max(pair)))
            origin.append(k)
    return found, origin

"""Outlines in a planar graph: which edges part something, what hangs together, what it encloses.

In: a planar graph, and which of its edges are outlines. Out: regions. Never: closes what is open.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import STRtree
from shapely.geometry.base import BaseGeometry

from lamc.readers.fold_faces import Edge, rings_of
from lamc.records.mechanism import Array


@dataclass(frozen=True)
class Island:
    """Edges of which no vertex holds two parts together, and all that they enclose."""

    edges: tuple[Edge, ...]
    hull: BaseGeometry


def parting(points: Array, edges: Sequence[Edge]) -> list[int]:
    """Edges with different faces on their two sides: all but those that dangle or link two rings."""
    ring: dict[Edge, int] = {}
    for k, face in enumerate(rings_of(points, edges)):
        for side in zip(face, (*face[1:], face[0]), strict=True):
            ring[side] = k
    return [k for k, (a, b) in enumerate(edges) if ring[(a, b)] != ring[(b, a)]]


def islands_of(points: Array, edges: Sequence[Edge]) -> list[Island]:
    """Of edges that part something, in the order of their lowest edges. Outlines that touch at a point are two."""
    blocks = [tuple(edges[k] for k in block) for block in sorted(_blocks(edges))]
    return [Island(block, _hull(points, block)) for block in blocks]


def nesting(islands: Sequence[Island]) -> list[int]:
    """How many other islands each lies within."""
    if not islands:
        return []
    shapes = np.array([each.hull for each in islands], dtype=object)
    shapely.prepare(shapes)
    inner, outer = STRtree(shapes).query(shapely.point_on_surface(shapes), predicate="within")
    # The point of a larger island may lie in a smaller one that is amid it.
    sizes = shapely.area(shapes)
    depths = np.bincount(inner[sizes[outer] > sizes[inner]], minlength=len(islands))
    return [int(depth) for depth in depths]


def hull(points: Array, edges: Sequence[Edge]) -> BaseGeometry:
    """All that edges enclose, holes too."""
    kept = [edges[k] for k in parting(points, edges)]
    return shapely.union_all([island.hull for island in islands_of(points, kept)])


def _hull(points: Array, edges: Sequence[Edge]) -> BaseGeometry:
    lines = shapely.linestrings(points[np.array(edges)])
    faces = shapely.get_parts(shapely.polygonize(lines))
    return shapely.union_all(shapely.polygons(shapely.get_exterior_ring(faces)))


def _blocks(edges: Sequence[Edge]) -> list[list[int]]:
    """Edges by number, ascending, in parts that hold together without any one vertex.

    J. Hopcroft, R. Tarjan, Algorithm 447: efficient algorithms for graph manipulation, 1973.
    """
    around: dict[int, list[tuple[int, int]]] = {}
    for k, (a, b) in enumerate(edges):
        around.setdefault(a, []).append((b, k))
        around.setdefault(b, []).append((a, k))
    found: list[list[int]] = []
    depth: dict[int, int] = {}
    low: dict[int, int] = {}
    waiting: list[int] = []
    for root in sorted(around):
        if root in depth:
            continue
        depth[root] = low[root] = 0
        path = [(root, -1, iter(around[root]), 0)]
        while path:
            vertex, via, others, start = path[-1]
            for other, k in others:
                if other not in depth:
                    depth[other] = low[other] = len(path)
                    path.append((other, k, iter(around[other]), len(waiting)))
                    waiting.append(k)
                    break
                if k != via and depth[other] < depth[vertex]:
                    waiting.append(k)
                    low[vertex] = min(low[vertex], depth[other])
            else:
                path.pop()
                if path:
                    above = path[-1][0]
                    low[above] = min(low[above], low[vertex])
                    if low[vertex] >= depth[above]:
                        found.append(sorted(waiting[start:]))
                        del waiting[start:]
    return found

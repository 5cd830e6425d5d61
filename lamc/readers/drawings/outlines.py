"""Material from outlines: what closed lines enclose, by turns where they lie within one another.

In: a planar graph, and which of its edges are outlines. Out: regions. Never: closes what is open.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import STRtree
from shapely.geometry import MultiPolygon
from shapely.geometry.base import BaseGeometry

from lamc.design.shapes import areas
from lamc.readers.fold_faces import Edge, rings_of
from lamc.readers.fold_groups import pieces_of
from lamc.records.mechanism import Array


@dataclass(frozen=True)
class Island:
    """Edges that hang together, none of them a bridge, and all that they enclose."""

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
    """Of edges that part something, in the order of their lowest vertices."""
    if not edges:
        return []
    pieces = pieces_of({v for edge in edges for v in edge}, edges)
    number = {v: k for k, piece in enumerate(pieces) for v in piece}
    found: list[list[Edge]] = [[] for _ in pieces]
    for edge in edges:
        found[number[edge[0]]].append(edge)
    return [Island(tuple(each), _hull(points, each)) for each in found]


def nesting(points: Array, islands: Sequence[Island]) -> list[int]:
    """How many other islands each lies within."""
    shapes = np.array([each.hull for each in islands], dtype=object)
    shapely.prepare(shapes)
    dots = shapely.points(np.array([points[each.edges[0][0]] for each in islands]))
    inner, outer = STRtree(shapes).query(dots, predicate="within")
    counts: list[int] = np.bincount(inner[inner != outer], minlength=len(islands)).tolist()
    return counts


def material(points: Array, edges: Sequence[Edge], holes: frozenset[Edge] = frozenset()) -> MultiPolygon:
    """What outlines enclose, and those within them leave out, by turns.

    holes  edges that bound what is taken away, whatever lies about them
    """
    kept = [edges[k] for k in parting(points, edges)]
    islands = [i for i in islands_of(points, kept) if not set(i.edges) <= holes]
    cut = [i for i in islands_of(points, kept) if set(i.edges) <= holes]
    depths = nesting(points, islands + cut) if islands or cut else []
    found: BaseGeometry = MultiPolygon()
    for depth in range(max(depths, default=-1) + 1):
        level = [i for i, d in zip(islands + cut, depths, strict=True) if d == depth]
        filled = [_without(points, i, holes) for i in level if not set(i.edges) <= holes and depth % 2 == 0]
        emptied = [i.hull for i in level if set(i.edges) <= holes or depth % 2]
        found = shapely.difference(shapely.union_all([found, *filled]), shapely.union_all(emptied))
    return areas(found)


def hull(points: Array, edges: Sequence[Edge]) -> BaseGeometry:
    """All that edges enclose, holes too."""
    kept = [edges[k] for k in parting(points, edges)]
    return shapely.union_all([island.hull for island in islands_of(points, kept)])


def _hull(points: Array, edges: Sequence[Edge]) -> BaseGeometry:
    lines = shapely.linestrings(points[np.array(edges)])
    faces = shapely.get_parts(shapely.polygonize(lines))
    return shapely.union_all(shapely.polygons(shapely.get_exterior_ring(faces)))


def _without(points: Array, island: Island, holes: frozenset[Edge]) -> BaseGeometry:
    """The island's hull without those holes that touch its other outlines."""
    own = [edge for edge in island.edges if edge in holes]
    ring = [own[k] for k in parting(points, own)] if own else []
    return shapely.difference(island.hull, _hull(points, ring)) if ring else island.hull

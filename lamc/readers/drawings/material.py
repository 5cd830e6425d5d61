"""Material from the outlines of a drawing: what they enclose, and those within them leave out, by turns.

In: a planar graph, the strokes that its edges are of. Out: the region of material, and lines within it that part
nothing. Never: closes what is open.

Which strokes are outlines, `rings` tells; what other strokes enclose, such as lines that end on lines, is material in
all its parts. An outline is the faces of the graph that lie within it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import shapely
from shapely import STRtree
from shapely.geometry import MultiPolygon
from shapely.geometry.base import BaseGeometry

from lamc.design.shapes import areas
from lamc.readers.drawings.heal import Graph
from lamc.readers.drawings.outlines import islands_of, parting
from lamc.readers.drawings.rings import Outline, rings_of
from lamc.readers.fold_faces import NEAR, Edge
from lamc.readers.fold_groups import pieces_of
from lamc.records.drawing import Role, Stroke
from lamc.records.mechanism import Array

_Faces = npt.NDArray[np.int64]  # numbers of faces, ascending


@dataclass(frozen=True, eq=False)
class Material:
    """region  where material is, m
    within  edges of the graph, by number, of strokes that are no outlines, with material on both sides
    """

    region: MultiPolygon
    within: tuple[int, ...]


def material_of(
    graph: Graph, strokes: Sequence[Stroke], kept: Sequence[int], roles: frozenset[Role]
) -> Material:
    """What outlines enclose that strokes of those roles draw; holes are taken away, whatever lies about them.

    kept  edges of the graph, by number, that part something
    """
    drawn = [k for k in kept if strokes[graph.strokes[k]].role in roles]
    drawn = [drawn[k] for k in parting(graph.points, [graph.edges[k] for k in drawn])]
    if not drawn:
        return Material(MultiPolygon(), ())
    edges = [graph.edges[k] for k in drawn]
    lines = shapely.linestrings(graph.points[np.array(edges)])
    faces = shapely.get_parts(shapely.polygonize(lines))
    rings, others = rings_of(graph, strokes, roles)
    owners = [graph.strokes[k] for k in drawn]
    holes = {edge for edge, k in zip(edges, owners, strict=True) if strokes[k].role == "hole"}
    loose = {edge for edge, k in zip(edges, owners, strict=True) if k in others}
    full = _full(faces, [*rings, *_patches(graph.points, edges, holes, loose)])
    region = areas(shapely.union_all(faces[full]))
    shapely.prepare(region)
    own = [j for j, k in enumerate(owners) if k in others]
    middles = shapely.line_interpolate_point(lines[own], 0.5, normalized=True)
    beyond = NEAR * float(np.ptp(graph.points, axis=0).max())  # the rim is as exact as its corners
    amid = shapely.contains_properly(region, middles)
    amid &= shapely.distance(shapely.boundary(region), middles) > beyond
    return Material(region, tuple(drawn[own[j]] for j in np.flatnonzero(amid)))


def _patches(points: Array, edges: Sequence[Edge], holes: set[Edge], loose: set[Edge]) -> list[Outline]:
    """What strokes that are no rings enclose, with all that holds together with them."""
    if not loose:
        return []
    found = [
        Outline(island.hull, set(island.edges) <= holes, True)
        for island in islands_of(points, edges)
        if not loose.isdisjoint(island.edges)
    ]
    own = sorted(holes & loose)
    rings = [own[k] for k in parting(points, own)] if own else []
    return [*found, *(Outline(island.hull, True) for island in islands_of(points, rings))]


def _full(faces: npt.NDArray[np.object_], outlines: Sequence[Outline]) -> npt.NDArray[np.bool_]:
    """Which faces are material."""
    places = STRtree(shapely.point_on_surface(faces))
    shapes = np.array([outline.shape for outline in outlines], dtype=object)
    shapely.prepare(shapes)
    which, inside = places.query(shapes, predicate="contains")
    enclosed = _grouped(which, inside, len(outlines))
    solid = [k for k, outline in enumerate(outlines) if not outline.is_hole and len(enclosed[k])]
    solid = _without_patches(solid, outlines, enclosed, faces)
    holes = [k for k, outline in enumerate(outlines) if outline.is_hole and len(enclosed[k])]
    nest = _Nest(_united(solid, shapes, enclosed, _cross), len(faces))
    return nest.full(_united(holes, shapes, enclosed, lambda a, b: True))


def _grouped(which: _Faces, values: _Faces, count: int) -> list[_Faces]:
    """Values (n,) by which of `count` groups they are of, ascending in each."""
    order = np.lexsort((values, which))
    return np.split(values[order], np.searchsorted(which[order], np.arange(1, count)))


def _cross(first: _Faces, second: _Faces) -> bool:
    """Whether two outlines have faces in common, and each has some of its own."""
    common = len(np.intersect1d(first, second, assume_unique=True))
    return 0 < common < min(len(first), len(second))


def _united(
    chosen: Sequence[int],
    shapes: npt.NDArray[np.object_],
    enclosed: Sequence[_Faces],
    are_one: Callable[[_Faces, _Faces], bool],
) -> list[_Faces]:
    """Faces of some outlines; of those that meet and `are_one`, together."""
    if not chosen:
        return []
    own = [enclosed[k] for k in chosen]
    rims = shapely.boundary(shapes[list(chosen)])
    meeting = STRtree(rims).query(rims, predicate="intersects").T.tolist()
    pairs = [(a, b) for a, b in meeting if a < b and are_one(own[a], own[b])]
    return [np.unique(np.concatenate([own[k] for k in each])) for each in pieces_of(range(len(own)), pairs)]


def _without_patches(
    solid: list[int],
    outlines: Sequence[Outline],
    enclosed: Sequence[_Faces],
    faces: npt.NDArray[np.object_],
) -> list[int]:
    """Less what other strokes enclose where rings enclose it as well; and where they enclose something beside rings, as
    where two tiles share a side, less those rings, which are of it. Within another outline the rings stay, and lines
    that lead from one to another are lines across."""
    within = {k: set(enclosed[k].tolist()) for k in solid}
    rings = [k for k in solid if not outlines[k].is_patched]
    gone: set[int] = set()
    for patch in (k for k in solid if outlines[k].is_patched):
        own = [k for k in rings if within[patch] >= within[k]]
        if within[patch] <= set[int]().union(*(within[k] for k in own)):
            gone.add(patch)
            continue
        rim = shapely.boundary(outlines[patch].shape)
        tiles = [k for k in own if _shares(faces[enclosed[k]], rim)]
        is_inner = any(within[patch] < within[k] for k in rings)
        gone |= {patch} if tiles and is_inner else set(tiles)
    return [k for k in solid if k not in gone]


def _shares(faces: npt.NDArray[np.object_], rim: BaseGeometry) -> bool:
    """Whether the faces reach a rim along a line."""
    around = shapely.boundary(shapely.union_all(faces))
    return bool(shapely.length(shapely.intersection(around, rim)) > 0.0)


class _Nest:
    """Outlines within one another, by the faces that they enclose; none crosses another.

    outlines  the largest first
    label     the smallest outline about each face; -1: none
    parent    the smallest outline about each outline; -1: none
    """

    def __init__(self, outlines: Sequence[_Faces], count: int) -> None:
        once = {faces.tobytes(): faces for faces in outlines}
        self.outlines = sorted(once.values(), key=lambda faces: (-len(faces), faces.tolist()))
        self.label, self.parent = np.full(count, -1), list[int]()
        for k, faces in enumerate(self.outlines):
            self.parent.append(int(self.label[faces[0]]))
            self.label[faces] = k

    def full(self, holes: Sequence[_Faces]) -> npt.NDArray[np.bool_]:
        """Faces whose smallest outline begins amid nothing, and that are in no hole within it."""
        empty = np.zeros(len(self.label), dtype=bool)
        begun_anew = np.zeros(len(self.outlines), dtype=bool)  # in a hole that their parent is not in
        for faces in holes:
            within = self._within(faces)
            begun_anew[[k for k in within if self.parent[k] not in within]] = True
            empty[faces[~np.isin(self.label[faces], list(within))]] = True
        solid: list[bool] = []
        for parent, anew in zip(self.parent, begun_anew.tolist(), strict=True):
            solid.append(anew or parent < 0 or not solid[parent])
        begins = np.array([*solid, False])  # the last: within no outline
        return np.asarray((self.label >= 0) & ~empty & begins[self.label])

    def _within(self, hole: _Faces) -> set[int]:
        """Outlines that lie within a hole, and are smaller."""
        own = self.label[hole]
        count: dict[int, int] = {}
        for k, times in zip(*np.unique(own[own >= 0], return_counts=True), strict=True):
            count[int(k)] = int(times)
        for k in list(count):
            while (k := self.parent[k]) >= 0 and k not in count:
                count[k] = 0
        for k in sorted(count, reverse=True):
            if self.parent[k] >= 0:
                count[self.parent[k]] += count[k]
        return {k for k, times in count.items() if times == len(self.outlines[k]) < len(hole)}

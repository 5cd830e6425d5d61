"""Material from the outlines of a drawing: what they enclose, and those within them leave out, by turns.

In: a planar graph, the strokes that its edges are of. Out: the region of material, and lines within it that part
nothing. Never: closes what is open.

An outline is a closed stroke, or strokes that join end to end to a ring, wherever it touches others. What other strokes
enclose, such as lines that end on lines, is material in all its parts.
"""

from collections.abc import Iterator, Sequence
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
from lamc.readers.fold_faces import Edge
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


@dataclass(frozen=True, eq=False)
class _Outline:
    """What an outline encloses; is_patched: strokes that are no ring do."""

    shape: BaseGeometry
    is_hole: bool
    is_patched: bool = False


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
    rings, others = _rings(graph, strokes, roles)
    owners = [graph.strokes[k] for k in drawn]
    holes = {edge for edge, k in zip(edges, owners, strict=True) if strokes[k].role == "hole"}
    loose = {edge for edge, k in zip(edges, owners, strict=True) if k in others}
    full = _full(faces, [*rings, *_patches(graph.points, edges, holes, loose)])
    region = areas(shapely.union_all(faces[full]))
    shapely.prepare(region)
    own = [j for j, k in enumerate(owners) if k in others]
    middles = shapely.line_interpolate_point(lines[own], 0.5, normalized=True)
    amid = np.flatnonzero(shapely.contains_properly(region, middles)).tolist()
    return Material(region, tuple(drawn[own[j]] for j in amid))


def _rings(
    graph: Graph, strokes: Sequence[Stroke], roles: frozenset[Role]
) -> tuple[list[_Outline], set[int]]:
    """Closed strokes and rings of open ones, and the numbers of all other strokes of those roles."""
    chosen = [k for k, stroke in enumerate(strokes) if stroke.role in roles]
    found: list[_Outline] = []
    others: set[int] = set()
    open_ones: dict[Role, list[int]] = {}
    for k in chosen:
        stroke = strokes[k]
        shape = shapely.Polygon(stroke.points) if stroke.closed and len(stroke.points) > 2 else None
        if shape is not None and shape.is_valid and shape.area > 0.0:
            found.append(_Outline(shape, stroke.role == "hole"))
        elif stroke.closed:
            others.add(k)
        else:
            open_ones.setdefault(stroke.role, []).append(k)
    vertices = STRtree(shapely.points(graph.points))
    for role, numbers in open_ones.items():
        ends = vertices.nearest(shapely.points([strokes[k].points[e] for k in numbers for e in (0, -1)]))
        pairs = dict(zip(numbers, ends.reshape(-1, 2).tolist(), strict=True))
        for chain in _chains(pairs):
            shape = shapely.Polygon(_joined(chain, pairs, strokes)) if _is_ring(chain, pairs) else None
            if shape is not None and shape.is_valid and shape.area > 0.0:
                found.append(_Outline(shape, role == "hole"))
            else:
                others |= set(chain)
    return found, others


def _chains(pairs: dict[int, list[int]]) -> Iterator[list[int]]:
    """Strokes, by number, that hold together by their ends, in the order in which one leads to the next."""
    at: dict[int, list[int]] = {}
    for k, ends in pairs.items():
        for v in ends:
            at.setdefault(v, []).append(k)
    seen: set[int] = set()
    for first in pairs:
        if first in seen:
            continue
        seen.add(first)
        chain, waiting = [], [first]
        while waiting:
            chain.append(waiting.pop())
            for v in pairs[chain[-1]]:
                for k in at[v]:
                    if k not in seen:
                        seen.add(k)
                        waiting.append(k)
        yield chain


def _is_ring(chain: Sequence[int], pairs: dict[int, list[int]]) -> bool:
    """Whether two ends meet wherever one is."""
    ends = np.array([pairs[k] for k in chain]).ravel()
    return bool((np.unique(ends, return_counts=True)[1] == 2).all())


def _joined(chain: Sequence[int], pairs: dict[int, list[int]], strokes: Sequence[Stroke]) -> Array:
    """Corners (n, 2) of a ring of strokes."""
    left = set(chain)
    k, (_, end) = chain[0], pairs[chain[0]]
    points = [strokes[k].points]
    left.discard(k)
    while left:
        k = next(k for k in chain if k in left and end in pairs[k])
        start, other = pairs[k]
        forward = start == end
        points.append(strokes[k].points if forward else strokes[k].points[::-1])
        end = other if forward else start
        left.discard(k)
    return np.concatenate(points)


def _patches(points: Array, edges: Sequence[Edge], holes: set[Edge], loose: set[Edge]) -> list[_Outline]:
    """What strokes that are no rings enclose, with all that holds together with them."""
    if not loose:
        return []
    found = [
        _Outline(island.hull, set(island.edges) <= holes, True)
        for island in islands_of(points, edges)
        if not loose.isdisjoint(island.edges)
    ]
    own = sorted(holes & loose)
    rings = [own[k] for k in parting(points, own)] if own else []
    return [*found, *(_Outline(island.hull, True) for island in islands_of(points, rings))]


def _full(faces: npt.NDArray[np.object_], outlines: Sequence[_Outline]) -> npt.NDArray[np.bool_]:
    """Which faces are material."""
    places = STRtree(shapely.point_on_surface(faces))
    shapes = np.array([outline.shape for outline in outlines], dtype=object)
    shapely.prepare(shapes)
    which, inside = places.query(shapes, predicate="contains")
    enclosed = _grouped(which, inside, len(outlines))
    solid = [k for k, outline in enumerate(outlines) if not outline.is_hole and len(enclosed[k])]
    solid = _without_tiles(solid, outlines, enclosed, faces)
    nest = _Nest([enclosed[k] for k in solid], len(faces))
    taken = [enclosed[k] for k, outline in enumerate(outlines) if outline.is_hole]
    return nest.full(taken)


def _grouped(which: _Faces, values: _Faces, count: int) -> list[_Faces]:
    """Values (n,) by which of `count` groups they are of, ascending in each."""
    order = np.lexsort((values, which))
    return np.split(values[order], np.searchsorted(which[order], np.arange(1, count)))


def _without_tiles(
    solid: list[int],
    outlines: Sequence[_Outline],
    enclosed: Sequence[_Faces],
    faces: npt.NDArray[np.object_],
) -> list[int]:
    """Less the rings that are tiles of what other strokes enclose together with them: they have a part of its rim."""
    gone: set[int] = set()
    for patch in (k for k in solid if outlines[k].is_patched):
        rim = shapely.boundary(outlines[patch].shape)
        amid = set(enclosed[patch].tolist())
        for k in solid:
            if k == patch or outlines[k].is_patched or k in gone or not amid.issuperset(enclosed[k].tolist()):
                continue
            own = shapely.boundary(shapely.union_all(faces[enclosed[k]]))
            if shapely.length(shapely.intersection(own, rim)) > 0.0:
                gone.add(k)
    return [k for k in solid if k not in gone]


class _Nest:
    """Outlines within one another, by the faces that they enclose; those that cross are one.

    outlines  the largest first
    label     the smallest outline about each face; -1: none
    parent    the smallest outline about each outline; -1: none
    """

    def __init__(self, outlines: Sequence[_Faces], count: int) -> None:
        self.outlines = list(outlines)
        self.label, self.parent = np.full(count, -1), list[int]()
        while not self._is_nested(count):
            pass

    def _is_nested(self, count: int) -> bool:
        """Orders the outlines, and joins those that cross; False where some did."""
        once = {faces.tobytes(): faces for faces in self.outlines}
        self.outlines = sorted(once.values(), key=lambda faces: (-len(faces), faces.tolist()))
        self.label, self.parent = np.full(count, -1), []
        joined: dict[int, int] = {}
        for k, faces in enumerate(self.outlines):
            about = np.unique(self.label[faces])
            crossed = [j for j in about.tolist() if j >= 0 and not np.isin(faces, self.outlines[j]).all()]
            if crossed:
                joined[k] = crossed[0]
            self.parent.append(int(about[0]) if len(about) == 1 else -1)
            self.label[faces] = k
        for k, other in sorted(joined.items(), reverse=True):
            self.outlines[other] = np.union1d(self.outlines[other], self.outlines.pop(k))
        return not joined

    def full(self, holes: Sequence[_Faces]) -> npt.NDArray[np.bool_]:
        """Faces within an odd number of outlines, and in no hole but one about the smallest of these."""
        depth: list[int] = []
        for parent in self.parent:
            depth.append(depth[parent] + 1 if parent >= 0 else 0)
        empty = np.zeros(len(self.label), dtype=bool)
        around = np.zeros(len(self.outlines), dtype=np.int64)
        for faces in holes:
            within = self._within(faces)
            around[within] += 1
            empty[faces[~np.isin(self.label[faces], within)]] = True
        turns = np.array(depth, dtype=np.int64) + around
        return np.asarray((self.label >= 0) & ~empty & (np.append(turns, 1)[self.label] % 2 == 0))

    def _within(self, hole: _Faces) -> list[int]:
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
        return [k for k, times in count.items() if times == len(self.outlines[k]) < len(hole)]

"""Facets of a flat drawing of edges, and of faces that a file lists.

In: vertices and edges. Out: rings of vertices, counterclockwise, each side of an edge in one of them. Never: mends a
drawing: crossings, doubled places and overlaps are told, each with its numbers and its place.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt
import shapely
from shapely import STRtree

from lamc.basics.errors import DesignError
from lamc.readers.fold_file import sides_of
from lamc.records.mechanism import Array
from lamc.records.network import listed_names

SHARE = 1e-6  # of the smaller facet: an overlap by less is rounding of corners to six digits
NEAR = 1e-9  # of the drawing's size: places that are nearer are one
# Of the sheet's extent: overlays in floating point take sides that all but coincide for a whole facet or for nothing
# (shapely issue 1871, JTS issue 1000); nodes on a grid do not. Far above the round-off of places (2e-16 of the extent),
# far below NEAR, so that it adds no area that counts.
_GRID = 1e-12
# A facet takes a millisecond or so from the file to its body; the largest pattern of public collections has 5100 edges.
MOST_FACETS = 10_000
AT_ONCE = 1_000_000  # pairs of lines that one query may look at: two seconds, where all cross
Edge = tuple[int, int]
Face = tuple[int, ...]
Indices = npt.NDArray[np.int64]


def check_count(count: int, what: str, *, large: bool) -> None:
    """Raises DesignError for a sheet that takes long to read, unless that is meant. what: "facets", or "edges", of
    which a facet has two at least."""
    most = MOST_FACETS if what == "facets" else 3 * MOST_FACETS
    if count > most and not large:
        raise DesignError(
            f"the sheet has {count} {what}; of more than {most} it takes minutes to read: take a part of it, or say "
            "that it is meant (--large; large=True of load)"
        )


def faces_of(
    points: Array, edges: Sequence[Edge], kinds: str, notes: list[str], number: Callable[[int], int] = int
) -> tuple[Face, ...]:
    """Bounded faces of a planar drawing; edges that bound none are left out, with a note. points: (n, 2).

    Raises DesignError where edges cross, run over one another or over a vertex, and where there is no face.
    """
    check_planar(points, edges, number)
    kept = _pruned(edges)
    if len(kept) < len(edges):
        left = ", ".join(str(number(k)) for k in sorted(set(range(len(edges))) - set(kept))[:8])
        notes.append(
            f"edges {left}{', …' if len(edges) - len(kept) > 8 else ''} end within a facet or lie outside all: they "
            "part nothing and are left out"
        )
    faces = [ring for ring in rings_of(points, [edges[k] for k in kept]) if area_of(points, ring) > 0.0]
    if not faces:
        raise DesignError("the edges enclose no facet; draw the sheet's outline too, as edges B")
    repeated = next((ring for ring in faces if len(set(ring)) < len(ring)), None)
    if repeated is not None:
        raise DesignError(
            f"the facet with the vertices {', '.join(map(str, repeated[:8]))}, … meets itself at a vertex; part it by "
            "an edge, or list faces_vertices"
        )
    return _without_holes(faces, edges, kinds, notes)


def _without_holes(
    faces: Sequence[Face], edges: Sequence[Edge], kinds: str, notes: list[str]
) -> tuple[Face, ...]:
    """Faces but those whose sides are all marked B and have a facet beyond: the boundary of a hole."""
    rim = {
        side for (a, b), kind in zip(edges, kinds, strict=True) if kind == "B" for side in ((a, b), (b, a))
    }
    whole = [set(sides_of(face)) <= rim for face in faces]
    facets = {side for face, alone in zip(faces, whole, strict=True) if not alone for side in sides_of(face)}
    holes = [
        face
        for face, alone in zip(faces, whole, strict=True)
        if alone and all((b, a) in facets for a, b in sides_of(face))
    ]
    if holes:
        named = "; ".join(", ".join(map(str, hole[:6])) for hole in holes[:4])
        notes.append(f"what edges B enclose amid facets is a hole: {len(holes)} (vertices {named})")
    return tuple(face for face in faces if face not in holes)


def polygons_of(points: Array, faces: Sequence[Face]) -> list[shapely.Polygon]:
    """Facets as polygons. Raises DesignError for one that crosses itself or has no area."""
    found = []
    for index, face in enumerate(faces):
        polygon = shapely.Polygon(points[list(face)])
        if not polygon.is_valid or not polygon.area > 0.0:
            raise DesignError(
                f"face {index} (vertices {', '.join(map(str, face[:8]))}) crosses itself or has no area"
            )
        found.append(polygon)
    return found


def overlap(polygons: Sequence[shapely.Polygon], share: float = SHARE) -> tuple[int, int] | None:
    """The first two facets that lie over one another by more than a share of the smaller one."""
    shapes = np.array(polygons, dtype=object)
    low, high = shapely.total_bounds(shapes).reshape(2, 2)
    shapes = shapely.transform(shapes, lambda places: places - low)  # a far place has no digits for the grid
    first, second = STRtree(shapes).query(shapes, predicate="intersects")
    once = first < second
    first, second = first[once], second[once]
    grid = _GRID * float((high - low).max())
    shared = shapely.area(shapely.intersection(shapes[first], shapes[second], grid_size=grid))
    over = shared > share * np.minimum(shapely.area(shapes[first]), shapely.area(shapes[second]))
    pairs = sorted(zip(first[over].tolist(), second[over].tolist(), strict=True))
    return pairs[0] if pairs else None


def check_planar(points: Array, edges: Sequence[Edge], number: Callable[[int], int]) -> None:
    """Raises DesignError where edges cross, have no length, or run over one another or over a vertex. points: (n, 2)"""
    size = float(np.ptp(points, axis=0).max()) or 1.0
    pairs = np.array(edges)
    for index, (a, b) in enumerate(edges):
        if math.dist(points[a], points[b]) <= NEAR * size:
            raise DesignError(f"edge {number(index)} has no length: vertices {a} and {b} are one place")
    lines = shapely.linestrings(points[pairs])
    used = np.unique(pairs)
    dots = shapely.points(points[used])
    at, line = STRtree(lines).query(dots, predicate="dwithin", distance=NEAR * size)
    for vertex, edge in sorted(zip(used[at].tolist(), line.tolist(), strict=True)):
        if vertex not in edges[edge]:
            near = [v for v in edges[edge] if math.dist(points[v], points[vertex]) <= NEAR * size]
            raise DesignError(
                "vertices {} and {} are one place, {}: join them".format(
                    *sorted((near[0], vertex)), _at(points[vertex])
                )
                if near
                else f"vertex {vertex} at {_at(points[vertex])} lies on edge {number(edge)}: part the edge there"
            )
    first, second = crossing_pairs(lines, 0)
    if len(first):
        a, b = min(zip(first.tolist(), second.tolist(), strict=True))
        where = shapely.get_coordinates(shapely.intersection(lines[a], lines[b]))[0]
        raise DesignError(
            f"edges {number(a)} and {number(b)} cross at {_at(where)}: put a vertex there, or list faces_vertices"
        )


def crossing_pairs(lines: npt.NDArray[np.object_], most: int) -> tuple[Indices, Indices]:
    """Pairs of lines that cross, by index, the lower one first; no further ones once they are more than `most`."""
    tree, step = STRtree(lines), max(1, AT_ONCE // max(1, len(lines)))
    none = np.zeros(0, dtype=np.int64)
    firsts, seconds, count = [none], [none], 0
    for start in range(0, len(lines), step):
        a, b = tree.query(lines[start : start + step], predicate="crosses")
        once = a + start < b
        firsts.append(a[once] + start)
        seconds.append(b[once])
        count += len(firsts[-1])
        if count > most:
            break
    return np.concatenate(firsts), np.concatenate(seconds)


def _at(point: Array) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"


def _pruned(edges: Sequence[Edge]) -> list[int]:
    """Edges without those that hang by one end, again and again."""
    beside: dict[int, set[int]] = {}
    for k, (a, b) in enumerate(edges):
        beside.setdefault(a, set()).add(k)
        beside.setdefault(b, set()).add(k)
    loose = [v for v, found in beside.items() if len(found) == 1]
    gone: set[int] = set()
    while loose:
        vertex = loose.pop()
        for k in beside[vertex]:
            gone.add(k)
            other = edges[k][0] + edges[k][1] - vertex
            beside[other].discard(k)
            if len(beside[other]) == 1:
                loose.append(other)
        beside[vertex] = set()
    return [k for k in range(len(edges)) if k not in gone]


def rings_of(points: Array, edges: Sequence[Edge]) -> list[Face]:
    """Every ring of directed edges with the drawing's inside to the left, in the order of their first edges."""
    around: dict[int, list[int]] = {}
    for a, b in edges:
        around.setdefault(a, []).append(b)
        around.setdefault(b, []).append(a)
    following: dict[Edge, Edge] = {}
    for vertex, ends in around.items():
        x, y = points[vertex]
        ends.sort(key=lambda other: math.atan2(points[other][1] - y, points[other][0] - x))
        for k, other in enumerate(ends):
            following[(other, vertex)] = (vertex, ends[k - 1])  # the next one clockwise
    rings: list[Face] = []
    done: set[Edge] = set()
    for edge in [side for a, b in edges for side in ((a, b), (b, a))]:
        ring = []
        while edge not in done:
            done.add(edge)
            ring.append(edge[0])
            edge = following[edge]
        if ring:
            rings.append(tuple(ring))
    return rings


def area_of(points: Array, ring: Face) -> float:
    xy = points[list(ring)] - points[ring[0]]
    after = np.roll(xy, -1, axis=0)
    return 0.5 * float(np.sum(xy[:, 0] * after[:, 1] - after[:, 0] * xy[:, 1]))


def aside(place: Array, start: Array, end: Array) -> float:
    """How far a place (2,) lies from the line between two others, m."""
    (x, y), (along, across) = place - start, end - start
    return float(abs(x * across - y * along)) / (math.hypot(along, across) or 1.0)


def counterclockwise(points: Array, face: Face) -> Face:
    """The same face with its inside to the left."""
    return face if area_of(points, face) > 0.0 else tuple(reversed(face))


def beside_edges(faces: Sequence[Face], edges: Sequence[Edge]) -> list[tuple[int | None, int | None]]:
    """The faces to the left and right of each edge. Raises DesignError for two on one side, and a side without edge."""
    left: dict[Edge, int] = {}
    known = {tuple(sorted(edge)) for edge in edges}
    for k, face in enumerate(faces):
        for side in sides_of(face):
            if side in left:
                met = [n for n, other in enumerate(faces) if {side, side[::-1]} & set(sides_of(other))]
                if len(met) > 2:
                    raise DesignError(
                        f"the edge from vertex {side[0]} to {side[1]} has {len(met)} faces, "
                        f"{listed_names([str(n) for n in met])}: an edge joins two of one sheet; sheets that are "
                        "joined to one another are files of their own"
                    )
                raise DesignError(
                    f"faces {left[side]} and {k} lie on the same side of the edge from vertex {side[0]} to {side[1]}: "
                    "they overlap, or one of them is listed clockwise"
                )
            if tuple(sorted(side)) not in known:
                raise DesignError(
                    f"face {k} has a side from vertex {side[0]} to {side[1]}, which is no edge; list it in "
                    "edges_vertices"
                )
            left[side] = k
    return [(left.get((a, b)), left.get((b, a))) for a, b in edges]

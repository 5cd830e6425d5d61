"""Facets that have vertices and edges of their own, as meshes for printing have: they are joined along their creases.

In: vertices, edges with kinds and angles, faces. Out: edges and faces of the sheet that is meant, and a note.
Never: joins rims and cuts, which may lie side by side; nor layers of a folded sheet, whose creases have both facets.
"""

from collections.abc import Sequence
from itertools import product
from operator import add

import numpy as np

from lamc.records.mechanism import Array
from lamc.records.network import listed_names

_SAME = 1e-9  # of the size: places that differ by less are one, as files write 10 to 17 digits
_FOLDS = "MVFU"
Edge = tuple[int, int]
Edges = tuple[Edge, ...]
Faces = tuple[tuple[int, ...], ...] | None


def with_seams(
    vertices: Array,
    edges: Edges,
    kinds: str,
    angles: Sequence[float | None],
    faces: Faces,
    kept: list[int],
    notes: list[str],
) -> tuple[Edges, Faces, list[int]]:
    """Edges, faces, and those of the places `kept` that stay, with facets joined along creases that both draw."""
    own = [edges[k] for k in kept]
    pairs = _seams(vertices, own, "".join(kinds[k] for k in kept), [angles[k] for k in kept], faces)
    left_out = {kept[second] for _, second in pairs}
    one = _joined(vertices, own, pairs)
    if faces is None:
        one = _at_creases(vertices, edges, kinds, [k for k in kept if k not in left_out], one, notes)
    if one == list(range(len(vertices))):
        return edges, faces, kept
    if left_out:
        named = listed_names([str(k) for k in sorted(left_out)])
        notes.append(
            f"edges {named} lie where others do, between vertices of their own: facets are joined along them"
        )
    joined = tuple((one[a], one[b]) for a, b in edges)
    rings = None if faces is None else tuple(tuple(one[v] for v in face) for face in faces)
    return joined, rings, [k for k in kept if k not in left_out]


def _seams(
    vertices: Array, edges: Sequence[Edge], kinds: str, angles: Sequence[float | None], faces: Faces
) -> list[tuple[int, int]]:
    """Pairs of creases, by their places in `edges`, that two facets draw along one line with vertices of their own."""
    places = _places(vertices)
    beside = _counts(faces)
    along: dict[Edge, list[int]] = {}
    for index, (a, b) in enumerate(edges):
        alone = beside is None or beside.get((min(a, b), max(a, b)), 0) == 1
        if alone and kinds[index] in _FOLDS:
            ends = places[a], places[b]
            along.setdefault((min(ends), max(ends)), []).append(index)
    pairs = [tuple(found) for found in along.values() if len(found) == 2]
    return [
        (first, second)
        for first, second in pairs
        if set(edges[first]) != set(edges[second])
        and (kinds[first], angles[first]) == (kinds[second], angles[second])
    ]


def _joined(vertices: Array, edges: Sequence[Edge], pairs: Sequence[tuple[int, int]]) -> list[int]:
    """The vertex that each one is, where ends of such pairs are one: the first of those."""
    places, one = _places(vertices), list(range(len(vertices)))

    def root(v: int) -> int:
        while one[v] != v:
            one[v] = one[one[v]]
            v = one[v]
        return v

    for first, second in pairs:
        for a in edges[first]:
            b = next(v for v in edges[second] if places[v] == places[a])
            low, high = sorted((root(a), root(b)))
            one[high] = low
    return [root(v) for v in range(len(vertices))]


def _at_creases(
    vertices: Array, edges: Edges, kinds: str, kept: Sequence[int], one: list[int], notes: list[str]
) -> list[int]:
    """The same of a drawing of lines alone, where a crease that is drawn once ends at a vertex that another facet has
    of its own. As `one` is where that would lay edges over one another: sides of a slit are two."""
    places = _places(vertices)
    ends = {places[v] for k in kept if kinds[k] in _FOLDS for v in edges[k]}
    used = sorted({one[v] for k in kept for v in edges[k]})
    first: dict[int, int] = {}
    instead = {v: first.setdefault(places[v], v) for v in used if places[v] in ends}
    found = [instead.get(v, v) for v in one]
    lines = [frozenset((found[a], found[b])) for a, b in (edges[k] for k in kept)]
    twice = [(low, v) for v, low in instead.items() if low != v]
    if not twice or len(set(lines)) < len(lines):
        return one
    named = "; ".join(f"{low} and {v}" for low, v in twice[:4]) + "; …" * (len(twice) > 4)
    notes.append(f"vertices at the end of a crease that are one place are joined: {named}")
    return found


def _places(vertices: Array) -> list[int]:
    """A number for each vertex; those at one place have the same: in one cell of a grid, or in cells that touch, as
    places on both sides of a line of the grid are one. (Pairs of near vertices could be as many as their square.)"""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    size = float(np.linalg.norm(np.ptp(vertices, axis=0))) or 1.0
    cells, of_cell = np.unique(np.round(vertices / (_SAME * size)), axis=0, return_inverse=True)
    index = {cell: k for k, cell in enumerate(map(tuple, cells.tolist()))}
    ways = [way for way in product((-1, 0, 1), repeat=vertices.shape[1]) if way > (0,) * len(way)]
    links = [
        (k, near)
        for cell, k in index.items()
        for way in ways
        if (near := index.get(tuple(map(add, cell, way)))) is not None
    ]
    pairs = np.array(links, dtype=np.int64).reshape(-1, 2)
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(cells), len(cells)))
    places = connected_components(graph, directed=False)[1]
    found: list[int] = places[of_cell.reshape(-1)].tolist()
    return found


def _counts(faces: Faces) -> dict[Edge, int] | None:
    """How many faces each side has; None where faces are not known, and what is drawn has no layers."""
    if faces is None:
        return None
    found: dict[Edge, int] = {}
    for face in faces:
        for a, b in zip(face, (*face[1:], face[0]), strict=True):
            side = min(a, b), max(a, b)
            found[side] = found.get(side, 0) + 1
    return found

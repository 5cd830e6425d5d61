"""Curves of a sheet with fewer corners, where facets that bend would be cut into more pieces than run within seconds.

In: a planar graph of edges that part something, and what each is for. Out: edges between fewer of its vertices. Never:
moves a vertex; leaves out one where lines meet or where what they are for changes; lets lines cross that did not.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from shapely import STRtree

from lamc.readers.fold_faces import NEAR, Edge, crossing_pairs
from lamc.records.mechanism import Array

_STEP = 0.25  # by which the tolerance of curves shrinks that would cross
_LEAST = 1e-3  # of the tolerance: curves that would cross even then keep all their corners


@dataclass(frozen=True)
class Curve:
    """A chain of edges alike, through vertices where nothing else ends.

    corners  vertices along it, both ends included
    edge     its first edge, which says what all are for
    """

    corners: tuple[int, ...]
    edge: int


def curves_of(points: Array, edges: Sequence[Edge], alike: Sequence[Hashable]) -> list[Curve]:
    """All edges as chains, each as long as edges are alike. A chain that closes is two, parted where it is widest."""
    at: dict[int, list[int]] = {}
    for k, (a, b) in enumerate(edges):
        at.setdefault(a, []).append(k)
        at.setdefault(b, []).append(k)
    inner = {v for v, ks in at.items() if len(ks) == 2 and alike[ks[0]] == alike[ks[1]]}
    done: set[int] = set()
    found: list[Curve] = []

    def walk(start: int, edge: int) -> tuple[int, ...]:
        corners, k = [start], edge
        while True:
            done.add(k)
            a, b = edges[k]
            corners.append(b if corners[-1] == a else a)
            if corners[-1] not in inner or corners[-1] == start:
                return tuple(corners)
            first, second = at[corners[-1]]
            k = second if first == k else first

    # What is left at inner vertices, after all else, are whole rings.
    for start in [*sorted(at.keys() - inner), *sorted(inner)]:
        for edge in at[start]:
            if edge not in done:
                corners = walk(start, edge)
                if corners[0] != corners[-1]:
                    found.append(Curve(corners, edge))
                    continue
                away = np.linalg.norm(points[list(corners)] - points[start], axis=1)
                half = int(np.argmax(away))
                found += [Curve(corners[: half + 1], edge), Curve(corners[half:], edge)]
    return found


def is_straight(points: Array, curve: Curve, tolerance: float) -> bool:
    """Whether none of its corners is off its chord by more than the tolerance, m."""
    return len(_fewer(points, curve.corners, tolerance)) == 2


def fewest(points: Array, curves: Sequence[Curve], tolerance: float) -> int:
    """How many vertices curves off by at most `tolerance`, m, have at least; `coarser` keeps more where they would
    cross."""
    return len({v for curve in curves for v in _fewer(points, curve.corners, tolerance)})


def coarser(points: Array, curves: Sequence[Curve], tolerance: float) -> list[tuple[Edge, int]]:
    """Edges, each with the first edge of its curve, of curves off by at most `tolerance`, m, or less where they would
    cross, fall together, or pass over what lies beside them."""
    within = np.full(len(curves), tolerance)
    kept = [_fewer(points, curve.corners, tolerance) for curve in curves]
    while True:
        rows = [(a, b, k) for k, corners in enumerate(kept) for a, b in pairwise(corners)]
        bad = _in_conflict(points, rows) | _passing_over(points, curves, kept)
        bad &= {k for k, curve in enumerate(curves) if len(kept[k]) < len(curve.corners)}
        if not bad:
            return [((min(a, b), max(a, b)), curves[k].edge) for a, b, k in rows]
        for k in bad:
            within[k] *= _STEP
            whole = within[k] < _LEAST * tolerance
            kept[k] = curves[k].corners if whole else _fewer(points, curves[k].corners, float(within[k]))


def _fewer(points: Array, corners: tuple[int, ...], tolerance: float) -> tuple[int, ...]:
    """Those of the corners from which the others are off by at most the tolerance (Douglas and Peucker, 1973)."""
    if len(corners) < 3:
        return corners
    places = points[list(corners)]
    left = shapely.get_coordinates(
        shapely.simplify(shapely.linestrings(places), tolerance, preserve_topology=False)
    )
    number = {tuple(place): v for place, v in zip(places.tolist(), corners, strict=True)}
    return tuple(number[tuple(place)] for place in left.tolist())


def _in_conflict(points: Array, rows: Sequence[tuple[int, int, int]]) -> set[int]:
    """Curves of edges that cross, or join the same vertices."""
    ends = np.array([row[:2] for row in rows])
    owner = np.array([row[2] for row in rows])
    first, second = crossing_pairs(shapely.linestrings(points[ends]), len(rows))
    found = set(owner[first].tolist()) | set(owner[second].tolist())
    ends.sort(axis=1)
    _, inverse, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    return found | set(owner[count[inverse.ravel()] > 1].tolist())


def _passing_over(points: Array, curves: Sequence[Curve], kept: Sequence[tuple[int, ...]]) -> set[int]:
    """Curves with a corner that stays between them and their chords, or on those: it would come to lie on the other
    side, or amid an edge."""
    owner, own = [], []
    for k, (curve, corners) in enumerate(zip(curves, kept, strict=True)):
        at = {v: i for i, v in enumerate(curve.corners)}
        for a, b in pairwise(corners):
            if at[b] > at[a] + 1:
                owner.append(k)
                own.append(curve.corners[at[a] : at[b] + 1])
    if not own:
        return set()
    number = np.repeat(np.arange(len(own)), [len(each) for each in own])
    hulls = shapely.convex_hull(shapely.linestrings(points[np.concatenate(own)], indices=number))
    left = np.unique([v for corners in kept for v in corners])
    near = NEAR * float(np.ptp(points, axis=0).max())
    tree = STRtree(shapely.points(points[left]))
    over, vertices = tree.query(hulls, predicate="dwithin", distance=near)
    pairs = zip(over.tolist(), left[vertices].tolist(), strict=True)
    return {owner[k] for k, vertex in pairs if vertex not in own[k]}

"""Crease patterns of any size with the angles of a folded state.

In: a size. Out: FOLD data in mm. Angles are closed forms of vertices that fold alike all over the sheet, so
that a pattern is flat as it stands and folded by `in_space`.
"""

import math
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np

from lamc.examples.folded import mirrored, third_of_opposites
from tests.support import fold_corpus
from tests.support.fold_corpus import ACUTE, Data

FOLD = 40.0  # degrees, of the creases that lead


def miura(columns: int, rows: int) -> Data:
    data = fold_corpus.miura(columns, rows, faces=True)
    straight = math.degrees(2.0 * math.atan(math.cos(ACUTE) * math.tan(math.radians(0.5 * FOLD))))
    level = {(a, b) for a, b in data["edges_vertices"] if b == a + 1}
    return _angled(data, lambda ends, _: straight if ends in level else FOLD)


def yoshimura(columns: int, rows: int) -> Data:
    data = fold_corpus.yoshimura(columns, rows)
    base = math.atan2(18.0, 15.0)
    slanted = math.radians(-FOLD)
    level = third_of_opposites((math.pi - 2.0 * base, base, base), slanted, slanted)
    return _angled(data, lambda _, kind: math.degrees(level) if kind == "V" else FOLD)


def kresling(columns: int, rows: int) -> Data:
    data = fold_corpus.kresling(columns, rows)
    side, diagonal = math.atan2(15.0, 8.0), math.atan2(15.0, 8.0 - 20.0)
    lead = math.radians(-0.5 * FOLD)
    level = third_of_opposites((diagonal - side, math.pi - diagonal, side), lead, -0.8 * lead)
    width = columns + 1

    def angle(ends: tuple[int, int], kind: str) -> float:
        of_level = abs(ends[0] - ends[1]) == 1 and min(ends) // width == max(ends) // width
        return math.degrees(level) if of_level else 0.4 * FOLD if kind == "V" else 0.5 * FOLD

    return _angled(data, angle)


def waterbomb(columns: int, rows: int) -> Data:
    """Squares of 30 mm with both diagonals and an upright midline, shifted by half a square from row to row."""
    half, right, eighth = 15.0, 0.5 * math.pi, 0.25 * math.pi
    diagonal = math.radians(FOLD)
    midline = third_of_opposites((right, eighth, eighth), diagonal, diagonal)
    level, upright = mirrored(midline, (right, eighth, eighth), diagonal)
    folds = {"d": diagonal, "m": midline, "h": level, "u": upright}
    index: dict[tuple[int, int], int] = {}
    facets: list[list[int]] = []
    for j in range(rows):
        for i in range(columns):
            x, y = 2 * i + j % 2, 2 * j
            ring = [(x, y), (x + 1, y), (x + 2, y), (x + 2, y + 2), (x + 1, y + 2), (x, y + 2)]
            corners = [index.setdefault(place, len(index)) for place in ring]
            centre = index.setdefault((x + 1, y + 1), len(index))
            facets += [[a, b, centre] for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]
    places = list(index)

    def fold(a: int, b: int) -> float:
        (xa, ya), (xb, yb) = places[a], places[b]
        if xa == xb:
            return folds["m" if ya % 2 or yb % 2 else "u"]
        return folds["h" if ya == yb else "d"]

    return _of_facets([(half * x, half * y) for x, y in places], facets, fold)


def grid(columns: int, rows: int) -> Data:
    """Squares of 20 mm with a diagonal each, by turns: vertices of four and of eight creases."""
    index = {(i, j): j * (columns + 1) + i for j in range(rows + 1) for i in range(columns + 1)}
    facets = []
    for j in range(rows):
        for i in range(columns):
            a, b, c, d = (index[i + p, j + q] for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
            facets += [[a, b, c], [a, c, d]] if (i + j) % 2 else [[a, b, d], [b, c, d]]
    return _of_facets([(20.0 * i, 20.0 * j) for i, j in index], facets, lambda a, b: 0.0)


PATTERNS: dict[str, Callable[[int, int], Data]] = {
    "miura": miura,
    "yoshimura": yoshimura,
    "kresling": kresling,
    "waterbomb": waterbomb,
    "grid": grid,
}


def _of_facets(places: list[Any], facets: list[list[int]], fold: Callable[[int, int], float]) -> Data:
    """FOLD data of triangles; fold: rad, of the crease between two vertices."""
    count: dict[tuple[int, int], int] = {}
    for facet in facets:
        for a, b in zip(facet, [*facet[1:], facet[0]], strict=True):
            count[min(a, b), max(a, b)] = count.get((min(a, b), max(a, b)), 0) + 1
    data = fold_corpus._started(places, "mm")
    angles: list[float | None] = []
    for (a, b), sides in count.items():
        angle = fold(a, b)
        fold_corpus._edge(
            data, a, b, "B" if sides == 1 else "V" if angle > 0.0 else "M" if angle else "UVM"[(a + b) % 3]
        )
        angles.append(None if sides == 1 or not angle else math.degrees(angle))
    return data | {"edges_foldAngle": angles, "faces_vertices": facets}


def _angled(data: Data, size: Callable[[tuple[int, int], str], float]) -> Data:
    """With angles, degrees, of each edge's size, that fold as its letter says."""
    angles: list[float | None] = []
    for (a, b), kind in zip(data["edges_vertices"], data["edges_assignment"], strict=True):
        angles.append(
            None if kind == "B" else math.copysign(size((a, b), kind), 1.0 if kind == "V" else -1.0)
        )
    return data | {"edges_foldAngle": angles}


def in_space(data: Data) -> Data:
    """The sheet folded by its angles, facets turned about their creases one after the other."""
    from lamc.readers.fold_faces import area_of, rings_of

    flat = np.array(data["vertices_coords"], dtype=float)[:, :2]
    edges = [tuple(edge) for edge in data["edges_vertices"]]
    rings = data.get("faces_vertices") or [r for r in rings_of(flat, edges) if area_of(flat, r) > 0.0]
    fold = {
        frozenset(edge): math.radians(a or 0.0)
        for edge, a in zip(edges, data["edges_foldAngle"], strict=True)
    }
    beside = {
        (a, b): k for k, ring in enumerate(rings) for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)
    }
    turned: dict[int, tuple[Any, Any]] = {0: (np.eye(3), np.zeros(3))}  # x_space = R x_flat + p
    points = np.column_stack([flat, np.zeros(len(flat))])
    found = points.copy()
    queue = deque([0])
    while queue:
        face = queue.popleft()
        rotation, shift = turned[face]
        ring = rings[face]
        for v in ring:
            found[v] = rotation @ points[v] + shift
        for a, b in zip(ring, [*ring[1:], ring[0]], strict=True):
            other = beside.get((b, a))
            if other is None or other in turned:
                continue
            # The other face lies to the left of the line from b to a, and turns about it by the fold.
            about = _turn(points[a] - points[b], fold[frozenset((a, b))])
            turned[other] = rotation @ about, rotation @ (points[b] - about @ points[b]) + shift
            queue.append(other)
    return data | {"vertices_coords": found.tolist(), "faces_vertices": [list(ring) for ring in rings]}


def _turn(axis: Any, angle: float) -> Any:
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross

"""Points and segments in the plane, for healing: what is near to what, where lines meet, lines parted at vertices.

In: arrays of places, m, and segments as pairs of them. Out: the same. Never: knows what a line is for.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import shapely
from shapely import STRtree

from lamc.basics.errors import DesignError
from lamc.readers.fold_faces import AT_ONCE, Edge, Indices
from lamc.records.mechanism import Array

# Ends beside one another or beside lines, 64 MB of pairs: a drawing has some for each line, a heap each with each.
MOST_NEAR = 4_000_000
_PARALLEL = 1e-6  # of the product of lengths: lines at a smaller angle do not meet in any useful place


@dataclass(frozen=True)
class Segments:
    """Vertices at both ends, and the stroke, of each segment; (n,) each."""

    a: Indices
    b: Indices
    owner: Indices

    @staticmethod
    def of(rows: Sequence[tuple[int, int, int]]) -> "Segments":
        table = np.array(rows, dtype=int).reshape(-1, 3)
        return Segments(table[:, 0], table[:, 1], table[:, 2])

    def __len__(self) -> int:
        return len(self.a)

    def rows(self) -> Iterable[tuple[int, int, int]]:
        return zip(self.a.tolist(), self.b.tolist(), self.owner.tolist(), strict=True)

    def pairs(self) -> Indices:
        """(n, 2)"""
        return np.column_stack([self.a, self.b])

    def degrees(self, count: int) -> Indices:
        """Ends at each of `count` vertices."""
        return np.bincount(self.pairs().ravel(), minlength=count).astype(np.int64)

    def renumbered(self, number: Indices) -> "Segments":
        return Segments(number[self.a], number[self.b], self.owner)

    def without(self, left_out: Iterable[int]) -> "Segments":
        """But for some of them, by their indices."""
        kept = np.setdiff1d(np.arange(len(self)), list(left_out))
        return Segments(self.a[kept], self.b[kept], self.owner[kept])

    def line_at(self, vertex: int, at: Array) -> tuple[Array, Array]:
        """The places of a vertex at which one segment ends, and of the segment's other end."""
        s = int(np.flatnonzero((self.a == vertex) | (self.b == vertex))[0])
        other = int(self.b[s] if self.a[s] == vertex else self.a[s])
        return at[vertex], at[other]

    def parted(self, cuts: Mapping[int, Sequence[int]], at: Array) -> "Segments":
        """With segments parted at vertices, in the order in which these lie along them."""
        rows: list[tuple[int, int, int]] = []
        for s, (a, b, owner) in enumerate(self.rows()):
            if s not in cuts:
                rows.append((a, b, owner))
                continue
            along = at[b] - at[a]
            inner = sorted(cuts[s], key=lambda v: (float((at[v] - at[a]) @ along), v))
            stops = [a, *inner, b]
            rows += [(p, q, owner) for p, q in pairwise(stops)]
        return Segments.of(rows)


def drawn(courses: Iterable[tuple[int, Array, bool]]) -> tuple[Array, Segments, set[Edge]]:
    """Points, segments and (vertex, stroke) at the ends of what is open, of strokes with their points, each (n, 2)."""
    points, segments, ends = [np.zeros((0, 2))], [Segments.of([])], set()
    count = 0
    for stroke, xy, closed in courses:
        index = count + np.arange(len(xy))
        count += len(xy)
        points.append(xy)
        start, stop = (index, np.roll(index, -1)) if closed else (index[:-1], index[1:])
        segments.append(Segments(start, stop, np.full(len(start), stroke)))
        if not closed:
            ends |= {(int(index[0]), stroke), (int(index[-1]), stroke)}
    a, b, owner = (np.concatenate([getattr(each, name) for each in segments]) for name in ("a", "b", "owner"))
    return np.concatenate(points), Segments(a, b, owner), ends


def gathered(points: Array, weight: Indices, near: float, may_join: Callable[[int, int], bool]) -> Indices:
    """For each point the one that it becomes: the heaviest within reach, of those the one with most about it, else
    itself. points: (n, 2).

    No chains: none moves by more than `near`, so that a heap of ends up to twice as wide becomes one point if one of
    them lies amid it.
    """
    kept = np.arange(len(points))
    dots = shapely.points(points)
    first, second = _pairs_within(STRtree(dots), dots, near)
    apart = first != second
    beside: dict[int, list[int]] = {}
    for p, q in zip(first[apart].tolist(), second[apart].tolist(), strict=True):
        beside.setdefault(p, []).append(q)
    order = sorted(beside, key=lambda p: (-weight[p], -len(beside[p]), points[p, 0], points[p, 1]))
    settled: set[int] = set()
    for p in order:
        if p in settled:
            continue
        settled.add(p)
        for q in sorted(beside[p]):
            if q not in settled and may_join(p, q):
                kept[q] = p
                settled.add(q)
    return kept


def _pairs_within(tree: STRtree, dots: npt.NDArray[np.object_], near: float) -> tuple[Indices, Indices]:
    """Dots and what of the tree is within reach of them, by index. Raises DesignError for very many."""
    step = max(1, AT_ONCE // max(1, len(tree)))
    firsts, seconds, count = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)], 0
    for start in range(0, len(dots), step):
        a, b = tree.query(dots[start : start + step], predicate="dwithin", distance=near)
        firsts.append(a + start)
        seconds.append(b)
        count += len(a)
        if count > MOST_NEAR:
            raise DesignError(
                f"more than {MOST_NEAR} ends and lines lie within {1e6 * near:.3g} um of one another, so that many are "
                "drawn over one another; draw each once, or heal with less"
            )
    return np.concatenate(firsts), np.concatenate(seconds)


def near_pairs(at: Array, segments: Segments, near: float, exact: float) -> tuple[Indices, Indices, Array]:
    """Vertices, segments and distances, where a vertex lies on a segment, or beside it and not beside its ends too."""
    lines = shapely.linestrings(at[segments.pairs()])
    used = np.unique(segments.pairs())
    v, s = _pairs_within(STRtree(lines), shapely.points(at[used]), near)
    v = used[v]
    other = (v != segments.a[s]) & (v != segments.b[s])
    v, s = v[other], s[other]
    start = at[segments.a[s]]
    along = at[segments.b[s]] - start
    length = np.linalg.norm(along, axis=1)
    share = np.einsum("ij,ij->i", at[v] - start, along) / length
    apart = shapely.distance(shapely.points(at[v]), lines[s])
    # Beside an end the next corner of a curve through that end would be taken for one that should lie on the line.
    margin = np.where(apart > exact, near, exact)
    within = (share > margin) & (share < length - margin)
    # What ends there is no such curve, and joins that end only where it is near enough.
    to_ends = [np.linalg.norm(at[v] - at[end], axis=1) for end in (segments.a[s], segments.b[s])]
    is_tip = (segments.degrees(len(at))[v] == 1) & (np.minimum(*to_ends) > near)
    within |= is_tip & (share > exact) & (share < length - exact)
    v, s, apart = v[within], s[within], apart[within]
    order = np.lexsort((s, v))
    return v[order], s[order], apart[order]


def crossing(at: Array, segments: Segments, first: Indices, second: Indices) -> Array:
    """Where pairs of segments cross, (n, 2)."""
    p, r = at[segments.a[first]], at[segments.b[first]] - at[segments.a[first]]
    q, s = at[segments.a[second]], at[segments.b[second]] - at[segments.a[second]]
    share = _cross(q - p, s) / _cross(r, s)
    return np.asarray(p + share[:, None] * r)


def meeting(p: Array, p_end: Array, q: Array, q_end: Array) -> Array | None:
    """Where two lines, drawn on, meet; None where they are all but parallel."""
    r, s = p_end - p, q_end - q
    turn = float(_cross(r, s))
    if abs(turn) <= _PARALLEL * float(np.linalg.norm(r) * np.linalg.norm(s)):
        return None
    return np.asarray(p + float(_cross(q - p, s)) / turn * r)


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])

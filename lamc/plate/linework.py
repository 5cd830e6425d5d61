"""From polygons to lines that a mesher can take: every meeting of lines is a point, and points lie as close as cells
shall be.

In: polygons that were checked. Out: corners, segments between them, and points on these. Never: cells.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from lamc.mechanism.checks import Array

Integers = NDArray[np.int32]

_ACUTE = np.radians(
    60.0
)  # between segments: below this, splits of one would call for splits of the other for ever


@dataclass(frozen=True, eq=False)
class Linework:
    """Corners and the segments between them, no two of which cross or lie upon each other."""

    corners: Array  # (c, 2), m
    segments: Integers  # (s, 2), rows of corners, the lower first
    sizes: Array  # (s,), m, wanted length of edges along each


@dataclass(frozen=True, eq=False)
class Divided:
    """Corners, then points on segments."""

    points: Array  # (n, 2), m
    sizes: Array  # (n,), m, wanted length of edges there
    segment_of: Integers  # (n,), -1 for corners
    parts: Integers  # (p, 2), rows of points


def linework(
    border: Sequence[Array],
    regions: Sequence[Sequence[Array]],
    size: float,
    sizes: Sequence[float],
    tolerance: float,
) -> Linework:
    """Lines along the rings of the plate's border and of its regions.

    Rings are closed, shape (k, 2). Corners nearer than `tolerance` to each other become one, and a corner that near to
    a segment lies on it: what should coincide but for round-off does.
    """
    rings = [(ring, -1) for ring in border] + [(ring, k) for k, own in enumerate(regions) for ring in own]
    given = np.concatenate([ring[:-1] for ring, _ in rings])
    starts = np.cumsum([0, *(len(ring) - 1 for ring, _ in rings)])
    corners, index = _merged(given, tolerance)
    pairs, owners = [], []
    for (_, of_region), start, end in zip(rings, starts[:-1], starts[1:], strict=True):
        along = index[start:end]
        pairs.append(np.stack([along, np.roll(along, -1)], axis=1))
        owners.append(np.full(len(along), of_region))
    ends, owner = _split_at_corners(corners, np.concatenate(pairs), np.concatenate(owners), tolerance)
    segments, of = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    # The plate's border has a region on one side, or none; other segments have one on one side at least.
    at_border = np.zeros(len(segments), dtype=bool)
    at_border[of[owner < 0]] = True
    in_regions = np.bincount(of[owner >= 0], minlength=len(segments))
    wanted = np.where(in_regions + at_border >= 2, np.inf, size)
    np.minimum.at(wanted, of[owner >= 0], np.asarray(sizes, dtype=float)[owner[owner >= 0]])
    return Linework(corners, segments.astype(np.int32), wanted)


def _merged(points: Array, tolerance: float) -> tuple[Array, NDArray[np.int64]]:
    """Points without doubles, in order of first appearance, and where each given one went."""
    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    count, label = connected_components(graph, directed=False)
    first = np.full(count, len(points))
    np.minimum.at(first, label, np.arange(len(points)))
    order = np.argsort(first)
    place = np.empty(count, dtype=np.int64)
    place[order] = np.arange(count)
    return points[first[order]], place[label]


def _split_at_corners(
    corners: Array, ends: NDArray[np.int64], owner: NDArray[np.int64], tolerance: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Segments cut at the corners that lie on them; those without length are left out."""
    real = ends[:, 0] != ends[:, 1]
    ends, owner = ends[real], owner[real]
    tree = shapely.STRtree(shapely.linestrings(corners[ends]))
    corner, segment = tree.query(shapely.points(corners), predicate="dwithin", distance=tolerance)
    between = (corner != ends[segment, 0]) & (corner != ends[segment, 1])
    corner, segment = corner[between], segment[between]
    along = corners[ends[segment, 1]] - corners[ends[segment, 0]]
    t = np.sum(along * (corners[corner] - corners[ends[segment, 0]]), axis=1) / np.sum(along * along, axis=1)
    # All points of all segments, in order along each; then pairs of neighbours on the same segment.
    number = np.arange(len(ends))
    point = np.concatenate([ends[:, 0], corner, ends[:, 1]])
    of = np.concatenate([number, segment, number])
    order = np.lexsort((np.concatenate([np.full(len(ends), -1.0), t, np.full(len(ends), 2.0)]), of))
    point, of = point[order], of[order]
    same = of[1:] == of[:-1]
    return np.stack([point[:-1], point[1:]], axis=1)[same], owner[of[1:][same]]


def corner_sizes(lines: Linework, grading: float) -> Array:
    """Wanted length of edges at the corners, shape (c,), m: not more than at any segment there, nor than the segment's
    length, and growing along segments by `grading` per length at most."""
    count = len(lines.corners)
    lengths = _lengths(lines)
    own = np.full(count, np.inf)
    for k in (0, 1):
        np.minimum.at(own, lines.segments[:, k], np.minimum(lines.sizes, lengths))
    # Least over all corners of (size there + grading × way): shortest ways from one more corner that all start at.
    rows = np.concatenate([np.full(count, count), lines.segments[:, 0]])
    columns = np.concatenate([np.arange(count), lines.segments[:, 1]])
    graph = coo_array(
        (np.concatenate([own, grading * lengths]), (rows, columns)), shape=(count + 1, count + 1)
    )
    return np.asarray(dijkstra(graph.tocsr(), directed=False, indices=count)[:count])


def _lengths(lines: Linework) -> Array:
    ends = lines.corners[lines.segments]
    return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))


def count_of_parts(lines: Linework, sizes: Array, grading: float) -> float:
    """About how many parts `divide` will make."""
    growth = [_Growth(r[0], r[1], r[2], r[3], grading) for r in _rows(lines, sizes)]
    return float(sum(g.total for g in growth))


def divide(lines: Linework, sizes: Array, grading: float) -> Divided:
    """Points on the segments, as far apart as `sizes` at the corners and the sizes along segments ask for.

    Segments that meet at an acute angle get their first points at the same distance from the corner.
    """
    lengths = _lengths(lines)
    first = _first_steps(lines, sizes, lengths)
    points, wanted, of, parts = [lines.corners], [sizes], [np.full(len(sizes), -1)], []
    count = len(lines.corners)
    for number, (length, at_start, at_end, cap) in enumerate(_rows(lines, sizes)):
        a, b = lines.segments[number]
        skip = (first[a], first[b]) if first[a] + first[b] < 0.9 * length else (0.0, 0.0)
        growth = _Growth(
            length - skip[0] - skip[1],
            min(cap, at_start + grading * skip[0]),
            min(cap, at_end + grading * skip[1]),
            cap,
            grading,
        )
        s = skip[0] + growth.positions()
        s = s[(0 if skip[0] else 1) : (len(s) if skip[1] else -1)]
        chain = np.concatenate([[a], count + np.arange(len(s)), [b]])
        parts.append(np.stack([chain[:-1], chain[1:]], axis=1))
        start, end = lines.corners[a], lines.corners[b]
        points.append(start + (end - start) * (s / length)[:, None])
        wanted.append(np.minimum(np.minimum(at_start + grading * s, at_end + grading * (length - s)), cap))
        of.append(np.full(len(s), number))
        count += len(s)
    return Divided(
        np.concatenate(points),
        np.concatenate(wanted),
        np.concatenate(of).astype(np.int32),
        np.concatenate(parts).astype(np.int32),
    )


def _rows(lines: Linework, sizes: Array) -> Array:
    """Per segment: its length, sizes at both ends, and the size along it."""
    at_ends = np.minimum(sizes[lines.segments], lines.sizes[:, None])
    return np.column_stack([_lengths(lines), at_ends, lines.sizes])


def _first_steps(lines: Linework, sizes: Array, lengths: Array) -> Array:
    """Distance of the first points on segments from each corner where two meet at an acute angle; 0 elsewhere."""
    steps = np.zeros(len(lines.corners))
    corner = lines.segments.ravel()
    ends = lines.corners[lines.segments]
    away = (ends[:, ::-1] - ends).reshape(-1, 2)
    direction = np.arctan2(away[:, 1], away[:, 0])
    order = np.lexsort((direction, corner))
    starts = np.flatnonzero(np.diff(corner[order], prepend=-1))
    for group in np.split(order, starts[1:]):
        gaps = np.diff(direction[group], append=direction[group[0]] + 2.0 * np.pi)
        if len(group) > 1 and gaps.min() < _ACUTE:
            at = corner[group[0]]
            steps[at] = min(sizes[at], lengths[group // 2].min() / 3.0)
    return steps


class _Growth:
    """Steps along a segment whose length grows from both ends up to `cap`: the integral of 1 / size."""

    def __init__(self, length: float, at_start: float, at_end: float, cap: float, grading: float) -> None:
        self.length, self.at_start, self.at_end, self.cap, self.grading = (
            length,
            at_start,
            at_end,
            cap,
            grading,
        )
        meeting = 0.5 * (length + (at_end - at_start) / grading)
        self.grown = max(0.0, min((cap - at_start) / grading, meeting, length))
        self.shrinks = min(length, max(self.grown, length - max(0.0, (cap - at_end) / grading)))
        self.first = self._steps(self.grown, at_start)
        self.middle = (self.shrinks - self.grown) / cap
        self.total = float(self.first + self.middle + self._steps(length - self.shrinks, at_end))

    def _steps(self, distance: float, size: float) -> float:
        return float(np.log1p(self.grading * distance / size) / self.grading)

    def _distance(self, steps: Array, size: float) -> Array:
        return np.asarray(size * np.expm1(self.grading * steps) / self.grading)

    def positions(self) -> Array:
        """From 0 to the length, as many equal steps as are needed."""
        count = max(1, int(np.ceil(self.total - 1e-6)))
        steps = self.total * (np.arange(count + 1) / count)
        before = self._distance(np.minimum(steps, self.first), self.at_start)
        middle = np.clip(steps - self.first, 0.0, self.middle) * self.cap
        after = self.length - self._distance(np.minimum(self.total - steps, self.total), self.at_end)
        s = np.where(steps <= self.first + self.middle, before + middle, after)
        s[0], s[-1] = 0.0, self.length
        return s

"""From polygons to lines that a mesher can take: every meeting of lines is a point, and points lie as close as cells
shall be.

In: outlines that were checked, in any unit. Out: corners, segments between them, and points on these, in that unit.
Never: cells.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from lamc.basics.checks import Array

Integers = NDArray[np.int32]

_ACUTE = np.radians(
    60.0
)  # between segments: below this, splits of one would call for splits of the other for ever
_ROOM = 0.9  # of a segment's length: first steps from both ends that take more are not taken


BORDER, REGION, FREE = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Path:
    """A chain of points; a ring ends where it begins, and one point alone is a corner."""

    points: Array  # (k, 2)
    kind: int  # BORDER of the plate, ring of a REGION, or FREE inside one
    size: float  # wanted length of edges: in the region, or where there is none


@dataclass(frozen=True, eq=False)
class Linework:
    """Corners and the segments between them, no two of which cross or lie upon each other."""

    corners: Array  # (c, 2)
    segments: Integers  # (s, 2), rows of corners, the lower first
    sizes: Array  # (s,), wanted length of edges along each
    limits: Array  # (c,), wanted length of edges at corners of no segment; inf at others


@dataclass(frozen=True, eq=False)
class Divided:
    """Corners, then points on segments."""

    points: Array  # (n, 2)
    sizes: Array  # (n,), wanted length of edges there
    segment_of: Integers  # (n,), -1 for corners
    parts: Integers  # (p, 2), rows of points


def linework(paths: Sequence[Path], tolerance: float) -> Linework:
    """All paths, cut where corners of others lie on them.

    Corners nearer than `tolerance` to each other become one, and a corner that near to a segment lies on it: what
    should coincide but for round-off does.
    """
    counts = [len(path.points) for path in paths]
    corners, index = _merged(np.concatenate([path.points for path in paths]), tolerance)
    owner = np.repeat(np.arange(len(paths)), counts)
    inside = owner[1:] == owner[:-1]
    pairs = np.stack([index[:-1], index[1:]], axis=1)[inside]
    ends, owner = _split_at_corners(corners, pairs, owner[1:][inside], tolerance)
    segments, of = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    kind = np.array([path.kind for path in paths])[owner]
    size = np.array([path.size for path in paths])
    # The plate's border has a region on one side, or none; rings of regions have another on the other side, or none.
    at_border = np.bincount(of[kind == BORDER], minlength=len(segments)) > 0
    in_regions = np.bincount(of[kind == REGION], minlength=len(segments))
    outer = np.array([path.size for path in paths if path.kind == BORDER]).min()
    wanted = np.where(in_regions + at_border == 1, outer, np.inf)
    np.minimum.at(wanted, of[kind != BORDER], size[owner[kind != BORDER]])
    limits = np.full(len(corners), np.inf)
    alone = np.array(counts) == 1
    np.minimum.at(limits, index[np.cumsum(counts)[alone] - 1], size[alone])
    limits[np.unique(segments)] = np.inf
    return Linework(corners, segments.astype(np.int32), wanted, limits)


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
    """Wanted length of edges at the corners, shape (c,): not more than at any segment there, nor than the segment's
    length, and growing along segments by `grading` per length at most."""
    count = len(lines.corners)
    lengths = _lengths(lines)
    own = lines.limits.copy()
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
    none = np.zeros(lines.segments.shape)
    return float(_growth(lines, sizes, none, grading).total.sum())


def divide(lines: Linework, sizes: Array, grading: float) -> Divided:
    """Points on the segments, as far apart as `sizes` at the corners and the sizes along segments ask for.

    Segments that meet at an acute angle get their first points at the same distance from the corner.
    """
    lengths = _lengths(lines)
    skips = _first_steps(lines, sizes, lengths)[lines.segments]
    skips[skips.sum(axis=1) >= _ROOM * lengths] = 0.0
    growth = _growth(lines, sizes, skips, grading)
    points, wanted, of, parts = [lines.corners], [sizes], [np.full(len(sizes), -1)], []
    whole = (growth.counts == 1) & (skips == 0.0).all(axis=1)
    parts.append(lines.segments[whole])
    count = len(lines.corners)
    for number in np.flatnonzero(~whole).tolist():
        a, b = lines.segments[number]
        s = skips[number, 0] + growth.positions(number)
        s = s[(0 if skips[number, 0] else 1) : (len(s) if skips[number, 1] else -1)]
        chain = np.concatenate([[a], count + np.arange(len(s)), [b]])
        parts.append(np.stack([chain[:-1], chain[1:]], axis=1))
        start, end, length = lines.corners[a], lines.corners[b], lengths[number]
        points.append(start + (end - start) * (s / length)[:, None])
        from_ends = np.minimum(sizes[a] + grading * s, sizes[b] + grading * (length - s))
        wanted.append(np.minimum(from_ends, lines.sizes[number]))
        of.append(np.full(len(s), number))
        count += len(s)
    return Divided(
        np.concatenate(points),
        np.concatenate(wanted),
        np.concatenate(of).astype(np.int32),
        np.concatenate(parts).astype(np.int32),
    )


def _first_steps(lines: Linework, sizes: Array, lengths: Array) -> Array:
    """Distance of the first points on segments from each corner where two meet at an acute angle; 0 elsewhere."""
    corner = lines.segments.ravel()
    ends = lines.corners[lines.segments]
    away = (ends[:, ::-1] - ends).reshape(-1, 2)
    direction = np.arctan2(away[:, 1], away[:, 0])
    order = np.lexsort((direction, corner))
    starts = np.flatnonzero(np.diff(corner[order], prepend=-1))
    angle = np.diff(direction[order], append=0.0)
    last = np.append(starts[1:], len(order)) - 1
    angle[last] = direction[order[starts]] + 2.0 * np.pi - direction[order[last]]
    acute = (np.minimum.reduceat(angle, starts) < _ACUTE) & (last > starts)
    shortest = np.minimum.reduceat(lengths[order // 2], starts)
    at = corner[order[starts]]
    steps = np.zeros(len(lines.corners))
    steps[at] = np.where(acute, np.minimum(sizes[at], shortest / 3.0), 0.0)
    return steps


def _growth(lines: Linework, sizes: Array, skips: Array, grading: float) -> "_Growth":
    """Of what is left of the segments when `skips`, shape (s, 2), are taken from their ends."""
    cap = lines.sizes
    start, end = (np.minimum(cap, sizes[lines.segments[:, k]] + grading * skips[:, k]) for k in (0, 1))
    return _Growth(_lengths(lines) - skips.sum(axis=1), start, end, cap, grading)


class _Growth:
    """Steps along segments that grow from both ends up to `cap`: `total` is the integral of 1 / size, shape (s,)."""

    def __init__(self, length: Array, at_start: Array, at_end: Array, cap: Array, grading: float) -> None:
        self.length, self.at_start, self.at_end, self.cap, self.grading = (
            length,
            at_start,
            at_end,
            cap,
            grading,
        )
        meeting = 0.5 * (length + (at_end - at_start) / grading)
        grown = np.clip(np.minimum((cap - at_start) / grading, meeting), 0.0, length)
        shrinks = np.clip(length - (cap - at_end) / grading, grown, length)
        self.first = np.log1p(grading * grown / at_start) / grading
        self.middle = (shrinks - grown) / cap
        self.total = self.first + self.middle + np.log1p(grading * (length - shrinks) / at_end) / grading

    @cached_property
    def counts(self) -> NDArray[np.int64]:
        """Steps along each segment."""
        return np.asarray(np.maximum(1, np.ceil(self.total - 1e-6)).astype(np.int64))

    def positions(self, number: int) -> Array:
        """From 0 to the length of one segment, equal steps in the integral."""
        count, total, first = self.counts[number], self.total[number], self.first[number]
        last = total - first - self.middle[number]
        steps = total * (np.arange(count + 1) / count)
        before = self._distance(np.minimum(steps, first), self.at_start[number])
        middle = np.clip(steps - first, 0.0, self.middle[number]) * self.cap[number]
        after = self.length[number] - self._distance(np.minimum(total - steps, last), self.at_end[number])
        s = np.where(steps <= first + self.middle[number], before + middle, after)
        s[0], s[-1] = 0.0, self.length[number]
        return np.asarray(s)

    def _distance(self, steps: Array, size: float) -> Array:
        return np.asarray(size * np.expm1(self.grading * steps) / self.grading)

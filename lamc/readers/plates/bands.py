"""Which parts of a line run along segments, by arithmetic: bands are thin, and overlaying many of them takes minutes.

In: corners of lines, segments as pairs of ends, m; the half width of the band around these. Out: parts of lines, the
nearest place. Never: shapes with an area.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely.geometry import LineString
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array


class Band:
    """What is within `near`, m, of `segments` (k, 2, 2); points are segments without a length."""

    def __init__(self, segments: Array, near: float) -> None:
        self.segments, self.near = segments, near
        self._tree = shapely.STRtree(shapely.linestrings(segments))

    def cut(self, parts: Sequence[BaseGeometry]) -> tuple[list[BaseGeometry], list[BaseGeometry]]:
        """What of lines and points is beyond the band, and what within: lines in pieces, in their order."""
        beyond: list[BaseGeometry] = []
        within: list[BaseGeometry] = []
        for part in parts:
            line = shapely.get_coordinates(part)
            if len(line) == 1:
                (within if self.nearest(line[0])[1] <= self.near else beyond).append(part)
                continue
            step = np.hypot(*np.diff(line, axis=0).T)
            at = np.concatenate([[0.0], np.cumsum(step)])
            left = 0.0
            for enters, leaves in self._stays(line, at, step):
                if enters > left:
                    beyond.append(_between(line, at, left, enters))
                within.append(_between(line, at, enters, leaves))
                left = leaves
            if left < at[-1]:
                beyond.append(_between(line, at, left, at[-1]))
        return beyond, within

    def nearest(self, point: Array) -> tuple[Array, float]:
        """The place (2,) on the segments that is nearest to `point` (2,), and how far that is, m; inf without any."""
        if not len(self.segments):
            return point, np.inf
        start, along = self.segments[:, 0], self.segments[:, 1] - self.segments[:, 0]
        square = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
        part = np.clip(((point - start) * along).sum(axis=1) / square, 0.0, 1.0)
        places = start + part[:, None] * along
        far = np.hypot(*(places - point).T)
        first = int(np.argmin(far))
        return places[first], float(far[first])

    def _stays(self, line: Array, at: Array, step: Array) -> list[tuple[float, float]]:
        """Where along the line it is within, from and to, m; in order, without overlaps."""
        a, b = line[:-1], line[1:]
        low, high = np.minimum(a, b) - self.near, np.maximum(a, b) + self.near
        i, j = self._tree.query(shapely.box(*low.T, *high.T))
        enters, leaves = _stay(a[i], (b[i] - a[i]) / step[i, None], self.segments[j], self.near)
        enters, leaves = np.maximum(enters, 0.0), np.minimum(leaves, step[i])
        met = enters <= leaves
        stays = sorted(zip((at[i] + enters)[met].tolist(), (at[i] + leaves)[met].tolist(), strict=True))
        found: list[tuple[float, float]] = []
        for first, last in stays:
            if found and first <= found[-1][1]:
                found[-1] = (found[-1][0], max(last, found[-1][1]))
            else:
                found.append((first, last))
        return found


def _stay(start: Array, along: Array, segments: Array, near: float) -> tuple[Array, Array]:
    """Lengths (k,) at which rays, from `start` (k, 2) in unit directions `along`, enter and leave what is within `near`
    of their segments (k, 2, 2), which is convex: two disks and the strip between; inf and -inf if never."""
    enters, leaves = np.full(len(start), np.inf), np.full(len(start), -np.inf)
    for end in (segments[:, 0], segments[:, 1]):
        ahead = ((end - start) * along).sum(axis=1)
        half = np.sqrt(np.maximum(near**2 - _cross(along, end - start) ** 2, 0.0))
        meets = np.abs(_cross(along, end - start)) <= near
        enters = np.where(meets, np.minimum(enters, ahead - half), enters)
        leaves = np.where(meets, np.maximum(leaves, ahead + half), leaves)
    axis = segments[:, 1] - segments[:, 0]
    length = np.hypot(*axis.T)
    axis /= np.maximum(length, np.finfo(float).tiny)[:, None]
    rises = _cross(axis, along)
    for side in (-near, near):
        with np.errstate(divide="ignore", invalid="ignore"):  # beside parallel ones there is no crossing
            crossing = (side - _cross(axis, start - segments[:, 0])) / rises
            foot = ((start + crossing[:, None] * along - segments[:, 0]) * axis).sum(axis=1)
        meets = (foot >= 0.0) & (foot <= length) & np.isfinite(crossing)
        enters = np.where(meets, np.minimum(enters, crossing), enters)
        leaves = np.where(meets, np.maximum(leaves, crossing), leaves)
    return enters, leaves


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _between(line: Array, at: Array, first: float, last: float) -> LineString:
    """The part of a line (n, 2), whose corners are `at` (n,) along it, from `first` to `last`, m."""
    ends = [np.array([np.interp(s, at, x) for x in line.T]) for s in (first, last)]
    return LineString([ends[0], *line[(at > first) & (at < last)], ends[1]])

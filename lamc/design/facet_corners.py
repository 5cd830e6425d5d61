"""Facets as polygons: their corners, and the shortest diagonals that part them into triangles.

In: hinge lines about a body, and its outline. Out: corners (n, 2), m, counterclockwise, and pairs of them. Never: cuts
material, knows masses or materials.

Corners are where hinge lines end, so that a diagonal runs through the same vertices as they do, and where a free edge
turns. What is no convex polygon by these corners has none.
"""

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon

from lamc.records.mechanism import Array

TURN = math.radians(10.0)  # of a free edge: what turns less is a curve drawn in short pieces, or straight
NEAR = 2.0  # hinge widths from the end of a hinge line: corners there are those of the hole about it
COVERED = 0.9  # of the outline, at least, lies within the corners of a facet that is the polygon they span
_TIE = 1e-9  # of a length: diagonals as alike as this are told apart by where they lie


def corners_of(outline: Polygon, lines: Sequence[LineString], width: float) -> Array | None:
    """Corners (n, 2) of the facet of this outline between hinge lines, or None where they span no convex polygon.

    width  m, of the widest hinge
    """
    ends = np.array([end for line in lines for end in line.coords])
    tips = _distinct(np.concatenate([ends, _free_corners(outline, lines, width)]), width)
    hull = shapely.convex_hull(shapely.multipoints(tips))
    if not isinstance(hull, Polygon) or shapely.intersection(hull, outline).area < COVERED * outline.area:
        return None
    ring = np.array(hull.exterior.coords)[:-1]
    within = [tip for tip in tips if hull.exterior.distance(shapely.Point(tip)) > width]
    if within:
        return None  # an end of a hinge line inside: the facet is not convex
    ring = ring if hull.exterior.is_ccw else ring[::-1]
    turns = _turns(ring)
    return np.asarray(ring[turns > TURN]) if (turns > TURN).sum() >= 3 else None


def shortest_diagonals(corners: Array) -> list[tuple[int, int]]:
    """Pairs of corners (i, j), i < j, that part a convex polygon into triangles: the shortest diagonal first, then the
    shortest that crosses none."""
    count = len(corners)
    apart = [(i, j) for i, j in combinations(range(count), 2) if 1 < j - i < count - 1]
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))

    def key(pair: tuple[int, int]) -> tuple[float, ...]:
        ends = sorted(corners[list(pair)].tolist())
        length = math.dist(*ends)
        return (round(length / size / _TIE), *(round(x / size / _TIE) for end in ends for x in end))

    chosen: list[tuple[int, int]] = []
    for i, j in sorted(apart, key=key):
        if not any((i < a < j) != (i < b < j) and len({i, j, a, b}) == 4 for a, b in chosen):
            chosen.append((i, j))
    return chosen


def triangle_corners(count: int, diagonals: Sequence[tuple[int, int]], pair: tuple[int, int]) -> list[int]:
    """The two corners that make triangles with a diagonal, one on either side."""
    edges = {tuple(sorted((k, (k + 1) % count))) for k in range(count)} | set(diagonals)
    return [
        k for k in range(count) if k not in pair and all(tuple(sorted((k, end))) in edges for end in pair)
    ]


def _free_corners(outline: Polygon, lines: Sequence[LineString], width: float) -> Array:
    """Corners of the outline that are not about hinge lines, (n, 2)."""
    ring = np.array(shapely.simplify(outline.exterior, 0.05 * width).coords)[:-1]
    turning = np.abs(_turns(ring)) > TURN
    points = shapely.points(ring)
    free = shapely.distance(points, shapely.multilinestrings([list(lines)])[0]) > NEAR * width
    return np.asarray(ring[turning & free]).reshape(-1, 2)


def _turns(ring: Array) -> Array:
    """Angles by which the sides of a ring (n, 2) turn at its corners, rad, positive to the left."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    sine = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turns: Array = np.arctan2(sine, (before * after).sum(axis=1))
    return turns


def _distinct(points: Array, width: float) -> Array:
    """Points without those nearer than `width` to an earlier one, in order of place."""
    kept: list[list[float]] = []
    for point in sorted(points.tolist()):
        if all(math.dist(point, other) > width for other in kept):
            kept.append(point)
    return np.array(kept)

"""Creases of a flat sheet that cannot fold, whatever pulls at them: those whose vertex has all its creases to one side.

In: edges, what lies beside them, places. Out: edges that stay flat. Never: looks at springs.

Facets about a vertex within a sheet are arcs of a closed chain on a sphere, 2 π in all. Where one of them is longer
than π, the others are as long as the way between its ends is, and lie straight; where it is π, its ends are opposite,
and the others lie straight too, on any half circle: the two creases beside it fold as one line, those between do not.
"""

from collections.abc import Sequence

import numpy as np

from lamc.readers.fold_faces import aside
from lamc.readers.fold_file import FoldFrame
from lamc.records.mechanism import Array

STRAIGHT = (
    1e-3  # rad: creases that are nearer to one line are drawn as one, as loops may be off by such a share
)
RIGID = "FJ"  # kinds that are no hinges


def locked_creases(frame: FoldFrame, joined: Sequence[int], points: Array) -> list[int]:
    """Numbers of edges, ascending. joined: edges along which two facets hold together; points (n, 2): of vertices."""
    within, at = set(joined), _edges_at(frame)
    hinged = {k for k in joined if frame.kinds[k] not in RIGID}
    inner = [v for v, around in at.items() if all(k in within for k in around)]
    locked: set[int] = set()
    waiting = [v for v in inner if hinged & set(at[v])]
    while waiting:
        found: set[int] = set()
        for v in waiting:
            creases = [k for k in at[v] if k in hinged]
            found |= _stuck(frame, v, creases, points)
        hinged -= found
        locked |= found
        ends = {v for k in found for v in frame.edges[k]}
        waiting = [v for v in inner if v in ends and hinged & set(at[v])]
    return sorted(locked)


def _edges_at(frame: FoldFrame) -> dict[int, list[int]]:
    found: dict[int, list[int]] = {}
    for k, ends in enumerate(frame.edges):
        for v in ends:
            found.setdefault(v, []).append(k)
    return found


def _stuck(frame: FoldFrame, vertex: int, creases: Sequence[int], points: Array) -> set[int]:
    """Of the creases at a vertex, those that stay flat. Two that are pieces of one hinge are in line."""
    others = [sum(frame.edges[k]) - vertex for k in creases]
    if len(creases) == 2 and aside(points[vertex], *points[others]) <= frame.off:
        return set()
    x, y = (points[others] - points[vertex]).T
    order = np.argsort(np.arctan2(y, x), kind="stable")
    angles = np.arctan2(y, x)[order]
    gaps = np.diff(np.append(angles, angles[0] + 2.0 * np.pi))
    widest = int(gaps.argmax())
    if gaps[widest] > np.pi + STRAIGHT:
        return set(creases)
    if gaps[widest] < np.pi - STRAIGHT:
        return set()
    line = {int(order[widest]), int(order[(widest + 1) % len(order)])}
    return {k for i, k in enumerate(creases) if i not in line}

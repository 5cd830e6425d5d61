"""Which cell of an exported plate is under a point: a tree of cuts along x and y, and the cells near each leaf.

In: a problem, and the order of its cells in C. Out: tables that C looks a point up in. Never: shape functions.

The tree is a k-d tree (J. L. Bentley, Comm. ACM 18, 1975) whose leaves hold the cells that touch them; those of a leaf
stand in the order of the mesh, so that a point on an edge belongs in C to the cell that it belongs to in
`Places.cells_under`: the first that holds it.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.plates.meshing.locate import TOLERANCE
from lamc.plates.meshing.mesh import Integers
from lamc.plates.problem import Problem

_FEW = 20  # cells of a leaf that is not cut: with fewer, more of them stand in several leaves
_GAIN = 0.75  # of the cells of a leaf that may be left to the larger side of a cut
LEAF = 2  # axis of a node that is not cut


@dataclass(frozen=True, eq=False)
class PointTables:
    """Of n nodes, the root first.

    low, high  (2,), m: no point of the plate is beyond
    axis   (n,): 0, cut along x; 1, along y; LEAF
    at     (n,): where, m
    following  (n,): the node below the cut, which the one above follows; of a leaf, its number
    begins  (leaves + 1,): where the cells of each leaf begin in `cells`, which are numbered as in C
    depth  cuts on the way to a leaf, at most; `most` cells near one, at most
    inside   m: a cell has the points that are no further outside of it
    outside  m: and the plate those that are no further from its boundary
    """

    low: Array
    high: Array
    axis: tuple[int, ...]
    at: tuple[float, ...]
    following: tuple[int, ...]
    begins: Integers
    cells: Integers
    depth: int
    most: int
    inside: float
    outside: float


def point_tables(problem: Problem, order: Integers) -> PointTables:
    """Of the mesh of `problem`, whose cell order[k] is cell k in C."""
    corners = problem.mesh.corners
    low, high = corners.min(axis=1), corners.max(axis=1)
    inside = TOLERANCE * float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))
    outside = problem.places.tolerance
    margin = 2.0 * max(inside, outside)
    boxes = np.stack([low - margin, high + margin])
    axis, at, following = [LEAF], [0.0], [0]
    leaves: list[Integers] = []
    depth = 0
    waiting = deque([(0, np.arange(len(corners), dtype=np.int32), 0)])
    while waiting:
        node, cells, cuts = waiting.popleft()
        depth = max(depth, cuts)
        found = _cut(boxes[:, cells])
        if found is None:
            following[node] = len(leaves)
            leaves.append(cells)
            continue
        axis[node], at[node] = found
        first = following[node] = len(axis)
        axis += [LEAF, LEAF]
        at += [0.0, 0.0]
        following += [0, 0]
        low, high = boxes[:, cells, axis[node]]
        waiting.append((first, cells[low <= at[node]], cuts + 1))
        waiting.append((first + 1, cells[high >= at[node]], cuts + 1))
    place = np.empty(len(order), dtype=np.int32)
    place[order] = np.arange(len(order), dtype=np.int32)
    counts = [len(cells) for cells in leaves]
    return PointTables(
        low=boxes[0].min(axis=0),
        high=boxes[1].max(axis=0),
        axis=tuple(axis),
        at=tuple(at),
        following=tuple(following),
        begins=np.cumsum([0, *counts]).astype(np.int32),
        cells=place[np.concatenate(leaves)],
        depth=depth,
        most=max(counts),
        inside=inside,
        outside=outside,
    )


def _cut(boxes: Array) -> tuple[int, float] | None:
    """Axis and place of the cut that halves the cells best, where one does, from their lower and upper corners (2, k,
    2)."""
    low, high = boxes
    count = len(low)
    if count <= _FEW:
        return None
    at = np.median(0.5 * (low + high), axis=0)
    larger = np.maximum((low <= at).sum(axis=0), (high >= at).sum(axis=0))
    axis = int(np.argmin(larger))
    return (axis, float(at[axis])) if larger[axis] <= _GAIN * count else None

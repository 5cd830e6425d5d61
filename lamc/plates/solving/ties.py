"""What the sides of hinge lines have in common: equations between the copies of a node, and what they leave free.

In: unknowns with copies along hinge lines. Out: for every node of several parts, orthonormal columns of the slopes that
its parts may have together; rows of all differences that stay zero. Never: supports, stiffness.

Displacements of all copies are one. Of the slopes, that along a hinge is the same on both of its sides: t · (θ_left -
θ_right) = 0, where t is the mean direction of the edges that lie between the same two parts, and both directions where
these turn by 30° or more. What is left is the mean slope, two amounts, and jumps: one for a line that passes, none
where it ends inside the plate, and where n lines meet what closes around the point, Σ φ_j n_j = 0.
"""

from dataclasses import dataclass
from math import radians, tan

import numpy as np
import scipy.sparse as sp

from lamc.basics.checks import Array
from lamc.plates.dofs import Dofs
from lamc.plates.meshing.mesh import Integers
from lamc.plates.solving.blocks import Indices, groups
from lamc.plates.solving.directions import PARALLEL, gram, principal
from lamc.plates.solving.hinge_sides import HingeSides, hinge_sides

_CORNER = 30.0  # degrees: lines that turn by more cannot fold there
_NONE = 1e-9  # singular values of unit rows that are dependent
_SLOPE = 3  # column of w_x in the table of unknowns


@dataclass(frozen=True, eq=False)
class Joint:
    """A node and its copies.

    nodes    (s,), ascending; the first is the original
    columns  (2s, f) orthonormal: slopes (w_x, w_y of one copy after the other) that hold together; the first two move
             all alike, the others are jumps
    """

    nodes: Integers
    columns: Array


@dataclass(frozen=True, eq=False)
class Ties:
    """Of all hinge lines.

    joints  in the order of their first nodes
    rows    (t, N) sparse: differences of unknowns that stay zero, each between two nodes
    pairs   (t, 2): these nodes
    """

    joints: tuple[Joint, ...]
    rows: sp.csr_array
    pairs: Integers


def ties(dofs: Dofs) -> Ties:
    """Between the copies of `dofs`; none without hinges."""
    copies = np.flatnonzero(dofs.origin != np.arange(len(dofs.origin)))
    if not len(copies):
        return Ties((), sp.csr_array((0, dofs.count)), np.zeros((0, 2), dtype=np.int32))
    pairs, directions = _held(hinge_sides(dofs))
    rows, between = _rows(dofs, copies.astype(np.int32), pairs, directions)
    return Ties(_joints(dofs, copies, pairs, directions), rows, between)


def _joints(dofs: Dofs, copies: Indices, pairs: Integers, directions: Array) -> tuple[Joint, ...]:
    """Of nodes of which there are `copies`."""
    originals, joint = np.unique(dofs.origin[copies], return_inverse=True)
    count = len(originals)
    members = np.concatenate([originals, copies]).astype(np.int32)
    nodes_of = [members[k] for k in groups(np.concatenate([np.arange(count), joint]), count)]
    rows_of = groups(np.searchsorted(originals, dofs.origin[pairs[:, 0]]), count)
    plain = [k for k in range(count) if len(nodes_of[k]) == 2 and len(rows_of[k]) == 1]
    columns = dict(zip(plain, _fold_columns(directions[[rows_of[k][0] for k in plain]]), strict=True))
    for k in range(count):
        if k not in columns:
            columns[k] = _columns(nodes_of[k], pairs[rows_of[k]], directions[rows_of[k]])
    return tuple(Joint(nodes_of[k], columns[k]) for k in range(count))


def _fold_columns(directions: Array) -> Array:
    """Where a line passes, of two nodes each, (k, 4, 3): see `Joint`. Nearly all are such, and are made at once."""
    columns = np.zeros((len(directions), 4, 3))
    columns[:, (0, 1, 2, 3), (0, 1, 0, 1)] = 1.0 / np.sqrt(2.0)
    x, y = directions.T
    columns[:, :, 2] = np.stack([-y, x, y, -x], axis=1) / np.sqrt(2.0)
    return columns


def _held(sides: HingeSides) -> tuple[Integers, Array]:
    """Pairs of nodes (k, 2), the lower first, and directions (k, 2) along which their slopes agree."""
    ends = sides.nodes.transpose(0, 2, 1)  # (h, q, 2)
    outwards = np.repeat(sides.along[:, None], ends.shape[1], axis=1)
    outwards[:, -1] *= -1.0
    several = ends[..., 0] != ends[..., 1]
    pair, outwards = np.sort(ends[several], axis=1), outwards[several]
    known, group = np.unique(pair, axis=0, return_inverse=True)
    group = group.ravel()
    first, second, ratio = principal(gram(outwards, group, len(known)))
    count = np.bincount(group, minlength=len(known))
    total = np.stack([np.bincount(group, part, len(known)) for part in outwards.T], axis=1)
    folded = (count > 1) & (np.linalg.norm(total, axis=1) > 1.0) & (ratio > PARALLEL)  # back along itself
    corner = (ratio > tan(radians(_CORNER / 2.0)) ** 2) | folded
    return np.concatenate([known, known[corner]]), np.concatenate([first, second[corner]])


def _columns(nodes: Integers, pairs: Integers, directions: Array) -> Array:
    """See `Joint`."""
    count = len(nodes)
    means: Array = np.tile(np.eye(2), (count, 1)) / np.sqrt(count)
    if count == 2 and len(directions) > 1:  # without the round-off of a decomposition
        return means
    held = np.zeros((len(pairs), count, 2))
    place = np.searchsorted(nodes, pairs)
    held[np.arange(len(pairs)), place[:, 0]] = directions
    held[np.arange(len(pairs)), place[:, 1]] = -directions
    _, values, right = np.linalg.svd(np.vstack([means.T, held.reshape(len(pairs), -1)]))
    return np.asarray(np.column_stack([means, right[int(np.count_nonzero(values > _NONE)) :].T]))


def _rows(dofs: Dofs, copies: Integers, pairs: Integers, directions: Array) -> tuple[sp.csr_array, Integers]:
    """Displacements of each copy less those of its original; slopes of each pair along its direction."""
    columns, data, between = [], [], []
    one = dofs.origin[copies]
    for column in range(_SLOPE):
        there = dofs.table[copies, column] >= 0
        both = np.stack([dofs.table[one[there], column], dofs.table[copies[there], column]], axis=1)
        columns.append(np.concatenate([both, both], axis=1))
        data.append(np.tile([1.0, -1.0, 0.0, 0.0], (len(both), 1)))
        between.append(np.stack([one[there], copies[there]], axis=1))
    x, y = dofs.table[pairs, _SLOPE], dofs.table[pairs, _SLOPE + 1]
    columns.append(np.concatenate([x, y], axis=1))
    dx, dy = directions.T
    data.append(np.stack([dx, -dx, dy, -dy], axis=1))
    between.append(pairs)
    index, values = np.concatenate(columns), np.concatenate(data)
    number = np.repeat(np.arange(len(index)), 4)
    rows = sp.csr_array(
        sp.coo_array((values.ravel(), (number, index.ravel())), shape=(len(index), dofs.count))
    )
    return rows, np.concatenate(between).astype(np.int32)

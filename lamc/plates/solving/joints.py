"""Supports where hinge lines give a point several nodes.

In: what supports ask of the slopes of such nodes, and what these have in common. Out: orthonormal rows that are held
and columns that are free, node by node. Never: which support asks what.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from lamc.basics.checks import Array
from lamc.plates.dofs import Dofs
from lamc.plates.meshing.mesh import Integers
from lamc.plates.solving.ties import Joint, Ties

_NEW = 1e-6  # of a unit row, what is left of it without those before, for it to hold something more
_SAME = 1e-9  # of values, relative
_SLOPE = 3  # column of w_x in the table of unknowns


@dataclass(frozen=True, eq=False)
class JointRows:
    """What is held of one joint's slopes.

    fixed   (c, 2s) orthonormal rows; values (c,)
    first   (c,): for each row the equation that asks for it
    free    (2s, f) orthonormal columns
    wrong   an equation that contradicts the others, -1 where none does
    """

    fixed: Array
    values: Array
    first: list[int]
    free: Array
    wrong: int


def held(joint: Joint, asked: Array, value: Array) -> JointRows:
    """Under the equations `asked` (k, 2s) · slopes = `value` (k,), in the order in which they count."""
    inside = asked @ joint.columns  # what of them concerns slopes that the joint allows
    rows: list[Array] = []
    first: list[int] = []
    for k, row in enumerate(inside):
        size, left = np.linalg.norm(asked[k]), row.copy()
        for _ in range(2):  # twice, for digits
            left -= sum((before * (before @ left) for before in rows), np.zeros_like(left))
        if np.linalg.norm(left) > _NEW * size:
            rows.append(left / np.linalg.norm(left))
            first.append(k)
    amounts = (
        np.linalg.lstsq(inside, value, rcond=_SAME)[0] if len(inside) else np.zeros(joint.columns.shape[1])
    )
    misfit = np.abs(inside @ amounts - value)
    size = np.abs(value).max(initial=0.0)
    wrong = int(np.argmax(misfit)) if len(value) and misfit.max() > _SAME * size else -1
    fixed = np.array(rows).reshape(-1, joint.columns.shape[1])
    free = joint.columns
    if len(fixed):
        _, _, right = np.linalg.svd(fixed)
        free = joint.columns @ right[len(fixed) :].T
    return JointRows(fixed @ joint.columns.T, fixed @ amounts, first, free, wrong)


def spread(dofs: Dofs, tied: Ties) -> tuple[sp.csr_array, Array]:
    """What makes all copies move as their original does: (N, N), columns orthonormal or zero, and whether a column is
    there, (N,); slopes of joints are none of them."""
    there, weight = np.ones(dofs.count, dtype=bool), np.ones(dofs.count)
    every: Integers = np.arange(dofs.count, dtype=np.int32)
    nodes = _nodes(tied)
    origin, several = dofs.origin[nodes], np.bincount(dofs.origin)
    moves, first = dofs.table[nodes, :_SLOPE], dofs.table[origin, :_SLOPE]
    has = first >= 0
    weight[moves[has]] = np.broadcast_to(1.0 / np.sqrt(several[origin])[:, None], has.shape)[has]
    copied = has & (nodes != origin)[:, None]
    there[slope_numbers(dofs, tied)], there[moves[copied]] = False, False
    row, column = np.concatenate([every, moves[copied]]), np.concatenate([every, first[copied]])
    kept = there[column]
    entries = (weight[column[kept]], (row[kept], column[kept]))
    return sp.csr_array(sp.coo_array(entries, shape=(dofs.count,) * 2)), there


def slope_numbers(dofs: Dofs, tied: Ties) -> Integers:
    """Of the slopes of all joints' nodes, joint by joint, (Σ2s,)."""
    return np.asarray(dofs.table[_nodes(tied), _SLOPE : _SLOPE + 2].ravel())


def _nodes(tied: Ties) -> Integers:
    """Of all joints, one after the other, (Σs,)."""
    return np.concatenate([joint.nodes for joint in tied.joints])

"""What supports hold, made independent, and what they leave free.

In: the equations of a problem's supports. Out: orthonormal rows, one per direction held, with its value and its
support; and orthonormal columns that span the rest. Never: stiffness, loads.

Along hinge lines a point has several nodes, which count as one: what they have in common is part of the columns.

At a node the unknowns (u, v) and (w_x, w_y) are vectors, and a support may hold a part of one along any direction.
Where that is an axis, an unknown is simply fixed; elsewhere the node gets axes of its own.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError, about
from lamc.plates.dofs import Dofs
from lamc.plates.meshing.mesh import Integers
from lamc.plates.problem import Problem
from lamc.plates.solving.blocks import placed
from lamc.plates.solving.directions import PARALLEL, Indices, gram, principal
from lamc.plates.solving.equations import ACROSS, PLANE, SLOPE, Equations, held_curves
from lamc.plates.solving.joints import held, slope_numbers, spread
from lamc.plates.solving.ties import Ties, ties

_FIRST = np.array([0, 2, 3, 5])  # column in the table of unknowns of the first of a kind
_SAME = 1e-9  # of values, relative


@dataclass(frozen=True, eq=False)
class Constraints:
    """What is held, and what is free: every vector of unknowns is free @ y + fixed.T @ values.

    fixed   (c, N) sparse, rows orthonormal; a row concerns one node, with its copies
    values  (c,)
    owners  (c,) index into the problem's supports, the first that holds it; -1: see Equations
    nodes   (c,)
    free    (N, f) sparse, columns orthonormal, in the order of the unknowns; slopes of copies come last
    ties    what copies of nodes have in common; `free` and `fixed` obey it
    """

    fixed: sp.csr_array
    values: Array
    owners: Integers
    nodes: Integers
    free: sp.csr_array
    ties: Ties


def constraints(problem: Problem, equations: Equations) -> Constraints:
    """The equations made independent, node by node; on curved edges the deflection is that on the curve. Raises
    DesignError where two contradict each other."""
    flat = _of_nodes(problem, equations)
    curve = held_curves(problem)
    several = np.bincount(problem.dofs.origin, minlength=len(problem.dofs.origin)) > 1
    columns = problem.dofs.table[curve.nodes][:, [2, 3, 4]]
    moved = np.isin(curve.nodes, flat.nodes[flat.values != 0.0]) | several[problem.dofs.origin[curve.nodes]]
    lie = (columns >= 0).all(axis=1) & (curve.height != 0.0) & ~moved
    if not lie.any():
        return flat
    rotation = _to_curves(columns[lie], curve.across[lie], curve.height[lie], problem.dofs.count)
    return replace(flat, fixed=sp.csr_array(flat.fixed @ rotation), free=sp.csr_array(rotation.T @ flat.free))


def _to_curves(columns: Integers, across: Array, height: Array, count: int) -> sp.csr_array:
    """Orthogonal (N, N): what becomes w of a node is (w + h w_n) / √(1 + h²), with h m the curve's distance along n."""
    cosine, sine = 1.0 / np.hypot(1.0, height), height / np.hypot(1.0, height)
    block = np.tile(np.eye(3), (len(height), 1, 1))
    block[:, 0, 0] = cosine
    block[:, 0, 1:] = sine[:, None] * across
    block[:, 1:, 0] = -sine[:, None] * across
    block[:, 1:, 1:] -= (1.0 - cosine)[:, None, None] * across[:, :, None] * across[:, None]
    ones = np.ones(count)
    ones[columns.ravel()] = 0.0
    rows, others = np.repeat(columns, 3, axis=1).ravel(), np.tile(columns, 3).ravel()
    rotation = sp.coo_array((block.ravel(), (rows, others)), shape=(count, count))
    return sp.csr_array(rotation + sp.diags_array(ones))


def _of_nodes(problem: Problem, equations: Equations) -> Constraints:
    """The equations at nodes as they are."""
    dofs, tied = problem.dofs, ties(problem.dofs)
    there = dofs.table[equations.node, _FIRST[equations.kind]] >= 0
    alone = _alone(dofs, equations, there)
    node, kind, owner = alone.node, alone.kind, alone.owner
    keys, group = np.unique(node.astype(np.int64) * 4 + kind, return_inverse=True)
    count = len(keys)
    sums = gram(alone.direction, group, count)
    first, second, ratio = principal(sums)
    both = ratio > PARALLEL
    first[both], second[both] = (1.0, 0.0), (0.0, 1.0)
    values = _held_values(sums, alone.direction, alone.value, group, first, both)
    _check_agreement(problem, node, alone.direction, alone.value, owner, values[group])
    rows_key = np.concatenate([np.arange(count), np.flatnonzero(both)])
    rows_direction = np.concatenate([first, second[both]])
    rows_owner = _owners(alone.direction, owner, group, rows_key, rows_direction)
    rows_value = np.einsum("ki,ki->k", rows_direction, values[rows_key])
    row_node = (keys[rows_key] // 4).astype(np.int32)
    column = dofs.table[row_node, _FIRST[keys[rows_key] % 4]].astype(np.int64)
    fixed = _pairs(column, rows_direction, dofs.count)
    oblique = ~both[rows_key]
    if not tied.joints:
        free = _free(column, rows_direction, oblique, np.ones(dofs.count, dtype=bool))
        return Constraints(fixed, rows_value, rows_owner, row_node, free, tied)
    wide, present = spread(dofs, tied)
    size = np.asarray(wide.max(axis=0).todense()).ravel()[column]  # 1 over the root of the number of copies
    free = sp.csr_array(wide @ _free(column, rows_direction, oblique, present))
    base = Constraints(sp.csr_array(fixed @ wide.T), rows_value / size, rows_owner, row_node, free, tied)
    return _with_joints(problem, base, equations)


def _alone(dofs: Dofs, equations: Equations, there: Indices) -> Equations:
    """Those that `there` says, without slopes of nodes that have copies; displacements are those of the original."""
    several = np.bincount(dofs.origin, minlength=len(dofs.origin)) > 1
    kept = there & ~((equations.kind == SLOPE) & several[dofs.origin[equations.node]])
    node, kind = equations.node[kept], equations.kind[kept]
    moves = (kind == PLANE) | (kind == ACROSS)
    node = np.where(moves, dofs.origin[node], node).astype(np.int32)
    return Equations(node, kind, equations.direction[kept], equations.value[kept], equations.owner[kept])


def _with_joints(problem: Problem, base: Constraints, equations: Equations) -> Constraints:
    """`base` and the slopes of nodes that have copies."""
    dofs, count = problem.dofs, problem.dofs.count
    fixed: list[Array] = []
    free: list[Array] = []
    values, owners, nodes = [base.values], [base.owners], [base.nodes]
    slopes = np.flatnonzero(equations.kind == SLOPE)
    slopes = slopes[np.argsort(equations.owner[slopes], kind="stable")]
    by_origin: dict[int, list[int]] = {}
    for k, origin in zip(slopes.tolist(), dofs.origin[equations.node[slopes]].tolist(), strict=True):
        by_origin.setdefault(origin, []).append(k)
    for joint in base.ties.joints:
        if int(joint.nodes[0]) not in by_origin:
            fixed.append(np.zeros((0, len(joint.columns))))
            free.append(joint.columns.T)
            continue
        mine = np.array(by_origin[int(joint.nodes[0])], dtype=np.intp)
        asked = np.zeros((len(mine), len(joint.nodes), 2))
        asked[np.arange(len(mine)), np.searchsorted(joint.nodes, equations.node[mine])] = equations.direction[
            mine
        ]
        found = held(joint, asked.reshape(len(mine), 2 * len(joint.nodes)), equations.value[mine])
        if found.wrong >= 0:
            _refuse(problem, equations, mine, int(mine[found.wrong]))
        fixed.append(found.fixed)
        free.append(found.free.T)
        values.append(found.values)
        owners.append(equations.owner[mine[found.first]])
        nodes.append(np.full(len(found.first), joint.nodes[0], dtype=np.int32))
    where = slope_numbers(dofs, base.ties)
    return Constraints(
        sp.csr_array(sp.vstack([base.fixed, placed(fixed, where, count)])),
        np.concatenate(values),
        np.concatenate(owners),
        np.concatenate(nodes),
        sp.csr_array(sp.hstack([base.free, placed(free, where, count).T])),
        base.ties,
    )


def _held_values(
    sums: Array, direction: Array, value: Array, group: Indices, first: Array, both: Indices
) -> Array:
    """The vector that the equations of each group ask for, in the least-squares sense, shape (groups, 2)."""
    count = len(sums)
    right = np.stack([np.bincount(group, direction[:, i] * value, count) for i in (0, 1)], axis=1)
    xx, xy, yy = sums.T
    along = np.einsum("ki,ki->k", first, right)
    size = xx * first[:, 0] ** 2 + 2.0 * xy * first[:, 0] * first[:, 1] + yy * first[:, 1] ** 2
    held = first * (along / size)[:, None]
    determinant = np.where(both, xx * yy - xy * xy, 1.0)
    full = np.stack([yy * right[:, 0] - xy * right[:, 1], xx * right[:, 1] - xy * right[:, 0]], axis=1)
    return np.where(both[:, None], full / determinant[:, None], held)


def _check_agreement(
    problem: Problem, node: Integers, direction: Array, value: Array, owner: Integers, held: Array
) -> None:
    got = np.einsum("ki,ki->k", direction, held)
    wrong = np.flatnonzero(np.abs(got - value) > _SAME * np.maximum(np.abs(value), np.abs(held).max(axis=1)))
    if not len(wrong):
        return
    here = np.flatnonzero(node == node[wrong[0]])
    _refuse(problem, Equations(node, node, direction, value, owner), here, int(wrong[0]))


def _refuse(problem: Problem, equations: Equations, here: Indices, wrong: int) -> None:
    """Raises DesignError: equation `wrong` contradicts another of those `here`."""
    owner, value = equations.owner, equations.value
    rivals = [k for k in here if value[k] != value[wrong]] or [here[0]]
    x, y = problem.dofs.points[equations.node[wrong]]
    texts = [
        f"{type(problem.supports[owner[k]]).__name__} (number {owner[k] + 1}) asks for {value[k]:g}"
        for k in (rivals[0], wrong)
    ]
    with about(problem.supports[max(owner[rivals[0]], owner[wrong])]):  # the later one was added to the other
        raise DesignError(
            f"supports contradict each other at ({x:.6g}, {y:.6g}): {texts[0]}, {texts[1]}; take one of them away, or "
            "make their values agree"
        )


def _owners(
    direction: Array, owner: Integers, group: Indices, rows_key: Indices, rows_direction: Array
) -> Integers:
    """For every row the support whose equation is most along it; of equals, the first."""
    result = np.empty(len(rows_key), dtype=np.int32)
    count = int(group.max()) + 1 if len(group) else 0
    for rows in np.split(np.arange(len(rows_key)), [count]):
        of_group = np.full(count, -1, dtype=np.int64)
        of_group[rows_key[rows]] = rows
        mine = np.flatnonzero(of_group[group] >= 0)
        row = of_group[group[mine]]
        along = np.abs(np.einsum("ki,ki->k", direction[mine], rows_direction[row]))
        order = np.lexsort((owner[mine], -np.round(along, 6), row))
        first = np.unique(row[order], return_index=True)
        result[first[0]] = owner[mine][order[first[1]]]
    return result


def _pairs(column: Indices, direction: Array, count: int) -> sp.csr_array:
    """Rows with `direction` in `column` and the next, zeros left out."""
    rows = np.repeat(np.arange(len(column)), 2)
    columns = np.stack([column, column + 1], axis=1).ravel()
    data = direction.ravel()
    there = data != 0.0
    return sp.csr_array((data[there], (rows[there], columns[there])), shape=(len(column), count))


def _free(column: Indices, direction: Array, alone: Indices, present: Indices) -> sp.csr_array:
    """Columns for what the rows leave of the unknowns that are `present` (N,): untouched ones, and the normals of rows
    that are oblique."""
    count = len(present)
    touched = ~present
    oblique = alone & (direction != 0.0).all(axis=1)
    for i in (0, 1):
        touched[(column + i)[direction[:, i] != 0.0]] = True
    keeps = ~touched
    keeps[column[oblique] + 1] = True  # the second unknown's place becomes the node's own second axis
    number = np.cumsum(keeps) - 1
    plain = np.flatnonzero(~touched)
    at = column[oblique]
    rows = np.concatenate([plain, at, at + 1])
    columns = number[np.concatenate([plain, at + 1, at + 1])]
    data = np.concatenate([np.ones(len(plain)), -direction[oblique, 1], direction[oblique, 0]])
    return sp.csr_array((data, (rows, columns)), shape=(count, int(np.count_nonzero(keeps))))

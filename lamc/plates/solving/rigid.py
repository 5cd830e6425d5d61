"""Rigid motion that nothing prevents: which pieces of a plate may move, and how.

In: a problem, and the directions held. Out: pieces, the motions left to each and their names; unknowns to pin where a
balanced load acts on a free piece. Never: stiffness.

A piece is what hangs together through its nodes, or by hinge lines: then it has several panels. A panel has three rigid
motions where it bends (it rises, it turns about x and about y) and three where it stretches (it slides, it turns in its
plane); the supports of its nodes, what panels have in common and springs, applied to these exactly, leave a null space.
"""

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.plates.dofs import Dofs
from lamc.plates.elements.definition import DOFS
from lamc.plates.elements.kernels import Numbers
from lamc.plates.meshing.mesh import Integers
from lamc.plates.problem import Problem
from lamc.plates.solving.blocks import groups
from lamc.plates.solving.constraints import Constraints
from lamc.plates.solving.equations import Equations, equations_of, joined
from lamc.plates.solving.panels import Panels, Piece, piece_of
from lamc.plates.solving.springs import Springs

_NOISE = 1e-9  # of the largest force, with the piece's size as the arm: smaller is round-off
_STRAY = 1e-5  # times the next: what forces in the plane may leave across it is 1e-15 of them
_BALANCED = (
    1e-10  # of the sum of what acts, whatever its sign: round-off of a sum of a million terms is below
)


def pieces(
    problem: Problem, constraints: Constraints, rotations: sp.csr_array, hinged: Springs
) -> tuple[Piece, ...]:
    """All pieces, in the order of their first nodes, with the motions that `constraints` leave.

    turns   (k, N) sparse: changes that springs of supports oppose, each of one piece
    hinged  rotations along hinge lines, with springs or without
    """
    dofs, tied = problem.dofs, constraints.ties
    panel, panels = _components(dofs)
    node_of = np.empty(dofs.count, dtype=np.int64)
    node_of[dofs.table[dofs.table >= 0]] = np.nonzero(dofs.table >= 0)[0]
    opposed = hinged.rotations[np.flatnonzero(hinged.stiffness > 0.0)]
    held = sp.csr_array(sp.vstack([constraints.fixed, rotations, tied.rows, opposed]))
    first = [
        constraints.nodes,
        *(node_of[each.indices[each.indptr[:-1]]] for each in (rotations, tied.rows, opposed)),
    ]
    links = (np.ones(len(tied.pairs), dtype=np.int8), tuple(panel[tied.pairs].T))
    graph = sp.coo_array(links, shape=(panels, panels)).tocsr()
    count, group = connected_components(graph, directed=False)
    label = group[panel]
    rows_of = groups(label[np.concatenate(first)], count)
    folds = hinged.rotations[: len(dofs.hinges)]  # at one point of each edge: panels are rigid
    folds_of = groups(label[node_of[folds.indices[folds.indptr[:-1]]]], count)
    titles = [hinge.text for hinge in problem.hinges]
    texts = [titles[owner] for owner in hinged.owners[: len(dofs.hinges)].tolist()]
    found = []
    for k, (nodes, rows, fold) in enumerate(zip(groups(label, count), rows_of, folds_of, strict=True)):
        panels_of = Panels(dofs, nodes, panel[nodes])
        found.append(piece_of((k + 1, count), panels_of, held[rows], folds[fold], [texts[f] for f in fold]))
    return tuple(found)


def _components(dofs: Dofs) -> tuple[Integers, int]:
    """A label for every node, in the order of their first nodes, and how many there are."""
    m, k = dofs.of_nodes.shape
    first = np.repeat(dofs.of_nodes[:, 0], k - 1)
    links = (np.ones(m * (k - 1), dtype=np.int8), (first, dofs.of_nodes[:, 1:].ravel()))
    graph = sp.coo_array(links, shape=(len(dofs.points),) * 2).tocsr()
    count, label = connected_components(graph, directed=False)
    return label, int(count)


def free_text(found: tuple[Piece, ...]) -> str:
    """Which pieces may move, and how: one line."""
    free = [piece for piece in found if piece.names]
    shown = "; ".join(f"{piece.text} may {', may '.join(piece.names)}" for piece in free[:4])
    return shown + (f"; and {len(free) - 4} more pieces" if len(free) > 4 else "")


def check_balance(found: tuple[Piece, ...], loads: Array, dofs: Dofs) -> None:
    """Raises DesignError where `loads` (N,) push a piece along a motion that is not held."""
    for piece in found:
        if not piece.names:
            continue
        if (np.abs(piece.motions.T @ loads[piece.dofs]) <= _BALANCED * _acting(piece, loads, dofs)).all():
            continue
        work = piece.motions.T @ loads[piece.dofs]
        fold = int(np.argmax(np.abs(work)))
        if fold < piece.folds:
            raise DesignError(
                f"the plate is a mechanism: {free_text(found)}; the loads on {piece.text} do "
                f"{abs(work[fold]):.4g} N·m of work per radian of it: add supports, give the hinge a stiffness, or "
                "balance the loads"
            )
        raise DesignError(
            f"the plate is not held: {free_text(found)}; the loads on {piece.text} leave "
            f"{_left_over(piece, loads, dofs)}: add supports, or balance the loads"
        )


def _acting(piece: Piece, loads: Array, dofs: Dofs) -> Array:
    """Work of the loads along each free motion if none cancelled another, N·m: what acts across for motions across, in
    the plane for motions in the plane, and of the other kind as much as round-off makes of it."""
    table = dofs.table[piece.nodes]
    in_plane = np.broadcast_to(np.arange(table.shape[1]) < 2, table.shape)[table >= 0]
    work = piece.units * np.abs(loads[piece.dofs])
    plane, across = float(work[in_plane].sum()), float(work[~in_plane].sum())
    moves_in_plane = np.abs(piece.motions[in_plane]).sum(axis=0) > 0.0
    return np.where(moves_in_plane, plane + _STRAY * across, across + _STRAY * plane)


def _left_over(piece: Piece, loads: Array, dofs: Dofs) -> str:
    force, moment = resultant(loads, dofs, piece.nodes, piece.centre)
    size = max(float(np.abs(force).max()), float(np.abs(moment).max()) / piece.size)
    texts = [
        ", ".join(f"{value:.4g}" for value in np.where(np.abs(values) > _NOISE * unit, values, 0.0))
        for values, unit in ((force, size), (moment, size * piece.size))
    ]
    return f"a force ({texts[0]}) N and a moment ({texts[1]}) N·m about its centre"


def resultant(loads: Array, dofs: Dofs, nodes: Integers, about: Array) -> tuple[Array, Array]:
    """Force (3,), N, and moment (3,), N·m, about the point `about` (2,) of the plane, of nodal `loads` (N,)."""
    table = dofs.table[nodes]
    values = np.where(table >= 0, loads[np.maximum(table, 0)], 0.0)
    u, v, w, by_x, by_y, _ = values.T  # what works on w_x turns about -y, on w_y about x
    x, y = (dofs.points[nodes] - about).T
    force = np.array([u.sum(), v.sum(), w.sum()])
    moment = np.array([(y * w + by_y).sum(), (-x * w - by_x).sum(), (x * v - y * u).sum()])
    return force, moment


def pins(piece: Piece, dofs: Dofs) -> Equations:
    """Displacements that hold exactly the motions of a free piece: as many as these, far from each other."""
    name_of = np.full(dofs.count, -1, dtype=np.int32)
    node_of = np.empty(dofs.count, dtype=np.int32)
    nodes, columns = np.nonzero(dofs.table >= 0)
    name_of[dofs.table[nodes, columns]], node_of[dofs.table[nodes, columns]] = columns, nodes
    moves = np.flatnonzero(name_of[piece.dofs] <= DOFS.index("w"))
    _, _, order = scipy.linalg.qr(piece.motions[moves].T / piece.size, mode="economic", pivoting=True)
    chosen = piece.dofs[moves[order[: len(piece.names)]]]
    return joined(
        equations_of(DOFS[name_of[number]], node_of[[number]], 0.0, -1) for number in np.sort(chosen)
    )


def without_rigid(d: Numbers, piece: Piece, dofs: Dofs) -> Numbers:
    """`d` (N,) with the free motions of `piece` taken out: its nodes' displacements have the least sum of squares."""
    table = dofs.table[piece.nodes]
    moves = np.isin(piece.dofs, table[:, :3])
    motions = piece.motions[moves] / piece.size
    amounts = np.linalg.lstsq(
        motions, np.asarray(d[piece.dofs][moves], dtype=float) / piece.size, rcond=None
    )[0]
    result = d.copy()
    result[piece.dofs] -= (piece.motions @ amounts).astype(d.dtype)
    return result

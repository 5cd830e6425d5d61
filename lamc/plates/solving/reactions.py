"""What supports do to the plate.

In: a system and what is out of balance without supports. Out: force and moment by support. Never: solves.
"""

from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.plates.elements.kernels import Numbers
from lamc.plates.foundations import ElasticFoundation
from lamc.plates.meshing.mesh import Integers
from lamc.plates.solving.rigid import resultant
from lamc.plates.solving.system import System
from lamc.plates.supports import SupportRecord, Where


@dataclass(frozen=True, eq=False)
class Reaction:
    """Of one support, or of elastic ground, on the plate.

    force   (3,), N, along x, y, z; zero in the plane for an element that only bends
    moment  (3,), N·m, about the origin of the coordinates
    nodes   (k,): numbers of its nodes; `values` (k, 6): forces and moments on the unknowns u, v, w, w_x, w_y, w_xy of
            each: N, N, N, N·m (that on w_x turns about -y, that on w_y about x), N·m²

    A node of several supports counts to the first of them that holds the direction in question.
    """

    support: SupportRecord | ElasticFoundation
    force: Array
    moment: Array
    nodes: Integers
    values: Array

    @property
    def where(self) -> Where | None:
        """None: all of the plate."""
        return self.support.where


def reactions(system: System, left: Numbers, d: Numbers) -> tuple[Reaction, ...]:
    """Of all supports, then of all foundations, in their order; `left` (N,): inner forces less loads. With the loads
    they are in balance."""
    problem, constraints = system.problem, system.constraints
    dofs = problem.dofs
    along = constraints.fixed @ np.asarray(left, dtype=float)
    found = []
    for index, support in enumerate([*problem.supports, *problem.foundations]):
        mine = np.where(constraints.owners == index, along, 0.0)
        forces = constraints.fixed.T @ mine
        if (system.springs.owners == index).any():
            forces = forces - np.asarray(system.springs.forces(d, index), dtype=float)
        touched = (dofs.table >= 0) & (forces[np.maximum(dofs.table, 0)] != 0.0)
        nodes = np.flatnonzero(touched.any(axis=1)).astype(np.int32)
        table = dofs.table[nodes]
        values = np.where(table >= 0, forces[np.maximum(table, 0)], 0.0)
        force, moment = resultant(forces, dofs, nodes, np.zeros(2))
        found.append(Reaction(support, force, moment, nodes, values))
    return tuple(found)

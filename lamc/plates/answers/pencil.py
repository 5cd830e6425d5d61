"""The matrices of a problem over what its supports leave free, for eigenproblems.

In: a problem. Out: stiffness, mass and geometric stiffness over free unknowns, the rigid motions among these, and the
way back to all unknowns. Never: loads.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from lamc.basics.checks import Array, shown
from lamc.basics.errors import DesignError
from lamc.plates.answers.eigen import Matrix, Solve
from lamc.plates.dofs import Dofs
from lamc.plates.problem import Problem
from lamc.plates.solving.constraints import constraints
from lamc.plates.solving.equations import support_equations
from lamc.plates.solving.panels import Piece
from lamc.plates.solving.solvers import factor
from lamc.plates.solving.system import System, places_of, system

# Displacements at nodes smaller than this, over those between them, are round-off.
_STILL = 1e-6


@dataclass(frozen=True, eq=False)
class Pencil:
    """Free unknowns y with d = free y, all supports at zero.

    free          (N, f), columns orthonormal
    stiffness     (f, f)
    motions       (f, r), rigid motions that are left, and their names
    """

    system: System
    free: sparse.csr_array
    stiffness: Matrix
    motions: Array
    motion_names: tuple[str, ...]

    @property
    def problem(self) -> Problem:
        return self.system.problem

    def factor(self, matrix: Matrix) -> Solve:
        """What solves with `matrix`."""
        places = places_of(self.free, self.problem.dofs)
        return factor(sparse.csc_array(matrix), places, self.system.solver).solve

    def mass(self, *, in_plane: bool = True) -> Matrix:
        """Consistent mass of all unknowns, (N, N), kg; without that of motion in the plane if it is not wanted."""
        problem = self.problem
        rho = np.array([laminate.areal_mass for laminate in problem.laminates])
        matrix = self.system.assembly.mass(rho)
        if in_plane:
            return matrix
        weight = np.ones(problem.dofs.count)
        weight[is_in_plane(problem.dofs)] = 0.0
        scale = sparse.diags_array(weight)
        return sparse.csc_array(scale @ matrix @ scale)

    def geometric(self, forces: Array) -> Matrix:
        """∫ ∇w · N ∇w dA from (N_x, N_y, N_xy) of every cell (m, 3), N/m."""
        return self.reduced(self.system.assembly.geometric(forces))

    def reduced(self, matrix: Matrix) -> Matrix:
        """Over the free unknowns."""
        return sparse.csc_array(self.free.T @ matrix @ self.free)

    def normalised(self, shapes: Array) -> tuple[Array, Array]:
        """All unknowns of `shapes` (f, k), each with its largest displacement at a node 1 m and positive, (N, k), and
        the factors (k,) that did it.

        Where nodes turn and do not move, as on the coarsest meshes, the displacement between them counts as an eighth
        of a cell times the slope.
        """
        full = np.asarray(self.free @ shapes)
        mesh, table = self.problem.mesh, self.problem.dofs.table
        reach = 0.125 * float(np.sqrt(mesh.areas.max()))
        rotations, twists = (
            np.abs(full[_there(part)]).max(axis=0, initial=0.0) for part in (table[:, 3:5], table[:, 5:])
        )
        between = np.maximum(rotations * reach, twists * reach**2)
        moves = full[_there(table[:, :3])]
        still = np.abs(moves).max(axis=0, initial=0.0) < _STILL * between
        size = np.where(still, between, np.abs(moves).max(axis=0, initial=0.0))
        # Of equal displacements the first decides the sign, whatever round-off makes the largest.
        signs = np.empty(len(size))
        for k in range(len(size)):
            values = full[:, k] if still[k] else moves[:, k]
            signs[k] = np.sign(values[np.argmax(np.abs(values) > (1.0 - 1e-6) * np.abs(values).max())])
        return full * (signs / size), 1.0 / size

    def require_held(self, what: str) -> None:
        """Raises DesignError if a rigid motion across the plate is left."""
        across = ~is_in_plane(self.problem.dofs)
        moving = np.abs((self.free @ self.motions)[across]).max(axis=0, initial=0.0) > 0.0
        if moving.any():
            names = [name for name, moves in zip(self.motion_names, moving, strict=True) if moves]
            raise DesignError(
                f"{what} needs a plate that is held, and supports leave it {', '.join(names)}; support it"
            )


def _there(table: NDArray[np.int32]) -> NDArray[np.int32]:
    """Numbers of the unknowns in a part of the table of all."""
    return np.unique(table[table >= 0])


def is_in_plane(dofs: Dofs) -> NDArray[np.bool_]:
    """Which unknowns are u or v, (N,)."""
    found = np.zeros(dofs.count, dtype=bool)
    table = dofs.table[:, :2]
    found[table[table >= 0]] = True
    return found


def translations(dofs: Dofs) -> Array:
    """Motion of all nodes by 1 m along x, y and z, (N, 3)."""
    unit = np.zeros((dofs.count, 3))
    for axis in range(3):
        there = dofs.table[:, axis]
        unit[there[there >= 0], axis] = 1.0
    return unit


def check_problem(problem: object) -> None:
    """Raises DesignError for anything but a Problem."""
    if not isinstance(problem, Problem):
        raise DesignError(f"the problem is {shown(problem)}; it must be a Problem")


def pencil(problem: Problem, solver: str = "auto") -> Pencil:
    """The matrices of `problem`; `solver` as for `plate.solve`. Raises DesignError where nothing is free to move."""
    made = system(problem, solver)
    free = made.constraints.free
    if not free.shape[1]:
        raise DesignError(
            "the supports hold every unknown of the plate, so there is nothing that vibrates or buckles; hold less, or "
            "mesh finer"
        )
    if any(piece.names for piece in made.pieces):  # without the pins that hold free pieces for `solve`
        free = constraints(problem, support_equations(problem)).free
    motions, names = _motions(made.pieces, problem.dofs.count)
    reduced = sparse.csc_array(free.T @ made.stiffness @ free + made.hinge_springs.over(free))
    return Pencil(made, free, reduced, np.asarray(free.T @ motions), names)


def _motions(found: tuple[Piece, ...], count: int) -> tuple[Array, tuple[str, ...]]:
    """Rigid motions of all pieces, (N, r), those that shift before those that turn, and their names."""
    columns, names = [], []
    for piece in found:
        for k, name in reversed(list(enumerate(piece.names))):
            column = np.zeros(count)
            column[piece.dofs] = piece.motions[:, k]
            columns.append(column)
            names.append(name if piece.count == 1 else f"{name} of {piece.text}")
    return np.array(columns).reshape(-1, count).T, tuple(names)

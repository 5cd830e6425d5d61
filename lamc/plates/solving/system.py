"""A plate as a system of equations: what depends on mesh, element and supports, and the stiffness of its laminates.

In: a problem. Out: the matrix of its free unknowns, scaled and factored; inner forces of any deformation. Never: loads.

Free unknowns are scaled by powers of two so that the stiffness matrix has a diagonal near one. Displacements and
slopes then count alike, whatever the units, the size of cells and the stiffness of regions; the condition of the scaled
matrix is what matters to the factorisation (A. van der Sluis, Numerische Mathematik 14, 1969), and powers of two round
nothing.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from lamc.basics.checks import Array
from lamc.basics.once import lazy
from lamc.plates.dofs import Dofs
from lamc.plates.elements.kernels import ElementKernels, Numbers, kernels
from lamc.plates.laminates.sections import sections
from lamc.plates.memory import check_memory
from lamc.plates.problem import Problem
from lamc.plates.solving.assembly import Assembly
from lamc.plates.solving.constraints import Constraints, constraints
from lamc.plates.solving.equations import joined, support_equations
from lamc.plates.solving.panels import Piece
from lamc.plates.solving.reduction import Reduction
from lamc.plates.solving.rigid import pieces, pins
from lamc.plates.solving.solvers import Factor, SingularError, checked_solver, factor
from lamc.plates.solving.springs import Springs, hinge_springs, springs, with_added

_INVERSE_STEPS = 3  # of inverse iteration: enough for the order of magnitude


class Pattern:
    """What depends on the unknowns and the supports only: computed once for all laminates."""

    def __init__(self, constraints: Constraints) -> None:
        self._constraints = constraints
        self._reduction: Reduction | None = None

    def reduction(self, matrix: sp.csc_array) -> Reduction:
        """Takes the free unknowns out of matrices of the pattern of `matrix`, which is always the same."""
        if self._reduction is None:
            self._reduction = Reduction(self._constraints.free, matrix)
        return self._reduction


@dataclass(frozen=True, eq=False)
class System:
    """What is solved; all but the laminates is shared by systems that `with_problem` makes.

    constraints  what the supports hold, and pins on the rigid motions that they leave
    pieces       with these motions
    """

    problem: Problem
    solver: str
    kernels: ElementKernels
    assembly: Assembly
    constraints: Constraints
    pieces: tuple[Piece, ...]
    springs: Springs
    hinge_springs: Springs
    pattern: "Pattern"
    before: Factor | None = None  # of a matrix of the same pattern

    @lazy
    def section_rows(self) -> Array:
        """What the element reads of the laminates, (regions, entries)."""
        return sections(self.problem.laminates, self.problem.dofs.element)

    @lazy
    def stiffness(self) -> sp.csc_array:
        """Of all unknowns, elastic hinges at supports included, (N, N), both triangles; without hinge lines."""
        return self.springs.added_to(self.assembly.stiffness(self.section_rows))

    @lazy
    def _reduced(self) -> tuple[sp.csc_array, Array]:
        """The scaled matrix of the free unknowns, and the scale."""
        matrix = self.pattern.reduction(self.stiffness).matrix(self.stiffness.data)
        matrix = with_added(matrix, self.hinge_springs.over(self.constraints.free))
        diagonal = matrix.diagonal()
        if not (diagonal > 0.0).all():
            number = int(np.flatnonzero(~(diagonal > 0.0))[0])
            raise SingularError(
                f"{self._text_of(number)} has no stiffness ({diagonal[number]:.3g}); check the cells and the laminate "
                "there"
            )
        scale = np.exp2(-np.round(0.5 * np.log2(diagonal)))
        matrix.data *= scale[matrix.indices] * np.repeat(scale, np.diff(matrix.indptr))
        return matrix, scale

    def _text_of(self, number: int) -> str:
        x, y = places_of(self.constraints.free, self.problem.dofs)[number]
        return f"the node at ({x:.6g}, {y:.6g})"

    @lazy
    def factor(self) -> Factor:
        """Of the scaled matrix. Raises SingularError."""
        matrix, _ = self._reduced
        if self.before is not None:
            return self.before.refactored(matrix)
        return factor(matrix, places_of(self.constraints.free, self.problem.dofs), self.solver)

    @lazy
    def condition(self) -> float:
        """Of the scaled matrix, estimated from below: its largest row sum over its smallest eigenvalue, the latter by
        inverse iteration."""
        matrix, _ = self._reduced
        if not matrix.shape[0]:
            return 1.0
        norm = float(np.add.reduceat(np.abs(matrix.data), matrix.indptr[:-1]).max())
        vector = np.cos(np.arange(matrix.shape[0], dtype=float))  # of no symmetry, and the same every time
        growth = 0.0
        for _ in range(_INVERSE_STEPS):
            vector = self.factor.solve(vector / np.linalg.norm(vector))
            growth = float(np.linalg.norm(vector))
        return norm * growth

    def solved(self, forces: Array) -> Array:
        """Changes of all unknowns (N, k) that answer `forces` (N, k), nothing prescribed."""
        return self.solved_free(self.constraints.free.T @ forces)

    def solved_free(self, right: Array) -> Array:
        """The same for forces on what is free, (f, k)."""
        _, scale = self._reduced
        free = self.factor.solve(scale[:, None] * right) if len(scale) else right
        return np.asarray(self.constraints.free @ (scale[:, None] * free))

    def on_free(self, forces: Numbers) -> Numbers:
        """Forces (N,) on what is free, (f,), in their precision: what the sides of a hinge line hand to each other
        cancels before anything is rounded."""
        return np.asarray(self.constraints.free.T @ forces)

    def size_of(self, changes: Array) -> float:
        """Norm of changes of the unknowns (N,), each counted in units of its own stiffness."""
        _, scale = self._reduced
        return float(np.linalg.norm((self.constraints.free.T @ changes) / scale)) if len(scale) else 0.0

    def force_size(self, forces: Numbers) -> float:
        """Norm of forces (N,) on what is free, each in units of its unknown's own stiffness."""
        _, scale = self._reduced
        return float(np.linalg.norm(np.asarray(self.on_free(forces), dtype=float) * scale))

    def inner_forces(self, d: Numbers) -> Numbers:
        """∫ Bᵀ S B d dA by way of the strains, elastic hinges included, (N,), in the precision of `d`."""
        total = self.assembly.force(self.section_rows, d)
        for each in (self.springs, self.hinge_springs):
            if len(each.stiffness):
                total = total + each.forces(d)
        return total

    def with_problem(self, problem: Problem) -> "System":
        """Of a problem that differs by its laminates only: values are assembled anew, patterns and ordering stay."""
        return replace(self, problem=problem, before=vars(self).get("factor", self.before))


def places_of(free: sp.csr_array, dofs: Dofs) -> Array:
    """Where free unknowns are, (f, 2), m; a column of `free` (N, f) concerns one node."""
    node_of = np.argwhere(dofs.table >= 0)[:, 0]  # unknowns are numbered node by node
    by_column = free.tocsc()
    return np.asarray(dofs.points[node_of[by_column.indices[by_column.indptr[:-1]]]])


def system(problem: Problem, solver: str = "auto") -> System:
    """Of `problem`.

    Raises DesignError where supports contradict each other, for an unknown solver, and where memory is too small.
    """
    chosen = checked_solver(solver)
    check_memory(problem.dofs.element, len(problem.mesh.cells), chosen)
    made = kernels(problem.dofs.element)
    equations = support_equations(problem)
    held = constraints(problem, equations)
    elastic = springs(problem, made)
    hinged = hinge_springs(problem)
    found = pieces(problem, held, elastic.rotations, hinged)
    free = [pins(piece, problem.dofs) for piece in found if piece.names]
    if free:
        held = constraints(problem, joined([equations, *free]))
    assembly = Assembly(made, problem.mesh, problem.dofs)
    return System(problem, chosen, made, assembly, held, found, elastic, hinged, Pattern(held))

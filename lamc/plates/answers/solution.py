"""What a plate does under its loads, anywhere on it.

In: unknowns at the nodes, and the problem they belong to. Out: deflection, slopes, curvature, moments, strains, forces,
ply states, reactions, energy. Never: solves.

Arrays of x and y may have any shape; results have that shape, with components last. Points on the boundary belong to
the plate; on an edge between cells, where curvature and moments jump, the first of them counts. They are the element's
own; `recovered` has the better ones, by which extremes, outputs of files and first failures go.
"""

import os
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from lamc.basics.brief import brief, counted
from lamc.basics.checks import Array, shown
from lamc.basics.drawing import drawer
from lamc.basics.errors import DesignError, UnsupportedError
from lamc.basics.once import lazy
from lamc.basics.seen import Viewable
from lamc.plates.answers.estimate import ErrorEstimate, error_estimate, recovered_strains
from lamc.plates.answers.hinge_rotations import HingeRotation, hinge_rotations, rotation_at
from lamc.plates.answers.recovery import RecoveredStrains
from lamc.plates.answers.shear_share import shear_share
from lamc.plates.elements.kernels import Numbers
from lamc.plates.laminates.climate import RegionClimate
from lamc.plates.laminates.graded import number_of
from lamc.plates.laminates.plies import PlyState
from lamc.plates.laminates.sections import in_cells, matrices
from lamc.plates.loads import LoadRecord
from lamc.plates.locator import points_at
from lamc.plates.meshing.mesh import Integers
from lamc.plates.problem import Problem
from lamc.plates.solving.expansion import Expansion
from lamc.plates.solving.reactions import Reaction, reactions
from lamc.plates.solving.refine import Accuracy
from lamc.plates.solving.refine import solve as refined
from lamc.plates.solving.rigid import check_balance
from lamc.plates.solving.system import System

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class SolveReport:
    """How it was solved.

    solver    "cholmod", "superlu" or "pardiso"
    unknowns  how many, held ones included
    accuracy  condition, steps of refinement, errors
    free      what may move freely, and was left out of the solution since the loads are in balance; "" if nothing
    notes     warnings: what may make the answer worse than the reader expects
    """

    solver: str
    unknowns: int
    accuracy: Accuracy
    free: str
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Solution(Viewable):
    """One load case.

    values  (N,): the unknowns, in the order of `problem.dofs`; m, m, m, no unit twice, 1/m
    loads   what acts, including what acts in every case
    """

    problem: Problem
    loads: tuple[LoadRecord, ...]
    values: Array
    report: SolveReport
    _system: System
    _exact: Numbers  # `values` in long double
    _inner: Numbers
    _outer: Array
    _better: RecoveredStrains | None = None

    # --- at points ---------------------------------------------------------------------------------------------------

    def deflection(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
        """w, m, positive up; shape of x and y. Raises DesignError for a point outside, with its distance."""
        return self._fields(x, y, "deflection")[..., -3]

    def slope(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
        """(w_x, w_y), shape (..., 2); with shear through the thickness, of the cross-section."""
        return self._fields(x, y, "slope")[..., -2:]

    def displacement(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
        """(u, v, w) of the reference surface, m, shape (..., 3); zeros for what the element does not have."""
        fields, chosen = self._fields(x, y), self.problem.dofs.element
        none = np.zeros((*fields.shape[:-1], 1))
        plane = fields[..., :2] if chosen.stretches else np.concatenate([none, none], axis=-1)
        return np.concatenate([plane, fields[..., -3:-2] if chosen.bends else none], axis=-1)

    def curvature(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
        """κ = -(w_xx, w_yy, 2 w_xy), 1/m, shape (..., 3)."""
        return self._bending(self._strains(x, y)[0], "curvature")

    def strain(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
        """(ε_x, ε_y, γ_xy) of the reference surface, expansion included, shape (..., 3)."""
        return self._stretching(self._strains(x, y)[0])

    def moments(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
        """(M_x, M_y, M_xy) per width about the reference surface, N, shape (..., 3)."""
        return self._bending(self._resultants(x, y), "moments")

    def forces(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
        """(N_x, N_y, N_xy) per width, N/m, tension positive, shape (..., 3)."""
        return self._stretching(self._resultants(x, y))

    def ply_states(self, x: float, y: float) -> tuple[PlyState, ...]:
        """Strain and stress of every ply at one point, bottom to top, with the case's temperature, moisture, field."""
        if np.ndim(x) or np.ndim(y):
            raise DesignError(
                f"ply states are asked for at {shown(x)}, {shown(y)}; they are of one point, as "
                "regions differ in their plies: ask point by point"
            )
        strains, cells = self._strains(x, y)
        chosen = self.problem.dofs.element
        strain = self._stretching(strains)
        curvature = strains[-3:] if chosen.bends else np.zeros(3)
        region = int(self.problem.mesh.regions[cells])
        state = self.climates[region].at(np.array([x, y], dtype=float))
        return self.problem.laminates[region].ply_states(
            strain,
            curvature,
            temperature=number_of(state.temperature),
            moisture=number_of(state.moisture),
            fields=state.fields,
        )

    def hinge_rotation(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
        """How far the sides of hinge lines turn against each other at points on them, rad, positive for a valley; shape
        of x and y. Raises DesignError for a point on none."""
        return rotation_at(self, x, y)

    # --- whole -------------------------------------------------------------------------------------------------------

    def at_nodes(self, name: str) -> Array:
        """The unknown `name` at all nodes of `problem.dofs`, shape (nodes,); nan where a node does not have it."""
        if name not in self.problem.dofs.names:
            raise DesignError(
                f"a node has no unknown {shown(name)}; with element {self.problem.dofs.element.name!r} there are "
                f"{', '.join(self.problem.dofs.names)}"
            )
        numbers = self.problem.dofs.of(name)
        return np.where(numbers >= 0, self.values[np.maximum(numbers, 0)], np.nan)

    def __repr__(self) -> str:
        return brief(
            "Solution", "", counted(self.report.unknowns, "unknown"), counted(len(self.loads), "load")
        )

    def plot(
        self, name: str = "w", *, axes: "Axes | None" = None, path: "str | os.PathLike[str] | None" = None
    ) -> "Axes":
        """Contours of a field: "u", "v", "w", "w_x", "w_y", "M_x", "M_y", "M_xy", "N_x", "N_y", "N_xy", "stress" (the
        largest von Mises stress of all plies) or "tsai_wu".

        axes  Matplotlib axes to draw on; None: a new figure
        path  a .png, .svg or .pdf file that the figure is written to, without opening a window

        Returns the axes. Raises RequestError for a field that there is not, LamcError for what cannot be written.
        """
        drawn: Axes = drawer("Solution", "plot")(self, name, axes=axes, path=path)
        return drawn

    @lazy
    def reactions(self) -> tuple[Reaction, ...]:
        """Of the supports, in their order; with the loads they are in balance."""
        return reactions(self._system, self._inner - self._outer, self._exact)

    @lazy
    def hinges(self) -> tuple[HingeRotation, ...]:
        """Rotation, moment and energy of the hinge lines, in the order of `problem.hinges`."""
        return hinge_rotations(self)

    def hinge_energy(self, index: int) -> float:
        """In the spring of the hinge line of that number, J."""
        return self._system.hinge_springs.energy(self._exact, index)

    @property
    def spring_energy(self) -> float:
        """In all hinge lines, elastic hinges at supports and elastic ground, J."""
        return sum(each.energy(self._exact) for each in (self._system.springs, self._system.hinge_springs))

    @property
    def free_unknowns(self) -> sp.csr_array:
        """Orthonormal columns that span what the supports leave free, (N, f)."""
        return self._system.constraints.free

    @property
    def exact(self) -> Numbers:
        """`values` in long double."""
        return self._exact

    @property
    def compliance(self) -> float:
        """Work of the loads along the displacements that they cause, J: twice the strain energy where nothing is
        prescribed and nothing expands."""
        return float(self._outer.astype(self._exact.dtype) @ self._exact)

    @lazy
    def strain_energy(self) -> float:
        """½ ∫ (strain - e)ᵀ S (strain - e) dA + elastic hinges and hinge lines, J, where e is the strain of the free
        laminate."""
        energy = 0.5 * float(self._inner @ self._exact)
        if not self.expansion.is_none:
            forces = self.expansion.forces(self._system.kernels)
            energy -= float(np.sum(forces * self._exact[self.problem.dofs.of_cells]))
            energy += self.expansion.energy
        return energy

    @property
    def climates(self) -> tuple[RegionClimate, ...]:
        """Temperature, moisture and fields of the regions in this case."""
        return self.expansion.climates

    @lazy
    def expansion(self) -> Expansion:
        """What these do to the laminates."""
        return Expansion(self.problem, self.loads)

    def cell_strains(self, xi: Array) -> Array:
        """Strains, then curvatures, of the element at natural coordinates `xi` (cells, 2) of every cell, (cells, 3 or
        6)."""
        return np.asarray(
            self._system.kernels.strain(self.problem.mesh.corners, xi, self.cell_unknowns, self._sections)
        )

    def cell_shear(self, xi: Array) -> Array:
        """(γ_x, γ_y) through the thickness at natural coordinates `xi` (cells, 2) of every cell, (cells, 2). Raises
        UnsupportedError for an element without shear."""
        corners, read = self.problem.mesh.corners, self._system.section_rows[self.problem.mesh.regions]
        return np.asarray(self._system.kernels.shear(corners, xi, self.cell_unknowns, read))

    def answer_to(self, forces: Array) -> Array:
        """Unknowns (N,) under other `forces` (N,) on them, nothing prescribed; as exact as the solution. Raises
        DesignError where a piece is not held and these are not in balance."""
        check_balance(self._system.pieces, forces, self.problem.dofs)
        still = np.zeros(self.problem.dofs.count)
        return np.asarray(refined(self._system, forces, still).d, dtype=float)

    @lazy
    def error_estimate(self) -> ErrorEstimate:
        """How far off the strains are, cell by cell and all together."""
        return error_estimate(self)

    @lazy
    def shear_share(self) -> float:
        """Energy of shear through the thickness over that of bending. Of classical theory, which leaves it out: from
        shear forces by equilibrium; about as much would be added to the deflection where the loads act, or less; inf
        across a gap."""
        return shear_share(self)

    @lazy
    def recovered(self) -> "Solution":
        """The same, with strains, curvatures, moments and forces recovered from patches of cells: smooth within a
        region, and of higher order than the element's own."""
        return replace(self, _better=self.recovered_strains)

    @lazy
    def recovered_strains(self) -> RecoveredStrains:
        """Strains, then curvatures, by patches of cells; what `recovered` and `error_estimate` go by."""
        return recovered_strains(self)

    # --- inside ------------------------------------------------------------------------------------------------------

    @lazy
    def cell_unknowns(self) -> Array:
        """Unknowns of all cells, (cells, unknowns of the element), without the rigid motion of their first node."""
        return self._relative(np.arange(len(self.problem.mesh.cells), dtype=np.int32))

    @lazy
    def _sections(self) -> Array | None:
        problem = self.problem
        return in_cells(problem.laminates, problem.dofs.element, problem.mesh.regions)

    def _located(self, x: npt.ArrayLike, y: npt.ArrayLike) -> tuple[Integers, Array, tuple[int, ...]]:
        points, shape = points_at(x, y)
        cells, xi = self.problem.places.cells_under(points, "a point of the solution")
        return cells, xi, shape

    def _fields(self, x: npt.ArrayLike, y: npt.ArrayLike, wanted: str = "") -> Array:
        if wanted and not self.problem.dofs.element.bends:
            raise UnsupportedError(
                f"element {self.problem.dofs.element.name!r} has no {wanted}: it only stretches; choose one that bends"
            )
        cells, xi, shape = self._located(x, y)
        corners = self.problem.mesh.corners[cells]
        values = self._system.kernels.displacement(
            corners, xi, self.values[self.problem.dofs.of_cells[cells]]
        )
        return np.asarray(values).reshape(*shape, -1)

    def _strains(self, x: npt.ArrayLike, y: npt.ArrayLike) -> tuple[Array, Integers]:
        """All strains of the element, (..., 3 or 6), and the cells that they are of, (...)."""
        cells, xi, shape = self._located(x, y)
        if self._better is not None:
            return self._better.at(cells, xi).reshape(*shape, -1), cells.reshape(shape)
        read = None if self._sections is None else self._sections[cells]
        corners = self.problem.mesh.corners[cells]
        values = self._system.kernels.strain(corners, xi, self._relative(cells), read)
        return np.asarray(values).reshape(*shape, -1), cells.reshape(shape)

    def _relative(self, cells: Integers) -> Array:
        """Unknowns of `cells` without the rigid motion of their first node, which strains nothing: it is taken out in
        long double, so that a strain keeps its digits however far the cell has moved."""
        dofs = self.problem.dofs
        d = self._exact[dofs.of_cells[cells]]
        names = np.array(dofs.element.dofs)
        node = np.repeat(np.arange(len(dofs.element.nodes)), [len(n.dofs) for n in dofs.element.nodes])
        for name in ("u", "v"):
            d[:, names == name] -= d[:, names == name][:, :1]
        if dofs.element.bends:
            arm = dofs.points[dofs.of_nodes[cells]] - dofs.points[dofs.of_nodes[cells, 0]][:, None]
            by_x, by_y = (d[:, names == name][:, :1] for name in ("w_x", "w_y"))
            at = node[names == "w"]
            d[:, names == "w"] -= d[:, names == "w"][:, :1] + by_x * arm[:, at, 0] + by_y * arm[:, at, 1]
            d[:, names == "w_x"] -= by_x
            d[:, names == "w_y"] -= by_y
        return np.asarray(d, dtype=float)

    def _resultants(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
        strains, cells = self._strains(x, y)
        S = matrices(self.problem.laminates, self.problem.dofs.element)[self.problem.mesh.regions[cells]]
        places = np.stack(np.broadcast_arrays(*np.atleast_1d(x, y)), axis=-1).reshape(-1, 2)
        free = self.expansion.at(cells.ravel(), places.astype(float)).reshape(strains.shape)
        return np.asarray(np.einsum("...ij,...j->...i", S, strains) - free)

    def _bending(self, values: Array, wanted: str) -> Array:
        if not self.problem.dofs.element.bends:
            raise UnsupportedError(
                f"element {self.problem.dofs.element.name!r} has no {wanted}: it only stretches; choose one that bends"
            )
        return values[..., -3:]

    def _stretching(self, values: Array) -> Array:
        """Zeros for an element that only bends: nothing pulls at it, or it would have got a membrane."""
        return values[..., :3] if self.problem.dofs.element.stretches else np.zeros_like(values)

"""How far off the strains of a solution are: an estimate with every result, from the solution itself.

In: a solution. Out: the energy of its error, cell by cell, and where to refine. Never: solves; a bound. It is right
within a small factor where the mesh shows what the solution does, and blind to what it does not show, such as infinite
strains under a point load.

The error of strains, of shear through the thickness where the element has it too, is taken for their difference from
recovered ones (`recovery.py`). Source: O. C. Zienkiewicz, J. Z.
Zhu, Int. J. Numer. Meth. Engng 33, 1992.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.checks import Array, checked_number
from lamc.basics.errors import DesignError
from lamc.plates.answers.edge_rows import CUBIC_ALONG_EDGES, SHEARED, edge_rows, sheared_rows
from lamc.plates.answers.kinks import corners_by_side
from lamc.plates.answers.recovery import RecoveredStrains, Rows, recover, sample_points
from lamc.plates.elements.definition import TRIANGLE
from lamc.plates.laminates.sections import matrices
from lamc.plates.meshing.mesh import Mesh

if TYPE_CHECKING:
    from lamc.plates.answers.solution import Solution

# Degree of the polynomials that strains are recovered by; 1 for all others. Those of second order, and with bending
# also those of first: moments at clamped edges are curved, and straight lines continued to the edge fall short of them.
_DEGREES = {"bciz": 2, "bfs": 3, "dkmt": 2, "dkt": 2, "lst": 2, "q12": 3, "q8": 3, "q9": 3, "specht": 2}
# Six points, exact to degree four: D. A. Dunavant, Int. J. Numer. Meth. Engng 21, 1985.
_DUNAVANT = (
    (0.091576213509770743, 0.10995174365532187),
    (0.44594849091596489, 0.22338158967801147),
)


@dataclass(frozen=True, eq=False)
class ErrorEstimate:
    """Of one solution.

    cells     (m,) J, energy of the strains' error in every cell, ½ ∫ (ε* - ε) · S (ε* - ε) dA
    energy    J, of all
    relative  size of the error over that of the solution, both in the energy norm: of stresses and strains in the mean.
              Deflections are better, by about its square
    regions   share of each region in the error's energy, by name
    """

    mesh: Mesh
    cells: Array
    energy: float
    relative: float
    regions: dict[str, float]

    @property
    def worst_region(self) -> str:
        """The one with most of the error: refine it first."""
        return max(self.regions, key=lambda name: self.regions[name])

    def sizes(self, relative: float) -> dict[str, float]:
        """For every region the size of cells, m, that would bring the error to `relative` with equal errors in cells.

        The error's energy of a cell is taken to fall with the fourth power of its size: strains of first order. A
        region without error gets one cell of its own area. Raises DesignError unless `relative` is positive.
        """
        target = checked_number(relative, "the relative error that cell sizes are asked for")
        if target <= 0.0:
            raise DesignError(
                f"the relative error that cell sizes are asked for is {target:g}; it must be positive"
            )
        total = self.energy / max(self.relative**2, np.finfo(float).tiny)
        # A cell of a region has the energy c h⁴. Equal ones, e, need h = (e/c)^¼ and so area √(c/e) cells, which have
        # the energy Σ area √(c e) together: √e is the energy allowed over Σ area √c.
        mesh, count = self.mesh, len(self.mesh.region_names)
        squared = 2.0 * mesh.areas if mesh.corner_count == 3 else mesh.areas
        areas = np.bincount(mesh.regions, mesh.areas, count)
        own = np.bincount(mesh.regions, self.cells / squared, count)
        root = np.sqrt(np.maximum(own / np.maximum(areas, np.finfo(float).tiny), np.finfo(float).tiny))
        sizes = np.sqrt(target**2 * total / np.sum(areas * root) / root) if self.energy > 0.0 else np.inf
        return dict(zip(mesh.region_names, np.minimum(sizes, np.sqrt(areas)).tolist(), strict=True))

    def __str__(self) -> str:
        where = f", most of it in region {self.worst_region!r}" if len(self.regions) > 1 else ""
        return f"strains are {100.0 * self.relative:.2g} % off in the energy norm{where}"


def error_estimate(solution: "Solution") -> ErrorEstimate:
    """The error of `solution` from its own recovered strains."""
    problem = solution.problem
    mesh, element = problem.mesh, problem.dofs.element
    better = solution.recovered_strains
    stiffness = matrices(problem.laminates, element)[mesh.regions]
    cells = np.arange(len(mesh.cells), dtype=np.int32)
    error, energy = np.zeros(len(cells)), np.zeros(len(cells))
    for point, weight in integration_points(element.cell):
        xi = np.tile(point, (len(cells), 1))
        strain = solution.cell_strains(xi)
        off = better.at(cells, xi) - strain
        area = 0.5 * weight * mesh.areas
        error += area * np.einsum("mi,mij,mj->m", off, stiffness, off)
        energy += area * np.einsum("mi,mij,mj->m", strain, stiffness, strain)
    if element.shear:
        sheared, of_shear = _shear_energies(solution)
        error, energy = error + sheared, energy + of_shear
    total, stored = float(error.sum()), float(energy.sum())
    names = mesh.region_names
    shares = np.bincount(mesh.regions, error, len(names)) / max(total, np.finfo(float).tiny)
    relative = math.sqrt(total / (total + stored)) if total > 0.0 else 0.0
    return ErrorEstimate(mesh, error, total, relative, dict(zip(names, shares.tolist(), strict=True)))


def _shear_energies(solution: "Solution") -> tuple[Array, Array]:
    """J of every cell, of shear through the thickness: of its error, and its own; two of shape (m,)."""
    problem = solution.problem
    mesh, kind = problem.mesh, problem.dofs.element.cell
    count = len(mesh.cells)
    cells = np.arange(count, dtype=np.int32)
    stiffness = np.array([laminate.H for laminate in problem.laminates], dtype=float)[mesh.regions]
    middle = sample_points(kind, 1)
    samples = solution.cell_shear(np.tile(middle, (count, 1)))[:, None]
    better = recover(mesh, middle, samples, 1, corners_by_side(solution))
    error, energy = np.zeros(count), np.zeros(count)
    for point, weight in integration_points(kind):
        xi = np.tile(point, (count, 1))
        shear = solution.cell_shear(xi)
        off = better.at(cells, xi) - shear
        for sum_, part in ((error, off), (energy, shear)):
            sum_ += 0.5 * weight * mesh.areas * np.einsum("mi,mij,mj->m", part, stiffness, part)
    return error, energy


def recovered_strains(solution: "Solution") -> RecoveredStrains:
    """Strains, then curvatures, of `solution`, by patches; each by polynomials that suit its part of the element."""
    problem = solution.problem
    element, count = problem.dofs.element, len(problem.mesh.cells)
    names = element.name.split("+")  # what bends, then what stretches, which comes first in the strains
    parts, corners = [], corners_by_side(solution)
    for k, name in enumerate(reversed(names)):
        degree = _DEGREES.get(name, 1)
        xi = sample_points(element.cell, degree)
        strains = np.stack([solution.cell_strains(np.tile(point, (count, 1))) for point in xi], axis=1)
        mine = slice(3 * k, 3 * k + 3) if len(names) > 1 else slice(None)
        rows = _edge_rows(solution, name)
        parts.append(recover(problem.mesh, xi, strains[:, :, mine], degree, corners, rows))
    return RecoveredStrains(tuple(parts))


def _edge_rows(solution: "Solution", name: str) -> Rows | None:
    if name in SHEARED:
        return sheared_rows(solution)
    if name not in CUBIC_ALONG_EDGES:
        return None
    names = np.array(solution.problem.dofs.element.dofs)
    w, slope_x, slope_y = (solution.cell_unknowns[:, names == name] for name in ("w", "w_x", "w_y"))
    return edge_rows(solution.problem.mesh.corners, w, np.stack([slope_x, slope_y], axis=-1))


def integration_points(cell: str) -> list[tuple[Array, float]]:
    """ξ, η and weights that sum to 1."""
    if cell == TRIANGLE:
        return [
            (np.array([1.0 - 2.0 * b if k == 0 else b, 1.0 - 2.0 * b if k == 1 else b]), weight)
            for b, weight in _DUNAVANT
            for k in range(3)
        ]
    points, weights = np.polynomial.legendre.leggauss(4)
    return [
        (np.array([a, b]), float(p * q) / 4.0)
        for a, p in zip(points, weights, strict=True)
        for b, q in zip(points, weights, strict=True)
    ]

"""What temperature, moisture and electric fields do to a plate: resultants at places, forces on unknowns, energy.

In: a problem and loads. Out: numbers by cell. Never: solves. Where nothing varies within a region the element's own
exact integrals are taken; elsewhere those of `cell_points.py`.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lamc.basics.checks import Array
from lamc.plates.elements.kernels import ElementKernels
from lamc.plates.laminates.climate import RegionClimate, climates, resultants
from lamc.plates.laminates.sections import in_cells, matrices
from lamc.plates.loads import LoadRecord
from lamc.plates.meshing.mesh import Integers
from lamc.plates.problem import Problem
from lamc.plates.solving.cell_points import CellPoints, cell_points


class Expansion:
    """Of `problem` under `loads`; those that are no climate do not matter."""

    def __init__(self, problem: Problem, loads: Sequence[LoadRecord]) -> None:
        self.problem = problem
        self.climates: tuple[RegionClimate, ...] = tuple(
            climates(problem.laminates, loads, problem.mesh.region_names)
        )

    @cached_property
    def _uniform(self) -> Array:
        """Resultants of what does not vary, (regions, 3 or 6)."""
        element = self.problem.dofs.element
        pairs = zip(self.problem.laminates, self.climates, strict=True)
        return np.array([resultants(laminate, element, climate.uniform) for laminate, climate in pairs])

    @property
    def is_none(self) -> bool:
        """Whether nothing expands."""
        return not self._uniform.any() and not any(climate.varying for climate in self.climates)

    def at(self, cells: Integers, points: Array) -> Array:
        """Resultants of expansion in `cells` (k,) at `points` (k, 2), shape (k, 3 or 6), N/m and N. Raises DesignError
        where a function fails."""
        regions = self.problem.mesh.regions[cells]
        result = self._uniform[regions]
        for region, climate in enumerate(self.climates):
            here = regions == region
            if climate.varying and here.any():
                there = climate.at(points[here])
                laminate = self.problem.laminates[region]
                result[here] = resultants(laminate, self.problem.dofs.element, there)
        return result

    def forces(self, kernels: ElementKernels) -> Array:
        """∫ Bᵀ r dA of every cell, shape (m, unknowns), N for displacements, N·m for slopes."""
        corners, regions = self.problem.mesh.corners, self.problem.mesh.regions
        read = in_cells(self.problem.laminates, kernels.element, regions)
        total = kernels.prestress(corners, self._uniform[regions], read)
        total[self._varies] = 0.0
        for corner in range(kernels.corner_count):  # Gauss's points would not meet what is infinite there
            cells = np.flatnonzero(self._varies).astype(np.int32)
            self.at(cells, corners[cells, corner])
        for point in self._points():
            own = None if read is None else read[point.cells]
            rows = strain_rows(kernels, corners[point.cells], point.xi, own)
            acting = point.areas[:, None] * self.at(point.cells, point.places)
            total[point.cells] += np.einsum("kai,ki->ka", rows, acting)
        return total

    @property
    def energy(self) -> float:
        """½ ∫ r S⁻¹ r dA, J: of the laminate that is kept from expanding."""
        mesh = self.problem.mesh
        softness = np.linalg.inv(matrices(self.problem.laminates, self.problem.dofs.element))
        areas = np.bincount(mesh.regions, np.where(self._varies, 0.0, mesh.areas), len(mesh.region_names))
        total = float(np.einsum("r,ri,rij,rj->", areas, self._uniform, softness, self._uniform))
        for point in self._points():
            r = self.at(point.cells, point.places)
            total += float(np.einsum("k,ki,kij,kj->", point.areas, r, softness[mesh.regions[point.cells]], r))
        return 0.5 * total

    @cached_property
    def _varies(self) -> NDArray[np.bool_]:
        """Which cells lie where something varies, (m,)."""
        by_region = np.array([bool(climate.varying) for climate in self.climates])
        return np.asarray(by_region[self.problem.mesh.regions])

    def _points(self) -> Iterator[CellPoints]:
        cells = np.flatnonzero(self._varies).astype(np.int32)
        return cell_points(self.problem.dofs.element.cell, self.problem.mesh.corners, cells)


def strain_rows(kernels: ElementKernels, corners: Array, xi: Array, sections: Array | None) -> Array:
    """Strains at `xi` (k, 2) of cells with `corners` (k, c, 2), per unit of each unknown, (k, unknowns, 3 or 6);
    `sections` (k, S) for elements whose strains go by them."""
    count = kernels.unknown_count
    unit = np.tile(np.eye(count), (len(xi), 1))
    read = None if sections is None else np.repeat(sections, count, axis=0)
    values = kernels.strain(np.repeat(corners, count, axis=0), np.repeat(xi, count, axis=0), unit, read)
    return np.asarray(values).reshape(len(xi), count, -1)

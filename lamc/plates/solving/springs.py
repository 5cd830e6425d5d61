"""Lines that resist turning, elastic hinges to bodies that stand still, and elastic ground.

In: a problem and kernels. Out: slopes across these lines and deflections on that ground, and what opposes them. Never:
supports without stiffness.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.plates.edge_parts import edge_parts_on
from lamc.plates.elements.kernels import ElementKernels
from lamc.plates.foundations import ElasticFoundation
from lamc.plates.problem import Problem
from lamc.plates.solving.blocks import runs
from lamc.plates.solving.cell_points import cell_points
from lamc.plates.solving.hinge_sides import hinge_sides
from lamc.plates.solving.load_vectors import along_edges, shape_functions
from lamc.plates.supports import Hinged

_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(4)  # exact for the square of a cubic


@dataclass(frozen=True, eq=False)
class Springs:
    """The energy ½ Σ stiffness (turns @ d)², over points of quadrature along the lines.

    turns      (k, N) sparse: the slope across the line, or the deflection on elastic ground; a row is of one cell
    stiffness  (k,), N·m per rad or N/m: of the part of line or area that the point stands for
    owners     (k,): numbers of the supports, and after these of the foundations
    """

    rotations: sp.csr_array
    stiffness: Array
    owners: NDArray[np.int64]

    def forces(self, d: NDArray[np.floating], owner: int | None = None) -> NDArray[np.floating]:
        """On the unknowns (N,), against the springs, in the precision of `d`; of all supports or of one."""
        stiffness = self.stiffness if owner is None else np.where(self.owners == owner, self.stiffness, 0.0)
        return np.asarray(self.rotations.T @ (stiffness * (self.rotations @ d)))

    def added_to(self, matrix: sp.csc_array) -> sp.csc_array:
        """`matrix` with the springs on its own pattern, which holds all unknowns of a cell with each other."""
        return with_added(
            matrix, sp.csc_array(self.rotations.T @ sp.diags_array(self.stiffness) @ self.rotations)
        )

    def energy(self, d: NDArray[np.floating], owner: int | None = None) -> float:
        """Of all springs or of those of one owner, J."""
        stiffness = self.stiffness if owner is None else np.where(self.owners == owner, self.stiffness, 0.0)
        rotations = self.rotations @ d
        return 0.5 * float(np.sum(stiffness * rotations * rotations))

    def over(self, free: sp.csr_array) -> sp.csc_array:
        """The stiffness of what is `free` (N, f), (f, f): formed from turns of these, so that motions that turn no
        spring get none of its round-off."""
        rotations = sp.csr_array(self.rotations @ free)
        return sp.csc_array(rotations.T @ sp.diags_array(self.stiffness) @ rotations)


def with_added(matrix: sp.csc_array, own: sp.csc_array) -> sp.csc_array:
    """The sum, on a pattern that depends on those of both alone, not on values."""
    if not own.nnz:
        return matrix
    own.sort_indices()
    count = np.int64(matrix.shape[0])
    columns = np.flatnonzero(np.diff(own.indptr))
    sizes = np.diff(matrix.indptr)[columns]
    places = runs(matrix.indptr[columns].astype(np.int64), sizes)
    keys = np.repeat(columns, sizes) * count + matrix.indices[places]
    wanted = np.repeat(columns, np.diff(own.indptr)[columns]) * count + own.indices
    at = np.minimum(np.searchsorted(keys, wanted), max(len(keys) - 1, 0))
    if not len(keys) or (keys[at] != wanted).any():
        ones = [sp.csc_array((np.ones(m.nnz), m.indices, m.indptr), shape=m.shape) for m in (matrix, own)]
        wide = sp.csc_array(ones[0] + ones[1])
        wide.sort_indices()
        wide.data[:] = 0.0
        return with_added(with_added(wide, matrix), own)
    data = matrix.data.copy()
    data[places[at]] += own.data
    return sp.csc_array((data, matrix.indices, matrix.indptr), shape=matrix.shape)


def springs(problem: Problem, kernels: ElementKernels) -> Springs:
    """Of all supports of `problem` with a stiffness, and of its foundations."""
    rows, stiffness, owners = (
        [sp.csr_array((0, problem.dofs.count))],
        [np.zeros(0)],
        [np.zeros(0, dtype=np.int64)],
    )
    for index, support in enumerate(problem.supports):
        if not isinstance(support, Hinged) or support.stiffness == 0.0:
            continue
        parts = edge_parts_on(problem.places, support.where, "the Hinged support")
        numbers = problem.dofs.of_cells[parts.edges[:, 0]]
        starts = np.arange(len(numbers) + 1) * numbers.shape[1]
        for point in along_edges(problem, kernels, parts):
            entries = (point.across.ravel(), numbers.ravel(), starts)
            rows.append(sp.csr_array(entries, shape=(len(numbers), problem.dofs.count)))
            stiffness.append(support.stiffness * point.length)
            owners.append(np.full(len(numbers), index))
    for index, foundation in enumerate(problem.foundations, start=len(problem.supports)):
        for row, own in _on_ground(problem, kernels, foundation):
            rows.append(row)
            stiffness.append(own)
            owners.append(np.full(len(own), index))
    return Springs(sp.csr_array(sp.vstack(rows)), np.concatenate(stiffness), np.concatenate(owners))


def _on_ground(
    problem: Problem, kernels: ElementKernels, foundation: ElasticFoundation
) -> Iterator[tuple[sp.csr_array, Array]]:
    """Deflections at points of the cells that lie on it, and their stiffness, N/m: k ∫ w² dA, exact for the square of a
    cubic. Raises DesignError where it is beside the plate."""
    of_w = 2 * problem.dofs.element.stretches
    every = np.arange(len(problem.mesh.cells), dtype=np.int32)
    touched = False
    for point in cell_points(problem.dofs.element.cell, problem.mesh.corners, every):
        on = foundation.covers(point.places)
        if not on.any():
            continue
        touched = True
        cells = point.cells[on]
        numbers = problem.dofs.of_cells[cells]
        shapes = shape_functions(problem, kernels, cells, point.xi[on])[:, :, of_w]
        starts = np.arange(len(cells) + 1) * numbers.shape[1]
        row = sp.csr_array((shapes.ravel(), numbers.ravel(), starts), shape=(len(cells), problem.dofs.count))
        yield row, foundation.stiffness * point.areas[on]
    if not touched:
        raise DesignError(
            f"{foundation.text} lies beside the plate, or between points of its cells; move it, or mesh finer there"
        )


def hinge_springs(problem: Problem) -> Springs:
    """Of all hinge lines of `problem`, owners by its hinges; one without stiffness has springs of stiffness zero."""
    dofs = problem.dofs
    if not problem.hinges:
        none = np.zeros(0)
        return Springs(sp.csr_array((0, dofs.count)), none, none.astype(np.int64))
    sides = hinge_sides(dofs)
    owner = np.empty(len(dofs.hinges), dtype=np.int64)
    for index, edges in enumerate(problem.hinge_edges):
        owner[np.searchsorted(dofs.hinges, edges)] = index
    stiffness = np.array([hinge.stiffness for hinge in problem.hinges])[owner]
    every = np.arange(len(owner), dtype=np.int32)
    rows, weights = [], []
    for place, weight in zip(_GAUSS, _WEIGHTS, strict=True):
        rows.append(sides.rotations(every, np.full(len(owner), 0.5 * (1.0 + place))))
        weights.append(0.5 * weight * sides.length * stiffness)
    return Springs(sp.csr_array(sp.vstack(rows)), np.concatenate(weights), np.tile(owner, len(_GAUSS)))

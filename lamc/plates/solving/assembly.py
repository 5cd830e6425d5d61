"""Assembly: from the elements of a mesh to sparse matrices, directly and again and again on one pattern.

In: kernels, a mesh and its unknowns; then sections, masses or forces. Out: symmetric sparse matrices. Never: supports,
loads, solving.

Cells are taken along a space-filling curve, so that those that meet at a node follow one another and what they add to
is still in the cache. No element matrix is kept: C adds each to the columns at once.
"""

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
import scipy.sparse as sps

from lamc.basics.checks import Array, shown
from lamc.basics.errors import DesignError
from lamc.plates.elements.definition import Element
from lamc.plates.elements.kernels import ElementKernels, Evaluator, Numbers, numbers
from lamc.plates.elements.native import CompiledAssembly, CompiledElement
from lamc.plates.meshing.mesh import Integers, Mesh


class Unknowns(Protocol):
    """What assembly asks of `Dofs`."""

    @property
    def count(self) -> int:
        """N, of all unknowns."""
        ...

    @property
    def of_cells(self) -> Integers:
        """Numbers of the cells' unknowns, shape (m, d); those of one node follow one another."""
        ...


class _Sums(Protocol):
    """Where the entries of the matrix lie, and their sums over all cells."""

    begins: Integers  # (N + 1,), of the columns
    rows: Integers  # of all entries

    def values(self, name: str, table: Array, row: Integers) -> Array:
        """Entries of the assembled matrix; cell i takes row[i] of the table."""
        ...

    def forces(self, sections: Array, row: Integers, d: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Forces on all unknowns d (N,), in their precision; cell i takes row[i] of the sections."""
        ...


class Assembly:
    """Matrices of all cells of a mesh, shape (N, N), as `scipy.sparse.csc_array`s with both triangles.

    Rows ascend in each column. The pattern is found once: all matrices share their `indices` and `indptr`, which are
    read-only. The same input gives the same bits.

    Raises DesignError where unknowns and cells do not fit together or the matrix is too large for 32-bit indices.
    """

    def __init__(self, kernels: ElementKernels, mesh: Mesh, dofs: Unknowns) -> None:
        element = kernels.element
        _check(element, mesh, dofs)
        self.kernels, self.mesh, self.count = kernels, mesh, int(dofs.count)
        self._order = _along_curve(mesh)
        self._regions = np.ascontiguousarray(mesh.regions[self._order])
        cells, of_cells = mesh.cells[self._order], dofs.of_cells[self._order]
        evaluator = kernels.evaluator
        self._sums: _Sums
        if isinstance(evaluator, CompiledElement):
            sizes = [len(node.dofs) for node in element.nodes]
            self._sums = CompiledAssembly(evaluator, sizes, mesh.points, cells, of_cells, self.count)
        else:
            self._sums = _NumpyAssembly(evaluator, mesh.points, cells, of_cells, self.count)
        for array in (self._sums.begins, self._sums.rows):
            array.flags.writeable = False

    @property
    def order(self) -> Integers:
        """Cells in the order in which their matrices are summed, (m,)."""
        return self._order

    @property
    def entry_count(self) -> int:
        """Entries of the matrix, both triangles."""
        return len(self._sums.rows)

    def stiffness(self, sections: npt.ArrayLike) -> sps.csc_array:
        """From section stiffnesses per region, shape (R, S), in the order of `mesh.region_names`."""
        table = self._per_region("sections", sections, (self.kernels.section_count,))
        return self._matrix("stiffness", table, self._regions)

    def mass(self, areal_mass: npt.ArrayLike) -> sps.csc_array:
        """From masses per area of the regions, shape (R,), kg/m²."""
        return self._matrix("mass", self._per_region("areal_mass", areal_mass, ()), self._regions)

    def geometric(self, forces: npt.ArrayLike) -> sps.csc_array:
        """From N_x, N_y, N_xy of the cells, shape (m, 3), N/m, tension positive.

        Raises UnsupportedError for a membrane, which has no deflection.
        """
        self.kernels.check_bends()
        table = numbers("forces", forces, (3,), len(self.mesh.cells), float)
        return self._matrix("geometric", table, self._order)

    def force(self, sections: npt.ArrayLike, d: npt.ArrayLike) -> Numbers:
        """∫ Bᵀ (S (B d)) dA, shape (N,), of unknowns d (N,): the stiffness times d by way of the strains.

        Computed in the precision of d, float or numpy.longdouble. Sections as for `stiffness`.
        """
        table = self._per_region("sections", sections, (self.kernels.section_count,))
        dtype = np.longdouble if np.asarray(d).dtype == np.dtype(np.longdouble) else float
        unknowns = numbers("d", d, (), self.count, dtype, "one number per unknown")
        return self._sums.forces(table, self._regions, unknowns.reshape(-1))

    def _per_region(self, label: str, values: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
        names = self.mesh.region_names
        listed = ", ".join(map(repr, names[:8]))
        return numbers(label, values, shape, len(names), float, f"one row per region ({listed})")

    def _matrix(self, name: str, table: Array, row: Integers) -> sps.csc_array:
        sums = self._sums
        matrix = sps.csc_array(
            (sums.values(name, table, row), sums.rows, sums.begins), shape=(self.count, self.count)
        )
        matrix.indices, matrix.indptr = sums.rows, sums.begins  # scipy made views
        matrix.has_canonical_format = True  # known, so that scipy does not look
        return matrix


def _check(element: Element, mesh: Mesh, dofs: Unknowns) -> None:
    """Numbers that C may follow: raises DesignError for all others."""
    if not isinstance(mesh, Mesh):
        raise DesignError(f"the mesh is {shown(mesh)}; it must be a Mesh")
    of_cells, count = np.asarray(dofs.of_cells), int(dofs.count)
    wanted = (len(mesh.cells), len(element.dofs))
    if mesh.corner_count != element.corner_count:
        raise DesignError(
            f"element {shown(element.name)} has {element.corner_count} corners and the cells of the mesh "
            f"{mesh.corner_count}; choose an element for these cells"
        )
    if of_cells.shape != wanted or of_cells.dtype != np.int32:
        raise DesignError(
            f"the unknowns of the cells have shape {of_cells.shape} and type {of_cells.dtype}; element "
            f"{shown(element.name)} needs int32 of shape {wanted}: number them with Dofs(mesh, element)"
        )
    if of_cells.size and not 0 <= of_cells.min() <= of_cells.max() < count:
        raise DesignError(
            f"the unknowns of the cells run from {of_cells.min()} to {of_cells.max()}; there are {count}, from 0"
        )
    local = np.concatenate([np.arange(len(node.dofs), dtype=np.int32) for node in element.nodes])
    size = np.repeat([len(node.dofs) for node in element.nodes], [len(node.dofs) for node in element.nodes])
    first = of_cells - local
    place, owned = np.full(count, -1, dtype=np.int32), np.zeros(count, dtype=np.int32)
    place[of_cells], owned[of_cells] = local, size
    start = np.cumsum([0, *(len(node.dofs) for node in element.nodes[:-1])])
    together = np.array_equal(first, np.repeat(of_cells[:, start], size[start], axis=1))
    if not together or np.any(place[of_cells] != local) or np.any(owned[of_cells] != size):
        raise DesignError(
            f"the unknowns of a node of {shown(element.name)} must follow one another and belong to it alone: number "
            "them with Dofs(mesh, element)"
        )


def _along_curve(mesh: Mesh) -> Integers:
    """Cells in the order of their centres along the Z-order curve (G. M. Morton, IBM, 1966), 16 bits per axis."""
    centre = np.zeros((len(mesh.cells), 2))
    for corner in mesh.cells.T:
        centre += mesh.points[corner]
    low, high = centre.min(axis=0), centre.max(axis=0)
    extent = max(float((high - low).max()), np.finfo(float).tiny)
    grid = ((centre - low) / extent * 65535.0).astype(np.uint32)
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        grid = (grid | (grid << np.uint32(shift))) & np.uint32(mask)
    code = grid[:, 0] | (grid[:, 1] << np.uint32(1))
    return np.argsort(code, kind="stable").astype(np.int32)


class _NumpyAssembly:
    """The same sums with numpy, for interpreted kernels: all element matrices at once."""

    def __init__(
        self, evaluator: Evaluator, points: Array, cells: Integers, of_cells: Integers, count: int
    ) -> None:
        self._evaluator, self._count, self._size = evaluator, count, of_cells.shape[1]
        self._corners = np.ascontiguousarray(points[cells].reshape(len(cells), -1))
        self._of_cells = of_cells
        self._rows = np.tile(of_cells, self._size).ravel()
        self._columns = np.repeat(of_cells, self._size, axis=1).ravel()
        pattern = self._summed(np.ones(len(self._rows)))
        self.begins, self.rows = pattern.indptr.astype(np.int32), pattern.indices.astype(np.int32)

    def values(self, name: str, table: Array, row: Integers) -> Array:
        """Entries of the assembled matrix; cell i takes row[i] of the table."""
        inputs = [self._corners, np.ascontiguousarray(table[row])]
        matrices = self._evaluator.values(name, inputs, (self._size, self._size), float)
        return np.asarray(self._summed(matrices.ravel()).data)

    def forces(self, sections: Array, row: Integers, d: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Forces on all unknowns d (N,), in their precision; cell i takes row[i] of the sections."""
        inputs = [a.astype(d.dtype) for a in (self._corners, sections[row])] + [d[self._of_cells]]
        total = np.zeros_like(d)
        np.add.at(total, self._of_cells, self._evaluator.values("force", inputs, (self._size,), d.dtype))
        return total

    def _summed(self, values: Array) -> sps.csc_array:
        summed = sps.coo_array((values, (self._rows, self._columns)), shape=(self._count,) * 2).tocsc()
        summed.sum_duplicates()
        return summed

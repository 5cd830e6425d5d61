"""From the matrix of all unknowns to that of the free ones, without a product of matrices each time.

In: the pattern of a symmetric matrix, and orthonormal columns with at most two entries per row. Out: columnsᵀ K columns
for any values on that pattern, by a gather. Never: knows what is held, or why.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from lamc.mechanism.checks import Array
from lamc.plate.meshing.mesh import Integers


class Reduction:
    """columnsᵀ K columns for matrices K of one pattern.

    columns  (N, f), as `Constraints.free`: rows with a single 1, and pairs of rows for oblique axes
    pattern  a sorted (N, N) matrix in compressed columns with the pattern of every K

    Entries of unknowns that are simply free keep their order, so they are picked out; those of oblique axes are summed.
    """

    def __init__(self, columns: sp.csr_array, pattern: sp.csc_array) -> None:
        count, self.size = columns.shape
        entries = np.diff(columns.indptr)
        assert entries.max(initial=0) <= 1, "a row of oblique axes has one free unknown"
        number, weight = np.full(count, -1, dtype=np.int32), np.zeros(count)
        rows = np.flatnonzero(entries)
        number[rows], weight[rows] = columns.indices, columns.data
        free = number >= 0
        shared = np.bincount(columns.indices, minlength=self.size) > 1
        oblique = np.append(shared, False)[number]  # -1, what is held, takes the last
        per_column = np.diff(pattern.indptr)
        plain = (free & ~oblique)[pattern.indices] & np.repeat(free & ~oblique, per_column)
        self._plain = np.flatnonzero(plain)
        self._indices: Integers = number[pattern.indices[self._plain]]
        before = np.concatenate([[0], np.cumsum(plain)])  # entries of earlier columns that are kept
        ends = before[pattern.indptr[1:]][free & ~oblique]
        self._indptr: Integers = np.concatenate([[0], ends]).astype(np.int32)
        self._place: NDArray[np.int64] | slice = slice(None)  # plain entries alone are in order already
        self._sums = sp.csr_array((0, len(pattern.indices)))
        if oblique.any():
            column_of = np.repeat(np.arange(count), per_column)
            both = free[pattern.indices] & free[column_of]
            self._add_sums(number, weight, pattern.indices, column_of, np.flatnonzero(both & ~plain))

    def _add_sums(
        self,
        number: Integers,
        weight: Array,
        row_of: Integers,
        column_of: NDArray[np.int64],
        summed: NDArray[np.int64],
    ) -> None:
        """Entries `summed` of the pattern, which concern oblique axes, merged with the plain ones."""
        a, b = number[row_of[summed]], number[column_of[summed]].astype(np.int64)
        own, group = np.unique(b * self.size + a, return_inverse=True)
        factors = weight[row_of[summed]] * weight[column_of[summed]]
        self._sums = sp.csr_array((factors, (group, summed)), shape=(len(own), len(row_of)))
        plain = number[column_of[self._plain]].astype(np.int64) * self.size + self._indices
        merged = np.concatenate([plain, own])
        order = np.argsort(merged, kind="stable")
        self._place = np.empty(len(merged), dtype=np.int64)
        self._place[order] = np.arange(len(merged))
        ends = np.searchsorted(merged[order], np.arange(self.size + 1) * self.size)
        self._indptr = ends.astype(np.int32)
        self._indices = (merged[order] % max(self.size, 1)).astype(np.int32)

    def matrix(self, data: Array) -> sp.csc_array:
        """For the matrix with these values on the pattern; every result shares the arrays of its pattern."""
        entries = data[self._plain]
        if self._sums.shape[0]:
            entries = np.concatenate([entries, self._sums @ data])
        values = np.empty(len(self._indices))
        values[self._place] = entries
        return sp.csc_array((values, self._indices, self._indptr), shape=(self.size, self.size))

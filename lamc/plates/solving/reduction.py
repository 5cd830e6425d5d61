"""From the matrix of all unknowns to that of the free ones, without a product of matrices each time.

In: the pattern of a symmetric matrix, and orthonormal columns with few entries per row. Out: columnsᵀ K columns
for any values on that pattern, by a gather. Never: knows what is held, or why.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from lamc.basics.checks import Array
from lamc.plates.meshing.mesh import Integers


class Reduction:
    """columnsᵀ K columns for matrices K of one pattern.

    columns  (N, f), as `Constraints.free`: rows with a single 1, and rows of several unknowns that move together
    pattern  a sorted (N, N) matrix in compressed columns with the pattern of every K

    Entries of unknowns that are simply free keep their order, so they are picked out; those of oblique axes, and of
    nodes along hinge lines, are summed.
    """

    def __init__(self, columns: sp.csr_array, pattern: sp.csc_array) -> None:
        count, self.size = columns.shape
        entries = np.diff(columns.indptr)
        uses = np.bincount(columns.indices, minlength=self.size)
        free = entries > 0
        alone = np.zeros(count, dtype=bool)
        single = columns.indptr[:-1][entries == 1]
        alone[entries == 1] = (uses[columns.indices[single]] == 1) & (columns.data[single] == 1.0)
        number = np.full(count, -1, dtype=np.int32)
        number[alone] = columns.indices[columns.indptr[:-1][alone]]
        per_column = np.diff(pattern.indptr)
        plain = alone[pattern.indices] & np.repeat(alone, per_column)
        self._plain = np.flatnonzero(plain)
        self._indices: Integers = number[pattern.indices[self._plain]]
        before = np.concatenate([[0], np.cumsum(plain)])  # entries of earlier columns that are kept
        self._indptr: Integers = np.concatenate([[0], before[pattern.indptr[1:]][alone]]).astype(np.int32)
        self._place: NDArray[np.int64] | slice = slice(None)  # plain entries alone are in order already
        self._sums = sp.csr_array((0, len(pattern.indices)))
        if not np.array_equal(free, alone):
            column_of = np.repeat(np.arange(count), per_column)
            summed = np.flatnonzero(free[pattern.indices] & free[column_of] & ~plain)
            self._add_sums(columns, number, pattern.indices, column_of, summed)

    def _add_sums(
        self,
        columns: sp.csr_array,
        number: Integers,
        row_of: Integers,
        column_of: NDArray[np.int64],
        summed: NDArray[np.int64],
    ) -> None:
        """Entries `summed` of the pattern, of unknowns that move with others, merged with the plain ones."""
        begin, entries = columns.indptr[:-1], np.diff(columns.indptr)
        row, column = row_of[summed], column_of[summed]
        times = entries[row] * entries[column]
        source = np.repeat(np.arange(len(summed)), times)
        within = np.arange(len(source)) - np.repeat(np.cumsum(times) - times, times)
        per_row = entries[column][source]
        first, second = begin[row][source] + within // per_row, begin[column][source] + within % per_row
        a, b = columns.indices[first], columns.indices[second].astype(np.int64)
        own, group = np.unique(b * self.size + a, return_inverse=True)
        factors = columns.data[first] * columns.data[second]
        self._sums = sp.csr_array((factors, (group, summed[source])), shape=(len(own), len(row_of)))
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

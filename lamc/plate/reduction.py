"""From the matrix of all unknowns to that of the free ones, without a product of matrices each time.

In: the pattern of a symmetric matrix, and orthonormal columns with at most two entries per row. Out: columnsᵀ K columns
for any values on that pattern, by a gather. Never: knows what is held, or why.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from lamc.mechanism.checks import Array
from lamc.plate.mesh import Integers


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
        number, weight = np.full(count, -1, dtype=np.int64), np.zeros(count)
        rows = np.flatnonzero(entries)
        number[rows], weight[rows] = columns.indices, columns.data
        column_of = np.repeat(np.arange(count), np.diff(pattern.indptr))
        a, b = number[pattern.indices], number[column_of]
        kept = np.flatnonzero((a >= 0) & (b >= 0))
        shared = np.append(np.bincount(columns.indices, minlength=self.size) > 1, False)  # [-1]: not free
        plain = ~shared[a[kept]] & ~shared[b[kept]]
        keys = b[kept] * self.size + a[kept]
        self._plain, oblique = kept[plain], kept[~plain]
        own, group = np.unique(keys[~plain], return_inverse=True)
        factors = weight[pattern.indices[oblique]] * weight[column_of[oblique]]
        self._sums = sp.csr_array((factors, (group, oblique)), shape=(len(own), len(pattern.indices)))
        merged = np.concatenate([keys[plain], own])
        self._place: NDArray[np.int64] | slice = slice(None)  # plain entries alone are in order already
        if len(own):
            order = np.argsort(merged, kind="stable")
            self._place = np.empty(len(merged), dtype=np.int64)
            self._place[order] = np.arange(len(merged))
            merged = merged[order]
        self._indptr: Integers = np.searchsorted(merged, np.arange(self.size + 1) * self.size).astype(
            np.int32
        )
        self._indices: Integers = (merged % max(self.size, 1)).astype(np.int32)

    def matrix(self, data: Array) -> sp.csc_array:
        """For the matrix with these values on the pattern; every result shares the arrays of its pattern."""
        entries = data[self._plain]
        if self._sums.shape[0]:
            entries = np.concatenate([entries, self._sums @ data])
        values = np.empty(len(self._indices))
        values[self._place] = entries
        return sp.csc_array((values, self._indices, self._indptr), shape=(self.size, self.size))

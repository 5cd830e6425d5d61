"""Which entries a sparse matrix of equations has, and the order in which it is eliminated.

In: what the compiler finds at one position. Out: records that the emitted C follows as tables. Never: holds a number.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True)
class PlanStep:
    """One step of an elimination: a row, freed of what earlier steps eliminated; the rates left, the pivot's first."""

    row: int
    updates: tuple[int, ...]
    left: tuple[int, ...]


@dataclass(frozen=True)
class Pattern:
    """Which entries a matrix of equations (m) by rates (nu) has, and how it is eliminated.

    rows  rates of each row, ascending; values come in this order, row by row
    plan  steps to follow while their pivots are large enough; empty: the matrix is eliminated as one array
    """

    rows: tuple[tuple[int, ...], ...]
    plan: tuple[PlanStep, ...] = ()

    @property
    def entry_count(self) -> int:
        return sum(map(len, self.rows))

    def dense(self, entries: npt.NDArray[np.float64], count: int) -> npt.NDArray[np.float64]:
        """The matrix (…, m, count) of entries (…, entry_count)."""
        matrix = np.zeros((*entries.shape[:-1], len(self.rows), count))
        places = [(i, j) for i, row in enumerate(self.rows) for j in row]
        if places:
            rows, columns = np.array(places).T
            matrix[..., rows, columns] = entries
        return matrix

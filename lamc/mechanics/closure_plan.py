"""Which entries the Jacobian of the closure has, and a plan to eliminate it row by row.

In: a `Closure`, a closed position of its loops. Out: a `Pattern`. Of the rows whose largest entry is at least a tenth
of the largest of all, the one with the fewest entries comes next, and its largest is the pivot (threshold pivoting;
I. S. Duff, A. M. Erisman, J. K. Reid, "Direct methods for sparse matrices"): few rows fill up, and stages of a step,
which are not quite closed, are projected well. The runtime follows the plan wherever its pivots are large enough, and
looks for an order of its own elsewhere. Never: decides which equations hold.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from lamc.mechanics.closure import Closure
from lamc.symbolic.evaluate import evaluate
from lamc.symbolic.pattern import Pattern, PlanStep
from lamc.symbolic.scalars import Value

OF_LARGEST = 0.1  # of the largest of a row, that is left or was there: what a pivot has at least
ALIKE = (
    1.0 - 1e-6
)  # likewise: what is so near to the largest is as large, and the first of them is taken: in a sheet of
# like vertices round-off would choose, of another machine or of a scaled drawing another one
NOTHING = 1e-9  # of the largest of a row: less is round-off of a position that closes to 1e-12
# Rates up to which J stays one array: complete pivoting passes singular positions in single precision too, where rows
# taken one after the other come apart: a Bricard linkage, an N-four-bar of three loops (`test_export_float_loops.py`)
FEW = 10
# An order that is looked for takes so many times what a plan takes; so it does where no position of full rank is known
LOOKED_FOR = 3.0


def pattern_of(closure: Closure, q: Sequence[Value], rank: int, position: Sequence[float]) -> Pattern:
    """The pattern. position: closed, (len(q),); empty: none is known, and there is no plan."""
    rows = tuple(tuple(j for j, _ in row) for row in closure.jacobian)
    plan = plan_of(_values(closure, q, position), rank) if len(position) == len(q) else ()
    return Pattern(rows, plan if _is_cheaper(plan, len(rows), len(q), rank) else ())


def _values(closure: Closure, q: Sequence[Value], position: Sequence[float]) -> list[dict[int, float]]:
    """Rows of J at the position, their largest entry one; rows of nought are empty."""
    flat = [value for row in closure.jacobian for _, value in row]
    values = iter(evaluate(q[0].store, flat, dict(zip(q, position, strict=True))))
    rows = [{j: next(values) for j, _ in row} for row in closure.jacobian]
    scales = [max(map(abs, row.values()), default=0.0) for row in rows]
    least = NOTHING * max(scales, default=0.0)
    return [
        {j: v / scale for j, v in row.items()} if scale > least else {}
        for row, scale in zip(rows, scales, strict=True)
    ]


def _is_cheaper(plan: Sequence[PlanStep], m: int, n: int, rank: int) -> bool:
    """Whether there are many rates, and the plan has fewer products than elimination of an array, of which half is
    nought."""
    if n <= FEW or not plan:
        return False
    left = [len(step.left) for step in plan]
    planned = sum(left[k] for step in plan for k in step.updates) + 2 * sum(left)
    array = sum((m - k) * (n - k) for k in range(rank)) / 2
    return planned < array if len(plan) == rank else LOOKED_FOR * planned < array


def plan_of(rows: list[dict[int, float]], rank: int) -> tuple[PlanStep, ...]:
    """As many steps as there are independent rows, at most `rank`."""
    elimination = _Elimination(rows)
    while len(elimination.steps) < rank and elimination.peaks.max(initial=0.0) > NOTHING:
        elimination.take(elimination.sparsest())
    return tuple(elimination.steps)


class _Elimination:
    """Steps so far, and what is left of all rows; entries that are nought at the position are kept."""

    def __init__(self, rows: list[dict[int, float]]) -> None:
        self.steps: list[PlanStep] = []
        self.peaks = np.zeros(len(rows))  # of what is left; 0 for rows that have become steps
        self._rows = rows
        self._lengths = np.zeros(len(rows))
        self._updates: list[list[int]] = [[] for _ in rows]
        self._knows: dict[int, set[int]] = {}
        for i, row in enumerate(rows):
            self._note(i, row)
        self._look(range(len(rows)))

    def sparsest(self) -> int:
        """The row that comes next."""
        length = np.where(self.peaks >= OF_LARGEST * self.peaks.max(), self._lengths, np.inf)
        alike = np.flatnonzero(length == length.min())
        peaks = self.peaks[alike]
        return int(alike[np.argmax(peaks >= ALIKE * peaks.max())])

    def take(self, index: int) -> None:
        """That row becomes a step, and the others lose its pivot."""
        row, self._rows[index] = self._rows[index], {}
        least = ALIKE * max(map(abs, row.values()))
        pivot = min(j for j, v in row.items() if abs(v) >= least)
        step = PlanStep(index, tuple(self._updates[index]), (pivot, *(j for j in row if j != pivot)))
        for j in row:
            self._knows[j].discard(index)
        others = sorted(self._knows.pop(pivot))
        for i in others:
            other = self._rows[i]
            factor = other.pop(pivot) / row[pivot]
            for j in step.left[1:]:
                other[j] = other.get(j, 0.0) - factor * row[j]
            self._updates[i].append(len(self.steps))
            self._note(i, step.left[1:])
        self.steps.append(step)
        self._look((index, *others))

    def _note(self, i: int, rates: Iterable[int]) -> None:
        for j in rates:
            self._knows.setdefault(j, set()).add(i)

    def _look(self, rows: Iterable[int]) -> None:
        for i in rows:
            self.peaks[i] = max(map(abs, self._rows[i].values()), default=0.0)
            self._lengths[i] = len(self._rows[i])

"""Which entries the Jacobian of the closure has, and a plan to eliminate it row by row.

In: a `Closure`, a closed position of its loops. Out: a `Pattern`. Of the rows whose largest entry is at least a tenth
of the largest of all, one with the fewest entries comes next, and of its large ones the pivot is what fewest other rows
know (threshold pivoting with Markowitz's count; I. S. Duff, A. M. Erisman, J. K. Reid, "Direct methods for sparse
matrices"): few rows fill up, and stages of a step, which are not quite closed, are projected well. The runtime follows
the plan wherever its pivots are large enough, and looks for an order of its own elsewhere. Never: decides which
equations hold.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

import numpy as np

from lamc.loops.rank import LoopCount
from lamc.mechanics.closure import Closure
from lamc.symbolic.evaluate import evaluate
from lamc.symbolic.pattern import Pattern, PlanStep
from lamc.symbolic.scalars import Value

OF_LARGEST = 0.1  # of the largest of a row, that is left or was there: what a pivot has at least
# Likewise: what has so much of the largest is taken for as large. The largest alone would be another one at another
# fold angle, and in a sheet of like vertices by round-off, and with it the program. Of plans by these shares the first
# is taken that is about as good as the best of them: 0.3 does for folded sheets, where plans by the largest are often
# worse; that of a flat one of 8 x 8 facets would have 20 times the noise, and run 1.5 times the steps.
ALIKE = (0.3, 0.5, 0.7, 1.0 - 1e-6)
NOISE, WORK = 3.0, 1.5  # times the least of those plans: as good
NOTHING = 1e-9  # of the largest of a row: less is round-off of a position that closes to 1e-12
# Rates up to which J stays one array: complete pivoting passes singular positions in single precision too, where rows
# taken one after the other come apart: a Bricard linkage, an N-four-bar of three loops (`test_export_float_loops.py`)
FEW = 10
# An order that is looked for takes so many times what a plan takes; so it does where no position of full rank is known
LOOKED_FOR = 3.0


def pattern_of(closure: Closure, q: Sequence[Value], loops: LoopCount) -> Pattern:
    """The pattern. loops: what they come to, at a closed position (len(q),); where none is known, there is no plan."""
    rows, rank = tuple(tuple(j for j, _ in row) for row in closure.jacobian), loops.rank
    if len(loops.position) != len(q):
        return Pattern(rows)
    # Where loops fit badly, equations that are left out stay open by the misfit times what they have of the others: of
    # rounded sheets, by more than is accepted, unless the largest come first.
    shares = ALIKE[-1:] if loops.accepted_gap else ALIKE
    values = tuple(tuple(row.items()) for row in _values(closure, q, loops.position))
    plan = _best_plan(values, rank, shares)
    return Pattern(rows, plan if _is_cheaper(plan, len(rows), len(q), rank) else ())


@lru_cache(maxsize=2)  # a design that is new is planned twice: as it is surveyed, and as it is derived
def _best_plan(
    rows: tuple[tuple[tuple[int, float], ...], ...], rank: int, shares: tuple[float, ...]
) -> tuple[PlanStep, ...]:
    """The first of the plans by these shares that is about as good as any; where none is, that of least noise."""
    made = [eliminated([dict(row) for row in rows], rank, share) for share in shares]
    quietest = min(made, key=lambda each: each.most_noise)
    noise, work = NOISE * quietest.most_noise, WORK * min(each.work for each in made)
    good = (each for each in made if each.most_noise <= noise and each.work <= work)
    return tuple(next(good, quietest).steps)


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


def eliminated(rows: Sequence[Mapping[int, float]], rank: int, alike: float = ALIKE[-1]) -> "Elimination":
    """By as many steps as there are independent rows, at most `rank`. alike: of the largest, what counts as large."""
    elimination = Elimination(rows, alike)
    while len(elimination.steps) < rank and elimination.peaks.max(initial=0.0) > NOTHING:
        elimination.take(elimination.sparsest())
    return elimination


class Elimination:
    """Steps so far, and what is left of all rows; entries that are nought at the position are kept.

    work  products of rows with what steps have left; most_noise: how many times the round-off of one row, or what a
          state is off, a step has of all that it took
    """

    def __init__(self, rows: Sequence[Mapping[int, float]], alike: float) -> None:
        self.alike = alike
        self.steps: list[PlanStep] = []
        self.peaks = np.zeros(len(rows))  # of what is left; 0 for rows that have become steps
        self.work, self.most_noise = 0, 1.0
        self._rows = [dict(row) for row in rows]
        self._noise = [1.0] * len(rows)
        self._lengths = np.zeros(len(rows))
        self._updates: list[list[int]] = [[] for _ in rows]
        self._knows: dict[int, set[int]] = {}
        for i, row in enumerate(rows):
            for j in row:
                self._knows.setdefault(j, set()).add(i)
        self._look(range(len(rows)))

    def sparsest(self) -> int:
        """The row that comes next."""
        length = np.where(self.peaks >= OF_LARGEST * self.peaks.max(), self._lengths, np.inf)
        alike = np.flatnonzero(length == length.min())
        peaks = self.peaks[alike]
        return int(alike[np.argmax(peaks >= self.alike * peaks.max())])

    def take(self, index: int) -> None:
        """That row becomes a step, and the others lose its pivot: of the large ones what fewest other rows know."""
        row, self._rows[index] = self._rows[index], {}
        least = self.alike * max(map(abs, row.values()))
        for j in row:
            self._knows[j].discard(index)
        pivot = min((len(self._knows[j]), j) for j, v in row.items() if abs(v) >= least)[1]
        step = PlanStep(index, tuple(self._updates[index]), (pivot, *(j for j in row if j != pivot)))
        others, left = sorted(self._knows.pop(pivot)), [(j, row[j]) for j in step.left[1:]]
        for i in others:
            other = self._rows[i]
            factor = other.pop(pivot) / row[pivot]
            for j, value in left:
                known = other.get(j)
                if known is None:
                    other[j] = 0.0 - factor * value
                    self._knows[j].add(i)
                else:
                    other[j] = known - factor * value
            self._updates[i].append(len(self.steps))
            self._noise[i] += abs(factor) * self._noise[index]
        self.work += len(others) * len(row)
        self.most_noise = max(self.most_noise, self._noise[index])
        self.steps.append(step)
        self._look((index, *others))

    def _look(self, rows: Iterable[int]) -> None:
        for i in rows:
            self.peaks[i] = max(map(abs, self._rows[i].values()), default=0.0)
            self._lengths[i] = len(self._rows[i])

"""Plans of elimination of large loops: their pivots where they were made, and how far along a motion they hold.

What the runtime does with a plan is done here once more, in Python, on the Jacobian of the closure in numbers.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lamc.loops.geometry import geometry_of
from lamc.loops.rank import count_loops
from lamc.loops.walks import walk
from lamc.mechanics.arranging import arrange
from lamc.mechanics.assembly import symbols_of
from lamc.mechanics.closure import Closure, close_cycles
from lamc.mechanics.closure_plan import pattern_of
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Array, Mechanism
from lamc.symbolic.evaluate import evaluate
from lamc.symbolic.pattern import Pattern
from lamc.symbolic.scalars import Value
from tests.support.sheets import folded_miura, sheet

PLANNED = 0.02  # runtime_c/src/loop_sparse.h: a pivot of less, or of less of its row, and the plan is left


@dataclass(frozen=True)
class Planned:
    closure: Closure
    q: Sequence[Value]
    pattern: Pattern
    position: tuple[float, ...]
    rank: int


def planned(mechanism: Mechanism) -> Planned:
    tree = plan(mechanism)
    loops, symbols = count_loops(tree), symbols_of(arrange(tree, ()), {})
    closure = close_cycles(tree, symbols.q, symbols.u)
    pattern = pattern_of(closure, symbols.q, loops)
    return Planned(closure, symbols.q, pattern, loops.position, loops.rank)


def least_pivot(of: Planned, position: Sequence[float]) -> tuple[float, float]:
    """The least pivot of the plan at a position, and the least beside the largest of its row."""
    flat = [value for row in of.closure.jacobian for _, value in row]
    values = iter(evaluate(of.q[0].store, flat, dict(zip(of.q, position, strict=True))))
    rows = [{j: next(values) for j, _ in row} for row in of.closure.jacobian]
    taken: list[tuple[tuple[int, ...], dict[int, float]]] = []
    least, beside = np.inf, np.inf
    for step in of.pattern.plan:
        row = dict(rows[step.row])
        for k in step.updates:
            (pivot, *others), known = taken[k]
            factor = row.pop(pivot, 0.0) / known[pivot]
            for j in others:
                row[j] = row.get(j, 0.0) - factor * known[j]
        left = {j: row.get(j, 0.0) for j in step.left}
        assert set(row) <= set(left)  # nothing is lost
        size, most = abs(left[step.left[0]]), max(map(abs, left.values()))
        least, beside = min(least, size), min(beside, size / most if most else 0.0)
        if not size:
            return 0.0, 0.0
        taken.append((step.left, left))
    return float(least), float(beside)


def along(mechanism: Mechanism, steps: int) -> list[Array]:
    """Closed positions along the motion of a sheet, both ways, 0.1 rad apart."""
    geometry = geometry_of(plan(mechanism))
    drawn = np.zeros(len(geometry.names))
    (way,) = geometry.linear(drawn).free()
    return [place.angles for sign in (1.0, -1.0) for place in walk(geometry, drawn, sign * way, 1e-11, steps)]


@pytest.mark.parametrize("theta", [0.5, 1.0, 1.4])
@pytest.mark.parametrize("count", [3, 5])
def test_a_plan_holds_nearly_all_along_the_fold(count: int, theta: float) -> None:
    """But next to the flat positions, where the sheet is singular."""
    mechanism = sheet(folded_miura(count, theta))
    found, places = planned(mechanism), along(mechanism, 24)
    assert len(places) > 24
    held = [min(least_pivot(found, place)) > PLANNED for place in places]
    assert np.mean(held) > 0.9


@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 2**32 - 1), theta=st.floats(0.3, 1.45))
def test_pivots_are_large_where_the_plan_was_made(seed: int, theta: float) -> None:
    """0.3 of their row or more (`ALIKE`), less round-off; a row that is taken has a tenth of the largest there is."""
    vertices = folded_miura(3, theta)
    rough = vertices + np.random.default_rng(seed).normal(0.0, 0.01, vertices.shape)
    found = planned(sheet(rough, diagonals=True))
    if found.pattern.plan:
        assert len(found.pattern.plan) == found.rank
        assert least_pivot(found, found.position)[1] > 0.3 * (1 - 1e-9)

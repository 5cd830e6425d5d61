"""Forms by vertices that have no common zero: the search for one ends early, and tells none."""

from dataclasses import dataclass, field

import numpy as np

from lamc.loops.local_forms import LocalForms
from lamc.loops.tangents import EXACTLY, Tangents
from lamc.loops.zeros import FEWEST_IN_VAIN, IN_VAIN, USUAL_FREE, arrivals
from lamc.records.mechanism import Array


@dataclass(frozen=True, eq=False)
class _Counted(LocalForms):
    asked: list[Array] = field(default_factory=list)

    def nearest(self, basis: Array, rates: Array, rounds: int = 60) -> Array | None:
        self.asked.append(rates)
        return super().nearest(basis, rates, rounds)


def _tangents(matrix: list[list[float]], count: int) -> tuple[_Counted, Tangents]:
    """One form for each of `count` vertices, of two creases of its own."""
    joints = np.arange(2 * count).reshape(count, 2)
    local = _Counted(((joints, np.tile(np.array(matrix), (count, 1, 1))),), np.ones(2 * count, bool))
    return local, Tangents(np.eye(2 * count), np.zeros((0, 2 * count, 2 * count)), local)


def test_a_sum_of_squares_has_no_zero_and_few_starts_are_tried() -> None:
    local, tangents = _tangents([[1.0, 0.0], [0.0, 1.0]], 12)
    starts = np.random.default_rng(1).normal(size=(IN_VAIN + 40, 24))
    assert arrivals(tangents, starts, EXACTLY).shape == (0, 24)
    assert len(local.asked) == IN_VAIN


def test_of_many_free_rates_fewer_starts_are_tried() -> None:
    """Each costs the cube of their number."""
    local, tangents = _tangents([[1.0, 0.0], [0.0, 1.0]], USUAL_FREE)
    starts = np.random.default_rng(1).normal(size=(IN_VAIN, 2 * USUAL_FREE))
    assert arrivals(tangents, starts, EXACTLY).shape == (0, 2 * USUAL_FREE)
    assert len(local.asked) == IN_VAIN // 8 >= FEWEST_IN_VAIN


def test_where_one_start_arrives_all_are_tried_or_enough() -> None:
    """u v = 0: one of two creases stands still."""
    local, tangents = _tangents([[0.0, 0.5], [0.5, 0.0]], 12)
    count = IN_VAIN + 40
    starts = np.random.default_rng(2).normal(size=(count, 24))
    found = arrivals(tangents, starts, EXACTLY)
    assert len(local.asked) == count
    assert len(found) > IN_VAIN
    # Newton's method arrives at 1e-12 of a form, of rates of length one.
    assert np.abs(found[:, 0::2] * found[:, 1::2]).max() < 1e-11
    local.asked.clear()
    assert 0 < len(arrivals(tangents, starts, EXACTLY, enough=8)) <= 8
    assert len(local.asked) == 8

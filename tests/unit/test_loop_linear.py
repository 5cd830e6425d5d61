"""Closure matrices taken apart sparsely, by their dense decomposition."""

import numpy as np
import pytest
from scipy import sparse

from lamc.loops.linear import BEYOND, BLOCK, DENSE, WEAK, Linear
from lamc.records.mechanism import Array


def matrix(rows: int, columns: int, weak: int) -> Array:
    """A few entries in each row, and `weak` singular values of 1e-4 beside those of one."""
    random = np.random.default_rng(rows + columns)
    full = random.normal(size=(rows, columns)) * (random.random((rows, columns)) < 0.1)
    left, values, right = np.linalg.svd(full, full_matrices=False)
    values = np.linspace(2.0, 1.0, len(values))
    values[len(values) - weak :] = 1e-4
    return np.asarray((left * values) @ right)


@pytest.mark.parametrize(("rows", "columns"), [(20, 100), (60, 61), (120, 261)])
def test_all_that_few_equations_leave_free_is_found(rows: int, columns: int) -> None:
    """As of a sheet with a hole, around which there are more creases than its loop has equations."""
    assert columns > DENSE
    full = matrix(rows, columns, 0)
    linear = Linear(sparse.csr_array(full))
    assert linear.rank() == rows
    free = linear.free()
    assert free.shape == (columns - rows, columns)
    assert np.abs(free @ free.T - np.eye(columns - rows)).max() < 1e-12
    assert np.abs(full @ free.T).max() < 1e-12  # round-off of sums of hundreds


@pytest.mark.parametrize(("rows", "columns"), [(40, 100), (100, 70)])
def test_what_holds_weakly_is_left_alone(rows: int, columns: int) -> None:
    full = matrix(rows, columns, 12)
    goal = np.random.default_rng(7).normal(size=rows)
    left, values, right = np.linalg.svd(full, full_matrices=False)
    kept = values > 5e-3 * values[0]
    expected = (goal @ left[:, kept] / values[kept]) @ right[kept]
    linear = Linear(sparse.csr_array(full))
    # Two per cent: the largest singular value is known to some hundredths, and a cutoff has no need of more.
    # What a weak direction holds is known to round-off over its singular value, 2e-12; twelve of them together take as
    # much away from a goal of length 6 to 10: 2e-12 x 12 x 10 at most.
    assert linear.least_change(goal, 5e-3) == pytest.approx(expected, abs=2.4e-10)
    nullity = columns - int(np.count_nonzero(kept))
    assert 1e-4 < linear.amid(nullity) < 1.0


@pytest.mark.parametrize("cutoff", [1e-3, 5e-3, 2e-2])
def test_what_is_left_alone_need_be_no_weaker_by_far(cutoff: float) -> None:
    """Of singular values that lie close together, those beside the cutoff are told apart by what iteration gives."""
    random = np.random.default_rng(5)
    full = random.normal(size=(140, 110)) * (random.random((140, 110)) < 0.1)
    left, _, right = np.linalg.svd(full, full_matrices=False)
    values = np.geomspace(1.0, 1e-4, 110)
    goal = random.normal(size=140)
    linear = Linear(sparse.csr_array((left * values) @ right))
    kept = values > cutoff * linear.scale
    expected = (goal @ left[:, kept] / values[kept]) @ right[kept]
    # Neighbours are 8 % apart, and by a round the part of one in the other shrinks by a sixth: a step of Newton's
    # method, which the next one mends.
    assert linear.least_change(goal, cutoff) == pytest.approx(
        expected, abs=0.02 * float(np.abs(expected).max())
    )


@pytest.mark.parametrize("cutoff", [5e-3, 2e-2, 5e-2])
def test_no_rate_that_a_cutoff_leaves_free_is_missed(cutoff: float) -> None:
    """All that may be a misfit's is looked for, and more where more is asked for: 64 rates, and not the first eight."""
    random = np.random.default_rng(6)
    full = random.normal(size=(300, 140)) * (random.random((300, 140)) < 0.1)
    left, _, right = np.linalg.svd(full, full_matrices=False)
    values = np.concatenate([np.linspace(2.0, 1.0, 76), 2.0 * np.geomspace(0.9, 0.4, 64) * cutoff])
    linear = Linear(sparse.csr_array((left * values) @ right))
    assert linear.nullity(cutoff) == 64
    assert linear.rank(cutoff) == 76
    # Three rounds leave so much of directions of values of 1 and more, beside those of 1.8 cutoffs; and round-off.
    share = (1.8 * cutoff) ** 6
    assert np.abs(linear.free(cutoff) @ right[:76].T).max() < 2.0 * share + 1e-11


def test_weak_directions_are_the_same_from_those_of_a_matrix_nearby() -> None:
    near = matrix(100, 70, 12)
    change = 1e-3 * np.random.default_rng(9).normal(size=near.shape) * (np.abs(near) > 0.1)
    goal = np.random.default_rng(8).normal(size=100)
    before = Linear(sparse.csr_array(near))
    before.least_change(goal, 5e-3)
    assert len(before.weak[0]) < 70
    alone, after = (Linear(sparse.csr_array(near + change)) for _ in range(2))
    after.after(before)
    known = int(np.count_nonzero(alone.weak[0] < WEAK))
    assert known == 12
    assert after.weak[0][:known] == pytest.approx(alone.weak[0][:known], rel=1e-9)
    assert after.weak[0][known] > WEAK
    # Round-off of 1e-16, over the square of the weakest: 1e-3 or so of the largest
    assert after.least_change(goal, 5e-3) == pytest.approx(alone.least_change(goal, 5e-3), abs=1e-9)


@pytest.mark.parametrize("cutoff", [5e-3, 2e-2])
def test_damped_changes_in_turn_are_those_of_damped_least_squares(
    cutoff: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As of more than 700 equations: of a singular value s, a pass leaves e^2 / (s^2 + e^2) of what it is to take."""
    monkeypatch.setattr("lamc.loops.linear.FEW_ROWS", 0)
    full = matrix(100, 70, 12)
    goal = np.random.default_rng(8).normal(size=100)
    left, values, right = np.linalg.svd(full, full_matrices=False)
    linear = Linear(sparse.csr_array(full))
    assert linear.is_very_large
    found = np.zeros(70)
    for _ in range(8):
        found = found + linear.damped_change(goal - full @ found, cutoff)
    damping = (cutoff * linear.scale) ** 2
    taken = 1.0 - (damping / (values**2 + damping)) ** 8
    expected = (taken * (left.T @ goal) / values) @ right
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * float(np.abs(expected).max()))
    assert taken[values > 1e-3].min() > 1.0 - 1e-9  # what is strong is taken wholly


def test_what_becomes_weak_on_the_way_is_found() -> None:
    """Of singular vectors that stay as they are, those of a matrix nearby have nothing of it."""
    random = np.random.default_rng(3)
    left, right = (np.linalg.qr(random.normal(size=(n, 110)))[0] for n in (300, 110))
    values = np.concatenate([[1e-4, 5e-4, 1e-3, 2e-3], np.geomspace(2e-2, 1.0, 106)])
    before = Linear(sparse.csr_array((left * values) @ right.T))
    before.least_change(random.normal(size=300), 5e-3)
    values[80] = 1e-3
    after = Linear(sparse.csr_array((left * values) @ right.T)).after(before)
    goal = random.normal(size=300)
    kept = values > 5e-3
    expected = right[:, kept] @ ((left[:, kept].T @ goal) / values[kept])
    assert after.least_change(goal, 5e-3) == pytest.approx(expected, abs=0.02 * float(np.abs(expected).max()))


@pytest.mark.quick("61", others="campaign")
@pytest.mark.parametrize("nullity", range(56, 66))
def test_a_cutoff_amid_close_values_leaves_out_as_many_as_asked_for(nullity: int) -> None:
    random = np.random.default_rng(11)
    left, right = (np.linalg.qr(random.normal(size=(n, 200)))[0] for n in (430, 200))
    values = np.geomspace(1e-3, 1.0, 200)
    linear = Linear(sparse.csr_array((left * values) @ right.T))
    left_out = int(np.count_nonzero(values <= linear.amid(nullity) * linear.scale))
    assert abs(left_out - nullity) <= 1  # the largest singular value is known to some hundredths


@pytest.mark.parametrize("most", [1e-3, 2e-2, 0.3])
@pytest.mark.parametrize(("rows", "columns"), [(140, 110), (70, 110)])
def test_small_singular_values_are_counted_by_one_elimination(rows: int, columns: int, most: float) -> None:
    """As many as a dense decomposition has, those that there are fewer rows than columns for among them."""
    random = np.random.default_rng(11)
    full = random.normal(size=(rows, columns)) * (random.random((rows, columns)) < 0.1)
    left, values, right = np.linalg.svd(full, full_matrices=False)
    values = np.geomspace(1.0, 1e-4, len(values))
    linear = Linear(sparse.csr_array((left * values) @ right))
    few = int(np.count_nonzero(values <= most * linear.scale)) + max(0, columns - rows)
    assert linear.about(most) == few
    # And iteration begins with a block that has them all: it does not grow.
    assert np.count_nonzero(linear.weak[0] <= WEAK) == linear.about(WEAK)
    assert len(linear.weak[0]) == linear.about(BEYOND * WEAK) + BLOCK


def test_a_matrix_that_holds_nothing_leaves_all_free() -> None:
    with np.errstate(all="raise"):
        linear = Linear(sparse.csr_array((6, DENSE + 10)))
        assert (linear.rank(), linear.about(WEAK), linear.scale) == (0, DENSE + 10, 1.0)

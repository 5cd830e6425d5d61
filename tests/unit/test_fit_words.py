"""What the data cannot tell apart: the law that two numbers follow, in words, and how far it lets others go."""

import numpy as np
import pytest

from lamc.fitting.uncertainty import Account, _words, account_of
from lamc.fitting.unknowns import Free, Unknown, Unknowns


@pytest.mark.parametrize(
    ("first", "second", "change", "words"),
    [
        (2.0, 1.0, (1.0, -1.0), "only their sum"),  # relative changes are 1 : -2, a product of powers
        (2.0, 1.01, (1.0, -1.0), "only their sum"),  # 1 : -1.98, within what powers are snapped
        (2.0, 1.0, (1.0, 1.0), "only their difference"),
        (5.0, 0.7, (5.0, -0.7), "only their product"),
        (5.0, 0.7, (5.0, 0.7), "only their ratio"),
        (5.0, 0.7, (10.0, -0.7), "only their product a^0.5 · b (here)"),
        (2.0, 2.0, (1.0, -1.0), "only their product or sum, which are alike here"),
        (5.0, 0.7, (1.0, -0.331), "(here, in SI units)"),
        (20.0, 10.1, (20.0, -20.2), "only their product a^2 · b (here)"),  # the sum is one per cent off
    ],
)
def test_the_law_of_two_is_that_of_their_changes(
    first: float, second: float, change: tuple[float, float], words: str
) -> None:
    plain = np.array(change)
    assert words in _words(("a", "b"), plain / np.array([first, second]), plain)


def test_numbers_of_two_units_have_no_sum() -> None:
    plain = np.array([1.0, -1.0])
    words = _words(("a", "b"), plain / np.array([2.0, 1.0]), plain, is_one_unit=False)
    assert words.endswith("only their product a^2 · b (here)")


def account(jacobian: np.ndarray, values: list[float], bounds: tuple[float, float], *, log: bool) -> Account:
    """Of two numbers, the second within bounds, and residuals that neither can lessen."""
    numbers = (
        Unknown("a", "parameter", "a", "1", Free(-np.inf, np.inf), values[0], log=False),
        Unknown("b", "parameter", "b", "1", Free(*bounds), values[1], log=log),
    )
    residual = 1e-6 * np.random.default_rng(1).standard_normal(len(jacobian))
    basis, _ = np.linalg.qr(jacobian)
    inner = np.array([values[0], np.log(values[1]) if log else values[1]])
    return account_of(
        Unknowns(numbers), inner, residual - basis @ (basis.T @ residual), jacobian, "linear", 1e-7
    )


@pytest.mark.parametrize("share", [2e-3, 9e-4, 1e-4])
def test_a_number_goes_as_far_as_one_that_is_not_told_may_take_it(share: float) -> None:
    """The data feel a + share·b: b goes from 0 to 3, so that a is off by share·2 at most. It was told to 1e-8 where the
    share is less than a thousandth."""
    x = np.random.default_rng(0).standard_normal(200)
    found = account(np.column_stack([x, share * x]), [1.0, 1.0], (0.0, 3.0), log=False)
    low, high = found.intervals[0]
    assert low <= 1.0 - share * 1.9  # b at 3, but for what 1.97 standard errors of half of it come to
    assert high >= 1.0 + share * 0.99  # b at 0
    if share < 1e-3:
        assert high - low < 8.0 * share
    # By its logarithm, from 1e-3 to 3: the same sum, of which the solver sees b d(log b).
    found = account(np.column_stack([x, share * x]), [1.0, 1.0], (1e-3, 3.0), log=True)
    low, high = found.intervals[0]
    assert low <= 1.0 - share * 1.9
    assert high >= 1.0 + share * 0.99

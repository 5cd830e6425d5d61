"""Equations that are weak next to a flat position, and those that are a drawing's misfit, by how they grow."""

import numpy as np
import pytest

from lamc.loops.rank import RISING, _rises
from lamc.loops.surveys import Survey
from lamc.loops.walks import LoopPosition


def walked(strongest: list[float]) -> Survey:
    """A walk of steps of 0.02 rad with two weak equations at each place, and a strong one."""
    places = [
        LoopPosition(np.array([0.02 * (k + 1), 0.0, 0.0]), 0.0, np.array([1e-6, value, 0.3]))
        for k, value in enumerate(strongest)
    ]
    return Survey([places], True, 3)


@pytest.mark.parametrize(
    ("strongest", "rises"),
    [
        ([3e-3, 5e-3, 7.2e-3, 9.2e-3], True),  # a kirigami's: a tenth of the way
        ([2e-4, 2e-4, 2e-4, 2e-4], False),  # there from the start
        ([3e-3, 5e-3, 7.2e-3, 0.9 * RISING * 0.08], False),  # one place is enough to doubt it
    ],
)
def test_what_grows_with_the_way_from_flat_is_of_the_second_order(
    strongest: list[float], rises: bool
) -> None:
    assert _rises(walked(strongest), np.zeros(3), 2) == rises


def test_equations_that_were_not_looked_for_are_strong() -> None:
    """Of large matrices a few of the weakest are known."""
    assert _rises(walked([3e-3, 5e-3]), np.zeros(3), 9)

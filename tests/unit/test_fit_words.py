"""What the data cannot tell apart, in words: of two numbers the law that their changes follow."""

import numpy as np
import pytest

from lamc.fitting.uncertainty import _words


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
    ],
)
def test_the_law_of_two_is_that_of_their_changes(
    first: float, second: float, change: tuple[float, float], words: str
) -> None:
    plain = np.array(change)
    assert words in _words(("a", "b"), plain / np.array([first, second]), plain)

"""Old public words still work, and warn once with the new one."""

import pytest

import lamc
from tests.support.mechanisms import chain


def test_books_are_the_energy_balance() -> None:
    sim = lamc.compile(chain(2), lamc.Scene(effects=(lamc.Gravity(),)))
    with pytest.warns(DeprecationWarning, match=r"^run\(books=...\) is run\(energy_balance=...\) now$"):
        result = sim.run(t_end=0.1, books=True)
    with pytest.warns(DeprecationWarning, match="^Result.books is Result.energy_balance now$"):
        books = result.books
    assert books is result.energy_balance
    assert books.balance < 1e-8  # at the default tolerance of 1e-9

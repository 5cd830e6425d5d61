"""What counts as a number where text is read."""

import pytest

from lamc.basics.number_text import is_comma_number, is_measured, is_number


@pytest.mark.parametrize("text", ["0", "-1", "+.5", "1.", "1e5", "1.E-3", "0E1", "9" * 100_000])
def test_numbers(text: str) -> None:
    assert is_number(text)
    assert float(text) is not None


@pytest.mark.parametrize("text", ["", "0E", "1e+", ".", "-", "1 ", "1_0", "nan", "١", "9" * 100_000 + "E"])
def test_what_is_none(text: str) -> None:
    assert not is_number(text)


def test_decimal_commas() -> None:
    assert is_comma_number("-0,5e3")
    assert is_comma_number(",5")
    assert not is_comma_number("1,")
    assert not is_comma_number("1,0E")


@pytest.mark.parametrize(("text", "measured"), [("0E5", False), ("0E5 m", True), ("1 e", True), ("1e", True)])
def test_an_exponent_is_no_unit(text: str, measured: bool) -> None:
    assert is_measured(text) == measured

"""Numbers for people: what is shown is the number, whatever its unit."""

import pytest

from lamc.basics.numbers import prefixed, shown_number
from lamc.basics.si_units import si_unit


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1.2038e-3, "m²", "1203.8 mm²"),
        (-4.2394e-5, "m³", "-42394 mm³"),
        (2.5e-13, "m^2", "2.5e+05 nm^2"),
        (3.2e-5, "m²·s", "32 mm²·s"),
        (2.83e-3, "rad²", "0.00283 rad²"),
        (2.0e-6, "kg", "2 mg"),
        (3.0e-8, "kg·m²", "30 µg·m²"),
        (4.0e-8, "kg²·m^4/s^4", "40000 mg²·m^4/s^4"),
        (0.02, "N·m", "20 mN·m"),
        (0.004, "m/s", "4 mm/s"),
        (0.004, "1/s", "0.004 1/s"),
        (0.25, "", "0.25"),
        (-0.003, "m", "-3 mm"),
        (2.0e9, "m", "2e+06 km"),
    ],
)
def test_a_prefix_is_raised_to_the_power_of_its_factor(value: float, unit: str, text: str) -> None:
    assert shown_number(value, unit) == text


@pytest.mark.parametrize(
    "unit", ["m", "m²", "m³", "kg", "kg·m²", "N·m", "m/s²", "m^2/s^2", "W", "s", "kg²/s"]
)
@pytest.mark.parametrize("exponent", range(-14, 8))
def test_what_is_shown_is_the_number(unit: str, exponent: int) -> None:
    """Read back by the reader of units, which knows nothing of how it was written."""
    value = 3.7 * 10.0**exponent
    scale, name = prefixed(value, unit)
    read = value / scale * si_unit(name).factor
    assert read == pytest.approx(value * si_unit(unit).factor, rel=1e-12, abs=0.0)  # round-off

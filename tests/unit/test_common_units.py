"""The table of common units is pint's, and what uses no other unit starts without pint."""

import subprocess
import sys

import pytest

from lamc.basics import si_units, units
from lamc.basics.common_units import COMMON

QUANTITIES = {
    value.unit: value for _, value in sorted(vars(units).items()) if isinstance(value, units.Quantity)
}


@pytest.mark.parametrize(("unit", "si"), sorted(COMMON))
def test_a_common_unit_is_what_pint_says(unit: str, si: str) -> None:
    units.check_unit(unit, QUANTITIES[si])
    assert COMMON[unit, si] == units._asked(unit, QUANTITIES[si])  # to the last bit: results must not move


def test_examples_are_read_without_pint() -> None:
    """In one process: what one of them loaded would be there for all."""
    code = (
        "import sys, lamc; from lamc.examples import path\n"
        "for name in ('flaps', 'four_bar', 'waterbomb', 'folding_box', 'pendulum'):\n"
        "    lamc.load(path(name)); print(name, 'pint' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert [line.split()[1] for line in done.stdout.splitlines()] == ["False"] * 5, done.stdout


def test_units_of_any_quantity_are_pints_to_the_last_bit() -> None:
    for unit, known in si_units._COMMON.items():
        assert si_units._parsed(si_units._spelled(unit)) == known, unit

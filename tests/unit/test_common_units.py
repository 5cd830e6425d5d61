"""The table of common units is pint's, and what uses no other unit starts without pint."""

import subprocess
import sys
from pathlib import Path

import pytest

from lamc.basics import si_units, units
from lamc.basics.common_units import COMMON
from tests.support.ctools import needs_cc
from tests.support.fold_corpus import miura, write

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


def test_units_that_are_plain_are_so_by_pint() -> None:
    for unit in si_units._PLAIN:
        if unit != "1":
            assert si_units._parsed(si_units._spelled(unit)) == si_units.SIUnit(unit, 1.0)


@pytest.mark.slow
@needs_cc
def test_a_sheet_without_units_of_its_own_runs_without_pint(tmp_path: Path) -> None:
    """Half a second of a start: its parameters have units, thickness, density and creases."""
    path = write(tmp_path / "sheet.fold", miura(1, 2))
    code = (
        "import sys; from lamc.cli import main\n"
        f"main(['run', {str(path)!r}, '--no-pictures', '--t-end', '0.001', '--out', {str(tmp_path / 'o')!r}],"
        " standalone_mode=False)\n"
        "print('pint' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "False", done.stdout

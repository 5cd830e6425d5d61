"""A table of two columns from a CSV file, such as a hinge's measured torque over its angle.

In: a path and the SI units of the columns. Out: rows of two numbers in SI. Never: runs or guesses anything: a line is
two numbers, or the heading, or a remark after #, or it is refused with its place.
"""

import re
from pathlib import Path

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, Place
from lamc.basics.files import read_bytes
from lamc.basics.number_text import is_number
from lamc.basics.units import Quantity, to_si

MAX_BYTES = 1_000_000
MAX_ROWS = 10_000

_BLANK = re.compile(r"\s+(?![\[(])")  # a unit belongs to the word before it
_HEADING_UNIT = re.compile(r"[\[(]([^\])]{1,40})[\])]\s*\Z")

Rows = tuple[tuple[float, float], ...]


def read_table(path: Path, columns: tuple[Quantity, Quantity]) -> Rows:
    """The rows of the file in SI.

    Columns are set apart by commas, semicolons, tabs or blanks. A first line that is not numbers is the heading, and
    may hold the units: "angle [deg], torque [N*mm]"; without units numbers are SI.

    Raises DesignError with file and line for what is no such table.
    """
    try:
        text = read_bytes(path, MAX_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DesignError("the table is not UTF-8 text: save it as CSV in UTF-8", Place(str(path))) from error
    units = ["", ""]
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        cells = _cells(line)
        if not cells:
            continue
        place = Place(str(path), number)
        if len(cells) != 2:
            raise DesignError(
                f"a line of {len(cells)} columns; give two, {columns[0].name} and {columns[1].name}", place
            )
        if not rows and units == ["", ""] and not any(map(is_number, cells)):
            units = [_heading_unit(c, q, place) for c, q in zip(cells, columns, strict=True)]
            continue
        first, second = (_value(c, u, q, place) for c, u, q in zip(cells, units, columns, strict=True))
        rows.append((first, second))
        if len(rows) > MAX_ROWS:
            raise DesignError(f"more than {MAX_ROWS} rows; give fewer points", place)
    return tuple(rows)


def _cells(line: str) -> list[str]:
    line = line.split("#", 1)[0].strip()
    for mark in (";", ",", "\t"):
        if mark in line:
            return [cell.strip() for cell in line.split(mark)]
    return [cell for cell in _BLANK.split(line) if cell]


def _heading_unit(cell: str, quantity: Quantity, place: Place) -> str:
    found = _HEADING_UNIT.search(cell)
    unit = found[1].strip() if found else quantity.unit
    try:
        to_si(f"1 {unit}", quantity)
    except DesignError as error:
        raise DesignError(f"the heading's unit: {error.message}", place) from error
    return unit


def _value(cell: str, unit: str, quantity: Quantity, place: Place) -> float:
    if not is_number(cell):
        raise DesignError(
            f"{shown(cell)} is no number; write {quantity.name} with a decimal point, and units into the heading",
            place,
        )
    try:
        return to_si(f"{cell} {unit}" if unit else float(cell), quantity)
    except DesignError as error:
        raise DesignError(error.message, place) from error

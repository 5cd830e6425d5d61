"""Cells of a recording's file: lines cut apart, and the numbers in them.

In: a path. Out: `Cells`; numbers, NaN for gaps. What spreadsheets write is read: a byte order mark, UTF-16,
semicolons or tabs with decimal commas, quotes. Raises DesignError with file and line for what is no number.
"""

import csv
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, Place
from lamc.basics.files import read_bytes
from lamc.basics.number_text import is_comma_number, is_number

MAX_BYTES = 500_000_000
MOST_COLUMNS = 10_000

Row = tuple[int, tuple[str, ...]]
_GAPS = ("", "nan", "none", "null", "-")
_THOUSANDS = re.compile(r"[-+]?[1-9][0-9]{0,2}(?:,[0-9]{3})+")
_MARKS = {"\t": "tab", ";": "semicolon", ",": "comma"}
_BYTE_ORDERS = (b"\xff\xfe", b"\xfe\xff")


@dataclass(frozen=True)
class Cells:
    """Lines of a file, with their numbers, cut into cells. remark: the last one above the first line, or empty."""

    path: str
    lines: tuple[Row, ...]
    mark: str
    remark: str = ""

    def place(self, number: int) -> Place:
        return Place(self.path, number)


def lines_of(path: Path) -> list[str]:
    """The lines of a file. Raises DesignError for what is no text."""
    data = read_bytes(path, MAX_BYTES)
    try:
        return data.decode("utf-16" if data[:2] in _BYTE_ORDERS else "utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise DesignError(
            "the recording is not UTF-8 text: save it as CSV in UTF-8", Place(str(path))
        ) from error


def mark_of(lines: Sequence[str]) -> str:
    """What sets columns apart: the first of tab, semicolon and comma that most lines have."""
    some = [line for line in lines[:50] if line.strip() and not line.lstrip().startswith("#")]
    for mark in ("\t", ";", ","):
        if sum(mark in line for line in some) > len(some) // 2:
            return mark
    return ","


def cut(path: Path, lines: Sequence[str], mark: str, *, remarks: bool) -> Cells:
    """The lines with anything in them. remarks: whether # begins one."""
    found: list[Row] = []
    remark = ""
    for number, line in enumerate(lines, start=1):
        if remarks and "#" in line:
            line, _, said = line.partition("#")
            remark = said if not found and not line.strip() else remark
        if line.strip(" \t\r,;"):
            found.append((number, cells_of(line, mark)))
    if not found:
        raise DesignError("the file holds no rows", Place(str(path)))
    if len(found[0][1]) > MOST_COLUMNS:
        raise DesignError(f"more than {MOST_COLUMNS} columns; leave some out", Place(str(path), found[0][0]))
    return Cells(str(path), tuple(found), mark, remark)


def cells_of(line: str, mark: str) -> tuple[str, ...]:
    """One line, cut apart; a mark in quotes is none."""
    if '"' in line and mark == ",":
        try:
            return tuple(cell.strip() for cell in next(csv.reader([line], skipinitialspace=True)))
        except (csv.Error, StopIteration):  # what is no table of a spreadsheet's is told by its cells
            pass
    return tuple(cell.strip().strip('"').strip() for cell in line.split(mark))


def numbers_of(cells: Cells, count: int, rows: Sequence[Row], fewest: int = 0) -> Iterator[list[float]]:
    """Numbers of rows by `count` columns, NaN for gaps. fewest: cells that a row has, though they may be empty."""
    comma = point = ""
    thousands = _Thousands(cells, count)
    for number, row in rows:
        if len(row) > count and any(row[count:]):
            hint = (
                "; decimal commas need columns set apart by semicolons"
                if cells.mark == "," and len(row) == 2 * count
                else ""
            )
            raise DesignError(
                f"a line of {len(row)} columns below a heading of {count}{hint}", cells.place(number)
            )
        if len(row) < fewest:
            raise DesignError(
                f"a line of {len(row)} columns below a heading of {count}: what is missing might be any of them; leave "
                f"the cells of gaps empty, each behind its {_MARKS[cells.mark]}",
                cells.place(number),
            )
        found = []
        for column, cell in enumerate((*row, *[""] * (count - len(row)))[:count]):
            thousands.see(column, cell, number)
            if "," in cell and is_comma_number(cell):
                comma = comma or cell
                cell = cell.replace(",", ".")
            elif "." in cell:
                point = point or cell
            if comma and point:
                raise DesignError(
                    f"there is {comma!r} with a decimal comma, and {point!r} with a point; write all with one of them",
                    cells.place(number),
                )
            found.append(_number(cell, cells, number))
        yield found
    thousands.check()


class _Thousands:
    """Looks for commas that set thousands apart, which read as decimal commas are a thousandth of the number."""

    def __init__(self, cells: Cells, count: int) -> None:
        self._cells = cells
        self._first: list[tuple[str, int] | None] = [None] * count  # cell with such a comma, and its line
        self._is_other = [False] * count  # a comma elsewhere: decimal ones
        self._whole = [False] * count  # numbers without a comma

    def see(self, column: int, cell: str, number: int) -> None:
        if "," not in cell:
            self._whole[column] = self._whole[column] or cell.isdigit()
        elif _THOUSANDS.fullmatch(cell) is None:
            self._is_other[column] = True
        elif self._first[column] is None:
            self._first[column] = cell, number

    def check(self) -> None:
        """Whether all commas of a column may be such: beside numbers without, or where commas set columns apart."""
        for first, is_other, whole in zip(self._first, self._is_other, self._whole, strict=True):
            if first is None or is_other or not (whole or self._cells.mark == ","):
                continue
            cell, number = first
            raise DesignError(
                f"{cell!r} may have a comma between thousands or before decimals; write {cell.replace(',', '')}, or "
                f"{cell.replace(',', '.', 1)} with a point",
                self._cells.place(number),
            )


def _number(cell: str, cells: Cells, number: int) -> float:
    if is_number(cell):
        found = float(cell)
        if not math.isfinite(found):
            raise DesignError(f"{cell[:40]} is more than a number can be", cells.place(number))
        return found
    if cell.lower() in _GAPS:
        return float("nan")
    if ":" in cell:
        return float("nan")  # a time code, beside the time
    raise DesignError(f"{shown(cell)} is no number; leave gaps empty, or write NaN", cells.place(number))

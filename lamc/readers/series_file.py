"""Series from CSV files: columns of numbers over time, such as what a bench or a controller recorded.

In: a path, and which columns are meant. Out: times and values as they are written, with their units. Never: runs or
guesses anything: a cell is a number, or empty, or it is refused with its line. A file of a million rows takes a second.

What spreadsheets write is read: a byte order mark, semicolons with decimal commas, tabs, quotes, a heading with units
as in "time [ms];angle [deg]", remarks after #.
"""

import csv
import io
import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import DesignError, Place
from lamc.basics.files import read_bytes
from lamc.basics.number_text import is_comma_number, is_number
from lamc.records.series import first_not_after

Array = npt.NDArray[np.float64]

MAX_BYTES = 200_000_000
MAX_ROWS = 2_000_000
MAX_COLUMNS = 10_000
TIMES = ("t", "time", "times", "zeit", "temps", "timestamp", "seconds")
GAPS = ("refuse", "bridge")

_EMPTY = ("", "nan", "na", "n/a", "null", "none", "-", "#n/a")
_UNIT = re.compile(r"\s*[\[(]([^\])]{1,40})[\])]\s*\Z")


@dataclass(frozen=True, eq=False)
class Columns:
    """t (n,) and values (n,) as they are written; their units, empty where the heading tells none."""

    t: Array
    values: Array
    time_unit: str
    unit: str


@dataclass(frozen=True)
class _Layout:
    """How the file is written: the line where rows begin, from 0, and what columns are called."""

    delimiter: str | None  # None: blanks
    decimal_comma: bool
    first: int
    names: tuple[str, ...]  # of the heading; empty: there is none
    units: tuple[str, ...]
    width: int


def read_columns(
    path: Path, column: str | int | None, time: str | int | None, *, gaps: str = "refuse"
) -> Columns:
    """Two columns of a file, by name or by number from 1.

    column  None: the only one beside the time's; time  None: the one that is called so, else the first
    gaps    rows without a number: "refuse", or "bridge" to leave them out

    Raises DesignError with file and line for what is no such table: time that runs backwards or repeats, gaps, lines of
    another length, cells that are no numbers, columns that are not there.
    """
    status = path.stat() if path.is_file() else None
    stamp = (status.st_mtime_ns, status.st_size) if status is not None else None
    return _read(path, stamp, column, time, gaps)


@lru_cache(
    maxsize=8
)  # scenes of a file, and designs made again, read the same; another stamp is another file
def _read(path: Path, _stamp: object, column: str | int | None, time: str | int | None, gaps: str) -> Columns:
    lines = _lines(path)
    layout = _layout(path, lines)
    at_time = _time_column(path, layout, time)
    at_value = _value_column(path, layout, column, at_time)
    t, values, numbers = _numbers(path, lines, layout, (at_time, at_value))
    t, values, numbers = _without_gaps(path, t, values, numbers, gaps)
    if len(t) == 0:
        raise DesignError("the file has no rows of numbers", Place(str(path)))
    if (back := first_not_after(t)) is not None:
        _refuse_order(path, t, numbers, back)
    units = layout.units or ("",) * layout.width
    return Columns(t, values, units[at_time], units[at_value])


def _lines(path: Path) -> list[str]:
    data = read_bytes(path, MAX_BYTES)
    try:
        text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError as error:
        raise DesignError("the file is not UTF-8 text: save it as CSV in UTF-8", Place(str(path))) from error
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if len(lines) > MAX_ROWS + 100:
        raise DesignError(f"the file has {len(lines)} lines; at most {MAX_ROWS} are read", Place(str(path)))
    return lines


def _bare(line: str) -> str:
    return (
        line.split("#", 1)[0].strip()
        if "#" in line and not line.strip().lower().startswith("#n/a")
        else line.strip()
    )


def _layout(path: Path, lines: list[str]) -> _Layout:
    shown_lines = [(k, bare) for k, line in enumerate(lines) if (bare := _bare(line))][:50]
    if not shown_lines:
        raise DesignError("the file is empty", Place(str(path)))
    number, head = shown_lines[0]
    delimiter = next((mark for mark in (";", "\t", ",") if mark in head), None)
    cells = _cells(head, delimiter)
    if len(cells) > MAX_COLUMNS:
        raise DesignError(
            f"a line of {len(cells)} columns; at most {MAX_COLUMNS} are read", Place(str(path), number + 1)
        )
    has_heading = not any(is_number(c) or is_comma_number(c) for c in cells)
    rows = shown_lines[1:] if has_heading else shown_lines
    comma = delimiter != "," and any(is_comma_number(c) for _, row in rows for c in _cells(row, delimiter))
    names = tuple(_UNIT.sub("", c).strip() for c in cells) if has_heading else ()
    units = (
        tuple(found[1].strip() if (found := _UNIT.search(c)) else "" for c in cells) if has_heading else ()
    )
    return _Layout(delimiter, comma, number + has_heading, names, units, len(cells))


def _cells(line: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return re.split(r"\s+(?![\[(])", line)
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]


def _time_column(path: Path, layout: _Layout, time: str | int | None) -> int:
    if time is not None:
        return _column(path, layout, time, "time")
    called = [k for k, name in enumerate(layout.names) if name.lower() in TIMES]
    return called[0] if called else 0


def _value_column(path: Path, layout: _Layout, column: str | int | None, at_time: int) -> int:
    if column is not None:
        found = _column(path, layout, column, "column")
        if found == at_time:
            raise DesignError(
                f"column {column!r} is the time's; name the column of the values", Place(str(path))
            )
        return found
    others = [k for k in range(layout.width) if k != at_time]
    if len(others) != 1:
        listed = ", ".join(layout.names[:12]) if layout.names else f"1 to {layout.width}"
        raise DesignError(
            f"the file has {len(others)} columns beside the time's; say by column which is meant: there are {listed}",
            Place(str(path)),
        )
    return others[0]


def _column(path: Path, layout: _Layout, wanted: str | int, what: str) -> int:
    place = Place(str(path))
    if isinstance(wanted, int):
        if not 1 <= wanted <= layout.width:
            raise DesignError(f"{what} is {wanted}; the file has columns 1 to {layout.width}", place)
        return wanted - 1
    if not layout.names:
        raise DesignError(
            f"{what} is {wanted!r}, and the file has no heading; give the number of the column", place
        )
    exact = [k for k, name in enumerate(layout.names) if name == wanted]
    alike = exact or [k for k, name in enumerate(layout.names) if name.lower() == wanted.lower()]
    if len(alike) > 1:
        raise DesignError(f"{len(alike)} columns are called {wanted!r}; give the number of one", place)
    if not alike:
        raise DesignError(f"no column is called {shown(wanted)}; {did_you_mean(wanted, layout.names)}", place)
    return alike[0]


def _numbers(
    path: Path, lines: list[str], layout: _Layout, columns: tuple[int, int]
) -> tuple[Array, Array, npt.NDArray[np.int64] | None]:
    """Two columns, NaN where a cell is empty, and the line of each row, from 1; None: one after the other."""
    if not layout.decimal_comma:
        fast = _at_once(lines[layout.first :], layout, columns)
        if fast is not None:
            return fast[:, 0].copy(), fast[:, 1].copy(), None
    found, numbers = [], []
    for number, line in enumerate(lines[layout.first :], start=layout.first + 1):
        bare = _bare(line)
        if not bare:
            continue
        place = Place(str(path), number)
        cells = _cells(bare, layout.delimiter)
        if len(cells) != layout.width:
            hint = "; decimal commas need columns set apart by semicolons" if layout.delimiter == "," else ""
            raise DesignError(
                f"a line of {len(cells)} columns, where the first has {layout.width}{hint}", place
            )
        found.append([_value(cells[k], layout, place) for k in columns])
        numbers.append(number)
    if len(found) > MAX_ROWS:
        raise DesignError(f"more than {MAX_ROWS} rows; thin them out", Place(str(path)))
    both = np.array(found, dtype=np.float64).reshape(-1, 2)
    return both[:, 0].copy(), both[:, 1].copy(), np.array(numbers, dtype=np.int64)


def _at_once(lines: list[str], layout: _Layout, columns: tuple[int, int]) -> Array | None:
    """Two columns where every line is numbers and nothing else; None: look line by line."""
    while lines and not lines[-1].strip():
        lines = lines[:-1]
    text = "\n".join(lines)
    if not text or re.search(r"[^0-9eE+\-.,;\s]|\n[ \t]*\n", text):
        return None  # letters, quotes, remarks, blank lines; what numpy reads besides, such as "nan", is for us to tell
    if layout.delimiter is None:
        widths = {len(line.split()) for line in lines}
    else:
        widths = {line.count(layout.delimiter) + 1 for line in lines}
    if widths != {layout.width}:
        return None
    try:
        read = np.loadtxt(
            io.StringIO(text), delimiter=layout.delimiter, usecols=columns, comments=None, ndmin=2
        )
    except ValueError:
        return None
    return read if read.shape == (len(lines), 2) else None


def _value(cell: str, layout: _Layout, place: Place) -> float:
    if cell.lower() in _EMPTY:
        return float("nan")
    if layout.decimal_comma and is_comma_number(cell):
        return float(cell.replace(",", "."))
    if layout.decimal_comma and "." in cell and "," in cell:
        raise DesignError(
            f"{shown(cell)} has a point and a comma; write numbers without marks between thousands", place
        )
    if not is_number(cell):
        raise DesignError(
            f"{shown(cell)} is no number; write one with a decimal point, or nothing for a gap", place
        )
    return float(cell)


def _without_gaps(
    path: Path, t: Array, values: Array, numbers: npt.NDArray[np.int64] | None, gaps: str
) -> tuple[Array, Array, npt.NDArray[np.int64] | None]:
    gone = ~np.isfinite(t) | ~np.isfinite(values)
    if not gone.any():
        return t, values, numbers
    first = int(np.flatnonzero(gone)[0])
    place = Place(str(path), int(numbers[first]) if numbers is not None else 0)
    if np.isinf(t[first]) or np.isinf(values[first]):
        raise DesignError("a number is larger than a double holds", place)
    if gaps != "bridge":
        more = f", and {int(gone.sum()) - 1} more" if gone.sum() > 1 else ""
        raise DesignError(
            f"a row has no number here{more}; say gaps: bridge to leave such rows out, and what stands between is held "
            "as between others",
            place,
        )
    kept = ~gone
    return t[kept], values[kept], numbers[kept] if numbers is not None else None


def _refuse_order(path: Path, t: Array, numbers: npt.NDArray[np.int64] | None, back: int) -> None:
    """Raises DesignError for a time that is not after the one before it."""
    if numbers is None:  # read at once: rows follow each other, and the last one is at the end of the file
        lines = _lines(path)
        rows = [k for k, line in enumerate(lines, start=1) if _bare(line)][-len(t) :]
        here, before = rows[back], rows[back - 1]
    else:
        here, before = int(numbers[back]), int(numbers[back - 1])
    what = "repeats" if t[back] == t[back - 1] else "runs backwards: it is before"
    raise DesignError(
        f"the time {t[back]:.9g} {what} {t[back - 1]:.9g} of line {before}; sort the rows, and keep one for each time",
        Place(str(path), here),
    )

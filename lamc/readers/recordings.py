"""Recordings of motion in files: CSV with any columns, Tracker's tables, OptiTrack Motive's exports.

In: a path. Out: a `Table`: times, s, and named columns in SI, gaps as NaN; points are NAME.x, NAME.y, NAME.z. Never:
guesses a unit or runs anything: a cell is a number, or empty, or refused with its place.

CSV: a heading, "t [s], h1 [deg], marker1.x [mm]", units in it or SI; commas, semicolons or tabs; # begins a remark.
Tracker (physlets.org/tracker, File, Export, Data File): a line with the name of the track, or "#multi:" and a line of
names, then "t x y". Motive (docs.optitrack.com, Data Export: CSV): a line of "Format Version, 1.2…" with the unit of
lengths, lines of types, names, IDs, kinds and axes; of rotations nothing is taken.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, Place
from lamc.basics.files import read_bytes
from lamc.basics.number_text import is_number
from lamc.basics.units import LENGTH, to_si

Array = npt.NDArray[np.float64]

MAX_BYTES = 500_000_000
MOST_COLUMNS = 10_000
TIMES = ("t", "time", "time (seconds)", "timestamp")
PIXELS = ("px", "pixel", "pixels")

_GAPS = ("", "nan", "none", "null", "-")
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+\Z")
_UNIT = re.compile(r"\s*[\[(]\s*([^\])]{1,40}?)\s*[\])]\s*\Z")
_MOTIVE = "format version"
_LENGTHS = {"meters": "m", "centimeters": "cm", "millimeters": "mm"}


@dataclass(frozen=True, eq=False)
class Table:
    """t: (m,), s; columns: (m,) each, SI, by name; units as they were, "" where none was said; kind of the file."""

    path: str
    kind: str
    t: Array
    columns: Mapping[str, Array]
    units: Mapping[str, str]


@dataclass(frozen=True)
class _Cells:
    """Lines of a file, with their numbers, cut into cells."""

    path: str
    lines: tuple[tuple[int, tuple[str, ...]], ...]

    def place(self, number: int) -> Place:
        return Place(self.path, number)


def read_recording(path: Path | str, time: str | None = None, length_unit: str = "") -> Table:
    """The columns of a file.

    time         the column of times; None: "t" or "time"
    length_unit  of columns of points whose heading says none; "": m

    Raises DesignError with file and line for what is no such table.
    """
    path = Path(path)
    try:
        text = read_bytes(path, MAX_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DesignError(
            "the recording is not UTF-8 text: save it as CSV in UTF-8", Place(str(path))
        ) from error
    lines = text.splitlines()
    mark = _mark(lines)
    first = next((line for line in lines if line.strip()), "")
    if first.lower().lstrip('"').startswith(_MOTIVE):
        return _motive(_cut(path, lines, ",", remarks=False))
    if mark == "\t" and _is_tracker(lines):
        return _tracker(_cut(path, lines, mark, remarks=False), length_unit)
    return _plain(_cut(path, lines, mark, remarks=True), time, length_unit)


def _mark(lines: Sequence[str]) -> str:
    """What sets columns apart: the first of tab, semicolon and comma that most lines have."""
    some = [line for line in lines[:50] if line.strip() and not line.lstrip().startswith("#")]
    for mark in ("\t", ";", ","):
        if sum(mark in line for line in some) > len(some) // 2:
            return mark
    return ","


def _cut(path: Path, lines: Sequence[str], mark: str, *, remarks: bool) -> _Cells:
    found = []
    for number, line in enumerate(lines, start=1):
        if remarks:
            line = line.split("#", 1)[0]
        if line.strip(" \t\r,;"):
            found.append((number, tuple(cell.strip().strip('"').strip() for cell in line.split(mark))))
    if not found:
        raise DesignError("the file holds no rows", Place(str(path)))
    if len(found[0][1]) > MOST_COLUMNS:
        raise DesignError(f"more than {MOST_COLUMNS} columns; leave some out", Place(str(path), found[0][0]))
    return _Cells(str(path), tuple(found))


def _plain(cells: _Cells, time: str | None, length_unit: str) -> Table:
    """A heading, then numbers."""
    number, head = cells.lines[0]
    if any(map(is_number, head)):
        raise DesignError(
            f"the first line is {', '.join(head[:4])[:60]!r}, and it must name the columns, with units: t [s], "
            "h1 [deg]",
            cells.place(number),
        )
    names, units = zip(*(_name_and_unit(cell, cells.place(number)) for cell in head), strict=True)
    return _table("csv", cells, names, units, cells.lines[1:], time, length_unit)


def _is_tracker(lines: Sequence[str]) -> bool:
    """A line of track names, or #multi:, above a line that begins with t."""
    some = [line for line in lines if line.strip()][:3]
    heads = [line.split("\t")[0].strip().lstrip("#") for line in some]
    return (len(some) > 1 and heads[1] == "t" and heads[0] != "t") or (
        len(some) > 2 and heads[0].startswith("multi") and heads[2] == "t"
    )


def _tracker(cells: _Cells, length_unit: str) -> Table:
    lines = list(cells.lines)
    multi = lines[0][1][0].lstrip("#").startswith("multi")
    if multi:
        lines.pop(0)
    if len(lines) < 2:
        raise DesignError(
            "a table of Tracker names its tracks in one line and columns in the next",
            cells.place(lines[0][0]),
        )
    (_, tracks), (_, head), *rows = lines
    owners = [""] * len(head)
    own = "" if multi else tracks[0].lstrip("#")
    for k in range(1, len(head)):
        if multi and k < len(tracks) and tracks[k]:
            own = tracks[k]
        owners[k] = own
    names = [
        head[0],
        *(f"{owner}.{axis}" if axis else "" for owner, axis in zip(owners[1:], head[1:], strict=True)),
    ]
    return _table("tracker", cells, names, [""] * len(names), rows, "t", length_unit)


def _motive(cells: _Cells) -> Table:
    number, first = cells.lines[0]
    said = {first[k].lower(): first[k + 1] for k in range(0, len(first) - 1, 2)}
    unit = _LENGTHS.get(said.get("length units", "meters").lower())
    if unit is None:
        raise DesignError(
            f"the length unit is {shown(said['length units'])}; known are {', '.join(_LENGTHS)}",
            cells.place(number),
        )
    at = next((k for k, (_, row) in enumerate(cells.lines) if row[0].lower() == "frame"), None)
    if at is None or at < 3:
        raise DesignError(
            "no line 'Frame, Time (Seconds), X, Y, Z' stands below names and types; export it anew",
            cells.place(number),
        )
    head = cells.lines[at][1]
    above = [row for _, row in cells.lines[1:at]]
    kinds = next((row for row in above if any(cell in ("Position", "Rotation") for cell in row)), ())
    labels = {row[1].lower(): row for row in above if len(row) > 1 and row[0] == "" and row[1]}
    tracks = labels.get("name") or (above[1] if len(above) > 1 else ())
    types = labels.get("type") or above[0]
    names = []
    for k, axis in enumerate(head):
        kind = kinds[k] if k < len(kinds) else ""
        if axis.lower().startswith("time (") or axis.lower() == "time":
            names.append("t")
        elif kind == "Position" and k < len(tracks) and axis.lower() in ("x", "y", "z"):
            solved = k < len(types) and types[k].lower().startswith("rigid body marker")
            names.append(f"{tracks[k]}{' (solved)' if solved else ''}.{axis.lower()}")
        else:
            names.append("")
    return _table(
        "motive",
        cells,
        names,
        [unit if "." in name else "" for name in names],
        cells.lines[at + 1 :],
        "t",
        unit,
    )


def _name_and_unit(cell: str, place: Place) -> tuple[str, str]:
    if not cell:
        return "", ""
    if cell.lower() in TIMES:
        return "t", ""
    found = _UNIT.search(cell)
    name, unit = (cell[: found.start()], found[1]) if found else (cell, "")
    name = name.strip()
    if not name.isprintable() or len(name) > 200:
        raise DesignError(f"{shown(cell)} is no name of a column", place)
    return ("t" if name.lower() in TIMES else name), unit


def _table(
    kind: str,
    cells: _Cells,
    names: Sequence[str],
    units: Sequence[str],
    rows: Sequence[tuple[int, tuple[str, ...]]],
    time: str | None,
    length_unit: str,
) -> Table:
    place = cells.place(cells.lines[0][0])
    twice = next((name for name in names if name and list(names).count(name) > 1), None)
    if twice is not None:
        raise DesignError(f"two columns are named {twice!r}; name them apart", place)
    wanted = time or "t"
    if wanted not in names:
        known = ", ".join(name for name in names if name)[:200]
        raise DesignError(
            f"no column is named {wanted!r}, of times; name it: --map COLUMN=t; there are {known}", place
        )
    if len(rows) < 2:
        raise DesignError(f"there are {len(rows)} rows of numbers; two or more are needed", place)
    values = np.array(list(_numbers(cells, len(names), rows)))
    at = list(names).index(wanted)
    factor = _factor(units[at], "s", place)
    t = values[:, at] * factor
    _check_times(t, rows, cells)
    columns, said = {}, {}
    for k, (name, unit) in enumerate(zip(names, units, strict=True)):
        if name and k != at:
            columns[name] = values[:, k] * _scale(name, unit, length_unit, place)
            said[name] = unit
    if not columns:
        raise DesignError("there are times and nothing else", place)
    return Table(cells.path, kind, t, columns, said)


def _numbers(cells: _Cells, count: int, rows: Sequence[tuple[int, tuple[str, ...]]]) -> Iterator[list[float]]:
    for number, row in rows:
        if len(row) > count and any(row[count:]):
            hint = (
                "; write decimal points, or set columns apart by semicolons"
                if all(map(str.isdigit, row[1:2]))
                else ""
            )
            raise DesignError(
                f"a line of {len(row)} columns below a heading of {count}{hint}", cells.place(number)
            )
        padded = [*row, *[""] * (count - len(row))][:count]
        yield [_number(cell, cells, number) for cell in padded]


def _number(cell: str, cells: _Cells, number: int) -> float:
    if is_number(cell):
        found = float(cell)
        if not math.isfinite(found):
            raise DesignError(f"{cell[:40]} is more than a number can be", cells.place(number))
        return found
    if cell.lower() in _GAPS:
        return float("nan")
    if _DECIMAL_COMMA.match(cell):
        raise DesignError(
            f"{cell!r} has a decimal comma; save the file with decimal points", cells.place(number)
        )
    if ":" in cell:
        return float("nan")  # a time code, beside the time
    raise DesignError(f"{shown(cell)} is no number; leave gaps empty, or write NaN", cells.place(number))


def _scale(name: str, unit: str, length_unit: str, place: Place) -> float:
    """How many of SI the unit of a column is; pixels stay."""
    is_point = name.rpartition(".")[2].lower() in ("x", "y", "z")
    unit = unit or (length_unit if is_point else "")
    if not unit or unit.lower() in PIXELS:
        return 1.0
    for si in ("m", "rad", "rad/s", "m/s", "s", "1"):
        try:
            return _factor(unit, si, place)
        except DesignError:
            continue
    raise DesignError(
        f"the column {name!r} is in {shown(unit)}; angles, rates and lengths have units such as deg, deg/s, mm, px",
        place,
    )


def _factor(unit: str, si: str, place: Place) -> float:
    from lamc.basics.si_units import in_unit

    if not unit:
        return 1.0
    try:
        return to_si(f"1 {unit}", LENGTH) if si == "m" else in_unit(f"1 {unit}", si, "number")
    except DesignError as error:
        raise DesignError(f"the heading's unit: {error.message}", place) from error


def _check_times(t: Array, rows: Sequence[tuple[int, tuple[str, ...]]], cells: _Cells) -> None:
    for k, (number, _) in enumerate(rows):
        if not np.isfinite(t[k]):
            raise DesignError("a row without a time; each needs one", cells.place(number))
        if k and t[k] <= t[k - 1]:
            word = "stands still" if t[k] == t[k - 1] else "runs backwards"
            raise DesignError(
                f"time {word}: {t[k]:g} s after {t[k - 1]:g} s; sort the rows, and drop repeated ones",
                cells.place(number),
            )

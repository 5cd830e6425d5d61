"""Recordings of motion in files: CSV with any columns, Tracker's tables, OptiTrack Motive's exports.

In: a path. Out: a `Table`: times, s, and named columns in SI, gaps as NaN; points are NAME.x, NAME.y, NAME.z. Never:
guesses a unit or runs anything: a cell is a number, or empty, or refused with its place.

CSV: a heading, "t [s], h1 [deg], marker1.x [mm]", units in it or SI, in a remark too; commas, semicolons or tabs.
Tracker (physlets.org/tracker, File, Export, Data File): a line with the name of the track, or "#multi:" and a line of
names, then "t x y". Motive (docs.optitrack.com, Data Export: CSV): a line of "Format Version, 1.2…" with the unit of
lengths, lines of types, names, IDs, kinds and axes; of rotations nothing is taken.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, Place
from lamc.basics.number_text import is_comma_number, is_number
from lamc.basics.units import LENGTH, to_si
from lamc.readers.recorded_cells import Cells, Row, cells_of, cut, lines_of, mark_of, numbers_of

Array = npt.NDArray[np.float64]

TIMES = ("t", "time", "time (seconds)", "timestamp")
PIXELS = ("px", "pixel", "pixels")

_UNIT = re.compile(r"\s*[\[(]\s*([^\])]{1,40}?)\s*[\])]\s*\Z")
_MOTIVE = "format version"
_SLOW = 1.0  # s: rows that far apart tell nothing of a motion; in milliseconds and frames rows are
_SUCH = {
    "m": "a length: m, mm",
    "rad": "an angle: rad, deg",
    "rad/s": "a rate: rad/s, deg/s",
    "s": "a time: s, ms",
}
_LENGTHS = {"meters": "m", "centimeters": "cm", "millimeters": "mm"}


@dataclass(frozen=True, eq=False)
class Table:
    """t: (m,), s; columns: (m,) each, SI, by name; units as they were, "" where none was said; kind of the file."""

    path: str
    kind: str
    t: Array
    columns: Mapping[str, Array]
    units: Mapping[str, str]


def read_recording(path: Path | str, time: str | None = None, length_unit: str = "") -> Table:
    """The columns of a file.

    time         the column of times; None: "t" or "time"
    length_unit  of columns of points whose heading says none; "": m

    Raises DesignError with file and line for what is no such table.
    """
    path = Path(path)
    if length_unit and length_unit.lower() not in PIXELS:
        factor_of(length_unit, "m", Place(str(path)), "the unit of lengths")
    lines = lines_of(path)
    mark = mark_of(lines)
    first = next((line for line in lines if line.strip()), "")
    if first.lower().lstrip('"').startswith(_MOTIVE):
        return _motive(cut(path, lines, ",", remarks=False))
    if mark == "\t" and _is_tracker(lines):
        return _tracker(cut(path, lines, mark, remarks=False), length_unit)
    return _plain(cut(path, lines, mark, remarks=True), time, length_unit)


def _plain(cells: Cells, time: str | None, length_unit: str) -> Table:
    """A heading, then numbers."""
    number, head = cells.lines[0]
    rows = cells.lines[1:]
    if any(is_number(cell) or is_comma_number(cell) for cell in head):
        above = cells_of(cells.remark, cells.mark)  # as numpy.savetxt writes a heading
        if len(above) == len(head) > 1 and not any(map(is_number, above)):
            head, rows = above, cells.lines
    if rows is not cells.lines and any(is_number(cell) or is_comma_number(cell) for cell in head):
        raise DesignError(
            f"the first line is {', '.join(head[:4])[:60]!r}, and it must name the columns, with units: t [s], "
            "h1 [deg]",
            cells.place(number),
        )
    names, units = zip(*(_name_and_unit(cell, cells.place(number)) for cell in head), strict=True)
    return _table("csv", cells, names, units, rows, time, length_unit)


def _is_tracker(lines: Sequence[str]) -> bool:
    """A line of track names, or #multi:, above a line that begins with t."""
    some = [line for line in lines if line.strip()][:3]
    heads = [line.split("\t")[0].strip().lstrip("#") for line in some]
    return (len(some) > 1 and heads[1] == "t" and heads[0] != "t") or (
        len(some) > 2 and heads[0].startswith("multi") and heads[2] == "t"
    )


def _tracker(cells: Cells, length_unit: str) -> Table:
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


def _motive(cells: Cells) -> Table:
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
    cells: Cells,
    names: Sequence[str],
    units: Sequence[str],
    rows: Sequence[Row],
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
    # Tracker and Motive leave marks behind the last number of a row away; in CSV a cell is left out by mistake.
    fewest = max(k for k, name in enumerate(names, start=1) if name) if kind == "csv" else 0
    values = np.array(list(numbers_of(cells, len(names), rows, fewest)))
    at = list(names).index(wanted)
    t = values[:, at] * factor_of(units[at], "s", place, f"the column {wanted!r}, of times,")
    _check_times(t, rows, cells)
    columns, said = {}, {}
    for k, (name, unit) in enumerate(zip(names, units, strict=True)):
        if name and k != at:
            columns[name] = values[:, k] * _scale(name, unit, length_unit, place)
            said[name] = unit or (length_unit if _is_point(name) else "")
    if not columns:
        raise DesignError("there are times and nothing else", place)
    apart = float(np.median(np.diff(t)))
    if kind == "csv" and not units[at] and apart >= _SLOW:
        raise DesignError(
            f"rows are {apart:g} apart in {wanted!r}, whose heading says no unit; are these milliseconds, or frames? "
            "write t [ms], or t [s] if it is seconds",
            place,
        )
    return Table(cells.path, kind, t, columns, said)


def _scale(name: str, unit: str, length_unit: str, place: Place) -> float:
    """How many of SI the unit of a column is; pixels stay."""
    unit = unit or (length_unit if _is_point(name) else "")
    if not unit or unit.lower() in PIXELS:
        return 1.0
    for si in ("m", "rad", "rad/s", "m/s", "s", "1"):
        try:
            return factor_of(unit, si, place, f"the column {name!r}")
        except DesignError:
            continue
    raise DesignError(
        f"the column {name!r} is in {shown(unit)}; angles, rates and lengths have units such as deg, deg/s, mm, px",
        place,
    )


def _is_point(name: str) -> bool:
    return name.rpartition(".")[2].lower() in ("x", "y", "z")


def factor_of(unit: str, si: str, place: Place | None, what: str) -> float:
    """How many of an SI unit a unit is; 1 of none. Raises DesignError where it is of another quantity."""
    from lamc.basics.si_units import in_unit

    if not unit:
        return 1.0
    try:
        return to_si(f"1 {unit}", LENGTH) if si == "m" else in_unit(f"1 {unit}", si, "number")
    except DesignError as error:
        raise DesignError(f"{what} is in {shown(unit)}, which is not {_SUCH.get(si, si)}", place) from error


def _check_times(t: Array, rows: Sequence[Row], cells: Cells) -> None:
    for k, (number, _) in enumerate(rows):
        if not np.isfinite(t[k]):
            raise DesignError("a row without a time; each needs one", cells.place(number))
        if k and t[k] <= t[k - 1]:
            word = "stands still" if t[k] == t[k - 1] else "runs backwards"
            raise DesignError(
                f"time {word}: {t[k]:g} s after {t[k - 1]:g} s; sort the rows, and drop repeated ones",
                cells.place(number),
            )

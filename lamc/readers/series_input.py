"""Inputs of scenes that follow a series: {csv: bench.csv, column: cmd, unit: deg, hold: linear}, or rows in the scene.

In: plain data, the folder that files are counted from, and what knows the place of each field. Out: an `Input` in SI;
the first problem is raised at its place, in the scene or in the CSV file. Never: guesses a unit.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import DesignError, Place
from lamc.basics.si_units import si_unit
from lamc.readers.series_file import GAPS, Columns, read_columns
from lamc.records.inputs import Input
from lamc.records.series import BEYOND, HOLDS, Series

FIELDS = (
    "csv",
    "column",
    "time",
    "unit",
    "time_unit",
    "hold",
    "beyond",
    "gaps",
    "t",
    "values",
    "meaning",
)
MOST_IN_SCENE = 10_000  # rows that stand in the scene itself

At = Callable[[str], Place]


def is_series(value: object) -> bool:
    """Whether the data of an input is that of a series."""
    return isinstance(value, Mapping) and any(
        key in value for key in ("csv", "t", "values", "hold", "column")
    )


def series_input(value: object, folder: FilePath | None, at: At) -> Input:
    """The input that `value` describes; `folder` holds the file, None: the present one.

    Raises DesignError at the place of what is wrong."""
    assert isinstance(value, Mapping)
    said: dict[str, Any] = {str(key): each for key, each in value.items()}
    for key in said:
        if key not in FIELDS:
            raise DesignError(f"a series has no field {shown(key)}; {did_you_mean(key, FIELDS)}", at(key))
    hold = _word(said, "hold", HOLDS, "linear", at)
    beyond = _word(said, "beyond", BEYOND, "refuse", at)
    columns = _from_file(said, folder, at) if "csv" in said else _in_scene(said, at)
    unit = _unit(said, "unit", columns.unit, "", at)
    time_unit = _unit(said, "time_unit", columns.time_unit, "s", at)
    if time_unit.text != "s":
        text = said.get("time_unit", columns.time_unit)
        raise DesignError(
            f"the unit of time is {text!r}, which is no time; give s, ms, min or h", at("time_unit")
        )
    t, values = columns.t * time_unit.factor, columns.values * unit.factor
    meaning = said.get("meaning", "")
    if not isinstance(meaning, str):
        raise DesignError(f"meaning is {shown(meaning)}; it must be text", at("meaning"))
    place = at("csv" if "csv" in said else "t")
    try:
        series = Series(t, values, hold, beyond, said.get("csv", ""))
        return Input(unit=unit.text, meaning=meaning, series=series)
    except DesignError as error:
        raise DesignError(error.message, error.place or place) from error


def _word(said: Mapping[str, Any], key: str, known: Any, usual: str, at: At) -> str:
    word = said.get(key, usual)
    if not isinstance(word, str) or word not in known:
        raise DesignError(f"{key} is {shown(word)}; {did_you_mean(str(word), list(known))}", at(key))
    return word


def _unit(said: Mapping[str, Any], key: str, heading: str, usual: str, at: At) -> Any:
    """The unit that the scene says, or the heading of the file; both must agree."""
    given = said.get(key)
    if given is not None and not isinstance(given, str):
        raise DesignError(f"{key} is {shown(given)}; write a unit, such as deg", at(key))
    try:
        unit = si_unit(given if given is not None else heading or usual)
    except DesignError as error:
        raise DesignError(f"{key}: {error.message}", at(key)) from error
    own = unit
    if heading:
        with suppress(DesignError):  # brackets may hold a remark, if the scene tells the unit
            own = si_unit(heading)
    if (own.text, own.factor) != (unit.text, unit.factor):
        raise DesignError(
            f"{key} is {given!r}, and the heading of the file says {heading!r}; say the one that is true in both",
            at(key),
        )
    return unit


def _from_file(said: Mapping[str, Any], folder: FilePath | None, at: At) -> Columns:
    for key in ("t", "values"):
        if key in said:
            raise DesignError(
                f"{key} stands beside csv; a series is read from the file or from the scene", at(key)
            )
    name = said["csv"]
    if not isinstance(name, str) or not name.strip():
        raise DesignError(f"csv is {shown(name)}; it must be the path of a file, from this one on", at("csv"))
    for key in ("column", "time"):
        each = said.get(key)
        if each is not None and (isinstance(each, bool) or not isinstance(each, str | int)):
            raise DesignError(
                f"{key} is {shown(each)}; give the name of a column, or its number from 1", at(key)
            )
    gaps = _word(said, "gaps", GAPS, "refuse", at)
    try:
        return read_columns((folder or FilePath()) / name, said.get("column"), said.get("time"), gaps=gaps)
    except DesignError as error:
        if "column" in error.message and error.place is not None and not error.place.line:
            key = "column" if "column" in said else "csv"
            raise DesignError(f"{name}: {error.message}", at(key)) from error
        raise


def _in_scene(said: Mapping[str, Any], at: At) -> Columns:
    """Rows that stand in the scene."""
    rows = []
    for key in ("t", "values"):
        if key not in said:
            raise DesignError(f"a series has no {key}; name a csv file, or give t and values", at("hold"))
        given = said[key]
        fits = isinstance(given, list | tuple) and all(
            isinstance(each, int | float) and not isinstance(each, bool) for each in given
        )
        if not fits:
            raise DesignError(f"{key} is {shown(given)}; it must be a list of numbers", at(key))
        if len(given) > MOST_IN_SCENE:
            raise DesignError(
                f"{key} has {len(given)} numbers; beyond {MOST_IN_SCENE} give a csv file", at(key)
            )
        rows.append(np.array([float(each) for each in given]))
    for key in ("column", "time", "gaps"):
        if key in said:
            raise DesignError(f"{key} is about a csv file, and none is named", at(key))
    return Columns(rows[0], rows[1], "", "")

"""Tables of files as recordings: which column is a hinge, which a point of a body.

In: a `Table`, what its columns are ("marker1" → "link_2@(30mm, 0, 0)", "angle_1" → "h1"). Out: a `Recording`. Columns
that are named as the model names them need no word. Raises RequestError for names that are not there.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import DesignError, Place, RequestError
from lamc.fitting.signals import Column, Point, signal_of
from lamc.readers.recordings import PIXELS, Table, factor_of
from lamc.records.recording import Camera, Marker, Recording
from lamc.records.series import Series
from lamc.run.simulator import Simulator

_AXES = ("x", "y", "z")
_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class Asked:
    """What is said of all recordings: maps by column or track; ranges of their own numbers ("delay", "angles.h1",
    "h1.bias"); start; frame: axes of a camera, None: points are in the world's."""

    maps: Mapping[str, str] = field(default_factory=dict)
    own: Mapping[str, str] = field(default_factory=dict)
    start: str = "known"
    frame: tuple[str, ...] | None = None


def own_names(free: Mapping[str, object]) -> dict[str, object]:
    """Of what is free, the numbers of recordings: the delay, starts, gains and biases."""
    return {
        name: given
        for name, given in free.items()
        if name == "delay" or name.startswith(("angles.", "rates.")) or name.endswith((".bias", ".gain"))
    }


def recording_of(
    table: Table, name: str, simulator: Simulator, asked: Asked
) -> tuple[Recording, tuple[str, ...]]:
    """The recording of a table, and the columns that nothing is made of."""
    sources: dict[str, str] = {}  # columns of the file, by what they are
    markers: dict[str, Marker] = {}
    series: dict[str, Series] = {}
    followed: set[str] = set()
    for track, what in asked.maps.items():
        if what == "t":
            continue
        if "@" in what:
            markers[track] = Marker.of(what, track)
            sources |= {f"{track}.{axis}": column for axis, column in _of_track(table, track).items()}
        else:
            if track not in table.columns:
                raise _unknown(table, track, list(table.columns))
            if what in simulator.model.series:
                followed.add(track)
                series[what] = _series(table, track, simulator, what)
            else:
                sources[what] = track
    for column in table.columns:
        taken = column in sources.values() or column in followed or column in sources
        if not taken and _is_known(simulator, column):
            sources[column] = column
    if not sources:
        raise RequestError(
            f"{table.path} has no column that the model knows ({', '.join(list(table.columns)[:8])}); say what "
            "they are: "
            "--map COLUMN=h1, --map MARKER=link_2@(30mm, 0, 0)"
        )
    used = followed | set(sources.values())
    columns = {what: table.columns[column] for what, column in sources.items()}
    _check_units(table, sources, markers, simulator, name)
    _check_pixels(table, set(sources.values()), asked)
    if asked.frame is not None and not markers:
        raise RequestError(
            "--frame is of markers, and no --map says where one sits: --map 'tip=link_2@(30mm, 0, 0)'"
        )
    camera = None
    if asked.frame is not None and markers:
        axes = asked.frame
        camera = Camera.unknown(axes)
        extra = [f"{m}.{axis}" for m in markers for axis in _AXES[len(axes) :]]
        columns = {c: v for c, v in columns.items() if c not in extra}
    own = asked.own
    recording = Recording(
        table.t,
        columns,
        name=name,
        start=asked.start,
        series=series,
        markers=markers,
        camera=camera,
        delay=own.get("delay", 0.0),
        angles={n.removeprefix("angles."): given for n, given in own.items() if n.startswith("angles.")},
        rates={n.removeprefix("rates."): given for n, given in own.items() if n.startswith("rates.")},
        gain={n.removesuffix(".gain"): given for n, given in own.items() if n.endswith(".gain")},
        bias={n.removesuffix(".bias"): given for n, given in own.items() if n.endswith(".bias")},
    )
    return recording, tuple(column for column in table.columns if column not in used)


def _series(table: Table, column: str, simulator: Simulator, name: str) -> Series:
    """A command that was recorded beside, as an input follows it; gaps are bridged."""
    values = table.columns[column]
    good = np.isfinite(values)
    if not good.any():
        raise DesignError(
            f"the column {column!r} is empty, and the input {name!r} shall follow it", Place(table.path)
        )
    usual = simulator.model.own_series.get(name)
    return Series(table.t[good], values[good], "linear" if usual is None else usual.hold, "hold", table.path)


def _of_track(table: Table, track: str) -> dict[str, str]:
    """The columns of a track by axis."""
    found: dict[str, str] = {}
    for axis in _AXES:
        for mark in (".", "_", " "):
            for letter in (axis, axis.upper()):
                if f"{track}{mark}{letter}" in table.columns:
                    found.setdefault(axis, f"{track}{mark}{letter}")
    if not found:
        known = [
            column.rpartition(mark)[0]
            for column in table.columns
            for mark in (".", "_", " ")
            if column[-1:] in "xyzXYZ"
        ]
        raise _unknown(table, track, [each for each in known if each])
    return found


def _check_units(
    table: Table, sources: Mapping[str, str], markers: Mapping[str, Marker], simulator: Simulator, name: str
) -> None:
    """Raises DesignError for columns in units of another quantity than they are in the model, and for angles without a
    unit that can hardly be radians."""
    for what, column in sources.items():
        signal = signal_of(simulator, what, markers, name)
        unit = signal.unit if isinstance(signal, Column) else "m"
        said, is_hinge = table.units.get(column, ""), what in simulator.joints
        if said.lower() not in PIXELS or not isinstance(signal, Point):
            factor_of(said, unit, Place(table.path), f"the column {column!r}, as {what!r} of the model,")
        most = float(np.nanmax(np.abs(table.columns[column]), initial=0.0))
        if is_hinge and not said and most > _TURN:
            raise DesignError(
                f"the column {column!r} reaches {most:.4g}, and its heading says no unit; are these degrees? write "
                f"{column} [deg], or {column} [rad] if it turns so far",
                Place(table.path),
            )


def _unknown(table: Table, name: str, known: list[str]) -> DesignError:
    hint = did_you_mean(name, known) if known else f"its columns are {', '.join(table.columns)}"[:200]
    return DesignError(
        f"--map names {name!r}, and the file has no such column or marker; {hint}", Place(table.path)
    )


def _is_known(simulator: Simulator, column: str) -> bool:
    try:
        signal_of(simulator, column, {}, "a file")
    except RequestError:
        return False
    return True


def _check_pixels(table: Table, used: set[str], asked: Asked) -> None:
    pixels = [column for column in sorted(used) if table.units.get(column, "").lower() in PIXELS]
    if pixels and asked.frame is None:
        raise DesignError(
            f"{pixels[0]!r} is in pixels, and points are in metres; say along which world axes the picture lies: "
            "--frame x,-z (scale and place are found)",
            Place(table.path),
        )

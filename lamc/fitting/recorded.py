"""One recording as it is fitted: which rows are compared, what it starts from, and the unknowns that are its own.

In: a `Recording`, a simulator. Out: a `Run`, unknowns. Raises RequestError of one line for columns, hinges and series
that are not there, and for rows that lie before the run.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import LamcError, RequestError
from lamc.basics.places import located_at
from lamc.fitting.begins import angle_and_rate
from lamc.fitting.sight import Sight, sight_of
from lamc.fitting.signals import signal_of
from lamc.fitting.unknowns import Unknown, free_of, is_range, unknown
from lamc.records.mechanism import FAR
from lamc.records.recording import Free, Marker, Recording
from lamc.records.series import Series
from lamc.run.following import with_series
from lamc.run.parameters import checked_parameters
from lamc.run.request import Array
from lamc.run.simulator import Simulator
from lamc.studies.axes import number_of

Rows = np.ndarray[tuple[int], np.dtype[np.bool_]]
_UNITS = {"delay": "s", "gain": "1", "rotation": "rad"}


@dataclass(frozen=True, eq=False)
class Run:
    """One recording as it is fitted.

    sight     its sensors
    simulator of the design as it stands
    rows      (m,) of bool: those that are compared
    begin     s, of the run's state at the start
    starts    unknown or given numbers of the start by the place of the coordinate, rate, in the state
    delay     s, given, unless it is unknown
    """

    recording: Recording
    name: str
    sight: Sight
    rows: Rows
    begin: float
    angles: Mapping[str, float]  # given ones, over the scene's
    rates: Mapping[str, float]
    parameters: Mapping[str, float | Series]
    numbers: Mapping[str, float]  # of the sensors, given ones; delay too

    @property
    def own_numbers(self) -> dict[str, float]:
        """Of `parameters` those that follow no series."""
        return {name: each for name, each in self.parameters.items() if not isinstance(each, Series)}

    @property
    def times(self) -> Array:
        return self.recording.t[self.rows]

    @property
    def measured(self) -> Array:
        """(m, k); NaN: gaps."""
        return np.stack([self.recording.values[c][self.rows] for c in self.sight.columns], axis=1)


def run_of(
    recording: Recording, simulator: Simulator, taken: set[str], notes: list[str]
) -> tuple[Run, list[Unknown]]:
    """A recording, and the unknowns that are its own."""
    name = recording.name
    sight = sight_of(recording, name)
    check_columns(simulator, sight)
    own: list[Unknown] = []
    delay, unknown_delay = _delay(recording)
    if unknown_delay is not None:
        own.append(unknown_delay)
        latest, earliest = unknown_delay.free.high, unknown_delay.free.low
    else:
        latest = earliest = delay
    estimated = recording.start == "estimated"
    t = recording.t
    begin = float(t[0]) - latest if estimated else 0.0
    rows = t - latest >= begin - 1e-12 * max(1.0, abs(float(t[-1])))
    if not estimated:
        _check_clock(recording, t, latest, rows)
        lost = int((~rows).sum())
        if lost:
            notes.append(f"{name}: {lost} rows are not compared, as they may lie before the start of the run")
    if not rows.any() or float(t[-1]) - earliest <= begin:
        raise RequestError(f"{name} has no rows within its run, which starts at {begin:g} s of its clock")
    recording, sight = _without_empty(recording, sight, rows, notes)
    numbers: dict[str, float] = {f"{name}.delay": delay}
    units = _units_of(simulator, sight)
    for key, given in sight.numbers.items():
        found = _sensor(key, given, recording, name, units)
        if isinstance(found, Unknown):
            own.append(found)
        else:
            numbers[key] = found
    angles: dict[str, float] = {}
    rates: dict[str, float] = {}
    joints = [joint.name for joint in simulator.mechanism.joints]
    for kind, whole, unit, said in (
        ("angle", angles, "rad", recording.angles),
        ("rate", rates, "rad/s", recording.rates),
    ):
        for joint, given in said.items():
            if joint not in joints:
                raise RequestError(
                    f"{name} starts {joint!r}, and no hinge is named so; {did_you_mean(joint, joints)}"
                )
            if is_range(given):
                guess = angle_and_rate(recording, joint, kind)
                usual = getattr(simulator.scene, f"{kind}s").get(joint, 0.0)
                free = free_of(given, f"{name}.{kind}s.{joint}", unit)
                begun = guess if guess is not None else usual
                begun = min(max(begun, free.low), free.high)
                own.append(unknown(f"{name}.{kind}s.{joint}", kind, joint, unit, free, begun, owner=name))
            else:
                whole[joint] = number_of(f"{name}.{kind}s.{joint}", given, unit)
    if estimated:
        own += _whole_start(recording, simulator, {each.name for each in own}, {**angles}, {**rates})
    parameters = checked_parameters(recording.parameters, simulator.parameter_units)
    for each in parameters:
        if each in taken:
            raise RequestError(f"{name} gives {each!r} a value, and it is free; say one of them")
    _check_series(recording, simulator, float(t[-1]) - earliest)
    followed: dict[str, float | Series] = {**parameters, **recording.series}
    return Run(recording, name, sight, rows, begin, angles, rates, followed, numbers), own


def _without_empty(
    recording: Recording, sight: Sight, rows: Rows, notes: list[str]
) -> tuple[Recording, Sight]:
    """The recording without columns that hold nothing, which are noted. Raises RequestError where all are empty."""
    empty = [c for c in sight.columns if not np.isfinite(recording.values[c][rows]).any()]
    if not empty:
        return recording, sight
    name, what = sight.name, ", ".join(empty)
    if len(empty) == len(sight.columns):
        raise RequestError(
            f"{name} holds no numbers to compare: {what} {_are(empty)} empty in all of its rows"
        )
    notes.append(f"{name}: {what} {_are(empty)} empty in all rows, and left out")
    values = {c: v for c, v in recording.values.items() if c not in empty}
    kept = replace(
        recording,
        values=values,
        gain={c: g for c, g in recording.gain.items() if c not in empty},
        bias={c: b for c, b in recording.bias.items() if c not in empty},
    )
    return kept, sight_of(kept, name)


def _are(names: list[str]) -> str:
    return "is" if len(names) == 1 else "are"


def _check_series(recording: Recording, simulator: Simulator, end: float) -> None:
    """Raises RequestError for series that no input follows, and that end before the recording does, at `end` s."""
    given = with_series({}, recording.series, simulator.model.series, simulator.parameters)
    with located_at(simulator.scene.places):
        try:
            simulator.model.motion(given).following.check_run(end)
        except LamcError as error:
            raise RequestError(f"{recording.name}: {error.message}") from error


def check_columns(simulator: Simulator, sight: Sight) -> None:
    """Raises RequestError for columns that are nothing of the model, and for markers that are on none of it."""
    for each in sight.signals:
        signal_of(simulator, each, sight.recording.markers, sight.name)
    for name, given in sight.recording.markers.items():
        marker = Marker.of(given, name)
        if marker.body in simulator.bodies and simulator.mechanism.apart(marker.body, marker.point) > FAR:
            away = math.dist(marker.point, simulator.mechanism.body(marker.body).com)
            raise RequestError(
                f"marker {name!r} of {sight.name} sits {away:.3g} m from the middle of {marker.body!r}, and the whole "
                f"device is {simulator.mechanism.size:.3g} m wide; are these mm? numbers without a unit are metres: "
                f"{marker.body}@(30mm, 0, 0)"
            )


def _check_clock(recording: Recording, t: Array, latest: float, rows: Rows) -> None:
    """Raises RequestError for clocks that do not start with the run."""
    if float(t[0]) > 1.0 and float(t[0]) > float(t[-1]) - float(t[0]):
        raise RequestError(
            f"{recording.name} begins at {float(t[0]):g} s of its clock, and the run with its known start at 0 "
            "s; subtract "
            "the time of the start from t, or have it found: start='estimated', --start estimated"
        )
    if not rows.any():
        why = f"as its delay may be up to {latest:g} s: narrow it" if latest > 0.0 else "shift its times"
        raise RequestError(
            f"{recording.name} ends at {float(t[-1]):g} s, before the run starts at {latest:g} s of its clock; {why}, "
            "or have the start found: start='estimated', --start estimated"
        )


def _delay(recording: Recording) -> tuple[float, Unknown | None]:
    given = recording.delay
    name = f"{recording.name}.delay"
    if not is_range(given):
        return number_of(name, given, "s"), None
    free = free_of(given, name, "s")
    if not (math.isfinite(free.low) and math.isfinite(free.high)):
        raise RequestError(
            f"{name!r} needs bounds on either side, such as (0, 0.02) s: rows that may fall before the start "
            "are left out"
        )
    own = 0.0 if free.low <= 0.0 <= free.high else None
    return 0.0, unknown(name, "delay", "delay", "s", replace(free, log=False), own, owner=recording.name)


def _units_of(simulator: Simulator, sight: Sight) -> dict[str, str]:
    """The units of columns; "1" of what a camera sees."""
    camera, markers = sight.recording.camera is not None, sight.recording.markers
    signals = [signal_of(simulator, each, markers, sight.name).unit for each in sight.signals]
    return {
        column: "1" if camera and told.axis is not None else signals[told.base] or "1"
        for column, told in zip(sight.columns, sight.told, strict=True)
    }


def _sensor(
    key: str, given: object, recording: Recording, name: str, units: Mapping[str, str]
) -> "Unknown | float":
    """A number of a sensor: the unknown, or the number. units: of columns, which biases have too."""
    kind = key.rpartition(".")[2].partition("_")[0]
    column = key.removeprefix(f"{name}.").rpartition(".")[0]
    unit = units.get(column, "1") if kind == "bias" else _UNITS.get(kind, "1")
    if not is_range(given):
        return number_of(key, given, unit)
    free = free_of(given, key, unit)
    values = recording.values.get(column)
    size = 1.0
    if kind == "bias" and values is not None:
        size = float(np.nanstd(values)) or 1.0
    if kind == "origin" and recording.camera is not None:
        every = np.concatenate(
            [v for c, v in recording.values.items() if c.rpartition(".")[0] in recording.markers]
        )
        size = float(np.nanstd(every)) or 1.0
    usual = 1.0 if kind in ("gain", "scale") else 0.0
    own = usual if free.low <= usual <= free.high else None
    owner = (
        recording.camera.name
        if recording.camera is not None and key.startswith(f"{recording.camera.name}.")
        else name
    )
    return unknown(key, kind, column, unit, free, own, owner=owner, size=size, positive=kind == "scale")


def _whole_start(
    recording: Recording,
    simulator: Simulator,
    known: set[str],
    angles: Mapping[str, float],
    rates: Mapping[str, float],
) -> list[Unknown]:
    """Unknowns of all of a start that nothing is said about."""
    name = recording.name
    if simulator.cut_joints:
        if not any(each.startswith(f"{name}.angles.") for each in known):
            raise RequestError(
                f"{name} shall have its start estimated, and the mechanism has loops; name the hinges that are free to "
                "choose: angles={'h1': (-1, 1)}, rates={'h1': (-5, 5)}; --free angles.h1=-1:1 --free rates.h1=-5:5"
            )
        return []
    if len(simulator.coordinates) > len(simulator.joints):
        extra = [c.name for c in simulator.coordinates[len(simulator.joints) :]]
        raise RequestError(
            f"{name} shall have its start estimated, and effects add the coordinates {', '.join(extra[:6])}; "
            "they start as "
            "the scene says: name the hinges to estimate as ranges instead, angles={'h1': (-1, 1)}"
        )
    found = []
    for kind, unit, given in (("angle", "rad", angles), ("rate", "rad/s", rates)):
        for joint in simulator.joints:
            key = f"{name}.{kind}s.{joint}"
            if key in known or joint in given:
                continue
            guess = angle_and_rate(recording, joint, kind)
            usual = getattr(simulator.scene, f"{kind}s").get(joint, 0.0)
            begun = guess if guess is not None else usual
            found.append(
                unknown(key, kind, joint, unit, Free(), begun, owner=name, size=max(abs(begun), 1.0))
            )
    return found

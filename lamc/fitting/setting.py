"""What a fit is about: a design in a scene, recordings, unknowns, all checked before anything is fitted.

In: what `lamc.fit` is given. Out: a `Setting`. Raises RequestError of one line for names that are not there, for fewer
data than unknowns, and for starts outside of their bounds.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import LamcError, RequestError
from lamc.basics.places import located_at
from lamc.fitting.sight import Sight, sight_of
from lamc.fitting.simulators import Simulators
from lamc.fitting.unknowns import Unknown, Unknowns, free_of, is_range, unknown
from lamc.records.recording import Free, Recording
from lamc.records.series import Series
from lamc.run.following import with_series
from lamc.run.parameters import bounds, checked_parameters
from lamc.run.request import Array
from lamc.run.simulator import Simulator
from lamc.studies.axes import axis_of
from lamc.studies.targets import Target, targets_of

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
    def times(self) -> Array:
        return self.recording.t[self.rows]

    @property
    def measured(self) -> Array:
        """(m, k); NaN: gaps."""
        return np.stack([self.recording.values[c][self.rows] for c in self.sight.columns], axis=1)


@dataclass(frozen=True, eq=False)
class Setting:
    """runs: of all recordings; unknowns; simulators of the design by its dimensions."""

    simulators: Simulators
    runs: tuple[Run, ...]
    unknowns: Unknowns
    notes: tuple[str, ...] = ()
    parameters: Mapping[str, float] = field(default_factory=dict)  # of all runs, given

    @property
    def count(self) -> int:
        """Numbers that were measured and are compared."""
        return sum(int(np.isfinite(run.measured).sum()) for run in self.runs)


def setting_of(
    simulators: Simulators,
    data: Sequence[Recording],
    free: Mapping[str, object],
    parameters: Mapping[str, float | str],
    *,
    held: bool = False,
) -> Setting:
    """All of a fit, checked. held: nothing need be free."""
    first = simulators.usual
    targets = targets_of(simulators.design, first)
    named = [replace(each, name=each.name or f"run{k + 1}") for k, each in enumerate(data)]
    _check_names([each.name for each in named])
    given = checked_parameters(parameters, first.parameter_units)
    unknowns = [_shared(name, range_, targets, simulators, given) for name, range_ in free.items()]
    runs = []
    notes: list[str] = []
    for recording in named:
        run, own = _run_of(recording, first, {each.name for each in unknowns}, notes)
        runs.append(run)
        unknowns += [each for each in own if each.name not in {u.name for u in unknowns}]
    _refuse_centres(unknowns, runs)
    setting = Setting(simulators, tuple(runs), Unknowns(tuple(unknowns)), tuple(notes), given)
    if not unknowns and not held:
        raise RequestError(
            "nothing is free; name what is to be found: free={'h1.stiffness': (1e-4, 1e-1)}, --free h1.stiffness"
        )
    if setting.count <= len(unknowns):
        raise RequestError(
            f"there are {setting.count} data, and {len(unknowns)} unknowns ({', '.join(setting.unknowns.names[:8])}); "
            "record more, or free less"
        )
    return setting


def _refuse_centres(unknowns: Sequence[Unknown], runs: Sequence[Run]) -> None:
    """Raises RequestError for centres of mass that are free beside points: points are told from the drawn centre."""
    free = next((each.name for each in unknowns if each.kind == "parameter" and ".com_" in each.name), None)
    point = next(
        (s for run in runs for s in run.sight.signals if s.rpartition(".")[2] in ("x", "y", "z")), None
    )
    if free is not None and point is not None:
        raise RequestError(
            f"{free!r} is free, and {point!r} is a point of a body, which is placed by the centre as drawn; "
            "record angles, or "
            "free a dimension of the design"
        )


def _check_names(names: Sequence[str]) -> None:
    twice = next((name for name in names if list(names).count(name) > 1), None)
    if twice is not None:
        raise RequestError(
            f"two recordings are named {twice!r}; their unknowns would be one: name them apart"
        )


def _shared(
    name: str,
    given: object,
    targets: Mapping[str, Target],
    simulators: Simulators,
    parameters: Mapping[str, float],
) -> Unknown:
    """An unknown of all recordings: a parameter of the model, or a dimension of the design."""
    target = targets.get(name)
    if target is None or target.kind not in ("parameter", "dimension"):
        raise RequestError(_no_such(name, targets))
    if name in parameters:
        raise RequestError(f"{name!r} is free, and it is given {parameters[name]:g}; say one of them")
    free = free_of(given, name, target.unit)
    own = target.default
    if target.kind == "dimension":
        least, most = target.minimum, target.maximum
        free = replace(
            free,
            low=max(free.low, -math.inf if least is None else least),
            high=min(free.high, math.inf if most is None else most),
        )
        return unknown(
            name,
            "dimension",
            name,
            target.unit,
            free,
            own,
            size=abs(own or 1.0),
            positive=bool(own and own > 0.0),
        )
    limits = bounds(name)
    _check_possible(name, free, limits.least, limits.most)
    return unknown(
        name,
        "parameter",
        name,
        target.unit,
        free,
        own,
        size=abs(own or 0.0) or 1.0,
        positive=limits.least == 0.0,
    )


def _check_possible(name: str, free: Free, least: float, most: float) -> None:
    for end, is_out in ((free.low, free.low < least), (free.high, free.high > most)):
        if is_out and math.isfinite(end):
            raise RequestError(f"{name!r} may not be {end:g}; it lies between {least:g} and {most:g}")


def _no_such(name: str, targets: Mapping[str, Target]) -> str:
    """Why a name cannot be free, and the way out."""
    known = [each.name for each in targets.values() if each.kind in ("parameter", "dimension")]
    joint, _, what = str(name).rpartition(".")
    effect = {"damping": "hinge_damping", "stiffness": "hinge_stiffness", "rest_angle": "rest_angle"}.get(
        what
    )
    if effect is not None and f"angles.{joint}" in targets:
        return (
            f"{name!r} cannot be free: the scene has no {effect}, so it is no parameter of the model; let it act: "
            f"Scene(added=(…,)), --with {effect}, or give the hinge a value in the design"
        )
    if str(name).startswith(("angles.", "rates.")):
        return f"{name!r} is of one recording: Recording(angles={{…: (low, high)}}), or start='estimated'"
    return f"nothing of this model that can be free is named {shown(name)}; {did_you_mean(str(name), known)}"


def _run_of(
    recording: Recording, simulator: Simulator, taken: set[str], notes: list[str]
) -> tuple[Run, list[Unknown]]:
    """A recording, and the unknowns that are its own."""
    from lamc.fitting.begins import angle_and_rate

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
    numbers: dict[str, float] = {f"{name}.delay": delay}
    for key, given in sight.numbers.items():
        found = _sensor(key, given, recording, name)
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
                whole[joint] = float(axis_of(joint, given, unit).extremes[0])
    if estimated:
        own += _whole_start(recording, simulator, {each.name for each in own}, {**angles}, {**rates})
    parameters = checked_parameters(recording.parameters, simulator.parameter_units)
    for each in parameters:
        if each in taken:
            raise RequestError(f"{name} gives {each!r} a value, and it is free; say one of them")
    _check_series(recording, simulator, float(t[-1]) - earliest)
    followed: dict[str, float | Series] = {**parameters, **recording.series}
    return Run(recording, name, sight, rows, begin, angles, rates, followed, numbers), own


def _check_series(recording: Recording, simulator: Simulator, end: float) -> None:
    """Raises RequestError for series that no input follows, and that end before the recording does, at `end` s."""
    given = with_series({}, recording.series, simulator.model.series, simulator.parameters)
    with located_at(simulator.scene.places):
        try:
            simulator.model.motion(given).following.check_run(end)
        except LamcError as error:
            raise RequestError(f"{recording.name}: {error.message}") from error


def check_columns(simulator: Simulator, sight: Sight) -> None:
    """Raises RequestError for columns that are nothing of the model."""
    from lamc.fitting.signals import signal_of

    for each in sight.signals:
        signal_of(simulator, each, sight.recording.markers, sight.name)


def _check_clock(recording: Recording, t: Array, latest: float, rows: Rows) -> None:
    """Raises RequestError for clocks that do not start with the run."""
    if float(t[0]) > 1.0 and float(t[0]) > float(t[-1]) - float(t[0]):
        raise RequestError(
            f"{recording.name} begins at {float(t[0]):g} s of its clock, and the run with its known start at 0 "
            "s; subtract "
            "the time of the start from t, or estimate it: start='estimated'"
        )
    if not rows.any():
        raise RequestError(
            f"{recording.name} ends at {float(t[-1]):g} s, before the run starts at {latest:g} s of its clock"
        )


def _delay(recording: Recording) -> tuple[float, Unknown | None]:
    given = recording.delay
    name = f"{recording.name}.delay"
    if not is_range(given):
        return float(axis_of("delay", given, "s").extremes[0]), None
    free = free_of(given, name, "s")
    if not (math.isfinite(free.low) and math.isfinite(free.high)):
        raise RequestError(
            f"{name!r} needs bounds on either side, such as (0, 0.02) s: rows that may fall before the start "
            "are left out"
        )
    own = 0.0 if free.low <= 0.0 <= free.high else None
    return 0.0, unknown(name, "delay", "delay", "s", replace(free, log=False), own, owner=recording.name)


def _sensor(key: str, given: object, recording: Recording, name: str) -> "Unknown | float":
    """A number of a sensor: the unknown, or the number."""
    kind = key.rpartition(".")[2].partition("_")[0]
    unit = _UNITS.get(kind, "1")
    if not is_range(given):
        return float(axis_of(key, given, unit).extremes[0])
    free = free_of(given, key, unit)
    column = key.removeprefix(f"{name}.").rpartition(".")[0]
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
    from lamc.fitting.begins import angle_and_rate

    name = recording.name
    if simulator.cut_joints:
        if not any(each.startswith(f"{name}.angles.") for each in known):
            raise RequestError(
                f"{name} shall have its start estimated, and the mechanism has loops; name the hinges that are free to "
                "choose: angles={'h1': (-1, 1)}, rates={'h1': (-5, 5)}"
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

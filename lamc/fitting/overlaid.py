"""Where recorded points and hinges are in the world, beside the model's.

In: a fit, one of its recordings. Out: an `Overlaid`. What a camera does not tell of a point, such as how deep it lies
in the picture, is taken from the model; what was not recorded is NaN. Never: draws.
"""

from dataclasses import dataclass, replace

import numpy as np

from lamc.fitting.answer import Fit
from lamc.fitting.predictions import Predictor
from lamc.fitting.recorded import Run
from lamc.fitting.sight import frame_of
from lamc.fitting.signals import Column, Point, Signals, signal_of
from lamc.run.model import Motion
from lamc.run.request import Array
from lamc.run.simulator import Simulator

_AXES = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class SeenPoint:
    """A point: where it was recorded and where the model has it, (m, 3), m, world."""

    name: str
    recorded: Array
    modelled: Array


@dataclass(frozen=True, eq=False)
class SeenHinge:
    """A hinge: its angle as recorded less the model's, (m,), rad."""

    joint: str
    apart: Array


@dataclass(frozen=True, eq=False)
class Overlaid:
    """A recording beside the model.

    times   (m,), s, of the model's clock, by row
    others  columns that have no place in the world, such as rates
    """

    simulator: Simulator
    times: Array
    points: tuple[SeenPoint, ...]
    hinges: tuple[SeenHinge, ...]
    others: tuple[str, ...]


def overlaid(fit: Fit, which: int) -> Overlaid:
    """Recording number `which` of a fit."""
    predictor, run = fit.predictor, fit.setting.runs[which]
    task = predictor.task(which, fit.values, sloped=False)
    simulator = task.simulator
    flight = predictor.runs.flight(task)
    numbers = {**run.numbers, **fit.values}
    plain = _without_sensors(run, numbers)
    columns = dict(zip(run.sight.columns, plain.T, strict=True))
    points, hinges, others = [], [], []
    for owner in dict.fromkeys(_owner(predictor, which, k) for k in range(len(columns))):
        if owner is None:
            continue
        signals = _signals(simulator, run, tuple(f"{owner}.{axis}" for axis in _AXES))
        modelled = signals.values(flight.motion, task.times, flight.rows)
        points.append(SeenPoint(owner, _placed(run, owner, columns, modelled, numbers), modelled))
    for k, column in enumerate(run.sight.columns):
        if _owner(predictor, which, k) is not None:
            continue
        if column in simulator.joints:
            angle = _signals(simulator, run, (column,)).values(flight.motion, task.times, flight.rows)[:, 0]
            hinges.append(SeenHinge(column, columns[column] - angle))
        else:
            others.append(column)
    return Overlaid(simulator, task.times, tuple(points), tuple(hinges), tuple(others))


def states_at(fit: Fit, which: int, times: Array) -> tuple[Motion, Array]:
    """The motion of a recording's run, and its states (k, n) at ascending times (k,), s, of the model's clock."""
    task = fit.predictor.task(which, fit.values, sloped=False)
    flight = fit.predictor.runs.flight(replace(task, times=times))
    return flight.motion, flight.rows


def _owner(predictor: Predictor, which: int, k: int) -> str | None:
    """The point that a column is a coordinate of; None: of no point."""
    sight = predictor.setting.runs[which].sight
    signal = predictor.signals(which, predictor.setting.simulators.usual).all[sight.told[k].base]
    return sight.columns[k].rpartition(".")[0] if isinstance(signal, Point) else None


def _signals(simulator: Simulator, run: Run, names: tuple[str, ...]) -> Signals:
    found: list[Column | Point] = [
        signal_of(simulator, name, run.recording.markers, run.name) for name in names
    ]
    return Signals(tuple(found))


def _without_sensors(run: Run, numbers: dict[str, float]) -> Array:
    """What was measured (m, k), without gains and biases."""
    gains, biases = (
        np.array([numbers.get(f"{run.name}.{column}.{what}", usual) for column in run.sight.columns])
        for what, usual in (("gain", 1.0), ("bias", 0.0))
    )
    return np.asarray((run.measured - biases) / np.where(gains == 0.0, np.nan, gains))


def _placed(
    run: Run, owner: str, columns: dict[str, Array], modelled: Array, numbers: dict[str, float]
) -> Array:
    """Where a point was recorded (m, 3), m, world; what no column tells is the model's (m, 3). NaN where a column that
    tells of it has a gap."""
    camera = run.recording.camera
    if camera is None or owner not in run.recording.markers:
        turn, scale, origin = np.eye(3), 1.0, np.zeros(3)
    else:
        turn, scale, origin = frame_of(camera, numbers)
    seen = modelled @ turn.T
    for axis, letter in enumerate(_AXES):
        measured = columns.get(f"{owner}.{letter}")
        if measured is not None:
            seen[:, axis] = (measured - origin[axis]) / scale
    placed: Array = seen @ turn
    placed[~np.isfinite(placed).all(axis=1)] = np.nan
    return placed

"""What a model says of a recording, and how it follows from the unknowns.

In: a run of a setting, values of the unknowns. Out: a `Prediction`: values (m, k) and derivatives (m, k, p). States
come from `flights`; from there to the sensors it is the chain rule, by dimensions of the drawing too: another drawing
has other bodies, masses and points.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from lamc.fitting.drawn import Drawn
from lamc.fitting.flights import Flight, Runs, Task, stencil_within
from lamc.fitting.recorded import Run
from lamc.fitting.setting import Setting
from lamc.fitting.signals import Signals, signal_of
from lamc.fitting.simulators import start_of
from lamc.fitting.unknowns import Unknown
from lamc.run.model import Motion
from lamc.run.request import Array
from lamc.run.simulator import Simulator

_START = 1e-5  # rad, rad/s: of differences of starts that close loops
_KEPT = 2  # predictions of each recording: where a solver stands, and what it tries


@dataclass(frozen=True, eq=False)
class Prediction:
    """values: (m, k), NaN where the run did not come; slopes: (m, k, p), by the unknowns' values, or empty; beside:
    (m, k, e), by what else the flight knows its slopes by; message: why a run ended early, else empty."""

    values: Array
    slopes: Array
    message: str = ""
    beside: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))


class Predictor:
    """Predicts the recordings of one setting."""

    def __init__(self, setting: Setting, runs: Runs) -> None:
        self.setting, self.runs = setting, runs
        self._signals: dict[int, Signals] = {}  # of the drawing as it stands
        self._draws = any(u.kind == "dimension" for u in setting.unknowns.all)
        self._known: dict[int, list[tuple[tuple[bytes, bool, bool], Prediction]]] = {}

    @property
    def at_once(self) -> bool:
        """Whether values and derivatives come at once. By dimensions they do not: each takes drawings of its own, which
        cost more than most runs."""
        return self.runs.at_once and not self._draws

    def numbers(self, values: Array) -> dict[str, float]:
        """Values (p,) of the unknowns by name."""
        return dict(zip(self.setting.unknowns.names, values.tolist(), strict=True))

    def prediction(
        self, which: int, values: Array, *, sloped: bool, fine: bool = False, loosely: bool = False
    ) -> Prediction:
        """Of one recording, at values (p,) of the unknowns. fine: derivatives to be trusted, where there is a choice;
        loosely: by a run that is good enough for a solver to walk by."""
        key = (values.tobytes(), fine and not self.at_once, loosely)
        known = self._known.setdefault(which, [])
        for each, found in known:
            if each == key and (found.slopes.shape[2] or not sloped or found.message):
                return found
        found = self._predicted(which, values, sloped=sloped, fine=fine, loosely=loosely)
        if self.runs.forgets:
            known[:] = [(key, found), *(pair for pair in known if pair[0] != key)][:_KEPT]
        return found

    def _predicted(self, which: int, values: Array, *, sloped: bool, fine: bool, loosely: bool) -> Prediction:
        setting, run = self.setting, self.setting.runs[which]
        at = self.numbers(values)
        found, flight, task, simulator = self._seen(which, at, sloped=sloped, fine=fine, loosely=loosely)
        if flight.message:
            empty = np.full((len(run.times), len(run.sight.columns)), np.nan)
            return Prediction(empty, np.zeros((*empty.shape, 0)), flight.message)
        told, by_signal, by_number = run.sight.tells(found, {**run.numbers, **at})
        if not sloped:
            return Prediction(told, np.zeros((*told.shape, 0)))
        slopes = np.zeros((*told.shape, len(values)))
        signals = self.signals(which, simulator)
        by_state = by_signal @ signals.slopes(flight.motion, task.times, flight.rows)
        moved = self.movers(which)
        by_flight = by_state @ flight.slopes
        slopes[:, :, list(moved)] = by_flight[:, :, list(moved.values())]
        for place, each in enumerate(setting.unknowns.all):
            if each.name == f"{run.name}.delay":
                slopes[:, :, place] = -np.einsum(
                    "mkn,mn->mk", by_state, _velocity(flight.motion, task.times, flight.rows)
                )
            elif each.name in by_number:
                slopes[:, :, place] = by_number[each.name]
            elif each.kind == "dimension":
                slopes[:, :, place] += self._by_drawing(which, task, flight, each.name, by_signal)
        return Prediction(told, slopes, beside=by_flight[:, :, len(moved) :])

    def seen(self, which: int, at: Mapping[str, float]) -> tuple[Array, Flight]:
        """Signals (m, K) of a recording's run at numbers of the unknowns, and the flight."""
        found, flight, _, _ = self._seen(which, at, sloped=False)
        return found, flight

    def signals(self, which: int, simulator: Simulator) -> Signals:
        """What the columns of a recording see of a model."""
        run, usual = self.setting.runs[which], self.setting.simulators.usual
        if simulator is usual and which in self._signals:
            return self._signals[which]
        markers = run.recording.markers
        found = Signals(tuple(signal_of(simulator, name, markers, run.name) for name in run.sight.signals))
        if simulator is usual:
            self._signals[which] = found
        return found

    def task(self, which: int, at: Mapping[str, float], *, sloped: bool, fine: bool = False) -> Task:
        """The run of a recording, at numbers of the unknowns. fine: dimensions by four drawings beside, not by two."""
        setting, run = self.setting, self.setting.runs[which]
        unknowns = setting.unknowns.all
        simulator = self._simulator(at)
        parameters = {
            **setting.parameters,
            **{u.key: at[u.name] for u in unknowns if u.kind == "parameter"},
            **run.parameters,
        }
        angles, rates = self.start(run, at)
        y0 = start_of(simulator, angles, rates)
        times = run.times - at.get(f"{run.name}.delay", run.numbers[f"{run.name}.delay"])
        times = np.maximum(times, run.begin)
        if not sloped:
            return Task(simulator, parameters, y0, run.begin, times, which=which)
        sizes = {
            u.key: abs(at[u.name]) if u.log or at[u.name] else u.size
            for u in unknowns
            if u.kind == "parameter"
        }
        drawn = {u.name: self._drawn(run, at, u, fine=fine) for u in unknowns if u.kind == "dimension"}
        moving = [u for u in unknowns if u.owner == run.name and u.kind in ("angle", "rate")]
        directions = [_direction(simulator, angles, rates, u.kind, u.key, y0) for u in moving]
        shaped = np.stack(directions, axis=1) if directions else np.zeros((len(y0), 0))
        reaches = np.ones(len(moving))
        return Task(simulator, parameters, y0, run.begin, times, sizes, drawn, shaped, reaches, which)

    def movers(self, which: int) -> dict[int, int]:
        """Places of unknowns that move the state → columns of a flight's slopes."""
        unknowns, name = self.setting.unknowns.all, self.setting.runs[which].name
        parameters = [k for k, u in enumerate(unknowns) if u.kind == "parameter"]
        dimensions = [k for k, u in enumerate(unknowns) if u.kind == "dimension"]
        starts = [k for k, u in enumerate(unknowns) if u.owner == name and u.kind in ("angle", "rate")]
        return {place: column for column, place in enumerate([*parameters, *dimensions, *starts])}

    def _simulator(self, at: Mapping[str, float]) -> Simulator:
        """Of the drawing with these dimensions."""
        setting = self.setting
        return setting.simulators.of(
            {u.name: at[u.name] for u in setting.unknowns.all if u.kind == "dimension"}
        )

    def start(self, run: Run, at: Mapping[str, float]) -> tuple[dict[str, float], dict[str, float]]:
        """Angles and rates of a recording's start, over the scene's."""
        angles, rates = dict(run.angles), dict(run.rates)
        for u in self.setting.unknowns.all:
            if u.owner == run.name and u.kind in ("angle", "rate"):
                (angles if u.kind == "angle" else rates)[u.key] = at[u.name]
        return angles, rates

    def _drawn(self, run: Run, at: Mapping[str, float], each: Unknown, *, fine: bool) -> Drawn:
        """The drawings beside one, by a dimension, within its bounds: beyond them there may be none."""
        value = at[each.name]
        size = abs(value) or each.size
        weights, offsets = stencil_within(value, size, each.free.low, each.free.high, fine=fine)
        simulators = tuple(self._simulator({**at, each.name: value + offset}) for offset in offsets)
        starts = [start_of(simulator, *self.start(run, at)) for simulator in simulators]
        return Drawn(weights, simulators, np.stack(starts))

    def _seen(
        self,
        which: int,
        at: Mapping[str, float],
        *,
        sloped: bool,
        fine: bool = False,
        loosely: bool = False,
    ) -> tuple[Array, Flight, Task, Simulator]:
        """Signals (m, K), the flight, its task and simulator."""
        task = replace(self.task(which, at, sloped=sloped, fine=fine), loosely=loosely)
        flight = self.runs.sensitive(task, fine=fine) if sloped else self.runs.flight(task)
        if flight.message:
            return np.zeros((0, 0)), flight, task, task.simulator
        return (
            self.signals(which, task.simulator).values(flight.motion, task.times, flight.rows),
            flight,
            task,
            task.simulator,
        )

    def _by_drawing(self, which: int, task: Task, flight: Flight, name: str, by_signal: Array) -> Array:
        """How columns (m, k) follow from a dimension while the state stands: points are those of another drawing."""
        found = np.zeros(by_signal.shape[::2])
        drawn = task.drawn[name]
        for weight, simulator in zip(drawn.weights, drawn.simulators, strict=True):
            signals = self.signals(which, simulator)
            if signals.has_points:
                motion = simulator.model.motion(task.parameters)
                found += weight * signals.values(motion, task.times, flight.rows)
        return np.asarray(np.einsum("mkj,mj->mk", by_signal, found))


def _direction(
    simulator: Simulator,
    angles: Mapping[str, float],
    rates: Mapping[str, float],
    kind: str,
    joint: str,
    y0: Array,
) -> Array:
    """How the start (n,) follows from an angle or a rate of it."""
    plain = not simulator.cut_joints and len(simulator.coordinates) == len(simulator.joints)
    if plain and joint in simulator.joints:
        found = np.zeros_like(y0)
        found[simulator.joints.index(joint) + (len(simulator.coordinates) if kind == "rate" else 0)] = 1.0
        return found
    ends = []
    for step in (-_START, _START):
        moved = {**(angles if kind == "angle" else rates)}
        usual = getattr(simulator.scene, f"{kind}s").get(joint, 0.0)
        moved[joint] = moved.get(joint, usual) + step
        ends.append(
            start_of(simulator, moved if kind == "angle" else angles, moved if kind == "rate" else rates)
        )
    return np.asarray((ends[1] - ends[0]) / (2.0 * _START))


def _velocity(motion: Motion, t: Array, rows: Array) -> Array:
    """Derivatives (m, n) of states by time."""
    rows = np.ascontiguousarray(rows)
    return np.hstack([motion.coordinate_rates(rows), motion.accelerations(t, rows)])

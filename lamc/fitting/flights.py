"""Runs and their derivatives: states at given times, and how each follows from parameters and from the start.

In: a motion, a start, directions in which it may move, names of parameters, drawings beside. Out: `Flight`s. This is
the only place that knows how derivatives are had: here by differences of runs, of fourth order where they are to be
trusted and of second while a solver walks. Never: knows what is measured.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from lamc.fitting.drawn import Drawn
from lamc.records.series import Series
from lamc.run import integrators
from lamc.run.model import Motion
from lamc.run.request import Array, Request
from lamc.run.simulator import Simulator

RTOL, ATOL = 1e-10, 1e-12  # of a step: what differences of runs are taken of
_NEAR = 1e-4  # of a number's size, of two points: misses 1e-8 of it, and the runs' errors come to 1e-6
DIFFERENCED = 1e-6  # see _FAR, and ten times as much
_FAR = 2e-3  # of four points: misses 1e-11, and the runs' errors come to 1e-7


@dataclass(frozen=True, eq=False)
class Task:
    """A run to be made.

    parameters  of the model that are not as ever, SI
    y0          (n,), state at time t_start, s
    times       (m,), s, ascending, none before t_start
    sizes       by parameter: of the change of it that counts as one
    drawn       by dimension of the drawing: the drawings beside
    which       recording it is of
    loosely     whether it need be no better than what a solver walks by
    directions  (n, r): how the start follows from r numbers, of which a change of one is of the size of `reaches` (r,)
    """

    simulator: Simulator
    parameters: Mapping[str, float | Series]
    y0: Array
    t_start: float
    times: Array
    sizes: Mapping[str, float] = field(default_factory=dict)
    drawn: Mapping[str, Drawn] = field(default_factory=dict)
    directions: Array = field(default_factory=lambda: np.zeros((0, 0)))
    reaches: Array = field(default_factory=lambda: np.zeros(0))
    which: int = 0
    loosely: bool = False

    @property
    def numbers(self) -> int:
        """Of parameters and dimensions."""
        return len(self.sizes) + len(self.drawn)


@dataclass(frozen=True, eq=False)
class Flight:
    """States of a run. rows: (m, n); NaN where it did not come; slopes: (m, n, p + d + r), by parameters, then
    dimensions, then directions; (m, n, 0) where nobody asked. message: why it ended early, else empty."""

    motion: Motion
    rows: Array
    slopes: Array
    message: str = ""


class Runs(Protocol):
    """Makes flights."""

    @property
    def count(self) -> int:
        """Runs that were made."""

    @property
    def derivatives_by(self) -> str:
        """How derivatives are had."""

    @property
    def known_to(self) -> float:
        """Errors of derivatives, of the largest."""

    @property
    def notes(self) -> list[str]:
        """Where they may not hold."""

    @property
    def at_once(self) -> bool:
        """Whether states and slopes come of one run."""

    @property
    def forgets(self) -> bool:
        """Whether a flight follows from its task alone."""

    def flight(self, task: Task) -> Flight:
        """States alone."""

    def sensitive(self, task: Task, *, fine: bool) -> Flight:
        """States and slopes. fine: to be trusted, where there is a choice."""


class Differences:
    """Slopes by differences of runs: two for each number while a solver walks, four where they are to be trusted. Its
    runs are never loose: differences are taken of them."""

    at_once = False
    forgets = True

    def __init__(
        self, integrator: str = "auto", rtol: float = RTOL, atol: float = ATOL, max_steps: int = 1_000_000
    ) -> None:
        self.count = 0
        self.notes: list[str] = []
        self._how = integrator
        self._rtol, self._atol, self._max_steps = rtol, atol, max_steps

    @property
    def derivatives_by(self) -> str:
        return "differences of runs, of fourth order at the end"

    @property
    def known_to(self) -> float:
        return DIFFERENCED

    def flight(self, task: Task) -> Flight:
        motion = task.simulator.model.motion(task.parameters)
        rows, message = self._run(task, motion, task.y0)
        return Flight(motion, rows, np.zeros((*rows.shape, 0)), message)

    def sensitive(self, task: Task, *, fine: bool) -> Flight:
        middle = self.flight(task)
        if middle.message:
            return middle
        slopes = np.full((*middle.rows.shape, task.numbers + task.directions.shape[1]), np.nan)
        for k, name in enumerate(task.sizes):
            slopes[:, :, k] = self._by_parameter(task, name, fine=fine)
        for k, drawn in enumerate(task.drawn.values(), len(task.sizes)):
            slopes[:, :, k] = self._by_dimension(task, drawn)
        for k, (direction, reach) in enumerate(
            zip(task.directions.T, task.reaches, strict=True), task.numbers
        ):
            slopes[:, :, k] = self._by_start(task, middle.motion, direction, float(reach), fine=fine)
        return Flight(
            middle.motion, middle.rows, slopes, "" if np.isfinite(slopes).all() else "a run beside fails"
        )

    def _by_parameter(self, task: Task, name: str, *, fine: bool) -> Array:
        model = task.simulator.model
        given = task.parameters.get(name, task.simulator.parameters[name])
        assert not isinstance(given, Series)
        at = float(given)

        def rows(value: float) -> Array:
            return self._run(task, model.motion({**task.parameters, name: value}), task.y0)[0]

        return difference(rows, at, task.sizes[name], least=0.0 if at >= 0.0 else -np.inf, fine=fine)

    def _by_dimension(self, task: Task, drawn: Drawn) -> Array:
        motions = [each.model.motion(task.parameters) for each in drawn.simulators]
        rows = [self._run(task, each, y0)[0] for each, y0 in zip(motions, drawn.starts, strict=True)]
        found: Array = np.einsum("k,kmn->mn", drawn.weights, np.stack(rows))
        return found

    def _by_start(self, task: Task, motion: Motion, direction: Array, reach: float, *, fine: bool) -> Array:
        def rows(step: float) -> Array:
            moved = motion.settled(task.t_start, task.y0 + step * direction)
            return self._run(task, motion, moved)[0]

        return difference(rows, 0.0, reach, fine=fine)

    def _run(self, task: Task, motion: Motion, y0: Array) -> tuple[Array, str]:
        """Rows (m, n), and why it ended early."""
        self.count += 1
        times = task.times
        end = float(times[-1])
        if end <= task.t_start:  # one row, at the start
            return np.tile(y0, (len(times), 1)), ""
        request = Request(
            np.ascontiguousarray(y0),
            end,
            self._rtol,
            self._atol,
            times,
            self._max_steps,
            np.inf,
            None,
            t_start=task.t_start,
        )
        _, done = integrators.integrate(self._how, motion, request)
        if done.status == 0:
            return np.hstack([done.q, done.u]), ""
        return np.full(
            (len(times), len(y0)), np.nan
        ), f"{done.status.name.lower().replace('_', ' ')} at {done.t_reached:g} s"


def difference(function: "Rows", at: float, size: float, *, least: float = -np.inf, fine: bool) -> Array:
    """The derivative of rows by a number: of fourth order if fine, else of second, central where `least` leaves room,
    else forward of the same order."""
    weights, offsets = stencil(at, size, least=least, fine=fine)
    return np.asarray(sum(w * function(at + h) for w, h in zip(weights, offsets, strict=True)))


def stencil(at: float, size: float, *, least: float = -np.inf, fine: bool) -> tuple[Array, Array]:
    """Weights and offsets (k,) of such differences."""
    step = (_FAR if fine else _NEAR) * size
    offsets = step * (np.array([-2.0, -1.0, 1.0, 2.0]) if fine else np.array([-1.0, 1.0]))
    if at + offsets[0] <= least:  # its own value would do, but a size of zero may make another model of it
        offsets = step * (np.arange(1.0, 6.0) if fine else np.arange(1.0, 4.0))
    return weights_of(offsets), offsets


def stencil_within(at: float, size: float, low: float, high: float, *, fine: bool) -> tuple[Array, Array]:
    """Weights and offsets (k,) of differences of the same order that stay within bounds, of what is known at `at` as
    well as beside: central where there is room, else on the side that has more of it, by a shorter step if it must."""
    weights, offsets = stencil(at, size, fine=fine)
    room = max(high - at, at - low)
    if (low <= at + offsets[0] and at + offsets[-1] <= high) or room <= 0.0:
        return weights, offsets
    places = np.arange(5.0 if fine else 3.0)
    step = min(
        (_FAR if fine else _NEAR) * size, (1.0 - 1e-9) * room / places[-1]
    )  # no bound is passed by round-off
    offsets = (step if high - at >= at - low else -step) * places
    return weights_of(offsets), offsets


def weights_of(offsets: Array) -> Array:
    """Weights (k,) of values at offsets whose sum is the first derivative at zero of the polynomial through them."""
    scale = float(np.max(np.abs(offsets)))
    powers = np.vander(offsets / scale, increasing=True).T
    wanted = np.zeros(len(offsets))
    wanted[1] = 1.0 / scale
    return np.asarray(np.linalg.solve(powers, wanted))


class Rows(Protocol):
    def __call__(self, value: float, /) -> Array: ...


def ordered(names: Sequence[str], sizes: Mapping[str, float]) -> dict[str, float]:
    """Sizes in the order of names."""
    return {name: sizes[name] for name in names}

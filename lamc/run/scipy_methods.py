"""Drives scipy's integrators step by step on the compiled right-hand side: a second opinion, and stiff
methods.

In: a `Motion`, a `Request`, a method's name. Out: a `Trajectory`, with the same ends as the C integrator has.
Never: hides a failure; scipy's own words are in `note`.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.integrate import BDF, DOP853, LSODA, RK23, RK45, Radau

from lamc.basics.errors import RequestError
from lamc.run.following import stretches
from lamc.run.model import Motion
from lamc.run.request import Array, Request, Status, Trajectory
from lamc.run.scipy_derivatives import Variation

METHODS = {"RK23": RK23, "RK45": RK45, "DOP853": DOP853, "Radau": Radau, "BDF": BDF, "LSODA": LSODA}


class _Output:
    """Rows at the requested times, or after every step."""

    def __init__(self, request: Request) -> None:
        self._times = request.t_eval
        self._next = 0
        self.t: list[Array] = []
        self.y: list[Array] = []
        if self._times is None:
            self._add(np.zeros(1), request.y0.reshape(1, -1))
        elif len(self._times) and self._times[0] == 0.0:
            self._add(self._times[:1], request.y0.reshape(1, -1))
            self._next = 1

    def _add(self, t: Array, y: Array) -> None:
        self.y.append(y.copy())
        self.t.append(t.copy())

    def after(self, solver: RK45) -> Array:
        """Takes the rows that the step just made gives; their times."""
        if self._times is None:
            self._add(np.array([solver.t]), solver.y.reshape(1, -1))
            return self.t[-1]
        stop = int(np.searchsorted(self._times, solver.t, side="right"))
        times = self._times[self._next : stop]
        if len(times):
            self._add(times, solver.dense_output()(times).T)
            self._next = stop
        return times


def integrate(motion: Motion, request: Request, method: str) -> Trajectory:
    """Runs to the end, an obstacle or Ctrl-C; KeyboardInterrupt gives Status.CANCELLED and what there is. Raises
    RequestError for a model that samples: nothing would be held in between."""
    if motion.model.has_clocks:
        raise RequestError(
            f"scipy:{method} does not end its steps where a controller samples (Servo.period), and holds nothing in "
            "between; take an integrator of lamc's own"
        )
    variation = None if request.along is None else Variation(motion, request, method)
    found = _integrated(motion, request, method, variation)
    if variation is None:
        return found
    return replace(found, along=variation.of_rows(len(found.t)), lost=variation.lost)


def _integrated(motion: Motion, request: Request, method: str, variation: Variation | None) -> Trajectory:
    """The run. variation: is told its steps."""
    output = _Output(request)
    accepted = 0
    last_step = 0.0
    reached = (0.0, request.y0)  # one assignment, so that an interrupt cannot part time and state
    note = ""
    nq = len(motion.model.coordinates)
    if not np.isfinite(motion.rhs(0.0, request.y0)).all():
        return _trajectory(nq, output, reached, Status.NOT_FINITE, note, 1, 0, 0.0)
    if request.t_end == 0.0 or not len(request.y0):  # scipy cannot treat an empty state
        return _nothing_moves(nq, request)
    status = Status.REACHED_END
    solvers = []
    try:
        with np.errstate(all="ignore"):  # NaN and infinity are told by the status
            for begin, end in stretches(motion.following.breaks_of_run(request), 0.0, request.t_end):
                solver = METHODS[method](
                    _before(motion, end),
                    begin,
                    reached[1],
                    end,
                    rtol=request.rtol,
                    atol=request.atol,
                    max_step=request.max_step,
                )
                solvers.append(solver)
                while solver.status == "running":
                    if accepted >= request.max_steps:
                        status = Status.STEP_LIMIT
                        break
                    note = solver.step() or ""
                    if solver.status == "failed" or not np.isfinite(solver.y).all():
                        status = _failure(motion, solver)
                        break
                    accepted += 1
                    before, last_step = reached, float(solver.t - solver.t_old)
                    reached = (float(solver.t), solver.y.copy())
                    times = output.after(solver)
                    if variation is not None:
                        variation.after(*before, reached[0], times)
                    if request.progress is not None:
                        request.progress(reached[0], request.t_end)
                    if request.until is not None and (why := request.until(reached[1])):
                        status, note = Status.FOLDED, why
                        break
                if status != Status.REACHED_END:
                    break
    except KeyboardInterrupt:
        status = Status.CANCELLED
    except ValueError as error:  # the linear algebra of implicit methods refuses NaN
        status, note = Status.NOT_FINITE, str(error)
    evaluations = sum(int(solver.nfev) for solver in solvers)
    return _trajectory(nq, output, reached, status, note, evaluations, accepted, last_step)


def _before(motion: Motion, end: float) -> Callable[[float, Array], Array]:
    """The right-hand side up to `end`, s; where inputs jump there, as it is before."""
    if not motion.following.series:
        return motion.rhs
    last = float(np.nextafter(end, -np.inf))
    return lambda t, y: motion.rhs(min(t, last), y)


def _failure(motion: Motion, solver: RK45) -> Status:
    """What a failed step means: NaN ahead of a point where all is well shows in the rate of change around
    it."""
    finite = np.isfinite(solver.y).all() and np.isfinite(motion.rhs(solver.t, solver.y)).all()
    if not finite:
        return Status.NOT_FINITE
    return Status.FAILED if isinstance(solver, LSODA) else Status.STEP_UNDERFLOW


def _nothing_moves(nq: int, request: Request) -> Trajectory:
    times = np.array([0.0, request.t_end]) if request.t_eval is None else request.t_eval
    if request.t_end == 0.0:
        times = times[:1]
    y = np.tile(request.y0, (len(times), 1))
    q, u = y[:, :nq].copy(), y[:, nq:].copy()
    return Trajectory(times, q, u, request.t_end, Status.REACHED_END, "", 1, 0, None, 0.0)


def _trajectory(
    nq: int,
    output: _Output,
    reached: tuple[float, Array],
    status: Status,
    note: str,
    evaluations: int,
    accepted: int,
    last_step: float,
) -> Trajectory:
    t_reached, y_reached = reached
    t = np.concatenate([np.zeros(0), *output.t])
    y = np.concatenate([np.zeros((0, len(y_reached))), *output.y])[: len(t)]
    if status != Status.REACHED_END and (not len(t) or t_reached > t[-1]):
        t, y = np.append(t, t_reached), np.vstack([y, y_reached])
    q, u = y[:, :nq].copy(), y[:, nq:].copy()
    return Trajectory(
        t, q, u, t_reached, status, note, evaluations, accepted, None, last_step, effort=float(evaluations)
    )

"""Drives the integrators of the C runtime in slices, so that Ctrl-C is answered between them.

In: a `Motion`, a `Request` and a method's name. Out: a `Trajectory`. Never: computes a step itself.

The C loop runs without the GIL for about SLICE seconds at a time. A slice ends between two steps, so the
numbers do not depend on where slices end. Rows go into chunks of one size that are never moved: Ctrl-C then waits for
no copying but the last, which puts them together.
"""

import math
import time
from typing import Any

import numpy as np

from lamc.basics.errors import SimulationError
from lamc.run.following import Recorded
from lamc.run.methods import LINEAR_ALGEBRA, NUMBERS
from lamc.run.model import Model, Motion
from lamc.run.request import Array, Request, Status, Trajectory

SLICE = 0.02  # s of wall time; Ctrl-C is answered after one at the latest
FIRST_BUDGET = 500  # evaluations; even a thousand hinges stay below SLICE with it
EVENTS = 4096  # room for events in a chunk
NAMES = {number: name for name, number in NUMBERS.items()}
CHUNK = 2**18  # numbers in a chunk of rows, 2 MiB; C needs longer to fill one than a slice lasts


class _Chunk:
    """Room for rows, and the C record that counts them."""

    def __init__(self, model: Model, capacity: int, integrals: int) -> None:
        self._t, self._y = np.empty(capacity), np.empty((capacity, model.state_size))
        self.handle: Any = model.ffi.new("lamc_rows *")
        self.handle.t, self.handle.y = model.write(self._t), model.write(self._y)
        self.handle.capacity = capacity
        self._integrals = np.empty((capacity, integrals))
        if integrals:
            self.handle.integrals = model.write(self._integrals)
        if not model.guards:
            return
        self._event_t, self._event_guard = np.empty(EVENTS), np.empty(EVENTS, dtype=np.int32)
        self.handle.event_t = model.write(self._event_t)
        self.handle.event_guard = model.ffi.from_buffer("int[]", self._event_guard, require_writable=True)
        self.handle.event_capacity = EVENTS

    @property
    def rows(self) -> tuple[Array, Array, Array]:
        """Times (m,), states (m, nq + nu) and integrals written so far."""
        count = int(self.handle.count)
        return self._t[:count], self._y[:count], self._integrals[:count]

    @property
    def events(self) -> list[tuple[float, int]]:
        """Times and guards of the events written so far."""
        count = int(self.handle.event_count)
        if not count:
            return []
        return list(zip(self._event_t[:count].tolist(), self._event_guard[:count].tolist(), strict=True))


class _Rows:
    """Chunks for C to write rows to. One append adds a chunk, so that an interrupt cannot come in between."""

    def __init__(self, model: Model, times: Array | None, integrals: int) -> None:
        self._model, self._integrals = model, integrals
        known = max(CHUNK // (model.state_size + 1), 1) if times is None else max(len(times), 1)
        self._capacity = known
        self._chunks = [_Chunk(model, known, integrals)]

    @property
    def handle(self) -> Any:
        return self._chunks[-1].handle

    def grow(self) -> None:
        self._chunks.append(_Chunk(self._model, self._capacity, self._integrals))

    @property
    def events(self) -> tuple[tuple[float, int], ...]:
        return tuple(event for chunk in self._chunks for event in chunk.events)

    def taken(self, last: tuple[Array, Array, Array] | None) -> tuple[Array, Array, Array, Array]:
        """Times, coordinates, rates and integrals, with the row `last` put behind them if it lies beyond."""
        parts = [chunk.rows for chunk in self._chunks]
        n = len(self._model.coordinates)
        if last is None and len(parts) == 1:  # as most runs, at a third of the time
            t, y, w = parts[0]
            return t.copy(), y[:, :n].copy(), y[:, n:].copy(), w.copy()
        reached = max((float(t[-1]) for t, _, _ in parts if len(t)), default=-math.inf)
        if last is not None and last[0][0] > reached:
            parts.append(last)
        t = np.concatenate([t for t, _, _ in parts])
        q, u = (np.concatenate([y[:, half] for _, y, _ in parts]) for half in (np.s_[:n], np.s_[n:]))
        return t, q, u, np.concatenate([w for _, _, w in parts])


def integrate(motion: Motion, request: Request, method: str) -> tuple[str, Trajectory]:
    """Runs to the end, an obstacle or Ctrl-C; KeyboardInterrupt gives Status.CANCELLED and what there is. The names of
    the methods that were used come first."""
    with motion.opened() as handle:
        if not motion.following.series:
            return _integrated(motion.model, handle, request, method)
        recorded = Recorded(motion.model.ffi, motion.following, motion.following.breaks_of_run(request))
        handle.recording = recorded.handle
        return _integrated(motion.model, handle, request, method)


def _integrated(model: Model, motion: Any, request: Request, method: str) -> tuple[str, Trajectory]:
    """The same on a `lamc_motion` that is this run's alone."""
    ffi, lib = model.ffi, model.lib
    ode = ffi.new("lamc_ode *", lib.lamc_motion_ode(motion))
    if not request.energy_balance:
        ode.integral_count = 0
    size = lib.lamc_run_work_size(ode, NUMBERS[method])
    work = np.empty(max(size, 1))
    max_step = request.max_step if math.isfinite(request.max_step) else 0.0
    options = ffi.new("lamc_options *", [request.rtol, request.atol, 0.0, max_step, request.max_steps])
    times = request.t_eval
    run = ffi.new("lamc_run *")
    rows = _Rows(model, times, int(ode.integral_count))
    status = lib.lamc_run_start(
        run,
        ode,
        NUMBERS[method],
        options,
        request.t_start,
        model.read(request.y0),
        request.t_end,
        ffi.NULL if times is None else model.read(times),
        0 if times is None else len(times),
        model.write(work),
    )
    if status == lib.LAMC_BAD_ARGUMENT:  # checked_request should have seen it
        raise SimulationError("the integrator refuses these arguments; please report this as a bug of lamc")
    first_method = run.method
    if status == lib.LAMC_OK:
        status = _advance(model, run, rows, request)
    t, q, u, kept_work = rows.taken(_last_row(model, run, ode, request) if status < 0 else None)
    first = NAMES[first_method]
    kept = min(int(run.switches), lib.LAMC_SWITCHES_KEPT)
    switches = tuple((float(run.switch_t[i]), NAMES[run.switch_method[i]]) for i in range(kept))
    used = ", ".join(dict.fromkeys([first, *(name for _, name in switches)]))
    return used, Trajectory(
        t=t,
        q=q,
        u=u,
        t_reached=float(run.t),
        status=Status(status),
        note="",
        evaluations=int(run.evaluations),
        accepted=int(run.accepted),
        rejected=int(run.rejected),
        last_step=float(run.h_last),
        work=kept_work if request.energy_balance else None,
        effort=run.evaluations + run.jacobians * ode.jacobian_cost + run.factorisations * LINEAR_ALGEBRA,
        events=rows.events,
        switches=switches,
        singular_steps=int(model.lib.lamc_motion_singular_steps(motion)),
    )


def _last_row(model: Model, run: Any, ode: Any, request: Request) -> tuple[Array, Array, Array]:
    """Time (1,), state (1, nq + nu) and integrals (1, k) of the last state that a run reached."""
    state = model.lib.lamc_run_state(run)
    known = 0 if run.integrals == model.ffi.NULL else int(ode.integral_count)
    y = np.array([[state[i] for i in range(len(request.y0))]], dtype=np.float64)
    work = np.array([run.integrals[i] for i in range(known)], dtype=np.float64).reshape(1, known)
    return np.array([float(run.t)]), y, work


def _advance(model: Model, run: Any, rows: _Rows, request: Request) -> int:
    """Slices until the run is over; its last status."""
    lib, null = model.lib, model.ffi.NULL
    budget = FIRST_BUDGET
    try:
        while True:
            before, started = run.evaluations, time.perf_counter()
            status = int(lib.lamc_run_advance(run, rows.handle, budget, null))
            if status <= 0:
                return status
            if status == lib.LAMC_OUTPUT_FULL:
                rows.grow()
            if request.progress is not None:
                request.progress(float(run.t), request.t_end)
            spent = max(time.perf_counter() - started, 1e-6)
            pace = (run.evaluations - before) / spent  # evaluations per second
            budget = int(min(max(pace * SLICE, 10), 10 * budget))
    except KeyboardInterrupt:
        return int(Status.CANCELLED)

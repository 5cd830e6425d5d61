"""Drives the Dormand–Prince integrator of the C runtime in slices, so that Ctrl-C is answered between them.

In: a `Motion` and a `Request`. Out: a `Trajectory`. Never: computes a step itself.

The C loop runs without the GIL for about SLICE seconds at a time. A slice ends between two steps, so the
numbers do not depend on where slices end. Rows go into chunks of one size that are never moved: Ctrl-C then waits for
no copying but the last, which puts them together.
"""

import math
import time
from typing import Any

import numpy as np

from lamc.errors import SimulationError
from lamc.run.model import Model, Motion
from lamc.run.request import Array, Request, Status, Trajectory

SLICE = 0.02  # s of wall time; Ctrl-C is answered after one at the latest
FIRST_BUDGET = 500  # evaluations; even a thousand hinges stay below SLICE with it
CHUNK = 2**18  # numbers in a chunk of rows, 2 MiB; C needs longer to fill one than a slice lasts


class _Chunk:
    """Room for rows, and the C record that counts them."""

    def __init__(self, model: Model, capacity: int) -> None:
        self._t, self._y = np.empty(capacity), np.empty((capacity, 2 * len(model.joints)))
        self.handle: Any = model.ffi.new("lamc_rows *")
        self.handle.t, self.handle.y = model.write(self._t), model.write(self._y)
        self.handle.capacity = capacity

    @property
    def rows(self) -> tuple[Array, Array]:
        """Times (m,) and states (m, 2n) written so far."""
        count = int(self.handle.count)
        return self._t[:count], self._y[:count]


class _Rows:
    """Chunks for C to write rows to. One append adds a chunk, so that an interrupt cannot come in between."""

    def __init__(self, model: Model, times: Array | None) -> None:
        self._model = model
        known = max(CHUNK // (2 * len(model.joints) + 1), 1) if times is None else max(len(times), 1)
        self._capacity = known
        self._chunks = [_Chunk(model, known)]

    @property
    def handle(self) -> Any:
        return self._chunks[-1].handle

    def grow(self) -> None:
        self._chunks.append(_Chunk(self._model, self._capacity))

    def taken(self, t_last: float, y_last: Array) -> tuple[Array, Array, Array]:
        """Times, angles and rates, with the state at t_last put behind them if it lies beyond."""
        parts = [chunk.rows for chunk in self._chunks]
        if t_last > max((float(t[-1]) for t, _ in parts if len(t)), default=-math.inf):
            parts.append((np.array([t_last]), y_last.reshape(1, -1)))
        n = len(self._model.joints)
        t = np.concatenate([t for t, _ in parts])
        return t, np.concatenate([y[:, :n] for _, y in parts]), np.concatenate([y[:, n:] for _, y in parts])


def integrate(motion: Motion, request: Request) -> Trajectory:
    """Runs to the end, an obstacle or Ctrl-C; KeyboardInterrupt gives Status.CANCELLED and what there is."""
    model = motion.model
    ffi, lib = model.ffi, model.lib
    ode = ffi.new("lamc_ode *", lib.lamc_motion_ode(motion.handle))
    work = np.empty(lib.lamc_rk45_work_size(ode.n))
    max_step = request.max_step if math.isfinite(request.max_step) else 0.0
    options = ffi.new("lamc_options *", [request.rtol, request.atol, 0.0, max_step, request.max_steps])
    times = request.t_eval
    run = ffi.new("lamc_rk45 *")
    rows = _Rows(model, times)
    status = lib.lamc_rk45_start(
        run,
        ode,
        options,
        0.0,
        model.read(request.y0),
        request.t_end,
        ffi.NULL if times is None else model.read(times),
        0 if times is None else len(times),
        model.write(work),
    )
    if status == lib.LAMC_BAD_ARGUMENT:  # checked_request should have seen it
        raise SimulationError("the integrator refuses these arguments; please report this as a bug of lamc")
    if status == lib.LAMC_OK:
        status = _advance(motion, run, rows, request)
    t_last, y_last = _last_good(model, run, status, len(request.y0))
    t, q, u = rows.taken(t_last if status < 0 else -math.inf, y_last)
    return Trajectory(
        t=t,
        q=q,
        u=u,
        t_reached=t_last,
        status=Status(status),
        note="",
        evaluations=int(run.evaluations),
        accepted=int(run.accepted),
        rejected=int(run.rejected),
        last_step=float(run.h_last),
    )


def _last_good(model: Model, run: Any, status: int, width: int) -> tuple[float, Array]:
    """The last time and state (width,) that hold: those where the run stands, or where a loop came apart in the last
    step those before it."""
    if status == Status.CLOSURE_LOST:
        y = np.empty(width)
        interpolated = model.lib.lamc_rk45_interpolate(run, run.t_old, model.write(y))
        assert interpolated == model.lib.LAMC_OK
        return float(run.t_old), y
    state = model.lib.lamc_rk45_state(run)
    return float(run.t), np.array([state[i] for i in range(width)], dtype=np.float64)


def _advance(motion: Motion, run: Any, rows: _Rows, request: Request) -> int:
    """Slices until the run is over; its last status."""
    lib, null = motion.model.lib, motion.model.ffi.NULL
    budget = FIRST_BUDGET
    try:
        while True:
            before, started = run.evaluations, time.perf_counter()
            status = int(lib.lamc_rk45_advance(run, rows.handle, budget, null))
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

"""Drives the Dormand–Prince integrator of the C runtime in slices, so that Ctrl-C is answered between them.

In: a `Motion` and a `Request`. Out: a `Trajectory`. Never: computes a step itself.

The C loop runs without the GIL for about SLICE seconds at a time. A slice ends between two steps, so the
numbers do not depend on where slices end.
"""

import math
import time
from typing import Any

import numpy as np

from lamc.errors import SimulationError
from lamc.run.model import Motion
from lamc.run.request import Request, Status, Trajectory

SLICE = 0.02  # s of wall time; Ctrl-C is answered after one at the latest
FIRST_BUDGET = 500  # evaluations; even a thousand hinges stay below SLICE with it
FIRST_ROWS = 1024


class _Rows:
    """Buffers for C to write rows to. They grow; the C side counts the rows."""

    def __init__(self, motion: Motion, capacity: int) -> None:
        self._model = motion.model
        self._width = 2 * len(motion.model.joints)
        self.handle: Any = self._model.ffi.new("lamc_rows *")
        self._use(np.empty(capacity), np.empty((capacity, self._width)), capacity)

    def _use(self, t: Any, y: Any, capacity: int) -> None:
        self._t, self._y = t, y
        self.handle.t, self.handle.y = self._model.write(t), self._model.write(y)
        self.handle.capacity = capacity

    def grow(self) -> None:
        """Doubles the room and keeps the rows."""
        count, capacity = int(self.handle.count), 2 * int(self.handle.capacity)
        t, y = np.empty(capacity), np.empty((capacity, self._width))
        t[:count], y[:count] = self._t[:count], self._y[:count]
        self._use(t, y, capacity)

    def taken(self) -> tuple[Any, Any]:
        count = int(self.handle.count)
        return self._t[:count].copy(), self._y[:count].copy()


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
    rows = _Rows(motion, FIRST_ROWS if times is None else max(len(times), 1))
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
    t, y = rows.taken()
    if not len(t) and times is None:  # not even the start could be evaluated: the start itself is known
        t, y = np.zeros(1), request.y0.reshape(1, -1).copy()
    return Trajectory(
        t=t,
        y=y,
        t_reached=float(run.t),
        status=Status(status),
        note="",
        evaluations=int(run.evaluations),
        accepted=int(run.accepted),
        rejected=int(run.rejected),
        last_step=float(run.h_last),
    )


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
                continue
            if request.progress is not None:
                request.progress(float(run.t), request.t_end)
            spent = max(time.perf_counter() - started, 1e-6)
            pace = (run.evaluations - before) / spent  # evaluations per second
            budget = int(min(max(pace * SLICE, 10), 10 * budget))
    except KeyboardInterrupt:
        return int(Status.CANCELLED)

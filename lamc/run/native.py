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
from lamc.run.request import Along, Array, Request, Status, Trajectory
from lamc.run.taping import TapedRun

SLICE = 0.02  # s of wall time; Ctrl-C is answered after one at the latest
FIRST_BUDGET = 500  # evaluations; even a thousand hinges stay below SLICE with it
WORK_DONE = "its loops have taken the work that was allowed"  # why a run ended
ASKING = 1  # evaluations: a run that may end before is asked after each step, on any machine alike
EVENTS = 4096  # room for events in a chunk
NAMES = {number: name for name, number in NUMBERS.items()}
CHUNK = 2**18  # numbers in a chunk of rows, 2 MiB; C needs longer to fill one than a slice lasts


class _Chunk:
    """Room for rows, and the C record that counts them."""

    def __init__(self, model: Model, capacity: int, integrals: int, columns: int) -> None:
        self.along = np.empty((capacity, model.state_size, columns))  # derivatives of the rows
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
    def rows(self) -> tuple[Array, Array, Array, Array]:
        """Times (m,), states (m, nq + nu), integrals and derivatives written so far."""
        count = int(self.handle.count)
        return self._t[:count], self._y[:count], self._integrals[:count], self.along[:count]

    @property
    def events(self) -> list[tuple[float, int]]:
        """Times and guards of the events written so far."""
        count = int(self.handle.event_count)
        if not count:
            return []
        return list(zip(self._event_t[:count].tolist(), self._event_guard[:count].tolist(), strict=True))


class _Rows:
    """Chunks for C to write rows to. One append adds a chunk, so that an interrupt cannot come in between."""

    def __init__(self, model: Model, times: Array | None, integrals: int, columns: int) -> None:
        self._model, self._more = model, (integrals, columns)
        size = model.state_size * (1 + columns) + 1
        self._capacity = max(CHUNK // size, 1) if times is None else max(len(times), 1)
        self._chunks = [_Chunk(model, self._capacity, *self._more)]

    @property
    def handle(self) -> Any:
        return self._chunks[-1].handle

    @property
    def along(self) -> Array:
        """Room for the derivatives of the rows of `handle`."""
        return self._chunks[-1].along

    def grow(self) -> None:
        self._chunks.append(_Chunk(self._model, self._capacity, *self._more))

    @property
    def events(self) -> tuple[tuple[float, int], ...]:
        return tuple(event for chunk in self._chunks for event in chunk.events)

    def taken(self, last: tuple[Array, ...] | None) -> tuple[Array, Array, Array, Array, Array]:
        """Times, coordinates, rates, integrals and derivatives, with the row `last` put behind them if it lies
        beyond."""
        parts = [chunk.rows for chunk in self._chunks]
        n = len(self._model.coordinates)
        if last is None and len(parts) == 1:  # as most runs, at a third of the time
            t, y, w, s = parts[0]
            return t.copy(), y[:, :n].copy(), y[:, n:].copy(), w.copy(), s.copy()
        reached = max((float(part[0][-1]) for part in parts if len(part[0])), default=-math.inf)
        if last is not None and last[0][0] > reached:
            parts.append(last)  # type: ignore[arg-type]
        t, y, w, s = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        return t, y[:, :n], y[:, n:], w, s


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
    work = np.empty(max(lib.lamc_run_work_size(ode, NUMBERS[method]), 1))
    max_step = request.max_step if math.isfinite(request.max_step) else 0.0
    options = ffi.new("lamc_options *", [request.rtol, request.atol, 0.0, max_step, request.max_steps])
    times = request.t_eval
    start = model.read(request.y0)
    asked = (ffi.NULL, 0) if times is None else (model.read(times), len(times))
    columns = 0 if request.along is None else request.along.start.shape[1]
    rows = _Rows(model, times, int(ode.integral_count), columns)
    engine: _Run | _Differentiated | TapedRun
    if request.tape is not None:
        engine = TapedRun(model, rows, request.tape)
        request.tape.request = request
        given = (request.t_start, start, request.t_end, *asked, model.write(work))
        status = engine.start(motion, NUMBERS[method], options, *given)
    elif request.along is None:
        engine = _Run(model, rows)
        given = (request.t_start, start, request.t_end, *asked, model.write(work))
        status = engine.start(ode, NUMBERS[method], options, *given)
    else:
        engine = _Differentiated(model, rows, request.along)
        began = (request.t_start, start)
        status = engine.start(
            motion, NUMBERS[method], options, began, request.t_end, *asked, model.write(work)
        )
    if status == lib.LAMC_BAD_ARGUMENT:  # checked_request should have seen it
        raise SimulationError("the integrator refuses these arguments; please report this as a bug of lamc")
    run = engine.run
    first_method, modes = run.method, model.modes(motion)
    note = ""
    if status == lib.LAMC_OK:
        status, note = _advance(model, motion, engine, request)
    if isinstance(engine, TapedRun):
        engine.close()
    last = _last_row(model, run, ode, request, columns) if status != lib.LAMC_OK else None
    t, q, u, kept_work, along = rows.taken(last)
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
        note=note,
        evaluations=int(run.evaluations),
        accepted=int(run.accepted),
        rejected=int(run.rejected),
        last_step=float(run.h_last),
        work=kept_work if request.energy_balance else None,
        effort=run.evaluations + run.jacobians * ode.jacobian_cost + run.factorisations * LINEAR_ALGEBRA,
        events=rows.events,
        switches=switches,
        singular_steps=int(model.lib.lamc_motion_singular_steps(motion)),
        along=None if request.along is None else along,
        lost=engine.lost,
        modes=(modes, model.modes(motion)),
    )


class _Run:
    """A `lamc_run`."""

    lost = None

    def __init__(self, model: Model, rows: _Rows) -> None:
        self._lib, self._null, self.rows = model.lib, model.ffi.NULL, rows
        self.run: Any = model.ffi.new("lamc_run *")

    def start(self, *given: Any) -> int:
        return int(self._lib.lamc_run_start(self.run, *given))

    def advance(self, budget: int) -> int:
        return int(self._lib.lamc_run_advance(self.run, self.rows.handle, budget, self._null))


class _Differentiated:
    """A `lamc_sensitivity`: a run with the derivatives of its states."""

    def __init__(self, model: Model, rows: _Rows, along: Along) -> None:
        self._model, self._lib, self.rows, self._along = model, model.lib, rows, along
        self._handle: Any = model.ffi.new("lamc_sensitivity *")

    @property
    def run(self) -> Any:
        return self._handle.run

    @property
    def lost(self) -> tuple[float, int, int] | None:
        """Since when there are no derivatives, why, and at which guard."""
        s = self._handle
        return (float(s.t_lost), int(s.lost), int(s.lost_guard)) if s.lost else None

    def start(self, motion: Any, method: int, options: Any, began: tuple[float, Any], *until: Any) -> int:
        model, lib, along = self._model, self._lib, self._along
        columns, tangents = along.start.shape[1], lib.lamc_this_tangents()
        self._work = np.empty(max(int(lib.lamc_sensitivity_work_size(motion.model, tangents, columns)), 1))
        given = (model.read(along.inputs), model.read(along.directions), columns)
        return int(
            lib.lamc_sensitivity_start(
                self._handle,
                motion,
                tangents,
                *given,
                method,
                options,
                *began,
                model.read(along.start),
                *until,
                model.write(self._work),
            )
        )

    def advance(self, budget: int) -> int:
        out = self._model.write(self.rows.along)
        return int(
            self._lib.lamc_sensitivity_advance(
                self._handle, self.rows.handle, out, budget, self._model.ffi.NULL
            )
        )


def _last_row(model: Model, run: Any, ode: Any, request: Request, columns: int) -> tuple[Array, ...]:
    """Time (1,), state (1, nq + nu), integrals (1, k) and derivatives of the last state that a run reached."""
    known = 0 if run.integrals == model.ffi.NULL else int(ode.integral_count)
    y = _state(model, run, len(request.y0)).reshape(1, -1)
    work = np.array([run.integrals[i] for i in range(known)], dtype=np.float64).reshape(1, known)
    unknown = np.full((1, len(request.y0), columns), math.nan)  # of a state where the run failed
    return np.array([float(run.t)]), y, work, unknown


def _state(model: Model, run: Any, size: int) -> Array:
    """The state (size,) where a run stands."""
    state = model.lib.lamc_run_state(
        run if model.ffi.typeof(run).kind == "pointer" else model.ffi.addressof(run)
    )
    return np.frombuffer(model.ffi.buffer(state, 8 * size)).copy() if size else np.zeros(0)


def _advance(
    model: Model, motion: Any, engine: "_Run | _Differentiated | TapedRun", request: Request
) -> tuple[int, str]:
    """Slices until the run is over; its last status, and why it ended before, where it was asked."""
    lib, run = model.lib, engine.run
    is_limited = math.isfinite(request.most_work) and model.cuts
    asks = request.until is not None or is_limited
    budget = ASKING if asks else FIRST_BUDGET
    told = time.perf_counter()
    try:
        while True:
            before, started = run.evaluations, time.perf_counter()
            status = engine.advance(budget)
            if status < 0 or (status == 0 and not asks):
                return status, ""
            if status == lib.LAMC_OUTPUT_FULL:
                engine.rows.grow()
            if request.until is not None and (why := request.until(_state(model, run, len(request.y0)))):
                return int(Status.FOLDED), why
            if status == 0:
                return status, ""
            share = float(lib.lamc_motion_work_done(motion)) / request.most_work if is_limited else 0.0
            if share > 1.0:
                return int(Status.STEP_LIMIT), WORK_DONE
            now = time.perf_counter()
            if request.progress is not None and (not asks or now - told >= SLICE):
                request.progress(max(float(run.t), share * request.t_end), request.t_end)
                told = now
            if not asks:
                pace = (run.evaluations - before) / max(now - started, 1e-6)  # evaluations per second
                budget = int(min(max(pace * SLICE, 10), 10 * budget))
    except KeyboardInterrupt:
        return int(Status.CANCELLED), ""

"""Ensembles: many runs of one simulator, with parameters and starts of their own, side by side in C.

In: a model compiled with lanes, parameters and starts of all instances, a `Request`. Out: an `Ensemble`. Never:
computes a step itself; lets one instance change another: each has the bits of `Simulator.run` with its values, however
many there are.

Threads take instances from one queue in C, without the GIL. Ctrl-C ends them between two steps and keeps what there is.
"""

import math
import os
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lamc.basics.brief import brief
from lamc.basics.errors import RequestError
from lamc.run.following import NOTHING, Following, Recorded
from lamc.run.methods import NUMBERS
from lamc.run.model import CompiledModule
from lamc.run.request import Array, Request, Status

if TYPE_CHECKING:
    from concurrent.futures import Future

    from lamc.run.result import Result

Integers = npt.NDArray[np.int64]
AWAKE = 0.05  # s between two looks at what threads do: what Ctrl-C waits at most, beside one step
NAMES = {number: name for name, number in NUMBERS.items()}


@dataclass(frozen=True, eq=False)
class EnsembleStats:
    """What an ensemble took. Arrays have shape (instances,).

    evaluations   of the right-hand side
    accepted, rejected  steps
    events        limits reached or left, and impacts
    integrators   the last one that each instance used
    lanes         instances side by side on each thread; 1: one after the other
    why_alone     why there are no lanes, or why some steps had none; empty where all had
    threads       how many took part
    wall_time     s, without compiling
    """

    evaluations: Integers
    accepted: Integers
    rejected: Integers
    events: Integers
    integrators: tuple[str, ...]
    lanes: int
    why_alone: str
    threads: int
    wall_time: float
    rtol: float
    atol: float  # rad and rad/s


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Runs of one simulator with values of their own.

    t       (rows,), s: the times of the rows of every instance
    q, u    (instances, rows, nq) and (instances, rows, nu): coordinates and rates, of joints rad and rad/s, in the
            order of `Simulator.coordinates` and `rates`; NaN in rows that an instance did not reach
    status  (instances,): 0 where the end was reached, else the `Status` by which the instance ended early
    t_reached  (instances,), s
    stats   what it took
    """

    t: Array
    q: Array
    u: Array
    status: npt.NDArray[np.int32]
    t_reached: Array
    stats: EnsembleStats
    refusals: dict[int, str] = field(repr=False)
    _run: "Callable[[int], Result]" = field(repr=False)

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        failed = int((self.status != 0).sum())
        ended = "all reached the end" if not failed else f"{failed} ended early"
        return brief("Ensemble", f"{len(self)} instances", f"{len(self.t)} rows", ended)

    @property
    def success(self) -> npt.NDArray[np.bool_]:
        """(instances,): whether the end was reached."""
        reached: npt.NDArray[np.bool_] = self.status == int(Status.REACHED_END)
        return reached

    def result(self, instance: int) -> "Result":
        """The run of one instance by itself, with events, energies and all that a `Result` has: the same rows to the
        last bit where the compiler contracts nothing (`CompileOptions.fast` is off).

        Raises IndexError for an instance that is not there, RequestError for one whose start was refused."""
        number = range(len(self))[instance]
        if number in self.refusals:
            raise RequestError(f"instance {number} did not start: {self.refusals[number]}")
        return self._run(number)

    def message(self, instance: int) -> str:
        """How the run of one instance ended, in a line. An early end is run again for it."""
        number = range(len(self))[instance]
        status = Status(int(self.status[number]))
        if number in self.refusals:
            return f"it did not start: {self.refusals[number]}"
        if status in (Status.REACHED_END, Status.CANCELLED):
            how = "the end was reached" if status == Status.REACHED_END else "cancelled"
            return f"{how} at t = {self.t_reached[number]:.9g} s"
        return self._run(number).message


@dataclass(frozen=True, eq=False)
class Instances:
    """What differs from instance to instance.

    parameters  (instances, n), or (1, n) where all have the same; behind each the numbers of the drawing
    starts      likewise, (…, nq + nu)
    refusals    by instance: why its start or values are refused
    """

    count: int
    parameters: Array
    starts: Array
    refusals: dict[int, str]


def run_instances(
    module: CompiledModule,
    instances: Instances,
    request: Request,
    method: str,
    threads: int | None,
    following: Following = NOTHING,
    *,
    use_lanes: bool,
    why_alone: str,
) -> tuple[Array, npt.NDArray[np.int32], Array, EnsembleStats]:
    """Rows (instances, rows, nq + nu), statuses, times reached, and what it took."""
    assert request.t_eval is not None
    task = _Task(module, instances, request, method, following, use_lanes=use_lanes)
    workers = min(threads or _processors(), max(1, math.ceil(instances.count / task.width)))
    started = time.perf_counter()
    task.run(workers, request)
    wall_time = time.perf_counter() - started
    told = task.told
    lib = module.lib
    if task.width == 1 and use_lanes and not why_alone:
        why_alone = (
            f"the integrator {method!r} is implicit, or vectors hold one number, or two, too few for loops"
        )
    if task.width > 1 and (told[:, lib.LAMC_TOLD_SWITCHES] > 0).any():
        why_alone = "some instances went on by an implicit method, one after the other"
    return (
        task.y,
        task.status,
        task.t_reached,
        EnsembleStats(
            evaluations=told[:, lib.LAMC_TOLD_EVALUATIONS],
            accepted=told[:, lib.LAMC_TOLD_ACCEPTED],
            rejected=told[:, lib.LAMC_TOLD_REJECTED],
            events=told[:, lib.LAMC_TOLD_EVENTS],
            integrators=tuple(NAMES[k] for k in told[:, lib.LAMC_TOLD_METHOD].tolist()),
            lanes=task.width,
            why_alone=why_alone,
            threads=workers,
            wall_time=wall_time,
            rtol=request.rtol,
            atol=request.atol,
        ),
    )


class _Task:
    """A `lamc_ensemble` with the arrays that it reads and writes."""

    def __init__(
        self,
        module: CompiledModule,
        instances: Instances,
        request: Request,
        method: str,
        following: Following,
        *,
        use_lanes: bool,
    ) -> None:
        ffi, lib, self._module = module.ffi, module.lib, module
        count, rows = instances.count, request.t_eval
        assert rows is not None
        model = lib.lamc_this_model()
        size = int(model.coordinate_count + model.rate_count)
        self.y = _rows(count, len(rows), size)
        self.status = np.full(count, int(Status.CANCELLED), dtype=np.int32)
        self.t_reached = np.zeros(count)
        self.told: Integers = np.zeros((count, int(lib.LAMC_TOLD)), dtype=np.int64)
        self._next = np.zeros(1, dtype=np.int64)
        self._cancel = np.zeros(1, dtype=np.int32)
        refused = sorted(instances.refusals)
        starts = instances.starts
        if refused:  # NaN is no start: the instance ends where it begins
            starts = np.array(np.broadcast_to(starts, (count, size)))
            starts[refused] = math.nan
        self._refused = refused
        kept = (np.ascontiguousarray(instances.parameters), np.ascontiguousarray(starts), rows)
        self._kept = kept  # alive as long as C reads them

        def stride(array: Array) -> int:
            return 0 if len(array) == 1 else int(array.shape[1])

        def address(kind: str, array: Any) -> Any:
            return ffi.from_buffer(kind, array)

        max_step = request.max_step if math.isfinite(request.max_step) else 0.0
        task = self.handle = ffi.new("lamc_ensemble *")
        task.model, task.method = model, NUMBERS[method]
        if following.series:
            self._recorded = Recorded(ffi, following, following.breaks_of_run(request))
            task.recording = self._recorded.handle
        task.options = [request.rtol, request.atol, 0.0, max_step, request.max_steps]
        task.t_end, task.count, task.row_count = request.t_end, count, len(rows)
        task.t_eval = address("double[]", rows)
        task.parameters, task.parameter_stride = address("double[]", kept[0]), stride(kept[0])
        task.starts, task.start_stride = address("double[]", kept[1]), stride(kept[1])
        task.use_lanes = int(use_lanes)
        task.next, task.cancel = address("long long[]", self._next), address("int[]", self._cancel)
        task.y, task.status = address("double[]", self.y), address("int[]", self.status)
        task.t_reached, task.told = address("double[]", self.t_reached), address("long long[]", self.told)
        self.width = int(lib.lamc_ensemble_width(task))

    def run(self, workers: int, request: Request) -> None:
        """All instances; Ctrl-C ends those under way and leaves the rest."""
        from concurrent.futures import (
            ThreadPoolExecutor,
        )  # a tenth of what importing lamc takes, and rarely needed

        count = len(self.status)
        with ThreadPoolExecutor(workers, thread_name_prefix="lamc-ensemble") as pool:
            done = [pool.submit(self._work) for _ in range(workers)]
            try:
                self._watch(done, count, request)
            except KeyboardInterrupt:
                self._cancel[0] = 1
            except BaseException:
                self._cancel[0] = 1
                raise
        for each in done:
            each.result()
        self.status[self._refused] = int(Status.FAILED)

    def _watch(self, done: "list[Future[None]]", count: int, request: Request) -> None:
        from concurrent.futures import wait

        waiting = True
        while waiting:
            waiting = bool(wait(done, timeout=AWAKE).not_done)
            if request.progress is not None:
                request.progress(float(min(int(self._next[0]), count)), float(count))

    def _work(self) -> None:
        lib = self._module.lib
        work = np.empty(int(lib.lamc_ensemble_work_size(self.handle)))
        status = lib.lamc_ensemble_run(self.handle, self._module.ffi.from_buffer("double[]", work))
        assert status in (lib.LAMC_OK, lib.LAMC_CANCELLED)


def _rows(count: int, rows: int, size: int) -> Array:
    """Room for the rows, NaN. Raises RequestError where memory has none."""
    try:
        return np.full((count, rows, size), math.nan)
    except (MemoryError, ValueError) as error:
        gigabytes = count * rows * size * 8e-9
        raise RequestError(
            f"{count} instances of {rows} rows of {size} numbers are {gigabytes:.3g} GB, more than there is memory; "
            "take fewer times in t_eval, or the instances in parts"
        ) from error


def _processors() -> int:
    """Those that this process may use."""
    with suppress(AttributeError):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1

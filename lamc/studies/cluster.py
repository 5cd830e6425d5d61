"""Points worked on by a Dask cluster, on however many machines.

In: a pickled `Subject`, points, the address of a scheduler. Out: their rows as they come. Each machine compiles once,
into its own cache. Points of a worker that is gone are given to another. A point with which several have gone, and
again several when nothing else was handed over, is a row that says so. Every machine needs this version of lamc.
Never: imports Dask unless a scheduler is named.
"""

import pickle
import threading
import time
from collections.abc import Iterator
from importlib import import_module
from typing import Any

from lamc.basics._version import __version__
from lamc.basics.errors import LamcError, SimulationError
from lamc.basics.threads import one_thread
from lamc.studies.bench import DIED, Bench, Row, without_values
from lamc.studies.pool import Point, Source

_CHUNK = 1.0  # s of work that is handed over at once, against some ms for the handing over
_LARGEST = 1000  # points in a chunk
_WAIT = 60.0  # s for a first worker
_ANSWER = 10.0  # s for a scheduler to answer
_benches = threading.local()  # of a worker's thread: the subject it has worked on last


def clustered(subject: bytes, measures: int, source: Source, scheduler: str) -> Iterator[Row]:
    """Rows of all points of the source. Raises SimulationError where there is no cluster, and LamcError without
    distributed or with another lamc on a worker."""
    try:
        dask: Any = import_module("distributed")  # optional, and slow to load
    except ImportError as error:
        raise LamcError("a cluster needs distributed: pip install lamc[cluster]") from error
    with _client(dask.Client, scheduler) as client:
        slots, size = _slots(client), 1
        waiting: list[list[Point]] = []
        suspects: list[Point] = []
        running: dict[str, tuple[list[Point], bool]] = {}  # chunks, and whether nothing else was handed over
        done = dask.as_completed(loop=client.loop, raise_errors=False)

        def submit(chunk: list[Point], *, alone: bool) -> None:
            future = client.submit(worked, subject, chunk, pure=False)
            running[future.key] = chunk, alone
            done.add(future)

        def fill() -> None:
            while len(running) < 2 * slots and (chunk := waiting.pop() if waiting else source.take(size)):
                submit(chunk, alone=False)
            if suspects and not running:
                submit([suspects.pop()], alone=True)

        fill()
        for future in done:
            chunk, was_alone = running.pop(future.key)
            failure = None if future.status == "finished" else future.exception()
            if failure is None:
                rows, spent = future.result()
                size = max(1, min(_LARGEST, 2 * size, int(len(rows) * _CHUNK / max(spent, 1e-6))))
                yield from rows
            elif not isinstance(failure, dask.KilledWorker):
                raise failure
            elif len(chunk) > 1:
                waiting += [[point] for point in chunk]
            elif not was_alone:
                # Dask blames all that a worker had been given: which of them it was is seen by itself.
                suspects.append(chunk[0])
            else:
                reason = "the workers that it was given to died"
                yield without_values(chunk[0][0], DIED, reason, measures)
            fill()


def worked(subject: bytes, chunk: list[Point]) -> tuple[list[Row], float]:
    """Rows of a chunk, and the time that they took, s; on a worker."""
    began = time.monotonic()
    known: tuple[bytes, Bench] | None = getattr(_benches, "known", None)
    if known is None or known[0] != subject:
        # Made by `Study.pickled` and brought by Dask, which runs what a scheduler sends: no user's file is read here.
        known = (subject, Bench(pickle.loads(subject)))
        _benches.known = known
    with one_thread():
        rows = [known[1].row(index, point) for index, point in chunk]
    return rows, time.monotonic() - began


def _client(make: Any, scheduler: str) -> Any:
    try:
        return make(scheduler, timeout=_ANSWER, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise SimulationError(
            f"no scheduler answers at {scheduler!r}: {error}; start one with `dask scheduler`, and workers with "
            "`dask worker ADDRESS`"
        ) from error


def _slots(client: Any) -> int:
    """How many points can be worked on at once. Waits for a first worker; refuses one with another lamc."""
    try:
        client.wait_for_workers(1, timeout=_WAIT)
    except TimeoutError as error:
        way_out = "start one: `dask worker ADDRESS`"
        raise SimulationError(f"the cluster has had no worker for {_WAIT:g} s; {way_out}") from error
    for worker, version in client.run(_version, on_error="return").items():
        if version != __version__:
            raise LamcError(
                f"the worker {worker} has lamc {version}, and this is {__version__}: they must be the same"
            )
    return max(1, sum(int(threads) for threads in client.nthreads().values()))


def _version() -> str:
    return __version__

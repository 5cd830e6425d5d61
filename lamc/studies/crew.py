"""Other processes that answer for points, for searches whose next points follow from the last answers.

In: what works on points, pickled; points. Out: their rows, to whoever asked, however many threads ask. A process that
dies is started again; a point at which it died twice has a row that says so (`pool`). What a point gives depends on
nothing but the point, so that it does not matter who worked on it.
"""

import pickle
import queue
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from typing import Self

from lamc.basics.errors import SimulationError
from lamc.studies.bench import Row
from lamc.studies.pool import Point, Pool, Source


class _Asked(Source):
    """Points that come as they are asked for; who takes some waits for them."""

    def __init__(self, workers: int) -> None:
        super().__init__(iter(()))
        self._waiting: queue.SimpleQueue[Point | None] = queue.SimpleQueue()
        self._workers = workers

    def put(self, point: Point) -> None:
        self._waiting.put(point)

    def end(self) -> None:
        """Whoever waits goes home."""
        self.stopped = True
        for _ in range(self._workers):
            self._waiting.put(None)

    def take(self, count: int) -> list[Point]:
        """The next points, no more than leave some for the others; none when it is over."""
        first = self._waiting.get()
        if first is None or self.stopped:
            return []
        share = min(count, 1 + self._waiting.qsize() // self._workers)
        return [first, *self._at_once(share - 1)]

    def _at_once(self, count: int) -> Iterator[Point]:
        for _ in range(count):
            try:
                point = self._waiting.get_nowait()
            except queue.Empty:
                return
            if point is None:
                self._waiting.put(None)
                return
            yield point


class Crew:
    """Processes that answer until they are stopped."""

    def __init__(self, worked: bytes, values: int, workers: int) -> None:
        """worked: what `worker.serve` takes; values: how many a row has."""
        self.workers = workers
        self._source = _Asked(workers)
        self._pool = Pool(worked, values, self._source, workers)
        self._lock, self._count = threading.Lock(), 0
        self._open: dict[int, Future[Row]] = {}
        self._failure: Exception | None = None
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    @property
    def is_ready(self) -> bool:
        """Whether all processes have begun."""
        return self._pool.ready >= self.workers and self._failure is None

    def rows(self, points: Sequence[tuple[float, ...]]) -> list[Row]:
        """Of points, in their order. Raises what no point would fare better with, such as BuildError."""
        futures = [self._asked(point) for point in points]
        return [future.result() for future in futures]

    def stop(self) -> None:
        """Ends all processes, whatever they are at; whoever waits for rows is told."""
        self._fail(SimulationError("the search was stopped"))
        self._source.end()
        self._pool.stop()
        self._listener.join()

    def _asked(self, point: tuple[float, ...]) -> Future[Row]:
        future: Future[Row] = Future()
        with self._lock:
            number, self._count = self._count, self._count + 1
            if self._failure is not None:
                future.set_exception(self._failure)
                return future
            self._open[number] = future
        self._source.put((number, point))
        return future

    def _fail(self, error: Exception) -> None:
        with self._lock:
            self._failure = self._failure or error
            waiting, self._open = list(self._open.values()), {}
        for future in waiting:
            future.set_exception(error)

    def _listen(self) -> None:
        running = self.workers
        while running:
            row = self._pool.rows.get()
            if row is None:
                running -= 1
            elif isinstance(row, Exception):
                self._fail(row)
            else:
                with self._lock:
                    future = self._open.pop(row.index, None)
                if future is not None:
                    future.set_result(row)


class Hands:
    """A crew that is there once a search has taken a while, and gone after it."""

    def __init__(self, worked: object, values: int, workers: int, alone: float) -> None:
        """alone: s of work after which processes are started; until they have begun there is no crew. 0: they are
        waited for, and do all that can be done by them."""
        self._worked, self._values = worked, values
        self._workers, self._alone = workers, alone
        self._began = time.monotonic()
        self._crew: Crew | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._crew is not None:
            self._crew.stop()

    def crew(self) -> Crew | None:
        """None while there is none."""
        if self._workers < 2 or time.monotonic() - self._began < self._alone:
            return None
        if self._crew is None:
            self._crew = Crew(pickle.dumps(self._worked), self._values, self._workers)
        return self._crew if self._crew.is_ready or not self._alone else None

"""Points worked on by several processes of this machine.

In: a pickled `Subject`, points. Out: their rows as they come, in any order. A process that dies is started again, and
the point at which it died is tried once more; a second time it is a row that says so. The processes import what they
need by themselves: no state of this one is copied, and scripts need no guard.
"""

import os
import pickle
import queue
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from itertools import islice
from typing import Any

from lamc.basics.errors import SimulationError
from lamc.studies.bench import DIED, Row, without_values
from lamc.studies.worker import READY

Point = tuple[int, tuple[float, ...]]

_CHUNK = 0.2  # s of work that a process is given at once: what a kill loses, against a hundred µs for the handing over
_LARGEST = 1000  # points in a chunk
_COMMAND = "from lamc.studies.worker import serve; serve()"
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class Source:
    """Points to be worked on, taken by several threads."""

    def __init__(self, points: Iterator[Point]) -> None:
        self._points, self._lock = points, threading.Lock()
        self.stopped = False

    def take(self, count: int) -> list[Point]:
        """The next points, at most `count`; none when there are no more."""
        with self._lock:
            return [] if self.stopped else list(islice(self._points, count))


class Pool:
    """Processes that take points from a source. `rows` holds what they answer: rows, exceptions, and None from each
    when it has no more to do."""

    def __init__(self, subject: bytes, measures: int, source: Source, workers: int) -> None:
        self.rows: queue.Queue[Row | Exception | None] = queue.Queue()
        self.ready = 0  # processes that have begun
        self._subject, self._measures, self._source = subject, measures, source
        self._processes: set[subprocess.Popen[bytes]] = set()
        self._threads = [threading.Thread(target=self._work, daemon=True) for _ in range(workers)]
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """Ends all processes, whatever they are at."""
        self._source.stopped = True
        for process in list(self._processes):
            process.kill()
        for thread in self._threads:
            thread.join()

    def _work(self) -> None:
        process: subprocess.Popen[bytes] | None = None
        size = 1
        try:
            process = self._start()
            self.ready += 1
            while chunk := deque(self._source.take(size)):
                began, count = time.monotonic(), len(chunk)
                process = self._through(process, chunk)
                spent = time.monotonic() - began
                size = max(1, min(_LARGEST, 2 * size, int(count * _CHUNK / max(spent, 1e-6))))
        except Exception as error:  # told to whoever waits for rows
            self.rows.put(error)
        finally:
            if process is not None:
                self._end(process)
            self.rows.put(None)

    def _through(
        self, process: subprocess.Popen[bytes] | None, chunk: deque[Point]
    ) -> subprocess.Popen[bytes] | None:
        """Works through a chunk; the process that is there in the end. Raises what ends the study."""
        tries = 0
        while chunk and not self._source.stopped:
            if process is None:
                process = self._start()
            try:
                _send(process, list(chunk))
                while chunk:
                    row = _receive(process)
                    if not isinstance(row, Row):
                        raise row
                    self.rows.put(row)
                    chunk.popleft()
                    tries = 0
            except (EOFError, OSError, pickle.UnpicklingError):
                self._end(process)
                process = None
                tries += 1
                if tries == 2 and not self._source.stopped:
                    reason = "the process that worked on it died, twice"
                    self.rows.put(without_values(chunk.popleft()[0], DIED, reason, self._measures))
                    tries = 0
        return process

    def _start(self) -> subprocess.Popen[bytes]:
        """A process that is ready. Raises SimulationError if none can be had."""
        process = subprocess.Popen(
            [sys.executable, "-c", _COMMAND],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, **_ONE_THREAD},
        )
        self._processes.add(process)
        try:
            _send(process, sys.path)
            _send(process, self._subject)
            answer = _receive(process)
        except (EOFError, OSError, pickle.UnpicklingError) as error:
            self._end(process)
            answer = error
        if answer != READY:
            self._end(process)
            raise SimulationError(f"no process can be started to work on points: {answer}; take workers=1")
        return process

    def _end(self, process: subprocess.Popen[bytes]) -> None:
        self._processes.discard(process)
        process.kill()
        for stream in (process.stdin, process.stdout):
            assert stream is not None
            with suppress(OSError):  # of what was not yet sent to it
                stream.close()
        process.wait()


def _send(process: subprocess.Popen[bytes], what: object) -> None:
    assert process.stdin is not None
    pickle.dump(what, process.stdin)
    process.stdin.flush()


def _receive(process: subprocess.Popen[bytes]) -> Any:
    assert process.stdout is not None
    return pickle.load(
        process.stdout
    )  # from a process that this one started, on its own pipe: never a user's file

"""A study, ready to be worked on: a subject, a plan, and the way of its points to rows.

In: what is varied and measured, as users give it. Out: a `Study`, checked before anything runs, and its `Table`. What
is in the table does not depend on how many processes worked on it, nor on how often they were stopped.
"""

import os
import pickle
import time
import warnings
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from lamc.basics._version import __version__
from lamc.basics.checks import shown
from lamc.basics.errors import DesignWarning, LamcError, RequestError
from lamc.basics.numbers import duration
from lamc.basics.threads import one_thread
from lamc.studies.bench import Bench, Row, Subject
from lamc.studies.cluster import clustered
from lamc.studies.identity import digest_of
from lamc.studies.plans import Plan
from lamc.studies.pool import Point, Pool, Source
from lamc.studies.storage import opened, rows_of
from lamc.studies.table import Table, table_of
from lamc.studies.targets import (
    SLOW,
    made,
)

MANY = 1_000_000  # points that are worked on without asking
ALONE = 0.5  # s of work that is done before other processes are started
_PAYS = 4  # times as much must be left: to begin takes them a second, and of two each does half

Progress = Callable[[float, float], None]  # points done, points in all


@dataclass(frozen=True, eq=False)
class Study:
    """subject: what is run; plan: which points; name: of the design."""

    subject: Subject
    plan: Plan
    name: str

    def manifest(self) -> dict[str, Any]:
        """What tells one study from another, in JSON's own types."""
        subject = self.subject
        return {
            "lamc": __version__,
            "design": self.name,
            "drawing": digest_of((subject.design, dict(subject.design.parameters))),
            "drawing_by_dimensions": self._drawings(),
            "scene": digest_of(subject.scene),
            "plan": self.plan.data(),
            "measures": {
                name: [each.text, each.unit, "" if each.function is None else digest_of(each.function)]
                for name, each in subject.measures.items()
            },
            "run": asdict(replace(subject.run, parameters={})) | {"parameters": dict(subject.run.parameters)},
            "compiler": repr(subject.options),
        }

    def _drawings(self) -> str:
        """Digest of the design at the first and the last point: how it follows from dimensions is known to its recipe,
        which no digest reads."""
        found: list[object] = []
        for index in (0, self.plan.count - 1):
            point = zip(self.subject.targets, self.plan.point(index), strict=True)
            try:
                found.append(
                    made(self.subject.design, {t.name: v for t, v in point if t.kind == "dimension"})
                )
            except LamcError as error:
                found.append(error.message)
        return digest_of(found)

    def check_size(self, workers: int) -> None:
        """Raises RequestError for a plan of very many points, with the time that it would take by the first."""
        if self.plan.count <= MANY:
            return
        bench, points = Bench(self.subject), (0, min(self.plan.count, 1000) - 1)
        times = []
        for k in points:
            began = time.perf_counter()
            with quietly():
                bench.row(k, self.plan.point(k))
            times.append(time.perf_counter() - began)
        whole = duration(min(times) * self.plan.count / workers)
        raise RequestError(
            f"the plan has {self.plan.count} points, which take about {whole} in {workers} "
            f"process{'es' * (workers > 1)}; if that is meant, give --yes (yes=True)"
        )

    def run(
        self,
        folder: Path | None,
        workers: int,
        *,
        resume: bool = False,
        progress: Progress | None = None,
        scheduler: str | None = None,
        alone: float = ALONE,
    ) -> Table:
        """Works on all points that have no row yet. After Ctrl-C the table holds what is there.

        folder  where rows are kept as they come; None: in memory only
        scheduler  address of a Dask cluster's, which does the work in place of other processes here
        alone   s of work after which other processes are started, and until they have begun, this one works too; 0:
                this one does no work, and what ends a process cannot end it

        Raises RequestError for a folder of another study, and what no point can do without, such as BuildError.
        """
        here = partial(self._rows, workers=workers, alone=alone)
        way = here if scheduler is None else partial(self._rows_of_cluster, scheduler)
        work = partial(self._work, way, progress)
        if folder is None:
            rows: dict[int, Row] = {}
            work(rows, lambda row: rows.update({row.index: row}))
            return table_of(self.subject, self.plan, rows.values(), self.name)
        with opened(folder, self.manifest(), resume=resume) as store:
            work(store.done, store.add)
        return table_of(self.subject, self.plan, rows_of(folder), self.name)

    def _work(
        self,
        rows: Callable[[Iterator[Point], int], Iterator[Row]],
        progress: Progress | None,
        done: Collection[int],
        add: Callable[[Row], Any],
    ) -> None:
        slow = [target.name for target in self.subject.targets if target.kind in SLOW]
        left = ((k, self.plan.point(k)) for k in self.plan.order(slow) if k not in done)
        try:
            for row in rows(left, self.plan.count - len(done)):
                add(row)
                if progress is not None:
                    progress(len(done), self.plan.count)
        except KeyboardInterrupt:  # what is there is kept
            return

    def _rows(self, points: Iterator[Point], left: int, workers: int, alone: float) -> Iterator[Row]:
        """In this process until others have begun, if there is work for them, by the time that the first points took;
        in those from there on. left: how many points there are."""
        source = Source(points)
        pool: Pool | None = None
        try:
            with quietly():
                bench, began, done = Bench(self.subject), time.monotonic(), 0
                while pool is None or pool.ready < workers:
                    spent = time.monotonic() - began
                    if (
                        pool is None
                        and workers > 1
                        and spent >= alone
                        and (left - done) * spent >= _PAYS * alone * done
                    ):
                        pool = Pool(self.pickled(), len(self.subject.measures), source, workers)
                    if pool is not None and alone <= 0.0:
                        break
                    chunk = source.take(1)
                    if not chunk:
                        break
                    yield bench.row(*chunk[0])
                    done += 1
            running = workers if pool is not None else 0
            while running:
                assert pool is not None
                row = pool.rows.get()
                if isinstance(row, Exception):
                    raise row
                if row is None:
                    running -= 1
                else:
                    yield row
        finally:
            if pool is not None:
                pool.stop()

    def _rows_of_cluster(self, scheduler: str, points: Iterator[Point], _left: int) -> Iterator[Row]:
        return clustered(self.pickled(), len(self.subject.measures), Source(points), scheduler)

    def pickled(self) -> bytes:
        """The subject for another process. Raises RequestError if it cannot travel."""
        return pickled(self.subject)

    def workers(self, wanted: int | None) -> int:
        """How many processes: None: as many as processors, or one if the subject cannot travel. Raises RequestError."""
        if wanted is None:
            try:
                self.pickled()
            except RequestError:
                return 1
        elif wanted != 1:
            self.pickled()
        return workers_of(wanted)


def pickled(what: object) -> bytes:
    """For another process. Raises RequestError for what cannot travel."""
    try:
        found = pickle.dumps(what)
        if b"__main__" in found:  # which is another module there
            raise TypeError("functions or classes of it are of the program itself")
    except Exception as error:  # pickle fails in many ways, all meaning the same here
        raise RequestError(
            f"what is studied cannot be given to other processes ({type(error).__name__}: {error}); put functions "
            "into a module of their own, or take workers=1"
        ) from error
    return found


@contextmanager
def quietly() -> Iterator[None]:
    """Points are worked on with BLAS on one thread, as in other processes, and without the warnings that the first
    compile has told."""
    with one_thread(), warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        yield


def workers_of(workers: int | None) -> int:
    """How many processes: as many as there are processors for this one, if nobody says."""
    if workers is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if isinstance(workers, bool) or not isinstance(workers, int) or not 1 <= workers <= 1024:
        raise LamcError(f"workers is {shown(workers)}; it must be a whole number from 1 to 1024")
    return workers

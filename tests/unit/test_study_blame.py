"""Which point a cluster's workers died of, by a scheduler that blames all that a worker had been given."""

from types import SimpleNamespace
from typing import Any

import pytest

from lamc.studies import cluster
from lamc.studies.bench import Row
from lamc.studies.pool import Source


class KilledWorkerError(Exception):
    """As Dask's: this task was on a worker that died, several times."""


def scheduler(deadly: int) -> SimpleNamespace:
    """A stand-in for `distributed`: of what is under way at once, all is killed if the deadly point is among it."""

    class Future:
        def __init__(self, key: str, chunk: list[cluster.Point]) -> None:
            self.key, self.chunk, self.status = key, chunk, "finished"

        def exception(self) -> Exception:
            return KilledWorkerError(self.key)

        def result(self) -> tuple[list[Row], float]:
            return [Row(index, "ok", "", (0.0,)) for index, _ in self.chunk], 0.1

    class Completed:
        def __init__(self, **_named: Any) -> None:
            self.under_way: list[Future] = []

        def add(self, future: Future) -> None:
            self.under_way.append(future)

        def __iter__(self) -> "Completed":
            return self

        def __next__(self) -> Future:
            if not self.under_way:
                raise StopIteration
            if any(index == deadly for future in self.under_way for index, _ in future.chunk):
                for future in self.under_way:
                    future.status = "error"
            return self.under_way.pop(0)

    class Client:
        loop = None
        count = 0

        def __init__(self, *_given: Any, **_named: Any) -> None:
            pass

        def __enter__(self) -> "Client":
            return self

        def __exit__(self, *_error: object) -> None:
            pass

        def wait_for_workers(self, _count: int, timeout: float) -> None:
            pass

        def run(self, work: Any, on_error: str) -> dict[str, str]:
            return {"one": work()}

        def nthreads(self) -> dict[str, int]:
            return {"one": 1}

        def submit(self, _work: Any, _subject: bytes, chunk: list[cluster.Point], pure: bool) -> Future:
            self.count += 1
            return Future(str(self.count), chunk)

    return SimpleNamespace(Client=Client, as_completed=Completed, KilledWorker=KilledWorkerError)


@pytest.mark.parametrize("deadly", [0, 1, 4, 6, None])
def test_only_the_point_that_kills_workers_is_blamed(
    deadly: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = scheduler(-1 if deadly is None else deadly)
    monkeypatch.setattr(cluster, "import_module", lambda name: made)
    points = [(index, (float(index),)) for index in range(7)]
    rows = list(cluster.clustered(b"", 1, Source(iter(points)), "tcp://nowhere"))
    assert sorted(row.index for row in rows) == list(range(7))
    assert [row.index for row in rows if row.status == "died"] == ([] if deadly is None else [deadly])

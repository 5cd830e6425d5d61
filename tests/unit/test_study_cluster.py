"""A study on a Dask cluster: a real scheduler, workers in processes of their own, one killed half way."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from lamc.basics.errors import SimulationError
from lamc.studies import cluster as clusters
from tests.support import studied
from tests.support.paths import ROOT
from tests.unit.test_sweep import csv, study

pytest.importorskip("distributed")
pytestmark = pytest.mark.slow  # five processes that import Dask: 10 s

Process = subprocess.Popen[bytes]


def begun(module: str, *words: str) -> Process:
    log = subprocess.DEVNULL
    command = [sys.executable, "-m", f"distributed.cli.{module}", *words]
    few = {**os.environ, "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}  # each costs a worker's start
    return subprocess.Popen(command, cwd=ROOT, stdout=log, stderr=log, env=few, start_new_session=True)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, Callable[..., Process]]]:
    """Its address, and what begins a worker of one thread."""
    place = tmp_path / "scheduler.json"
    common = ("--scheduler-file", str(place), "--no-dashboard")
    processes = [begun("dask_scheduler", "--host", "127.0.0.1", "--port", "0", *common)]

    def worker(*words: str) -> Process:
        processes.append(begun("dask_worker", "--nthreads", "1", *words, *common))
        return processes[-1]

    try:
        _wait(place.exists)
        yield json.loads(place.read_text())["address"], worker
    finally:
        for process in processes:
            _kill(process)


def _kill(process: Process) -> None:
    """With what it has started: asked to end, a nanny whose scheduler has gone waits for it."""
    if hasattr(os, "killpg"):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()
    process.wait()


def _wait(ready, seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not ready():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_worker_that_is_killed_half_way_changes_nothing(cluster, tmp_path: Path) -> None:
    address, worker = cluster
    workers = [worker("--no-nanny") for _ in range(2)]
    whole = study({"length": "0.1:0.36316:20", "hip.stiffness": "1e-3:1e-1:100"})
    here = whole.run(None, 1)
    assert here.tally() == {"ok": 1900, "refused": 100}

    def halfway(done: float, total: float) -> None:
        if done >= total / 2 and workers[0].poll() is None:
            workers[0].kill()

    there = whole.run(tmp_path / "study", 1, scheduler=address, progress=halfway)
    assert workers[0].poll() is not None
    assert csv(there, tmp_path / "there.csv") == csv(here, tmp_path / "here.csv")


def test_a_point_that_kills_its_workers_is_a_row(cluster) -> None:
    """The worker is started again each time, by its nanny."""
    address, worker = cluster
    worker()
    table = study({"hip.stiffness": [1.0, 2.0, 3.0]}, {"end": studied.deadly}).run(None, 1, scheduler=address)
    assert [table.status(k) for k in range(3)] == ["ok", "died", "ok"]
    assert table.reasons == {1: "the workers that it was given to died"}


def test_an_address_at_which_nobody_is_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clusters, "_ANSWER", 1.0)
    with pytest.raises(SimulationError, match=r"no scheduler answers at 'tcp://127\.0\.0\.1:9'"):
        study({"hip.stiffness": [1.0]}).run(None, 1, scheduler="tcp://127.0.0.1:9")

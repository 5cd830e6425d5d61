"""BLAS has one thread while loops are counted, and as many as before afterwards."""

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController

import lamc
from lamc.basics.threads import on_one_thread
from tests.support.closed_mechanisms import closed_mechanism
from tests.support.ctools import needs_cc


def blas_threads() -> list[int]:
    return [each["num_threads"] for each in ThreadpoolController().select(user_api="blas").info()]


def test_blas_has_one_thread_within_and_as_many_as_before_afterwards() -> None:
    np.linalg.svd(np.eye(3))  # whose BLAS is there
    with ThreadpoolController().limit(limits=2, user_api="blas"):
        before = blas_threads()
        assert set(on_one_thread(blas_threads)()) == {1}
        assert blas_threads() == before


def test_an_error_within_gives_the_threads_back() -> None:
    @on_one_thread
    def fail() -> None:
        raise ValueError

    with ThreadpoolController().limit(limits=2, user_api="blas"):
        before = blas_threads()
        with contextlib.suppress(ValueError):
            fail()
        assert blas_threads() == before


def test_one_within_another_gives_no_threads_back_before_the_outer_ends() -> None:
    inner = on_one_thread(blas_threads)
    with ThreadpoolController().limit(limits=2, user_api="blas"):
        before = blas_threads()
        for counts in on_one_thread(lambda: (inner(), blas_threads()))():
            assert set(counts) == {1}
        assert blas_threads() == before


_LATE = """
import json
import sys
from threadpoolctl import ThreadpoolController
import numpy as np
from lamc.basics.threads import hold_scipy_too, on_one_thread

def count():
    return [each["num_threads"] for each in ThreadpoolController().select(user_api="blas").info()]

@on_one_thread
def loads_scipy():
    import scipy.linalg
    hold_scipy_too()
    return count()

assert "scipy.linalg" not in sys.modules
np.linalg.svd(np.eye(3))
print(json.dumps([loads_scipy(), count()]))
"""


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one processor has one thread")
def test_scipy_that_is_loaded_within_has_one_thread_until_the_end() -> None:
    """Sheets of hundreds of hinges load it while their loops are counted, and took ten times as long beside other
    work."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "2"}
    done = subprocess.run(
        [sys.executable, "-c", _LATE], capture_output=True, text=True, check=True, env=environment
    )
    within, after = json.loads(done.stdout)
    assert set(within) == {1}
    assert set(after) == {2}


@pytest.fixture(scope="module")
def linkage() -> lamc.Simulator:
    return lamc.compile(closed_mechanism("planar", 3).mechanism)


@pytest.mark.quick("notes", others="campaign")
@needs_cc
@pytest.mark.parametrize(
    "ask",
    [
        pytest.param(lambda simulator: simulator.run(0.05).notes, id="notes"),
        pytest.param(lambda simulator: simulator.equilibrium(), id="equilibrium"),
        pytest.param(lambda simulator: simulator.modes(simulator.equilibrium()), id="modes"),
    ],
)
def test_what_is_asked_of_a_simulator_is_decomposed_on_one_thread(
    ask: Callable[[lamc.Simulator], object], linkage: lamc.Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Threads that share them wait for one another beside other work, of sheets of hundreds of hinges for long."""
    met: list[int] = []

    def watched(name: str) -> None:
        plain = getattr(np.linalg, name)

        def decompose(*given: Any, **named: Any) -> Any:
            met.extend(blas_threads())
            return plain(*given, **named)

        monkeypatch.setattr(np.linalg, name, decompose)

    for name in ("svd", "eigh", "eig"):
        watched(name)
    with ThreadpoolController().limit(limits=2, user_api="blas"):
        ask(linkage)
    assert set(met) == {1}

"""The C runtime passes its own tests, plain and under sanitizers, and its sources are C++ as well.

`make test` of lamc runs them here, once, beside other tests."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.support.ctools import sanitizer_works
from tests.support.paths import RUNTIME
from tests.support.quick import LEVEL

COMPILER = os.environ.get("CC", "cc")

pytestmark = pytest.mark.skipif(
    shutil.which(COMPILER.split()[0]) is None or shutil.which("make") is None,
    reason="needs make and a C compiler (set CC)",
)


def make(target: str, out: Path, *settings: str) -> str:
    done = subprocess.run(
        ["make", "-C", str(RUNTIME), target, f"CC={COMPILER}", f"OUT={out}", *settings],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


QUICK = [f"OPT={LEVEL}", f"OPT_SANITIZED={LEVEL}"]


@pytest.mark.parametrize("target", ["test", "sanitize"])
@pytest.mark.quick("test")
def test_runtime_passes_its_own_tests(target: str, tmp_path: Path, pytestconfig: pytest.Config) -> None:
    settings = [] if pytestconfig.getoption("--as-shipped") else QUICK
    counts = re.findall(r"^(\d+) passed, (\d+) failed$", make(target, tmp_path, *settings), re.MULTILINE)
    assert len(counts) == len(list((RUNTIME / "tests").glob("test_*.c")))
    assert all(int(passed) > 0 and failed == "0" for passed, failed in counts)


def test_steps_of_fixed_length_compile_in_single_precision(tmp_path: Path) -> None:
    make("single", tmp_path)


@pytest.mark.slow
def test_threads_share_a_model_under_the_thread_sanitizer(tmp_path: Path) -> None:
    if not sanitizer_works(tmp_path, "-fsanitize=thread"):
        pytest.skip("this compiler, or this kernel, has no thread sanitizer")
    assert re.search(r"^\d+ passed, 0 failed$", make("tsan", tmp_path, *QUICK[1:]), re.MULTILINE)


@pytest.mark.skipif(shutil.which("c++") is None, reason="needs a C++ compiler")
@pytest.mark.slow
def test_runtime_compiles_as_cxx(tmp_path: Path) -> None:
    make("cxx", tmp_path)

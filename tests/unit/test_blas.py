"""CHOLMOD's BLAS is told by its symbols: what it loads counts; clocks and what else is in the process do not."""

import sys
import time
import types
from pathlib import Path

import numpy as np
import pytest

from lamc.plates.solving import solvers
from lamc.plates.solving.blas import tuned_blas
from tests.support.ctools import cc, needs_cc

pytestmark = [
    needs_cc,
    pytest.mark.skipif(
        sys.platform == "win32", reason="symbols of what a library loads are not looked up there"
    ),
]


def extension(folder: Path, symbol: str) -> str:
    """A library that loads another one, with `symbol`, as an extension module loads BLAS."""
    (folder / "blas.c").write_text(f"int {symbol}(void);\nint {symbol}(void) {{ return 1; }}\n")
    (folder / "own.c").write_text(
        f"int {symbol}(void);\nint own(void);\nint own(void) {{ return {symbol}(); }}\n"
    )
    cc(folder, "-shared", "-fPIC", "-o", "libblas-of-the-test.so", "blas.c")
    cc(folder, "-shared", "-fPIC", "-o", "own.so", "own.c", str(folder / "libblas-of-the-test.so"))
    return str(folder / "own.so")


@pytest.mark.parametrize(
    ("symbol", "name"),
    [
        ("openblas_get_config", "OpenBLAS"),
        ("scipy_openblas_get_config64_", "OpenBLAS"),
        ("MKL_Get_Version", "MKL"),
        ("bli_info_get_version_str", "BLIS"),
        ("dgemm_", None),
    ],
)
def test_the_blas_that_a_library_loads_is_reported(tmp_path: Path, symbol: str, name: str | None) -> None:
    assert (
        np.linalg.norm(np.eye(2) @ np.eye(2)) > 0.0
    )  # numpy's own OpenBLAS is in this process, and does not count
    assert tuned_blas([extension(tmp_path, symbol)]) == name


def test_what_cannot_be_opened_is_no_blas(tmp_path: Path) -> None:
    (tmp_path / "x.so").write_text("no library")
    assert tuned_blas([str(tmp_path / "x.so"), str(tmp_path / "none.so")]) is None


@pytest.mark.parametrize(("symbol", "fast"), [("openblas_get_config", True), ("dgemm_", False)])
def test_cholmod_is_chosen_by_its_blas_and_not_by_a_clock(
    tmp_path: Path, symbol: str, fast: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = types.ModuleType("sksparse.cholmod")
    module.__file__ = extension(tmp_path, symbol)
    monkeypatch.setitem(sys.modules, "sksparse", types.ModuleType("sksparse"))
    monkeypatch.setitem(sys.modules, "sksparse.cholmod", module)
    monkeypatch.setattr(time, "perf_counter", lambda: pytest.fail("a clock was read"))
    solvers.cholmod_is_fast.cache_clear()
    try:
        assert solvers.cholmod_is_fast() is fast
        assert solvers.checked_solver("auto") == ("cholmod" if fast else "superlu")
    finally:
        solvers.cholmod_is_fast.cache_clear()

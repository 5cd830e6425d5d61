"""Tables of studies as zarr folders."""

import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

from lamc.basics.errors import LamcError
from lamc.studies.bench import RunOptions
from lamc.studies.making import study_of
from lamc.studies.table import Table
from tests.support import studied
from tests.support.ctools import needs_cc

pytestmark = needs_cc

VARY = {"length": [0.2, 0.3, 0.4], "hip.stiffness": [1e-3, 1e-2]}
MEASURE = {"end": "last(hip)", "fast/slow": "max(hip.rate) / (1 rad/s)"}


def table() -> Table:
    return study_of(studied.rod, VARY, MEASURE, run=RunOptions(t_end=0.05, rows=11)).run(None, 1)


def contents(folder: Path) -> dict[str, bytes]:
    files = sorted(each for each in folder.rglob("*") if each.is_file())
    return {each.relative_to(folder).as_posix(): each.read_bytes() for each in files}


def test_a_zarr_folder_is_the_same_bytes_and_reads_back(tmp_path: Path) -> None:
    pytest.importorskip("zarr")
    xarray, made = pytest.importorskip("xarray"), table()
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # such as of types that other readers may not know
        first = contents(made.write_zarr(tmp_path / "table.zarr"))
        again = contents(made.write_zarr(tmp_path / "table.zarr"))  # in the place of the one that is there
        read = xarray.open_zarr(tmp_path / "table.zarr").load()
    assert first == again
    assert [each.name for each in tmp_path.iterdir()] == ["table.zarr"]
    whole = made.dataset()
    assert np.array_equal(read["end"], whole["end"], equal_nan=True)
    # A slash parts groups of zarr, where a measure of that name would vanish.
    assert np.array_equal(read["fast÷slow"], whole["fast/slow"], equal_nan=True)
    assert read["fast÷slow"].attrs == {"units": "1", "long_name": "fast/slow"}
    assert read["status"].values.tolist() == [["ok", "ok"], ["ok", "ok"], ["refused", "refused"]]
    assert "does not fit" in str(read["reason"].values[2, 0])
    assert read.attrs == whole.attrs


def test_without_zarr_it_is_told_before_anything_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from click.testing import CliRunner

    from lamc.cli import main

    pytest.importorskip("xarray")
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(LamcError, match="pip install zarr"):
        table().write_zarr(tmp_path / "table.zarr")
    words = [
        "sweep",
        "--example",
        "flaps",
        "--vary",
        "t_end=1:2:2",
        "--measure",
        "last(left)",
        "--to",
        "zarr",
    ]
    told = CliRunner().invoke(main, [*words, "--out", str(tmp_path / "out")])
    assert told.exit_code != 0
    assert "pip install zarr" in told.output
    assert not (tmp_path / "out").exists()

"""`lamc export`: the same folder as from Python, errors of one line, and nothing of the user's touched."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import lamc
from lamc.cli import main
from lamc.export import TARGETS
from tests.ctools import needs_cc
from tests.exported_folders import mechanism_of

pytestmark = needs_cc


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def call(*words: str) -> Result:
    return CliRunner().invoke(main, ["export", *words], catch_exceptions=False)


def content(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir()}


def test_it_writes_the_folder_that_python_writes_and_tells_what_is_in_it(tmp_path: Path) -> None:
    result = call("--example", "flaps", "--json")
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    assert data["folder"] == str(Path("out") / "flaps_c")
    written = content(tmp_path / "out" / "flaps_c")
    assert set(data["files"]) == set(written)
    assert {name: len(written[name]) for name in data["bytes"]} == data["bytes"]
    assert content(lamc.export(mechanism_of("flaps"), out=tmp_path / "python")) == written


def test_options_reach_the_export(tmp_path: Path) -> None:
    words = (
        "--inputs",
        "right",
        "--real-time",
        "--single-header",
        "--prefix",
        "wings",
        "--without",
        "gravity",
        "--angle",
        "left=20 deg",
    )
    result = call("--example", "flaps", "--out", "here", *words)
    assert result.exit_code == 0, result.stderr
    assert {p.name for p in (tmp_path / "here").iterdir()} == {
        *("wings.h", "wings.pc.in", "CMakeLists.txt", "example_main.c", "README.md", "mechanism.png"),
        "lamc-export.json",
    }
    header = (tmp_path / "here" / "wings.h").read_text(encoding="utf-8")
    assert "wings_step_fixed(" in header
    assert "wings_step(" not in header
    assert "gravity" not in header
    assert "double right_torque;" in header
    assert "left_torque" not in header
    assert "0.349066" in (tmp_path / "here" / "README.md").read_text(encoding="utf-8")  # 20 degrees


def test_it_replaces_its_own_files_only(tmp_path: Path) -> None:
    out = tmp_path / "c"
    assert call("--example", "flaps", "--out", "c").exit_code == 0
    (out / "notes.txt").write_text("mine")
    assert call("--example", "flaps", "--out", "c", "--integrator", "rk45").exit_code == 0
    assert (out / "notes.txt").read_text() == "mine"
    (out / "flaps.c").write_text("mine")
    refused = call("--example", "flaps", "--out", "c")
    assert refused.exit_code == 2
    assert "was edited since lamc wrote it" in refused.stderr
    assert (out / "flaps.c").read_text() == "mine"
    assert "holds c of 'flaps'" in call("--example", "shutter", "--out", "c").stderr
    assert call("--example", "flaps", "--out", "c", "--force").exit_code == 0
    assert (out / "flaps.c").read_text() != "mine"


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--example", "flaps", "--to", "nix"), "no target is named 'nix'"),
        (("--example", "flaps", "--prefix", "3d"), "the prefix is '3d'"),
        (("--example", "flaps", "--integrator", "euler"), "integrator is 'euler'"),
        (("--example", "flaps", "--integrator", "scipy:LSODA"), "integrator is 'scipy:LSODA'"),
        (("--example", "flaps", "--out", "file"), "is a file"),
        (("--example", "flaps", "--inputs", "left,nix"), "'nix'"),
        ((), "name a FILE"),
        (("none.yaml",), "there is no such file"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2_and_leaves_nothing(
    tmp_path: Path, words: tuple[str, ...], told: str
) -> None:
    (tmp_path / "file").write_text("mine")
    result = call(*words, "--quiet")
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert line.startswith("error: ")
    assert told in line
    assert content(tmp_path) == {"file": b"mine"}


def test_targets_are_listed() -> None:
    result = call("--to", "list")
    assert result.exit_code == 0
    assert [line.split()[0] for line in result.stdout.splitlines()] == list(TARGETS)


def test_equal_designs_give_equal_bytes_on_every_hash_seed(tmp_path: Path) -> None:
    """The picture and the digests among them."""
    for seed in ("1", "2"):
        done = subprocess.run(
            [sys.executable, "-m", "lamc", "export", "--example", "four_bar", "--out", seed, "--quiet"],
            env={**os.environ, "PYTHONHASHSEED": seed},
            check=False,
        )
        assert done.returncode == 0
    assert content(tmp_path / "1") == content(tmp_path / "2")

"""One cache, many processes, on a machine as users have it: Python writes bytecode, masks and homes differ.

An entry stays as it was built whoever loads it, and a cache that was warmed once serves all that come after.
"""

import errno
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

import lamc
from lamc.basics.errors import BuildError
from lamc.codegen.cache import Cache, intact
from tests.support.ctools import needs_cc
from tests.support.paths import ROOT
from tests.support.quick import QUICKLY
from tests.unit.test_cache import MECHANISM, SCENE, compiled, entries, no_debris

CHECKOUT = ROOT

# argv: how many loads. Prints the hits among them. It imports as little as a user's program does.
_LOADS = """
import sys, lamc
from lamc.basics.times import Times
from tests.support.mechanisms import chain
scene = lamc.Scene(effects=(lamc.Gravity((0.0, 0.0, -9.81)), lamc.HingeStiffness()))
hits = 0
for _ in range(int(sys.argv[1])):
    times = Times()
    lamc.compile(chain(2, "space", seed=31), scene, times=times)
    hits += times.from_cache
print(hits)
"""


def started(loads: int, beginning: str = "") -> subprocess.Popen[str]:
    """A process as a user starts it; `beginning` of its program."""
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    return subprocess.Popen(
        [sys.executable, "-c", beginning + _LOADS, str(loads)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        cwd=CHECKOUT,
    )


def hits_of(processes: list[subprocess.Popen[str]]) -> list[int]:
    answers = [process.communicate(timeout=300) for process in processes]
    assert [process.returncode for process in processes] == [0] * len(processes), answers
    return [int(out) for out, _ in answers]


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of this test's own, not there yet."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("LAMC_CACHE_DIR", str(folder))
    return folder


@pytest.mark.slow
@needs_cc
def test_fifty_loads_by_two_processes_all_hit(root: Path) -> None:
    assert not compiled()[1].from_cache
    files = sorted(path for path in root.rglob("*") if path.is_file())
    assert hits_of([started(25) for _ in range(2)]) == [25] * 2
    assert sorted(path for path in root.rglob("*") if path.is_file()) == files  # no bytecode, nothing else
    no_debris(root)


@needs_cc
@pytest.mark.campaign  # two of them in each run: test_processes_that_build_the_same_design_at_once_all_get_it
def test_three_processes_that_find_nothing_build_once_each_at_most(root: Path) -> None:
    assert min(hits_of([started(4, QUICKLY) for _ in range(3)])) >= 3
    assert len(entries(root)) == 1
    no_debris(root)


@needs_cc
def test_loading_writes_nothing_where_python_may(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    compiled()
    (folder,) = entries(root)
    assert compiled()[1].from_cache
    assert not (folder / "__pycache__").exists()
    assert intact(folder)


@needs_cc
@pytest.mark.parametrize("mask", [0o022, 0o077, 0o000])
@pytest.mark.quick("63")
def test_any_mask_makes_a_cache_of_the_users_own(root: Path, mask: int) -> None:
    earlier = os.umask(mask)
    try:
        compiled()
        assert compiled()[1].from_cache
    finally:
        os.umask(earlier)
    assert stat.S_IMODE(root.stat().st_mode) == 0o700
    (folder,) = entries(root)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.slow
@needs_cc
def test_a_home_that_cannot_be_written_is_reported_and_a_folder_elsewhere_helps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path / "home"
    home.write_text("")  # root may write to any folder, but makes none below a file
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.delenv("LAMC_CACHE_DIR")
    monkeypatch.setenv("HOME", str(home))
    with pytest.raises(BuildError, match=r"home/\.cache/lamc cannot be written: .*; set \$LAMC_CACHE_DIR"):
        compiled()
    monkeypatch.setenv("LAMC_CACHE_DIR", str(tmp_path / "elsewhere"))
    assert not compiled()[1].from_cache
    assert hits_of([started(2)]) == [2]


def test_without_any_home_the_cache_asks_for_a_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    def nobody(self: Path) -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "expanduser", nobody)
    with pytest.raises(BuildError, match=r"no home folder; set \$LAMC_CACHE_DIR"):
        lamc.codegen.cache.cache_root({})


def test_an_entry_that_another_process_moves_aside_is_put_in_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The place is taken when we rename, and free when we look."""
    rename, refusals = os.rename, [OSError(errno.ENOTEMPTY, "Directory not empty")]

    def taken_once(source: object, target: object) -> None:
        if refusals:
            raise refusals.pop()
        rename(str(source), str(target))

    tmp_path.chmod(0o700)
    monkeypatch.setattr(os, "rename", taken_once)
    place = Cache(tmp_path).put("0" * 64, lambda folder: (folder / "a").write_text("a") and None, {})
    assert intact(place)


@needs_cc
def test_an_alias_that_cannot_be_written_leaves_nothing(root: Path) -> None:
    lamc.compile(MECHANISM, SCENE)
    for alias in list(root.glob("*.note")):
        alias.unlink()
        alias.mkdir()
    compiled()
    assert [path.name for path in root.iterdir() if path.name.startswith(".")] == []

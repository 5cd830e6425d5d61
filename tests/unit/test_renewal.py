"""A folder holds one run or the other: whenever a run is killed, whatever else lies in the folder."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from click.testing import CliRunner

from lamc.basics import renewal
from lamc.basics.errors import LamcError
from lamc.basics.renewal import UNFINISHED, digests, renewed
from lamc.cli import main

posix_only = pytest.mark.skipif(os.name != "posix", reason="processes are forked and killed")
exchanges = pytest.mark.skipif(renewal._renameat2() is None, reason="folders cannot change places here")
OWN = {"a.txt", "b.txt", "film.gif", "last.json"}


def listed(folder: Path) -> set[str]:
    """What the manifest names; as commands have it."""
    try:
        return OWN & set(json.loads((folder / "last.json").read_text())["files"])
    except OSError:
        return set()


def write(folder: Path, run: str, names: tuple[str, ...] = ("a.txt", "b.txt")) -> None:
    with renewed(folder, "last.json", listed) as staged:
        for name in names:
            (staged / name).write_text(run)
        (staged / "last.json").write_text(json.dumps({"run": run, "files": [*names, "last.json"]}))


def content(folder: Path) -> dict[str, str]:
    return {str(p.relative_to(folder)): p.read_text() for p in folder.rglob("*") if p.is_file()}


def leftovers(folder: Path) -> list[str]:
    return [path.name for path in (*folder.parent.iterdir(), *folder.iterdir()) if ".lamc-" in path.name]


def first_run(tmp_path: Path) -> Path:
    folder = tmp_path / "out"
    folder.mkdir()
    write(folder, "old", ("a.txt", "b.txt", "film.gif"))
    return folder


def whole(folder: Path) -> str | None:
    """Which run the folder holds; None for a mixture."""
    found = content(folder)
    manifest = json.loads(found.pop("last.json", "{}"))
    files = {name: text for name, text in found.items() if name in OWN}
    expected = dict.fromkeys(manifest["files"][:-1], manifest["run"]) if manifest else None
    return manifest["run"] if files == expected else None


@pytest.mark.parametrize("moves", [False, True])
def test_a_run_takes_the_place_of_another_and_what_is_not_its_own_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moves: bool
) -> None:
    if moves:
        monkeypatch.setattr(renewal, "_renameat2", lambda: None)
    folder = first_run(tmp_path)
    (folder / "notes.txt").write_text("mine")
    write(folder, "new")
    assert content(folder) == {
        "a.txt": "new",
        "b.txt": "new",
        "last.json": content(folder)["last.json"],
        "notes.txt": "mine",
    }
    assert whole(folder) == "new"
    (folder / "sub").mkdir()
    (folder / "sub" / "c.txt").write_text("mine too")
    write(folder, "newer")
    assert whole(folder) == "newer"
    assert content(folder)["notes.txt"] == "mine"
    assert content(folder)["sub/c.txt"] == "mine too"
    assert leftovers(folder) == []


def test_a_run_that_fails_leaves_the_earlier_one(tmp_path: Path) -> None:
    folder = first_run(tmp_path)

    def fail() -> None:
        with renewed(folder, "last.json", listed) as staged:
            (staged / "a.txt").write_text("new")
            raise LamcError(f"'{staged / 'b.txt'}' cannot be written: the disk is full")

    with pytest.raises(LamcError, match="disk is full") as caught:
        fail()
    assert str(folder / "b.txt") in caught.value.message  # not the folder that nobody has heard of
    assert whole(folder) == "old"
    assert leftovers(folder) == []


def test_a_folder_at_a_files_place_is_told_before_anything_is_touched(tmp_path: Path) -> None:
    folder = first_run(tmp_path)
    (folder / "b.txt").unlink()
    (folder / "b.txt").mkdir()
    before = content(folder)
    with pytest.raises(LamcError, match=r"b.txt' is a folder, where a file has to be"):
        write(folder, "new")
    assert content(folder) == before


def test_the_working_folder_stays_the_working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = first_run(tmp_path)
    monkeypatch.chdir(folder)
    write(Path(), "new")
    assert whole(Path()) == whole(folder) == "new"
    assert Path.cwd().samefile(folder)


def test_a_link_to_a_folder_stays_a_link(tmp_path: Path) -> None:
    folder = first_run(tmp_path)
    (tmp_path / "link").symlink_to(folder)
    write(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert whole(folder) == "new"


def test_rights_that_somebody_gave_the_folder_stay(tmp_path: Path) -> None:
    folder = first_run(tmp_path)
    folder.chmod(0o750)
    write(folder, "new")
    assert folder.stat().st_mode & 0o777 == 0o750


def test_digests_are_those_of_sha256(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"abc")  # FIPS 180-2, appendix B.1
    assert digests(tmp_path, ["a"])["a"].startswith("ba7816bf8f01cfea414140de5dae2223b00361a396177a9c")


# --- killed -------------------------------------------------------------------------------------------------------


def killed(work: Callable[[], None], step: int) -> bool:
    """Runs `work` in a process that dies before the given one of the steps that change the disk; whether it died."""
    child = os.fork()
    if child:
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        assert status in (0, 9)
        return status == 9
    count = [0]

    def dying(function: Callable[..., object]) -> Callable[..., object]:
        def wrapped(*given: object, **named: object) -> object:
            if count[0] == step:
                os._exit(9)
            count[0] += 1
            return function(*given, **named)

        return wrapped

    try:
        for owner, name in ((Path, "replace"), (Path, "rename"), (Path, "unlink"), (os, "link")):
            setattr(owner, name, dying(getattr(owner, name)))
        for owner, name in ((renewal, "_exchanged"), (renewal.shutil, "rmtree")):
            setattr(owner, name, dying(getattr(owner, name)))
        work()
        os._exit(0)
    finally:
        os._exit(1)


@posix_only
@pytest.mark.parametrize("kind", ["exchange", "move", "move among folders"])
def test_a_run_that_is_killed_leaves_one_run_or_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    if kind == "move":
        monkeypatch.setattr(renewal, "_renameat2", lambda: None)
    elif kind == "exchange" and renewal._renameat2() is None:
        pytest.skip("folders cannot change places here")
    found = []
    for step in range(60):
        place = tmp_path / str(step)
        place.mkdir()
        folder = first_run(place)
        (folder / "notes.txt").write_text("mine")
        if kind == "move among folders":
            (folder / "sub").mkdir()
        died = killed(partial(write, folder, "new"), step)
        state = "told" if (folder / UNFINISHED).exists() else whole(folder)
        assert state is not None, f"a mixture without a word: {content(folder)}"
        assert kind != "exchange" or state in ("old", "new")
        found.append(state)
        write(folder, "newer")
        assert whole(folder) == "newer"
        assert content(folder)["notes.txt"] == "mine"
        assert not (folder / UNFINISHED).exists()
        assert leftovers(folder) == []
        if not died:
            break
    assert found[0] == "old"
    assert found[-1] == "new"
    assert len(found) > 3


@posix_only
def test_what_a_run_that_still_goes_on_writes_is_left_alone(tmp_path: Path) -> None:
    folder = first_run(tmp_path)
    with renewed(folder, "last.json", listed) as staged:
        write(folder, "new")
        assert staged.is_dir()
        (staged / "a.txt").write_text("newest")
        (staged / "last.json").write_text(json.dumps({"run": "newest", "files": ["a.txt", "last.json"]}))
    assert whole(folder) == "newest"


@pytest.mark.slow
@posix_only
@pytest.mark.usefixtures("unpainted")
def test_lamc_run_killed_while_it_writes_leaves_the_earlier_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = ["run", "--example", "flaps", "--out", "o", "--quiet", "--t-end"]
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(main, [*given, "0.05"]).exit_code == 0
    process = subprocess.Popen([sys.executable, "-m", "lamc", *given, "0.3"])
    while process.poll() is None and not list(tmp_path.glob(".o.lamc-*/results.csv")):
        time.sleep(0.002)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    manifest = json.loads((tmp_path / "o" / "manifest.json").read_text())
    assert manifest["t_reached"] == 0.05
    assert digests(tmp_path / "o", sorted(manifest["sha256"])) == manifest["sha256"]
    assert set(manifest["sha256"]) == set(manifest["files"]) - {"manifest.json"}
    assert CliRunner().invoke(main, [*given, "0.1"]).exit_code == 0
    assert json.loads((tmp_path / "o" / "manifest.json").read_text())["t_reached"] == 0.1
    assert os.listdir(tmp_path) == ["o"]

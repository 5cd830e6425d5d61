"""Files get the rights that the system gives any new file, and the process's mask is never touched."""

import os
import stat
import threading
from pathlib import Path

import pytest

from lamc.basics.files import fresh_file, fresh_folder, replacing, write_text
from lamc.export.folder import Origin, write_folder

posix_only = pytest.mark.skipif(os.name != "posix", reason="other systems have no such mask")


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.fixture
def no_mask(monkeypatch: pytest.MonkeyPatch) -> None:
    """os.umask is not there, as nothing may call it: other threads would make files with what it sets."""
    monkeypatch.delattr(os, "umask")


@posix_only
@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002])
def test_new_files_and_folders_have_the_rights_of_the_mask(tmp_path: Path, mask: int) -> None:
    before = os.umask(mask)
    try:
        write_text(tmp_path / "a.txt", "a")
        write_folder(tmp_path / "new", {"b/c.txt": b"c"}, Origin("d", "c"))
        write_folder(tmp_path / "new", {"b/c.txt": b"d"}, Origin("d", "c"))
        assert os.umask(mask) == mask
    finally:
        os.umask(before)
    assert mode(tmp_path / "a.txt") == 0o666 & ~mask
    assert mode(tmp_path / "new") == mode(tmp_path / "new" / "b") == 0o777 & ~mask
    assert mode(tmp_path / "new" / "b" / "c.txt") == 0o666 & ~mask


@pytest.mark.usefixtures("no_mask")
def test_threads_that_write_files_leave_the_mask_alone(tmp_path: Path) -> None:
    def work(k: int) -> None:
        for n in range(50):
            write_text(tmp_path / f"{k}_{n}.txt", "text")
        write_folder(tmp_path / f"folder {k}", {"a": b"a"}, Origin("d", "c"))

    threads = [threading.Thread(target=work, args=(k,)) for k in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    (tmp_path / "plain").touch()
    written = list(tmp_path.glob("*.txt"))
    assert len(written) == 8 * 50
    assert {mode(path) for path in written} == {mode(tmp_path / "plain")}
    assert len(list(tmp_path.glob("folder */a"))) == 8


def test_a_fresh_name_is_never_one_that_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = iter(["a", "a", "b", "b", "c"])
    monkeypatch.setattr("secrets.token_hex", lambda _: next(names))
    assert fresh_file(tmp_path, "x-").name == "x-a"
    assert fresh_file(tmp_path, "x-").name == "x-b"
    assert fresh_folder(tmp_path, "x-").name == "x-c"  # the file "x-b" is in the way
    monkeypatch.setattr("secrets.token_hex", lambda _: "a")
    with pytest.raises(FileExistsError, match="no name is free"):
        fresh_file(tmp_path, "x-")


def test_a_file_that_could_not_be_written_leaves_the_old_one_and_no_part(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_text(path, "old")

    def cut_short() -> None:
        with replacing(path) as temporary:
            temporary.write_text("ne")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        cut_short()
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]

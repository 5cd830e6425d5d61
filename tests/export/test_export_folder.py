"""Exported folders: whole or absent, and nobody else's file is touched."""

import errno
import json
import os
from collections.abc import Mapping
from pathlib import Path

import pytest

from lamc.basics.errors import ExportError
from lamc.export import folder as folder_module
from lamc.export.folder import MANIFEST, Origin, write_folder

ORIGIN = Origin("pend", "c")
FILES: Mapping[str, bytes] = {
    "pend.c": b"int a;\n",
    "pend.h": b"extern int a;\n",
    "cmake/pend.cmake": b"# x\n",
}


def content(folder: Path) -> dict[str, bytes]:
    """Every file below `folder`, links not followed."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def refused(
    folder: Path, files: Mapping[str, bytes] = FILES, origin: Origin = ORIGIN, **options: bool
) -> str:
    """The message of the refusal; nothing in the folder may have changed."""
    before = content(folder) if folder.is_dir() else None
    with pytest.raises(ExportError) as caught:
        write_folder(folder, files, origin, **options)
    assert (content(folder) if folder.is_dir() else None) == before
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 2
    return str(caught.value)


def test_a_new_folder_has_the_files_and_their_digests(tmp_path: Path) -> None:
    out = tmp_path / "a" / "b"
    assert write_folder(out, FILES, ORIGIN) == ("cmake/pend.cmake", "pend.c", "pend.h", MANIFEST)
    assert {p: c for p, c in content(out).items() if p != MANIFEST} == FILES
    assert [p.name for p in out.parent.iterdir()] == ["b"]  # nothing else stays behind
    manifest = json.loads((out / MANIFEST).read_bytes())
    # By `printf 'int a;\n' | sha256sum`.
    assert manifest["sha256"]["pend.c"] == [
        "386593f1475dc210d45a5f3d4b6bb11c065fc6fe2e08ebdd00ab4cf3a0848744"
    ]


def test_the_same_export_again_changes_no_byte_and_no_time(tmp_path: Path) -> None:
    """So that make and ninja build nothing anew."""
    write_folder(tmp_path / "out", FILES, ORIGIN)
    before = content(tmp_path / "out")
    os.utime(tmp_path / "out" / "pend.c", (1e9, 1e9))
    write_folder(tmp_path / "out", FILES, ORIGIN)
    assert content(tmp_path / "out") == before
    assert (tmp_path / "out" / "pend.c").stat().st_mtime == 1e9


def test_a_later_export_replaces_its_own_files_and_takes_away_stale_ones(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write_folder(out, FILES, ORIGIN)
    (out / "notes.txt").write_text("mine")
    write_folder(out, {"pend.c": b"int b;\n"}, ORIGIN)
    assert set(content(out)) == {"pend.c", "notes.txt", MANIFEST}
    assert (out / "pend.c").read_bytes() == b"int b;\n"
    assert not (out / "cmake").exists()


def test_stale_files_that_were_edited_stay(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write_folder(out, FILES, ORIGIN)
    (out / "pend.h").write_text("my own")
    write_folder(out, {"pend.c": b"int b;\n"}, ORIGIN)
    assert (out / "pend.h").read_text() == "my own"
    assert "was not written by lamc" in refused(out)  # it is the user's from now on


def test_an_empty_folder_and_one_without_files_in_the_way_are_used(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    write_folder(tmp_path / "empty", FILES, ORIGIN)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine")
    write_folder(tmp_path / "mine", FILES, ORIGIN)
    assert (tmp_path / "mine" / "notes.txt").read_text() == "mine"


def test_files_of_somebody_else_and_edited_files_are_refused_by_name(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "pend.c").write_text("my own")
    reported = refused(out)
    assert str(out / "pend.c") in reported
    assert "was not written by lamc" in reported
    assert "--force" in reported
    (out / "pend.c").unlink()
    write_folder(out, FILES, ORIGIN)
    with (out / "pend.c").open("ab") as file:
        file.write(b"/* my own line */\n")
    assert "was edited since lamc wrote it" in refused(out)
    write_folder(out, FILES, ORIGIN, force=True)
    assert (out / "pend.c").read_bytes() == FILES["pend.c"]


def test_another_export_does_not_go_into_the_same_folder(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write_folder(out, FILES, ORIGIN)
    assert "c of 'pend'" in refused(out, origin=Origin("arm", "c"))
    assert "c of 'pend'" in refused(out, origin=Origin("pend", "fmu"))
    write_folder(out, {"arm.c": b""}, Origin("arm", "c"), force=True)
    assert set(content(out)) == {"arm.c", MANIFEST}


@pytest.mark.parametrize("force", [False, True])
def test_files_and_links_where_folders_have_to_be_are_refused(tmp_path: Path, force: bool) -> None:
    (tmp_path / "file").write_text("x")
    assert "is a file" in refused(tmp_path / "file", force=force)
    (tmp_path / "nowhere").symlink_to(tmp_path / "missing")
    assert "link to nowhere" in refused(tmp_path / "nowhere", force=force)
    outside = tmp_path / "outside"
    outside.mkdir()
    out = tmp_path / "out"
    out.mkdir()
    (out / "cmake").symlink_to(outside)
    assert "is a link, where a folder has to be" in refused(out, force=force)
    (out / "cmake").unlink()
    (out / "cmake").write_text("x")
    assert "is a file, where a folder has to be" in refused(out, force=force)
    (out / "cmake").unlink()
    (out / "pend.c").mkdir()
    assert "is a folder, where a file has to be" in refused(out, force=force)
    assert list(outside.iterdir()) == []


def test_a_link_in_the_place_of_a_file_is_never_written_through(tmp_path: Path) -> None:
    """Not even where what it points to is, by content, lamc's own."""
    out, precious = tmp_path / "out", tmp_path / "precious"
    precious.write_bytes(FILES["pend.c"])
    write_folder(out, FILES, ORIGIN)
    (out / "pend.c").unlink()
    (out / "pend.c").symlink_to(precious)
    refused(out)
    write_folder(out, {**FILES, "pend.c": b"other\n"}, ORIGIN, force=True)
    assert precious.read_bytes() == FILES["pend.c"]
    assert not (out / "pend.c").is_symlink()


def test_a_manifest_that_names_files_outside_removes_nothing(tmp_path: Path) -> None:
    out, precious = tmp_path / "out", tmp_path / "precious"
    precious.write_bytes(FILES["pend.c"])
    write_folder(out, FILES, ORIGIN)
    manifest = json.loads((out / MANIFEST).read_bytes())
    digest = manifest["sha256"]["pend.c"]
    for path in ("../precious", str(precious)):
        (out / MANIFEST).write_text(json.dumps({**manifest, "sha256": {path: digest}}))
        assert "is no manifest of lamc's" in refused(out)
        write_folder(out, FILES, ORIGIN, force=True)
        assert precious.exists()
    (out / "pocket").symlink_to(tmp_path)
    (out / MANIFEST).write_text(
        json.dumps({**manifest, "sha256": {**manifest["sha256"], "pocket/precious": digest}})
    )
    write_folder(out, FILES, ORIGIN)
    assert precious.exists()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"sha256": {}}',
        '{"sha256": {"a": 1}, "design": "", "target": ""}',
        "[" * 100_000,
        "\0",
    ],
)
def test_a_manifest_that_is_none_is_refused(tmp_path: Path, text: str) -> None:
    write_folder(tmp_path / "out", FILES, ORIGIN)
    (tmp_path / "out" / MANIFEST).write_text(text)
    assert "is no manifest of lamc's" in refused(tmp_path / "out")
    write_folder(tmp_path / "out", FILES, ORIGIN, force=True)


def test_a_manifest_that_is_a_link_a_folder_or_huge_is_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Force replaces the link, not what it points to; a folder may hold what nobody wants to lose."""
    out, precious = tmp_path / "out", tmp_path / "precious"
    write_folder(out, FILES, ORIGIN)
    with monkeypatch.context() as patched:
        patched.setattr(folder_module, "_LARGEST_MANIFEST", 100)
        assert "is no manifest of lamc's" in refused(out)
    (out / MANIFEST).rename(precious)
    (out / MANIFEST).symlink_to(precious)
    before = precious.read_bytes()
    assert "is no manifest of lamc's" in refused(out)
    write_folder(out, {"pend.c": b"int b;\n"}, ORIGIN, force=True)
    assert precious.read_bytes() == before
    assert not (out / MANIFEST).is_symlink()
    (out / MANIFEST).unlink()
    (out / MANIFEST).mkdir()
    for force in (False, True):
        assert "is no manifest of lamc's" in refused(out, force=force)


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_read_only_folder_is_reported_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "ro").mkdir(mode=0o500)
    for out in (tmp_path / "ro", tmp_path / "ro" / "new"):
        assert "Permission denied" in refused(out)


def test_a_folder_that_may_not_be_written_is_reported_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same for the superuser, whom no mode bits stop."""

    def failing(*_: object) -> Path:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    (tmp_path / "ro").mkdir()
    monkeypatch.setattr(folder_module, "fresh_folder", failing)
    for out in (tmp_path / "ro", tmp_path / "new"):
        reported = refused(out)
        assert "Permission denied" in reported
        assert str(out) in reported
        assert "--out" in reported


@pytest.mark.parametrize("name", ["a\0b", "x" * 5000])
def test_paths_that_cannot_be_are_reported_in_one_line(tmp_path: Path, name: str) -> None:
    with pytest.raises(ExportError, match="cannot be written"):
        write_folder(tmp_path / name, FILES, ORIGIN)


@pytest.mark.parametrize("is_there", [False, True])
@pytest.mark.parametrize("after", range(4))
def test_a_full_disk_leaves_the_old_files_or_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, after: int, is_there: bool
) -> None:
    """Whichever write fails, the folder is the old one, and the next export goes through."""
    out = tmp_path / "out"
    if is_there:
        write_folder(out, dict.fromkeys(FILES, b"old\n"), ORIGIN)
    write = folder_module._write
    count = 0

    def failing(path: Path, data: bytes) -> None:
        nonlocal count
        count += 1
        if count > after:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        write(path, data)

    with monkeypatch.context() as patched:
        patched.setattr(folder_module, "_write", failing)
        with pytest.raises(ExportError, match="No space left"):
            write_folder(out, FILES, ORIGIN)
    if is_there:
        assert all(c == b"old\n" for p, c in content(out).items() if p != MANIFEST)
        assert {p.name for p in out.iterdir()} == {"pend.c", "pend.h", "cmake", MANIFEST}
    else:
        assert list(tmp_path.iterdir()) == []
    write_folder(out, FILES, ORIGIN)
    assert {p: c for p, c in content(out).items() if p != MANIFEST} == FILES


def test_an_export_cut_short_between_renames_can_be_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Old and new files stand side by side then, and the manifest knows both."""
    out = tmp_path / "out"
    write_folder(out, dict.fromkeys(FILES, b"old\n"), ORIGIN)
    replace = Path.replace

    def failing(self: Path, target: Path) -> Path:
        if target.name == "pend.h":
            raise KeyboardInterrupt
        return replace(self, target)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "replace", failing)
        with pytest.raises(KeyboardInterrupt):
            write_folder(out, FILES, ORIGIN)
    assert (out / "pend.c").read_bytes() != (out / "pend.h").read_bytes() == b"old\n"
    write_folder(out, FILES, ORIGIN)
    assert {p: c for p, c in content(out).items() if p != MANIFEST} == FILES

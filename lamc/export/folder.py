"""Puts exported files into a folder, whole or not at all, and never over what somebody else wrote.

In: files by relative path, and what they are an export of. Out: a folder with these files and a manifest,
`lamc-export.json`, that holds the digest of each. By it the next export knows which files are lamc's and untouched:
only those are replaced, or taken away where the new export has them no more. Never: writes through a link in the
folder, or removes a file whose content is not in the manifest.
"""

import hashlib
import json
import os
import shlex
import shutil
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from lamc.basics._version import __version__
from lamc.basics.errors import ExportError
from lamc.basics.files import fresh_folder

MANIFEST = "lamc-export.json"
_LARGEST_MANIFEST = 16_000_000  # bytes
_FORCE = "--force (in Python force=True)"
_ELSEWHERE = "name another folder with --out"


@dataclass(frozen=True)
class Origin:
    """What the files of a folder are: another design's, or of another target, do not go into the same folder."""

    design: str
    target: str

    def __str__(self) -> str:
        return f"{self.target} of {self.design!r}"


@dataclass(frozen=True)
class _Kept:
    """What the manifest in a folder says: relative path → the digests that the file may have."""

    origin: Origin | None
    digests: Mapping[str, frozenset[str]]


_NOTHING_KEPT = _Kept(None, {})


def quoted(folder: str, files: Mapping[str, bytes], ending: str) -> str:
    """The first of `files` with this ending, in the folder, for a shell."""
    return shlex.quote(f"{folder}/{next(path for path in files if path.endswith(ending))}")


def write_folder(
    folder: Path, files: Mapping[str, bytes], origin: Origin, *, force: bool = False
) -> tuple[str, ...]:
    """Writes `files` (relative POSIX path → content) and the manifest into `folder`; returns the paths, sorted.

    A folder that is not there, or is empty, appears in one rename. In one that is there each file is replaced in one
    rename, after all were checked and written beside it. force: replace also files that were edited or are not lamc's.

    Raises ExportError for anything in the way, before the first file is touched, and for what the system refuses.
    """
    assert all(_is_inside(path) for path in files)
    contents = dict(sorted(files.items()))
    try:
        if _is_there(folder):
            _renew(folder, contents, origin, force)
        else:
            _create(folder, contents, origin)
    except (OSError, ValueError) as error:  # a null character in the path is a ValueError
        reported = getattr(error, "strerror", None) or error
        raise ExportError(
            f"the folder {str(folder)!r} cannot be written: {reported}; {_ELSEWHERE}"
        ) from error
    return (*contents, MANIFEST)


def _is_inside(path: str) -> bool:
    """Whether it is a plain relative path that stays in its folder, and is not the manifest's."""
    pure = PurePosixPath(path)
    plain = bool(pure.parts) and str(pure) == path and not pure.is_absolute() and "\\" not in path
    return plain and ".." not in pure.parts and path != MANIFEST


def _is_there(folder: Path) -> bool:
    """Whether there is a folder. Raises ExportError for what is none."""
    if folder.is_symlink() and not folder.exists():
        raise ExportError(f"{str(folder)!r} is a link to nowhere; {_ELSEWHERE}")
    if folder.exists() and not folder.is_dir():
        raise ExportError(f"{str(folder)!r} is a file; {_ELSEWHERE}")
    return folder.is_dir()


# --- a folder that is not there -----------------------------------------------------------------------------------


def _create(folder: Path, contents: Mapping[str, bytes], origin: Origin) -> None:
    folder.parent.mkdir(parents=True, exist_ok=True)
    staged = fresh_folder(folder.parent, ".lamc-export-")
    try:
        _write_all(staged, contents)
        _write(staged / MANIFEST, _manifest(origin, {p: (_digest(c),) for p, c in contents.items()}))
        staged.replace(folder)
    finally:
        shutil.rmtree(staged, ignore_errors=True)


# --- a folder that is there ---------------------------------------------------------------------------------------


def _renew(folder: Path, contents: Mapping[str, bytes], origin: Origin, force: bool) -> None:
    kept = _kept(folder, force)
    if kept.origin not in (None, origin) and not force:
        raise ExportError(
            f"the folder {str(folder)!r} holds {kept.origin}; {_ELSEWHERE}, or replace it with {_FORCE}"
        )
    for path in contents:
        _check_place(folder, path, kept, force)
    digests = {path: _digest(content) for path, content in contents.items()}
    changed = {p: c for p, c in contents.items() if _digest_of(folder / p) != digests[p]}
    stale = [p for p in sorted(kept.digests) if p not in contents and _is_own(folder, p, kept)]
    staged = fresh_folder(folder, ".lamc-export-")
    try:
        _write_all(staged, changed)
        # An export that is cut short leaves old and new files side by side: until the end the manifest knows both.
        both = {p: (d, *sorted(kept.digests.get(p, frozenset()) - {d})) for p, d in digests.items()}
        both |= {p: tuple(sorted(kept.digests[p])) for p in stale}
        _replace(staged, folder, MANIFEST, _manifest(origin, both))
        for path in changed:
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (staged / path).replace(folder / path)
        for path in stale:
            _remove(folder, path)
        _replace(staged, folder, MANIFEST, _manifest(origin, {p: (d,) for p, d in digests.items()}))
    finally:
        shutil.rmtree(staged, ignore_errors=True)


def _check_place(folder: Path, path: str, kept: _Kept, force: bool) -> None:
    """Raises ExportError if `path` cannot be put into `folder` without harm."""
    for parent in reversed(PurePosixPath(path).parents[:-1]):
        place = folder / parent
        if place.is_symlink() or (place.exists() and not place.is_dir()):
            kind = "a link" if place.is_symlink() else "a file"
            raise ExportError(f"{str(place)!r} is {kind}, where a folder has to be; move it, or {_ELSEWHERE}")
    place = folder / path
    if place.is_dir() and not place.is_symlink():
        raise ExportError(f"{str(place)!r} is a folder, where a file has to be; move it, or {_ELSEWHERE}")
    if force or not (place.exists() or place.is_symlink()) or _is_own(folder, path, kept):
        return
    if path in kept.digests and not place.is_symlink():
        reported = "was edited since lamc wrote it"
    else:
        reported = "was not written by lamc"
    raise ExportError(f"{str(place)!r} {reported}; move it, {_ELSEWHERE}, or replace it with {_FORCE}")


def _is_own(folder: Path, path: str, kept: _Kept) -> bool:
    """Whether the file is as lamc wrote it, and lies in the folder itself, not behind a link."""
    if any((folder / parent).is_symlink() for parent in PurePosixPath(path).parents[:-1]):
        return False
    return _digest_of(folder / path) in kept.digests.get(path, frozenset())


def _remove(folder: Path, path: str) -> None:
    """Takes away a file of an earlier export, and folders that it leaves empty."""
    (folder / path).unlink()
    for parent in PurePosixPath(path).parents[:-1]:
        with suppress(OSError):  # not empty
            (folder / parent).rmdir()


# --- files and their digests --------------------------------------------------------------------------------------


def _write_all(folder: Path, contents: Mapping[str, bytes]) -> None:
    for path, content in contents.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        _write(folder / path, content)


def _write(path: Path, content: bytes) -> None:
    with path.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())  # else a crash of the system may leave the new name with no content


def _replace(staged: Path, folder: Path, name: str, content: bytes) -> None:
    _write(staged / name, content)
    (staged / name).replace(folder / name)


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _digest_of(path: Path) -> str | None:
    """Digest of a plain file; None for what is none, or is not there."""
    if path.is_symlink() or not path.is_file():
        return None
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _manifest(origin: Origin, digests: Mapping[str, tuple[str, ...]]) -> bytes:
    data = {
        "made_by": f"lamc {__version__}",
        "note": "Tells which files lamc wrote and nobody has edited; only those does it replace later.",
        "design": origin.design,
        "target": origin.target,
        "sha256": {path: list(found) for path, found in sorted(digests.items())},
    }
    return (json.dumps(data, indent=1) + "\n").encode()


def _kept(folder: Path, force: bool) -> _Kept:
    """What the manifest in the folder says. A folder without one holds nothing of lamc's.

    Raises ExportError for a manifest that is none, unless `force` is set.
    """
    place = folder / MANIFEST
    if not (place.exists() or place.is_symlink()):
        return _NOTHING_KEPT
    try:
        if place.is_symlink() or not place.is_file() or place.stat().st_size > _LARGEST_MANIFEST:
            raise ValueError("it is no plain file, or too large")
        return _read_manifest(json.loads(place.read_bytes()))
    except (ValueError, RecursionError) as error:
        if force and not place.is_dir():
            return _NOTHING_KEPT
        raise ExportError(
            f"{str(place)!r} is no manifest of lamc's; move it, {_ELSEWHERE}, or replace it with {_FORCE}"
        ) from error


def _read_manifest(data: Any) -> _Kept:
    """Raises ValueError for what lamc did not write: paths out of the folder among them."""
    if not isinstance(data, dict) or not isinstance(data.get("sha256"), dict):
        raise ValueError("no digests")
    origin = data.get("design"), data.get("target")
    if not all(isinstance(word, str) for word in origin):
        raise ValueError("no origin")
    digests = {}
    for path, found in data["sha256"].items():
        if not _is_inside(path):
            raise ValueError(f"{path!r} lies outside")
        if not isinstance(found, list) or not all(isinstance(each, str) for each in found):
            raise ValueError("a digest is no text")
        digests[path] = frozenset(found)
    return _Kept(Origin(str(origin[0]), str(origin[1])), digests)

"""Reading and writing whole files: bounded, atomic, with errors that say what to do."""

import difflib
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from lamc.basics.errors import DesignError, LamcError, Place, RequestError

_TRIES = 100  # names of 16 random digits that are all taken: the folder itself is at fault


def read_bytes(path: Path, limit: int) -> bytes:
    """All of a file of at most `limit` bytes.

    Raises DesignError where there is no such file, it is not a plain file, may not be read, or is larger.
    """
    place = Place(str(path))
    try:
        if path.is_dir():
            raise DesignError("this is a folder; name a file in it", place)
        if path.is_symlink() and not path.exists():
            raise DesignError(f"this is a link that leads to no file: {str(path.readlink())[:200]!r}", place)
        if not path.exists():
            raise DesignError(f"there is no such file{_nearest(path)}", place)
        if not path.is_file():
            raise DesignError("this is not a plain file", place)
        with path.open("rb") as stream:
            data = stream.read(limit + 1)
    except OSError as error:
        raise DesignError(f"the file cannot be read: {error.strerror or error}", place) from error
    except ValueError as error:  # a null character in the path
        raise DesignError(f"{str(path)!r} is not a usable path: {error}") from error
    if len(data) > limit:
        raise DesignError(f"the file is larger than the limit 'bytes' of {limit}", place)
    return data


def _nearest(path: Path) -> str:
    """The end of an error message: the name in the folder that may have been meant, or that there is no such folder."""
    if not path.parent.is_dir():
        return f", nor the folder {str(path.parent)!r}"
    near = difflib.get_close_matches(path.name, sorted(os.listdir(path.parent)), n=1, cutoff=0.6)
    return f"; did you mean {str(path.parent / near[0])!r}?" if near else ""


def checked_path(path: object) -> Path:
    """`path` as a Path, or RequestError."""
    if not isinstance(path, str | os.PathLike):
        raise RequestError(f"the path to write to is {path!r:.80}; it must be a text or a Path")
    return Path(os.fsdecode(path))


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path in the folder of `path`, which becomes `path` by one rename if the block succeeds: readers see
    the old file or the new one, never a part. Raises LamcError where the folder is missing or cannot be written."""
    temporary: Path | None = None
    try:
        temporary = fresh_file(path.parent, f".{path.name[:40]}.", ".part")
        yield temporary
        settle(temporary)
        temporary.replace(path)
    except OSError as error:
        raise LamcError(
            f"{str(path)!r} cannot be written: {error.strerror or error}; choose another place"
        ) from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Puts `text` into the file in one step, as `replacing` does."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


# What `tempfile` makes is for its owner's eyes only, and the mask that files are to have can be read only by setting
# it, for all threads at once. So files and folders are made as `open` and `mkdir` make them: the system applies it.


def fresh_file(folder: Path, prefix: str, suffix: str = "") -> Path:
    """An empty file that was not there, with the rights of any new file of this process. Raises OSError."""
    for _ in range(_TRIES):
        path = folder / f"{prefix}{secrets.token_hex(8)}{suffix}"
        with suppress(FileExistsError):
            os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            return path
    raise FileExistsError(f"no name is free for a new file in {str(folder)!r}")


def fresh_folder(parent: Path, prefix: str) -> Path:
    """An empty folder that was not there, with the rights of any new folder of this process. Raises OSError."""
    for _ in range(_TRIES):
        path = parent / f"{prefix}{secrets.token_hex(8)}"
        with suppress(FileExistsError):
            path.mkdir()
            return path
    raise FileExistsError(f"no name is free for a new folder in {str(parent)!r}")


def settle(path: Path) -> None:
    """Has the system write a file's content, else a crash of it may leave the file's name with no content."""
    with path.open("r+b") as written:  # Windows refuses this for files opened to be read only
        os.fsync(written.fileno())

"""Reading and writing whole files: bounded, atomic, with errors that say what to do."""

import difflib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lamc.errors import DesignError, LamcError, Place, RequestError


def read_bytes(path: Path, limit: int) -> bytes:
    """All of a file of at most `limit` bytes.

    Raises DesignError where there is no such file, it is not a plain file, may not be read, or is larger.
    """
    place = Place(str(path))
    try:
        if path.is_dir():
            raise DesignError("this is a folder; name a file in it", place)
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
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:40]}.", suffix=".part")
        os.close(handle)
        temporary = Path(name)
        yield temporary
        with temporary.open("rb") as written:
            os.fsync(written.fileno())  # else a crash of the system may leave the new name with no content
        temporary.chmod(0o666 & ~umask())  # mkstemp gives 0600
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


def umask() -> int:
    """The process's file mode mask; the system lets it be read only by setting it."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask

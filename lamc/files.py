"""Reading and writing whole files: bounded, atomic, with errors that say what to do."""

import os
import tempfile
from pathlib import Path

from lamc.errors import DesignError, LamcError, Place


def read_bytes(path: Path, limit: int) -> bytes:
    """All of a file of at most `limit` bytes.

    Raises DesignError where there is no such file, it is not a plain file, may not be read, or is larger.
    """
    place = Place(str(path))
    try:
        if path.is_dir():
            raise DesignError("this is a folder; name a file in it", place)
        if not path.exists():
            raise DesignError("there is no such file", place)
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


def write_text(path: Path, text: str) -> None:
    """Puts `text` into the file in one step: readers see the old file or the new one, never a part.

    Raises LamcError where the folder is missing or cannot be written.
    """
    temporary: str | None = None
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:80]}.", suffix=".part")
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except OSError as error:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
        raise LamcError(f"{path} cannot be written: {error.strerror or error}") from error


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask

"""A folder of results that holds one run or the other, never parts of both.

In: a folder, and a block that writes files into one beside it. Out: the folder with these files, in place of those of
the run before; whatever else lies there stays. Never: leaves a mixture without saying so.

On Linux the two folders change places in one step (renameat2). Where the system does not offer that, or something lies
in the folder that cannot be in two places (a folder of the user's), files move one by one: the file that vouches for
the others is taken away first and comes last, and `lamc-unfinished.json` says until then what is going on.
"""

import ctypes
import errno
import hashlib
import json
import os
import platform
import shutil
import sys
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from lamc.basics.errors import LamcError
from lamc.basics.files import fresh_folder, write_text

UNFINISHED = "lamc-unfinished.json"
_NOTE = "lamc was cut short while it replaced the files of an earlier run: these are of one run or the other"
_EXCHANGE, _HERE = 2, -100  # RENAME_EXCHANGE of linux/fs.h; AT_FDCWD of linux/fcntl.h
_CANNOT = (errno.ENOSYS, errno.EINVAL, errno.EXDEV, errno.EBUSY, errno.EPERM, errno.EACCES, errno.EOPNOTSUPP)
_FORGOTTEN = 86400.0  # s; a run whose process cannot be asked after has ended by then


@contextmanager
def renewed(folder: Path, last: str, older: Callable[[Path], set[str]]) -> Iterator[Path]:
    """A fresh folder to write into; when the block succeeds, its files take the places of the names `older(folder)` in
    `folder`, which must be there. last: the file that vouches for the others, such as a manifest.

    Raises LamcError where a folder lies at a file's place, and for what the system refuses.
    """
    reported = folder
    try:
        folder = folder.resolve()
        _clear(folder)
        staged = _beside(folder)
    except OSError as error:
        raise _refused(reported, error) from error
    try:
        yield staged
        _settle(staged, folder, last, older(folder))
    except LamcError as error:
        if str(staged) not in error.message:
            raise
        raise type(error)(error.message.replace(str(staged), str(reported)), error.place) from error
    except OSError as error:
        raise _refused(reported, error) from error
    finally:
        shutil.rmtree(staged, ignore_errors=True)


def digests(folder: Path, names: list[str]) -> dict[str, str]:
    """SHA-256 of files, in hexadecimal, by name."""
    found = {}
    for name in names:
        with (folder / name).open("rb") as stream:
            found[name] = hashlib.file_digest(stream, "sha256").hexdigest()
    return found


def _refused(folder: Path, error: OSError) -> LamcError:
    reported = error.strerror or error
    return LamcError(f"the folder {str(folder)!r} cannot be written to: {reported}; name another with --out")


def _settle(staged: Path, folder: Path, last: str, older: set[str]) -> None:
    """Puts what lies in `staged` into `folder`. Raises OSError and LamcError."""
    fresh = sorted(os.listdir(staged))
    for name in fresh:
        if (folder / name).is_dir() and not (folder / name).is_symlink():
            raise LamcError(
                f"{str(folder / name)!r} is a folder, where a file has to be; move it, or name another with --out"
            )
    gone = (older | _unfinished(folder) | {UNFINISHED}) - set(fresh)
    if (
        staged.parent == folder.parent
        and _keep(staged, folder, {*fresh, *gone})
        and _exchanged(staged, folder)
    ):
        for name in set(os.listdir(staged)) - set(fresh) - gone:
            with suppress(OSError):  # what came while the folders changed places; what is in both is no loss
                if not (folder / name).exists():
                    (staged / name).rename(folder / name)
        return
    _move(staged, folder, last, fresh, gone)


def _move(staged: Path, folder: Path, last: str, fresh: list[str], gone: set[str]) -> None:
    """One file after the other, told while it lasts."""
    note = {"note": _NOTE, "files": sorted({*fresh, *gone} - {UNFINISHED})}
    write_text(staged / UNFINISHED, json.dumps(note, indent=1) + "\n")
    (staged / UNFINISHED).replace(folder / UNFINISHED)
    (folder / last).unlink(missing_ok=True)
    for name in gone - {UNFINISHED, last}:
        (folder / name).unlink(missing_ok=True)
    for name in sorted(fresh, key=lambda name: name == last):
        (staged / name).replace(folder / name)
    (folder / UNFINISHED).unlink()


def _unfinished(folder: Path) -> set[str]:
    """Names of files that an exchange that was cut short left here."""
    try:
        reported = json.loads((folder / UNFINISHED).read_text(encoding="utf-8"))
        names = {str(name) for name in reported["files"]}
    except (OSError, ValueError, KeyError, TypeError):
        return set()
    return {name for name in names if name == Path(name).name and (folder / name).is_file()}


def _keep(staged: Path, folder: Path, ours: set[str]) -> bool:
    """Whether all that is not ours is in `staged` too now, as the same files."""
    here = Path.cwd()
    if here == folder or folder in here.parents:
        return False  # whoever stands in a folder would be left in the old one
    for entry in sorted(os.scandir(folder), key=lambda entry: entry.name):
        if entry.name in ours:
            continue
        if not entry.is_file(follow_symlinks=False):
            return False
        try:
            os.link(entry.path, staged / entry.name)
        except (OSError, NotImplementedError):
            return False
    shutil.copymode(folder, staged)  # the rights that somebody gave the folder
    return True


def _exchanged(one: Path, other: Path) -> bool:
    """Whether two folders have changed places. Raises OSError for what a move one by one would not survive either."""
    rename = _renameat2()
    if rename is None:
        return False
    if rename(_HERE, os.fsencode(one), _HERE, os.fsencode(other), _EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in _CANNOT:
        return False
    raise OSError(number, os.strerror(number), str(other))


def _renameat2() -> Any:
    """The system's function; None where there is none."""
    if not sys.platform.startswith("linux"):
        return None
    try:
        function = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):  # a C library from before 2018
        return None
    function.argtypes = [ctypes.c_int, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_uint]
    function.restype = ctypes.c_int
    return function


# --- the folder beside it -----------------------------------------------------------------------------------------


def _prefix(folder: Path) -> str:
    return f".{folder.name[:40]}.lamc-"


def _beside(folder: Path) -> Path:
    """A fresh folder beside `folder`, or in it where nothing else may be written."""
    name = f"{_prefix(folder)}{_machine()}-{os.getpid()}-"
    if folder.parent.stat().st_dev == folder.stat().st_dev and folder != folder.parent:
        with suppress(OSError):
            return fresh_folder(folder.parent, name)
    return fresh_folder(folder, name)


def _machine() -> str:
    return f"{zlib.crc32(platform.node().encode()):08x}"


def _clear(folder: Path) -> None:
    """Takes away what runs that were killed have left."""
    for place in (folder.parent, folder):
        for path in place.glob(f"{_escaped(_prefix(folder))}*"):
            machine, _, rest = path.name.removeprefix(_prefix(folder)).partition("-")
            if path.is_dir() and not path.is_symlink() and _is_over(path, machine, rest.partition("-")[0]):
                shutil.rmtree(path, ignore_errors=True)


def _escaped(text: str) -> str:
    return "".join(f"[{sign}]" if sign in "*?[" else sign for sign in text)


def _is_over(path: Path, machine: str, process: str) -> bool:
    """Whether the run that made the folder has ended."""
    if machine == _machine() and process.isdecimal() and os.name == "posix":
        try:
            os.kill(int(process), 0)  # asks only
        except ProcessLookupError:
            return True
        except (OSError, OverflowError):
            return False
        return False
    with suppress(OSError):
        return time.time() - path.stat().st_mtime > _FORGOTTEN
    return False

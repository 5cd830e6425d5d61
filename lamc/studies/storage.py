"""The folder of a study: what it is of, and a line for each point that is done.

In: a manifest in JSON's own types, rows. Out: the same, read back. A row is handed to the system as soon as it is
there, and to the disk every second: what kills the process loses the points in flight only, and what stops the machine
a second of them. A last line that was cut short is dropped. Never: mixes rows of two studies.
"""

import json
import math
import os
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

from lamc.basics.errors import LamcError, RequestError
from lamc.basics.files import write_text
from lamc.studies.bench import DIED, STATUSES, Row

MANIFEST, ROWS = "study.json", "rows.jsonl"
_SETTLED_EVERY = 1.0  # s


@dataclass
class Store:
    """An open study folder. done: numbers of the points that have a row."""

    folder: Path
    done: set[int]
    _stream: IO[bytes]
    _settled: float = 0.0

    def add(self, row: Row) -> None:
        """Keeps a row. Raises LamcError where the disk is full or gone."""
        line = json.dumps(
            [row.index, row.status, row.reason, [_plain(v) for v in row.values], row.structure],
            ensure_ascii=True,
        )
        try:
            self._stream.write(line.encode("ascii") + b"\n")
            self._stream.flush()
            if time.monotonic() - self._settled > _SETTLED_EVERY:
                self._settle()
        except OSError as error:
            raise LamcError(f"{str(self.folder)!r} cannot be written: {error.strerror or error}") from error
        self.done.add(row.index)

    def _settle(self) -> None:
        os.fsync(self._stream.fileno())
        self._settled = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stream.flush()
        self._settle()
        self._stream.close()


def opened(folder: Path, manifest: Mapping[str, Any], *, resume: bool) -> Store:
    """The study folder, fresh or as far as it is done.

    Raises RequestError for a folder with a study in it unless `resume`, and for one of another study, with what
    differs; LamcError for what cannot be written.
    """
    place = folder / MANIFEST
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if place.exists():
            if not resume:
                raise RequestError(
                    f"{str(folder)!r} holds a study already; go on with it by --resume (resume=…), or name another"
                )
            _check_same(folder, _read_manifest(place), _jsonable(manifest))
        else:
            (folder / ROWS).unlink(missing_ok=True)
            write_text(place, json.dumps(_jsonable(manifest), indent=1, ensure_ascii=False) + "\n")
        stream = (folder / ROWS).open("ab")
        if not _held(stream):
            stream.close()
            raise RequestError(
                f"another process works on the study in {str(folder)!r}; wait for its end, or stop it"
            )
        return Store(folder, _mended(folder / ROWS), stream)
    except OSError as error:
        raise LamcError(f"the folder {str(folder)!r} cannot be used: {error.strerror or error}") from error


def _held(stream: IO[bytes]) -> bool:
    """Whether the file is this process's alone until it is closed; the system lets go of it whatever ends the process.
    True where the system has no such locks."""
    try:
        fcntl: Any = import_module("fcntl")
    except ImportError:
        return True
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def rows_of(folder: Path) -> Iterator[Row]:
    """All rows of a study folder, in the order in which they came."""
    try:
        with (folder / ROWS).open("rb") as stream:
            for line in stream:
                row = _row(line)
                if row is not None:
                    yield row
    except FileNotFoundError:
        return


def _mended(path: Path) -> set[int]:
    """Numbers of the rows that are whole; cuts off what follows the last of them."""
    if not path.exists():
        return set()
    done: set[int] = set()
    end = 0
    with path.open("rb") as stream:
        for line in stream:
            row = _row(line)
            if row is None:
                break
            (done.discard if row.status == DIED else done.add)(row.index)  # it is tried again
            end += len(line)
    if end != path.stat().st_size:
        os.truncate(path, end)
    return done


def _row(line: bytes) -> Row | None:
    """The row of a line; None if it is not whole."""
    if not line.endswith(b"\n"):
        return None
    try:
        index, status, reason, values, *more = json.loads(line)
        numbers = tuple(float(each) for each in values)
    except (ValueError, TypeError):
        return None
    is_whole = isinstance(index, int) and status in STATUSES and isinstance(reason, str)
    structure = more[0] if more and isinstance(more[0], str) else ""
    return Row(index, status, reason, numbers, structure) if is_whole else None


def _plain(value: float) -> float | str:
    return value if math.isfinite(value) else str(value)


def _jsonable(manifest: Mapping[str, Any]) -> dict[str, Any]:
    """As it will be read back."""
    whole: dict[str, Any] = json.loads(json.dumps(manifest))
    return whole


def _read_manifest(place: Path) -> dict[str, Any]:
    try:
        found = json.loads(place.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise RequestError(
            f"{str(place)!r} is no manifest of a study: {error}; name another folder"
        ) from error
    return found if isinstance(found, dict) else {}


def _check_same(folder: Path, there: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Raises RequestError with what differs."""
    differing = [name for name in wanted if there.get(name) != wanted[name]]
    if "plan" in differing or "drawing" in differing:  # from which this follows
        differing = [name for name in differing if name != "drawing_by_dimensions"]
    if differing:
        words = ", ".join(name.replace("_", " ") for name in differing)
        details = "; ".join(_difference(name, there, wanted) for name in differing)
        raise RequestError(
            f"{str(folder)!r} holds a study of another {words} ({details}); give the same again, or name another folder"
        )


def _difference(name: str, there: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    texts = [json.dumps(each.get(name), ensure_ascii=False) for each in (there, wanted)]
    short = [text if len(text) <= 60 else f"{text[:60]}…" for text in texts]
    return f"{name.replace('_', ' ')}: {short[0]} there, {short[1]} asked for"

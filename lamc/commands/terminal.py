"""How a command speaks: text for people, JSON for programs, progress, and errors of one line.

In: what a command has to say. Out: on stdout the result (text, or nothing but JSON), on stderr progress and errors. It
imports nothing heavy: rich only where there is a terminal to draw on.
"""

import json
import math
import os
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Protocol, Self

import click

from lamc.basics.errors import DesignErrors, DesignWarning, LamcError

INTERRUPTED = 130  # 128 + SIGINT, as shells have it
_PLAIN_EVERY = 2.0  # s between two plain lines about the same work
_SILENT = 10.0  # s without a line after which one says that the work goes on
_LEAST = 0.1  # s between two looks at that


def open_streams() -> None:
    """Puts the null device where a stream is not there: daemons and pythonw have none, shells close them by `2>&-`.

    Python has None then, which nothing can be printed to; and the next file that is opened gets the stream's number, so
    that what a compiler or a library prints there would end up in the results.
    """
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, os.O_RDWR)
            os.dup2(opened, number)  # inheritable, as compilers expect
            if opened != number:
                os.close(opened)
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        stream = getattr(sys, name)
        if stream is None or stream.closed:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115  (as long as the process)


def tell(text: str) -> None:
    """A line on stderr. Where nobody reads that any more, the work goes on: what it is about is in the results."""
    try:
        click.echo(printable(text), err=True)
    except OSError:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  (else Python complains as it ends)


def print_out(text: str) -> None:
    """A line or a document on stdout. Raises LamcError where it cannot be written, as on a full disk."""
    try:
        click.echo(text)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise unprinted(error) from error


def unprinted(error: OSError) -> LamcError:
    """What to tell of a failure to write on stdout; nothing more goes there, as what is left would fail once more."""
    sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  (as long as the process)
    return LamcError(f"standard output cannot be written: {error.strerror or error}; send it elsewhere")


class Progress(Protocol):
    """Told what is being done, and how far it is."""

    def stage(self, name: str) -> None: ...
    def part(self, done: float, total: float) -> None: ...


class Silent:
    """No progress at all."""

    def stage(self, name: str) -> None:
        """Says nothing."""

    def part(self, done: float, total: float) -> None:
        """Says nothing."""


class PlainProgress:
    """A line per stage, and one every few seconds within a long stage: how much of it is done or, where that is not
    known, how long it has taken."""

    def __init__(self) -> None:
        self._name = ""
        self._reported = self._begun = time.monotonic()
        self._ended = threading.Event()
        self._watch = threading.Thread(target=self._tell_of_silence, daemon=True)

    def __enter__(self) -> Self:
        self._watch.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()
        self._watch.join()

    def _tell_of_silence(self) -> None:
        while not self._ended.wait(max(_LEAST, self._reported + _SILENT - time.monotonic())):
            now = time.monotonic()
            if self._name and now - self._reported >= _SILENT:
                self._reported = now
                tell(f"{self._name} … {now - self._begun:.0f} s")

    def stage(self, name: str) -> None:
        if name != self._name:
            self._name, self._reported = name, time.monotonic()
            self._begun = self._reported
            tell(f"{name} …")

    def part(self, done: float, total: float) -> None:
        now = time.monotonic()
        if now - self._reported >= _PLAIN_EVERY and total > 0.0:
            self._reported = now
            left = (now - self._begun) * (total - done) / done if done > 0.0 else 0.0
            tell(
                f"{self._name} … {100 * done / total:.0f} %" + (f", {left:.0f} s left" if left >= 1.0 else "")
            )


class BarProgress:
    """One bar, drawn by rich, that vanishes when the work is done."""

    def __init__(self) -> None:
        from rich.console import Console  # heavy, and of use on a terminal only
        from rich.progress import (
            BarColumn,
            TaskProgressColumn,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )
        from rich.progress import Progress as RichProgress

        columns = (
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=30),
            TaskProgressColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
        )
        self._bar = RichProgress(*columns, console=Console(stderr=True), transient=True)
        self._task = self._bar.add_task("starting", total=None)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()

    def stage(self, name: str) -> None:
        self._bar.reset(self._task, description=name, total=None)

    def part(self, done: float, total: float) -> None:
        self._bar.update(self._task, completed=done, total=total)


@dataclass(frozen=True)
class Terminal:
    """Where a command's words go.

    as_json  stdout carries one JSON document and nothing else
    quiet    neither text nor progress; errors only
    debug    errors come with their traceback
    """

    as_json: bool = False
    quiet: bool = False
    debug: bool = False

    def say(self, text: str) -> None:
        """The result for people."""
        if not self.as_json and not self.quiet:
            print_out(printable(text))

    def error(self, text: str) -> None:
        """A failure that comes with a result, on stderr; other failures are raised."""
        tell(f"error: {text}")

    def warn(self, text: str) -> None:
        """A word on stderr about how the command was called."""
        if not self.quiet:
            tell(f"warning: {text}")

    def result(self, data: Mapping[str, Any]) -> None:
        """The result for programs: numbers that are not finite become null."""
        if self.as_json:
            print_out(json.dumps(plain(data), indent=2, ensure_ascii=True, allow_nan=False))

    @contextmanager
    def progress(self) -> Iterator[Progress]:
        """A bar on a terminal, plain lines elsewhere, nothing if quiet."""
        if self.quiet:
            yield Silent()
        elif sys.stderr.isatty():
            with BarProgress() as bar:
                yield bar
        else:
            with PlainProgress() as lines:
                yield lines

    def guard(self, work: Callable[[], int]) -> int:
        """The exit code of `work`; every exception becomes one line per problem on stderr and an exit code, and every
        warning of lamc's a line."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore" if self.quiet else "default", DesignWarning)
                warnings.showwarning = _shown_by(warnings.showwarning)
                return work()
        except KeyboardInterrupt:
            self._complain(["interrupted; nothing more was written"], [], INTERRUPTED)
            return INTERRUPTED
        except LamcError as error:
            problems = error.problems if isinstance(error, DesignErrors) else (error,)
            self._complain([str(p) for p in problems], problems, error.exit_code)
            return error.exit_code
        except BrokenPipeError:
            # The reader went away (`lamc schema | head`); without this, Python complains once more as it ends.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        except (Exception, RecursionError) as error:
            if self.debug:
                traceback.print_exc()
            reported = " ".join(f"{type(error).__name__}: {error}".split())
            line = f"this is a bug of lamc: {reported[:300]}; please report it with the output of --debug"
            self._complain([line], [], 1, traced=True)
            return 1

    def _complain(
        self,
        lines: list[str],
        problems: tuple[LamcError, ...] | list[LamcError],
        code: int,
        *,
        traced: bool = False,
    ) -> None:
        if self.debug and not traced:
            traceback.print_exc()
        for line in lines:
            tell(f"error: {line}")
        if self.as_json:
            reported = [problem_data(p) for p in problems] or [{"message": line} for line in lines]
            with suppress(LamcError):  # stderr has it
                print_out(json.dumps({"ok": False, "exit_code": code, "errors": reported}, indent=2))


def _shown_by(others: Callable[..., None]) -> Callable[..., None]:
    """How warnings are shown: lamc's own as a line on stderr, `others` as ever."""

    def show(message: Warning | str, category: type[Warning], *where: Any) -> None:
        if issubclass(category, DesignWarning):
            tell(f"warning: {message}")
        else:
            others(message, category, *where)

    return show


def problem_data(error: LamcError) -> dict[str, Any]:
    """An error for programs: its kind, its message and its place."""
    place = error.place
    return {
        "kind": type(error).__name__,
        "message": error.message,
        "file": place.file if place else None,
        "line": (place.line or None) if place else None,
        "column": (place.column or None) if place else None,
    }


def printable(text: str) -> str:
    """`text` without characters that could steer a terminal; line ends stay."""
    return "".join(ch if ch.isprintable() or ch == "\n" else repr(ch)[1:-1] for ch in text)


def plain(value: Any) -> Any:
    """`value` in JSON's own types; a number that is not finite becomes null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value

"""Every error that lamc raises for something outside itself. `assert` is for lamc's own bugs.

One exception root, specific leaves. A message is one line and names the offender, the value, the rule and the
way out; `place` says where in which file. The CLI turns `exit_code` into the process's exit code.
"""

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass


@dataclass(frozen=True, order=True)
class Place:
    """A place in an input file; line and column count from 1, and 0 stands for "not known"."""

    file: str = ""
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        parts = [self.file or "<input>"]
        if self.line:
            parts.append(str(self.line))
            if self.column:
                parts.append(str(self.column))
        return ":".join(parts)


class LamcError(Exception):
    """Root of all errors raised on purpose.

    subject  the record that the error is about, where one is known: who read it from a file knows its place there
    part     of the record, by keys
    """

    exit_code = 2

    def __init__(self, message: str, place: Place | None = None) -> None:
        self.message = " ".join(message.split())
        self.place = place
        self.subject: object = None
        self.part: tuple[str | int, ...] = ()
        super().__init__(f"{place}: {self.message}" if place else self.message)


class DesignError(LamcError):
    """A design, mechanism or scene is malformed or impossible."""


class DesignErrors(DesignError):  # noqa: N818  it is what it says: several errors
    """Several problems of one file, all of them at once, one per line of `str(error)`."""

    def __init__(self, problems: Sequence[DesignError]) -> None:
        self.problems = tuple(problems)
        Exception.__init__(self, "\n".join(str(p) for p in self.problems))
        self.message = str(self)
        self.place = self.problems[0].place if self.problems else None
        self.subject, self.part = None, ()


class TopologyError(DesignError):
    """Bodies and joints do not make a mechanism."""


class ExpressionError(DesignError):
    """An expression in a scene is outside the permitted language."""


class DesignWarning(UserWarning):
    """What a file or an argument says is read, and is probably not what is meant, or has a new name."""


def warn(text: str, place: Place | None = None) -> None:
    """Warns the user: Python's way, or one line of the command line."""
    warnings.warn(f"{place}: {text}" if place else text, DesignWarning, stacklevel=3)


class UnsupportedError(LamcError):
    """The input is well formed, and this version of lamc cannot treat it."""


class SimulationError(LamcError):
    """A run could not be started or did not reach its end."""

    exit_code = 3


class RequestError(SimulationError):
    """What a run was asked for makes no sense: an unknown parameter, a time that runs backwards."""

    exit_code = 2


class EmitError(LamcError):
    """An expression has no C form."""

    exit_code = 4


class ExportError(LamcError):
    """What an export was asked for makes no sense, or something is in the way of its files."""


class BuildError(LamcError):
    """No C compiler, a compiler that fails, or a cache that cannot be used."""

    exit_code = 4


@contextmanager
def about(record: object, *part: str | int) -> Iterator[None]:
    """LamcErrors of the block are about `record`, or a part of it, unless they already are about another."""
    try:
        yield
    except LamcError as error:
        if error.subject is None:
            error.subject, error.part = record, part
        raise

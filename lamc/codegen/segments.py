"""Finds what repeats in a long function: like links do the same, link after link, with other operands.

Goes in: a Function. Comes out: its statements as segments, in order; segments of one class hold the same shapes on
the same pattern of operands and become one kernel and a loop. gcc's time grows faster than linearly in the length
of one block (213 s for 11 000 lines at -O2) and a kernel stays in the instruction cache, so this is quicker to
build and to run. A segment reads values of other segments through a row of indices.
"""

import itertools
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from lamc.symbolic.program import Function, Operand, Shape, Space, Statement

MIN_INSTANCES = 3  # fewer are written out: a kernel and its table would be longer than what they replace


class Local(NamedTuple):
    """Operand made in the same segment, by the statement at this position."""

    position: int


class External(NamedTuple):
    """Operand from outside the segment: number `slot` among them, in this array."""

    slot: int
    space: Space


Pattern = tuple[tuple[Shape, tuple[Local | External, ...]], ...]


@dataclass(frozen=True)
class Segment:
    """Statements [start, stop) of a function; all about one link and from one section. kind: number of its pattern."""

    start: int
    stop: int
    section: int
    pattern: Pattern
    kind: int
    externals: tuple[Operand, ...]


@dataclass(frozen=True)
class KernelClass:
    """Segments of one pattern. `stored`: positions whose values are read outside by any of them."""

    pattern: Pattern
    section: int
    stored: tuple[int, ...]


@dataclass(frozen=True)
class Layout:
    """Segments in order, the class of each (None: written out), and where values that cross are kept.

    place: local index → index in the array of crossing values; the stored values of a kernel's segment lie in a row.
    """

    segments: tuple[Segment, ...]
    class_of: tuple[int | None, ...]
    classes: tuple[KernelClass, ...]
    place: dict[int, int]
    size: int


def lay_out(function: Function) -> Layout:
    """The layout of `function`; time and size are linear in its length."""
    segments = _segments(function)
    crossing = _crossing(function, segments)
    class_of: list[int | None] = [None] * len(segments)
    classes: list[KernelClass] = []
    for members in _alike(segments):
        first = segments[members[0]]
        if len(members) < MIN_INSTANCES:
            continue
        stored = sorted(
            {
                index - segments[m].start
                for m in members
                for index in range(segments[m].start, segments[m].stop)
                if index in crossing
            }
        )
        for member in members:
            class_of[member] = len(classes)
        classes.append(KernelClass(first.pattern, first.section, tuple(stored)))
    place: dict[int, int] = {}
    for segment, kernel in zip(segments, class_of, strict=True):
        if kernel is not None:
            for position in classes[kernel].stored:
                place[segment.start + position] = len(place)
        else:
            for index in range(segment.start, segment.stop):
                if index in crossing:
                    place[index] = len(place)
    return Layout(tuple(segments), tuple(class_of), tuple(classes), place, len(place))


def _alike(segments: Sequence[Segment]) -> Iterable[list[int]]:
    """The segments of each pattern, by their numbers."""
    numbers: dict[int, list[int]] = {}
    for number, segment in enumerate(segments):
        numbers.setdefault(segment.kind, []).append(number)
    return numbers.values()


def _segments(function: Function) -> list[Segment]:
    """By links; those that are like no others by their steps."""
    statements = function.statements
    kinds: dict[Pattern, int] = {}
    whole = _runs(statements, 0, len(statements), _owner, kinds)
    counts = Counter(segment.kind for segment in whole)
    segments: list[Segment] = []
    for segment in whole:
        if counts[segment.kind] < MIN_INSTANCES:
            segments += _runs(statements, segment.start, segment.stop, _step, kinds)
        else:
            segments.append(segment)
    return segments


def _runs(
    statements: tuple[Statement, ...],
    start: int,
    stop: int,
    of: Callable[[Statement], object],
    kinds: dict[Pattern, int],
) -> list[Segment]:
    """Statements [start, stop) in runs that are of one thing; `kinds` of patterns grow."""
    segments: list[Segment] = []
    for _, run in itertools.groupby(range(start, stop), lambda k: of(statements[k])):
        places = list(run)
        segments.append(_segment(statements, places[0], places[-1] + 1, kinds))
    return segments


def _step(statement: Statement) -> int:
    return statement.step


def _owner(statement: Statement) -> tuple[int, int]:
    return statement.section, statement.link


def _segment(statements: tuple[Statement, ...], start: int, stop: int, kinds: dict[Pattern, int]) -> Segment:
    slots: dict[Operand, int] = {}
    pattern: list[tuple[Shape, tuple[Local | External, ...]]] = []
    for statement in statements[start:stop]:
        operands: list[Local | External] = []
        for operand in statement.operands:
            if operand.space is Space.LOCAL and operand.index >= start:
                operands.append(Local(operand.index - start))
            else:
                operands.append(External(slots.setdefault(operand, len(slots)), operand.space))
        pattern.append((statement.shape, tuple(operands)))
    made = tuple(pattern)
    kind = kinds.setdefault(made, len(kinds))
    return Segment(start, stop, statements[start].section, made, kind, tuple(slots))


def _crossing(function: Function, segments: list[Segment]) -> set[int]:
    """Locals that are read outside their segment."""
    crossing = {o.index for s in segments for o in s.externals if o.space is Space.LOCAL}
    return crossing | {operand.index for _, operand in function.outputs if operand.space is Space.LOCAL}

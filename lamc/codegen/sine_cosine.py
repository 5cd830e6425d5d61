"""Sines and cosines that belong together: one angle's share their work, and two angles take hardly longer than one.

Goes in: statements in order, or the pattern of a kernel. Comes out: who shares with whom, and the calls of `trig.h` as
lines of C. A batch of angles waits until one of its results is read or its section ends, so that it is as large as it
can be; nothing else changes its place.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

from lamc.codegen.printer import LANES, REAL
from lamc.symbolic.program import Operand, Shape, Space, Statement

CALLS = ("lamc_turn(", "lamc_turn_two(", "lamc_sin(", "lamc_cos(")  # in runtime_c/src/trig.h
SHARING = ("double", REAL, LANES)  # types of numbers for which trig.h, or lane_numbers.h, is called
_SINE, _COSINE = ("sin", 0), ("cos", 0)
_Operand = TypeVar("_Operand")


@dataclass(frozen=True)
class SineCosine:
    """An angle, and the positions of the statements that want its sine and its cosine."""

    sine: int
    cosine: int

    @property
    def first(self) -> int:
        return min(self.sine, self.cosine)


def sine_cosine_pairs(entries: Sequence[tuple[Shape, tuple[_Operand, ...]]]) -> dict[int, SineCosine]:
    """By position: the pair that a statement is half of, where both halves are wanted."""
    sines = {operands[0]: k for k, (shape, operands) in enumerate(entries) if shape == _SINE}
    cosines = {operands[0]: k for k, (shape, operands) in enumerate(entries) if shape == _COSINE}
    pairs = [SineCosine(k, cosines[angle]) for angle, k in sines.items() if angle in cosines]
    return {k: pair for pair in pairs for k in (pair.sine, pair.cosine)}


def batches(statements: Sequence[Statement]) -> Iterator[Statement | tuple[tuple[Statement, Statement], ...]]:
    """Statements and batches of (sine, cosine), in an order in which everything is there before it is read."""
    found = sine_cosine_pairs([(s.shape, s.operands) for s in statements])
    waiting: list[tuple[Statement, Statement]] = []
    missing: set[Operand] = set()  # targets of what waits
    section = -1
    for position, statement in enumerate(statements):
        if waiting and (statement.section != section or not missing.isdisjoint(statement.operands)):
            yield tuple(waiting)
            waiting.clear()
            missing.clear()
        pair = found.get(position)
        if pair is None or statement.operands[0].space is Space.NUMBER:
            yield statement
        elif position == pair.first:
            sine, cosine = statements[pair.sine], statements[pair.cosine]
            waiting.append((sine, cosine))
            missing |= {sine.target, cosine.target}
            section = statement.section
    if waiting:
        yield tuple(waiting)


def call(angle: str, sine: str, cosine: str, number: str) -> list[str]:
    """Lines of C that declare a sine and a cosine."""
    return [f"{number} {sine}, {cosine};", f"{_turn(number)}({angle}, &{sine}, &{cosine});"]


def _turn(number: str) -> str:
    return "lane_turn" if number == LANES else "lamc_turn"


def calls(
    batch: Sequence[tuple[Statement, Statement]], name: Callable[[Operand], str], number: str
) -> Iterator[str]:
    """Lines of C for a batch: two angles at a time, and the last of an odd number alone."""
    for (sine, cosine), (other_sine, other_cosine) in zip(batch[0::2], batch[1::2], strict=False):
        s, c = f"s{sine.target.index}", f"c{cosine.target.index}"
        yield f"{number} {s}[2], {c}[2];"
        yield f"{_turn(number)}_two({name(sine.operands[0])}, {name(other_sine.operands[0])}, {s}, {c});"
        for k, (one, other) in enumerate(((sine, cosine), (other_sine, other_cosine))):
            yield f"const {number} z{one.target.index} = {s}[{k}], z{other.target.index} = {c}[{k}];"
    if len(batch) % 2:
        sine, cosine = batch[-1]
        yield from call(name(sine.operands[0]), f"z{sine.target.index}", f"z{cosine.target.index}", number)

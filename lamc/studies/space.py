"""What an optimisation may choose: real numbers in a range, whole numbers, one of several values.

In: "20mm:60mm", "log:1e-4:1e-2", "3..8", "0.1 mm|0.2 mm", "carbon|glass", (0.02, 0.06), range(3, 9). Out: a `Space`,
whose unit box optimisers walk in: each name takes one edge of it, of length 1. Raises RequestError of one line for what
is none.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from lamc.basics.checks import is_list, shown
from lamc.basics.errors import RequestError, warn
from lamc.run.request import Array
from lamc.studies.axes import Span, axis_of, number_of
from lamc.studies.targets import Target, check_within, known_target

_WHOLE = re.compile(r"\s*([+-]?\d{1,9})\s*\.\.\s*([+-]?\d{1,9})\s*\Z")

Value = float | str
Edges = np.ndarray[Any, np.dtype[np.int64]]  # places of parameters in a point


@dataclass(frozen=True)
class Variable:
    """One thing to choose.

    unit       SI
    low, high  of real numbers, and of whole ones
    log        real numbers evenly in their logarithms
    levels     the values that there are to choose from, else empty: numbers, or words, which a point has by their place
    """

    name: str
    unit: str
    low: float
    high: float
    log: bool = False
    levels: tuple[Value, ...] = ()
    in_order: bool = False  # levels are whole numbers, one after the other

    @property
    def is_real(self) -> bool:
        return not self.levels

    @property
    def has_words(self) -> bool:
        return bool(self.levels) and isinstance(self.levels[0], str)

    def number(self, place: float) -> float:
        """What stands at a place of the unit interval."""
        place = min(max(place, 0.0), 1.0)
        if self.levels:
            level = min(int(place * len(self.levels)), len(self.levels) - 1)
            found = self.levels[level]
            return float(level) if isinstance(found, str) else found
        if place == 1.0:
            return self.high
        if self.log:
            return float(self.low * (self.high / self.low) ** place)
        return self.low + (self.high - self.low) * place

    def place(self, number: float) -> float:
        """Where in the unit interval a number stands; levels at the middle of their share."""
        if self.levels:
            level = number if self.has_words else self.levels.index(number)
            return (float(level) + 0.5) / len(self.levels)
        if self.log:
            return math.log(number / self.low) / math.log(self.high / self.low)
        return (number - self.low) / (self.high - self.low)

    def slope(self, place: float) -> float:
        """How much of its unit a whole edge of the box would be, going on as here."""
        span = self.number(place) * math.log(self.high / self.low) if self.log else self.high - self.low
        return abs(span)

    def value_of(self, number: float) -> Value:
        """A number as users know it: a word where there are words."""
        return self.levels[int(number)] if self.has_words else number


@dataclass(frozen=True)
class Space:
    """All that is to be chosen, in the order of a point's values."""

    variables: tuple[Variable, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(each.name for each in self.variables)

    @cached_property
    def real(self) -> Edges:
        """Places of the real numbers."""
        return np.array([k for k, each in enumerate(self.variables) if each.is_real], dtype=np.int64)

    def point(self, places: Array) -> tuple[float, ...]:
        return tuple(v.number(float(u)) for v, u in zip(self.variables, places, strict=True))

    def places(self, point: Sequence[float]) -> Array:
        return np.array([v.place(x) for v, x in zip(self.variables, point, strict=True)])

    def numbers(self, point: Sequence[float]) -> dict[str, float]:
        """Values by name, SI, of all but words."""
        return {v.name: x for v, x in zip(self.variables, point, strict=True) if not v.has_words}

    def values_at(self, point: Sequence[float]) -> dict[str, Value]:
        return {v.name: v.value_of(x) for v, x in zip(self.variables, point, strict=True)}


def space_of(vary: object, targets: Mapping[str, Target], words: Mapping[str, tuple[str, ...]]) -> Space:
    """The space of what is varied. words: of names that take words. Raises RequestError."""
    if not isinstance(vary, Mapping) or not vary:
        raise RequestError(
            f"vary is {shown(vary)}; it must map names to ranges, vary={{'length': (0.02, 0.06)}}, "
            "--vary length=20mm:60mm"
        )
    found = []
    for name, given in vary.items():
        if name in words:
            found.append(Variable(name, "1", 0.0, 0.0, levels=words[name]))
            continue
        target = known_target(name, targets)
        variable = _variable(target, given)
        check_within(target, variable.low, variable.high)
        found.append(variable)
    return Space(tuple(found))


def words_of(given: object) -> tuple[str, ...] | None:
    """The words of "carbon|glass" and ["carbon", "glass"]; None of what is no list of words."""
    parts = (
        given.split("|") if isinstance(given, str) else list(given) if isinstance(given, list | tuple) else []
    )
    if len(parts) < 2 or not all(isinstance(each, str) and each.strip() for each in parts):
        return None
    return tuple(each.strip() for each in parts)


def _variable(target: Target, given: object) -> Variable:
    """What a name is given. Raises RequestError."""
    name, unit = target.name, target.unit
    if isinstance(given, range):
        return _whole(name, unit, given.start, given[-1] if len(given) else given.start)
    if isinstance(given, str):
        whole = _WHOLE.match(given)
        if whole is not None:
            return _whole(name, unit, int(whole[1]), int(whole[2]))
        if "|" in given:
            given = [each.strip() for each in given.split("|")]
            return _levels(name, unit, given)
    elif is_list(given):
        values = list(given)
        if len(values) != 2:
            return _levels(name, unit, values)
        low, high = axis_values(name, values[:1], unit) + axis_values(name, values[1:], unit)
        return _range(name, unit, low, high, log=False)
    axis = axis_of(name, given, unit)
    if not isinstance(axis, Span):
        raise RequestError(
            f"vary {name!r}: {shown(given)} is no range; write FROM:TO, log:FROM:TO, 3..8 for whole numbers, or A|B|C"
        )
    if axis.count:
        warn(
            f"vary {name!r}: an optimum is looked for everywhere in the range, not at {axis.count} points of it; "
            "leave out the count, or list values: A|B|C"
        )
    return _range(name, unit, axis.start, axis.stop, log=axis.log)


def axis_values(name: str, given: Sequence[object], unit: str) -> list[float]:
    """Numbers in `unit`, of numbers and of texts. Raises RequestError."""
    return [number_of(name, each, unit) for each in given]


def _range(name: str, unit: str, low: float, high: float, *, log: bool) -> Variable:
    if not low < high:
        what = "is empty" if low == high else "runs backwards"
        raise RequestError(
            f"vary {name!r}: the range from {low:g} to {high:g} {what}; the first must be below the second"
        )
    return Variable(name, unit, low, high, log)


def _whole(name: str, unit: str, low: int, high: int) -> Variable:
    if low >= high:
        raise RequestError(
            f"vary {name!r}: {low}..{high} holds no two whole numbers; write FROM..TO, such as 3..8"
        )
    if high - low >= 100_000:
        raise RequestError(
            f"vary {name!r}: {low}..{high} are too many whole numbers; take a range, {low}:{high}"
        )
    levels = tuple(float(each) for each in range(low, high + 1))
    return Variable(name, unit, float(low), float(high), levels=levels, in_order=True)


def _levels(name: str, unit: str, given: Sequence[object]) -> Variable:
    values = axis_values(name, given, unit)
    if len(set(values)) != len(values) or len(values) < 2:
        raise RequestError(f"vary {name!r}: {shown(given)} are not two or more different values")
    return Variable(name, unit, min(values), max(values), levels=tuple(values))

"""The numbers that a fit looks for: each with its bounds, where it begins, and how it is moved.

In: what users give for a range. Out: `Unknown`s, and vectors of them as a solver moves them: logarithms of what is
positive and spans a decade, else the numbers themselves. Raises RequestError of one line for what is no range.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lamc.basics.checks import is_list, shown
from lamc.basics.errors import RequestError
from lamc.records.recording import Free
from lamc.run.request import Array
from lamc.studies.axes import number_of

_DECADE = 10.0
_WIDE = 1e8  # a positive number without bounds is looked for from a part to as many times of where it begins
_ROUND_OFF = (
    1e-14  # of a number: exp(log(x)) is off by |log x| units in the last place, some 20 of 2e-16 at 1e-8
)
_PRIOR = re.compile(r"\s*(.*?)\s*(?:±|\+-)\s*(.*?)\s*\Z")


@dataclass(frozen=True)
class Unknown:
    """A number to be found, SI.

    kind   "parameter", "dimension", "angle", "rate", "delay", "gain", "bias", "scale", "rotation", "origin"
    key    which of its kind: a parameter's name, a hinge, a column, the place of a coordinate
    owner  the recording or camera that it belongs to; "": it is of all
    size   by which changes are told where no logarithm is sought
    """

    name: str
    kind: str
    key: str
    unit: str
    free: Free
    start: float
    log: bool = False
    owner: str = ""
    size: float = 1.0

    def inner(self, value: float) -> float:
        """The number as a solver moves it."""
        return math.log(value) if self.log else value

    def value(self, inner: float) -> float:
        if not self.log:
            return inner
        found = math.exp(min(inner, 700.0))
        for bound in (self.free.low, self.free.high):  # which the logarithm and back may pass by round-off
            if math.isclose(found, bound, rel_tol=_ROUND_OFF):
                return bound
        return found


@dataclass(frozen=True)
class Unknowns:
    """All unknowns, in the order of a solver's vector."""

    all: tuple[Unknown, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(each.name for each in self.all)

    @cached_property
    def start(self) -> Array:
        return np.array([each.inner(each.start) for each in self.all])

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Least and most of the vector, (p,) each."""
        ends = [[each.free.low, each.free.high] for each in self.all]
        found = [
            [each.inner(v) if abs(v) < math.inf else v for v in pair]
            for each, pair in zip(self.all, ends, strict=True)
        ]
        low, high = np.array(found).reshape(-1, 2).T
        return low, high

    def values(self, inner: Array) -> Array:
        """Numbers (p,), SI, of a solver's vector (p,)."""
        return np.array([each.value(float(x)) for each, x in zip(self.all, inner, strict=True)])

    def rates(self, inner: Array) -> Array:
        """Derivatives (p,) of the numbers by the vector."""
        return np.array(
            [each.value(float(x)) if each.log else 1.0 for each, x in zip(self.all, inner, strict=True)]
        )

    def within(self, inner: Array) -> Array:
        return np.clip(inner, *self.bounds)


def free_of(given: object, name: str, unit: str) -> Free:
    """The range that a name is given: a `Free`, (low, high), "1e-4:1e-1", "log:1e-4:1e-1", "3 ± 0.5" (a prior), or
    nothing: None or "". Raises RequestError."""
    try:
        return _free_of(given, unit)
    except RequestError as error:
        why = error.message.removeprefix("'range': ")
        raise RequestError(f"{name!r}: {why}") from error


def _free_of(given: object, unit: str) -> Free:
    if isinstance(given, Free):
        return given
    if given is None or (isinstance(given, str) and not given.strip()):
        return Free()
    if isinstance(given, str):
        prior = _PRIOR.match(given)
        if prior is not None:
            mean, deviation = (_number(each, unit) for each in prior.groups())
            return Free(prior=(mean, deviation), start=mean)
        log = given.strip().startswith("log:")
        parts = given.strip().removeprefix("log:").split(":")
        if len(parts) == 2:
            return Free(_number(parts[0], unit), _number(parts[1], unit), log=log or None)
    elif is_list(given) and len(given) == 2:
        return Free(_number(given[0], unit), _number(given[1], unit))
    raise RequestError(
        f"{shown(given)} is no range; give (low, high), 'LOW:HIGH', 'MEAN ± DEVIATION' or lamc.Free(…)"
    )


def _number(given: object, unit: str) -> float:
    if isinstance(given, float) and math.isinf(given):
        return given
    return number_of("range", given, unit)


def is_range(given: object) -> bool:
    """Whether a number is to be found, rather than given."""
    return (
        isinstance(given, Free)
        or (is_list(given) and len(given) == 2)
        or (isinstance(given, str) and bool(set(given) & set(":±")))
    )


def unknown(
    name: str,
    kind: str,
    key: str,
    unit: str,
    free: Free,
    own: float | None,
    *,
    owner: str = "",
    size: float = 1.0,
    positive: bool = False,
) -> Unknown:
    """The unknown of a range. own: where it begins if the range says nothing; positive: it cannot be zero or less, or a
    logarithm of it may be sought where it begins above zero. Raises RequestError for a start out of bounds."""
    low, high = free.low, free.high
    start = free.start if free.start is not None else own
    bare = math.isinf(low) and math.isinf(high)
    if positive and bare and start is not None and start > 0.0:
        low, high = start / _WIDE, start * _WIDE
    elif positive:
        low = max(low, 0.0)
    log = free.log if free.log is not None else bool(low > 0.0 and high >= _DECADE * low)
    if start is None:
        start = _middle(low, high, log=log)
    if free.start is None and own is not None and not low <= own <= high:
        shown_unit = "" if unit == "1" else f" {unit}"
        raise RequestError(
            f"{name!r} begins at {own:g}{shown_unit}, outside of its bounds {low:g} … {high:g}; widen them, or "
            "say where "
            "to begin: lamc.Free(low, high, start=…)"
        )
    if log and not start > 0.0:
        log = False
    width = high - low
    size = width if math.isfinite(width) and not log else max(abs(start), 1e-300) if log else size
    return Unknown(name, kind, key, unit, replace(free, low=low, high=high), float(start), log, owner, size)


def _middle(low: float, high: float, *, log: bool) -> float:
    if log:
        return math.sqrt(low * high)
    if math.isfinite(low) and math.isfinite(high):
        return 0.5 * (low + high)
    return low if math.isfinite(low) else high if math.isfinite(high) else 0.0


def begun_at(unknowns: Sequence[Unknown], starts: Mapping[str, float]) -> tuple[Unknown, ...]:
    """The unknowns, some with other starts, as far as bounds let them."""
    return tuple(
        replace(each, start=min(max(starts[each.name], each.free.low), each.free.high))
        if each.name in starts
        else each
        for each in unknowns
    )

"""What one name of a study is given: a range, a list, or a distribution; in numbers, or in text with units.

In: "20mm:60mm:9", "log:1e-4:1e-2:7", "1,2,3", "normal(0.3 mm, 0.02 mm)", arrays of numbers. Out: axes in the SI unit of
what is varied. A range is never written out. Raises RequestError of one line for what is none.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import did_you_mean, is_list, shown
from lamc.basics.errors import DesignError, RequestError
from lamc.basics.si_units import in_unit
from lamc.records.scene import is_bare, warn_of_degrees
from lamc.run.request import Array

_SPREAD = re.compile(r"\s*([a-z]+)\s*\((.*)\)\s*\Z", re.DOTALL)
_FORMS = {  # how many numbers, and what they are
    "normal": ("mean", "standard deviation"),
    "uniform": ("least", "most"),
    "triangular": ("least", "likeliest", "most"),
    "lognormal": ("median", "standard deviation of the logarithm"),
    "truncated": ("mean", "standard deviation", "least", "most"),
}


@dataclass(frozen=True)
class Span:
    """`count` numbers from `start` to `stop`, evenly spread, or evenly in their logarithms. count 0: none are told, and
    samples lie in between."""

    start: float
    stop: float
    count: int
    log: bool = False

    def __len__(self) -> int:
        return self.count

    def value(self, k: int) -> float:
        if k == 0:
            return self.start
        if k == self.count - 1:
            return self.stop
        part = k / (self.count - 1)
        if self.log:
            return float(self.start * (self.stop / self.start) ** part)
        return self.start + (self.stop - self.start) * part

    @property
    def extremes(self) -> tuple[float, float]:
        return self.start, self.stop

    def quantiles(self, parts: Array) -> Array:
        """The numbers below which the shares `parts` (n,) of all samples lie."""
        if self.log:
            return self.start * (self.stop / self.start) ** parts
        return self.start + (self.stop - self.start) * parts


@dataclass(frozen=True)
class Listed:
    """Numbers one by one."""

    values: tuple[float, ...]

    def __len__(self) -> int:
        return len(self.values)

    def value(self, k: int) -> float:
        return self.values[k]

    @property
    def extremes(self) -> tuple[float, float]:
        return min(self.values), max(self.values)


@dataclass(frozen=True)
class Spread:
    """A distribution of `_FORMS`, by its numbers."""

    kind: str
    numbers: tuple[float, ...]

    @property
    def extremes(self) -> tuple[float, float]:
        """What samples are sure to lie within."""
        return {
            "uniform": (self.numbers[0], self.numbers[-1]),
            "triangular": (self.numbers[0], self.numbers[-1]),
            "truncated": (self.numbers[-2], self.numbers[-1]),
        }.get(self.kind, (-math.inf, math.inf))

    def quantiles(self, parts: Array) -> Array:
        """The numbers below which the shares `parts` (n,) of all samples lie."""
        from scipy import stats  # a third of a second, and of use to samples only

        first, second, *others = self.numbers
        if self.kind == "normal":
            found = stats.norm.ppf(parts, first, second)
        elif self.kind == "uniform":
            found = first + (second - first) * parts
        elif self.kind == "triangular":
            found = stats.triang.ppf(parts, (second - first) / (others[0] - first), first, others[0] - first)
        elif self.kind == "lognormal":
            found = stats.lognorm.ppf(parts, second, 0.0, first)
        else:
            low, high = ((end - first) / second for end in others)
            found = stats.truncnorm.ppf(parts, low, high, first, second)
        return np.asarray(found, dtype=np.float64)


Axis = Span | Listed | Spread


def axis_of(name: str, given: object, unit: str) -> Axis:
    """What `name`, whose SI unit is `unit`, is given. Raises RequestError."""
    if isinstance(given, Span | Listed | Spread):
        return given
    try:
        if isinstance(given, str):
            axis = _of_text(given, unit)
        elif is_list(given):
            axis = _listed([_number(each, unit) for each in given])
        else:
            axis = Listed((_number(given, unit),))
    except DesignError as error:
        raise RequestError(f"vary {name!r}: {error.message}") from error
    except RequestError as error:
        raise RequestError(f"vary {name!r}: {error.message}") from error
    if unit == "rad" and _are_bare(given):
        largest = max((end for end in axis.extremes if math.isfinite(end)), key=abs, default=0.0)
        warn_of_degrees(largest, f"what {name!r} is given")
    return axis


def number_of(name: str, given: object, unit: str) -> float:
    """The one number that `name`, whose SI unit is `unit`, is given. Raises RequestError for what is none, and for what
    may be several: 1,000 or 1:5, whose first is not meant."""
    if isinstance(given, str) and (set(given) & set(":,") or _SPREAD.match(given)):
        raise RequestError(f"{name!r}: {shown(given)} is not one number; decimals have a point")
    try:
        number = _number(given, unit)
    except (DesignError, RequestError) as error:
        raise RequestError(f"{name!r}: {error.message}") from error
    if unit == "rad" and is_bare(given):
        warn_of_degrees(number, f"what {name!r} is given")
    return number


def _are_bare(given: object) -> bool:
    """Whether none of the numbers comes with a unit."""
    if is_list(given):
        return all(map(is_bare, given))
    if not isinstance(given, str):
        return True
    spread = _SPREAD.match(given)
    if spread is not None:
        return all(map(is_bare, spread[2].split(",")))
    body = given.strip().removeprefix("log:")
    return all(map(is_bare, body.split(":")[:2] if ":" in body else body.split(",")))


def _of_text(text: str, unit: str) -> Axis:
    match = _SPREAD.match(text)
    if match is not None:
        return _spread(match[1], match[2], unit)
    log = text.strip().startswith("log:")
    body = text.strip().removeprefix("log:")
    if ":" in body:
        return _span(body.split(":"), unit, text, log=log)
    if log:
        raise RequestError(f"{text!r} is no range; a logarithmic one is log:FROM:TO:COUNT")
    return _listed([_number(each, unit) for each in body.split(",")])


def _span(parts: Sequence[str], unit: str, text: str, *, log: bool) -> Span:
    if len(parts) not in (2, 3):
        raise RequestError(f"{text!r} is no range; write FROM:TO:COUNT, such as 20mm:60mm:9")
    start, stop = (_number(each, unit) for each in parts[:2])
    if start > stop:
        way_out = ":".join([parts[1], parts[0], *parts[2:]])
        raise RequestError(f"the range {text!r} runs backwards; write {'log:' * log}{way_out}")
    if start == stop:
        raise RequestError(f"the range {text!r} is empty: both ends are {start:g}; write one number")
    if log and start <= 0.0:
        raise RequestError(f"the range {text!r} begins at {start:g}; a logarithmic one lies above zero")
    count = _count(parts[2], text) if len(parts) == 3 else 0
    return Span(start, stop, count, log)


def _count(text: str, whole: str) -> int:
    count = text.strip()
    if not (count.isascii() and count.isdigit() and len(count) <= 15 and int(count) >= 2):
        raise RequestError(
            f"the range {whole!r} has {count[:20]!r} points; a count is a whole number, 2 or more"
        )
    return int(count)


def _spread(kind: str, body: str, unit: str) -> Spread:
    if kind not in _FORMS:
        raise RequestError(f"no distribution is named {kind!r}; {did_you_mean(kind, list(_FORMS))}")
    forms, given = _FORMS[kind], body.split(",")
    if len(given) != len(forms):
        raise RequestError(f"{kind} takes {len(forms)} numbers ({', '.join(forms)}), not {len(given)}")
    units = ["1" if form.endswith("logarithm") else unit for form in forms]
    numbers = tuple(_number(each, of) for each, of in zip(given, units, strict=True))
    if "deviation" in forms[1] and numbers[1] <= 0.0:
        raise RequestError(f"{kind}: the {forms[1]} is {numbers[1]:g}; it must be above zero")
    if kind == "lognormal" and numbers[0] <= 0.0:
        raise RequestError(f"lognormal: the median is {numbers[0]:g}; it must be above zero")
    ends = numbers if kind in ("uniform", "triangular") else numbers[2:]
    if list(ends) != sorted(ends) or (ends and ends[0] == ends[-1]):
        raise RequestError(
            f"{kind}: {', '.join(forms[-len(ends) :])} must ascend, and they are {body.strip()}"
        )
    return Spread(kind, numbers)


def _listed(values: Sequence[float]) -> Listed:
    if not values:
        raise RequestError("there are no values; give one at least")
    twice = (
        next((value for k, value in enumerate(values) if value in values[:k]), None)
        if len(values) < 1000
        else None
    )
    if twice is not None:
        raise RequestError(f"the value {twice:g} is there twice; leave one out")
    return Listed(tuple(values))


def _number(given: object, unit: str) -> float:
    """A number in `unit`, of one or of text with its own."""
    if isinstance(given, str):
        if not given.strip():
            raise RequestError("a value is missing; values are numbers, with units or without")
        return in_unit(given, unit, "value")
    if isinstance(given, bool | np.bool_) or not isinstance(given, int | float | np.number):
        raise RequestError(f"{shown(given)} is no value; give numbers, or text such as '20mm:60mm:9'")
    number = float(given)
    if not math.isfinite(number):
        raise RequestError(f"the value {number} is not finite")
    return number

"""What expressions of measures are made of: terms with a unit, over time or not, and the ways to combine them.

In: terms. Out: terms; what a term comes to is asked for with the `Rows` of a run. Raises ExpressionError for units that
do not fit. A term holds functions, so it stays in its process; measures travel as text.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

import numpy as np

from lamc.basics.errors import ExpressionError, RequestError
from lamc.run.request import Array
from lamc.run.result import Result
from lamc.studies import sample_slopes as slopes
from lamc.studies.dimensions import PLAIN, RADIAN, SECOND, Unit
from lamc.studies.measure_slopes import Slope, mapped_slope, nothing, sampled_slope, without
from lamc.studies.samples import Samples, first_above, highest, integral, mean, rms, turned, value_at


@dataclass(frozen=True, eq=False)
class Rows:
    """A run as measures see it. given: what was varied for it, SI, by name."""

    result: Result
    breaks: Array  # (k,), s: times of events, ascending
    given: Mapping[str, float] = field(default_factory=dict)
    known: dict[str, Array] = field(default_factory=dict)

    def quantity(self, name: str) -> Array:
        """Values (m,) of a quantity, in SI."""
        if name not in self.known:
            if name == "t":
                self.known[name] = self.result.t
            elif name.startswith("energy."):
                self.known[name] = self.result.energies[name.removeprefix("energy.")]
            else:
                self.known[name] = self.result.quantity(name).values
        return self.known[name]

    @classmethod
    def of(cls, result: Result, given: Mapping[str, float]) -> "Rows":
        return cls(result, np.sort(np.array([event.t for event in result.events], dtype=float)), given)

    def parameter(self, name: str) -> float:
        """What was varied. Raises RequestError where it is not told."""
        if name not in self.given:
            raise RequestError(f"a measure names {name!r}, which was varied; give its value with the run")
        return self.given[name]

    def samples(self, values: Array | float) -> Samples:
        return Samples(self.result.t, np.broadcast_to(values, self.result.t.shape), self.breaks)


_MOST_POWER = 12  # of a unit
Value = Callable[[Rows], Any]  # floats, or arrays (m,) of terms over time


@dataclass(frozen=True, eq=False)
class Term:
    """value: in SI `unit`. is_bare: a number that was written without a unit, and takes that of what it is added to.
    number: its value where no run is needed for it. times: at which values are asked for, s. slope: hands what the
    term is weighed with on to what it is made of."""

    unit: Unit
    value: Value
    over_time: bool = False
    is_bare: bool = False
    number: float | None = None
    times: tuple[float, ...] = ()
    names: frozenset[str] = frozenset()  # of the quantities in it, and of what is varied
    slope: Slope = nothing

    @staticmethod
    def of_number(number: float, unit: Unit, *, is_bare: bool = False) -> "Term":
        return Term(unit, lambda _: number, is_bare=is_bare, number=number)


def quantity(name: str, unit: Unit) -> Term:
    return Term(
        unit,
        lambda rows: rows.quantity(name),
        over_time=True,
        names=frozenset([name]),
        slope=lambda _, weight, gathered: gathered.add_quantity(name, weight),
    )


def parameter(name: str, unit: Unit) -> Term:
    """What was varied for the run."""
    return Term(
        unit,
        lambda rows: rows.parameter(name),
        names=frozenset([name]),
        slope=lambda _, weight, gathered: gathered.add_given(name, weight),
    )


def negated(term: Term) -> Term:
    return _mapped(np.negative, [term], term.unit, is_bare=term.is_bare)


def added(left: Term, right: Term) -> Term:
    return _mapped(np.add, [left, right], _common(left, right), is_bare=left.is_bare and right.is_bare)


def multiplied(left: Term, right: Term, sign: str) -> Term:
    """sign: "*" or "/"."""
    is_bare = left.is_bare and right.is_bare
    if sign == "*":
        return _mapped(np.multiply, [left, right], left.unit * right.unit, is_bare=is_bare)
    if right.number == 0.0:
        raise ExpressionError("division by zero")
    return _mapped(np.divide, [left, right], left.unit / right.unit, is_bare=is_bare)


def raised(base: Term, exponent: Term) -> Term:
    if exponent.unit.dimension:
        raise ExpressionError(f"an exponent has no unit, and this one is in {exponent.unit.text}")
    if not base.unit.dimension:
        return _mapped(np.float_power, [base, exponent], PLAIN, is_bare=base.is_bare and exponent.is_bare)
    if exponent.number is None:
        raise ExpressionError(f"what is in {base.unit.text} can be raised to a plain number only")
    if abs(exponent.number) > _MOST_POWER:
        raise ExpressionError(
            f"what is in {base.unit.text} can be raised to the power of {_MOST_POWER} at most"
        )
    power = Fraction(exponent.number).limit_denominator(12)
    return _mapped(np.float_power, [base, exponent], base.unit**power)


# name: function, whether its argument is an angle, or any unit is kept ("kept"), and the unit that comes out
_PLAIN_FUNCTIONS: Mapping[str, Any] = {
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "exp": np.exp,
    "log": np.log,
}
_OF_ANGLES: Mapping[str, Any] = {"sin": np.sin, "cos": np.cos, "tan": np.tan}
_TO_ANGLES: Mapping[str, Any] = {"asin": np.arcsin, "acos": np.arccos, "atan": np.arctan}
_OF_TWO: Mapping[str, Any] = {"min": np.minimum, "max": np.maximum}


def function(name: str, terms: Sequence[Term]) -> Term:
    """A function of `FUNCTIONS`, of as many terms as it takes."""
    (first, *others) = terms
    if name == "abs":
        return _mapped(np.abs, terms, first.unit, is_bare=first.is_bare)
    if name == "sign":
        return _mapped(np.sign, terms, PLAIN)
    if name == "sqrt":
        return _mapped(np.sqrt, terms, first.unit ** Fraction(1, 2))
    if name == "pow":
        return raised(first, others[0])
    if name in _OF_TWO:
        is_bare = first.is_bare and others[0].is_bare
        return _mapped(_OF_TWO[name], terms, _common(first, others[0]), is_bare=is_bare)
    if name == "atan2":
        _common(first, others[0])
        return _mapped(np.arctan2, terms, RADIAN)
    if first.unit.dimension and not (name in _OF_ANGLES and first.unit.is_like(RADIAN)):
        rule = "an angle or a plain number" if name in _OF_ANGLES else "a plain number"
        raise ExpressionError(f"{name} takes {rule}, and this is in {first.unit.text}")
    if name in _TO_ANGLES:
        return _mapped(_TO_ANGLES[name], terms, RADIAN)
    return _mapped({**_PLAIN_FUNCTIONS, **_OF_ANGLES}[name], terms, PLAIN)


OVER_TIME: Mapping[str, Callable[[Samples], float]] = {
    "max": lambda samples: highest(samples)[0],
    "min": lambda samples: -highest(turned(samples))[0],
    "mean": mean,
    "rms": rms,
    "integral": integral,
    "first": lambda samples: float(samples.y[0]),
    "last": lambda samples: float(samples.y[-1]),
}


def reduced(name: str, term: Term) -> Term:
    """A number of a quantity over the run."""
    _needs_time(name, term)
    reduce = OVER_TIME[name]
    unit = term.unit * SECOND if name == "integral" else term.unit
    slope = sampled_slope(term, slopes.OVER_TIME[name])
    return _number(term, lambda rows: reduce(rows.samples(term.value(rows))), unit, slope)


def row(term: Term, index: int) -> Term:
    _needs_time("[…]", term)

    def value(rows: Rows) -> float:
        values = rows.samples(term.value(rows)).y
        return float(values[index]) if -len(values) <= index < len(values) else math.nan

    return _number(term, value, term.unit, sampled_slope(term, lambda each: slopes.row_slope(each, index)))


def valued_at(term: Term, time: Term) -> Term:
    _needs_time("at", term)
    if time.number is None:
        raise ExpressionError("the time in at(…) is a number, such as 0.5 s")
    if not (time.is_bare or time.unit.is_like(SECOND)):
        raise ExpressionError(f"the time in at(…) is in {time.unit.text}; it must be in s")
    moment = time.number
    slope = sampled_slope(term, lambda each: slopes.at_slope(each, moment))
    found = _number(term, lambda rows: value_at(rows.samples(term.value(rows)), moment), term.unit, slope)
    return replace(found, times=(*term.times, moment))


def extreme_time(name: str, term: Term) -> Term:
    """The time of the largest value (name "max") or the least."""
    _needs_time("time_of", term)

    def value(rows: Rows) -> float:
        samples = rows.samples(term.value(rows))
        return highest(samples if name == "max" else turned(samples))[1]

    slope = slopes.highest_time_slope if name == "max" else slopes.lowest_time_slope
    return _number(term, value, SECOND, sampled_slope(term, slope))


def first_time(left: Term, right: Term, sign: str) -> Term:
    """The first time at which left < right, or left > right."""
    difference = added(left, negated(right)) if sign == ">" else added(right, negated(left))
    _needs_time("time_of", difference)
    slope = sampled_slope(difference, slopes.crossing_slope)
    return _number(difference, lambda rows: first_above(rows.samples(difference.value(rows))), SECOND, slope)


def counted(name: str | None, _which: int) -> Term:
    """How many events there were, of a name or in all."""
    return Term(PLAIN, lambda rows: float(sum(name in (None, each.name) for each in rows.result.events)))


def event_time(name: str | None, which: int) -> Term:
    if name is None:
        raise ExpressionError("time_of takes a comparison, x > 5 mm, an extreme, max(x), or an event, 'name'")

    def value(rows: Rows) -> float:
        times = [each.t for each in rows.result.events if each.name == name]
        return times[which] if -len(times) <= which < len(times) else math.nan

    return Term(
        SECOND,
        value,
        slope=without(
            "there is no gradient of the time of an event; take that of a crossing, time_of(x > …)"
        ),
    )


def _needs_time(what: str, term: Term) -> None:
    if not term.over_time:
        raise ExpressionError(f"{what} takes a quantity of the run, and this is one number")


def _number(term: Term, value: Value, unit: Unit, slope: Slope) -> Term:
    return Term(unit, value, times=term.times, names=term.names, slope=slope)


def _common(left: Term, right: Term) -> Unit:
    """The unit of both."""
    if left.is_bare or right.is_bare:
        return right.unit if left.is_bare else left.unit
    if not left.unit.is_like(right.unit):
        raise ExpressionError(f"{left.unit.text} and {right.unit.text} are of different dimensions")
    return left.unit


def _mapped(operation: Any, terms: Sequence[Term], unit: Unit, *, is_bare: bool = False) -> Term:
    """The operation on values, entry by entry."""
    values = tuple(term.value for term in terms)

    def value(rows: Rows | None) -> Any:
        with np.errstate(all="ignore"):  # what is not finite is told of the point
            return operation(*(each(rows) for each in values))  # type: ignore[arg-type]

    number = None
    if all(term.number is not None for term in terms):
        number = float(value(None))
        if not math.isfinite(number):
            raise ExpressionError(f"a constant part is {number}; it must be finite")
    return Term(
        unit,
        value,
        over_time=any(term.over_time for term in terms),
        is_bare=is_bare,
        number=number,
        times=tuple(time for term in terms for time in term.times),
        names=frozenset().union(*(term.names for term in terms)),
        slope=mapped_slope(operation, terms),
    )

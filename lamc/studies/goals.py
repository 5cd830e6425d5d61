"""What an optimisation is after: goals, the constraints beside them, and the residuals of goals that are squares.

In: text such as "rms(tip.z - 5 mm)" and "max(abs(h1)) < 60 deg", or functions of a result, and what runs tell. Out:
`Goal`s and `Constraint`s, checked before anything runs. Never: runs anything.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lamc.basics.checks import shown
from lamc.basics.errors import ExpressionError, RequestError
from lamc.run.request import Array
from lamc.run.result import Result
from lamc.studies.dimensions import unit_of
from lamc.studies.measure_names import NOTHING_GIVEN, Outputs
from lamc.studies.measure_terms import Rows, Term, added, negated
from lamc.studies.measure_text import read, read_part
from lamc.studies.measures import Measure

_COMPARISON = re.compile(r"<=|>=|==|<|>|=")
_SQUARE = re.compile(r"\s*(?:\*\*|\^)\s*2(?:\.0*)?\s*\Z")
_ROOT = re.compile(r"\s*rms\s*\((.*)\)\s*\Z", re.DOTALL)


@dataclass(frozen=True, eq=False)
class Goal:
    """A number to make as small as can be.

    text     as it was written, or the name of a function; unit: SI
    is_root  the number is the root of the sum of the squares of its residuals, else that sum, if it has any
    times    at which it asks for values, s
    parts    terms whose squares are added up; none: nothing is known of how it is made up
    """

    text: str
    unit: str
    times: tuple[float, ...] = ()
    measure: Measure | None = None
    function: Callable[[Result], object] | None = None
    is_root: bool = False
    parts: tuple[Term, ...] = field(default=(), repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """Terms hold functions: they are read again."""
        known = (self.text, self.unit, self.times, self.measure, self.function, self.is_root)
        return _goal_again, (*known, bool(self.parts))

    @property
    def is_squares(self) -> bool:
        return bool(self.parts)

    def of(self, result: Result, given: Mapping[str, float] = NOTHING_GIVEN) -> tuple[float, Array | None]:
        """The value of a run, and its residuals (m,): their squares add up to the value, or to its square. given: what
        was varied for it, SI, by name."""
        if self.function is not None:
            return _of_function(self.function(result), self.text)
        assert self.measure is not None
        value = self.measure.value(result, given)
        if not self.parts or not len(result.t):
            return value, None
        rows = Rows.of(result, given)
        return value, np.concatenate([_residual(part, rows) for part in self.parts])


@dataclass(frozen=True, eq=False)
class Constraint:
    """text: as it was written; measure: left minus right, or right minus left: at most 0; is_equal: 0."""

    text: str
    measure: Measure
    is_equal: bool = False


def goal_of(given: object, outputs: Outputs) -> Goal:
    """The goal of a text, of a function of the result or of (function, unit). A function of several numbers gives their
    root mean square. Raises RequestError and ExpressionError."""
    if isinstance(given, str):
        measure = Measure.parse(given, outputs)
        if read(given, outputs).number is not None:
            raise RequestError(
                f"the goal {given.strip()!r} is the same in every run; name what a run gives, such as 'max(tip.z)'"
            )
        is_root, parts = _squares(given, outputs)
        return Goal(given.strip(), measure.unit, measure.times, measure, is_root=is_root, parts=parts)
    if isinstance(given, Measure):
        return Goal(given.text, given.unit, given.times, given)
    function, unit = given if isinstance(given, tuple) and len(given) == 2 else (given, "1")
    if not callable(function) or not isinstance(unit, str):
        raise RequestError(
            f"minimise is {shown(given)}; it must be text such as 'rms(tip.z - 5 mm)', a function of the result, or "
            "(function, unit)"
        )
    name = getattr(function, "__qualname__", type(function).__name__)
    return Goal(name, unit_of(unit).text, function=function)


def _goal_again(*given: Any) -> Goal:
    """A goal that has travelled."""
    *known, has_parts = given
    made = Goal(*known)
    return (
        replace(made, parts=_squares(made.text, made.measure.known)[1])
        if has_parts and made.measure
        else made
    )


def constraints_of(given: object, outputs: Outputs) -> tuple[Constraint, ...]:
    """The constraints of a text or of several; "1 < x < 2" makes two. Raises RequestError and ExpressionError."""
    texts = [given] if isinstance(given, str) else given
    if not isinstance(texts, Sequence) or not all(isinstance(each, str) for each in texts):
        raise RequestError(
            f"subject_to is {shown(given)}; it must be a list of texts such as 'max(abs(h1)) < 60 deg'"
        )
    return tuple(found for text in texts for found in _constraints(text, outputs))


def _constraints(text: str, outputs: Outputs) -> list[Constraint]:
    parts, signs = _split(text, _COMPARISON)
    if not signs or not all(part.strip() for part in parts) or "=" in signs:
        raise ExpressionError(
            f"constraint {text!r} is no comparison; write EXPRESSION < VALUE, with <, <=, >, >= or =="
        )
    try:
        terms = [read(part, outputs) for part in parts]
    except ExpressionError as error:
        raise ExpressionError(f"constraint {text!r}: {error.message}") from error
    found = []
    for k, sign in enumerate(signs):
        try:
            added(terms[k], negated(terms[k + 1]))
        except ExpressionError as error:
            raise ExpressionError(f"constraint {text!r}: {error.message}") from error
        if not (terms[k].names or terms[k + 1].names or "(" in parts[k] + parts[k + 1]):
            raise ExpressionError(
                f"constraint {text!r} compares two fixed numbers; name an output of the run, or what is varied"
            )
        small, large = (parts[k], parts[k + 1]) if sign in ("<", "<=", "==") else (parts[k + 1], parts[k])
        measure = Measure.parse(f"({small.strip()}) - ({large.strip()})", outputs)
        alone = text.strip() if len(signs) == 1 else f"{parts[k].strip()} {sign} {parts[k + 1].strip()}"
        found.append(Constraint(alone, measure, is_equal=sign == "=="))
    return found


def _squares(text: str, outputs: Outputs) -> tuple[bool, tuple[Term, ...]]:
    """Whether a goal is the root of a sum of squares, and the terms that are squared; none if it is no such sum."""
    root = _ROOT.match(text)
    if root is not None and _is_closed(root[1]):
        return True, (read_part(root[1], outputs),)
    parts, _ = _split(text, re.compile(r"\+"))
    bases = [_SQUARE.sub("", part).strip() for part in parts if _SQUARE.search(part)]
    if len(bases) != len(parts) or any(_split(each, re.compile(r"[-+*/^]"))[1] for each in bases):
        return False, ()
    return False, tuple(read(each, outputs) for each in bases)


def _residual(term: Term, rows: Rows) -> Array:
    """Of a quantity over time, weighted such that the squares add up to the mean of the square by the trapezoidal rule;
    of a number, the number."""
    if not term.over_time:
        return np.array([float(term.value(rows))])
    samples = rows.samples(term.value(rows))
    steps = np.diff(samples.t)
    weights = 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))
    return np.asarray(samples.y * np.sqrt(weights / max(float(np.sum(steps)), 1e-300)), dtype=np.float64)


def _of_function(given: object, name: str) -> tuple[float, Array | None]:
    try:
        numbers = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise RequestError(
            f"the goal {name!r} gives {shown(given)}; it must give one number, or several"
        ) from error
    if numbers.ndim == 0:
        return float(numbers), None
    residual = numbers.ravel() / np.sqrt(max(numbers.size, 1))
    return float(np.linalg.norm(residual)), residual


def _split(text: str, separator: re.Pattern[str]) -> tuple[list[str], list[str]]:
    """Parts of a text and the separators between them, outside of brackets and quotes."""
    parts, signs = [], []
    depth, start, quote, k = 0, 0, "", 0
    while k < len(text):
        char = text[k]
        if quote:
            quote = "" if char == quote else quote
        elif char in "'\"":
            quote = char
        elif char in "([":
            depth += 1
        elif char in ")]":
            depth -= 1
        elif depth == 0 and (match := separator.match(text, k)) is not None:
            parts.append(text[start:k])
            signs.append(match[0])
            k = start = match.end()
            continue
        k += 1
    return [*parts, text[start:]], signs


def _is_closed(inner: str) -> bool:
    """Whether all brackets that open within also close within."""
    depth = 0
    for char in re.sub(r"'[^']*'|\"[^\"]*\"", "", inner):
        depth += (char in "([") - (char in ")]")
        if depth < 0:
            return False
    return depth == 0

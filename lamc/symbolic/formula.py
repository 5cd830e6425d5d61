"""Expressions in named dimensions, such as "length/2 + 3 mm", with their units checked.

Goes in: text of the language of `lamc.symbolic.grammar`, in which a number may have a unit behind it, and the dimension
of each name. Comes out: a `Formula`, which has a dimension and gives numbers, SI, for numbers. Nothing is evaluated by
Python.

Sums, products and quotients of decimals are exact, and rounded once at the end: a/2 + b is the number that one would
write in its place, to the last bit, and edges that meet on paper meet. Functions, and powers that are not whole, round.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from lamc.basics.checks import did_you_mean
from lamc.basics.common_units import COMMON
from lamc.basics.dimensions import PLAIN, Dimension, dimension_of, in_words, product
from lamc.basics.errors import DesignError, ExpressionError
from lamc.basics.si_units import measured
from lamc.symbolic.functions import ARITHMETIC, FUNCTIONS
from lamc.symbolic.grammar import CONSTANTS, Grammar, Token, check_length, tokens_of

Number = Fraction | float
Values = Mapping[str, Number]
Run = Callable[[Values], Number]

LENGTH = dimension_of("m")
ANGLE = dimension_of("rad")
_MOST_BITS = (
    2000  # of an exact number; beyond them it is rounded, so that no chain of squares grows without end
)
_MOST_POWER = 64
_OF_ANGLES = ("sin", "cos", "tan")
_TO_ANGLES = ("asin", "acos", "atan")
_LIKE = ("min", "max", "atan2")  # two of one dimension


@dataclass(frozen=True, slots=True)
class Formula:
    """An expression in names.

    dimension  of its values
    names      that stand in it, in order
    """

    text: str
    dimension: Dimension
    names: tuple[str, ...]
    run: Run

    def value(self, values: Values) -> Number:
        """Its value, SI, for values of the names. Raises ExpressionError where it has none that is finite."""
        try:
            value = self.run(values)
            if math.isfinite(value):
                return value
        except (ArithmeticError, ValueError):
            pass
        raise ExpressionError(f"expression {self.text!r}: it has no finite value here")


@dataclass(frozen=True, slots=True)
class _Part:
    """is_written: it holds neither names nor units, and so may take the unit of what it is added to."""

    dimension: Dimension
    run: Run
    is_written: bool = False


def formula(text: str, dimensions: Mapping[str, Dimension], bare: Fraction = Fraction(1)) -> Formula:
    """The expression in the names of `dimensions`.

    bare  how many m a length without a unit is, where one is added to a length

    Raises ExpressionError, with the column, for what is outside the language, for names that are not known, and for
    dimensions that do not go together.
    """
    reader = _Typed(text, dimensions, bare)
    try:
        part = reader.whole()
    except ExpressionError:
        raise
    except (ArithmeticError, ValueError) as error:
        raise reader.error(f"a constant part has no finite value ({error})", 1) from error
    return Formula(text, part.dimension, tuple(reader.used), part.run)


def constant(text: str, value: Number, dimension: Dimension) -> Formula:
    """The formula of a number."""
    return Formula(text, dimension, (), _always(value))


def exact(value: float) -> Fraction:
    """The decimal number as which a float is written."""
    return Fraction(repr(value))


def names_of(text: str) -> Mapping[str, int]:
    """Names in `text` that are no functions, constants or units, each with the column where it first stands.

    Raises ExpressionError for a sign outside the language."""
    check_length(text)
    found: dict[str, int] = {}
    tokens = tokens_of(text)
    for before, token in pairwise([Token("end", "", 0), *tokens]):
        known = token.text in FUNCTIONS or token.text in CONSTANTS
        if token.kind == "name" and not known and before.kind != "number":
            found.setdefault(token.text, token.column)
    return found


class _Typed(Grammar[_Part]):
    """What is constant is computed as it is read."""

    def __init__(self, text: str, dimensions: Mapping[str, Dimension], bare: Fraction) -> None:
        super().__init__(text)
        self.dimensions = dimensions
        self.bare = bare
        self.used: dict[str, None] = {}

    def number(self, token: Token) -> _Part:
        unit = self._unit(token)
        if not unit:
            return _written(Fraction(token.text))
        try:
            value, si = measured(f"{token.text} {unit}")
        except DesignError as error:
            raise self.error(error.message, token.column) from error
        return _constant(exact(value), dimension_of(si))

    def _unit(self, number: Token) -> str:
        """The unit behind a number, "N*mm/rad", which ends before what is no unit's name; empty for none."""
        if self.token.kind != "name":
            return ""
        if self.token.text in self.dimensions or self.token.text in (*FUNCTIONS, *CONSTANTS):
            raise self.error(f"write {number.text}*{self.token.text}")
        text = self._unit_factor()
        while (sign := self.token.text) in ("*", "/"):
            following = self.tokens[self.position + 1]
            taken = (*self.dimensions, *FUNCTIONS, *CONSTANTS)
            if following.kind != "name" or following.text in taken:
                break
            self.position += 1
            text += sign + self._unit_factor()
        return text

    def _unit_factor(self) -> str:
        """A name, and its power where it has one."""
        name = self.token.text
        self.position += 1
        if self.token.text not in ("^", "**"):
            return name
        texts = [each.text for each in self.tokens[self.position + 1 : self.position + 3]]
        count = 2 if texts[0] == "-" else 1
        power = "".join(texts[:count])
        if not power.lstrip("-").isdigit():
            raise self.error(f"the power of the unit {name} is no whole number")
        self.position += 1 + count
        return f"{name}^{power}"

    def name(self, token: Token) -> _Part:
        name = token.text
        if name in self.dimensions:
            self.used[name] = None
            return _Part(self.dimensions[name], lambda values: values[name])
        if name in CONSTANTS:
            return _written(CONSTANTS[name])
        raise self.error(self._unknown(name), token.column)

    def _unknown(self, name: str) -> str:
        if (name, "m") in COMMON or name in ("m", "rad", "deg"):
            return f"{name} is a unit, and a unit follows a number: write 1 {name}"
        known = [*self.dimensions]
        if not known:
            return f"no parameter is named {name!r}; the design has none: declare it under parameters:"
        return f"no parameter is named {name!r}; {did_you_mean(name, known)}"

    def negative(self, value: _Part) -> _Part:
        run = value.run
        return self._made(value.dimension, lambda values: -run(values), value)

    def combined(self, sign: str, left: _Part, right: _Part, column: int) -> _Part:
        if sign == "^":
            return self._power(left, right, column)
        if sign in "+-":
            left, right = self._alike(left, right, column, "added" if sign == "+" else "subtracted")
            dimension = left.dimension
        else:
            dimension = product(left.dimension, right.dimension, 1 if sign == "*" else -1)
        one, other = left.run, right.run
        return self._made(dimension, _run_of(sign, one, other, self, column), left, right)

    def _alike(self, left: _Part, right: _Part, column: int, verb: str) -> tuple[_Part, _Part]:
        """Both in one dimension: a plain number that is written out takes that of the other, as it would standing
        alone: a length in the file's unit, anything else in SI."""
        if left.dimension == right.dimension:
            return left, right
        if left.is_written and left.dimension == PLAIN:
            return self._measured(left, right.dimension), right
        if right.is_written and right.dimension == PLAIN:
            return left, self._measured(right, left.dimension)
        one, other = in_words(left.dimension), in_words(right.dimension)
        way_out = ""
        if PLAIN in (left.dimension, right.dimension):
            way_out = "; give the plain one its unit where it is declared"
        raise self.error(f"{one} and {other} cannot be {verb} or compared{way_out}", column)

    def _measured(self, part: _Part, dimension: Dimension) -> _Part:
        return _constant(part.run({}) * (self.bare if dimension == LENGTH else 1), dimension)

    def _power(self, base: _Part, exponent: _Part, column: int) -> _Part:
        if exponent.dimension != PLAIN:
            raise self.error(
                f"an exponent is a plain number, and this is {in_words(exponent.dimension)}", column
            )
        dimension = base.dimension
        if dimension != PLAIN:
            power = exponent.run({}) if exponent.is_written else None
            if not isinstance(power, Fraction) or abs(power) > _MOST_POWER:
                raise self.error(
                    f"{in_words(dimension)} takes a power that is written out, such as 2 or 0.5", column
                )
            dimension = product(PLAIN, dimension, power)
        one, other = base.run, exponent.run
        return self._made(
            dimension, lambda values: self._raised(one(values), other(values), column), base, exponent
        )

    def _raised(self, base: Number, exponent: Number, column: int) -> Number:
        if isinstance(exponent, Fraction) and exponent.denominator == 1 and abs(exponent) <= _MOST_POWER:
            if base == 0 and exponent < 0:
                raise self.error("division by zero", column)
            return _bounded(base ** int(exponent))
        try:
            return math.pow(base, exponent)
        except (ValueError, OverflowError) as error:
            raise self.error("the power has no finite value", column) from error

    def called(self, token: Token, arguments: Sequence[_Part]) -> _Part:
        name = token.text
        if name == "pow":
            return self._power(arguments[0], arguments[1], token.column)
        if name in _LIKE:
            arguments = self._alike(arguments[0], arguments[1], token.column, "given to " + name)
        first = arguments[0].dimension
        result = PLAIN
        if name in ("abs", "min", "max"):
            result = first
        elif name == "sqrt":
            result = product(PLAIN, first, Fraction(1, 2))
        elif name in ("atan2", "sign") or (name in _OF_ANGLES and first == ANGLE):
            result = ANGLE if name == "atan2" else PLAIN
        elif first != PLAIN:
            kind = "an angle or a plain number" if name in _OF_ANGLES else "a plain number"
            raise self.error(f"{name} takes {kind}, and this is {in_words(first)}", token.column)
        elif name in _TO_ANGLES:
            result = ANGLE
        return self._made(result, self._function(token, [each.run for each in arguments]), *arguments)

    def _function(self, token: Token, runs: Sequence[Run]) -> Run:
        name, value = token.text, FUNCTIONS[token.text].value
        if name in ("abs", "min", "max"):
            return lambda values: value(*(run(values) for run in runs))

        def run(values: Values) -> Number:
            given = [float(each(values)) for each in runs]
            try:
                return value(*given)
            except (ValueError, OverflowError) as error:
                said = ", ".join(f"{each:g}" for each in given)
                raise self.error(f"{name}({said}) has no finite value", token.column) from error

        return run

    def _made(self, dimension: Dimension, run: Run, *parts: _Part) -> _Part:
        """Computed now where nothing in it has a name."""
        if all(part.is_written for part in parts):
            return _Part(dimension, _always(run({})), dimension == PLAIN)
        return _Part(dimension, run)


def _run_of(sign: str, one: Run, other: Run, reader: _Typed, column: int) -> Run:
    if sign != "/":
        apply = ARITHMETIC[sign]
        return lambda values: _bounded(apply(one(values), other(values)))

    def run(values: Values) -> Number:
        divisor = other(values)
        if divisor == 0:
            raise reader.error("division by zero", column)
        return _bounded(one(values) / divisor)

    return run


def _bounded(value: Number) -> Number:
    if isinstance(value, Fraction):
        largest = max(value.denominator.bit_length(), value.numerator.bit_length())
        return float(value) if largest > _MOST_BITS else value
    return value


def _always(value: Number) -> Run:
    return lambda _: value


def _constant(value: Number, dimension: Dimension) -> _Part:
    return _Part(dimension, _always(value))


def _written(value: Number) -> _Part:
    return _Part(PLAIN, _always(value), True)

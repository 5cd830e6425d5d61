"""Numbers of a file that are expressions in its parameters, for one set of values.

In: `Parameters`, their values, texts. Out: numbers in SI; and which parameters something follows from. It is what
`lamc.basics.quantity_fields` calls `Expressions`.
"""

from collections.abc import Mapping

from lamc.basics.dimensions import PLAIN, Dimension, dimension_of, in_words, product, unit_text
from lamc.basics.errors import DesignError, ExpressionError
from lamc.basics.units import Quantity, to_si
from lamc.readers.parameters import Parameters, as_float, with_hint
from lamc.symbolic.formula import ANGLE, LENGTH, Number, exact, names_of
from lamc.symbolic.grammar import tokens_of

_OF_DRIVES = ("t", "angle", "rate")  # in expressions of effects they mean the time, and what a joint does
_DEGREES = 57.29577951308232  # in a radian


class Numbers:
    """used: names of parameters that expressions asked for have held; read: how many such expressions were read."""

    def __init__(self, parameters: Parameters, given: Mapping[str, float]) -> None:
        """Raises DesignError where a parameter has no value, or one out of bounds."""
        self.parameters = parameters
        self.values = parameters.values(given)
        self.used: set[str] = set()
        self.read = 0

    def takes(self, text: str) -> bool:
        return self.parameters.takes(text)

    def number(self, text: str, kind: Quantity, bare_unit: str | None) -> float:
        value, dimension = self._value(text)
        expected = dimension_of(kind.unit)
        if dimension == PLAIN != expected:
            scale = exact(to_si(1.0, kind, bare_unit)) if expected == LENGTH and bare_unit else 1
            return as_float(value * scale, f"the {kind.name}")
        if dimension != expected:
            raise DesignError(f"{text!r} is {in_words(dimension)}; {_expected(kind, dimension)}")
        return as_float(value * _DEGREES if kind.unit == "deg" else value, f"the {kind.name}")

    def measured(self, text: str) -> tuple[float, str]:
        """A number of any kind, and its SI unit. Raises DesignError."""
        value, dimension = self._value(text)
        return as_float(value, "it"), unit_text(dimension)

    def _value(self, text: str) -> tuple[Number, Dimension]:
        try:
            formula = self.parameters.expression(text)
            self.used.update(formula.names)
            self.read += 1
            return formula.value(self.values), formula.dimension
        except ExpressionError as error:
            raise ExpressionError(with_hint(error.message, text)) from error

    def in_drive(self, text: str) -> str | None:
        try:
            names = names_of(text)
        except ExpressionError:  # told by the effect
            return text
        own = {name for name in names if name in self.values and name not in _OF_DRIVES}
        if not own:
            return text
        if own == set(names):
            return None
        self.used |= own
        self.read += 1
        return _replaced(text, {name: float(self.values[name]) for name in own})


def _expected(kind: Quantity, dimension: Dimension) -> str:
    unit = dimension_of(kind.unit)
    said = f"the {kind.name} is expected " + (f"in {unit_text(unit)}" if unit else "without a unit")
    for power, way_out in ((1, "divide by 1 rad"), (-1, "multiply by 1 rad")):
        if product(unit, ANGLE, power) == dimension:
            return f"{said}: {way_out}"
    return said


def _replaced(text: str, values: Mapping[str, float]) -> str:
    """The expression with numbers in the place of names."""
    parts, end = [], 0
    for token in tokens_of(text):
        if token.kind == "name" and token.text in values:
            value, start = values[token.text], token.column - 1
            parts += [text[end:start], repr(value) if value >= 0.0 else f"({value!r})"]
            end = start + len(token.text)
    return "".join([*parts, text[end:]])

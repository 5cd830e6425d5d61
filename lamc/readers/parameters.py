"""The parameters of a native design, and the expressions in them.

In: what the file declares, in an order in which each needs only those before it. Out: values for values, formulas for
texts. Never: reads a node; evaluates anything by Python.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from lamc.basics.dimensions import Dimension, dimension_of, unit_text
from lamc.basics.errors import DesignError, ExpressionError, Place
from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.si_units import measured
from lamc.basics.units import LARGEST, LENGTH, is_quantity, to_si
from lamc.readers.checking import QUOTE
from lamc.records.parameters import DesignParameter, check_bounds
from lamc.symbolic.formula import Formula, Number, constant, exact, formula, names_of

SECTION = "parameters"
_WORD = re.compile(r"[A-Za-z_]\w*")


@dataclass(frozen=True)
class Declared:
    """A parameter as its file says it.

    text    of its default: a number, with or without a unit, or an expression in other parameters
    bounds  lowest and highest value, SI
    place, of_name  where its value stands, and its name
    """

    name: str
    text: str
    place: Place
    of_name: Place
    bounds: tuple[float | None, float | None] = (None, None)
    meaning: str = ""


@dataclass(frozen=True, eq=False)
class Parameters:
    """The parameters of one file, and the expressions in them that were read.

    declared  in an order in which each needs only those before it
    listed    their names as the file has them
    bare      the unit of lengths that are written without one; None: m
    """

    declared: tuple[Declared, ...] = ()
    listed: tuple[str, ...] = ()
    bare: str | None = None

    def __getstate__(self) -> dict[str, object]:
        """Without formulas, which are made of functions: they are read again when they are needed."""
        return {name: self.__dict__[name] for name in ("declared", "listed", "bare")}

    @cached_property
    def by_name(self) -> Mapping[str, Declared]:
        return {each.name: each for each in self.declared}

    @cached_property
    def formulas(self) -> Mapping[str, Formula]:
        """Of the defaults. Raises ExpressionError."""
        made: dict[str, Formula] = {}
        for each in self.declared:
            known = {name: of.dimension for name, of in made.items()}
            made[each.name] = default_formula(each.text, known, self.length)
        return made

    @cached_property
    def dimensions(self) -> Mapping[str, Dimension]:
        return {name: each.dimension for name, each in self.formulas.items()}

    @cached_property
    def length(self) -> Fraction:
        """How many m a length of 1 without a unit is."""
        return exact(to_si(1.0, LENGTH, self.bare))

    @cached_property
    def _expressions(self) -> dict[str, Formula]:
        return {}

    @cached_property
    def _taken(self) -> dict[str, bool]:
        return {}

    def expression(self, text: str) -> Formula:
        """An expression of the file, read once. Raises ExpressionError."""
        found = self._expressions.get(text)
        if found is None:
            found = self._expressions[text] = formula(text, self.dimensions, self.length)
        return found

    def takes(self, text: str) -> bool:
        """Whether a text that stands for a number is an expression. Without parameters only sums and the like of
        numbers are: of other texts whoever reads the number says what is wrong."""
        found = self._taken.get(text)
        if found is None:
            found = self._taken[text] = self._is_expression(text)
        return found

    def _is_expression(self, text: str) -> bool:
        if is_quantity(text) and not any(word in self.by_name for word in _WORD.findall(text)):
            return False
        if self.declared:
            return True
        try:
            return not names_of(text) and any(sign in text for sign in "+-*/^(")
        except ExpressionError:
            return False

    def values(self, given: Mapping[str, float]) -> dict[str, Number]:
        """Of all, SI; given ones take the place of defaults. Raises DesignErrors, with places, for those that have no
        finite value, or one out of bounds."""
        values: dict[str, Number] = {}
        for each in self.declared:
            try:
                if each.name in given:
                    values[each.name] = exact(given[each.name])
                else:
                    values[each.name] = self.formulas[each.name].value(values)
                number = as_float(values[each.name], "its value")
                if each.bounds != (None, None):
                    unit = unit_text(self.dimensions[each.name])
                    check_bounds(number, each.bounds, unit, f"parameter {each.name!r}")
            except DesignError as error:
                raise type(error)(f"{SECTION}.{each.name}: {error.message}", each.place) from error
        return values

    def records(self, values: Mapping[str, Number]) -> Mapping[str, DesignParameter]:
        """As users see them, in the file's order."""
        each = self.by_name
        return ReadOnlyDict(
            {
                name: DesignParameter(
                    float(values[name]),
                    unit_text(self.dimensions[name]),
                    *each[name].bounds,
                    each[name].meaning,
                )
                for name in self.listed
            }
        )

    def needed_by(self, names: Iterable[str]) -> set[str]:
        """The names, and all that their defaults follow from."""
        found = set(names)
        for each in reversed(self.declared):
            if each.name in found:
                found.update(self.formulas[each.name].names)
        return found


NO_PARAMETERS = Parameters()


def default_formula(text: str, known: Mapping[str, Dimension], length: Fraction) -> Formula:
    """The default of a parameter: a number with a unit, or an expression. Raises ExpressionError, and DesignError for a
    unit that is none."""
    if is_quantity(text) and not any(word in known for word in _WORD.findall(text)):
        value, unit = measured(text)
        return constant(text, exact(value), dimension_of(unit))
    return formula(text, known, length)


def as_float(value: Number, what: str) -> float:
    """Raises DesignError for what is larger than any number of a design."""
    number = float(value)  # of what is finite
    if not abs(number) < LARGEST:
        raise DesignError(
            f"{what} is {number:g}, which is {LARGEST:g} or more in SI; no design has such a number"
        )
    return number


def with_hint(message: str, text: str) -> str:
    """With the usual cause of half an expression: a comma in a list of YAML."""
    if text.count("(") != text.count(")"):
        return f"{message}; {QUOTE}"
    return message

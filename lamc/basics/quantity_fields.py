"""Fields that hold quantities with units, as pydantic validates them.

    stiffness: Annotated[float, Unit("N*m/rad", "of the stop", gt=0.0)]

In: numbers, text with a unit, expressions, alone or in lists and maps. Out: floats in SI, tuples, read-only maps, and
JSON Schema that says the unit. What is refused is told by the part at fault.
"""

import numbers
import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from types import NoneType
from typing import Annotated, Any, Literal, Protocol, get_args, get_origin

import numpy as np
from pydantic import GetCoreSchemaHandler, PlainValidator, ValidationInfo, WithJsonSchema
from pydantic_core import CoreSchema

from lamc.basics import units
from lamc.basics.checks import checked_name, is_list, shown
from lamc.basics.errors import DesignError
from lamc.basics.fields import EXPRESSIONS, LENGTH_UNIT, MEANING, RULES, UNIT, custom, part
from lamc.basics.number_text import is_measured
from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.units import Quantity, to_si

Path = tuple[str | int, ...]


class Expressions(Protocol):
    """Reads numbers that stand in a file as expressions in its parameters."""

    def takes(self, text: str) -> bool:
        """False for a number, with a unit or without, and for what is no expression."""

    def number(self, text: str, kind: Quantity, bare_unit: str | None) -> float:
        """The value in SI; one without a dimension counts as a number without a unit does. Raises DesignError."""

    def in_drive(self, text: str) -> str | None:
        """An expression that is evaluated as a model runs, with values for its parameters; None where it is the
        parameters' alone, and so a number. Raises DesignError."""


@lru_cache(maxsize=1024)
def _quantity(name: str, unit: str) -> Quantity:
    """A kind of number that has the name of its field."""
    return Quantity(name, unit, units.EXAMPLES.get(unit) or f"0.5 {unit}".rstrip())


@dataclass(frozen=True)
class Unit:
    """Says of a field that its numbers have a unit: as they are, in tuples, or in maps by name, as its type has it.

    unit         SI, as in "N*m/rad"; "1" for a plain number; or a Quantity, which has a name of its own for messages
    description  what the field is, for people
    gt, ge, lt, le  bounds of each number

    A number is SI, or a length in the context's unit; text has its unit ("3 N*mm/deg"). Where the type has `str` too,
    text that is no number with a unit passes as it is: an expression.
    """

    unit: str | Quantity
    description: str = ""
    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        read = partial(self._validated, source)
        return handler.generate_schema(
            Annotated[Any, PlainValidator(read), WithJsonSchema(self._described(source))]
        )

    def number(self, value: object, name: str, context: Mapping[str, Any] | None = None) -> float:
        """`value` in SI. Raises DesignError for what is no finite number, out of bounds, or of another dimension."""
        if not isinstance(value, int | float | str):
            value = value.item() if isinstance(value, np.generic) else value
            value = (
                float(value) if isinstance(value, numbers.Rational) and not isinstance(value, int) else value
            )
        plain = self.si
        kind = self.unit if isinstance(self.unit, Quantity) else _quantity(name, plain)
        context = context or {}
        bare = context.get(LENGTH_UNIT) if plain == "m" else None
        expressions: Expressions | None = context.get(EXPRESSIONS)
        if expressions is not None and isinstance(value, str) and expressions.takes(value):
            number = expressions.number(value, kind, bare) + 0.0
        else:
            number = to_si(value, kind, bare) + 0.0
        for rule, bound in self._bounds:
            if not getattr(operator, rule)(number, bound):
                words = RULES[rule]
                reported = f"the {kind.name} is {number:g} {plain}".rstrip()
                raise DesignError(f"{reported}; it must be {words} {bound:g}")
        return number

    @cached_property
    def si(self) -> str:
        """The unit, empty for a plain number."""
        unit = self.unit.unit if isinstance(self.unit, Quantity) else self.unit
        return "" if unit == "1" else unit

    @cached_property
    def _bounds(self) -> tuple[tuple[str, float], ...]:
        """Those that there are, by their rules."""
        found = ((rule, getattr(self, rule)) for rule in RULES)
        return tuple((rule, bound) for rule, bound in found if bound is not None)

    def _validated(self, kind: Any, value: Any, info: ValidationInfo) -> Any:
        name, context = info.field_name or "value", info.context or {}
        if kind is not float:
            return self._read(kind, value, (name,), context)
        try:  # as `_read`, sooner: designs have thousands of coordinates
            return self.number(value, name.replace("_", " "), context)
        except DesignError as error:
            raise custom(error) from error

    def _read(self, kind: Any, value: Any, path: Path, context: Mapping[str, Any]) -> Any:
        """`value` as the type `kind` has it; path: the field's name, and where in it the value stands."""
        forms = _forms(kind)
        if isinstance(value, np.ndarray):
            value = value.tolist()
        if value is None and NoneType in forms:
            return None
        for form in forms:
            origin, inner = _origin(form), get_args(form)
            if origin is tuple and is_list(value):
                return self._tuple(inner, value, path, context)
            if origin is Mapping and isinstance(value, Mapping):
                return self._map(inner[1], value, path, context)
            if origin is Literal and value in inner:
                return value
            if form is str and isinstance(value, str) and not is_measured(value):
                expressions = context.get(EXPRESSIONS)
                drive = value if expressions is None else expressions.in_drive(value)
                if drive is not None:
                    return drive
        with part(*path[1:]):
            if float not in forms:
                asked = ", or ".join(self._asked(form) for form in forms if form is not NoneType)
                left = ", or leave it out" if NoneType in forms else ""
                raise DesignError(f"{_called(path)} is {shown(value)}; give {asked}{left}")
            return self.number(value, _called(path), context)

    def _tuple(
        self, inner: tuple[Any, ...], value: Sequence[Any], path: Path, context: Mapping[str, Any]
    ) -> tuple[Any, ...]:
        if Ellipsis not in inner and len(value) != len(inner):
            with part(*path[1:]):
                raise DesignError(f"{_called(path)} is {shown(value)}; it must hold {len(inner)} numbers")
        kinds = [inner[0]] * len(value) if Ellipsis in inner else inner
        return tuple(
            self._read(kind, each, (*path, k), context)
            for k, (kind, each) in enumerate(zip(kinds, value, strict=True))
        )

    def _map(self, kind: Any, value: Mapping[Any, Any], path: Path, context: Mapping[str, Any]) -> Any:
        found = {}
        for name, each in sorted(value.items(), key=lambda item: str(item[0])):
            with part(*path[1:]):
                checked_name(name, f"an entry of {_called(path)}")
            found[name] = self._read(kind, each, (*path, name), context)
        return ReadOnlyDict(found)

    def _asked(self, form: Any) -> str:
        """What a type asks people for."""
        origin, inner = _origin(form), get_args(form)
        many = f"numbers ({self.si or 'plain'})"
        if origin is Literal:
            return " or ".join(map(repr, inner))
        if origin is Mapping:
            return f"a map from names to {'lists' if _origin(inner[1]) is tuple else many}"
        if origin is tuple:
            count = "" if Ellipsis in inner else f"{len(inner)} "
            return f"a list of {count}{'lists' if _origin(inner[0]) is tuple else many}"
        return "text" if form is str else f"a number ({self.si or 'plain'})"

    def _described(self, kind: Any) -> dict[str, Any]:
        """JSON Schema of the type `kind`, with the unit in words."""
        said = self._schema(kind)
        words = "; ".join(text for text in (self.description, said.get("description")) if text)
        meaning = {MEANING: self.description} if self.description else {}
        return {**said, "description": words, **meaning} if words else said

    def _schema(self, kind: Any) -> dict[str, Any]:
        forms = [form for form in _forms(kind) if form is not str or float not in _forms(kind)]
        if len(forms) > 1:
            return {"anyOf": [self._schema(form) for form in forms]}
        (form,) = forms
        origin, inner = _origin(form), get_args(form)
        if form is float:
            bare = "the file's units" if self.si == "m" else self.si or "plain"
            words = f"a number ({bare}), or text with a unit"
            if isinstance(self.unit, Quantity):
                words = f"{self.unit.name}, {words} such as {self.unit.example!r}"
            words += ", or an expression" if str in _forms(kind) else ""
            bounds = {
                "exclusiveMinimum": self.gt,
                "minimum": self.ge,
                "exclusiveMaximum": self.lt,
                "maximum": self.le,
            }
            said = {key: bound for key, bound in bounds.items() if bound is not None}
            return {"type": ["number", "string"], "description": words, UNIT: self.si or "1", **said}
        if origin is Literal:
            return {"enum": list(inner)}
        if origin is Mapping:
            return {"type": "object", "additionalProperties": self._schema(inner[1])}
        if origin is tuple:
            fixed = {} if Ellipsis in inner else {"minItems": len(inner), "maxItems": len(inner)}
            return {"type": "array", "items": self._schema(inner[0]), **fixed}
        return {"type": {NoneType: "null", str: "string"}[form]}


def _forms(kind: Any) -> tuple[Any, ...]:
    """The types of a union, or the only one."""
    origin = get_origin(kind)
    if origin is Annotated:
        return _forms(get_args(kind)[0])
    plain = (
        origin is None
        or origin is Literal
        or (isinstance(origin, type) and issubclass(origin, Mapping | tuple))
    )
    return (kind,) if plain else get_args(kind)


def _origin(form: Any) -> Any:
    origin = get_origin(form)
    return Mapping if isinstance(origin, type) and issubclass(origin, Mapping) else origin


def _called(path: Path) -> str:
    """A value by its field, and in a map by its name: "stiffness", "torque of 'knee'"."""
    field, *names = (step for step in path if isinstance(step, str))
    if names and field.endswith("s") and not field.endswith("ss"):
        field = field[:-1]
    return field.replace("_", " ") + "".join(f" of {name!r}" for name in names)

"""Fields of records that people fill in, as pydantic validates them: quantities with units, names, flags.

    stiffness: Annotated[float, Unit("N*m/rad", "of the stop", gt=0.0)]

In: plain values from a file or from Python. Out: floats in SI, tuples, read-only maps. What is refused is told by the
part at fault. The context of a validation (`info.context`) may have LENGTH_UNIT, the unit of lengths that are written
bare, FOLDER, from which the names of files count, and EXPRESSIONS, which reads numbers that are written as expressions.
"""

import numbers
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from types import NoneType
from typing import Annotated, Any, Literal, Protocol, TypeVar, get_args, get_origin

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    GetCoreSchemaHandler,
    PlainValidator,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
)
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError

from lamc.basics import units
from lamc.basics.checks import checked_flag, checked_name, did_you_mean, is_list, shown
from lamc.basics.errors import DesignError, LamcError
from lamc.basics.number_text import is_measured
from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.units import Quantity, to_si

M = TypeVar("M", bound=BaseModel)

LENGTH_UNIT = "length_unit"
FOLDER = "folder"
EXPRESSIONS = "expressions"
UNIT = "x-unit"  # of numbers, in JSON Schema: SI, "1" for a plain number
MEANING = "x-meaning"  # of a field, in JSON Schema: its description without words about its form

_PLAIN_WORDS = {  # pydantic speaks of Python's types; people who write files know lists and maps
    "tuple_type": "a list of values is expected here",
    "list_type": "a list of values is expected here",
    "dict_type": "a map of keys and values is expected here",
    "model_type": "a map of keys and values is expected here",
    "string_type": "a text is expected here",
    "bool_type": "true or false is expected here",
    "bool_parsing": "true or false is expected here",
}
_RULES = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}
Path = tuple[str | int, ...]


class StrictModel(BaseModel):
    """Base of all models: unknown keys are errors, and nothing changes after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)


def custom(error: LamcError) -> PydanticCustomError:
    """A LamcError in pydantic's own clothing; its text is the whole message."""
    return PydanticCustomError("lamc", "{text}", {"text": error.message, "error": error})


@contextmanager
def part(*path: str | int) -> Iterator[None]:
    """DesignErrors of the block are pydantic's, about the part at `path` within the value that is validated."""
    try:
        yield
    except DesignError as error:
        line = InitErrorDetails(type=custom(error), loc=path, input=None)
        raise ValidationError.from_exception_data("part", [line]) from error


def inner(model: type[M], data: Any, info: ValidationInfo) -> M:
    """`data` as a model within another; what is no map of its fields is reported with the nearest name."""
    known = list(model.model_fields)
    with part():
        if not isinstance(data, Mapping):
            raise DesignError(f"it is {shown(data)}; give a map of {', '.join(known)}")
    for name in data:
        with part(str(name)[:40]):
            if name not in known:
                raise DesignError(f"no field {str(name)[:40]!r}; {did_you_mean(str(name), known)}")
    return model.model_validate(dict(data), context=info.context)


def problem_text(item: Any) -> str:
    """An entry of pydantic's `errors()` in plain words."""
    text = str(item["msg"]).removeprefix("Value error, ")
    if item["type"] == "lamc":
        return text
    if item["type"] == "missing":
        return "this key is missing, and it is required"
    given = shown(item["input"])
    for rule, words in _RULES.items():
        if rule in item.get("ctx", ()):
            return f"it is {given}; it must be {words} {item['ctx'][rule]:g}"
    text = _PLAIN_WORDS.get(item["type"], text)
    return f"{text[0].lower()}{text[1:]}, and it is {given if len(given) <= 40 else given[:39] + '…'}"


def unit_in(schema: Any) -> str:
    """The unit of the numbers in a field's JSON Schema: of one, of a list or a map, whatever its depth; "" for none."""
    if isinstance(schema, Mapping):
        if UNIT in schema:
            return str(schema[UNIT])
        inner = [schema.get("items"), schema.get("additionalProperties"), schema.get("prefixItems")]
        return next(
            (
                unit
                for unit in map(unit_in, [*inner, *schema.get("anyOf", ()), *schema.get("oneOf", ())])
                if unit
            ),
            "",
        )
    if isinstance(schema, list):
        return next((unit for unit in map(unit_in, schema) if unit), "")
    return ""


def with_unit(schema: Mapping[str, Any]) -> dict[str, Any]:
    """A field whose description says its unit, for editors, which show nothing else."""
    unit, said = unit_in(schema), str(schema.get("description", ""))
    if unit in ("", "1") or "a number (" in said or ": a number" in said:
        return dict(schema)
    bare = "the file's units" if unit == "m" else unit
    words = f"a number ({bare}), or text with a unit"
    return {
        **schema,
        "description": f"{said}; {words}" if said else words,
        MEANING: schema.get(MEANING, said),
    }


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
                words = _RULES[rule]
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
        found = ((rule, getattr(self, rule)) for rule in _RULES)
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
    """A value by its field, and in a map by its name."""
    field, *names = (step for step in path if isinstance(step, str))
    return field.replace("_", " ") + "".join(f" of {name!r}" for name in names)


def checked(check: Callable[[Any, str], Any]) -> BeforeValidator:
    """A check of `lamc.basics.checks`, or one like it: of a value and what to call it."""

    def read(value: Any, info: ValidationInfo) -> Any:
        with part():
            return check(value, (info.field_name or "value").replace("_", " "))

    return BeforeValidator(read)


def _names(value: Any, what: str) -> tuple[str, ...]:
    if not is_list(value) or not len(value):
        raise DesignError(f"{what} are {shown(value)}; give a list of names, or leave it out")
    names = tuple(checked_name(name, f"an entry of {what}") for name in value)
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise DesignError(f"{what} have {twice!r} twice; once is enough")
    return names


def _names_in_a_row(value: Any, what: str) -> tuple[str, ...]:
    if not is_list(value) or not len(value):
        raise DesignError(f"{what} are {shown(value)}; give a list of names")
    return tuple(checked_name(name, f"an entry of {what}") for name in value)


def _whole(value: Any, what: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise DesignError(f"{what} is {shown(value)}; it must be a whole number")
    return value


Name = Annotated[str, checked(checked_name)]
Names = Annotated[tuple[str, ...], checked(_names)]  # none twice
NamesInARow = Annotated[tuple[str, ...], checked(_names_in_a_row)]  # one may stand there again
Flag = Annotated[bool, checked(checked_flag)]
Whole = Annotated[int, checked(_whole)]
Vector = tuple[float, float, float]

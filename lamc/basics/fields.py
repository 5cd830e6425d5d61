"""Records that people fill in, as pydantic validates them: their base, names and flags, and what errors say.

In: plain values from a file or from Python. Out: records that do not change. What is refused is told by the part at
fault. The context of a validation (`info.context`) may have LENGTH_UNIT, the unit of lengths that are written bare,
FOLDER, from which the names of files count, and EXPRESSIONS, which reads numbers that are written as expressions.
Quantities with units: `lamc.basics.quantity_fields`.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Annotated, Any, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    ValidationError,
    ValidationInfo,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

from lamc.basics.brief import counted
from lamc.basics.checks import checked_flag, checked_name, did_you_mean, is_list, shown
from lamc.basics.errors import DesignError, LamcError

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
_COUNTS = {"too_long": ("at most", "max_length"), "too_short": ("no fewer than", "min_length")}
RULES = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}


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
    if item["type"] in _COUNTS:
        least_or_most, key = _COUNTS[item["type"]]
        return f"{least_or_most} {counted(item['ctx'][key], 'value')} may stand here, and it is {given[:60]}"
    for rule, words in RULES.items():
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

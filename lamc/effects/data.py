"""From the plain data of a scene file to the values of an effect: numbers with units, records field by field.

In: what a YAML file holds under an effect's name, and where it stands. Out: SI floats, or the effect itself. Every
refusal is a `DataError` that knows which part of the data it is about, so that readers of files can point at it.
Never: knows an effect by name.

An effect says the units of its fields once, and has nothing else to do:

    units: ClassVar[Mapping[str, str]] = {"stiffness": "N*m/rad", "point": "m"}

    @classmethod
    def from_data(cls, value, where):
        return record(cls, value, where)

A field of `units` may then be a number (SI), text with a unit ("3 N*mm/deg"), or a list or map of such. `shorthand`, a
class variable too, names the field that may be given alone, as in `gravity: [0, 0, -9.81]`. `lamc schema` tells both.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, Field, fields
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from lamc.basics import units as kinds
from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import DesignError
from lamc.basics.units import Quantity, to_si

E = TypeVar("E")

# No expression begins with a number and goes on with a unit: "3 N*mm" is a quantity, "3*sin(t)" is none.
_MEASURED = re.compile(
    r"\s*[-+]?(?:\.[0-9]++|[0-9]++(?:\.[0-9]*+)?+)(?:[eE][-+]?[0-9]++)?+\s*[A-Za-zµμ°(]", re.ASCII
)
_KNOWN = {
    quantity.unit: quantity.example
    for quantity in vars(kinds).values()
    if isinstance(quantity, Quantity) and quantity.unit
}


class Where(str):
    """The place of an effect's data in a file, for messages, the unit of lengths that are written bare there, and the
    folder from which the names of files count (None: the current one)."""

    length_unit: str | None
    folder: Path | None

    def __new__(cls, text: str, length_unit: str | None = None, folder: Path | None = None) -> "Where":
        where = super().__new__(cls, text)
        where.length_unit = length_unit
        where.folder = folder
        return where


class DataError(DesignError):
    """An effect's data does not fit.

    problem  the message without the place
    path     of the part that does not fit, from the effect's data on
    """

    problem: str = ""
    path: tuple[str | int, ...] = ()


def refusal(where: str, problem: str, *path: str | int) -> DataError:
    """The error to raise for data that does not fit, at `path` within it."""
    place = where + "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    error = DataError(f"{place}: {problem}")
    error.problem, error.path = problem, path
    return error


def quantity(value: object, unit: str, where: str, *path: str | int) -> float:
    """`value` in SI: a number, or text such as "3 N*mm/deg".

    unit   of the field, SI, as in "N*m/rad" or "N·m/rad"; "" or "1" for a plain number
    where  the place, as `from_data` is given it
    path   of the value within the effect's data, as in ("stiffness",), for the message

    Raises DataError for what is no number, not finite, or of another dimension.
    """
    plain = unit.replace("·", "*").replace("²", "^2").replace("³", "^3")
    plain = "" if plain == "1" else plain
    words = [step for step in path if isinstance(step, str) and step.strip()]
    name = words[-1].replace("_", " ") if words else "value"
    kind = Quantity(name, plain, _KNOWN.get(plain) or f"0.5 {plain}".rstrip())
    bare = getattr(where, "length_unit", None) if plain == "m" else None
    try:
        return to_si(value, kind, bare)
    except DesignError as error:
        raise refusal(where, error.message, *path) from error


def is_measured(text: str) -> bool:
    """True for a number with a unit, which no expression looks like."""
    return _MEASURED.match(text) is not None


def record(kind: type[E], value: object, where: str) -> E:
    """The effect of class `kind`, a frozen dataclass, from a map of its fields; nothing stands for all defaults, and a
    value that is no map for the field `kind.shorthand`.

    Fields named in `kind.units` are read by `quantity`, as they are or in lists and maps. In a field that also holds
    text, an expression, text goes through as it is, unless it is a number with a unit; so do all other fields.

    Raises DataError for an unknown field (with the nearest name), one that is missing, and a quantity that is none.
    """
    known: dict[str, Field[Any]] = {f.name: f for f in fields(kind)}  # type: ignore[arg-type]
    label = getattr(kind, "name", kind.__name__)
    if value is None or value is True:
        value = {}
    short: str | None = getattr(kind, "shorthand", None)
    if short is not None and isinstance(value, str | int | float | list | tuple):
        value = {short: value}
    needed = [f.name for f in known.values() if f.default is MISSING and f.default_factory is MISSING]
    if not isinstance(value, Mapping):
        raise refusal(
            where, f"{label} is {shown(value)}; give a map of its fields: {_listed(list(known), needed)}"
        )
    for name in value:
        if name not in known:
            raise refusal(
                where,
                f"{label} has no field {str(name)[:40]!r}; {did_you_mean(str(name), list(known))}",
                str(name)[:40],
            )
    missing = [name for name in needed if name not in value]
    if missing:
        raise refusal(where, f"{label} needs {' and '.join(missing)}: give {_listed(list(known), needed)}")
    units: Mapping[str, str] = getattr(kind, "units", {})
    hints = get_type_hints(kind) if units else {}
    data = {
        name: _si(each, units[name], where, (name,), text=takes_text(hints[name])) if name in units else each
        for name, each in value.items()
    }
    return kind(**data)


def takes_text(hint: Any) -> bool:
    """True if a field of this annotation holds text, such as expressions, as it is or in a list or map."""
    inner = get_args(hint)
    if hint is str or (get_origin(hint) is Literal and any(isinstance(word, str) for word in inner)):
        return True
    if isinstance(get_origin(hint), type) and issubclass(get_origin(hint), Mapping):
        inner = inner[1:]  # keys are names
    return any(takes_text(part) for part in inner)


def _si(value: object, unit: str, where: str, path: tuple[str | int, ...], *, text: bool) -> object:
    if value is None or (text and isinstance(value, str) and not is_measured(value)):
        return value
    if isinstance(value, Mapping):
        return {str(k): _si(v, unit, where, (*path, str(k)), text=text) for k, v in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return tuple(_si(v, unit, where, (*path, k), text=text) for k, v in enumerate(value))
    return quantity(value, unit, where, *path)


def _listed(known: list[str], needed: list[str]) -> str:
    optional = [name for name in known if name not in needed]
    if not needed:
        return f"{', '.join(optional)}, as many as wished" if optional else "it has none"
    return ", ".join(needed) + (f", and {', '.join(optional)} if wished" if optional else "")

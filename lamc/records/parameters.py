"""Dimensions by name: `DesignParameter`s, and records that may be made again with others.

In: numbers, or text with units, by name. Out: a new record; the old one stays. What a record is made of again is its
`Recipe`, which whoever made it knows: a reader of a file, or a function of the user's.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Protocol, Self, TypeVar

from lamc.basics.brief import brief
from lamc.basics.checks import checked_number, did_you_mean, shown
from lamc.basics.drawing import drawer, registered
from lamc.basics.errors import DesignError, Place
from lamc.basics.given import GivenMaybe, GivenNumber
from lamc.basics.readonly import ReadOnlyDict
from lamc.basics.si_units import in_unit, measured, si_unit

V = TypeVar("V", bound="Varied")


@dataclass(frozen=True)
class DesignParameter:
    """A dimension of a design, or another number that its drawing follows from.

    default  its value until set otherwise, in `unit`; or text with its own, "40 mm"
    unit     SI, such as "m"; "1" for a plain number
    minimum, maximum  bounds that it keeps, in `unit`, or text; None: none
    meaning  what it is, in a few words

    Raises DesignError for what are no finite numbers of one unit, for a unit that is not SI, and for a default that is
    out of bounds.
    """

    default: GivenNumber = 0.0  # type: ignore[assignment]
    unit: str = "1"
    minimum: GivenMaybe = None  # type: ignore[assignment]
    maximum: GivenMaybe = None  # type: ignore[assignment]
    meaning: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.unit, str) or not isinstance(self.meaning, str):
            raise DesignError(
                f"a parameter has unit {shown(self.unit)} and meaning {shown(self.meaning)}; both must be text"
            )
        unit = si_unit(self.unit)
        if unit.factor != 1.0:
            raise DesignError(
                f"the unit of a parameter is {self.unit!r}; parameters are in SI units: give {unit.text!r}, and the "
                f"numbers times {unit.factor:g}, or each as text with its unit"
            )
        said: float | str = self.default
        own = unit.text if unit.text != "1" or not isinstance(said, str) else measured(said)[1]
        object.__setattr__(self, "unit", own)
        object.__setattr__(self, "meaning", " ".join(self.meaning.split()))
        for name in ("default", "minimum", "maximum"):
            value = getattr(self, name)
            if value is not None or name == "default":
                object.__setattr__(self, name, self.number(value, f"the {name} of a parameter"))
        self.check(self.default, "the default of a parameter")

    def __repr__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        low, high = _given(self.minimum, ">= "), _given(self.maximum, "<= ")
        return brief("DesignParameter", "", f"{self.default:.6g}{unit}", low, high, self.meaning[:40])

    def number(self, value: object, what: str) -> float:
        """`value` in `unit`. Raises DesignError for what is no finite number of it."""
        if isinstance(value, str):
            try:
                return in_unit(value, self.unit, what)
            except DesignError as error:
                raise DesignError(f"{what} is {shown(value)}; {error.message}") from error
        return checked_number(value, what)

    def check(self, value: float, what: str) -> None:
        """Raises DesignError for a value out of bounds."""
        check_bounds(value, (self.minimum, self.maximum), self.unit, what)


def check_bounds(value: float, bounds: tuple[float | None, float | None], unit: str, what: str) -> None:
    """Raises DesignError for a value below the first bound or above the second."""
    for bound, side, rule in zip(bounds, (1.0, -1.0), ("at least", "at most"), strict=True):
        if bound is not None and side * value < side * bound:
            unit = "" if unit == "1" else f" {unit}"
            raise DesignError(f"{what} is {value:.9g}{unit}; it must be {rule} {bound:.9g}{unit}")


def _given(bound: float | None, rule: str) -> str:
    return "" if bound is None else f"{rule}{bound:.6g}"


class Recipe(Protocol):
    """What a record is made of. It does not change, and it can be pickled where the record can."""

    @property
    def parameters(self) -> Mapping[str, DesignParameter]:
        """By name, each with the value that it has in the record as its default."""

    @property
    def given(self) -> Mapping[str, float]:
        """Those values, SI, that were set: with them the record is made again to the last bit."""

    @property
    def listed(self) -> Mapping[str, DesignParameter]:
        """Those of which a summary of the record tells."""

    def made(self, values: Mapping[str, float]) -> Any:
        """The record with these values, checked, in the place of its own; the others stay."""

    def place(self, name: str) -> Place | None:
        """Where the parameter stands in its file; None where it is in none."""


@dataclass(frozen=True, eq=False)
class Origin:
    """Where a record comes from: its recipe, and the fields that this made, by name."""

    recipe: Recipe
    fields: Mapping[str, Any]


class Varied:
    """A record that is a function of its dimensions: `parameters`, and `with_parameters`."""

    origin: Origin | None
    _carried: ClassVar[
        tuple[str, ...]
    ] = ()  # fields that do not follow from parameters where users replace them

    @property
    def parameters(self) -> Mapping[str, DesignParameter]:
        """Dimensions by name, SI, each with its present value as its default."""
        return _recipe(self).parameters

    def with_parameters(
        self, values: Mapping[str, float | str] | None = None, /, **named: float | str
    ) -> Self:
        """The record with other values, SI or text with a unit: with_parameters(length=0.05), or of names that are no
        words of Python with_parameters({"carbon.thickness": "0.2 mm"}). A scene that was replaced by hand meanwhile
        stays (`dataclasses.replace`).

        Raises DesignError for a name that is none of its parameters (it names the nearest), for a value that is no
        finite number of its unit, or out of bounds, for a drawing that is impossible with them, and where parts that
        follow from parameters were replaced by hand.
        """
        recipe = _recipe(self)
        given = checked_values(recipe, values, named)
        replaced = _replaced(self) if given else {}
        made: Self = recipe.made(given) if given else self
        return replace(made, **replaced) if replaced else made  # type: ignore[type-var]


def with_origin(record: V, recipe: Recipe) -> V:
    """The record, which was just made by that recipe, with it."""
    known = {each.name: getattr(record, each.name) for each in fields(record) if each.name != "origin"}  # type: ignore[arg-type]
    object.__setattr__(record, "origin", Origin(recipe, known))
    return record


class _Nothing:
    """The recipe of a record that has no parameters."""

    parameters: Mapping[str, DesignParameter] = ReadOnlyDict({})
    given: Mapping[str, float] = ReadOnlyDict({})
    listed = parameters

    def made(self, values: Mapping[str, float]) -> Any:
        raise AssertionError(values)

    def place(self, name: str) -> Place | None:
        return None


_NOTHING = _Nothing()


def _recipe(record: Varied) -> Recipe:
    """Its own, or that of a drawing as such."""
    if record.origin is not None:
        return record.origin.recipe
    place = (type(record).__name__, "vary")
    found: Recipe = drawer(*place)(record) if place in registered() else _NOTHING
    return found


def _replaced(record: Varied) -> dict[str, Any]:
    """Fields that are not those that its recipe made. Raises DesignError for one that follows from parameters."""
    made = record.origin.fields if record.origin is not None else {}
    values = {name: getattr(record, name) for name in made}
    found = {name: now for name, now in values.items() if now is not made[name] and now != made[name]}
    for name in found:
        if name not in record._carried:
            raise DesignError(
                f"{name} of {record!r} were replaced by hand, and follow from its parameters: call with_parameters "
                "first, and replace them after that"
            )
    return found


def checked_values(
    recipe: Recipe, values: object, named: Mapping[str, float | str] | None = None
) -> dict[str, float]:
    """Values by name, SI. Raises DesignError as `Varied.with_parameters` does."""
    if values is not None and not isinstance(values, Mapping):
        raise DesignError(f"the parameters are {shown(values)}; give them by name: {{'length': 0.05}}")
    known = recipe.parameters
    found = {}
    for name, value in {**(values or {}), **(named or {})}.items():
        if name not in known:
            raise unknown_parameter(name, known)
        what = f"parameter {name!r}"
        number = known[name].number(value, what)
        try:
            known[name].check(number, what)
        except DesignError as error:
            raise DesignError(error.message, recipe.place(name)) from error
        found[name] = number
    return found


def unknown_parameter(name: object, known: Iterable[str]) -> DesignError:
    """The error for a name that is none of the parameters."""
    return DesignError(f"no parameter is named {shown(name)}; {did_you_mean(str(name), list(known))}")

"""Field types of the file schemas: quantities in SI, points, lists of layer names.

In: plain values from a file. Out: floats in SI (angles rad). A bare length counts in the file's `units`,
which comes in as validation context; a bare number of any other kind is SI.
"""

import math
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BeforeValidator, ValidationInfo, WithJsonSchema

from lamc.basics import units
from lamc.basics.errors import DesignError
from lamc.basics.fields import LENGTH_UNIT as LENGTH_UNIT
from lamc.basics.fields import Model as Model
from lamc.basics.fields import custom as custom
from lamc.basics.units import Quantity, length_unit

ALL_LAYERS = "all"
_WIDEST_ANGLE = 4.0 * math.pi


def reader(quantity: Quantity, rule: Callable[[float], str | None] | None = None) -> BeforeValidator:
    def read(value: Any, info: ValidationInfo) -> float:
        bare = (info.context or {}).get(LENGTH_UNIT) if quantity is units.LENGTH else None
        try:
            number = units.to_si(value, quantity, bare)
        except DesignError as error:
            raise custom(error) from error
        broken = rule(number) if rule else None
        if broken:
            raise custom(DesignError(f"{value!r} {broken}"))
        return number

    return BeforeValidator(read)


def described(quantity: Quantity, note: str = "") -> WithJsonSchema:
    bare = "the file's units" if quantity is units.LENGTH else quantity.unit or "plain"
    text = f"{quantity.name}, a number ({bare}) or text with a unit such as {quantity.example!r}{note}"
    return WithJsonSchema({"type": ["number", "string"], "description": text})


def above_zero(number: float) -> str | None:
    return None if number > 0.0 else "is not above 0"


def not_negative(number: float) -> str | None:
    return None if number >= 0.0 else "is below 0"


def _plausible_angle(number: float) -> str | None:
    if abs(number) <= _WIDEST_ANGLE:
        return None
    return (
        f"is {number:g} rad, more than two turns; bare angles are radians: write '{number:g} deg' for degrees"
    )


def _poisson(number: float) -> str | None:
    return None if -1.0 < number < 1.0 else "is not between -1 and 1"


def _length_unit(value: Any) -> str:
    try:
        return length_unit(value)
    except DesignError as error:
        raise custom(error) from error


def _names(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


Coordinate = Annotated[float, reader(units.LENGTH), described(units.LENGTH)]
Length = Annotated[float, reader(units.LENGTH, above_zero), described(units.LENGTH, ", above 0")]
Gap = Annotated[float, reader(units.LENGTH, not_negative), described(units.LENGTH, ", at least 0")]
Angle = Annotated[float, reader(units.ANGLE, _plausible_angle), described(units.ANGLE)]
AnyAngle = Annotated[float, reader(units.ANGLE), described(units.ANGLE)]
AngleRate = Annotated[float, reader(units.ANGLE_RATE), described(units.ANGLE_RATE)]
Density = Annotated[float, reader(units.DENSITY, not_negative), described(units.DENSITY, ", at least 0")]
Modulus = Annotated[float, reader(units.MODULUS, above_zero), described(units.MODULUS, ", above 0")]
Stiffness = Annotated[
    float, reader(units.STIFFNESS, not_negative), described(units.STIFFNESS, ", at least 0")
]
Damping = Annotated[float, reader(units.DAMPING, not_negative), described(units.DAMPING, ", at least 0")]
Poisson = Annotated[float, reader(units.RATIO, _poisson), described(units.RATIO, ", between -1 and 1")]
Mass = Annotated[float, reader(units.MASS, not_negative), described(units.MASS, ", at least 0")]
Inertia = Annotated[float, reader(units.INERTIA), described(units.INERTIA)]
Number = Annotated[float, reader(units.RATIO), described(units.RATIO)]

Duration = Annotated[float, reader(units.DURATION, above_zero), described(units.DURATION, ", above 0")]

Point = tuple[Coordinate, Coordinate]
SpacePoint = tuple[Coordinate, Coordinate, Coordinate]
Direction = tuple[Number, Number, Number]
InertiaRow = tuple[Inertia, Inertia, Inertia]
InertiaTensor = tuple[InertiaRow, InertiaRow, InertiaRow]
LengthUnit = Annotated[str, BeforeValidator(_length_unit)]
LayerNames = Annotated[
    list[str],
    BeforeValidator(_names),
    WithJsonSchema(
        {
            "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}],
            "description": "names of layers, or 'all'",
        }
    ),
]

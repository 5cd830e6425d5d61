"""Field types of the file schemas: quantities in SI, points, lists of layer names.

In: plain values from a file. Out: floats in SI (angles rad). A bare length counts in the file's `units`,
which comes in as validation context; a bare number of any other kind is SI.
"""

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ValidationInfo, WithJsonSchema

from lamc.basics import units
from lamc.basics.errors import DesignError
from lamc.basics.fields import EXPRESSIONS
from lamc.basics.fields import LENGTH_UNIT as LENGTH_UNIT
from lamc.basics.fields import StrictModel as StrictModel
from lamc.basics.fields import custom as custom
from lamc.basics.number_text import is_measured
from lamc.basics.quantity_fields import Unit
from lamc.basics.units import length_unit

ALL_LAYERS = "all"
FROM_MATERIAL = "from-material"
_WIDEST_ANGLE = 4.0 * math.pi


def _plausible_angle(number: float) -> float:
    if abs(number) > _WIDEST_ANGLE:
        text = f"{number:g} rad is more than two turns; bare angles are radians: write '{number:g} deg' for degrees"
        raise custom(DesignError(text))
    return number


def _length_unit(value: Any) -> str:
    try:
        return length_unit(value)
    except DesignError as error:
        raise custom(error) from error


def _material_stiffness(value: Any, info: ValidationInfo) -> Any:
    expressions = (info.context or {}).get(EXPRESSIONS)
    is_expression = isinstance(value, str) and expressions is not None and expressions.takes(value)
    if isinstance(value, str) and value != FROM_MATERIAL and not is_measured(value) and not is_expression:
        text = f"it is {value[:40]!r}; write a number and a unit, such as '1e-3 N*m/rad', or {FROM_MATERIAL}"
        raise custom(DesignError(text))
    return value


def _names(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


Coordinate = Annotated[float, Unit(units.LENGTH)]
Length = Annotated[float, Unit(units.LENGTH, gt=0.0)]
Gap = Annotated[float, Unit(units.LENGTH, ge=0.0)]
Angle = Annotated[float, Unit(units.ANGLE), AfterValidator(_plausible_angle)]
AnyAngle = Annotated[float, Unit(units.ANGLE)]
AngleRate = Annotated[float, Unit(units.ANGLE_RATE)]
Density = Annotated[float, Unit(units.DENSITY, ge=0.0)]
Modulus = Annotated[float, Unit(units.MODULUS, gt=0.0)]
Stiffness = Annotated[float, Unit(units.STIFFNESS, ge=0.0)]
Damping = Annotated[float, Unit(units.DAMPING, ge=0.0)]
Poisson = Annotated[float, Unit(units.RATIO, gt=-1.0, lt=1.0)]
Mass = Annotated[float, Unit(units.MASS, ge=0.0)]
Inertia = Annotated[float, Unit(units.INERTIA)]
Number = Annotated[float, Unit(units.RATIO)]
Duration = Annotated[float, Unit(units.DURATION, gt=0.0)]

MaterialStiffness = Annotated[
    float | Literal["from-material"], Unit(units.STIFFNESS, ge=0.0), BeforeValidator(_material_stiffness)
]

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

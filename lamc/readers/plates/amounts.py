"""Amounts in plate files that may change from place to place: a number, text with a unit, or an expression in x and y.

In: plain data. Out: types of the schema, whose values are floats in SI, or the text of an expression that is sound.
Never: evaluates one.
"""

from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from lamc.basics import units
from lamc.basics.errors import DesignError, ExpressionError
from lamc.basics.fields import UNIT
from lamc.basics.units import Quantity, to_si
from lamc.readers import fields
from lamc.readers.plates import expression


def _varying(quantity: Quantity, kinds: Sequence[str] = ()) -> tuple[BeforeValidator, WithJsonSchema]:
    """Reads a number of `quantity`, or keeps an expression in x and y as text; of a list, where `kinds` has "array",
    each."""

    def read(value: Any) -> float | str | list[float | str]:
        if isinstance(value, list) and "array" in kinds:
            return [one(item) for item in value]
        return one(value)

    def one(value: Any) -> float | str:
        try:
            return read_amount(value, quantity)
        except DesignError as error:
            raise fields.custom(error) from error

    unit = quantity.unit or "plain"
    reported = (
        f"{quantity.name}: a number ({unit}), text with a unit, or an expression in x and y with the value in {unit}, "
        "where x and y count in the file's units"
    )
    return BeforeValidator(read), WithJsonSchema(
        {"type": ["number", "string", *kinds], "description": reported, UNIT: quantity.unit or "1"}
    )


def read_amount(value: Any, quantity: Quantity) -> float | str:
    """A number of `quantity`, SI, or the text of an expression in x and y that is sound. Raises DesignError."""
    try:
        if isinstance(value, str) and expression.depends_on_place(value):
            expression.Field(value)
            return value
        return to_si(value, quantity)
    except DesignError as error:
        hint = ", or an expression in x and y" if not isinstance(error, ExpressionError) else ""
        raise DesignError(error.message + hint) from error


Intensity = Annotated[float | str, *_varying(units.PRESSURE)]
Warming = Annotated[float | str, *_varying(units.WARMING)]
Wetness = Annotated[float | str, *_varying(units.RATIO)]
ElectricField = Annotated[float | str | list[float | str], *_varying(units.ELECTRIC_FIELD, ["array"])]

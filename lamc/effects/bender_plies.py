"""The laminate of an effect from plain data: plies from bottom to top, with materials by name or by their numbers.

In: a `lamc.plate.Laminate`, or data of a scene file. Out: a `Laminate`. The plate half of lamc is imported when it is
needed: it takes longer than all the rest.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import PlainValidator, TypeAdapter, ValidationInfo, WithJsonSchema, create_model

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import DesignError, LamcError
from lamc.basics.fields import StrictModel, inner, part
from lamc.basics.quantity_fields import Unit

if TYPE_CHECKING:
    from lamc.plates.laminates.laminate import Laminate
    from lamc.plates.laminates.materials import Material
    from lamc.plates.laminates.plies import Ply

T = TypeVar("T")
_TWO = ("E1", "E2", "nu12", "G12")
_WAYS = "give E and nu, or E1, E2, nu12 and G12"
_UNITS = {
    **dict.fromkeys(("E", "E1", "E2", "G12", "G13", "G23", "Xt", "Xc", "Yt", "Yc", "S"), "Pa"),
    **dict.fromkeys(("nu", "nu12", "beta1", "beta2"), "1"),
    **dict.fromkeys(("alpha1", "alpha2"), "K^-1"),
    **dict.fromkeys(("d31", "d32"), "m/V"),
    "density": "kg/m^3",
}


@lru_cache(maxsize=1)
def _numbers() -> type[StrictModel]:
    """The model of a material's numbers; made when it is needed, since it takes a while."""
    texts = dict.fromkeys(("name", "source"), (str | None, None))
    units = {name: (Annotated[float | None, Unit(unit)], None) for name, unit in _UNITS.items()}
    fields: dict[str, Any] = {**texts, **units}
    return create_model("MaterialNumbers", __base__=StrictModel, **fields)


def _made(make: Callable[[], T]) -> T:
    """Errors are about the whole that is made."""
    with part():
        try:
            return make()
        except LamcError as error:
            raise DesignError(error.message) from error


def _material(data: Any, info: ValidationInfo) -> "Material":
    from lamc.plates.laminates.library import LIBRARY
    from lamc.plates.laminates.materials import Material

    if isinstance(data, Material):
        return data
    if isinstance(data, str):
        with part():
            if data not in LIBRARY:
                hint = did_you_mean(data, sorted(LIBRARY))
                raise DesignError(f"no material of the library is named {data[:40]!r}; {hint}")
        return LIBRARY[data]
    said = inner(_numbers(), data, info)
    values = {name: getattr(said, name) for name in sorted(said.model_fields_set)}
    values = {"density": 0.0} | {name: value for name, value in values.items() if value is not None}
    with part():
        if "E" in values or "nu" in values:
            if not {"E", "nu"} <= set(values) or set(_TWO) & set(values):
                raise DesignError("a material has E and nu, or E1, E2, nu12 and G12")
            modulus, ratio = values.pop("E"), values.pop("nu")
            sheet = _made(lambda: Material.isotropic(modulus, ratio, values["density"]))
            values |= {name: getattr(sheet, name) for name in _TWO}
        missing = [name for name in _TWO if name not in values]
        if missing:
            raise DesignError(f"the material has no {', '.join(missing)}; {_WAYS}")
    return _made(lambda: Material(**values))


class _PlyData(StrictModel):
    """A ply of a file."""

    material: Annotated[
        Any,
        PlainValidator(_material),
        WithJsonSchema({"description": f"a name of lamc's library, or a map of its numbers: {_WAYS}"}),
    ]
    thickness: Annotated[float, Unit("m")]
    angle: Annotated[float, Unit("deg")] = 0.0
    gap: Annotated[float, Unit("m")] = 0.0


def _ply(data: Any, info: ValidationInfo) -> "Ply":
    from lamc.plates.laminates.plies import Ply

    if isinstance(data, Ply):
        return data
    said = inner(_PlyData, data, info)
    return _made(lambda: Ply(**{name: getattr(said, name) for name in sorted(said.model_fields_set)}))


@lru_cache(maxsize=1)
def _plies() -> "TypeAdapter[list[Any]]":
    return TypeAdapter(list[Annotated[Any, PlainValidator(_ply)]])


def _listed(data: Any, info: ValidationInfo) -> "list[Any]":
    with part():
        if not isinstance(data, list | tuple) or not data:
            raise DesignError(
                f"the laminate is {shown(data)}; give its plies from bottom to top, or a lamc.plate.Laminate"
            )
    return _plies().validate_python(list(data), context=info.context)


class _LaminateData(StrictModel):
    """A laminate of a file whose plies have a name."""

    plies: Annotated[Any, PlainValidator(_listed)]
    reference: Any = "middle"


class _LaminateSchema:
    """What JSON Schema says of a laminate, made when it is asked for: it takes longer than importing this."""

    def __get_pydantic_json_schema__(self, _core: Any, _handler: Any) -> dict[str, Any]:
        return {
            "type": ["array", "object"],
            "items": _PlyData.model_json_schema(),
            "properties": {"plies": {"type": "array"}, "reference": {"enum": ["bottom", "middle", "top"]}},
        }


def _laminate(data: Any, info: ValidationInfo) -> "Laminate":
    from lamc.plates.laminates.laminate import Laminate

    if isinstance(data, Laminate):
        return data
    if not isinstance(data, Mapping):
        plies = _listed(data, info)
        return _made(lambda: Laminate(plies))
    said = inner(_LaminateData, data, info)
    return _made(lambda: Laminate(said.plies, said.reference))


if TYPE_CHECKING:
    LaminateField = Annotated[Laminate, PlainValidator(_laminate)]
else:
    LaminateField = Annotated[object, PlainValidator(_laminate), _LaminateSchema()]

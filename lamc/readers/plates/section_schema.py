"""The schema of materials and laminates in plate files.

In: plain data. Out: validated models, SI, ply angles in degrees. Beside them two checks that all models of plate files
share. Never: whether a material exists that is named.
"""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from lamc.basics import units
from lamc.basics.errors import DesignError
from lamc.basics.fields import UNIT
from lamc.basics.quantity_fields import Unit
from lamc.basics.units import to_si
from lamc.readers import fields
from lamc.readers.fields import Density, Length, Modulus, StrictModel
from lamc.readers.fields import Number as Ratio


def problem(message: str) -> Exception:
    return fields.custom(DesignError(message))


def one_of(model: StrictModel, names: tuple[str, ...], what: str) -> str:
    """The one of these keys that is given. Raises where none is, or several are."""
    given = [name for name in names if getattr(model, name) is not None]
    if len(given) != 1:
        said = " and ".join(given) if given else "none of them"
        raise problem(f"{what} has exactly one of {', '.join(names)}; this one has {said}")
    return given[0]


def only_with(model: StrictModel, kind: str, allowed: dict[str, tuple[str, ...]], what: str) -> None:
    """Refuses keys that mean nothing beside `kind`; `allowed` lists them by kind."""
    for name in sorted({n for names in allowed.values() for n in names} - set(allowed.get(kind, ()))):
        if name in model.model_fields_set:
            owners = " or ".join(k for k, names in allowed.items() if name in names)
            raise problem(f"{name} belongs to {owners}, and this {what} is {kind}: take it away")


def _angle(value: Any) -> float:
    try:
        if not isinstance(value, str) and value != 0:
            raise DesignError(
                f"{value!r} has no unit; write the angle of a ply with it, such as '{value} deg'"
            )
        return to_si(value, units.PLY_ANGLE)
    except DesignError as error:
        raise fields.custom(error) from error


PlyAngle = Annotated[
    float,
    BeforeValidator(_angle),
    WithJsonSchema(
        {
            "type": ["number", "string"],
            "description": "ply angle with its unit, such as '45 deg'",
            UNIT: "deg",
        }
    ),
]
StrainPerField = Annotated[float, Unit(units.STRAIN_PER_FIELD)]
Expansion = Annotated[float, Unit(units.EXPANSION)]


class PlateMaterialModel(StrictModel):
    """A material of one's own, E and nu or E1, E2, nu12 and G12; or the name of one of lamc's library."""

    library: str | None = Field(None, description="a material of lamc's library (`lamc materials`), alone")
    E: Modulus | None = Field(None, description="Young's modulus of a sheet that is alike in all directions")
    nu: Ratio | None = Field(None, description="its Poisson's ratio")
    E1: Modulus | None = Field(None, description="Young's modulus along the fibres")
    E2: Modulus | None = Field(None, description="Young's modulus across the fibres")
    nu12: Ratio | None = Field(None, description="Poisson's ratio: stretch along 1 contracts 2 by it")
    G12: Modulus | None = Field(None, description="shear modulus in the plane")
    density: Density = Field(0.0, description="mass per volume")
    alpha: Expansion | None = Field(None, description="thermal expansion, the same in all directions")
    alpha1: Expansion | None = Field(None, description="thermal expansion along 1")
    alpha2: Expansion | None = Field(None, description="thermal expansion along 2")
    beta: Ratio | None = Field(None, description="swelling per share of water by mass, in all directions")
    beta1: Ratio | None = Field(None, description="swelling along 1")
    beta2: Ratio | None = Field(None, description="swelling along 2")
    d31: StrainPerField = Field(0.0, description="free strain along 1 per electric field along z")
    d32: StrainPerField = Field(0.0, description="free strain along 2 per electric field along z")
    G13: Modulus | None = Field(None, description="shear through the thickness, in the plane of 1 and z")
    G23: Modulus | None = Field(None, description="shear through the thickness, in the plane of 2 and z")
    Xt: Modulus | None = Field(None, description="strength along 1 in tension; strengths are magnitudes")
    Xc: Modulus | None = Field(None, description="strength along 1 in compression")
    Yt: Modulus | None = Field(None, description="strength along 2 in tension")
    Yc: Modulus | None = Field(None, description="strength along 2 in compression")
    S: Modulus | None = Field(None, description="strength in shear in the plane")

    @model_validator(mode="after")
    def _one_kind(self) -> "PlateMaterialModel":
        alike, two = (
            ("E", "nu", "alpha", "beta"),
            ("E1", "E2", "nu12", "G12", "alpha1", "alpha2", "beta1", "beta2"),
        )
        given = [[n for n in names if getattr(self, n) is not None] for names in (alike, two)]
        if given[0] and given[1]:
            raise problem(
                f"{given[0][0]} and {given[1][0]} do not go together: give E and nu, or E1, E2, nu12 and G12"
            )
        if self.library is not None:
            if len(self.model_fields_set) > 1:
                raise problem("a material of the library has its own numbers; give the name alone")
            return self
        needed = ("E1", "E2", "nu12", "G12") if given[1] else ("E", "nu")
        missing = [name for name in needed if getattr(self, name) is None]
        if missing:
            raise problem(f"{', '.join(missing)} missing: a material has E and nu, or E1, E2, nu12 and G12")
        return self


def _material(value: Any) -> Any:
    return {"library": value} if isinstance(value, str) else value


MaterialField = Annotated[
    PlateMaterialModel, BeforeValidator(_material, json_schema_input_type=PlateMaterialModel | str)
]


class PlyModel(StrictModel):
    """One layer; plies are listed from bottom to top."""

    material: str = Field(description="an entry of materials, or a name of lamc's library")
    thickness: Length = Field(description="of the ply")
    angle: PlyAngle = Field(0.0, description="of its fibres from x towards y, with its unit")


class LaminateModel(StrictModel):
    """A laminate: plies, a layup of one material, one sheet, or the name of an entry of laminates."""

    use: str | None = Field(None, description="the name of an entry of laminates")
    plies: list[PlyModel] | None = Field(None, description="the layers from bottom to top")
    material: str | None = Field(
        None, description="of one sheet or of a layup: an entry of materials, or a name of lamc's library"
    )
    layup: str | None = Field(None, description="angles in degrees from bottom to top, such as '[0/90/±45]s'")
    ply: Length | None = Field(None, description="thickness of one ply of a layup")
    thickness: Length | None = Field(None, description="of one sheet")
    angle: PlyAngle = Field(0.0, description="of one sheet")
    reference: Literal["bottom", "middle", "top"] = Field(
        "middle", description="the surface that heights and membrane displacements count from"
    )

    @model_validator(mode="after")
    def _one_kind(self) -> "LaminateModel":
        kind = one_of(self, ("use", "plies", "material"), "a laminate")
        only_with(self, kind, {"material": ("thickness", "angle", "layup", "ply")}, "laminate")
        if kind == "use" and "reference" in self.model_fields_set:
            raise problem("reference belongs to the laminate that is named: give it there")
        if kind == "material" and (self.thickness is None) == (self.layup is None):
            raise problem("a laminate of one material has a thickness, or a layup and the thickness of a ply")
        if self.layup is not None and (self.ply is None or "angle" in self.model_fields_set):
            raise problem(
                "a layup has the thickness of a ply, such as ply: 125 um, and says all angles itself"
            )
        if self.layup is None and self.ply is not None:
            raise problem("ply is the thickness of a ply in a layup; a single sheet has a thickness")
        if self.plies == []:
            raise problem("a laminate has one ply at least; list them from bottom to top")
        return self


def _laminate(value: Any) -> Any:
    return {"use": value} if isinstance(value, str) else value


LaminateField = Annotated[
    LaminateModel, BeforeValidator(_laminate, json_schema_input_type=LaminateModel | str)
]

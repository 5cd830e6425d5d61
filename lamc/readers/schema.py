"""The schema of lamc's own files: what a native design and a mechanism file may say.

In: plain data. Out: validated models with every quantity in SI. References between parts of a file (a layer's
material, a hinge's layer) and geometry are checked where models become records (`native`, and `yaml_file` in
`lamc.mechanism`).
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from lamc.basics.errors import DesignError
from lamc.basics.fields import with_unit
from lamc.readers import fields
from lamc.readers.checking import CHOICE
from lamc.readers.effects_schema import with_effects
from lamc.readers.fields import (
    ALL_LAYERS,
    Angle,
    Coordinate,
    Damping,
    Density,
    Gap,
    LayerNames,
    Length,
    LengthUnit,
    MaterialStiffness,
    Modulus,
    Point,
    Poisson,
    StrictModel,
)
from lamc.readers.mechanism_schema import MechanismModel
from lamc.readers.parameters_section import JSON_SCHEMA
from lamc.readers.scene_schema import LoneSceneModel, SceneFileModel, SceneModel, ScenesModel
from lamc.records.design import FacetCreases
from lamc.records.drawing import Role


class MaterialModel(StrictModel):
    """A sheet material; one or none of the flags is usual."""

    density: Density = Field(description="mass per volume of the sheet")
    E1: Modulus | None = Field(
        None,
        description="Young's modulus along the sheet's first axis; alone, of a sheet that is alike in all directions",
    )
    E2: Modulus | None = Field(None, description="Young's modulus across it; as E1 if not said")
    poisson: Poisson | None = Field(None, description="Poisson's ratio; stretch along 1 contracts 2 by it")
    G12: Modulus | None = Field(None, description="shear modulus; needed where E2 differs from E1")
    rigid: bool = Field(False, description="a board: hinges cut through it")
    flexible: bool = Field(False, description="a film: it bends at hinges and carries their axes")
    adhesive: bool = Field(False, description="glue: it joins its neighbours and is cut like a board")
    conductive: bool = Field(False, description="a conductor: it is cut like a board")


class LayerModel(StrictModel):
    """One sheet of the laminate; layers are listed from bottom to top."""

    name: str = Field(description="of the layer, for hinges, shapes and regions to name")
    material: str = Field(description="an entry of materials")
    thickness: Length = Field(description="of the sheet")
    angle: Angle = Field(0.0, description="of the material's first axis, from x towards y")


class CircleModel(StrictModel):
    """A disc."""

    center: Point = Field(description="its centre, [x, y]")
    radius: Length = Field(description="its radius")


class DrawnModel(StrictModel):
    """What is drawn in an SVG or DXF file that lies beside the design's own."""

    file: str = Field(description="its name, without folders")
    layer: str | None = Field(None, description="the layer or group to take; the whole drawing if not said")
    units: LengthUnit | None = Field(None, description="of the drawing's numbers, where its own are not true")
    roles: dict[str, Role] | None = Field(
        None, description="what lines of a colour or layer are for, as in {red: cut}"
    )
    heal: Gap | None = Field(
        None, description="how far ends of lines may be off and are mended; 0 mends nothing"
    )
    at: Point = Field(
        (0.0, 0.0),
        description="where the drawing's zero lies in the design; an SVG's is its upper left corner",
    )


class OutlineModel(StrictModel):
    """A region: exactly one of rect, polygon (with holes), circle and shape."""

    rect: tuple[Coordinate, Coordinate, Coordinate, Coordinate] | None = Field(
        None, description="two opposite corners: [x0, y0, x1, y1]"
    )
    polygon: list[Point] | None = Field(None, description="corners in order; the last joins the first")
    holes: list[list[Point]] = Field(default=[], description="holes of the polygon")
    circle: CircleModel | None = Field(None, description="a disc: {center: [x, y], radius: r}")
    shape: DrawnModel | None = Field(
        None, description="what outlines of a drawing enclose: {file: top.dxf, layer: body}"
    )

    @model_validator(mode="after")
    def _one_region(self) -> "OutlineModel":
        given = [
            n for n in ("rect", "polygon", "circle", "shape", "cut") if getattr(self, n, None) is not None
        ]
        choices = (
            "rect, polygon, circle, shape or cut"
            if "cut" in type(self).model_fields
            else "rect, polygon, circle or shape"
        )
        if len(given) != 1:
            said = " and ".join(given) if given else "none of them"
            raise fields.custom(
                DesignError(
                    f"a shape has exactly one of {choices}; this one has {said}; give one, such as rect: [0, 0, 9, 5], "
                    "and draw the others as shapes of their own"
                )
            )
        if self.holes and self.polygon is None:
            raise fields.custom(DesignError("holes belong to a polygon; subtract from other shapes with cut"))
        return self


class RegionModel(OutlineModel):
    """A region in some layers."""

    layers: LayerNames = Field(default=[ALL_LAYERS], description="names of the layers that it is in, or all")


class ShapeModel(RegionModel):
    """A drawn shape: material that is added, or with `cut`, taken away from what was drawn before it."""

    cut: OutlineModel | None = Field(
        None, description="a region to take away from what was drawn before, in place of one that is added"
    )


DrawnLines = Annotated[
    Annotated[DrawnModel, Tag(f"{CHOICE}drawing")]
    | Annotated[list[tuple[Point, Point]], Tag(f"{CHOICE}list")],
    Discriminator(
        lambda value: f"{CHOICE}{'drawing' if isinstance(value, Mapping | DrawnModel) else 'list'}"
    ),
]


class HingeModel(StrictModel):
    """One hinge line, or several that share their properties.

    The joint's axis points from the start of a line to its end, and its angle is positive by the right hand.
    """

    name: str | None = Field(None, description="of the joint; several lines count on: fold_1, fold_2")
    line: tuple[Point, Point] | None = Field(
        None, description="the hinge line from start to end, [[x, y], [x, y]]"
    )
    lines: DrawnLines | None = Field(
        None,
        description="several such lines, each a hinge of its own; or those of a drawing: {file: top.dxf}",
    )
    layer: str | None = Field(None, description="the layer that bends; by default the only flexible one")
    gap: Length | None = Field(
        None, description="length of bare film that bends, from board to board across the line; required"
    )
    width: Length | None = Field(
        None, description="old name: half of the gap", json_schema_extra={"deprecated": True}
    )
    stiffness: MaterialStiffness = Field(
        0.0, description="torque per angle, or from-material: of the film's modulus, thickness and gap"
    )
    damping: Damping = Field(0.0, description="torque per rate")
    rest_angle: Angle = Field(
        0.0, description="angle at which the hinge's own stiffness holds it; 0 is as drawn"
    )
    limits: tuple[Angle, Angle] | None = Field(None, description="lowest and highest angle; free if not said")
    layers: LayerNames = Field(default=[ALL_LAYERS], description="layers that the hinge cuts through")

    @property
    def half_gap(self) -> float:
        """m, to either side of the line."""
        return 0.5 * self.gap if self.gap is not None else self.width or 0.0

    @model_validator(mode="after")
    def _one_gap(self) -> "HingeModel":
        if self.gap is None and self.width is None:
            text = "a hinge needs its gap, the length of bare film from board to board, such as gap: 0.4 mm"
            raise fields.custom(DesignError(text))
        if self.gap is not None and self.width is not None:
            raise fields.custom(DesignError("width is the old name of half the gap; keep gap alone"))
        return self

    @model_validator(mode="after")
    def _one_kind_of_line(self) -> "HingeModel":
        if (self.line is None) == (self.lines is None) or self.lines == []:
            raise fields.custom(
                DesignError(
                    "a hinge has either line: [[x, y], [x, y]] or lines: a list of such, or {file: …}"
                )
            )
        if self.limits is not None and not self.limits[0] < self.limits[1]:
            raise fields.custom(
                DesignError(
                    f"limits run from {self.limits[0]:g} to {self.limits[1]:g} rad; the lower comes first"
                )
            )
        return self


class NamedBodyModel(StrictModel):
    """A point inside the body that gets the name, and the layer to look in where bodies lie above one another."""

    at: Point = Field(description="a point inside the body, [x, y]")
    layer: str | None = Field(None, description="the layer to look in, where bodies lie above one another")


def _point_alone(value: Any) -> Any:
    """A bare point [x, y] is short for {at: [x, y]}."""
    return {"at": value} if isinstance(value, list | tuple) else value


BodyPoint = Annotated[
    NamedBodyModel,
    BeforeValidator(_point_alone, json_schema_input_type=NamedBodyModel | Point),
]


class FacetCreasesModel(StrictModel):
    """Facets bend along their diagonals: each moving one of four corners or more is parted into triangles by hinges."""

    stiffness: MaterialStiffness = Field(
        description="of each diagonal, or from-material: of its facet's layers"
    )
    damping: Damping = Field(0.0, description="torque per rate of each diagonal")

    def record(self) -> FacetCreases:
        return FacetCreases(None if isinstance(self.stiffness, str) else self.stiffness, self.damping)


class DesignModel(StrictModel):
    """A laminate design."""

    kind: Literal["design"] = Field("design", description="what the file is; may be left out")
    name: str | None = Field(None, description="of the design; the file's name if not said")
    story: str = Field("", description="what the design is for and what it shows, a paragraph of plain text")
    units: LengthUnit = Field("m", description="the unit of every length written without one, such as mm")
    parameters: dict[str, Any] = Field(
        default={},
        description="dimensions by name, {length: 40 mm, t: {default: 0.3 mm, min: 0.1 mm, max: 1 mm, meaning: …}}; "
        "every number of the file may be an expression in them, such as length/2",
        json_schema_extra=JSON_SCHEMA,
    )
    materials: dict[str, MaterialModel] = Field(description="materials of the sheets by name")
    layers: list[LayerModel] = Field(description="the sheets from bottom to top")
    shapes: list[ShapeModel] = Field(
        description="what is drawn, in order: later shapes add to earlier ones or cut from them"
    )
    hinges: list[HingeModel] = Field(
        default=[], description="hinge lines, along which the flexible layer bends"
    )
    fixed: list[RegionModel] = Field(
        default=[], description="regions that the world holds; a body that meets one is fixed"
    )
    bodies: dict[str, BodyPoint] = Field(
        default={}, description="names of bodies, each with a point inside it"
    )
    contact_points: list[Point] = Field(
        default=[], description="points of the drawing at which bodies may touch something"
    )
    facet_creases: FacetCreasesModel | None = Field(
        None, description="facets bend along their diagonals: {stiffness: from-material}"
    )
    scene: SceneModel | None = Field(None, description="what is simulated where no scene is named")
    scenes: ScenesModel = Field(default={})


FILES: dict[str, type[StrictModel]] = {
    "Design": DesignModel,
    "Mechanism": MechanismModel,
    "Scene": LoneSceneModel,
    "Scenes": SceneFileModel,
}


def json_schema(files: Mapping[str, type[StrictModel]] = FILES) -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of native files: any of `files`, which have names that differ from their parts'."""
    parts = [m.model_json_schema(ref_template="#/$defs/{model}") for m in files.values()]
    shared: dict[str, Any] = {}
    for part in parts:
        shared |= part.pop("$defs", {})
    named = dict(zip(files, parts, strict=True))
    for definition in (shared | named).values():
        for name, field in definition.get("properties", {}).items():
            definition["properties"][name] = with_unit(field)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"lamc {' or '.join(name.lower() for name in files)}",
        "anyOf": [{"$ref": f"#/$defs/{name}"} for name in sorted(named)],
        "$defs": dict(sorted(with_effects(shared | named).items())),
    }

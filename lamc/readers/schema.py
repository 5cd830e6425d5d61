"""The schema of lamc's own files: what a native design and a mechanism file may say.

In: plain data. Out: validated models with every quantity in SI. References between parts of a file (a layer's
material, a hinge's layer) and geometry are checked where models become records (`native`, and `yaml_file` in
`lamc.mechanism`).
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from lamc.basics.errors import DesignError
from lamc.readers import fields
from lamc.readers.effects_schema import with_effects
from lamc.readers.fields import (
    ALL_LAYERS,
    Angle,
    AnyAngle,
    Coordinate,
    CreaseStiffness,
    Damping,
    Density,
    Direction,
    InertiaTensor,
    LayerNames,
    Length,
    LengthUnit,
    Mass,
    Modulus,
    Point,
    Poisson,
    SpacePoint,
    Stiffness,
    StrictModel,
)
from lamc.readers.scene_schema import LoneSceneModel, SceneFileModel, SceneModel, ScenesModel
from lamc.records.design import FacetCreases


class MaterialModel(StrictModel):
    """A sheet material; one or none of the flags is usual."""

    density: Density
    E1: Modulus | None = None
    E2: Modulus | None = None
    poisson: Poisson | None = None
    G12: Modulus | None = Field(None, description="shear modulus; needed where E2 differs from E1")
    rigid: bool = False
    flexible: bool = False
    adhesive: bool = False
    conductive: bool = False


class LayerModel(StrictModel):
    """One sheet of the laminate; layers are listed from bottom to top."""

    name: str
    material: str
    thickness: Length
    angle: Angle = 0.0


class CircleModel(StrictModel):
    center: Point
    radius: Length


class OutlineModel(StrictModel):
    """A region: exactly one of rect, polygon (with holes) and circle."""

    rect: tuple[Coordinate, Coordinate, Coordinate, Coordinate] | None = Field(
        None, description="two opposite corners: [x0, y0, x1, y1]"
    )
    polygon: list[Point] | None = Field(None, description="corners in order; the last joins the first")
    holes: list[list[Point]] = Field(default=[], description="holes of the polygon")
    circle: CircleModel | None = None

    @model_validator(mode="after")
    def _one_region(self) -> "OutlineModel":
        given = [n for n in ("rect", "polygon", "circle", "cut") if getattr(self, n, None) is not None]
        choices = (
            "rect, polygon, circle or cut" if "cut" in type(self).model_fields else "rect, polygon or circle"
        )
        if len(given) != 1:
            said = " and ".join(given) if given else "none of them"
            raise fields.custom(DesignError(f"a shape has exactly one of {choices}; this one has {said}"))
        if self.holes and self.polygon is None:
            raise fields.custom(DesignError("holes belong to a polygon; subtract from other shapes with cut"))
        return self


class RegionModel(OutlineModel):
    """A region in some layers."""

    layers: LayerNames = Field(default=[ALL_LAYERS])


class ShapeModel(RegionModel):
    """A drawn shape: material that is added, or with `cut`, taken away from what was drawn before it."""

    cut: OutlineModel | None = None


class HingeModel(StrictModel):
    """One hinge line, or several that share their properties.

    The joint's axis points from the start of a line to its end, and its angle is positive by the right hand.
    """

    name: str | None = None
    line: tuple[Point, Point] | None = None
    lines: list[tuple[Point, Point]] | None = None
    layer: str | None = Field(None, description="the layer that bends; by default the only flexible one")
    width: Length
    stiffness: Stiffness = 0.0
    damping: Damping = 0.0
    rest_angle: Angle = 0.0
    limits: tuple[Angle, Angle] | None = None
    layers: LayerNames = Field(default=[ALL_LAYERS], description="layers that the hinge cuts through")

    @model_validator(mode="after")
    def _one_kind_of_line(self) -> "HingeModel":
        if (self.line is None) == (self.lines is None) or self.lines == []:
            raise fields.custom(
                DesignError("a hinge has either line: [[x, y], [x, y]] or lines: a list of such")
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

    at: Point
    layer: str | None = None


def _point_alone(value: Any) -> Any:
    """A bare point [x, y] is short for {at: [x, y]}."""
    return {"at": value} if isinstance(value, list | tuple) else value


BodyPoint = Annotated[
    NamedBodyModel,
    BeforeValidator(_point_alone, json_schema_input_type=NamedBodyModel | Point),
]


class FacetCreasesModel(StrictModel):
    """Facets bend along their diagonals: each moving one of four corners or more is parted into triangles by hinges."""

    stiffness: CreaseStiffness = Field(
        description="of each diagonal, or from-material: of its facet's layers"
    )
    damping: Damping = 0.0

    def record(self) -> FacetCreases:
        return FacetCreases(None if isinstance(self.stiffness, str) else self.stiffness, self.damping)


class DesignModel(StrictModel):
    """A laminate design."""

    kind: Literal["design"] = "design"
    name: str | None = None
    story: str = Field("", description="what the design is for and what it shows, a paragraph of plain text")
    units: LengthUnit = Field("m", description="the unit of every length written without one, such as mm")
    materials: dict[str, MaterialModel]
    layers: list[LayerModel]
    shapes: list[ShapeModel]
    hinges: list[HingeModel] = Field(default=[])
    fixed: list[RegionModel] = Field(default=[])
    bodies: dict[str, BodyPoint] = Field(
        default={}, description="names of bodies, each with a point inside it"
    )
    contact_points: list[Point] = Field(
        default=[], description="points of the drawing at which bodies may touch something"
    )
    facet_creases: FacetCreasesModel | None = None
    scene: SceneModel | None = None
    scenes: ScenesModel = Field(default={})


class PlateModel(StrictModel):
    """One flat piece of a body's outline, between two heights."""

    polygon: list[Point]
    holes: list[list[Point]] = Field(default=[])
    z: tuple[Coordinate, Coordinate]


class BodyModel(StrictModel):
    """A rigid body in the drawn configuration, world axes."""

    name: str
    mass: Mass = 0.0
    com: SpacePoint = (0.0, 0.0, 0.0)
    inertia: InertiaTensor = Field(default=((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    fixed: bool = False
    outline: list[PlateModel] = Field(default=[])


class JointModel(StrictModel):
    """A hinge from parent to child about `axis` through `point`."""

    name: str
    parent: str
    child: str
    point: SpacePoint
    axis: Direction
    stiffness: Stiffness = 0.0
    damping: Damping = 0.0
    rest_angle: AnyAngle = 0.0
    limits: tuple[AnyAngle, AnyAngle] | None = None


class MechanismModel(StrictModel):
    """Bodies and joints without a drawing."""

    kind: Literal["mechanism"] = "mechanism"
    name: str | None = None
    story: str = Field("", description="what the design is for and what it shows, a paragraph of plain text")
    units: LengthUnit = "m"
    bodies: list[BodyModel]
    joints: list[JointModel] = Field(default=[])
    contact_points: list[Point] = Field(
        default=[], description="points of the drawing at which bodies may touch something"
    )
    scene: SceneModel | None = None
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
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"lamc {' or '.join(name.lower() for name in files)}",
        "anyOf": [{"$ref": f"#/$defs/{name}"} for name in sorted(named)],
        "$defs": dict(sorted(with_effects(shared | named).items())),
    }

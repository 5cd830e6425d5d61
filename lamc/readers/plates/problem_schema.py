"""The schema of plate files: what `kind: plate` may say.

In: plain data. Out: validated models with every quantity in SI. What needs more than one entry (a laminate that is
named exists, a force at a point or along an edge) and geometry are checked where models become records, in
`problem_file`.
"""

from typing import Annotated, Any, Literal, get_args

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from lamc.basics import units
from lamc.basics.fields import UNIT
from lamc.basics.quantity_fields import Unit
from lamc.readers.fields import Coordinate, LengthUnit, Point, StrictModel
from lamc.readers.plates.amounts import ElectricField, Intensity, Warming, Wetness
from lamc.readers.plates.geometry_schema import GeometryModel, PlateRegionModel, check_line
from lamc.readers.plates.section_schema import LaminateField, MaterialField, one_of, only_with, problem
from lamc.readers.schema import CircleModel

Named = Literal["boundary", "left", "right", "bottom", "top", "fixed"]
PLACES = get_args(Named)
VALUES = {  # what can be asked for at a point, and its unit
    "w": "m",
    "u": "m",
    "v": "m",
    "w_x": "",
    "w_y": "",
    "kappa_x": "1/m",
    "kappa_y": "1/m",
    "kappa_xy": "1/m",
    "M_x": "N",
    "M_y": "N",
    "M_xy": "N",
    "N_x": "N/m",
    "N_y": "N/m",
    "N_xy": "N/m",
}


HingeStiffness = Annotated[float, Unit(units.LINE_STIFFNESS, ge=0.0)]
FoundationStiffness = Annotated[float, Unit(units.FOUNDATION, ge=0.0)]
Moment = Annotated[float, Unit(units.LINE_MOMENT)]
Acceleration = Annotated[float, Unit(units.ACCELERATION)]
FreeValue = Annotated[
    Any, WithJsonSchema({"type": ["number", "string"]})
]  # its unit depends on its neighbours
FreeVector = Annotated[Any, WithJsonSchema({"type": ["number", "string", "array"]})]


class WhereModel(StrictModel):
    """A place on the plate: the boundary, a side of its bounding box, or what is drawn or named here."""

    named: Named | None = Field(None, description="fixed: where the design holds the body")
    point: Point | None = Field(None, description="a point, [x, y]")
    line: list[Point] | None = Field(None, description="points of a line in order")
    rect: tuple[Coordinate, Coordinate, Coordinate, Coordinate] | None = Field(
        None, description="what lies between two corners: [x0, y0, x1, y1]"
    )
    polygon: list[Point] | None = Field(None, description="what lies inside of these corners")
    circle: CircleModel | None = Field(None, description="what lies inside of {center: [x, y], radius: r}")
    region: str | None = Field(None, description="an entry of regions")
    hinge: str | None = Field(None, description="a hinge of the design, by the name of its joint")

    @model_validator(mode="after")
    def _one_place(self) -> "WhereModel":
        one_of(self, ("named", "point", "line", "rect", "polygon", "circle", "region", "hinge"), "a place")
        check_line(self.line)
        return self


def _where(value: Any) -> Any:
    if isinstance(value, str):
        if value not in PLACES:
            raise problem(
                f"{value[:40]!r} is no place; write one of {', '.join(PLACES)}, or a map such as "
                "{line: [[0, 0], [0, 1]]}, {point: [0, 0]} or {region: name}"
            )
        return {"named": value}
    return value


Where = Annotated[
    WhereModel,
    BeforeValidator(_where, json_schema_input_type=WhereModel | Named),
]


_BESIDE = {"fixed": ("where", "value"), "simply_supported": ("kind",), "hinged": ("stiffness",)}


class SupportModel(StrictModel):
    """How the plate is held, and where: {clamped: left}; {fixed: [w, w_x], where: left, value: 1 mm}."""

    clamped: Where | None = Field(None, description="the place where the plate neither moves nor turns")
    simply_supported: Where | None = Field(
        None, description="the place where it does not move and turns freely"
    )
    hinged: Where | None = Field(None, description="on a hinge to another body: turns, and does not move")
    symmetry: Where | None = Field(None, description="the place where its mirror image goes on")
    fixed: list[Literal["u", "v", "w", "w_x", "w_y"]] | None = Field(
        None, description="unknowns that are given, at where"
    )
    where: Where | None = Field(None, description="of fixed unknowns")
    value: FreeValue = Field(
        0.0,
        description="of the fixed unknowns, or an expression in x and y; m, of slopes without unit",
        json_schema_extra={UNIT: "m, 1"},
    )
    stiffness: HingeStiffness = Field(0.0, description="of a hinge, per length of its line; 0: turns freely")
    kind: Literal["hard", "soft"] = Field("hard", description="soft: free to twist along a simple support")

    @model_validator(mode="after")
    def _one_kind(self) -> "SupportModel":
        kind = one_of(self, ("clamped", "simply_supported", "hinged", "symmetry", "fixed"), "a support")
        only_with(self, kind, _BESIDE, "support")
        if kind == "fixed" and (not self.fixed or self.where is None):
            raise problem("fixed lists unknowns, and where tells the place: {fixed: [w], where: left}")
        return self


class FoundationModel(StrictModel):
    """Elastic ground under the plate: {stiffness: 2 MPa/mm, where: {rect: [0, 0, 50, 20]}}."""

    stiffness: FoundationStiffness = Field(description="pressure per deflection")
    where: Where | None = Field(
        None, description="an area: a rect, a polygon, a circle or a region; all of the plate"
    )


class HingeLineModel(StrictModel):
    """A line inside the plate along which its sides may turn: {along: {line: [[5, 0], [5, 2]]}, stiffness: 3 N/rad}."""

    along: Where = Field(description="a line, or a hinge between bodies of the design: {hinge: name}")
    stiffness: HingeStiffness = Field(0.0, description="per length of the line; 0: turns freely")
    name: str | None = Field(None, description="of the hinge, for the results")

    @model_validator(mode="after")
    def _a_line(self) -> "HingeLineModel":
        if self.along.line is None and self.along.hinge is None:
            raise problem(
                "a hinge inside the plate is along a line: {along: {line: [[0, 0], [0, 1]]}}; an edge of the plate is "
                "held by supports: hinged"
            )
        return self


class LoadModel(StrictModel):
    """What acts: at a point, along an edge, on the face, or in the material."""

    point: Point | None = Field(None, description="where a force acts, [x, y]")
    edge: Where | None = Field(None, description="the place along which a force or a moment acts")
    force: FreeVector = Field(
        None,
        description="N at a point, N/m along an edge; along z, or [x, y, z]",
        json_schema_extra={UNIT: "N, N/m"},
    )
    total: FreeVector = Field(
        None,
        description="force that is spread evenly along the edge; along z, or [x, y, z]",
        json_schema_extra={UNIT: "N"},
    )
    moment: Moment | None = Field(None, description="N·m/m, bends like a positive moment of the plate")
    pressure: Intensity | None = Field(
        None, description="force per area along z, or an expression in x and y"
    )
    gravity: tuple[Acceleration, Acceleration, Acceleration] | None = Field(
        None, description="acceleration of free fall, [x, y, z]: the plate's own weight"
    )
    temperature: Warming | None = Field(
        None, description="rise from the state without stress, or an expression in x and y"
    )
    moisture: Wetness | None = Field(
        None, description="rise of the share of water by mass, or an expression in x and y"
    )
    field: ElectricField | None = Field(
        None, description="V/m through every piezoelectric ply, or a list of one value per ply"
    )
    gradient: FreeValue | None = Field(
        None,
        description="of temperature, K/m, or of moisture, 1/m, through the thickness, upwards from the reference "
        "surface; or an expression in x and y",
        json_schema_extra={UNIT: "K/m, 1/m"},
    )
    region: str | None = Field(None, description="the named region only")

    @model_validator(mode="after")
    def _one_kind(self) -> "LoadModel":
        kinds = ("point", "edge", "pressure", "gravity", "temperature", "moisture", "field")
        kind = one_of(self, kinds, "a load")
        allowed = {"point": ("force",), "edge": ("force", "total", "moment")}
        allowed |= dict.fromkeys(("pressure", "field"), ("region",))
        allowed |= dict.fromkeys(("temperature", "moisture"), ("region", "gradient"))
        only_with(self, kind, allowed, "load")
        if kind == "point" and self.force is None:
            raise problem("a load at a point has a force: {point: [0, 0], force: 1 N}")
        if kind == "edge":
            one_of(self, ("force", "total", "moment"), "a load along an edge")
        return self


class OutputModel(StrictModel):
    """A value to print: {name: middle, at: [0, 0], value: w, expected: 0.1 mm}. Curvatures, moments and forces are
    recovered from patches of cells, as the extremes are."""

    at: Point = Field(description="the point, [x, y]")
    name: str | None = Field(None, description="of the value, for the results")
    value: Literal[tuple(VALUES)] = Field(  # type: ignore[valid-type]
        "w", description="deflection w, u, v, slopes, curvatures, moments or forces per length"
    )
    expected: FreeValue | None = Field(
        None,
        description="what it should be: a number, text with a unit, or an expression in A11 to D66 and h, all SI",
        json_schema_extra={UNIT: "of the value"},
    )


class PlateFileModel(StrictModel):
    """A plate, how it is held and what acts on it."""

    kind: Literal["plate"] = Field(description="what the file is")
    name: str | None = Field(None, description="of the problem; the file's name if not said")
    story: str = Field("", description="what the problem is about, a paragraph of plain text")
    units: LengthUnit = Field("m", description="the unit of every length written without one, such as mm")
    materials: dict[str, MaterialField] = Field(
        default={}, description="materials by name, each with its numbers or a name of lamc's library"
    )
    laminates: dict[str, LaminateField] = Field(default={}, description="laminates by name")
    laminate: LaminateField | None = Field(None, description="of the plate, where no region has its own")
    geometry: GeometryModel = Field(description="outline and mesh")
    regions: dict[str, PlateRegionModel] = Field(
        default={}, description="parts of the plate by name, with a laminate or an edge length of their own"
    )
    element: str = Field(
        "dkt",
        description="the finite element: dkt, bciz, specht, or auto with shear through the thickness where it counts",
    )
    hinges: list[HingeLineModel] = Field(default=[], description="lines inside the plate that fold")
    supports: list[SupportModel] = Field(default=[], description="how the plate is held")
    foundation: list[FoundationModel] = Field(
        default=[], description="elastic ground under the plate, in one or several areas"
    )
    loads: list[LoadModel] = Field(default=[], description="what acts, in every case if there are cases")
    cases: dict[str, list[LoadModel]] = Field(default={}, description="loads by the name of the case")
    outputs: list[OutputModel] = Field(default=[], description="values at points that are printed")
    modes: int = Field(0, description="natural modes to compute")
    buckling: int = Field(0, description="buckling loads to compute, in multiples of the first case")

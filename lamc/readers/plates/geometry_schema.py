"""The schema of plate files: outlines, regions, meshes.

In: plain data. Out: validated models with every quantity in SI.
"""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from lamc.readers.fields import Coordinate, Length, Point, StrictModel
from lamc.readers.plates.section_schema import LaminateField, one_of, only_with, problem
from lamc.readers.schema import CircleModel


def check_line(line: list[Point] | None) -> None:
    """Raises for a line of less than two points."""
    if line is not None and len(line) < 2:
        raise problem("a line has two points at least")


class PlateOutlineModel(StrictModel):
    """A region of the plane: exactly one of rect, polygon, circle and wkt."""

    rect: tuple[Coordinate, Coordinate, Coordinate, Coordinate] | None = Field(
        None, description="two opposite corners: [x0, y0, x1, y1]"
    )
    polygon: list[Point] | None = Field(None, description="corners in order; the last joins the first")
    circle: CircleModel | None = Field(None, description="a disc: {center: [x, y], radius: r}")
    wkt: str | None = Field(None, description="a polygon in well-known text, coordinates in the file's units")

    @model_validator(mode="after")
    def _one_shape(self) -> "PlateOutlineModel":
        one_of(self, ("rect", "polygon", "circle", "wkt"), "an outline")
        return self


def _outline(value: Any) -> Any:
    return {"polygon": value} if isinstance(value, list) else value


OutlineField = Annotated[
    PlateOutlineModel, BeforeValidator(_outline, json_schema_input_type=PlateOutlineModel | list[Point])
]


class PlateRegionModel(PlateOutlineModel):
    """A part of the plate with a laminate or an edge length of its own."""

    laminate: LaminateField | None = Field(None, description="of this region; as the plate's if not said")
    size: Length | None = Field(None, description="length of the mesh's edges in this region")


class FollowModel(StrictModel):
    """A line or a point inside the plate, where a support, a load or an output is."""

    point: Point | None = Field(None, description="a point, [x, y]")
    line: list[Point] | None = Field(None, description="points of a line in order, two at least")

    @model_validator(mode="after")
    def _one_place(self) -> "FollowModel":
        one_of(self, ("point", "line"), "a place to follow")
        check_line(self.line)
        return self


class GeometryModel(StrictModel):
    """The plate's outline and how it is meshed."""

    rect: tuple[Coordinate, Coordinate, Coordinate, Coordinate] | None = Field(
        None, description="two opposite corners: [x0, y0, x1, y1]"
    )
    polygon: list[Point] | None = Field(None, description="corners in order; the last joins the first")
    circle: CircleModel | None = Field(None, description="a disc: {center: [x, y], radius: r}")
    wkt: str | None = Field(None, description="a polygon in well-known text, coordinates in the file's units")
    design: str | None = Field(
        None, description="a laminate design beside this file; the laminates come from it"
    )
    body: str | list[str] | None = Field(
        None, description="the body of that design, or several that hang together"
    )
    hinges: Literal["none", "lines", "strips"] = Field(
        "none",
        description="the strip that bends: none: it ends where it was cut; lines: it is left out, and the "
        "stiff edge beside the hinge line can be held, and between two bodies of the plate the line itself folds; "
        "strips: it is part of the plate",
    )
    holes: list[OutlineField] = Field(
        default=[], description="what is cut out, each a region or a list of corners"
    )
    grid: tuple[int, int] | None = Field(None, description="cells along x and y of a regular mesh; for rect")
    pattern: Literal["one-diagonal", "criss-cross", "union-jack", "squares"] = Field(
        "one-diagonal", description="how the cells of a grid are parted into triangles; squares: not at all"
    )
    size: Length | None = Field(None, description="length of the mesh's edges")
    follow: list[FollowModel] = Field(
        default=[], description="lines and points inside that edges and corners of the mesh shall be on"
    )

    @model_validator(mode="after")
    def _one_shape(self) -> "GeometryModel":
        kind = one_of(self, ("rect", "polygon", "circle", "wkt", "design"), "a geometry")
        only_with(self, kind, {"design": ("body", "hinges"), "rect": ("grid", "pattern")}, "geometry")
        if kind == "design" and (self.holes or not self.body):
            raise problem("a plate of a design names a body of it, and holes are drawn there")
        if self.grid is not None and (self.size is not None or self.holes):
            raise problem("a grid has neither size nor holes: give size alone for a mesh that follows them")
        if self.grid is not None and self.follow:
            raise problem(
                "the lines of a grid are where they are: give size alone for a mesh that follows others"
            )
        if self.grid is None and "pattern" in self.model_fields_set:
            raise problem("pattern belongs to a grid: give grid: [cells along x, cells along y]")
        if self.grid is not None and min(self.grid) < 1:
            raise problem(f"the grid is {list(self.grid)}; it has one cell at least along x and along y")
        return self

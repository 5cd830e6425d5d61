"""The schema of mechanism files: bodies and joints without a drawing.

In: plain data. Out: validated models with every quantity in SI. References between parts are checked where models
become records, in `mechanism_file`.
"""

from typing import Literal

from pydantic import Field

from lamc.readers.fields import (
    AnyAngle,
    Coordinate,
    Damping,
    Direction,
    InertiaTensor,
    LengthUnit,
    Mass,
    Point,
    SpacePoint,
    Stiffness,
    StrictModel,
)
from lamc.readers.scene_schema import SceneModel, ScenesModel


class PlateModel(StrictModel):
    """One flat piece of a body's outline, between two heights."""

    polygon: list[Point] = Field(description="its corners in order, world x and y")
    holes: list[list[Point]] = Field(default=[], description="holes in it, each by its corners")
    z: tuple[Coordinate, Coordinate] = Field(description="lower and upper height, world")


class BodyModel(StrictModel):
    """A rigid body in the drawn configuration, world axes."""

    name: str = Field(description="of the body")
    mass: Mass = Field(0.0, description="of the body; 0 for one that is fixed")
    com: SpacePoint = Field(
        (0.0, 0.0, 0.0), description="centre of mass in the drawn configuration, world axes"
    )
    inertia: InertiaTensor = Field(
        default=((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        description="tensor about the centre of mass, world axes: three rows of three",
    )
    fixed: bool = Field(False, description="whether the world holds it")
    outline: list[PlateModel] = Field(
        default=[], description="flat pieces of its outline, for pictures, contact and air"
    )


class JointModel(StrictModel):
    """A hinge from parent to child about `axis` through `point`."""

    name: str = Field(description="of the joint")
    parent: str = Field(description="the body that the angle counts from")
    child: str = Field(description="the body that turns")
    point: SpacePoint = Field(description="a point of the axis in the drawn configuration, world axes")
    axis: Direction = Field(
        description="its direction, world axes; the child turns about it by the right hand"
    )
    stiffness: Stiffness = Field(0.0, description="torque per angle, towards the rest angle")
    damping: Damping = Field(0.0, description="torque per rate")
    rest_angle: AnyAngle = Field(0.0, description="angle at which its stiffness holds it; 0 is as drawn")
    limits: tuple[AnyAngle, AnyAngle] | None = Field(
        None, description="lowest and highest angle; free if not said"
    )


class MechanismModel(StrictModel):
    """Bodies and joints without a drawing."""

    kind: Literal["mechanism"] = Field("mechanism", description="what the file is")
    name: str | None = Field(None, description="of the mechanism; the file's name if not said")
    story: str = Field("", description="what the design is for and what it shows, a paragraph of plain text")
    units: LengthUnit = Field("m", description="the unit of every length written without one, such as mm")
    bodies: list[BodyModel] = Field(description="rigid bodies, one of them fixed")
    joints: list[JointModel] = Field(default=[], description="hinges between two bodies each")
    contact_points: list[Point] = Field(
        default=[], description="points of the drawing at which bodies may touch something"
    )
    scene: SceneModel | None = Field(None, description="what is simulated where no scene is named")
    scenes: ScenesModel = Field(default={})

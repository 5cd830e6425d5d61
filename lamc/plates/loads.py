"""What acts on a plate.

In: where, and how much. Out: records, checked by themselves. Never: meshes; whether a load touches anything is the
problem's to say.

Forces are positive along +x, +y, +z (w is up). `where` is as for supports.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from lamc.basics.checks import Array, checked_array, checked_name, checked_number
from lamc.plates.supports import Where, checked_where

Force: TypeAlias = float | Sequence[float]  # along z, or (x, y, z)
# A number, or a function of x and y, m, that takes and gives arrays.
Intensity: TypeAlias = float | Callable[[Array, Array], Array]


@dataclass(frozen=True, eq=False)
class PointLoad:
    """A force at a point anywhere on the plate.

    at     (x, y), m
    force  N along z, or (x, y, z)

    Right under it curvature and moments are infinite, and their values there grow as the mesh is refined. Raises
    DesignError.
    """

    at: Sequence[float]
    force: Force

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "at", tuple(checked_array(self.at, (2,), "the place of a PointLoad").tolist())
        )
        object.__setattr__(self, "force", _checked_force(self.force, "the force of a PointLoad"))


@dataclass(frozen=True, eq=False)
class EdgeLoad:
    """A force per length along edges of the mesh, inner ones too: N/m along z, or (x, y, z).

    A line may begin and end within an edge; an area stands for the boundary of the plate in it. Raises DesignError.
    """

    where: Where
    force: Force

    def __post_init__(self) -> None:
        checked_where(self.where, "an EdgeLoad")
        object.__setattr__(self, "force", _checked_force(self.force, "the force of an EdgeLoad"))


@dataclass(frozen=True, eq=False)
class EdgeMoment:
    """A moment per length, N, that bends like a positive M_n about the laminate's reference surface.

    On the right-hand edge of a plate it is M_x: it pulls at the upper face and turns the edge's slope down. It acts on
    edges of the boundary: which side of an inner line is outside would be anyone's guess. Raises DesignError.
    """

    where: Where
    moment: float

    def __post_init__(self) -> None:
        checked_where(self.where, "an EdgeMoment")
        object.__setattr__(self, "moment", checked_number(self.moment, "the moment of an EdgeMoment"))


@dataclass(frozen=True, eq=False)
class Pressure:
    """A force per area along +z, Pa; everywhere, or on the region named.

    intensity  a number, or a function of x and y that takes and gives arrays; it is taken at 16 points of each cell

    Raises DesignError.
    """

    intensity: Intensity
    region: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(
            self, "intensity", _checked_intensity(self.intensity, "the intensity of a Pressure")
        )
        _check_region(self.region, "a Pressure")


@dataclass(frozen=True, eq=False)
class SelfWeight:
    """Weight of the laminate's own mass: (gx, gy, gz), m/s². Raises DesignError."""

    acceleration: Sequence[float] = (0.0, 0.0, -9.81)

    def __post_init__(self) -> None:
        value = checked_array(self.acceleration, (3,), "the acceleration of SelfWeight")
        object.__setattr__(self, "acceleration", tuple(value.tolist()))


@dataclass(frozen=True, eq=False)
class Temperature:
    """Warmer by `rise` + `gradient` z than where the plate is free of stress; everywhere, or on the region named.

    rise      K, a number, or a function of x and y that takes and gives arrays
    gradient  K/m, likewise: through the thickness, z upwards from the laminate's reference surface. A free plate curls
              with κ = α gradient: hollow side down where the top is warmer

    Raises DesignError.
    """

    rise: Intensity
    region: str | None = None
    gradient: Intensity = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "rise", _checked_intensity(self.rise, "the rise of a Temperature"))
        object.__setattr__(
            self, "gradient", _checked_intensity(self.gradient, "the gradient of a Temperature")
        )
        _check_region(self.region, "a Temperature")

    @property
    def has_gradient(self) -> bool:
        """Whether it changes through the thickness."""
        return callable(self.gradient) or self.gradient != 0.0


@dataclass(frozen=True, eq=False)
class Moisture:
    """Mass of moisture over dry mass, `content` + `gradient` z; everywhere, or on the region named.

    content   a number, or a function of x and y that takes and gives arrays
    gradient  1/m, likewise: through the thickness, z upwards from the laminate's reference surface

    Raises DesignError.
    """

    content: Intensity
    region: str | None = None
    gradient: Intensity = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "content", _checked_intensity(self.content, "the content of a Moisture"))
        object.__setattr__(self, "gradient", _checked_intensity(self.gradient, "the gradient of a Moisture"))
        _check_region(self.region, "a Moisture")

    @property
    def has_gradient(self) -> bool:
        """Whether it changes through the thickness."""
        return callable(self.gradient) or self.gradient != 0.0


@dataclass(frozen=True, eq=False)
class ElectricField:
    """Field through the thickness of every piezoelectric ply, V/m, positive upwards; or one field per ply.

    Each is a number, or a function of x and y. Everywhere, or on the region named. Raises DesignError.
    """

    field: Intensity | Sequence[Intensity]
    region: str | None = None

    def __post_init__(self) -> None:
        what = "the field of an ElectricField"
        given = self.field
        if isinstance(given, np.ndarray) and given.ndim:
            given = checked_array(given, (len(given),), what).tolist()
        if isinstance(given, Sequence) and not isinstance(given, str):
            each = [_checked_intensity(value, f"{what} in ply {k}") for k, value in enumerate(given)]
            object.__setattr__(self, "field", tuple(each))
        else:
            object.__setattr__(self, "field", _checked_intensity(given, what))
        _check_region(self.region, "an ElectricField")


LoadRecord: TypeAlias = (
    PointLoad | EdgeLoad | EdgeMoment | Pressure | SelfWeight | Temperature | Moisture | ElectricField
)
LOADS = (PointLoad, EdgeLoad, EdgeMoment, Pressure, SelfWeight, Temperature, Moisture, ElectricField)
CLIMATES = (Temperature, Moisture, ElectricField)  # what makes a free laminate stretch and bend


def _checked_force(force: object, what: str) -> tuple[float, float, float]:
    """As (x, y, z)."""
    if isinstance(force, str) or not hasattr(force, "__len__"):
        return (0.0, 0.0, checked_number(force, f"{what} along z"))
    x, y, z = checked_array(force, (3,), what).tolist()
    return (x, y, z)


def _checked_intensity(value: object, what: str) -> Intensity:
    return value if callable(value) else checked_number(value, what)


def _check_region(region: object, what: str) -> None:
    if region is not None and region != "":  # the region of a mesh without names
        checked_name(region, f"the region of {what}")

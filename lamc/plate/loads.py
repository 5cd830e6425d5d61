"""What acts on a plate. Forces are positive along +x, +y, +z; `where` is as for supports."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from lamc.plate.supports import Where

Force: TypeAlias = float | Sequence[float]  # along z, or (x, y, z)
Intensity: TypeAlias = (
    float | Callable[[float, float], float]
)  # or a function of x, y in m, called with arrays


@dataclass(frozen=True, eq=False)
class PointLoad:
    """A force at a point anywhere on the plate, N."""

    at: tuple[float, float]  # m
    force: Force


@dataclass(frozen=True, eq=False)
class EdgeLoad:
    """A force per length, N/m, along edges."""

    where: Where
    force: Force


@dataclass(frozen=True, eq=False)
class EdgeMoment:
    """A moment per length, N, that bends like a positive M_n about the laminate's reference surface.

    On the right-hand edge of a plate it is M_x: it pulls at the upper face and turns the edge's slope down.
    """

    where: Where
    moment: float


@dataclass(frozen=True, eq=False)
class Pressure:
    """A force per area along +z, Pa; everywhere, or on the region named."""

    intensity: Intensity
    region: str | None = None


@dataclass(frozen=True, eq=False)
class Gravity:
    """Weight: (gx, gy, gz), m/s²."""

    acceleration: Sequence[float] = (0.0, 0.0, -9.81)


@dataclass(frozen=True, eq=False)
class Temperature:
    """Warmer by `rise` K than where the plate is free of stress; everywhere, or on the region named."""

    rise: float
    region: str | None = None


@dataclass(frozen=True, eq=False)
class Moisture:
    """Mass of moisture over dry mass."""

    content: float
    region: str | None = None


@dataclass(frozen=True, eq=False)
class ElectricField:
    """Field through the thickness of every piezoelectric ply, V/m, positive upwards; or one field per ply."""

    field: float | Sequence[float]
    region: str | None = None

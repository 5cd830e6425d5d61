"""How a plate is held. `where` is "boundary", or a shapely geometry: what lies on it within a tolerance."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from shapely.geometry.base import BaseGeometry

Where: TypeAlias = str | BaseGeometry


@dataclass(frozen=True, eq=False)
class Support:
    """The named unknowns are `value` there: any of "u", "v", "w" in m, "w_x", "w_y" without unit."""

    where: Where
    dofs: Sequence[str]
    value: float = 0.0


@dataclass(frozen=True, eq=False)
class Clamped:
    """Neither displacement nor slope."""

    where: Where


@dataclass(frozen=True, eq=False)
class SimplySupported:
    """No deflection; "hard": no slope along the edge either, "soft": free to twist."""

    where: Where
    kind: str = "hard"


@dataclass(frozen=True, eq=False)
class Symmetry:
    """No slope across the edge, and no displacement across it: the mirror image lies beyond."""

    where: Where

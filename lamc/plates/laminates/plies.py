"""What laminate theory speaks of: a ply, and what is known of a laminate or of one of its plies.

In: numbers. Out: records. Never: sums over plies, which are `laminate.py`'s.
"""

from dataclasses import dataclass

from lamc.basics.checks import Array, checked_number, shown
from lamc.basics.errors import DesignError
from lamc.plates.laminates.materials import Material


@dataclass(frozen=True)
class Ply:
    """One layer. Raises DesignError unless the thickness is positive, the gap not negative and all is finite.

    gap  empty space between it and the ply below, as where the layer between them is cut away; the two are held at
         their distance all the same, as by what stands beside the gap
    """

    material: Material
    thickness: float  # m
    angle: float = 0.0  # degrees, from plate axis x towards y to the fibres, seen from above
    gap: float = 0.0  # m

    def __post_init__(self) -> None:
        if not isinstance(self.material, Material):
            raise DesignError(
                f"the material of a ply is {shown(self.material)}; it must be a Material: "
                "make one, or take one by plate.material(name)"
            )
        thickness = checked_number(self.thickness, "the thickness of a ply")
        if thickness <= 0.0:
            raise DesignError(
                f"the thickness of a ply is {thickness:g} m; it must be positive: leave out a ply that is not there"
            )
        object.__setattr__(self, "thickness", thickness)
        object.__setattr__(self, "angle", checked_number(self.angle, "the angle of a ply"))
        object.__setattr__(self, "gap", checked_number(self.gap, "the gap below a ply", minimum=0.0))


@dataclass(frozen=True, eq=False)
class Resultants:
    """Force and moment per width, plate axes, about the laminate's reference surface."""

    force: Array  # (3,), N/m
    moment: Array  # (3,), N


@dataclass(frozen=True, eq=False)
class Deformation:
    """What the reference surface does, plate axes."""

    strain: Array  # (3,)
    curvature: Array  # (3,), 1/m, -(w_xx, w_yy, 2 w_xy)


@dataclass(frozen=True)
class EngineeringConstants:
    """Of the homogeneous sheet that stretches as the laminate does while it is kept from bending."""

    Ex: float  # Pa
    Ey: float  # Pa
    Gxy: float  # Pa
    nuxy: float


@dataclass(frozen=True, eq=False)
class PlyState:
    """Strain and stress in one ply; the rows are at its bottom and at its top, and between them all is linear."""

    ply: Ply
    z: Array  # (2,), m above the reference surface
    strain: Array  # (2, 3), plate axes, expansion included
    stress: Array  # (2, 3), Pa, plate axes
    strain_material: Array  # (2, 3), along and across the fibres
    stress_material: Array  # (2, 3), Pa

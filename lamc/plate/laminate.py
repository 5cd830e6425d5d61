"""Classical laminate theory: the stiffness of a stack of bonded plies, and the stress in each.

In: plies from bottom to top and a reference surface. Out: A, B, D, what warming and moisture do, deformation under
resultants, strain and stress in every ply. Never: transverse shear, failure, meshes.

    strain(z) = strain of the reference surface + z κ,   κ = -(w_xx, w_yy, 2 w_xy),   w and z up
    N = ∫ stress dz = A strain + B κ,   M = ∫ stress z dz = B strain + D κ

z is measured from the reference surface. A positive M_x bends the plate hollow side down, and pulls at its upper face.
Vectors are (x, y, xy), shear strain and twist in the engineering sense. Source: J. N. Reddy, Mechanics of Laminated
Composite Plates and Shells, 2nd ed. 2004, section 3.3; R. M. Jones, Mechanics of Composite Materials, 1999, chapter 4.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lamc.errors import DesignError
from lamc.mechanism.checks import Array, checked_array, checked_number, checked_records, shown
from lamc.plate.materials import Material, strain_rotation

_NONE = (0.0, 0.0, 0.0)
_SURFACES = {"bottom": -0.5, "middle": 0.0, "top": 0.5}  # height above the middle, in thicknesses


@dataclass(frozen=True)
class Ply:
    """One layer. Raises DesignError unless the thickness is positive and all is finite."""

    material: Material
    thickness: float  # m
    angle: float = 0.0  # degrees, from plate axis x towards y to the fibres, seen from above

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


@dataclass(frozen=True)
class Laminate:
    """Plies bonded to each other, bottom to top.

    reference  the surface that z, strain and moments refer to: "middle", "bottom", "top", or its height above the
               middle of the thickness, m
    A, B, D    shape (3, 3), N/m, N and N·m, symmetric; A and D positive definite; B zero about the middle of a
               symmetric stack

    Raises DesignError for no plies, things that are no plies, an unknown reference, and numbers so large or small
    that the stiffness is out of the range of floating-point numbers.
    """

    plies: Sequence[Ply]  # kept as a tuple
    reference: str | float = "middle"
    A: Array = field(init=False, repr=False, compare=False)
    B: Array = field(init=False, repr=False, compare=False)
    D: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        self._put("plies", checked_records(self.plies, Ply, "plies", "a laminate"))
        if not self.plies:
            raise DesignError("a laminate has no plies; give one at least, from bottom to top")
        if isinstance(self.reference, str):
            if self.reference not in _SURFACES:
                raise DesignError(
                    f"the reference surface of a laminate is {shown(self.reference)}; it must be one of "
                    f"{', '.join(sorted(_SURFACES))}, or a height above the middle in m"
                )
        else:
            self._put("reference", checked_number(self.reference, "the reference surface of a laminate"))
        self._set_stiffness()

    def _put(self, name: str, value: Any) -> None:
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
        object.__setattr__(self, name, value)

    def _set_stiffness(self) -> None:
        z = self.interfaces
        middle = 0.5 * (z[:-1] + z[1:])
        t = np.array([ply.thickness for ply in self.plies])  # differences of z far away have lost digits
        with np.errstate(over="ignore", invalid="ignore"):
            stiffness = np.array([ply.material.stiffness(ply.angle) for ply in self.plies])
            # Moments of each ply's thickness by its middle: differences of z³ would lose digits of thin plies.
            weights = (t, t * middle, t * (middle * middle + t * t / 12.0))
            A, B, D = (np.einsum("p,pij->ij", w, stiffness) for w in weights)
        if not np.isfinite([A, B, D]).all() or not (np.diag(D) > np.finfo(float).tiny).all():
            raise DesignError(
                f"the stiffness of a laminate of thickness {self.thickness:g} m is out of the range of floating-point "
                "numbers; thicknesses are in m and moduli in Pa: check the units"
            )
        for name, matrix in zip("ABD", (A, B, D), strict=True):
            self._put(name, matrix)

    @property
    def thickness(self) -> float:
        """Of all plies together, m."""
        return float(sum(ply.thickness for ply in self.plies))

    @property
    def reference_height(self) -> float:
        """Height of the reference surface above the middle of the thickness, m."""
        if isinstance(self.reference, str):
            return _SURFACES[self.reference] * self.thickness
        return self.reference

    @property
    def interfaces(self) -> Array:
        """Heights of the plies' faces above the reference surface, ascending, shape (plies + 1,), m."""
        heights = np.cumsum([0.0, *(ply.thickness for ply in self.plies)])
        return np.asarray(heights - 0.5 * heights[-1] - self.reference_height)

    @property
    def ABD(self) -> Array:  # noqa: N802  the field's symbol
        """[[A, B], [B, D]], shape (6, 6)."""
        return np.block([[self.A, self.B], [self.B, self.D]])

    @property
    def areal_mass(self) -> float:
        """Mass per area, kg/m²."""
        return float(sum(ply.material.density * ply.thickness for ply in self.plies))

    @property
    def engineering_constants(self) -> EngineeringConstants:
        """From the inverse of A, so for any reference surface the same.

        A stack that is not symmetric is softer than this where it is free to bend.
        """
        a = np.linalg.inv(self.A) * self.thickness
        return EngineeringConstants(
            Ex=float(1.0 / a[0, 0]),
            Ey=float(1.0 / a[1, 1]),
            Gxy=float(1.0 / a[2, 2]),
            nuxy=float(-a[0, 1] / a[0, 0]),
        )

    @property
    def thermal(self) -> Resultants:
        """Thermal resultants per kelvin, N/(m·K) and N/K: N = A strain + B κ - ΔT thermal.force, and M likewise."""
        return self._expansion(1.0, 0.0)

    @property
    def moisture(self) -> Resultants:
        """As `thermal`, per mass of moisture over dry mass: N/m and N."""
        return self._expansion(0.0, 1.0)

    def _expansion(self, temperature: float, moisture: float) -> Resultants:
        """The resultants that would stretch and bend an unheated, dry laminate as much."""
        z = self.interfaces
        force, moment = np.zeros(3), np.zeros(3)
        for ply, low, high in zip(self.plies, z[:-1], z[1:], strict=True):
            free = ply.material.free_strain(temperature, moisture)
            push = strain_rotation(ply.angle).T @ ply.material.Q @ free
            force += ply.thickness * push
            moment += ply.thickness * 0.5 * (low + high) * push
        return Resultants(force, moment)

    def deformation(
        self,
        force: Sequence[float] | Array = _NONE,
        moment: Sequence[float] | Array = _NONE,
        *,
        temperature: float = 0.0,
        moisture: float = 0.0,
    ) -> Deformation:
        """What the laminate does under `force` N/m and `moment` N per width, each (3,), and warmed by `temperature` K.

        Raises DesignError where these are not finite numbers of that shape.
        """
        expansion = self._expansion(*_checked_climate(temperature, moisture))
        N = checked_array(force, (3,), "the force per width on a laminate") + expansion.force
        M = checked_array(moment, (3,), "the moment per width on a laminate") + expansion.moment
        # In units of the thickness, where A and D are of one size: the answer does not depend on the unit of length.
        h = self.thickness
        scaled = np.block([[self.A, self.B / h], [self.B / h, self.D / h**2]])
        solution = np.linalg.solve(scaled, np.concatenate([N, M / h]))
        return Deformation(solution[:3], solution[3:] / h)

    def ply_states(
        self,
        strain: Sequence[float] | Array,
        curvature: Sequence[float] | Array = _NONE,
        *,
        temperature: float = 0.0,
        moisture: float = 0.0,
    ) -> tuple[PlyState, ...]:
        """Strain and stress of every ply, bottom to top, where the reference surface has `strain` (3,) and `curvature`
        (3,), 1/m, in a laminate that is `temperature` K warmer than where it is free of stress.

        Raises DesignError where these are not finite numbers of that shape.
        """
        strain0 = checked_array(strain, (3,), "the strain of a laminate")
        kappa = checked_array(curvature, (3,), "the curvature of a laminate")
        climate = _checked_climate(temperature, moisture)
        z = self.interfaces
        states = []
        for ply, low, high in zip(self.plies, z[:-1], z[1:], strict=True):
            ends = np.array([low, high])
            turn = strain_rotation(ply.angle)
            total = strain0 + np.outer(ends, kappa)
            along = total @ turn.T
            stress = (along - ply.material.free_strain(*climate)) @ ply.material.Q
            states.append(PlyState(ply, ends, total, stress @ turn, along, stress))
        return tuple(states)


def _checked_climate(temperature: float, moisture: float) -> tuple[float, float]:
    return (
        checked_number(temperature, "the rise in temperature of a laminate"),
        checked_number(moisture, "the moisture of a laminate"),
    )

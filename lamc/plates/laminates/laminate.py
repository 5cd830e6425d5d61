"""Classical laminate theory: the stiffness of a stack of bonded plies, and the stress in each.

In: plies from bottom to top and a reference surface. Out: A, B, D, what warming, moisture and electric fields do,
deformation under resultants, strain and stress in every ply, and what bears shear through the thickness. Never:
failure, meshes.

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

from lamc.basics.brief import brief, counted
from lamc.basics.checks import Array, checked_array, checked_number, checked_records, shown
from lamc.basics.errors import DesignError
from lamc.basics.once import lazy
from lamc.plates.laminates.free_strains import Fields, free_strains, free_strains_at
from lamc.plates.laminates.graded import Amount, Graded, is_of_places, number_of
from lamc.plates.laminates.layup import layup_angles
from lamc.plates.laminates.materials import Material, strain_rotation
from lamc.plates.laminates.plies import Deformation, EngineeringConstants, Ply, PlyState, Resultants
from lamc.plates.laminates.shear import shear_share, shear_warning
from lamc.plates.laminates.transverse import transverse_stiffness

_NONE = (0.0, 0.0, 0.0)
_SURFACES = {"bottom": -0.5, "middle": 0.0, "top": 0.5}  # height above the middle, in thicknesses


@dataclass(frozen=True)
class Laminate:
    """Plies bonded to each other, bottom to top.

    reference  the surface that z, strain and moments refer to: "middle", "bottom", "top", or its height above the
               middle of the thickness, m
    A, B, D    shape (3, 3), N/m, N and N·m, symmetric; A and D positive definite; B zero about the middle of a
               symmetric stack

    Raises DesignError for no plies, things that are no plies, a gap below the lowest, an unknown reference, and numbers
    so large or small that the stiffness is out of the range of floating-point numbers.
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
        if self.plies[0].gap > 0.0:
            raise DesignError(
                f"the lowest ply of a laminate has a gap of {self.plies[0].gap:g} m below it; a gap lies between two "
                "plies: give the height of the reference surface instead"
            )
        if isinstance(self.reference, str):
            if self.reference not in _SURFACES:
                raise DesignError(
                    f"the reference surface of a laminate is {shown(self.reference)}; it must be one of "
                    f"{', '.join(sorted(_SURFACES))}, or a height above the middle in m"
                )
        else:
            self._put("reference", checked_number(self.reference, "the reference surface of a laminate"))
        self._set_stiffness()

    def __repr__(self) -> str:
        thickness = sum(ply.thickness for ply in self.plies)
        at = "" if self.reference == "middle" else f"reference {self.reference!r}"
        return brief("Laminate", "", counted(len(self.plies), "ply", "plies"), f"{thickness:g} m thick", at)

    @classmethod
    def parse(
        cls, layup: str, material: Material, thickness: float, reference: str | float = "middle"
    ) -> "Laminate":
        """Of plies of one material and one thickness, m, from notation such as "[0/90/±45]s" (see `layup.py`).

        Raises DesignError with the place of what is wrong.
        """
        return cls([Ply(material, thickness, angle) for angle in layup_angles(layup)], reference)

    @classmethod
    def sandwich(cls, face: Ply | Sequence[Ply], core: Ply, reference: str | float = "middle") -> "Laminate":
        """A core between two faces, one the mirror image of the other; `face` is the lower one, from the bottom up.

        Raises DesignError.
        """
        lower = (face,) if isinstance(face, Ply) else checked_records(face, Ply, "face", "a sandwich")
        return cls((*lower, core, *lower[::-1]), reference)

    @classmethod
    def layer(
        cls, material: Material, thickness: float, angle: float = 0.0, height: float = 0.0
    ) -> "Laminate":
        """A single layer, as in a hinge, with its middle `height` m above the reference surface. Raises DesignError."""
        return cls([Ply(material, thickness, angle)], -checked_number(height, "the height of a layer"))

    def _put(self, name: str, value: Any) -> None:
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
        object.__setattr__(self, name, value)

    def _set_stiffness(self) -> None:
        middle = self.heights.mean(axis=1)
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
        """From the lowest face to the highest, m, gaps included."""
        return float(sum(ply.gap + ply.thickness for ply in self.plies))

    @property
    def reference_height(self) -> float:
        """Height of the reference surface above the middle of the thickness, m."""
        if isinstance(self.reference, str):
            return _SURFACES[self.reference] * self.thickness
        return self.reference

    @property
    def heights(self) -> Array:
        """Of each ply's lower and upper face above the reference surface, shape (plies, 2), m."""
        edges = np.cumsum([step for ply in self.plies for step in (ply.gap, ply.thickness)])
        return np.asarray(edges - 0.5 * edges[-1] - self.reference_height).reshape(-1, 2)

    @property
    def interfaces(self) -> Array:
        """Heights of all faces above the reference surface, ascending, m, shape (plies + 1,), and one more per gap."""
        heights = self.heights
        apart = [k > 0 and ply.gap > 0.0 for k, ply in enumerate(self.plies)]
        return np.concatenate(
            [
                heights[:1, 0],
                *([low, high] if a else [high] for a, (low, high) in zip(apart, heights, strict=True)),
            ]
        )

    @property
    def ABD(self) -> Array:  # noqa: N802  the field's symbol
        """[[A, B], [B, D]], shape (6, 6)."""
        return np.block([[self.A, self.B], [self.B, self.D]])

    @lazy
    def H(self) -> Array:  # noqa: N802  the field's symbol
        """Stiffness in shear through the thickness, (Q_x, Q_y) = H (γ_xz, γ_yz), shape (2, 2), N/m: by the energy of
        the plies' stresses (`transverse.py`), 5/6 G h for one isotropic ply. G13 and G23 default to G12. Raises
        DesignError for a gap."""
        found = transverse_stiffness(self.plies, self.heights, self.ABD)
        found.flags.writeable = False
        return found

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
        return self.expansion(temperature=1.0)

    @property
    def moisture(self) -> Resultants:
        """As `thermal`, per mass of moisture over dry mass: N/m and N."""
        return self.expansion(moisture=1.0)

    def expansion(
        self, temperature: float | Graded = 0.0, moisture: float | Graded = 0.0, fields: Fields = 0.0
    ) -> Resultants:
        """What warming by `temperature` K, `moisture` and electric `fields` do, as the resultants that would stretch
        and bend the untouched laminate as much: N = A strain + B κ - expansion.force, and M likewise.

        temperature, moisture  numbers, or `Graded` where they change through the thickness
        fields                 V/m along +z, in all plies or one per ply; plies without piezoelectric constants do not
                               mind

        Raises DesignError where these are not finite numbers, or not as many fields as plies.
        """
        force, moment = np.zeros(3), np.zeros(3)
        free = zip(*free_strains(self.plies, temperature, moisture, fields), strict=True)
        for ply, (level, slope), middle in zip(self.plies, free, self.heights.mean(axis=1), strict=True):
            stiffness = strain_rotation(ply.angle).T @ ply.material.Q
            push = stiffness @ (level + middle * slope)
            force += ply.thickness * push
            moment += ply.thickness * middle * push + ply.thickness**3 / 12.0 * (stiffness @ slope)
        return Resultants(force, moment)

    def deformation(
        self,
        force: Sequence[float] | Array = _NONE,
        moment: Sequence[float] | Array = _NONE,
        *,
        temperature: float | Graded = 0.0,
        moisture: float | Graded = 0.0,
        fields: Fields = 0.0,
    ) -> Deformation:
        """What the laminate does under `force` N/m and `moment` N per width, each (3,), and what `expansion` names.

        Raises DesignError where these are not finite numbers of that shape.
        """
        expansion = self.expansion(temperature, moisture, fields)
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
        temperature: float | Graded = 0.0,
        moisture: float | Graded = 0.0,
        fields: Fields = 0.0,
    ) -> tuple[PlyState, ...]:
        """Strain and stress of every ply, bottom to top, where the reference surface has `strain` (3,) and `curvature`
        (3,), 1/m, in a laminate with what `expansion` names.

        Raises DesignError where these are not finite numbers of that shape.
        """
        strain0 = checked_array(strain, (3,), "the strain of a laminate")
        kappa = checked_array(curvature, (3,), "the curvature of a laminate")
        free = zip(*free_strains(self.plies, temperature, moisture, fields), strict=True)
        states = []
        for ply, ends, (level, slope) in zip(self.plies, self.heights, free, strict=True):
            rotation = strain_rotation(ply.angle)
            total = strain0 + np.outer(ends, kappa)
            along = total @ rotation.T
            stress = (along - level - np.outer(ends, slope)) @ ply.material.Q
            states.append(PlyState(ply, ends, total, stress @ rotation, along, stress))
        return tuple(states)

    def material_stress(
        self,
        strain: Array,
        curvature: Array,
        *,
        temperature: Amount = 0.0,
        moisture: Amount = 0.0,
        fields: Fields = 0.0,
    ) -> Array:
        """Stress along and across the fibres at the lower and upper face of every ply, Pa, shape (..., plies, 2, 3),
        from strains (..., 3) and curvatures (..., 3) of many places at once; for a result, so nothing is checked.

        What expands is the same at all places; or temperature and moisture have shape (...) and fields (..., plies)."""
        if is_of_places(temperature) or is_of_places(moisture):
            level, slope = free_strains_at(self.plies, temperature, moisture, fields)
        else:
            level, slope = free_strains(self.plies, number_of(temperature), number_of(moisture), fields)
        free = level[..., :, None, :] + self.heights[:, :, None] * slope[..., :, None, :]
        rotations = np.array([strain_rotation(ply.angle) for ply in self.plies])
        Q = np.array([ply.material.Q for ply in self.plies])
        bend = np.asarray(curvature)[..., None, None, :]
        total = np.asarray(strain)[..., None, None, :] + self.heights[:, :, None] * bend
        along = np.einsum("pij,...pfj->...pfi", rotations, total) - free
        return np.asarray(np.einsum("pij,...pfj->...pfi", Q, along))

    def shear_share(self, length: float) -> float:
        """Deflection by shear through the thickness over that by bending, of a strip of `length` m that is held at both
        ends and free to turn; of plates, and where ends are clamped, it is several times as much
        (`Solution.shear_share`). inf across a gap. Raises DesignError."""
        return shear_share(self.plies, _checked_span(length))

    def shear_warning(self, length: float) -> str:
        """A sentence where the laminate is too thick or too soft in shear for classical theory in such a strip: h/a
        above 1/20, or a share above 5 %; else nothing. Raises DesignError."""
        return shear_warning(self.plies, _checked_span(length))


def _checked_span(length: float) -> float:
    span = checked_number(length, "the span of a laminate")
    if span <= 0.0:
        raise DesignError(f"the span of a laminate is {span:g} m; it must be positive")
    return span

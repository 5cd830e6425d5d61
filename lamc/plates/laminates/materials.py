"""Orthotropic materials in plane stress.

In: engineering constants in SI, in the material's own axes: 1 along the fibres, 2 across, in the plane. Out: the
reduced stiffness in these axes or in turned ones, free strains, and the strengths as they were given. Never:
thicknesses or stacking, which are `laminate.py`'s; numbers of real materials, which are `library.py`'s.

Vectors of strain are (x, y, xy) with the engineering shear strain γ = 2 ε_xy; vectors of stress are (x, y, xy). Source:
R. M. Jones, Mechanics of Composite Materials, 2nd ed. 1999, sections 2.5 and 2.6.
"""

import math
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array, checked_number, shown
from lamc.basics.errors import DesignError

STRENGTHS = ("Xt", "Xc", "Yt", "Yc", "S")
_NUMBERS = ("E1", "E2", "nu12", "G12", "density", "alpha1", "alpha2", "beta1", "beta2", "d31", "d32")
_OPTIONAL_MODULI = ("G13", "G23")


@dataclass(frozen=True)
class Material:
    """An orthotropic material as a thin ply shows it: plane stress, axes 1 and 2 in its plane.

    What is None is not known, and whatever needs it says so by an error that names it. Strengths are magnitudes.

    Raises DesignError where a number is not finite, a modulus or a strength not positive, a density negative, or |nu12|
    not below sqrt(E1/E2), beyond which some strain would release energy.
    """

    E1: float  # Pa
    E2: float  # Pa
    nu12: float  # strain along 2 over strain along 1, sign turned, under stress along 1
    G12: float  # Pa
    density: float  # kg/m³
    alpha1: float = 0.0  # 1/K, thermal expansion
    alpha2: float = 0.0  # 1/K
    beta1: float = 0.0  # expansion per mass of moisture over dry mass
    beta2: float = 0.0
    d31: float = (
        0.0  # m/V, free strain along 1 per field along z; negative for one that shortens, as PZT does
    )
    d32: float = 0.0  # m/V, along 2
    G13: float | None = None  # Pa, shear through the thickness, in the plane of 1 and z
    G23: float | None = None  # Pa
    Xt: float | None = None  # Pa, strength along 1 in tension
    Xc: float | None = None  # Pa, along 1 in compression
    Yt: float | None = None  # Pa, along 2
    Yc: float | None = None  # Pa
    S: float | None = None  # Pa, in shear in the plane
    name: str = ""
    source: str = ""  # where the numbers are printed

    def __post_init__(self) -> None:
        for text in ("name", "source"):
            if not isinstance(getattr(self, text), str):
                raise DesignError(f"{text} of a material is {shown(getattr(self, text))}; it must be text")
        what = f"material {self.name!r}" if self.name else "a material"
        for symbol in _NUMBERS:
            object.__setattr__(self, symbol, checked_number(getattr(self, symbol), f"{symbol} of {what}"))
        for symbol in (*_OPTIONAL_MODULI, *STRENGTHS):
            if getattr(self, symbol) is not None:
                object.__setattr__(self, symbol, checked_number(getattr(self, symbol), f"{symbol} of {what}"))
        for symbol in ("E1", "E2", "G12", *_OPTIONAL_MODULI):
            value = getattr(self, symbol)
            if value is not None and value <= 0.0:
                raise DesignError(
                    f"{symbol} of {what} is {value:g} Pa; a modulus must be positive: "
                    "for a layer without stiffness leave the ply out"
                )
        for symbol in STRENGTHS:
            value = getattr(self, symbol)
            if value is not None and value <= 0.0:
                raise DesignError(
                    f"{symbol} of {what} is {value:g} Pa; a strength is a magnitude and must be positive, in "
                    "compression too: leave it out where it is not known"
                )
        checked_number(self.density, f"density of {what}", minimum=0.0)
        if not self.nu12 * self.nu12 * (self.E2 / self.E1) < 1.0:
            bound = math.sqrt(self.E1) / math.sqrt(self.E2)
            raise DesignError(
                f"nu12 of {what} is {self.nu12:g}; |nu12| must be below sqrt(E1/E2) = {bound:.6g}: if this is nu21, "
                "give nu12 = nu21 E1/E2"
            )

    @classmethod
    def isotropic(
        cls,
        E: float,
        nu: float,
        density: float,
        alpha: float = 0.0,
        beta: float = 0.0,
        *,
        name: str = "",
        source: str = "",
    ) -> "Material":
        """The same in all directions: E in Pa, -1 < nu <= 1/2, density kg/m³, alpha 1/K; G = E / (2 (1 + nu)).

        Raises DesignError.
        """
        what = f"material {name!r}" if name else "a material"
        ratio = checked_number(nu, f"nu of {what}")
        if not -1.0 < ratio <= 0.5:
            raise DesignError(
                f"nu of {what} is {ratio:g}; an isotropic material has -1 < nu <= 1/2: correct it, or give E1, E2, "
                "nu12 and G12"
            )
        modulus = checked_number(E, f"E of {what}")
        if modulus <= 0.0:
            raise DesignError(
                f"E of {what} is {modulus:g} Pa; a modulus must be positive: for a layer without stiffness leave the "
                "ply out"
            )
        shear = modulus / (2.0 * (1.0 + ratio))
        return cls(
            E1=modulus,
            E2=modulus,
            nu12=ratio,
            G12=shear,
            density=density,
            alpha1=alpha,
            alpha2=alpha,
            beta1=beta,
            beta2=beta,
            G13=shear,
            G23=shear,
            name=name,
            source=source,
        )

    @property
    def Q(self) -> Array:  # noqa: N802  the field's symbol
        """Reduced stiffness in material axes, shape (3, 3), Pa: stress = Q strain."""
        rest = 1.0 - self.nu12 * self.nu12 * (self.E2 / self.E1)  # 1 - nu12 nu21
        coupling = self.nu12 * self.E2 / rest
        return np.array(
            [[self.E1 / rest, coupling, 0.0], [coupling, self.E2 / rest, 0.0], [0.0, 0.0, self.G12]]
        )

    def stiffness(self, angle: float) -> Array:
        """Reduced stiffness in plate axes, shape (3, 3), Pa, symmetric; fibres at `angle` degrees from x towards y."""
        rotation = strain_rotation(angle)
        rotated = rotation.T @ self.Q @ rotation
        return np.asarray(0.5 * (rotated + rotated.T))

    @property
    def is_isotropic(self) -> bool:
        """Whether it is the same in all directions of its plane."""
        return self.E1 == self.E2 and math.isclose(
            self.G12, self.E1 / (2.0 * (1.0 + self.nu12)), rel_tol=1e-9
        )

    @property
    def transverse_shear(self) -> Array:
        """G13 and G23, shape (2,), Pa; G12 for one that is not known, which across fibres is too high for G23."""
        return np.array([self.G12 if g is None else g for g in (self.G13, self.G23)])

    def free_strain(self, temperature: float = 0.0, moisture: float = 0.0, field: float = 0.0) -> Array:
        """Strain of the unloaded material, material axes, shape (3,): `temperature` K and `moisture` above the state
        without stress, `field` V/m along z."""
        along = self.alpha1 * temperature + self.beta1 * moisture + self.d31 * field
        across = self.alpha2 * temperature + self.beta2 * moisture + self.d32 * field
        return np.array([along, across, 0.0])


def strain_rotation(angle: float) -> Array:
    """Strain in plate axes to strain in material axes, shape (3, 3); its transpose takes stress the other way.

    `angle` in degrees, from plate axis x towards y to material axis 1.

    The angle is reduced to ±90° first, which is exact, and the cosine is the sine of the complement: so 0°, 45° and 90°
    are free of round-off, and so are half turns.
    """
    reduced = math.remainder(angle, 180.0)
    s = math.copysign(math.sin(math.radians(abs(reduced))), reduced)
    c = math.sin(math.radians(90.0 - abs(reduced)))
    return np.array(
        [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2.0 * c * s, 2.0 * c * s, c * c - s * s]]
    )

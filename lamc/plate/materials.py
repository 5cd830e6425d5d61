"""Orthotropic materials in plane stress.

In: engineering constants in SI, in the material's own axes: 1 along the fibres, 2 across, in the plane. Out: the
reduced stiffness in these axes or in turned ones, and a few materials whose numbers are printed somewhere. Never:
thicknesses or stacking, which are `laminate.py`'s.

Vectors of strain are (x, y, xy) with the engineering shear strain γ = 2 ε_xy; vectors of stress are (x, y, xy). Source:
R. M. Jones, Mechanics of Composite Materials, 2nd ed. 1999, sections 2.5 and 2.6.
"""

import math
from dataclasses import dataclass

import numpy as np

from lamc.errors import DesignError
from lamc.mechanism.checks import Array, checked_number, shown
from lamc.readonly import ReadOnlyDict


@dataclass(frozen=True)
class Material:
    """An orthotropic material as a thin ply shows it: plane stress, axes 1 and 2 in its plane.

    Raises DesignError where a number is not finite, a modulus not positive, a density negative, or |nu12| not below
    sqrt(E1/E2), beyond which some strain would release energy.
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
    name: str = ""
    source: str = ""  # where the numbers are printed

    def __post_init__(self) -> None:
        for text in ("name", "source"):
            if not isinstance(getattr(self, text), str):
                raise DesignError(f"{text} of a material is {shown(getattr(self, text))}; it must be text")
        what = f"material {self.name!r}" if self.name else "a material"
        for symbol in ("E1", "E2", "nu12", "G12", "density", "alpha1", "alpha2", "beta1", "beta2"):
            object.__setattr__(self, symbol, checked_number(getattr(self, symbol), f"{symbol} of {what}"))
        for symbol in ("E1", "E2", "G12"):
            if getattr(self, symbol) <= 0.0:
                raise DesignError(
                    f"{symbol} of {what} is {getattr(self, symbol):g} Pa; a modulus must be positive: "
                    "for a layer without stiffness leave the ply out"
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
        return cls(modulus, modulus, ratio, shear, density, alpha, alpha, beta, beta, name, source)

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
        turn = strain_rotation(angle)
        turned = turn.T @ self.Q @ turn
        return np.asarray(0.5 * (turned + turned.T))

    def free_strain(self, temperature: float = 0.0, moisture: float = 0.0) -> Array:
        """Strain of the unloaded material, material axes, shape (3,): `temperature` K and `moisture` above the state
        without stress."""
        along = self.alpha1 * temperature + self.beta1 * moisture
        across = self.alpha2 * temperature + self.beta2 * moisture
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


# An expansion that is not given here is not in the source, and counts as zero.
_TSAI_HAHN = "S. W. Tsai and H. T. Hahn, Introduction to Composite Materials, 1980"

LIBRARY: ReadOnlyDict[str, Material] = ReadOnlyDict(
    {
        entry.name: entry
        for entry in (
            Material(
                E1=181e9,
                E2=10.3e9,
                nu12=0.28,
                G12=7.17e9,
                density=1600.0,
                alpha1=0.02e-6,
                alpha2=22.5e-6,
                beta2=0.6,
                name="T300/5208",
                source=f"{_TSAI_HAHN}: carbon fibre in epoxy, 70 % fibres by volume",
            ),
            Material(
                E1=38.6e9,
                E2=8.27e9,
                nu12=0.26,
                G12=4.14e9,
                density=1800.0,
                alpha1=8.6e-6,
                alpha2=22.1e-6,
                beta2=0.6,
                name="Scotchply 1002",
                source=f"{_TSAI_HAHN}: E-glass in epoxy, 45 % fibres by volume",
            ),
            Material.isotropic(
                E=2.5e9,
                nu=0.34,
                density=1420.0,
                alpha=20e-6,
                name="Kapton HN",
                source="DuPont, Kapton HN data sheet: polyimide film at 23 °C",
            ),
            Material.isotropic(
                E=210e9,
                nu=0.3,
                density=7850.0,
                alpha=12e-6,
                name="steel",
                source="EN 1993-1-1:2005, 3.2.6; density EN 1993-1-2:2005, 3.2.2",
            ),
        )
    }
)


def material(name: str) -> Material:
    """The material of that name in `LIBRARY`. Raises DesignError with the names there are."""
    if name not in LIBRARY:
        raise DesignError(
            f"there is no material {shown(name)} in the library; there are {', '.join(sorted(LIBRARY))}: "
            "choose one, or give Material(E1=…, E2=…, nu12=…, G12=…, density=…)"
        )
    return LIBRARY[name]

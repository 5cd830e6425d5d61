"""The stiffness of a hinge's strip against all that its links may do to each other: a symmetric 6 by 6 matrix.

In: the laminate of the strip, its width L from link to link and its length b along the hinge line. Out: N·m/rad, N/rad
and N/m about the strip's middle. Never: geometry of designs, angles that are not small.

Axes: x across the hinge from link to link, y along the plate's normal, z along the hinge line. The links are rigid and
clamp both edges. About the middle nothing couples, but for laminates whose 16, 26 or B terms couple, and these terms
are left out:

    angle    D b / L                         about z: what hinge_stiffness gives
    twist_x  G J / L / (1 - tanh(λ/2)/(λ/2)) torsion about x with its warping held at both edges,
                                             G J = 4 D66 b (isotropic: G b t³/3), E Γ = D b³/12, λ = L √(G J / E Γ)
    twist_y  A b³ / (12 L)                   bending in the plane
    slide_x  A b / L                         stretch
    slide_y  1 / (L³/(12 D b) + L/S b)       across the plate: bending to an S, and shear through the thickness
    slide_z  1 / (L³/(A b³) + L/(κ A66 b))   in the plane: the same of a deep beam (Timoshenko)

A and D are those of a strip that cannot narrow along z (A11, D11; κ = 1) for b ≥ L, and that may (1/a11, 1/d11 and
κ = 5/6) for narrower ones, as for `hinge_stiffness`. Finite elements differ by 13 % at most, near b = L, and by 3 %
from b = 10 L on (`tests/plates/test_strip_stiffness.py`). Warping is what counts in hinges: free to warp, a strip ten
times as long as wide would be some hundred times softer in torsion. Sources: S. P. Timoshenko and J. M. Gere, Theory of
Elastic Stability, 2nd ed. 1961, section 5.3 (torsion with warping; Γ = b³ t³/144 of a thin rectangle); S.
P. Timoshenko, Strength of Materials I, 3rd ed. 1955, section 39 (shear).
"""

import math
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array, checked_kind, checked_number
from lamc.basics.errors import DesignError
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.shear import shear_compliance

DIRECTIONS = ("twist_x", "twist_y", "angle", "slide_x", "slide_y", "slide_z")
_SMALL = 0.05  # λ/2 below which 1 - tanh(x)/x is summed as a series: the difference would lose its digits


@dataclass(frozen=True)
class StripStiffness:
    """About the strip's middle, in the order of `DIRECTIONS`: N·m/rad three times, N/m three times."""

    twist_x: float
    twist_y: float
    angle: float
    slide_x: float
    slide_y: float
    slide_z: float

    @property
    def matrix(self) -> Array:
        """(6, 6), in the order of `DIRECTIONS`."""
        return np.diag([getattr(self, name) for name in DIRECTIONS])


def strip_stiffness(laminate: Laminate, width: float, length: float) -> StripStiffness:
    """Of a strip `width` m from link to link (laminate axis x) and `length` m along the hinge line (y).

    Raises DesignError where these are not positive.
    """
    checked_kind(laminate, Laminate, "the laminate of a hinge", "make one of plies, or by Laminate.layer")
    L, b = _positive(width, "width"), _positive(length, "length")
    stretch, shear, bend, turn, kappa = _rigidities(laminate, wide=b >= L)
    through, _ = shear_compliance(laminate.plies, 0.0)
    torsion, warping = 4.0 * turn * b, bend * b**3 / 12.0
    return StripStiffness(
        twist_x=torsion / L / _free_part(0.5 * L * math.sqrt(torsion / warping)),
        twist_y=stretch * b**3 / (12.0 * L),
        angle=bend * b / L,
        slide_x=stretch * b / L,
        slide_y=float(1.0 / (L**3 / (12.0 * bend * b) + L * through / b)),
        slide_z=1.0 / (L**3 / (stretch * b**3) + L / (kappa * shear * b)),
    )


def about(matrix: Array, along: float) -> Array:
    """A stiffness about a strip's middle, (6, 6), as one about a point of the hinge line `along` m before it on z.

    Displacements there are those of the point and ω × (0, 0, along).
    """
    moved = np.eye(6)
    moved[3, 1], moved[4, 0] = along, -along
    carried: Array = moved.T @ matrix @ moved
    return carried


def _rigidities(laminate: Laminate, *, wide: bool) -> tuple[float, float, float, float, float]:
    """Stretch and shear in the plane, N/m, bending and twisting, N·m, and κ; bending about its neutral surface."""
    A, B, D = laminate.A, laminate.B, laminate.D
    if wide:
        neutral = B[0, 0] ** 2
        rotated = B[2, 2] ** 2
        return (
            float(A[0, 0]),
            float(A[2, 2]),
            float(D[0, 0] - neutral / A[0, 0]),
            float(D[2, 2] - rotated / A[2, 2]),
            1.0,
        )
    # In units of the thickness: the inverse does not depend on the unit of length.
    h = laminate.thickness
    soft = np.linalg.inv(np.block([[A, B / h], [B / h, D / h**2]]))
    return (
        float(1.0 / soft[0, 0]),
        float(1.0 / soft[2, 2]),
        float(h**2 / soft[3, 3]),
        float(h**2 / soft[5, 5]),
        5.0 / 6.0,
    )


def _free_part(x: float) -> float:
    """1 - tanh(x)/x."""
    if x > _SMALL:
        return 1.0 - math.tanh(x) / x
    s = x * x
    return s / 3.0 * (1.0 - 0.4 * s * (1.0 - 17.0 / 42.0 * s * (1.0 - 62.0 / 153.0 * s)))


def _positive(value: float, what: str) -> float:
    number = checked_number(value, f"the {what} of a hinge's strip")
    if number <= 0.0:
        raise DesignError(f"the {what} of a hinge's strip is {number:g} m; it must be positive")
    return number

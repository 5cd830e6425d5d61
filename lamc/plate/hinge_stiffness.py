"""The stiffness of a hinge from its geometry and material: moment per angle of a strip that joins two rigid links.

In: the laminate of the strip, its width L from link to link and its length b along the axis. Out: N·m/rad by two
formulas. Never: geometry of designs.

The links turn by the angle φ against each other about the strip's long direction, y, and do nothing else; the strip
bends in x with κ_x = φ/L, and no force pulls at it (N_x = 0). Between the clamped edges it would curl across, as a bent
rubber does:

    plate   the links keep it from curling: κ_y = κ_xy = 0 and ε_y = γ_xy = 0, which is right for b >> L
                k = (D11 - B11²/A11) b / L
    beam    it curls as it likes: M_y = M_xy = 0 and N_y = N_xy = 0, which is right for b << L
                k = b / (d11 L),  d11 from the inverse of [[A, B], [B, D]]

An isotropic layer of thickness t has E t³ b / (12 L) as a beam and 1/(1 - ν²) times that as a plate. The truth lies
between. Source: S. P. Timoshenko and S. Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. 1959, chapters 1 and 2.
"""

from dataclasses import dataclass

import numpy as np

from lamc.errors import DesignError
from lamc.mechanism.checks import checked_number
from lamc.plate.laminate import Laminate


@dataclass(frozen=True)
class HingeStiffness:
    """N·m/rad, by each way."""

    plate_formula: float
    beam_formula: float
    width: float  # m, L
    length: float  # m, b

    @property
    def value(self) -> float:
        """By the formula that is nearer: the plate's from b = L on, the beam's for narrower strips."""
        return self.plate_formula if self.length >= self.width else self.beam_formula

    @property
    def formula(self) -> str:
        """ "plate" or "beam": where `value` comes from."""
        return "plate" if self.length >= self.width else "beam"


def hinge_stiffness(laminate: Laminate, width: float, length: float) -> HingeStiffness:
    """Of a strip `width` m from link to link (laminate axis x) and `length` m along the hinge's axis (y).

    Raises DesignError where these are not positive.
    """
    L, b = _checked(width, "width"), _checked(length, "length")
    A, B, D = laminate.A, laminate.B, laminate.D
    # In units of the thickness, as for a deformation: the inverse does not depend on the unit of length.
    h = laminate.thickness
    compliance = np.linalg.inv(np.block([[A, B / h], [B / h, D / h**2]]))[3, 3] / h**2
    return HingeStiffness(
        plate_formula=float((D[0, 0] - B[0, 0] ** 2 / A[0, 0]) * b / L),
        beam_formula=float(b / (L * compliance)),
        width=L,
        length=b,
    )


def _checked(value: float, what: str) -> float:
    number = checked_number(value, f"the {what} of a hinge")
    if number <= 0.0:
        raise DesignError(f"the {what} of a hinge is {number:g} m; it must be positive")
    return number

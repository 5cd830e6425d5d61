"""Stiffness in shear through the thickness: what shear forces meet that bend a laminate more and more along its way.

In: plies, heights, A, B, D. Out: H, (2, 2), N/m, with (Q_x, Q_y) = H (γ_xz, γ_yz). Never: a factor of 5/6 for every
stack; the stress in the plies decides.

Moments M with no membrane force stress the plies by σ(z) = a(z) M, where a = Q̄ (b + z d) and [b; d] are the columns of
[A B; B D]⁻¹ that moments multiply. In cylindrical bending about each axis M_x,x = Q_x and M_y,y = Q_y; equilibrium
of the plies from the lower face up, where there is no stress, gives

    τ_xz = -∫ a_11 dζ Q_x - ∫ a_32 dζ Q_y,     τ_yz = -∫ a_31 dζ Q_x - ∫ a_22 dζ Q_y,

say τ = f(z) Q, and their energy H⁻¹ = ∫ fᵀ G⁻¹ f dz. One isotropic ply: H = 5/6 G h; thin faces at distance d on a
soft core of thickness c: G d²/c. Source: R. Rolfes, K. Rohwer, Int. J. Numer. Meth. Engng 40, 1997, equations 8 to 20.
"""

import math
from collections.abc import Sequence

import numpy as np

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.plates.laminates.plies import Ply


def transverse_stiffness(plies: Sequence[Ply], heights: Array, ABD: Array) -> Array:
    """H, shape (2, 2), N/m, symmetric and positive definite. Raises DesignError for a gap, which bears no shear."""
    for number, ply in enumerate(plies):
        if ply.gap > 0.0:
            raise DesignError(
                f"there is a gap of {ply.gap:g} m between the plies {number - 1} and {number} of a laminate "
                "(counted from 0), and nothing in it bears shear through the thickness; give the gap a ply with G13 "
                "and G23, or take an element without shear, such as 'dkt'"
            )
    size = float(np.ptp(heights))  # in units of it, so that the unit of length does not matter
    scaled = ABD / np.outer(*[np.repeat([1.0, size], 3)] * 2)
    compliance = np.linalg.inv(scaled)[:, 3:]
    flow, flexibility = np.zeros((2, 2)), np.zeros((2, 2))
    for ply, (low, high) in zip(plies, heights / size, strict=True):
        stiffness = ply.material.stiffness(ply.angle)
        low_stress, high_stress = (stiffness @ (compliance[:3] + z * compliance[3:]) for z in (low, high))
        t = ply.thickness / size
        start, slope = _parts(low_stress), _parts(high_stress) - _parts(low_stress)
        softness = np.linalg.inv(_modulus(ply))
        for s, weight in zip(*_GAUSS, strict=True):
            f = flow - t * (start * s + 0.5 * slope * s * s)
            flexibility += weight * t * f.T @ softness @ f
        flow = flow - t * (start + 0.5 * slope)
    found = np.linalg.inv(size * flexibility)
    return np.asarray(0.5 * (found + found.T))


def _gauss() -> tuple[Array, Array]:
    """On [0, 1]; three points are exact to degree five, and f² has four."""
    x, weights = np.polynomial.legendre.leggauss(3)
    return 0.5 * (1.0 + x), 0.5 * weights


_GAUSS = _gauss()


def _parts(a: Array) -> Array:
    """Of a (3, 3), what Q_x and Q_y call for: [[a_11, a_32], [a_31, a_22]]."""
    return np.array([[a[0, 0], a[2, 1]], [a[2, 0], a[1, 1]]])


def _modulus(ply: Ply) -> Array:
    """G of τ = G γ in plate axes, (2, 2), Pa."""
    turn = math.radians(ply.angle)
    c, s = math.cos(turn), math.sin(turn)
    axes = np.array([[c, s], [-s, c]])
    return np.asarray(axes.T @ (ply.material.transverse_shear[:, None] * axes))

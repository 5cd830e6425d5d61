"""How much classical theory leaves out of a strip: shear through the thickness, estimated before anything is solved.

In: plies and a span. Out: the deflection by shear as a part of that by bending, and a sentence where it matters.
Never: a theory with shear in it; plates, of which `answers/shear_share.py` tells after they are solved.

A strip bends in x under a load of one half wave of length a. Equilibrium of the plies gives the shear stress
τ(z) = V g(z) / D with g(z) = ∫ Q11 (ζ - z0) dζ from the lower face, and its energy the shear stiffness

    1/S = ∫ g² / G dz / D²,      w_shear / w_bending = π² D / (S a²)

For one homogeneous layer S = 5/6 G h, for a soft core of thickness c between thin faces at distance d, S = G d²/c.
Source: J. M. Whitney, Structural Analysis of Laminated Anisotropic Plates, 1987, section 10.2.
"""

import math
from collections.abc import Sequence

import numpy as np

from lamc.plates.laminates.plies import Ply

THIN = 1 / 20  # thickness over span up to which a plate counts as thin
SMALL = 0.05  # part of the deflection that shear may add without a word


def shear_compliance(plies: Sequence[Ply], direction: float) -> tuple[float, float]:
    """1/S, m/N, and D, N·m, of a strip along `direction` degrees that cannot narrow; 1/S is inf across a gap."""
    modulus = np.array([ply.material.stiffness(ply.angle - direction)[0, 0] for ply in plies])
    edges = np.cumsum([step for ply in plies for step in (ply.gap, ply.thickness)])
    low, t = edges[::2], np.array([ply.thickness for ply in plies])
    middle = low + 0.5 * t
    neutral = (modulus * t) @ middle / (modulus @ t)
    arm = middle - neutral
    D = float(modulus @ (t * arm**2 + t**3 / 12))
    total, flow = 0.0, 0.0
    for k, ply in enumerate(plies):
        turn = math.radians(ply.angle - direction)
        G = np.array([math.cos(turn) ** 2, math.sin(turn) ** 2]) @ ply.material.transverse_shear
        a, b, h = modulus[k] * (low[k] - neutral), 0.5 * modulus[k], t[k]
        square = flow**2 * h + flow * (a * h**2 + 2 * b * h**3 / 3)
        square += a**2 * h**3 / 3 + a * b * h**4 / 2 + b**2 * h**5 / 5
        total += square / G
        flow += a * h + b * h**2
        if k + 1 < len(plies) and plies[k + 1].gap > 0.0:
            return math.inf, D
    return total / D**2, D


def shear_share(plies: Sequence[Ply], length: float) -> float:
    """Deflection by shear over that by bending, over a span of `length` m in x or in y, whichever is worse."""
    pairs = [shear_compliance(plies, direction) for direction in (0.0, 90.0)]
    return float(max(math.pi**2 * D * compliance / length**2 for compliance, D in pairs))


def shear_warning(plies: Sequence[Ply], length: float) -> str:
    """A sentence where the laminate is thick for a span of `length` m, or soft in shear; else nothing."""
    thickness = math.fsum(ply.thickness + ply.gap for ply in plies)
    share = shear_share(plies, length)
    if thickness <= THIN * length and share <= SMALL:
        return ""
    ratio = f"h/a = {thickness / length:.2g}"
    why = (
        f"{ratio}, above 1/20" if thickness > THIN * length else f"{ratio} and a layer that is soft in shear"
    )
    percent = float(f"{100 * share:.2g}")
    added = (
        "which gives way in a gap"
        if math.isinf(share)
        else f"which adds about {percent:g} % to the deflection"
    )
    return (
        f"the laminate's thickness over the shorter span is {why}: shear through the thickness, {added}, is left out "
        "by classical theory"
    )

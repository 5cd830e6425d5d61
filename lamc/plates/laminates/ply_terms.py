"""What one ply adds to its laminate, and how that changes with the ply: the formulas of `laminate.py`, staged.

In: nothing. Out: a staged function of one ply's numbers, `PLY_NUMBERS`, that gives its terms, `TERMS`, and their
derivatives by each of these numbers. Never: whole laminates, meshes, C text. The terms of a laminate are the sums over
its plies, so one function, compiled once, serves every laminate.

Source: R. M. Jones, Mechanics of Composite Materials, 2nd ed. 1999, section 2.6 (stiffness of a turned ply, in powers
of sine and cosine) and 4.2; the derivatives are those of the staged store.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

from lamc.symbolic.derivative import derivatives
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value, cos, sin
from lamc.symbolic.staging import Store

# Pa, Pa, -, Pa; degrees; m; m, of the ply's middle above the reference surface; free strains along and across; kg/m³
PLY_NUMBERS = ("E1", "E2", "nu12", "G12", "angle", "thickness", "height", "free1", "free2", "density")
_ENTRIES = ("11", "12", "16", "22", "26", "66")
# A, B, D (unique entries), resultants of the expansion, mass per area: N/m, N, N·m; N/m, N; kg/m²
TERMS = (
    *(f"{matrix}{entry}" for matrix in "ABD" for entry in _ENTRIES),
    *(f"{kind}{axis}" for kind in "NM" for axis in ("x", "y", "xy")),
    "areal_mass",
)
STIFFNESS, EXPANSION, MASS = slice(0, 18), slice(18, 24), 24  # where these are in TERMS


@dataclass(frozen=True)
class PlyEquations:
    """`values`: one per term; `slopes[i][j]`: of term i by number j of the ply."""

    store: Store
    numbers: tuple[Value, ...]
    values: tuple[Scalar, ...]
    slopes: tuple[tuple[Scalar, ...], ...]


@cache
def ply_equations() -> PlyEquations:
    """The terms of one ply and their derivatives, staged."""
    store = Store()
    numbers = tuple(store.symbol(name, Space.PLY, k) for k, name in enumerate(PLY_NUMBERS))
    with store.section("terms of a ply", source="Jones 1999, sections 2.6 and 4.2"):
        values = _terms(dict(zip(PLY_NUMBERS, numbers, strict=True)))
    with store.section("their derivatives"):
        columns = [derivatives(values, {number: 1}) for number in numbers]
    return PlyEquations(store, numbers, tuple(values), tuple(zip(*columns, strict=True)))


def _terms(ply: dict[str, Value]) -> list[Scalar]:
    rotated = ply["angle"] * (math.pi / 180.0)
    c, s = cos(rotated), sin(rotated)
    stiffness, push = _rotated_ply(ply, c, s)
    t, z = ply["thickness"], ply["height"]
    weights = (t, t * z, t * (z * z + t * t / 12))
    return [
        *(weight * entry for weight in weights for entry in stiffness),
        *(weight * component for weight in weights[:2] for component in push),
        ply["density"] * t,
    ]


def _rotated_ply(ply: dict[str, Value], c: Scalar, s: Scalar) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
    """The reduced stiffness in plate axes, unique entries, Pa, and the stress that holds the free strains back, Pa."""
    E1, E2, nu = ply["E1"], ply["E2"], ply["nu12"]
    rest = 1 - nu * nu * E2 / E1
    q11, q22, q66 = E1 / rest, E2 / rest, ply["G12"]
    q12 = nu * q22
    cc, ss, cs = c * c, s * s, c * s
    both = q12 + 2 * q66
    stiffness = (
        q11 * cc * cc + 2 * both * ss * cc + q22 * ss * ss,
        (q11 + q22 - 4 * q66) * ss * cc + q12 * (ss * ss + cc * cc),
        (q11 - both) * cs * cc + (both - q22) * ss * cs,
        q11 * ss * ss + 2 * both * ss * cc + q22 * cc * cc,
        (q11 - both) * cs * ss + (both - q22) * cc * cs,
        (q11 + q22 - 2 * q12 - 2 * q66) * ss * cc + q66 * (ss * ss + cc * cc),
    )

    first, second = q11 * ply["free1"] + q12 * ply["free2"], q12 * ply["free1"] + q22 * ply["free2"]
    return stiffness, (cc * first + ss * second, ss * first + cc * second, cs * (first - second))

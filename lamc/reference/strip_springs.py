"""Stiffness of a hinge's strip across its axis, by flexibilities and least energy, beside that of the equations.

In: an effect `twist_compliance` that says all of a strip: sizes and moduli. Out: comparisons. The strip is a beam of an
isotropic sheet between rigid clamps. Strips that come from a drawing have the stiffness that the effect finds there.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from lamc.mechanics.arranging import arrange
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism
from lamc.reference.check_report import Comparison, Largest
from lamc.reference.kinematics import Array

LIMIT = 1e-10  # round-off of the solution for polynomials of degree 40, where boundary layers are not too thin for them
_REASON = "energies and flexibilities by quadrature; torsion by polynomials of degree 40"
_DEGREE = 40
_THIN = 0.02  # of the width: the thinnest boundary layer of torsion that such polynomials resolve
_SIZES = ("width", "length", "thickness", "E", "nu")


def strip_springs(mechanism: Mechanism, effects: Iterable[Any]) -> list[Comparison]:
    """Diagonals of K of the hinges that yield and of which the scene says all; nothing without such hinges."""
    effects = tuple(effects)
    yielding = next((effect for effect in effects if effect.name == "twist_compliance"), None)
    if yielding is None:
        return []
    arrangement = arrange(plan(mechanism), effects)
    hinges = [*arrangement.compliant, *(bushing.hinge for bushing in arrangement.bushings)]
    given = {hinge.joint: _reported(yielding, hinge.joint) for hinge in hinges}
    known = [hinge for hinge in hinges if given[hinge.joint] is not None]
    if not known:
        return []
    largest = Largest(tuple(hinge.joint for hinge in known), ("equations", "flexibilities"))
    own = np.array([_springs(*given[hinge.joint]) for hinge in known])  # type: ignore[misc]
    found = np.array([hinge.stiffness for hinge in known])
    expected = np.zeros_like(found)
    expected[:, range(6), range(6)] = own
    # Entries differ in unit and by orders of magnitude: each is one against its own.
    root = np.sqrt(np.where(own > 0.0, own, 1.0))
    scale = root[:, :, None] * root[:, None, :]
    largest.add(found / scale, expected / scale, "drawn")
    return [largest.comparison("strip stiffness", LIMIT, _REASON)]


def _reported(effect: Any, joint: str) -> tuple[float, ...] | None:
    """width, length, thickness, E, nu; None where any is left to the drawing, or torsion is beyond the polynomials."""
    values: list[float] = []
    for name in _SIZES:
        amount = getattr(effect, name)
        amount = amount.get(joint) if isinstance(amount, Mapping) else amount
        if amount is None:
            return None
        values.append(float(amount))
    L, b, nu = values[0], values[1], values[4]
    return tuple(values) if b / np.sqrt(24.0 * (1.0 - nu)) > _THIN * L else None


def _springs(L: float, b: float, t: float, E: float, nu: float) -> Array:
    """(6,), the order of the records' freedoms; nought for the angle. L from clamp to clamp, b along the hinge line."""
    wide = b >= L
    shear = 0.5 * E / (1.0 + nu) * t  # N/m
    sheet = E * t / (1.0 - nu**2) if wide else E * t  # N/m; a wide strip cannot narrow
    across = t**2 / 12.0
    points, weights = legendre.leggauss(_DEGREE)
    place = 0.5 * (1.0 + points)  # along the strip, over L
    weights = 0.5 * weights
    along = b * points / 2.0  # of the hinge line, m
    in_plane = sheet * float(weights @ along**2) * b  # N·m²
    out_of_plane = sheet * across * b
    arm = float(weights @ (L * (place - 0.5)) ** 2) * L  # ∫ of the lever arm squared, from the middle, m³
    through = 6.0 / 5.0 / shear
    in_sheet = 1.0 / shear if wide else 6.0 / 5.0 / shear
    twist = _torsion(4.0 * shear * across * b, sheet * across * b**3 / 12.0, L)
    slide_y = 1.0 / (arm / out_of_plane + L * through / b)
    slide_z = 1.0 / (arm / in_plane + L * in_sheet / b)
    return np.array([twist, in_plane / L, 0.0, sheet * b / L, slide_y, slide_z])


def _torsion(rigidity: float, warping: float, L: float) -> float:
    """Twice the least energy ½ ∫ (rigidity θ'² + warping θ''²) of a turn by 1 rad without warping at both ends."""
    points, weights = legendre.leggauss(_DEGREE + 2)
    # θ' = Σ c_k P_k over L; ∫ θ' = 1, and θ' = 0 at both ends
    table = np.eye(_DEGREE + 1)
    value = np.array([legendre.legval(points, row) for row in table])
    slope = np.array([legendre.legval(points, legendre.legder(row)) for row in table]) * 2.0 / L
    parts = 0.5 * L * weights
    energy = rigidity * (value * parts) @ value.T + warping * (slope * parts) @ slope.T
    held = np.array([value @ parts, *([legendre.legval(end, row) for row in table] for end in (-1.0, 1.0))])
    count = len(table)
    size = float(np.abs(energy).max())
    system = np.block([[energy / size, held.T / L], [held / L, np.zeros((3, 3))]])
    shape = np.linalg.solve(system, np.append(np.zeros(count), [1.0 / L, 0.0, 0.0]))[:count]
    return float(shape @ energy @ shape)

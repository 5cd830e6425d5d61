"""Nonlinear stiffness and stops of hinges as numbers: torque and energy of each law, from its plain data.

An independent reading: curves come from scipy, energies of formulas from quadrature, torques of energies from
differences of order 8. Nothing is shared with the staged form.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.polynomial import polynomial
from scipy.integrate import quad
from scipy.interpolate import CubicSpline, PchipInterpolator

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Joint, Mechanism
from lamc.reference.expression import Formula, Values, parse

STANDARD_GRAVITY = 9.81  # m/s², as the text of stops says that weight is counted
_STEP = 2e-3  # rad; differences of order 8 then have errors of 1e-13, by round-off and by the ninth derivative alike
_WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)


def laws(
    data: Mapping[str, Any], joints: Sequence[Joint]
) -> tuple[list[tuple[int, Formula]], list[tuple[int, Formula]]]:
    """(index of the joint, torque on it, N·m), and (index, energy, J), as functions of its angle.

    Raises DesignError for a joint that is not there.
    """
    index = {joint.name: k for k, joint in enumerate(joints)}
    torques, energies = [], []
    for name in sorted(data):
        if name not in index:
            raise DesignError(f"the scene stiffens joint {name!r}, which the mechanism does not have")
        restoring, energy = _law(data[name])
        rest = joints[index[name]].rest_angle
        torques.append((index[name], _at(restoring, rest, -1.0)))
        energies.append((index[name], _at(energy, rest, 1.0)))
    return torques, energies


def stops(
    mechanism: Mechanism, effect: Any, joints: Sequence[Joint]
) -> tuple[list[tuple[int, Formula]], list[tuple[int, Formula]]]:
    """Of an effect `joint_limits`: (index of the joint, torque on it, N·m), and (index, energy, J), beyond each limit.

    Nothing where limits are impacts: between these, they do nothing.
    """
    if effect.restitution is not None:
        return [], []
    mass = sum(body.mass for body in mechanism.bodies if not body.fixed)
    stiffness, damping = effect.stiffness, effect.damping or 0.0
    if stiffness is None:
        stiffness = 100.0 * mass * STANDARD_GRAVITY * mechanism.size
        if effect.damping is None:
            damping = 0.3 * 2.0 * math.sqrt(stiffness * mass) * mechanism.size
    torques, energies = [], []
    for k, joint in enumerate(joints):
        for limit, sense in zip(joint.limits, (-1.0, 1.0), strict=True):
            if effect.flat_fold or abs(limit) < math.pi - 1e-12:
                torque, energy = _stop(limit, sense, stiffness, damping)
                torques.append((k, torque))
                energies.append((k, energy))
    return torques, energies


def _stop(limit: float, sense: float, stiffness: float, damping: float) -> tuple[Formula, Formula]:
    def depth(values: Values) -> float:
        return max(0.0, sense * (values["angle"] - limit))

    def torque(values: Values) -> float:
        inside = depth(values)
        return -sense * stiffness * inside - (damping * values["rate"] if inside > 0.0 else 0.0)

    return torque, lambda values: 0.5 * stiffness * depth(values) ** 2


def _at(function: Any, rest: float, sign: float) -> Formula:
    return lambda values: sign * float(function(values["angle"] - rest))


def _law(data: Any) -> tuple[Any, Any]:
    """Restoring torque and energy as functions of the angle from the rest."""
    if isinstance(data, str):
        torque = _formula(data)
        return torque, lambda angle: quad(torque, 0.0, angle, epsabs=1e-13, epsrel=1e-12)[0]
    if not isinstance(data, Mapping):
        coefficients = [0.0, *data]
        integral = polynomial.polyint(coefficients)
        return (lambda a: polynomial.polyval(a, coefficients)), (lambda a: polynomial.polyval(a, integral))
    if "energy" in data:
        energy = _formula(data["energy"])
        return (lambda angle: _difference(energy, angle)), (lambda angle: energy(angle) - energy(0.0))
    angles, torques = np.array(data["table"]).T
    if data["between"] == "spline":
        curve = CubicSpline(angles, torques, bc_type="natural")
    else:
        curve = PchipInterpolator(angles, torques)
    area = curve.antiderivative()

    def straight(angle: float) -> tuple[float, float]:
        """Nearest angle of the table, and how far the angle lies outside it."""
        nearest = min(max(angle, angles[0]), angles[-1])
        return nearest, angle - nearest

    def torque_of(angle: float) -> float:
        nearest, outside = straight(angle)
        return float(curve(nearest) + outside * curve(nearest, 1))

    def area_to(angle: float) -> float:
        nearest, outside = straight(angle)
        return float(area(nearest) + outside * curve(nearest) + 0.5 * outside**2 * curve(nearest, 1))

    return torque_of, lambda angle: area_to(angle) - area_to(0.0)


def _formula(text: str) -> Any:
    formula = parse(text)

    def evaluate(angle: float) -> float:
        values: Values = {"t": 0.0, "angle": angle, "rate": 0.0}
        return formula(values)

    return evaluate


def _difference(function: Any, x: float) -> float:
    """The derivative by central differences of order 8."""
    pairs = enumerate(_WEIGHTS, start=1)
    return float(sum(w * (function(x + k * _STEP) - function(x - k * _STEP)) for k, w in pairs) / _STEP)

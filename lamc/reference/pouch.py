"""Pouches across hinges as numbers: torque at an angle, from the geometry of their film or from a table.

An independent reading: the arc's angle by bisection, the volume's slope by the arc's pull on the links, curves from
scipy. Nothing is imported from the effect.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Joint
from lamc.reference.expression import Formula, Values, parse

_FLAT = 1e-4  # rad, below which the arc's angle is taken from its series


def pouch(effect: Any, joints: Sequence[Joint]) -> tuple[int, Formula]:
    """Index of the joint, and torque on it, N·m. Raises DesignError for a joint that is not there."""
    names = [joint.name for joint in joints]
    if effect.joint not in names:
        raise DesignError(
            f"the scene puts a pouch on joint {effect.joint!r}, which the mechanism does not have"
        )
    pressure = parse(effect.pressure) if isinstance(effect.pressure, str) else lambda _: effect.pressure
    side = -1.0 if effect.reverse else 1.0

    def by_film(values: Values) -> float:
        bent = side * (values["angle"] - effect.flat_angle)
        area = effect.length**2 * effect.width
        return float(side * max(pressure(values), 0.0) * area * _slope(bent))

    def by_table(values: Values) -> float:
        return _measured(effect, max(pressure(values), 0.0), values["angle"])

    return names.index(effect.joint), by_film if effect.torques is None else by_table


def _slope(bent: float) -> float:
    """dV/dφ over length² width: of two links of half the length each, and an arc of the length from end to end."""
    size = min(abs(bent), math.pi)
    links = 0.125 * math.cos(size)
    if size < _FLAT:
        film = 0.25 / math.sqrt(3.0)
    else:
        chord = math.cos(0.5 * size)
        arc = brentq(lambda a: math.sin(a) / a - chord, 1e-9, math.pi, xtol=1e-16, rtol=1e-15)
        # pressure times radius pulls each end along the arc: by virtual work on the chord, whose rate is -sin(φ/2)/2
        film = 0.5 * math.cos(arc) / (2.0 * arc) * math.sin(0.5 * size)
    return links + film if bent >= 0.0 else links - film


def _measured(effect: Any, pressure: float, angle: float) -> float:
    rows = np.vstack([np.zeros(len(effect.angles)), np.array(effect.torques)])
    curves = CubicSpline(effect.angles, rows, axis=1, bc_type="natural")
    nearest = min(max(angle, effect.angles[0]), effect.angles[-1])
    torques = curves(nearest) + (angle - nearest) * curves(nearest, 1)
    knots = np.array([0.0, *effect.pressures])
    k = min(int(np.searchsorted(knots, pressure, side="right")) - 1, len(knots) - 2)
    share = (pressure - knots[k]) / (knots[k + 1] - knots[k])
    return float(torques[k] + share * (torques[k + 1] - torques[k]))

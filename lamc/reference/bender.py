"""Piezoelectric benders in numbers: the strip as plies in plane stress and as a beam; forces and torques out.

In: an effect's own numbers. Out: what it does at a state. The cross section is found by least energy, summed over
points through the plies, and the beam by quadrature along it: no A, B and D, and no closed form of a cantilever. With
the effect it shares the text of the drive, which a parser of its own reads.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Joint
from lamc.reference.expression import Formula, Values, parse
from lamc.reference.kinematics import cross
from lamc.reference.point_loads import BodyState, Push

Array = npt.NDArray[np.float64]
_UNIT, _WEIGHT = (0.5 * x for x in np.polynomial.legendre.leggauss(3))  # exact for degree 5, on (-1/2, 1/2)


@dataclass(frozen=True)
class Section:
    """Of a strip that is free to bend across: free curvature along it, w_xx, 1/(m·V), and bending stiffness, N·m²."""

    curvature: float
    rigidity: float


def section(effect: Any) -> Section:
    """By least energy of ε + z κ in plies that would have the strain of the field if they were free."""
    plies = effect.laminate.plies
    stiffness, push = np.zeros((6, 6)), np.zeros(6)
    thickness = sum(ply.thickness + ply.gap for ply in plies)
    bottom = -0.5 * thickness
    for ply, polarity in zip(plies, effect.polarity, strict=True):
        material, bottom = ply.material, bottom + ply.gap
        c, s = math.cos(math.radians(ply.angle)), math.sin(math.radians(ply.angle))
        # Strains along and across the fibres from those along x and y; the last one is the shear angle.
        rotation = np.array(
            [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]]
        )
        soft = np.diag([1.0 / material.E1, 1.0 / material.E2, 1.0 / material.G12])
        soft[0, 1] = soft[1, 0] = -material.nu12 / material.E1
        hard = np.linalg.inv(soft)
        free = polarity / ply.thickness * np.array([material.d31, material.d32, 0.0])  # per volt
        for place, weight in zip(_UNIT, _WEIGHT, strict=True):
            z = bottom + (0.5 + place) * ply.thickness
            rows = rotation @ np.hstack(
                [np.eye(3), -z * np.eye(3)]
            )  # of the strain, and of (w_xx, w_yy, 2 w_xy)
            stiffness += weight * ply.thickness * rows.T @ hard @ rows
            push += weight * ply.thickness * rows.T @ hard @ free
        bottom += ply.thickness
    scale = np.repeat([1.0, 1.0 / thickness], 3)  # strains and curvatures in one unit
    scaled = stiffness * np.outer(scale, scale)
    free_shape = scale * np.linalg.solve(scaled, scale * push)
    bent = scale * np.linalg.solve(scaled, scale * np.eye(6)[3])  # under a moment of 1 N per width
    return Section(float(free_shape[3]), effect.width / float(bent[3]))


@dataclass(frozen=True)
class PushingBender:
    """A strip clamped on `bodies[0]`, whose tip pushes `bodies[1]` along the normal; points as drawn, m."""

    bodies: tuple[str, str]
    tip: Array
    normal: Array
    stiffness: float  # N/m
    per_volt: float  # m/V, deflection of the free tip
    voltage: Formula

    effect = "piezo_bender"

    def pushes(self, t: float, place: BodyState) -> list[Push]:
        """Two forces on one line, that of the tip of the second body: the first body is pushed there as a rigid one."""
        normal, apart, beyond = self._state(t, place)
        force = -self.stiffness * beyond * normal
        first, second = self.bodies
        return [Push(second, self.tip, force), Push(first, self.tip, -force, cross(apart, -force))]

    def stored(self, t: float, place: BodyState) -> float:
        return 0.5 * self.stiffness * self._state(t, place)[2] ** 2

    def _state(self, t: float, place: BodyState) -> tuple[Array, Array, float]:
        """The normal, the way between the tips of both bodies, m, and the deflection beyond the free one, m."""
        here, there = (place.point(body, self.tip)[0] for body in self.bodies)
        normal = place.direction(self.bodies[0], self.normal)
        apart = there - here
        volts = self.voltage({"t": t, "angle": 0.0, "rate": 0.0})
        return normal, apart, float(normal @ apart) - self.per_volt * volts


def pushing_bender(effect: Any) -> PushingBender:
    """The tip's stiffness and free deflection by the principle of virtual forces: a force at the tip bends the laminate
    by its distance from there."""
    own, length = section(effect), math.dist(effect.tip, effect.root) - effect.extension
    at = (0.5 + _UNIT) * length
    arms, parts = effect.extension + length - at, _WEIGHT * length
    return PushingBender(
        (effect.body_a, effect.body_b),
        np.array(effect.tip),
        np.array(effect.normal) / np.linalg.norm(effect.normal),
        own.rigidity / float(parts @ arms**2),
        own.curvature * float(parts @ arms),
        _volts(effect),
    )


def folding_bender(effect: Any, joints: Sequence[Joint]) -> tuple[int, Formula, Formula]:
    """Index of the joint that a strip across it bends, torque on it, N·m, and stored energy, J.

    Both ends are clamped: turning the hinge by a small angle moves the tip and its slope, and a cubic lies between.
    Raises DesignError for a joint that is not there.
    """
    names = [joint.name for joint in joints]
    if effect.hinge not in names:
        raise DesignError(
            f"the scene lays a bender across joint {effect.hinge!r}, which the mechanism does not have"
        )
    joint = joints[names.index(effect.hinge)]
    own, along = section(effect), np.subtract(effect.tip, effect.root)
    length = float(np.linalg.norm(along))
    sense = 1.0 if joint.parent == effect.body_a else -1.0
    rotated = sense * cross(joint.axis, np.subtract(effect.tip, joint.point))  # by one radian; of the tip, m
    up = np.array(effect.normal) / np.linalg.norm(effect.normal)
    rise, slope = float(rotated @ up), float(sense * cross(joint.axis, along / length) @ up)
    x = 0.5 + _UNIT
    second = ((6.0 - 12.0 * x) * rise / length + (6.0 * x - 2.0) * slope) / length  # w_xx of that cubic
    weights = own.rigidity * _WEIGHT * length
    stiffness = float(weights @ second**2)
    driven = float(weights @ second) * own.curvature / stiffness  # rad/V, the angle at which nothing pushes
    volts = _volts(effect)

    def beyond(values: Values) -> float:
        return values["angle"] - driven * volts(values)

    return (
        names.index(effect.hinge),
        lambda values: -stiffness * beyond(values),
        lambda values: 0.5 * stiffness * beyond(values) ** 2,
    )


def _volts(effect: Any) -> Formula:
    return parse(effect.voltage) if isinstance(effect.voltage, str) else lambda _: float(effect.voltage)

"""Contact with the ground in numbers: the force on each point at a state, and the energy in the ground.

In: an effect's own numbers, and the motion of the bodies. Out: forces, N, and moments, N·m. Written from the law
and the effect's text; shares nothing with the symbolic form but the choice of the points.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.effects.contact_points import contact_points
from lamc.records.mechanism import Mechanism
from lamc.reference.point_loads import BodyState, Push

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Ground:
    """A plane with points that can touch it; bodies (k) by name, points (k, 3), m, as drawn."""

    normal: Array
    height: float  # m
    stiffness: float  # N/m^exponent
    exponent: float
    damping: float  # s/m
    sliding: float  # coefficients of friction
    static: float
    slip_speed: float  # m/s
    bodies: tuple[str, ...]
    points: Array

    effect = "ground_contact"

    def pushes(self, t: float, place: BodyState) -> list[Push]:
        """On each point that touches."""
        found = []
        for body, point in zip(self.bodies, self.points, strict=True):
            position, velocity = place.point(body, point)
            depth = self.height - self.normal @ position
            if depth > 0.0:
                speed = -float(self.normal @ velocity)
                # log(1 + exp(20 w)) / 20 stands for max(w, 0)
                factor = np.logaddexp(0.0, 20.0 * (1.0 + 1.5 * self.damping * speed)) / np.logaddexp(
                    0.0, 20.0
                )
                push = self.stiffness * depth**self.exponent * factor
                along = velocity + speed * self.normal
                found.append(Push(body, point, push * self.normal - push * self._drag(along)))
        return found

    def stored(self, t: float, place: BodyState) -> float:
        """J."""
        places = [place.point(body, point)[0] for body, point in zip(self.bodies, self.points, strict=True)]
        depths = [max(self.height - float(self.normal @ position), 0.0) for position in places]
        return math.fsum(self.stiffness * d ** (self.exponent + 1.0) / (self.exponent + 1.0) for d in depths)

    def _drag(self, along: Array) -> Array:
        """Friction over the pushing force, (3,)."""
        x = float(np.linalg.norm(along)) / self.slip_speed
        coefficient = self.sliding * x / math.hypot(1.0, x)
        coefficient += (self.static - self.sliding) * (2.0 * (x / 5.0) / (1.0 + (x / 5.0) ** 2)) ** 3
        return coefficient * along / (x * self.slip_speed) if x > 0.0 else np.zeros(3)


def ground(mechanism: Mechanism, effect: Any, moving: Sequence[str] | None = None) -> Ground:
    """The ground of an effect `ground_contact`, with what it leaves open filled in from mass and size.

    moving  names of the bodies that move; None: those that are not fixed
    """
    moving = [body.name for body in mechanism.bodies if not body.fixed] if moving is None else moving
    touching = contact_points(mechanism, moving, effect.bodies, effect.points, effect.corners)
    points = np.array([each.point for each in touching])
    size = float(np.linalg.norm(points.max(axis=0) - points.min(axis=0))) or mechanism.size
    weight = 9.81 * sum(body.mass for body in mechanism.bodies if body.name in moving)
    speed = math.sqrt(9.81 * size)

    def given(value: float | None, default: float) -> float:
        return default if value is None else value

    return Ground(
        normal=np.array(effect.normal),
        height=effect.height,
        stiffness=given(effect.stiffness, weight / (1e-3 * size) ** effect.exponent),
        exponent=effect.exponent,
        damping=given(effect.damping, 1.0 / speed),
        sliding=effect.friction,
        static=given(effect.static_friction, effect.friction),
        slip_speed=given(effect.slip_speed, 1e-3 * speed),
        bodies=tuple(each.body for each in touching),
        points=points,
    )

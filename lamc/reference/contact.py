"""Contact with the ground in numbers: the force on each point at a state, and the energy in the ground.

In: an effect's own numbers, and the motion of the bodies. Out: forces, N, and moments, N·m. Written from the law
and the effect's text; shares nothing with the symbolic form but the choice of the points.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.effects.contact_points import contact_points
from lamc.mechanism.records import Mechanism

Array = npt.NDArray[np.float64]
Place = Callable[
    [str, Array], tuple[int, Array, Array]
]  # body, point as drawn → place in the walk, position, velocity


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

    def forces(self, place: Place) -> list[tuple[int, Array, Array]]:
        """(place in the walk, where, m, force, N) of each point that touches."""
        found = []
        for index, position, velocity in self._placed(place):
            depth = self.height - self.normal @ position
            if depth > 0.0:
                speed = -float(self.normal @ velocity)
                # log(1 + exp(20 w)) / 20 stands for max(w, 0)
                factor = np.logaddexp(0.0, 20.0 * (1.0 + 1.5 * self.damping * speed)) / np.logaddexp(
                    0.0, 20.0
                )
                push = self.stiffness * depth**self.exponent * factor
                along = velocity + speed * self.normal
                found.append((index, position, push * self.normal - push * self._drag(along)))
        return found

    def stored(self, place: Place) -> float:
        """J."""
        depths = [
            max(self.height - float(self.normal @ position), 0.0) for _, position, _ in self._placed(place)
        ]
        return math.fsum(self.stiffness * d ** (self.exponent + 1.0) / (self.exponent + 1.0) for d in depths)

    def _placed(self, place: Place) -> list[tuple[int, Array, Array]]:
        return [place(body, point) for body, point in zip(self.bodies, self.points, strict=True)]

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

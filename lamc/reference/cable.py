"""Cables through points as numbers: what they pull with, and what they store.

An independent reading: tensions from point to point as the rope runs, clipped at zero. Nothing is imported from the
effect.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Mechanism
from lamc.reference.expression import Formula, parse
from lamc.reference.point_loads import Array, BodyState, Push

_STEP = 1e-5  # s, over which the rate of a driven length is taken, by differences of order 4


@dataclass(frozen=True)
class PointCable:
    """Its points are on bodies, by name, given as drawn, m; length: m over time, s."""

    bodies: tuple[str, ...]
    points: tuple[Array, ...]
    stiffness: float  # N/m
    damping: float  # N·s/m
    friction: float
    slip_speed: float  # m/s
    length: Formula
    is_driven: bool

    effect = "cable"

    def pushes(self, t: float, place: BodyState) -> list[Push]:
        where, moving = map(np.array, zip(*map(place.point, self.bodies, self.points), strict=True))
        lines, partings = np.diff(where, axis=0), np.diff(moving, axis=0)
        lengths = np.linalg.norm(lines, axis=1)
        along = lines / lengths[:, None]
        rates = np.einsum("ij,ij->i", along, partings)
        stretch = lengths.sum() - self._length(t)
        tension = 0.0
        if stretch > 0.0:
            tension = max(self.stiffness * stretch + self.damping * (rates.sum() - self._winding(t)), 0.0)
        forces = np.zeros_like(where)
        for k in range(len(lines)):
            if k:
                turned = np.arctan2(np.linalg.norm(np.cross(along[k - 1], along[k])), along[k - 1] @ along[k])
                tension *= math.exp(self.friction * turned * math.tanh(rates[k:].sum() / self.slip_speed))
            forces[k] += tension * along[k]
            forces[k + 1] -= tension * along[k]
        return [Push(b, p, f) for b, p, f in zip(self.bodies, self.points, forces, strict=True)]

    def stored(self, t: float, place: BodyState) -> float:
        where = np.array([place.point(b, p)[0] for b, p in zip(self.bodies, self.points, strict=True)])
        stretch = np.linalg.norm(np.diff(where, axis=0), axis=1).sum() - self._length(t)
        return float(0.5 * self.stiffness * max(stretch, 0.0) ** 2)

    def _length(self, t: float) -> float:
        return self.length({"t": t, "angle": math.nan, "rate": math.nan})

    def _winding(self, t: float) -> float:
        """Rate of the length, m/s."""
        if not self.is_driven:
            return 0.0
        near = [self._length(t + k * _STEP) for k in (-2, -1, 1, 2)]
        return (near[0] - 8.0 * near[1] + 8.0 * near[2] - near[3]) / (12.0 * _STEP)


def cable(mechanism: Mechanism, effect: Any) -> PointCable:
    """Raises DesignError for a body that the mechanism does not have."""
    known = {body.name for body in mechanism.bodies}
    for name in effect.bodies:
        if name not in known:
            raise DesignError(f"the scene puts a cable on body {name!r}, which the mechanism does not have")
    points = tuple(np.array(point, dtype=np.float64) for point in effect.points)
    is_driven = isinstance(effect.length, str)
    drawn = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    said = drawn if effect.length is None else effect.length
    length = parse(said) if isinstance(said, str) else lambda _: float(said)
    return PointCable(
        tuple(effect.bodies),
        points,
        effect.stiffness,
        effect.damping,
        effect.friction,
        effect.slip_speed,
        length,
        is_driven,
    )

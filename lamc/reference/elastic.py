"""What holds hinges that yield and bodies that bend: stiffness and damping matrices on their deflections. Numbers only.

In: the records of an arrangement, and a state. Out: deflections with their rates and what they are by the rates u.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from lamc.mechanics.compliant_hinge import FREEDOMS, CompliantHinge
from lamc.mechanics.flexible import FlexibleBody
from lamc.reference.chain_poses import Chain
from lamc.reference.hinge_sides import Sides
from lamc.reference.kinematics import Array

_LARGEST = (0.3, 0.1)  # rad, and of the size: deflections to compare at, at most
_RATES = 10.0  # 1/s, times these: their rates at most


@dataclass(frozen=True)
class Spring:
    """amounts p (m,), rad or m, and their rates; partials (nu, m) of these by u; matrices (m, m).

    turns       which amounts are angles
    from_poses  p follows from where two bodies are; else p are coordinates
    """

    effect: str
    stiffness: Array
    damping: Array
    amounts: Array
    rates: Array
    partials: Array
    is_rotation: Array
    from_poses: bool = False

    def force(self) -> Array:
        """What it takes, by u, (nu,)."""
        return np.asarray(self.partials @ (self.stiffness @ self.amounts + self.damping @ self.rates))

    def energy(self) -> float:
        """J."""
        return 0.5 * float(self.amounts @ self.stiffness @ self.amounts)


class Elastic:
    """All springs of a chain: hinges of the walk that yield, joints that only stiffness holds, bodies that bend."""

    def __init__(self, chain: Chain, held: Mapping[str, CompliantHinge], size: float) -> None:
        self._chain, self._held, self._size = chain, held, size
        self._damping = {name: _damping(record) for name, record in chain.bending.items()}

    def at(self, q: Array, u: Array, sides: Sequence[Sides]) -> list[Spring]:
        """sides: of the joints that stiffness holds, in the order of `held`; none: without these."""
        found: list[Spring] = []
        for name, hinge in self._chain.yielding.items():
            index = self._chain.index
            places = [index.get(name if f == "angle" else f"{name}.{f}") for f in FREEDOMS]
            found.append(_along(hinge.effect, hinge.stiffness, hinge.damping, places, _TURNS, q, u))
        for hinge, side in zip(self._held.values() if sides else (), sides, strict=True):
            matrices = hinge.stiffness, hinge.damping
            found.append(
                Spring(hinge.effect, *matrices, side.amounts, side.rates, side.partials, _TURNS, True)
            )
        for name, record in self._chain.bending.items():
            places, none = [*self._chain.modes(name)], np.zeros(record.count, dtype=bool)
            found.append(_along(record.effect, record.stiffness, self._damping[name], places, none, q, u))
        return found

    def typical(self, weight: float) -> tuple[Array, Array]:
        """Deflections and their rates, both (nu,), at which elastic forces are as large as the weight, N; 0 for joints
        and the base."""
        count = len(self._chain.rates)
        q, u, joints = np.zeros(count), np.zeros(count), {link.joint.name for link in self._chain.links}
        for spring in self.at(q, u, ()):
            for i, column in enumerate(spring.partials.T):
                place = int(np.argmax(column))
                if not column.any() or self._chain.rates[place] in joints:
                    continue
                most, load = _LARGEST[1] * self._size, weight
                if spring.is_rotation[i]:
                    most, load = _LARGEST[0], weight * self._size
                K, C = spring.stiffness[i, i], spring.damping[i, i]
                q[place] = min(most, load / K) if K > 0.0 else most
                u[place] = min(_RATES * most, load / C) if C > 0.0 else _RATES * most
        return q, u

    def largest_acceleration(self, mass: Array, free: Array, springs: Sequence[Spring], gap: float) -> float:
        """That one entry of the elastic forces alone would make, by u; 0 without springs.

        free (nu, f): directions of u that loops leave free
        gap  rad and sizes, by which deflections count as larger that follow from positions, not coordinates
        """
        columns = [np.zeros((len(mass), 1))]
        for spring in springs:
            more = gap * np.where(spring.is_rotation, 1.0, self._size) if spring.from_poses else 0.0
            columns.append(spring.partials @ (spring.stiffness * (np.abs(spring.amounts) + more)))
        moved = np.linalg.solve(free.T @ mass @ free, free.T @ np.hstack(columns))
        return float(np.abs(free @ moved).max(initial=0.0))


_TURNS = np.repeat([True, False], 3)  # of FREEDOMS


def _along(
    effect: str, K: Array, C: Array, places: Sequence[int | None], is_rotation: Array, q: Array, u: Array
) -> Spring:
    """Of amounts that are coordinates, at these places of q and u; None: nought."""
    partials = np.zeros((len(u), len(places)))
    for i, place in enumerate(places):
        if place is not None:
            partials[place, i] = 1.0
    return Spring(effect, K, C, partials.T @ q[: len(u)], partials.T @ u, partials, is_rotation)


def _damping(record: FlexibleBody) -> Array:
    """2 ζ ω in the modes of K and M, ascending, carried back."""
    squares, shapes = eigh(record.stiffness, record.mass)
    momenta = record.mass @ shapes
    result: Array = (momenta * (2.0 * record.damping_ratios * np.sqrt(np.maximum(squares, 0.0)))) @ momenta.T
    return result

"""Matrices along a motion: value, velocity, acceleration with rates that stay, and what each rate has of the velocity.

The pose of a body is one 4 by 4 matrix, from drawn to world coordinates (J. J. Uicker 1965; J. Denavit and R. S.
Hartenberg 1955); poses follow each other by products, and derivatives by the product rule. Numbers only: no angular
velocities, no frames of links, and no differences, so that nothing is lost but round-off.
"""

from dataclasses import dataclass
from functools import reduce

import numpy as np
import numpy.typing as npt

from lamc.reference.kinematics import rodrigues, skew

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """value, first and second derivative by time, all (r, c); partials (n, r, c): of the first by each rate."""

    value: Array
    first: Array
    second: Array
    partials: Array

    def __matmul__(self, other: "Curve") -> "Curve":
        a, b = self, other
        return Curve(
            a.value @ b.value,
            a.first @ b.value + a.value @ b.first,
            a.second @ b.value + 2.0 * (a.first @ b.first) + a.value @ b.second,
            a.partials @ b.value + a.value @ b.partials,
        )

    def __sub__(self, other: "Curve") -> "Curve":
        a, b = self, other
        return Curve(a.value - b.value, a.first - b.first, a.second - b.second, a.partials - b.partials)

    def transposed(self) -> "Curve":
        rotated = self.partials.swapaxes(1, 2)
        return Curve(self.value.T, self.first.T, self.second.T, rotated)

    def times(self, numbers: Array) -> "Curve":
        """Its product with numbers, (c,) or (c, d)."""
        return Curve(
            self.value @ numbers, self.first @ numbers, self.second @ numbers, self.partials @ numbers
        )

    def block(self, first: int, last: int) -> "Curve":
        """The upper three rows, from one column to before another."""
        at = np.s_[..., :3, first:last]
        return Curve(self.value[at], self.first[at], self.second[at], self.partials[at])

    def flat(self) -> "Curve":
        """A column as a vector."""
        return Curve(self.value[:, 0], self.first[:, 0], self.second[:, 0], self.partials[:, :, 0])


@dataclass(frozen=True)
class Amount:
    """A coordinate times a factor: value and rate, factor included, and the place of its rate in u."""

    value: float
    rate: float
    index: int
    factor: float = 1.0


def still(matrix: Array, count: int) -> Curve:
    """A matrix that does not change, among `count` rates."""
    none = np.zeros_like(matrix)
    return Curve(matrix, none, none, np.zeros((count, *matrix.shape)))


def rotation_curve(axis: Array, angle: Amount, count: int) -> Curve:
    """Rotation about a unit vector through the origin."""
    spin, value = np.zeros((4, 4)), np.eye(4)
    spin[:3, :3], value[:3, :3] = skew(axis), rodrigues(axis, angle.value)
    partials = np.zeros((count, 4, 4))
    partials[angle.index] = angle.factor * spin @ value
    first = angle.rate * spin @ value
    return Curve(value, first, angle.rate * spin @ first, partials)


def slide(direction: Array, amount: Amount, count: int) -> Curve:
    """Displacement along a vector."""
    along = np.zeros((4, 4))
    along[:3, 3] = direction
    partials = np.zeros((count, 4, 4))
    partials[amount.index] = amount.factor * along
    return Curve(np.eye(4) + amount.value * along, amount.rate * along, np.zeros((4, 4)), partials)


def about(point: Array, count: int, *steps: Curve) -> Curve:
    """The product of steps that turn about a point, (3,), and not about the origin."""
    there, back = np.eye(4), np.eye(4)
    there[:3, 3], back[:3, 3] = point, -point
    return reduce(Curve.__matmul__, (*steps, still(back, count)), still(there, count))

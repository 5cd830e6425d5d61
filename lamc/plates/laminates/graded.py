"""A temperature or moisture that changes through the thickness of a laminate.

In: numbers, or arrays of places. Out: what laminates take in place of a number. Never: units, loads.
"""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from lamc.basics.checks import Array, checked_number


@dataclass(frozen=True, eq=False)
class Graded:
    """level + gradient · z, with z from the laminate's reference surface, m, upwards: a number or an array each.

    Sums with numbers and others of its kind, and multiples, are of its kind too.
    """

    level: float | Array
    gradient: float | Array  # per m

    __array_ufunc__ = None  # arrays leave sums and products to the methods below

    def __add__(self, other: "Amount") -> "Graded":
        return Graded(self.level + level_of(other), self.gradient + gradient_of(other))

    __radd__ = __add__

    def __mul__(self, factor: float | Array) -> "Graded":
        return Graded(factor * self.level, factor * self.gradient)

    __rmul__ = __mul__


Amount: TypeAlias = float | Array | Graded


def level_of(amount: Amount) -> float | Array:
    """At the reference surface."""
    return amount.level if isinstance(amount, Graded) else amount


def gradient_of(amount: Amount) -> float | Array:
    """Per m along z; 0 for a number or an array of places."""
    return amount.gradient if isinstance(amount, Graded) else 0.0


def is_of_places(amount: Amount) -> bool:
    """Whether it is of many places."""
    return bool(np.ndim(level_of(amount)) or np.ndim(gradient_of(amount)))


def number_of(amount: Amount, what: str = "an amount") -> float | Graded:
    """Of one place, checked. Raises DesignError for what is not finite."""
    level = checked_number(np.asarray(level_of(amount)).tolist(), what)
    if not isinstance(amount, Graded):
        return level
    return Graded(level, checked_number(np.asarray(amount.gradient).tolist(), f"the gradient of {what}"))


def over(shape: tuple[int, ...], amount: Amount) -> Array | Graded:
    """The same at places of `shape`."""
    level = np.full(shape, level_of(amount))
    return Graded(level, np.full(shape, amount.gradient)) if isinstance(amount, Graded) else level

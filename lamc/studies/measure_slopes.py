"""Derivatives of measures by what they are made of, from the result back to the quantities: reverse accumulation.

In: operations on terms, and what the measure weighs each with. Out: what it weighs the terms' values with; at the
leaves, `Gathered`: derivatives by quantities at the rows, and by what was varied. Never: evaluates a run.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lamc.run.request import Array
from lamc.studies.sample_slopes import NoSlopeError
from lamc.studies.samples import Samples

Slope = Callable[
    [Any, Any, "Gathered"], None
]  # of a term: rows, its weight (a float, or (m,)), where it goes


@dataclass
class Gathered:
    """Derivatives of a measure by quantities, (m,) each, and by numbers that were varied, by name."""

    quantities: dict[str, Array] = field(default_factory=dict)
    given: dict[str, float] = field(default_factory=dict)

    def add_quantity(self, name: str, weight: Array) -> None:
        self.quantities[name] = self.quantities.get(name, 0.0) + weight

    def add_given(self, name: str, weight: float) -> None:
        self.given[name] = self.given.get(name, 0.0) + weight


def nothing(_rows: Any, _weight: Any, _gathered: Gathered) -> None:
    """Of a number, which follows from nothing."""


def without(reason: str) -> Slope:
    """Of what has no derivative."""

    def slope(_rows: Any, _weight: Any, _gathered: Gathered) -> None:
        raise NoSlopeError(reason)

    return slope


def mapped_slope(operation: Any, terms: Sequence[Any]) -> Slope:
    """Of an operation, entry by entry, on terms."""
    partials = _PARTIALS[operation]

    def slope(rows: Any, weight: Any, gathered: Gathered) -> None:
        values = [np.asarray(term.value(rows), dtype=np.float64) for term in terms]
        with np.errstate(all="ignore"):  # what is not finite is told of the gradient
            found = partials(*values)
        for term, partial in zip(terms, found, strict=True):
            if term.number is not None:
                continue
            own = np.where(weight == 0.0, 0.0, weight * partial)
            term.slope(rows, own if term.over_time else float(np.sum(own)), gathered)

    return slope


def sampled_slope(term: Any, slopes: Callable[[Samples], Array]) -> Slope:
    """Of one number that is read off the samples of a term."""

    def slope(rows: Any, weight: float, gathered: Gathered) -> None:
        if weight != 0.0:
            term.slope(rows, weight * slopes(rows.samples(term.value(rows))), gathered)

    return slope


def _extreme(sign: float) -> Callable[[Array, Array], tuple[Any, Any]]:
    """Of minimum (sign -1) and maximum (+1): of the one that counts, half of each where they are equal."""

    def partials(a: Array, b: Array) -> tuple[Any, Any]:
        share = 0.5 * (1.0 + sign * np.sign(a - b))
        return share, 1.0 - share

    return partials


def _power(a: Array, b: Array) -> tuple[Any, Any]:
    of_exponent = np.where(a > 0.0, np.float_power(a, b) * np.log(np.where(a > 0.0, a, 1.0)), 0.0)
    return b * np.float_power(a, b - 1.0), of_exponent


_PARTIALS: Mapping[Any, Callable[..., tuple[Any, ...]]] = {
    np.negative: lambda a: (-np.ones_like(a),),
    np.add: lambda a, b: (np.ones_like(a), np.ones_like(b)),
    np.multiply: lambda a, b: (b, a),
    np.divide: lambda a, b: (1.0 / b, -a / (b * b)),
    np.float_power: _power,
    np.abs: lambda a: (np.sign(a),),
    np.sign: lambda a: (np.zeros_like(a),),
    np.sqrt: lambda a: (0.5 / np.sqrt(a),),
    np.sinh: lambda a: (np.cosh(a),),
    np.cosh: lambda a: (np.sinh(a),),
    np.tanh: lambda a: (1.0 - np.tanh(a) ** 2,),
    np.exp: lambda a: (np.exp(a),),
    np.log: lambda a: (1.0 / a,),
    np.sin: lambda a: (np.cos(a),),
    np.cos: lambda a: (-np.sin(a),),
    np.tan: lambda a: (1.0 + np.tan(a) ** 2,),
    np.arcsin: lambda a: (1.0 / np.sqrt(1.0 - a * a),),
    np.arccos: lambda a: (-1.0 / np.sqrt(1.0 - a * a),),
    np.arctan: lambda a: (1.0 / (1.0 + a * a),),
    np.arctan2: lambda a, b: (b / (a * a + b * b), -a / (a * a + b * b)),
    np.minimum: _extreme(-1.0),
    np.maximum: _extreme(+1.0),
}

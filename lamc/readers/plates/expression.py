"""Expressions in x and y, such as "1000*sin(pi*x)", as functions of arrays.

In: text of the language of `lamc.symbolic.expression`. Out: a function that numpy evaluates point by point. Nothing is
evaluated by Python, and no name is known but those that are given.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.basics.checks import Array
from lamc.basics.errors import ExpressionError
from lamc.symbolic.expression import stage
from lamc.symbolic.operations import BATCHED
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import NUMBER, Scalar, Value
from lamc.symbolic.staging import CONSTANT, SYMBOL, Store, Symbol

_PLACE = re.compile(r"(?<![A-Za-z0-9_.])[xy](?![A-Za-z0-9_(])", re.ASCII)


@dataclass(frozen=True)
class Field:
    """A function of the place, called with x and y in m, arrays of one shape.

    unit   length of one step of x and y in the expression, m
    scale  what the expression's value is multiplied by

    Raises ExpressionError when it is made with text outside the language, and when it is called where it has no finite
    value.
    """

    text: str
    unit: float = 1.0
    scale: float = 1.0

    def __post_init__(self) -> None:
        _staged(self.text)

    def __call__(self, x: npt.ArrayLike, y: npt.ArrayLike) -> Array:
        store, value = _staged(self.text)
        places = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        with np.errstate(all="ignore"):
            result = _evaluated(store, value, [axis / self.unit for axis in places])
        if not np.isfinite(result).all():
            at = np.argwhere(~np.isfinite(result))[0]
            px, py = (float(axis[tuple(at)]) for axis in places)
            raise ExpressionError(
                f"expression {self.text!r} has no finite value at ({px:g}, {py:g}) m; change it, or its region"
            )
        return np.asarray(self.scale * result)


def depends_on_place(text: str) -> bool:
    """Whether x or y stands in the text as a name."""
    return _PLACE.search(text) is not None


def number(text: str, names: Mapping[str, float]) -> float:
    """The value of an expression in which `names` stand for numbers. Raises ExpressionError."""
    value = stage(text, names)
    assert not isinstance(value, Value)  # numbers make numbers
    return float(value)


def _staged(text: str) -> tuple[Store, Scalar]:
    store = Store()
    names = {name: store.symbol(name, Space.TIME, index) for index, name in enumerate("xy")}
    return store, stage(text, names)


def _evaluated(store: Store, value: Scalar, places: list[Array]) -> Array:
    """The staged value at every place."""
    if not isinstance(value, Value):
        return np.full(places[0].shape, float(value))
    known: dict[int, Any] = {}
    for index in store.live([value]):
        operation, payload = store.operations[index], store.payloads.get(index)
        if operation == SYMBOL:
            assert isinstance(payload, Symbol)
            known[index] = places[payload.index]
        elif operation in (NUMBER, CONSTANT):
            assert isinstance(payload, int | float | Fraction)
            known[index] = float(payload)
        else:
            known[index] = BATCHED[operation](*(known[i] for i in store.arguments[index]))
    return np.asarray(value.sign * known[value.index] + np.zeros(places[0].shape))

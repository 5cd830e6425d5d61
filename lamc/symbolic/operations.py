"""What each operation of a `Program` means, as Python numbers and as numpy arrays.

Two tables by name, written from the C standard's definitions and shared with no printer. Where C gives NaN
or an infinity, so do these: nothing here raises for a value.
"""

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import polynomial

if TYPE_CHECKING:
    from lamc.symbolic.piecewise import Piecewise

Operation = Callable[..., Any]


def _total(function: Callable[..., float]) -> Callable[..., float]:
    """`function` with C's answers where Python's math raises: NaN outside the domain, else infinity."""

    def evaluate(*arguments: float) -> float:
        try:
            return function(*arguments)
        except OverflowError:
            return math.inf
        except ValueError:
            return math.nan

    return evaluate


def _reciprocal(x: float) -> float:
    return 1.0 / x if x != 0.0 else math.copysign(math.inf, x)


def _sign(x: float) -> float:
    return float((x > 0.0) - (x < 0.0))


def _minimum(x: float, y: float) -> float:
    """C's fmin: the other argument where one is NaN."""
    return x if (x < y or y != y) else y


def _maximum(x: float, y: float) -> float:
    """C's fmax: the other argument where one is NaN."""
    return x if (x > y or y != y) else y


def _logarithm(x: float) -> float:
    return -math.inf if x == 0.0 else math.log(x)


def _sinh(x: float) -> float:
    try:
        return math.sinh(x)
    except OverflowError:
        return math.copysign(math.inf, x)


def _power(x: float, y: float) -> float:
    try:
        return math.pow(x, y)
    except OverflowError:
        return -math.inf if x < 0.0 and y % 2.0 == 1.0 else math.inf
    except ValueError:
        if x == 0.0:  # a negative power of zero
            return math.copysign(math.inf, x) if y % 2.0 == 1.0 else math.inf
        return math.nan


SCALAR: Mapping[str, Callable[..., float]] = {
    "+": lambda x, y: x + y,
    "-": lambda x, y: x - y,
    "*": lambda x, y: x * y,
    "neg": lambda x: -x,
    "reciprocal": _reciprocal,
    "sqrt": _total(math.sqrt),
    "sin": _total(math.sin),
    "cos": _total(math.cos),
    "tan": _total(math.tan),
    "asin": _total(math.asin),
    "acos": _total(math.acos),
    "atan": math.atan,
    "atan2": math.atan2,
    "sinh": _sinh,
    "cosh": _total(math.cosh),
    "tanh": math.tanh,
    "exp": _total(math.exp),
    "log": _total(_logarithm),
    "abs": abs,
    "sign": _sign,
    "min": _minimum,
    "max": _maximum,
    "pow": _power,
}

BATCHED: Mapping[str, Operation] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "neg": np.negative,
    "reciprocal": lambda x: np.divide(1.0, x),
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "exp": np.exp,
    "log": np.log,
    "abs": np.abs,
    "sign": np.sign,
    "min": np.fmin,
    "max": np.fmax,
    "pow": np.power,
}


def lookups(tables: "Mapping[int, Piecewise]") -> Mapping[str, Operation]:
    """The operations that look up `tables`, for numbers and for arrays: table_<number>_<order of the derivative>."""
    return {
        f"table_{number}_{order}": _lookup(table, order)
        for number, table in tables.items()
        for order in range(table.degree + 1)
    }


def _lookup(table: "Piecewise", order: int) -> Operation:
    breaks = np.array(table.breaks)
    pieces = np.array([np.atleast_1d(polynomial.polyder(row, order)) for row in table.pieces])

    def evaluate(x: Any) -> Any:
        row = np.searchsorted(breaks, x, side="right")
        distance = x - breaks[np.maximum(row - 1, 0)]
        value = polynomial.polyval(distance, np.moveaxis(pieces[row], -1, 0), tensor=False)
        return np.where(np.isnan(distance), np.nan, value)[()]

    return evaluate

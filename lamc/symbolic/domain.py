"""Where an expression has no value: interval arithmetic on what `expression.stage` makes of it.

In: the text, and the range of each name, for many instants at once. Out: where no choice of values within the ranges
gives the expression a finite value, and why. What may have a value is never reported: arguments that miss their domain
by round-off pass, and so does what overflows or underflows on the way, as in 1/cosh(1000*t), which is zero then.
Nothing is divided by zero, not even where the infinity of floating point would vanish again.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from lamc.symbolic.expression import stage
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Value
from lamc.symbolic.staging import Store, Symbol

Array = npt.NDArray[np.float64]
Interval = tuple[Array, Array]  # lower and upper bounds, each (m,)

EVERYWHERE = (-math.inf, math.inf)
_ROUND_OFF = 1e-12
_TINY = 5e-324  # the least number above zero: what underflows is not zero

_RISING: Mapping[str, Callable[[Array], Array]] = {
    "atan": np.arctan,
    "sinh": np.sinh,
    "tanh": np.tanh,
    "sign": np.sign,
}
_FUNCTION: Mapping[str, Callable[[Array], Array]] = {
    "sqrt": np.sqrt,
    "log": np.log,
    "asin": np.arcsin,
    "acos": np.arccos,
}
_DOMAIN = {"sqrt": (0.0, math.inf), "log": (0.0, math.inf), "asin": (-1.0, 1.0), "acos": (-1.0, 1.0)}


@dataclass(frozen=True)
class Undefined:
    """index: of the first instant without a value; reason: in a few words, such as "sqrt of -2"."""

    index: int
    reason: str


def undefined(text: str, ranges: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]]) -> Undefined | None:
    """The first instant at which `text` has no finite value, whatever its names are within their ranges, or None.

    ranges  lower and upper bounds by name, numbers or arrays (m,)

    Raises ExpressionError as `stage` does.
    """
    store = Store()
    symbols = {name: store.symbol(name, Space.TIME, k) for k, name in enumerate(ranges)}
    value = stage(text, symbols)
    if not isinstance(value, Value):
        return None
    bounds = [np.broadcast_arrays(*np.atleast_1d(*ranges[name])) for name in ranges]
    shape = np.broadcast_shapes(*(low.shape for low, _ in bounds))
    given = {
        name: tuple(np.broadcast_to(b, shape) for b in pair)
        for name, pair in zip(ranges, bounds, strict=True)
    }
    found: list[Undefined] = []
    known: dict[int, Interval] = {}
    with np.errstate(all="ignore"):
        for index in store.live([value]):
            leaf = _leaf(store, index, given, shape)
            if leaf is not None:
                known[index] = leaf
                continue
            arguments = [known[i] for i in store.arguments[index]]
            (low, high), missing = _applied(store.operations[index], arguments)
            if missing.any():
                first = int(np.argmax(missing))
                ends = [(low[first], high[first]) for low, high in arguments]
                found.append(Undefined(first, _reason(store.operations[index], ends)))
            known[index] = (np.where(missing, -math.inf, low), np.where(missing, math.inf, high))
        low, high = known[value.index]
        too_large = (low == math.inf) | (high == -math.inf)
        if too_large.any():
            found.append(Undefined(int(np.argmax(too_large)), "it is too large for a number"))
    return min(found, key=lambda each: each.index) if found else None


def _leaf(
    store: Store, index: int, given: Mapping[str, tuple[Array, ...]], shape: tuple[int, ...]
) -> Interval | None:
    """The bounds of a symbol or a number; None for an operation."""
    payload = store.payloads.get(index)
    if isinstance(payload, Symbol):
        low, high = given[payload.name]
        return np.array(low, dtype=float), np.array(high, dtype=float)
    if payload is None:
        return None
    number = np.full(shape, float(payload))
    return number, number


def _applied(operation: str, arguments: list[Interval]) -> tuple[Interval, npt.NDArray[np.bool_]]:
    """The bounds of an operation on intervals, and where it has no value."""
    (a, b), (c, d) = arguments[0], arguments[-1]
    never = np.zeros(a.shape, dtype=bool)
    everywhere = (np.full(a.shape, -math.inf), np.full(a.shape, math.inf))
    match operation:
        case "+":
            return _filled(a + c, b + d), never
        case "-":
            return _filled(a - d, b - c), never
        case "neg":
            return (-b, -a), never
        case "*":
            return _product(a, b, c, d), never
        case "reciprocal":
            across = (a < 0.0) & (b > 0.0)
            low = np.where(across | (b == 0.0), -math.inf, 1.0 / b)
            return (low, np.where(across | (a == 0.0), math.inf, 1.0 / a)), (a == 0.0) & (b == 0.0)
        case "min":
            return (np.minimum(a, c), np.minimum(b, d)), never
        case "max":
            return (np.maximum(a, c), np.maximum(b, d)), never
        case "abs" | "cosh":
            least = np.where((a <= 0.0) & (b >= 0.0), 0.0, np.minimum(np.abs(a), np.abs(b)))
            most = np.maximum(np.abs(a), np.abs(b))
            return ((least, most) if operation == "abs" else (np.cosh(least), np.cosh(most))), never
        case "sqrt" | "log" | "asin" | "acos":
            return _in_domain(operation, a, b)
        case "pow":
            return _power(a, b, c, d)
        case "exp":
            return (np.exp(a), np.maximum(np.exp(b), _TINY)), never
        case name if name in _RISING:
            return (_RISING[name](a), _RISING[name](b)), never
    at_points: dict[str, Callable[..., Array]] = {
        "sin": np.sin,
        "cos": np.cos,
        "tan": np.tan,
        "atan2": np.arctan2,
    }
    bounds = {"sin": (-1.0, 1.0), "cos": (-1.0, 1.0), "atan2": (-math.pi, math.pi)}.get(operation, EVERYWHERE)
    point = np.logical_and.reduce([low == high for low, high in arguments])
    exact = at_points[operation](*(low for low, _ in arguments)) if operation in at_points else everywhere[0]
    return (np.where(point, exact, bounds[0]), np.where(point, exact, bounds[1])), never


def _product(a: Array, b: Array, c: Array, d: Array) -> Interval:
    """Bounds of x·y for x in (a, b) and y in (c, d)."""
    factors = np.stack([a, a, b, b]), np.stack([c, d, c, d])
    corners = factors[0] * factors[1]
    corners = np.where(np.isnan(corners), 0.0, corners)
    vanished = (corners == 0.0) & (factors[0] != 0.0) & (factors[1] != 0.0)
    low = np.where(vanished, -_TINY, corners).min(axis=0)
    return low, np.where(vanished, _TINY, corners).max(axis=0)


def _in_domain(operation: str, a: Array, b: Array) -> tuple[Interval, npt.NDArray[np.bool_]]:
    least, most = _DOMAIN[operation]
    missing = (b < least - _ROUND_OFF) | (a > most + _ROUND_OFF)
    if operation == "log":
        missing |= b == 0.0
    low, high = np.clip(a, least, most), np.clip(b, least, most)
    function = _FUNCTION[operation]
    ends = (function(low), function(high))
    return (ends if operation != "acos" else (ends[1], ends[0])), missing


def _power(a: Array, b: Array, c: Array, d: Array) -> tuple[Interval, npt.NDArray[np.bool_]]:
    """x**y for x in (a, b) and y in (c, d)."""
    fixed = c == d
    broken = fixed & np.isfinite(c) & (c != np.floor(c))
    missing = ((b < -_ROUND_OFF) & broken) | ((a == 0.0) & (b == 0.0) & (d < 0.0))
    point = (a == b) & fixed & ~missing
    exact = np.power(a, c)
    rising = np.where(a >= 0.0, 0.0, -math.inf)
    return (np.where(point, exact, rising), np.where(point, exact, math.inf)), missing


def _filled(low: Array, high: Array) -> Interval:
    """Bounds of a sum; infinities that cancel leave no bound."""
    return np.where(np.isnan(low), -math.inf, low), np.where(np.isnan(high), math.inf, high)


def _reason(operation: str, arguments: list[tuple[float, float]]) -> str:
    said = [f"{low:.6g}" if low == high else f"{low:.3g} to {high:.3g}" for low, high in arguments]
    if operation == "reciprocal":
        return "division by zero"
    if operation in _DOMAIN:
        return f"{operation} of {said[0]}"
    if operation == "pow":
        return f"{said[0]} to the power {said[1]}"
    raise AssertionError(f"{operation} has a value everywhere")

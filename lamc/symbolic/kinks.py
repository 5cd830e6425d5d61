"""Where an expression in t jumps, or has a kink: where it or its derivative is not continuous.

In: the text, the values of its other names, and the time to look at. Out: the first such instant found, and the jump.
Between instants the part with the larger change is taken again and again: of what is continuous the change dies away
with the interval, and a jump stays. What rises within 1e-7 of the whole time counts as a jump; two kinks that cancel
between neighbouring instants may be missed.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from lamc.symbolic.derivative import derivative
from lamc.symbolic.expression import stage
from lamc.symbolic.operations import BATCHED
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import LEAVES, Store, Symbol

Array = npt.NDArray[np.float64]

_SMOOTH = (
    "+",
    "-",
    "*",
    "neg",
    "reciprocal",
    "sin",
    "cos",
    "tan",
    "sinh",
    "cosh",
    "tanh",
    "atan",
    "exp",
    "log",
)
_GOLDEN = 0.6180339887498949
_PARTS = 34  # taken of an interval in turn; they leave some 1e-13 of the whole time, far above the spacing of numbers
_LEFT = 0.4871  # share of the left part: with one half, the middle would often be the kink itself
_JUMP = 1e-6  # of the largest value: far above what a rise within 1e-7 of the time changes in the end


class Curve(Protocol):
    """A function of the time, with its derivatives."""

    def at(self, t: Array, order: int = 0, /) -> Array: ...


_ORDERS = 2  # of a curve: its value and its rate


@dataclass(frozen=True)
class Kink:
    """t: s; jump: by how much the value, or if it is continuous (order 1) the derivative, changes there."""

    t: float
    jump: float
    order: int


def first_kink(text: str, values: "Mapping[str, float | Curve]", t_end: float, instants: int) -> Kink | None:
    """The first jump of `text` or of its derivative by t within (0, t_end), or None. values: of its other names; a
    curve is a function of the time that has no kink of its own.

    instants  how many times are looked at, at least. Raises ExpressionError as `stage` does.
    """
    store = Store()
    t = store.symbol("t", Space.TIME, 0)
    curves = {name: each for name, each in values.items() if not isinstance(each, float | int)}
    chains = {name: store.series(name, _ORDERS * place, _ORDERS) for place, name in enumerate(curves)}
    value = stage(text, {"t": t, **values, **chains})  # type: ignore[dict-item]  # no curve is left
    if not isinstance(value, Value) or not _may_have_kinks(store, value):
        return None
    # Not evenly spread: what oscillates would be seen at its zeros only, and a kink be hit where it has no rate.
    steps = np.arange(instants) + np.modf(_GOLDEN * np.arange(1, instants + 1))[0]
    times = t_end * steps / (instants + 1)
    known = list(curves.values())
    functions = [_function(store, v, known) for v in (value, derivative(value, {t: 1}))]
    sizes = [_largest(function(times)) for function in functions]
    sizes[1] = max(sizes[1], sizes[0] / t_end)  # a rate of round-off alone is none
    found = [_first_jump(function, times, sizes[k], k) for k, function in enumerate(functions)]
    return min((kink for kink in found if kink is not None), key=lambda kink: kink.t, default=None)


def _may_have_kinks(store: Store, value: Value) -> bool:
    return any(
        store.operations[i] not in _SMOOTH and store.operations[i] not in LEAVES for i in store.live([value])
    )


def _function(store: Store, value: Scalar, curves: "Sequence[Curve]") -> Callable[[Array], Array]:
    """`value` at times (m,)."""

    def evaluate(times: Array) -> Array:
        if not isinstance(value, Value):
            return np.full(times.shape, float(value))
        known: dict[int, Array] = {}
        with np.errstate(all="ignore"):
            for index in store.live([value]):
                payload = store.payloads.get(index)
                if isinstance(payload, Symbol) and payload.space is Space.CONSTANT:
                    place, order = divmod(payload.index, _ORDERS)
                    known[index] = curves[place].at(times, order)
                elif isinstance(payload, Symbol):
                    known[index] = times
                elif payload is not None:
                    known[index] = np.full(times.shape, float(payload))
                else:
                    arguments = (known[i] for i in store.arguments[index])
                    known[index] = BATCHED[store.operations[index]](*arguments)
        return value.sign * known[value.index]

    return evaluate


def _largest(values: Array) -> float:
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def _first_jump(function: Callable[[Array], Array], times: Array, size: float, order: int) -> Kink | None:
    """The first jump of `function`, of that size, between `times`; where it has no finite value, none is seen."""
    left, right = times[:-1], times[1:]
    low, high = function(left), function(right)
    least = _JUMP * size
    with np.errstate(all="ignore"):
        for _ in range(_PARTS):
            kept = np.abs(high - low) > least
            left, right, low, high = left[kept], right[kept], low[kept], high[kept]
            if not left.size:
                return None
            middle = left + _LEFT * (right - left)
            value = function(middle)
            known = np.isfinite(value)
            first = known & (np.abs(value - low) >= np.abs(high - value))
            second = known & ~first
            left, right = np.where(second, middle, left), np.where(first, middle, right)
            low, high = np.where(second, value, low), np.where(first, value, high)
    jumps = np.abs(high - low)
    seen = np.flatnonzero(jumps > least)
    return Kink(float(right[seen[0]]), float(jumps[seen[0]]), order) if seen.size else None

"""Derivatives of staged values by the chain rule (eq. 12), staged in turn.

One pass over the nodes gives the derivative along one direction: every input x moves at the speed `speeds[x]`. The
time derivative has q̇ = u; a partial derivative moves one input at speed 1. Where the time moves, inputs that follow
a series move with it.
"""

from collections.abc import Callable, Mapping, Sequence

from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, Value, call, cos, power, reciprocal, sin
from lamc.symbolic.staging import LEAVES, Store, Symbol

Rule = Callable[[Sequence[Scalar], Value, Sequence[Scalar]], Scalar]


def derivatives(values: Sequence[Scalar], speeds: Mapping[Value, Scalar]) -> list[Scalar]:
    """d/ds of each value when each input in `speeds` moves at its speed; all other inputs stand still."""
    stores = [v.store for v in values if isinstance(v, Value)]
    if not stores:
        return [0 for _ in values]
    store = stores[0]
    moving: dict[int, Scalar] = {x.index: x.sign * speed for x, speed in speeds.items()}
    pace = _pace_of_time(store, speeds)
    for index in store.live(values):
        if index in moving:
            continue
        following = store.flows.get(index)
        if following is None or pace is None:
            moving[index] = _node(store, index, moving)
        else:
            moving[index] = pace * Value(store, following, 1)
    return [v.sign * moving[v.index] if isinstance(v, Value) else 0 for v in values]


def _pace_of_time(store: Store, speeds: Mapping[Value, Scalar]) -> Scalar | None:
    """The speed of the time; None: it stands still, or nothing follows it."""
    for x, speed in speeds.items() if store.flows else ():
        symbol = store.payloads.get(x.index)
        if isinstance(symbol, Symbol) and symbol.space is Space.TIME:
            return x.sign * speed
    return None


def derivative(value: Scalar, speeds: Mapping[Value, Scalar]) -> Scalar:
    """d/ds of one value; see `derivatives`."""
    return derivatives([value], speeds)[0]


def _node(store: Store, index: int, moving: Mapping[int, Scalar]) -> Scalar:
    if store.operations[index] in LEAVES:
        return 0
    return slope_of_node(store, index, [moving[i] for i in store.arguments[index]])


def slope_of_node(store: Store, index: int, speeds: Sequence[Scalar]) -> Scalar:
    """The speed of a node, which is no leaf, whose arguments move at theirs."""
    operation, arguments = store.operations[index], store.arguments[index]
    if all(not isinstance(s, Value) and s == 0 for s in speeds):
        return 0
    values = [store.scalar(i) for i in arguments]
    if (found := store.table_of(operation)) is not None:
        table, order = found
        return store.table(table, values[0], order + 1) * speeds[0]
    return _RULES[operation](values, Value(store, index, 1), speeds)


def _extreme(side: int) -> Rule:
    """min (side -1) and max (+1): the speed of the one that counts, the mean where they are equal."""

    def rule(a: Sequence[Scalar], _: Value, d: Sequence[Scalar]) -> Scalar:
        which = side * call("sign", a[0] - a[1])
        return 0.5 * (d[0] + d[1]) + 0.5 * (which * (d[0] - d[1]))

    return rule


def _power(a: Sequence[Scalar], f: Value, d: Sequence[Scalar]) -> Scalar:
    result = a[1] * power(a[0], a[1] - 1) * d[0]
    if isinstance(d[1], Value) or d[1] != 0:
        result = result + f * call("log", a[0]) * d[1]
    return result


_RULES: Mapping[str, Rule] = {
    "+": lambda a, f, d: d[0] + d[1],
    "-": lambda a, f, d: d[0] - d[1],
    "*": lambda a, f, d: d[0] * a[1] + a[0] * d[1],
    "neg": lambda a, f, d: -d[0],
    "reciprocal": lambda a, f, d: -(f * f) * d[0],
    "sqrt": lambda a, f, d: 0.5 * reciprocal(f) * d[0],
    "sin": lambda a, f, d: cos(a[0]) * d[0],
    "cos": lambda a, f, d: -sin(a[0]) * d[0],
    "tan": lambda a, f, d: (1 + f * f) * d[0],
    "asin": lambda a, f, d: d[0] / call("sqrt", 1 - a[0] * a[0]),
    "acos": lambda a, f, d: -d[0] / call("sqrt", 1 - a[0] * a[0]),
    "atan": lambda a, f, d: d[0] / (1 + a[0] * a[0]),
    "atan2": lambda a, f, d: (a[1] * d[0] - a[0] * d[1]) / (a[0] * a[0] + a[1] * a[1]),
    "sinh": lambda a, f, d: call("cosh", a[0]) * d[0],
    "cosh": lambda a, f, d: call("sinh", a[0]) * d[0],
    "tanh": lambda a, f, d: (1 - f * f) * d[0],
    "exp": lambda a, f, d: f * d[0],
    "log": lambda a, f, d: d[0] / a[0],
    "abs": lambda a, f, d: call("sign", a[0]) * d[0],
    "sign": lambda a, f, d: 0,
    "min": _extreme(-1),
    "max": _extreme(+1),
    "pow": _power,
}

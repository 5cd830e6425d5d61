"""Cotangents of staged values: derivatives of one weighted sum by everything that it depends on, staged in turn.

One pass over the nodes, from the last to the first, whatever their number of inputs: each node hands what it was
weighed with to its arguments, times its derivative by them. The rules are those of `derivative`, asked for one
argument at a time. (A. Griewank, A. Walther, Evaluating Derivatives, 2nd ed. (2008), section 3.2.)"""

from collections.abc import Sequence

from lamc.symbolic.derivative import slope_of_node
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import LEAVES, Level, Store


def cotangents(
    store: Store, values: Sequence[Scalar], weights: Sequence[Scalar], outer: Level
) -> dict[int, Scalar]:
    """Derivatives of the sum of weights times values by symbols and by nodes up to level `outer`, by their index: what
    lies behind such a node is not looked at. Those of numbers are left out."""
    found: dict[int, Scalar] = {}

    def add(index: int, term: Scalar) -> None:
        found[index] = found.get(index, 0) + term

    for value, weight in zip(values, weights, strict=True):
        if isinstance(value, Value):
            add(value.index, value.sign * weight)
    for index in reversed(store.live(values)):
        weight = found.get(index, 0)
        if store.levels[index] <= outer or store.operations[index] in LEAVES or _is_zero(weight):
            continue
        store.link = store.link_of[index]
        arguments = store.arguments[index]
        for place, argument in enumerate(arguments):
            if store.levels[argument] > Level.NUMBER:
                along = [int(k == place) for k in range(len(arguments))]
                add(argument, slope_of_node(store, index, along) * weight)
    ends = {index: value for index, value in found.items() if _is_end(store, index, outer)}
    return {index: ends[index] for index in sorted(ends)}


def _is_end(store: Store, index: int, outer: Level) -> bool:
    level = store.levels[index]
    return level > Level.NUMBER and (level <= outer or store.operations[index] in LEAVES)


def _is_zero(value: Scalar) -> bool:
    return not isinstance(value, Value) and value == 0

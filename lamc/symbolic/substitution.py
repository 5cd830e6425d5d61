"""Other scalars in the place of some: staged values rebuilt, with folding, so that what becomes zero disappears."""

from collections.abc import Callable, Mapping, Sequence

from lamc.symbolic.functions import ARITHMETIC
from lamc.symbolic.scalars import Scalar, Value, call, cos, reciprocal, sin
from lamc.symbolic.staging import LEAVES, Store

_FOLDED: Mapping[str, Callable[[Scalar], Scalar]] = {"reciprocal": reciprocal, "sin": sin, "cos": cos}


def substitute(values: Sequence[Scalar], replacements: Mapping[Value, Scalar]) -> list[Scalar]:
    """`values` with each key of `replacements` (a symbol, as a rule) replaced."""
    stores = [v.store for v in values if isinstance(v, Value)]
    if not stores:
        return list(values)
    store = stores[0]
    rebuilt: dict[int, Scalar] = {x.index: x.sign * new for x, new in replacements.items()}
    for index in store.live(values):
        if index not in rebuilt:
            rebuilt[index] = _node(store, index, [rebuilt[i] for i in store.arguments[index]])
    return [v.sign * rebuilt[v.index] if isinstance(v, Value) else v for v in values]


def _node(store: Store, index: int, a: list[Scalar]) -> Scalar:
    operation = store.operations[index]
    if operation in LEAVES:
        return store.scalar(index)
    if (found := store.table_of(operation)) is not None:
        return store.table(found[0], a[0], found[1])
    if operation in ARITHMETIC:
        result: Scalar = ARITHMETIC[operation](*a)
        return result
    special = _FOLDED.get(operation)
    return special(a[0]) if special else call(operation, *a)

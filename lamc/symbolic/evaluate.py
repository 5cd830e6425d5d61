"""Numbers of staged values at one state: for facts of a design that are found once, never for a run."""

import math
from collections.abc import Mapping, Sequence

from lamc.symbolic.functions import ARITHMETIC, FUNCTIONS
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import LEAVES, Store, Symbol


def evaluate(store: Store, values: Sequence[Scalar], inputs: Mapping[Value, float]) -> list[float]:
    """`values` with each symbol at its number in `inputs`, and every other symbol at nought."""
    known = {x.index: x.sign * number for x, number in inputs.items()}
    memory: dict[int, float] = {}
    for index in store.live(values):
        operation = store.operations[index]
        if operation in LEAVES:
            payload = store.payloads[index]
            memory[index] = known.get(index, 0.0) if isinstance(payload, Symbol) else float(payload)
        else:
            arguments = [memory[i] for i in store.arguments[index]]
            found = store.table_of(operation)
            memory[index] = (
                _applied(operation, arguments) if found is None else found[0].value(arguments[0], found[1])
            )
    return [v.sign * memory[v.index] if isinstance(v, Value) else float(v) for v in values]


def _applied(operation: str, a: Sequence[float]) -> float:
    if operation in ARITHMETIC:
        return float(ARITHMETIC[operation](*a))
    if operation == "reciprocal":
        return 1.0 / a[0] if a[0] else math.inf
    return FUNCTIONS[operation].value(*a)

"""Which nodes of a store get a name: the statements of a straight-line program.

A node is named when it is used more than once, when it is a function call or a reciprocal, when the expression that
it would be part of grows long, or when it is what an effect hands to the rest of the equations, so that every effect
can be seen in the C. All others are written inside the one statement that uses them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from lamc.symbolic.program import Operations
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import BINARY, LEAVES, Level, Store

# Longer right-hand sides gain nothing at run time and are hard to read; shorter ones make many temporaries.
MAX_OPERANDS = 6


@dataclass(frozen=True)
class Grouping:
    """`named`: nodes with a statement of their own, in order; `leaves`: inputs and outer values they read."""

    named: tuple[int, ...]
    leaves: tuple[int, ...]


def group(store: Store, outputs: Sequence[Scalar], outer: Level) -> Grouping:
    """Statements for `outputs`; nodes up to level `outer` are taken as given."""
    live = _within(store, outputs, outer)
    uses = dict.fromkeys(live, 0)
    handed_over: set[int] = set()
    for index in live:
        if store.levels[index] > outer:
            section = store.section_of[index]
            for argument in store.arguments[index]:
                uses[argument] += 1
                own = store.section_of[argument]
                if own != section and store.sections[own].effect:
                    handed_over.add(argument)
    for value in outputs:
        if isinstance(value, Value):
            uses[value.index] += 2
    named: list[int] = []
    leaves: list[int] = []
    operands: dict[int, int] = {}
    for index in live:
        operation = store.operations[index]
        operands[index] = 1
        if operation in LEAVES or store.levels[index] <= outer:
            leaves.append(index)
            continue
        count = sum(operands[i] for i in store.arguments[index])
        short = operation in (*BINARY, "neg") and uses[index] == 1 and count <= MAX_OPERANDS
        inline = short and index not in handed_over
        if inline:
            operands[index] = count
        else:
            named.append(index)
    return Grouping(tuple(named), tuple(leaves))


def _within(store: Store, outputs: Sequence[Scalar], outer: Level) -> list[int]:
    """Live nodes, not looking behind those of level `outer` or below."""
    seen: set[int] = set()
    stack = [v.index for v in outputs if isinstance(v, Value)]
    while stack:
        index = stack.pop()
        if index not in seen:
            seen.add(index)
            if store.levels[index] > outer:
                stack.extend(store.arguments[index])
    return sorted(seen)


def count_operations(store: Store, outputs: Sequence[Scalar], outer: Level) -> Operations:
    """Operations on nodes above level `outer` that `outputs` need."""
    counts = {"+": 0, "*": 0, "reciprocal": 0, "call": 0}
    for index in _within(store, outputs, outer):
        operation = store.operations[index]
        if store.levels[index] <= outer or operation in (*LEAVES, "neg"):
            continue
        key = {"+": "+", "-": "+", "*": "*", "reciprocal": "reciprocal"}.get(operation, "call")
        counts[key] += 1
    return Operations(counts["+"], counts["*"], counts["reciprocal"], counts["call"])

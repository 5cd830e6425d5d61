"""Which nodes of a store get a name: the statements of a straight-line program.

A node is named when it is used more than once, when it is a function call or a reciprocal, when the expression that
it would be part of grows long, or when it is what an effect hands to the rest of the equations, so that every effect
can be seen in the C. All others are written inside the one statement that uses them.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from lamc.symbolic.program import Operations
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import BINARY, LEAVES, Level, Store

# Longer right-hand sides gain nothing at run time and are hard to read; shorter ones make many temporaries.
MAX_OPERANDS = 6
_SHORT = frozenset((*BINARY, "neg"))


@dataclass(frozen=True)
class Grouping:
    """`named`: nodes with a statement of their own, in order; `leaves`: inputs and outer values they read."""

    named: tuple[int, ...]
    leaves: tuple[int, ...]


def group(store: Store, outputs: Sequence[Scalar], outer: Level) -> Grouping:
    """Statements for `outputs`; nodes up to level `outer` are taken as given."""
    live = _within(store, outputs, outer)
    levels, operations = store.levels, store.operations
    arguments, section_of = store.arguments, store.section_of
    of_effects = {number for number, section in enumerate(store.sections) if section.effect}
    uses = dict.fromkeys(live, 0)
    handed_over: set[int] = set()
    for index in live:
        if levels[index] > outer:
            section = section_of[index]
            for argument in arguments[index]:
                uses[argument] += 1
                own = section_of[argument]
                if own != section and own in of_effects:
                    handed_over.add(argument)
    for value in outputs:
        if isinstance(value, Value):
            uses[value.index] += 2
    named: list[int] = []
    leaves: list[int] = []
    operands: dict[int, int] = {}
    for index in live:
        operation = operations[index]
        operands[index] = 1
        if levels[index] <= outer or operation in LEAVES:
            leaves.append(index)
            continue
        if uses[index] == 1 and operation in _SHORT and index not in handed_over:
            count = sum([operands[i] for i in arguments[index]])
            if count <= MAX_OPERANDS:
                operands[index] = count
                continue
        named.append(index)
    return Grouping(tuple(named), tuple(leaves))


def _within(store: Store, outputs: Sequence[Scalar], outer: Level) -> list[int]:
    """Live nodes, not looking behind those of level `outer` or below."""
    levels, arguments = store.levels, store.arguments
    stack = [v.index for v in outputs if isinstance(v, Value)]
    seen = set(stack)
    while stack:
        index = stack.pop()
        if levels[index] > outer:
            for argument in arguments[index]:
                if argument not in seen:
                    seen.add(argument)
                    stack.append(argument)
    return sorted(seen)


def count_operations(store: Store, outputs: Sequence[Scalar], outer: Level) -> Operations:
    """Operations on nodes above level `outer` that `outputs` need."""
    levels, operations = store.levels, store.operations
    counts = Counter(operations[i] for i in _within(store, outputs, outer) if levels[i] > outer)
    for free in (*LEAVES, "neg"):
        del counts[free]
    additions, products, reciprocals = counts["+"] + counts["-"], counts["*"], counts["reciprocal"]
    return Operations(additions, products, reciprocals, counts.total() - additions - products - reciprocals)

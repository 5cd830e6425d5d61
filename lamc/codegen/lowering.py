"""One function of a program from staged values: statements in order, over numbered slots.

Goes in: a store and the values that the function gives. Comes out: a Function. What reads it does not know whether it
is about a mechanism or a finite element.
"""

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from types import MappingProxyType

from lamc.symbolic.program import Function, Operand, Section, Shape, Space, Statement
from lamc.symbolic.scalars import Number, Scalar, Value
from lamc.symbolic.staging import Level, Store, Symbol
from lamc.symbolic.statements import count_operations, group

MAX_EXACT = 2**53  # doubles hold all integers up to here
_LETTERS = {space: space.value for space in Space}


class Lowering:
    """One function. `constants` grows by the outer values that it reads.

    exact: fractions that no double holds stay fractions, for functions that are also computed in other precisions.
    drawn: numbers of the drawing, node → place behind the parameters; those that are not in it are literals.
    """

    def __init__(
        self,
        store: Store,
        outer: Level,
        constants: dict[int, int],
        drawn: Mapping[int, int] = MappingProxyType({}),
        *,
        exact: bool = False,
    ) -> None:
        self.store = store
        self.exact = exact
        self.outer = outer
        self.constants = constants
        self.drawn = drawn
        self.slots: dict[int, Operand] = {}

    def function(
        self, name: str, purpose: str, reads: tuple[Space, ...], outputs: Sequence[Scalar]
    ) -> Function:
        store = self.store
        grouping = group(store, outputs, self.outer)
        for index in grouping.leaves:
            self.slots[index] = self._leaf(index)
        sections: dict[Section, int] = {}
        statements: list[Statement] = []
        for position, index in enumerate(grouping.named):
            operands: list[Operand] = []
            shape = self._shape(index, operands)
            target = Operand(Space.LOCAL, position)
            section = sections.setdefault(store.sections[store.section_of[index]], len(sections))
            origin = store.link_of[index], store.step_of[index]
            statements.append(Statement(target, shape, tuple(operands), section, *origin))
            self.slots[index] = target
        return Function(
            name=name,
            purpose=purpose,
            reads=reads,
            statements=tuple(statements),
            outputs=tuple(self._output(v) for v in outputs),
            sections=tuple(sections),
            operations=count_operations(store, outputs, self.outer),
        )

    def _leaf(self, index: int) -> Operand:
        payload = self.store.payloads.get(index)
        if self.store.levels[index] == Level.PARAMETER and self.outer == Level.PARAMETER:
            return Operand(Space.CONSTANT, self.constants.setdefault(index, len(self.constants)))
        if isinstance(payload, Symbol):
            held = payload.space is Space.CONSTANT  # by the runtime, in a slot that its symbol may not know
            return Operand(payload.space, self.constants.get(index, payload.index) if held else payload.index)
        if index in self.drawn:
            return Operand(Space.PARAMETER, self.drawn[index])
        assert payload is not None, "a leaf is an input or a number"
        return self._number(payload)

    def _number(self, value: Number) -> Operand:
        rounded = float(value)
        if not self.exact or not isinstance(value, Fraction) or value == rounded:
            return Operand(Space.NUMBER, value=rounded)
        short = max(abs(value.numerator), value.denominator) <= MAX_EXACT
        return Operand(Space.NUMBER, value=value if short else rounded)

    def _shape(self, index: int, operands: list[Operand]) -> Shape:
        """The expression of one statement; recursion is bounded by `statements.MAX_OPERANDS`."""
        parts: list[str | Shape] = [self.store.operations[index]]
        for argument in self.store.arguments[index]:
            slot = self.slots.get(argument)
            if slot is None:
                parts.append(self._shape(argument, operands))
            else:
                parts.append(len(operands))
                operands.append(slot)
        return tuple(parts)

    def _output(self, value: Scalar) -> tuple[int, Operand]:
        if isinstance(value, Value):
            return value.sign, self.slots[value.index]
        return 1, self._number(value)


def canonical(function: Function) -> Iterable[str]:
    """Every fact of the function as text, one line each, in a fixed order."""
    yield repr((function.name, function.purpose, function.sections))
    for s in function.statements:
        yield f"{_slot(s.target)}={s.shape}{','.join(map(_slot, s.operands))};{s.section}"
    for sign, operand in function.outputs:
        yield f"{sign}{_slot(operand)}"


def _slot(operand: Operand) -> str:
    if operand.space is Space.NUMBER:
        return f"#{operand.value!r}"
    return f"{_LETTERS[operand.space]}{operand.index}"

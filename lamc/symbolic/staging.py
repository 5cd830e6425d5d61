"""The staged store: every intermediate quantity is a numbered value the moment it is not trivial.

Goes in: operators on `Value`s. Comes out: a list of nodes, each an operation on earlier nodes, in which equal
subexpressions are one node (common subexpressions are shared by construction), constants are folded and signs
are normalised: a `Value` is a node and a sign, so that -x costs nothing and a - b and b - a are one node.
Autolev's Z variables are the same idea. The store never simplifies: what is written is what is computed.

Plain Python numbers take part in all operators and stay plain as long as nothing symbolic joins them, so
structural zeros disappear by themselves. Integers and Fractions stay exact until they are printed.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise

from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.piecewise import Piecewise
from lamc.symbolic.program import Section, Space
from lamc.symbolic.scalars import NUMBER, Number, Scalar, Value

CONSTANT = "constant"  # a number of the design, kept apart; see Store.constant
SYMBOL = "symbol"
LEAVES = (NUMBER, CONSTANT, SYMBOL)
BINARY = ("+", "-", "*")
NO_LINK = -1
EQUATIONS, LATER = "equations", "later"  # what a store is for, before and after effects have had their turn
TABLE = (
    "table_"  # begins the names of operations that look a table up: table_<number>_<order of the derivative>
)


ALIKE = 2.0**-44  # of a number, some 6e-14: what a few turns and sums of a drawing's numbers leave


class Level(IntEnum):
    """What a node depends on."""

    NUMBER = 0
    PARAMETER = 1
    STATE = 2


DrawnKey = tuple[str | int, ...]  # what a number is of the drawing, as ("offset", link, axis)


@dataclass(frozen=True, slots=True)
class Symbol:
    """An input of the equations."""

    name: str
    space: Space
    index: int


class Store:
    """Nodes, each with an operation, the indices of its arguments, a level and a section."""

    def __init__(self) -> None:
        self.operations: list[str] = []
        self.arguments: list[tuple[int, ...]] = []
        self.levels: list[int] = []
        self.section_of: list[int] = []
        self.link_of: list[int] = []
        self.link = NO_LINK  # nodes made from now on belong to this link of the tree; see `section`
        self.step_of: list[int] = []
        self.step = 0  # counts what is done one after the other for a link; see `section`
        self.payloads: dict[int, Number | Symbol] = {}
        self.drawn: dict[
            DrawnKey, int
        ] = {}  # numbers of the drawing, in the order in which they were asked for
        self.sections: list[Section] = [Section("", "", "")]
        self.tables: list[Piecewise] = []
        self.flows: dict[int, int] = {}  # node of a symbol that moves with time → node of its derivative
        self.is_frozen = False  # equations that are finished: what is to be added is added to a copy
        self.factors: set[int] = (
            set()
        )  # numbers of the drawing that met values as factors or terms, and their products
        self.scope = EQUATIONS  # whose numbers come without a key; see `numbers_of`
        self._draws = False
        self._unnamed: dict[str, dict[tuple[int, int], int]] = {}
        self._known: dict[object, int] = {}
        self._section = 0

    def __deepcopy__(self, memo: dict[int, object]) -> "Store":
        """A store that goes on from here: the nodes so far are the same, and keep their numbers."""
        copied = memo[id(self)] = Store()
        for name in (
            "operations",
            "arguments",
            "levels",
            "section_of",
            "link_of",
            "step_of",
            "sections",
            "tables",
        ):
            setattr(copied, name, list(getattr(self, name)))
        copied.payloads, copied._known = dict(self.payloads), dict(self._known)
        copied.drawn, copied.factors = dict(self.drawn), set(self.factors)
        copied.flows = dict(self.flows)
        copied._unnamed = {scope: dict(known) for scope, known in self._unnamed.items()}
        return copied

    def __len__(self) -> int:
        return len(self.operations)

    @contextmanager
    def section(self, title: str, *, effect: str = "", source: str = "") -> Iterator[None]:
        """Nodes made inside carry this origin; a node that already exists keeps its first one.

        Where the same is done for link after link, set `link` in the loop: code that repeats becomes one kernel. Where
        what is done for a link is itself the same again and again, count `step` on: if links are too unlike to become
        a kernel, their steps do.
        """
        entry = Section(title, effect, source)
        outer = self._section, self.link
        if entry not in self.sections:
            self.sections.append(entry)
        self._section, self.link = self.sections.index(entry), NO_LINK
        try:
            yield
        finally:
            self._section, self.link = outer

    def symbol(self, name: str, space: Space, index: int) -> Value:
        level = Level.PARAMETER if space is Space.PARAMETER else Level.STATE
        return Value(
            self, self._node((SYMBOL, space, index), SYMBOL, (), level, Symbol(name, space, index)), 1
        )

    def series(self, name: str, first: int, orders: int) -> Value:
        """The symbol of an input that follows a series: the runtime keeps its value, and then its derivatives by time
        up to order `orders` - 1, in constants from `first` on. What moves by time moves it by its derivative."""
        names = (name, *(f"series_{first + order}" for order in range(1, orders)))
        chain = [self.symbol(each, Space.CONSTANT, first + order) for order, each in enumerate(names)]
        self.flows |= {a.index: b.index for a, b in pairwise(chain)}
        return chain[0]

    def number(self, value: Number) -> int:
        """Index of the node that holds a number; finite ones only."""
        if not math.isfinite(value):
            raise OverflowError(f"a constant of the equations became {value}")
        return self._node((NUMBER, value), NUMBER, (), Level.NUMBER, value)

    def constant(self, value: float, key: DrawnKey = ()) -> Scalar:
        """A number of the design, such as a length, as something that equations do not look into.

        It is neither folded nor does its sign move, so that like links give like equations whatever their
        dimensions; `setup` keeps it with the parameter-only values. Zeros and ±1 are structure and stay plain.

        key: what the number is of the drawing, so that numbers of two keys are two nodes, though they be equal. Without
        one, equal numbers are one, and the key is which of them came first.
        """
        value = float(value)
        if value in (0.0, 1.0, -1.0):
            return int(value)
        return self.drawn_number(value, key or (self.scope, self._place(value)))

    def drawn_number(self, value: float, key: DrawnKey) -> Value:
        """The same of any number, zeros and ones too: `setup` is given it beside the parameters, and another drawing
        has another value there."""
        index = self._node((CONSTANT, key), CONSTANT, (), Level.PARAMETER, float(value))
        self.drawn.setdefault(key, index)
        return Value(self, index, 1)

    def _place(self, value: float) -> int:
        """Which of the numbers without keys it is, in the order in which they came, in the present scope. Numbers that
        round-off tells apart are one: which of them are equal to the last bit, another drawing changes."""
        known = self._unnamed.setdefault(self.scope, {})
        mantissa, exponent = math.frexp(value)
        bucket = round(mantissa / ALIKE)
        for near in (bucket, bucket - 1, bucket + 1):
            if (near, exponent) in known:
                return known[near, exponent]
        return known.setdefault((bucket, exponent), len(known))

    def literal(self, value: Number) -> int:
        """Index of the node of a number that meets a value: within `drawing` a number of the drawing, unless it is
        whole or a few halves, as those of formulas are."""
        if not self._draws or not isinstance(value, float) or (4.0 * value).is_integer():
            return self.number(value)
        index = self.drawn_number(value, (self.scope, self._place(value))).index
        self.factors.add(index)
        return index

    def factor(self, name: str, *arguments: int) -> int:
        """An operation on numbers of the drawing that `literal` gave, which may join others in turn."""
        index = self.operation(name, *arguments)
        self.factors.add(index)
        return index

    @contextmanager
    def numbers_of(self, scope: str) -> Iterator[None]:
        """Numbers of the drawing without keys are inside those of what is named."""
        outer, self.scope = self.scope, scope
        try:
            yield
        finally:
            self.scope = outer

    @contextmanager
    def drawing(self) -> Iterator[None]:
        """Plain numbers that meet values inside are of the drawing, as places of bodies are: no literals."""
        outer, self._draws = self._draws, True
        try:
            yield
        finally:
            self._draws = outer

    def call(self, name: str, *arguments: Scalar) -> Scalar:
        """A function of `FUNCTIONS`; folded when all arguments are numbers."""
        function = FUNCTIONS[name]
        if len(arguments) != function.arity:
            raise TypeError(f"{name} takes {function.arity} arguments, not {len(arguments)}")
        values = [float(a) for a in arguments if not isinstance(a, Value)]
        if len(values) == len(arguments):
            return function.value(*values)
        return Value(self, self.operation(name, *(self.materialise(a) for a in arguments)), 1)

    def table(self, table: Piecewise, x: Scalar, order: int = 0) -> Scalar:
        """The derivative of that order of a piecewise polynomial at x; equal tables are one."""
        if order > table.degree:
            return 0
        if not isinstance(x, Value):
            return table.value(float(x), order)
        number = self.tables.index(table) if table in self.tables else len(self.tables)
        if number == len(self.tables):
            self.tables.append(table)
        return Value(self, self.operation(f"{TABLE}{number}_{order}", self.materialise(x)), 1)

    def table_of(self, operation: str) -> tuple[Piecewise, int] | None:
        """The table that an operation looks up, and the order of its derivative; None for all other operations."""
        if not operation.startswith(TABLE):
            return None
        number, order = table_place(operation)
        return self.tables[number], order

    def materialise(self, value: Scalar) -> int:
        """Node index of a scalar, sign included."""
        if not isinstance(value, Value):
            return self.number(value)
        return value.index if value.sign > 0 else self.operation("neg", value.index)

    def scalar(self, index: int) -> Scalar:
        """The node as it takes part in operators: numbers plain, so that they fold."""
        if self.operations[index] == NUMBER:
            number = self.payloads[index]
            assert not isinstance(number, Symbol)
            return number
        return Value(self, index, 1)

    def operation(self, name: str, *arguments: int) -> int:
        level = max(self.levels[i] for i in arguments)
        return self._node((name, *arguments), name, arguments, level)

    def _node(
        self,
        key: object,
        name: str,
        arguments: tuple[int, ...],
        level: int,
        payload: Number | Symbol | None = None,
    ) -> int:
        index = self._known.get(key)
        if index is None:
            if self.is_frozen:
                raise RuntimeError("finished equations take no new nodes: write in `Equations.forked()`")
            index = len(self.operations)
            self._known[key] = index
            self.operations.append(name)
            self.arguments.append(arguments)
            self.levels.append(level)
            self.section_of.append(self._section)
            self.link_of.append(self.link)
            self.step_of.append(self.step)
            if payload is not None:
                self.payloads[index] = payload
        return index

    def live(self, values: Sequence[Scalar]) -> list[int]:
        """Indices of the nodes that `values` need, ascending, which is an order of evaluation."""
        seen: set[int] = set()
        stack = [v.index for v in values if isinstance(v, Value)]
        while stack:
            index = stack.pop()
            if index not in seen:
                seen.add(index)
                stack.extend(self.arguments[index])
        return sorted(seen)


def table_place(operation: str) -> tuple[int, int]:
    """(number of the table, order of the derivative) of an operation that begins with TABLE."""
    number, order = operation.removeprefix(TABLE).split("_")
    return int(number), int(order)

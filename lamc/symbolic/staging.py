"""The staged store: every intermediate quantity is a numbered value the moment it is not trivial.

Goes in: operators on `Value`s. Comes out: a list of nodes, each an operation on earlier nodes, in which equal
subexpressions are one node (common subexpressions are shared by construction), constants are folded and signs
are normalised: a `Value` is a node and a sign, so that -x costs nothing and a - b and b - a are one node.
Autolev's Z variables are the same idea. The store never simplifies: what is written is what is computed.

Plain Python numbers take part in all operators and stay plain as long as nothing symbolic joins them, so
structural zeros disappear by themselves. Integers and Fractions stay exact until they are printed.
"""

import math
import numbers
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass
from enum import IntEnum
from fractions import Fraction
from typing import TYPE_CHECKING, TypeAlias, Union

from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.piecewise import Piecewise
from lamc.symbolic.program import Section, Space

if TYPE_CHECKING:
    import sympy as sp

Number: TypeAlias = int | float | Fraction
Scalar: TypeAlias = Union["Value", int, float, Fraction]

NUMBER = "number"
CONSTANT = "constant"  # a number of the design, kept apart; see Store.constant
SYMBOL = "symbol"
LEAVES = (NUMBER, CONSTANT, SYMBOL)
BINARY = ("+", "-", "*")
NO_LINK = -1
TABLE = (
    "table_"  # begins the names of operations that look a table up: table_<number>_<order of the derivative>
)
STAGED = "lamc:"  # begins the names of sympy symbols that stand for values of a store


class Level(IntEnum):
    """What a node depends on."""

    NUMBER = 0
    PARAMETER = 1
    STATE = 2


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
        self.payloads: dict[int, Number | Symbol] = {}
        self.sections: list[Section] = [Section("", "", "")]
        self.tables: list[Piecewise] = []
        self.is_frozen = False  # equations that are finished: what is to be added is added to a copy
        self._known: dict[object, int] = {}
        self._section = 0

    def __deepcopy__(self, memo: dict[int, object]) -> "Store":
        """A store that goes on from here: the nodes so far are the same, and keep their numbers."""
        copied = memo[id(self)] = Store()
        for name in ("operations", "arguments", "levels", "section_of", "link_of", "sections", "tables"):
            setattr(copied, name, list(getattr(self, name)))
        copied.payloads, copied._known = dict(self.payloads), dict(self._known)
        return copied

    def __len__(self) -> int:
        return len(self.operations)

    @contextmanager
    def section(self, title: str, *, effect: str = "", source: str = "") -> Iterator[None]:
        """Nodes made inside carry this origin; a node that already exists keeps its first one.

        Where the same is done for link after link, set `link` in the loop: code that repeats becomes one kernel.
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

    def symbol(self, name: str, space: Space, index: int) -> "Value":
        level = Level.PARAMETER if space is Space.PARAMETER else Level.STATE
        return Value(
            self, self._node((SYMBOL, space, index), SYMBOL, (), level, Symbol(name, space, index)), 1
        )

    def number(self, value: Number) -> int:
        """Index of the node that holds a number; finite ones only."""
        if not math.isfinite(value):
            raise OverflowError(f"a constant of the equations became {value}")
        return self._node((NUMBER, value), NUMBER, (), Level.NUMBER, value)

    def constant(self, value: float) -> Scalar:
        """A number of the design, such as a length, as something that equations do not look into.

        It is neither folded nor does its sign move, so that like links give like equations whatever their
        dimensions; `setup` keeps it with the parameter-only values. Zeros and ±1 are structure and stay plain.
        """
        value = float(value)
        if value in (0.0, 1.0, -1.0):
            return int(value)
        return Value(self, self._node((CONSTANT, value), CONSTANT, (), Level.PARAMETER, value), 1)

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


class Value:
    """± one node of a store. Operators give Values, or plain numbers where everything folds."""

    __slots__ = ("index", "sign", "store")

    def __init__(self, store: Store, index: int, sign: int) -> None:
        self.store = store
        self.index = index
        self.sign = sign

    def __deepcopy__(self, memo: dict[int, object]) -> "Value":
        return Value(deepcopy(self.store, memo), self.index, self.sign)

    def __eq__(self, other: object) -> bool:
        """Same node and sign, i.e. the same expression."""
        if isinstance(other, Value):
            return self.store is other.store and self.index == other.index and self.sign == other.sign
        return False

    def __hash__(self) -> int:
        return hash((self.index, self.sign))

    def __neg__(self) -> "Value":
        return Value(self.store, self.index, -self.sign)

    def __pos__(self) -> "Value":
        return self

    def __mul__(self, other: Scalar) -> Scalar:
        store = self.store
        if not isinstance(other, Value):
            factor = _plain(other)
            return NotImplemented if factor is None else _scale(self, factor)
        i, j = self.index, other.index
        sign = self.sign * other.sign
        operations, arguments = store.operations, store.arguments
        if (operations[i] == "reciprocal" and arguments[i][0] == j) or (
            operations[j] == "reciprocal" and arguments[j][0] == i
        ):
            return sign
        if i > j:
            i, j = j, i
        return Value(store, store.operation("*", i, j), sign)

    __rmul__ = __mul__

    def __add__(self, other: Scalar) -> Scalar:
        store = self.store
        if not isinstance(other, Value):
            term = _plain(other)
            if term is None:
                return NotImplemented
            if term == 0:
                return self
            constant = store.number(term if term > 0 else -term)
            if (term > 0) == (self.sign > 0):
                return Value(store, store.operation("+", self.index, constant), self.sign)
            return Value(store, store.operation("-", self.index, constant), self.sign)
        i, j, si, sj = self.index, other.index, self.sign, other.sign
        if i == j:
            return 0 if si != sj else _scale(self, 2)
        if i > j:
            i, j, si, sj = j, i, sj, si
        return Value(store, store.operation("+" if si == sj else "-", i, j), si)

    __radd__ = __add__

    def __sub__(self, other: Scalar) -> Scalar:
        return self + (-other)

    def __rsub__(self, other: Scalar) -> Scalar:
        return (-self) + other

    def __truediv__(self, other: Scalar) -> Scalar:
        return self * reciprocal(other)

    def __rtruediv__(self, other: Scalar) -> Scalar:
        return reciprocal(self) * other

    def __pow__(self, exponent: Scalar) -> Scalar:
        return power(self, exponent)

    def __abs__(self) -> Scalar:
        return call("abs", self)

    def _sympy_(self) -> "sp.Symbol":
        """A symbol that stands for this value where sympy takes it up; `from_sympy` finds the value again."""
        import sympy as sp  # whoever calls this has imported it already

        return sp.Symbol(f"{STAGED}{self.index if self.sign > 0 else -1 - self.index}")

    def __repr__(self) -> str:
        return f"Value({'-' if self.sign < 0 else ''}#{self.index})"


def _plain(number: object) -> Number | None:
    """A number of any kind as one of Python's, or None for what is none: sympy then has its turn."""
    if isinstance(number, Number):
        return number
    return float(number) if isinstance(number, numbers.Real) else None


def _scale(value: Value, factor: Number) -> Scalar:
    """factor·value; two constant factors in a row become one."""
    if factor == 0:
        return 0
    sign = value.sign if factor > 0 else -value.sign
    factor = factor if factor > 0 else -factor
    if factor == 1:
        return Value(value.store, value.index, sign)
    store, index = value.store, value.index
    if store.operations[index] == "*":
        first, second = store.arguments[index]
        if store.operations[first] == NUMBER:
            inner = store.payloads[first]
            assert not isinstance(inner, Symbol)
            return _scale(Value(store, second, sign), inner * factor)
    # The number goes first, so that the pattern above finds it whatever the two indices are.
    return Value(store, store.operation("*", store.number(factor), index), sign)


def reciprocal(x: Scalar) -> Scalar:
    """1/x. Exact for integers and fractions."""
    if not isinstance(x, Value):
        return Fraction(1) / x if isinstance(x, int | Fraction) else 1.0 / x
    store = x.store
    if store.operations[x.index] == "reciprocal":
        return Value(store, store.arguments[x.index][0], x.sign)
    return Value(store, store.operation("reciprocal", x.index), x.sign)


# Up to here repeated multiplication is quicker and at least as exact as the library's pow.
MAX_EXPANDED_EXPONENT = 16


def power(x: Scalar, exponent: Scalar) -> Scalar:
    """x**exponent; small whole exponents become products."""
    if isinstance(exponent, Value):
        return call("pow", x, exponent)
    if not isinstance(x, Value):
        return math.pow(x, exponent)
    if exponent == int(exponent) and -MAX_EXPANDED_EXPONENT <= exponent <= MAX_EXPANDED_EXPONENT:
        count = abs(int(exponent))
        result: Scalar = 1
        square: Scalar = x
        while count:
            if count & 1:
                result = result * square
            count >>= 1
            if count:
                square = square * square
        return result if exponent >= 0 else reciprocal(result)
    if exponent == Fraction(1, 2):
        return call("sqrt", x)
    return call("pow", x, exponent)


def call(name: str, *arguments: Scalar) -> Scalar:
    """A function of `FUNCTIONS` on scalars of any kind."""
    for argument in arguments:
        if isinstance(argument, Value):
            return argument.store.call(name, *arguments)
    return FUNCTIONS[name].value(*(float(a) for a in arguments if not isinstance(a, Value)))


def sin(x: Scalar) -> Scalar:
    """sin x; odd, so the sign moves outside."""
    if not isinstance(x, Value):
        return 0 if x == 0 else math.sin(x)
    return Value(x.store, x.store.operation("sin", x.index), x.sign)


def cos(x: Scalar) -> Scalar:
    """cos x; even, so the sign is dropped."""
    if not isinstance(x, Value):
        return 1 if x == 0 else math.cos(x)
    return Value(x.store, x.store.operation("cos", x.index), 1)

"""Scalars of the staged store: `Value`s, which are ± one node, and the functions and operators on them.

Goes in: `Value`s and plain numbers. Comes out: the same; what folds stays plain. Signs are normalised: a `Value` is a
node and a sign, so that -x costs nothing and a - b and b - a are one node. Never: keeps anything; the store does.
"""

import math
import numbers
from copy import deepcopy
from fractions import Fraction
from typing import TYPE_CHECKING, TypeAlias, Union

from lamc.symbolic.functions import FUNCTIONS

if TYPE_CHECKING:
    import sympy as sp

    from lamc.symbolic.staging import Store

Number: TypeAlias = int | float | Fraction
Scalar: TypeAlias = Union["Value", int, float, Fraction]

NUMBER = "number"
STAGED = "lamc:"  # begins the names of sympy symbols that stand for values of a store


class Value:
    """± one node of a store. Operators give Values, or plain numbers where everything folds."""

    __slots__ = ("index", "sign", "store")

    def __init__(self, store: "Store", index: int, sign: int) -> None:
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
            constant = store.literal(term if term > 0 else -term)
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
            assert isinstance(inner, Number)
            return _scale(Value(store, second, sign), inner * factor)
        if first in store.factors:  # as above, once per change of the drawing
            both = store.factor("*", store.literal(factor), first)
            return Value(store, store.operation("*", both, second), sign)
    # The number goes first, so that the pattern above finds it whatever the two indices are.
    return Value(store, store.operation("*", store.literal(factor), index), sign)


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

"""C text of expressions, by sympy's C99 printer, once per expression shape.

Ten thousand statements have a few dozen shapes; printing a shape once and filling in operands takes a quarter of
a second where statement by statement took seven.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import sympy as sp
from sympy.codegen.ast import float32, real
from sympy.printing.c import C99CodePrinter

from lamc.basics.errors import EmitError
from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.program import Operand, Shape
from lamc.symbolic.staging import TABLE, table_place

REAL = "lamc_real"  # the type of numbers in C that may become float
LANES = "lanes"  # the type of numbers of several runs side by side, in runtime_c/ensemble/lane_numbers.h
_PLACE = re.compile(r"P(\d+)Q")
_CALL = re.compile(r"\b([a-z]\w*)\(")
_CONSTANT = re.compile(r"\b\d+\.\d+(?:e[+-]?\d+)?\b")


class _Product(sp.Function):  # type: ignore[misc]
    """A product that is printed as it stands."""


class _LookUp(sp.Function):  # type: ignore[misc]
    """Number of a table, order of its derivative, argument."""


class _Printer(C99CodePrinter):  # type: ignore[misc]
    def _print__Product(self, expr: sp.Expr) -> str:  # noqa: N802  sympy's own naming
        text = str(self._print(expr.args[0]))
        return f"({text})" if text.startswith("-") else text  # - -x is no --x

    def _print__LookUp(self, expr: sp.Expr) -> str:  # noqa: N802
        number, order, x = expr.args
        return f"table_{number}({self._print(x)}, {order})"


class _RealPrinter(_Printer):
    def _print_sign(self, expr: sp.Expr) -> str:
        return f"({REAL}){super()._print_sign(expr)}"  # of floats, comparisons are told to be numbers


class _LanePrinter(_Printer):
    def _print_sign(self, expr: sp.Expr) -> str:
        return f"sign({self._print(expr.args[0])})"  # comparisons of vectors are no numbers


@dataclass(frozen=True)
class ShapePrinter:
    """Prints shapes.

    single: numbers and functions of single precision, 1.0F and sinf.
    own_trig: sine and cosine of `trig.h`.
    number: type of constants, "double" or REAL; LANES: functions are those of lane_numbers.h.
    """

    single: bool = False
    own_trig: bool = False
    number: str = "double"

    def text(self, shape: Shape, operands: tuple[Operand, ...], name: Callable[[Operand], str]) -> str:
        """C expression of `shape` with operands named by `name`. Raises EmitError if there is no C form."""
        literals, positions = _pieces(shape, self)
        parts = [literals[0]]
        for literal, position in zip(literals[1:], positions, strict=True):
            parts.append(name(operands[position]))
            parts.append(literal)
        return "".join(parts)


@lru_cache(maxsize=4096)  # of the whole process: models share most shapes
def _pieces(shape: Shape, way: ShapePrinter) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """The text of `shape` around its operands, and which these are. Raises EmitError if there is no C form."""
    # Terms stay in the order in which the store has them: sorting them would depend on placeholder names.
    types = {"type_aliases": {real: float32}} if way.single else {}
    names = {"user_functions": {"sin": "lamc_sin", "cos": "lamc_cos"}} if way.own_trig else {}
    printer = {LANES: _LanePrinter, REAL: _RealPrinter}.get(way.number, _Printer)
    text = printer({"order": "none", **types, **names}).doprint(_unevaluated(shape))
    if "Not supported" in text:
        raise EmitError(f"an operation of {shape} has no C form")
    if way.number == REAL:
        text = _CONSTANT.sub(r"LAMC_R(\g<0>)", text)
    if way.number == LANES:
        text = _CALL.sub(r"lane_\g<0>", text)
    pieces = _PLACE.split(text)
    return tuple(pieces[0::2]), tuple(int(p) for p in pieces[1::2])


def _unevaluated(shape: Shape) -> sp.Expr:
    """The shape in sympy exactly as it is, operand k as the symbol PkQ. Brackets of a - b*(c*d) are kept, which sympy
    leaves out: the last bit is another without them."""
    if isinstance(shape, int):
        return sp.Symbol(f"P{shape}Q")
    operation, *rest = shape
    arguments = [_unevaluated(a) for a in rest if not isinstance(a, str)]
    if operation in ("-", "neg") and isinstance(arguments[-1], sp.Mul):
        arguments[-1] = _Product(arguments[-1])
    match operation:
        case "+":
            return sp.Add(*arguments, evaluate=False)
        case "-":
            return sp.Add(arguments[0], sp.Mul(sp.Integer(-1), arguments[1], evaluate=False), evaluate=False)
        case "*":
            return sp.Mul(*arguments, evaluate=False)
        case "neg":
            return sp.Mul(sp.Integer(-1), arguments[0], evaluate=False)
        case "reciprocal":
            return sp.Pow(arguments[0], sp.Integer(-1), evaluate=False)
        case str() if operation.startswith(TABLE):
            return _LookUp(*table_place(operation), *arguments)
        case str() if operation in FUNCTIONS:
            return getattr(sp, FUNCTIONS[operation].sympy_name)(*arguments)
        case _:
            raise EmitError(f"operation {operation!r} has no C form")


def literal(value: float | Fraction, number: str = "double") -> str:
    """A C literal that reads back exactly; negative ones in brackets. number: its type; where that is REAL, LAMC_R(…).

    A fraction is RATIO(numerator, denominator), which the compiler divides in the precision that is asked for.
    """
    if isinstance(value, Fraction):
        return f"RATIO({float(value.numerator)!r}, {float(value.denominator)!r})"
    text = f"LAMC_R({value!r})" if number == REAL else repr(value)
    return f"({text})" if value < 0 else text

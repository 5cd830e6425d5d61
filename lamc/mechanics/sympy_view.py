"""Between staged values and sympy expressions, both ways.

`expression` shows any value as sympy, down to the level that is asked for; `from_sympy` stages an expression that
a user wrote. Text never becomes sympy here: only objects pass.
"""

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import sympy as sp
from sympy.core.function import UndefinedFunction

from lamc.basics.errors import ExpressionError
from lamc.basics.once import remembered
from lamc.symbolic.functions import FUNCTIONS
from lamc.symbolic.piecewise import Piecewise
from lamc.symbolic.scalars import STAGED, Scalar, Value, call, power
from lamc.symbolic.staging import LEAVES, TABLE, Store, Symbol, table_place

# sympy class → name here; sqrt is no class of its own, and powers have a rule of their own.
_CALLS = {getattr(sp, f.sympy_name): name for name, f in FUNCTIONS.items() if name not in ("sqrt", "pow")}


def number(value: float | Fraction) -> sp.Number:
    """Exact numbers stay exact."""
    if isinstance(value, Fraction):
        return sp.Rational(value.numerator, value.denominator)
    if isinstance(value, int) or (value.is_integer() and abs(value) < 2**53):
        return sp.Integer(int(value))  # "x", not "1.0*x"
    return sp.Float(value, 17)


def expression(value: Scalar, named: Mapping[int, sp.Symbol]) -> sp.Expr:
    """`value` in sympy; nodes in `named` appear as their symbols, all others are written out.

    With nothing named, the whole expression is written out: it can be as large as the equations.
    """
    if not isinstance(value, Value):
        return number(value)
    store = value.store
    done: dict[int, sp.Expr] = {}
    stack = [value.index]
    while stack:
        index = stack[-1]
        if index in done:
            stack.pop()
        elif index in named:
            done[index] = named[index]
        else:
            missing = [i for i in store.arguments[index] if i not in done]
            if missing:
                stack.extend(missing)
            else:
                done[index] = node_expression(store, index, [done[i] for i in store.arguments[index]])
    result = done[value.index]
    return result if value.sign > 0 else -result


def node_expression(store: Store, index: int, arguments: list[sp.Expr]) -> sp.Expr:
    """One node applied to sympy arguments."""
    operation = store.operations[index]
    if operation in LEAVES:
        payload = store.payloads[index]
        return sp.Symbol(payload.name) if isinstance(payload, Symbol) else number(payload)
    match operation:
        case "+":
            return arguments[0] + arguments[1]
        case "-":
            return arguments[0] - arguments[1]
        case "*":
            return arguments[0] * arguments[1]
        case "neg":
            return -arguments[0]
        case "reciprocal":
            return 1 / arguments[0]
        case _ if (found := store.table_of(operation)) is not None:
            return table_function(table_place(operation)[0], *found)(*arguments)
        case _:
            return getattr(sp, FUNCTIONS[operation].sympy_name)(*arguments)


@remembered  # two functions of one name would not cancel
def table_function(number: int, table: Piecewise, order: int) -> Any:
    """The derivative of a piecewise polynomial as a function of sympy's: it has a name, numbers and derivatives."""
    return UndefinedFunction(
        f"{TABLE}{number}_{order}",
        _imp_=staticmethod(lambda x: table.value(float(x), order)),
        fdiff=lambda self, _=1: (
            table_function(number, table, order + 1)(*self.args) if order < table.degree else sp.Integer(0)
        ),
    )


def from_sympy(expr: sp.Expr, inputs: Mapping[str, Scalar], store: Store | None = None) -> Scalar:
    """`expr` staged; its symbols are looked up by name in `inputs`, values that sympy took up in `store`.

    Raises ExpressionError for a symbol that is not there, a function that has no C form, a constant that is not
    finite, and for what is no sympy expression.
    """
    try:
        return _staged(expr, inputs, store)
    except (ArithmeticError, ValueError) as error:
        raise ExpressionError(f"a constant part of the expression has no finite value ({error})") from error


def _staged(expr: sp.Expr, inputs: Mapping[str, Scalar], store: Store | None) -> Scalar:
    if not isinstance(expr, sp.Basic):
        raise ExpressionError(f"{expr!r} is a {type(expr).__name__}; give a number or a sympy expression")
    if isinstance(expr, sp.Symbol):
        if store is not None and expr.name.startswith(STAGED):
            index = int(expr.name.removeprefix(STAGED))
            return Value(store, index, 1) if index >= 0 else Value(store, -1 - index, -1)
        if expr.name not in inputs:
            raise ExpressionError(f"the expression uses {expr.name!r}; known are {', '.join(sorted(inputs))}")
        return inputs[expr.name]
    if isinstance(expr, sp.Rational):
        return int(expr) if expr.is_Integer else Fraction(int(expr.p), int(expr.q))
    if isinstance(expr, sp.Number | sp.NumberSymbol):
        if not math.isfinite(float(expr)):
            raise ValueError(f"{expr} is not finite")
        return float(expr)
    arguments = [_staged(a, inputs, store) for a in expr.args]
    result = arguments[0] if arguments else 0
    if isinstance(expr, sp.Add):
        for argument in arguments[1:]:
            result = result + argument
        return result
    if isinstance(expr, sp.Mul):
        for argument in arguments[1:]:
            result = result * argument
        return result
    if isinstance(expr, sp.Pow):
        return power(arguments[0], arguments[1])
    if expr.func is sp.exp:
        return call("exp", arguments[0])
    name = _CALLS.get(expr.func)
    if name is None:
        raise ExpressionError(
            f"the expression uses {expr.func.__name__}, which has no C form; {', '.join(FUNCTIONS)} have"
        )
    while len(arguments) > 2:  # sympy's Min and Max take any number of arguments
        arguments = [call(name, arguments[0], arguments[1]), *arguments[2:]]
    return call(name, *arguments)

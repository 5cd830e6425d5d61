"""Formulas in t, angle and rate as numbers: text in, a Python callable out.

The grammar is Python's own expression grammar (`ast`, mode "eval"; ^ reads as **), walked on a whitelist.
Nothing is ever evaluated or compiled by Python, no name is looked up outside the two tables below, and no
code is shared with the parser that the compiler uses.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping

from lamc.basics.errors import ExpressionError
from lamc.symbolic.operations import SCALAR

Values = Mapping[str, float]
Formula = Callable[[Values], float]

VARIABLES = ("t", "angle", "rate")
NUMBERS = {"pi": math.pi}
FUNCTIONS = {name: function for name, function in SCALAR.items() if name.isalpha() or name == "atan2"}
MAX_LENGTH = 2000  # characters, beyond which a formula is a mistake or an attack
MAX_DEPTH = 60  # nesting, far below where Python's own recursion ends

_BINARY: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: SCALAR["pow"],
}


def parse(text: str) -> Formula:
    """`text` as a function of {"t": s, "angle": rad, "rate": rad/s}. Raises ExpressionError."""
    if len(text) > MAX_LENGTH:
        raise ExpressionError(f"a formula of {len(text)} characters; at most {MAX_LENGTH} are allowed")
    try:
        tree = ast.parse(text.strip().replace("^", "**"), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ExpressionError(f"{text[:60]!r} is not a formula: {error}") from error
    return _walk(tree.body, text, 0)


def _walk(node: ast.expr, text: str, depth: int) -> Formula:
    if depth > MAX_DEPTH:
        raise ExpressionError(
            f"{text[:60]!r} is nested more than {MAX_DEPTH} deep; name its parts or shorten it"
        )
    match node:
        case ast.Constant(value=bool()):
            raise ExpressionError(f"{text[:60]!r} holds a truth value; a formula is made of numbers")
        case ast.Constant(value=int() | float() as value):
            return _constant(float(value))
        case ast.Name(id=name) if name in VARIABLES:
            return _variable(name)
        case ast.Name(id=name) if name in NUMBERS:
            return _constant(NUMBERS[name])
        case ast.UnaryOp(op=ast.USub(), operand=inner):
            return _apply(operator.neg, (_walk(inner, text, depth + 1),))
        case ast.UnaryOp(op=ast.UAdd(), operand=inner):
            return _walk(inner, text, depth + 1)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
            return _apply(_BINARY[type(op)], (_walk(left, text, depth + 1), _walk(right, text, depth + 1)))
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]) if name in FUNCTIONS:
            return _call(name, arguments, text, depth)
        case _:
            part = ast.unparse(node)
            raise ExpressionError(
                f"{part[:60]!r} is not allowed in a formula; it may use {', '.join(VARIABLES)}, pi, numbers, "
                f"+ - * / ** and {', '.join(sorted(FUNCTIONS))}"
            )


def _call(name: str, arguments: list[ast.expr], text: str, depth: int) -> Formula:
    wanted = 2 if name in ("atan2", "min", "max", "pow") else 1
    if len(arguments) != wanted:
        raise ExpressionError(f"{name} takes {wanted} arguments, not {len(arguments)}, in {text[:60]!r}")
    return _apply(FUNCTIONS[name], tuple(_walk(a, text, depth + 1) for a in arguments))


def _constant(value: float) -> Formula:
    return lambda values: value


def _variable(name: str) -> Formula:
    return lambda values: values[name]


def _apply(function: Callable[..., float], parts: tuple[Formula, ...]) -> Formula:
    def evaluate(values: Values) -> float:
        try:
            return function(*(part(values) for part in parts))
        except ZeroDivisionError:
            return math.nan

    return evaluate

"""Random expressions as plain trees, with four meanings: a number with its rounding error, staged, sympy, text.

A tree is a float, the name of a variable, or (operation, tree, …).
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import sympy as sp
from hypothesis import strategies as st

from lamc.symbolic.scalars import Scalar, call, cos, power, sin

EPS = 2.0**-52
VARIABLES = ("a", "b", "c")
BINARY = ("+", "-", "*", "/")
# Functions of one number that are smooth and bounded enough for any argument.
UNARY = ("sin", "cos", "tanh", "atan", "exp", "abs", "neg", "square")

Tree = Any


class Rounded(NamedTuple):
    """A value and a bound of the rounding error with which any sensible order of operations finds it."""

    value: float
    error: float


def trees(max_leaves: int = 12) -> st.SearchStrategy[Tree]:
    numbers = st.sampled_from([0.0, 1.0, 2.0, 0.5, 0.25, 3.0, 1.7, 10.0])
    leaves = st.one_of(st.sampled_from(VARIABLES), st.sampled_from(VARIABLES), numbers)
    return st.recursive(
        leaves,
        lambda inner: st.one_of(
            st.tuples(st.sampled_from(BINARY), inner, inner), st.tuples(st.sampled_from(UNARY), inner)
        ),
        max_leaves=max_leaves,
    )


def rounded(tree: Tree, values: Mapping[str, float]) -> Rounded | None:
    """By Python's own arithmetic, or None where the expression is undefined or ill-conditioned there."""
    if isinstance(tree, float):
        return Rounded(tree, 0.0)
    if isinstance(tree, str):
        return Rounded(values[tree], 0.0)
    arguments = [rounded(t, values) for t in tree[1:]]
    if any(a is None for a in arguments):
        return None
    result = _apply(tree[0], [a for a in arguments if a is not None])
    if result is None or not math.isfinite(result.value) or abs(result.value) > 1e6 or result.error > 1e-3:
        return None
    return Rounded(result.value, result.error + 2 * EPS * abs(result.value))


def _apply(operation: str, a: list[Rounded]) -> Rounded | None:
    x, dx = a[0]
    match operation:
        case "+":
            return Rounded(x + a[1].value, dx + a[1].error)
        case "-":
            return Rounded(x - a[1].value, dx + a[1].error)
        case "*":
            y, dy = a[1]
            return Rounded(x * y, abs(x) * dy + abs(y) * dx + dx * dy)
        case "/":
            y, dy = a[1]
            # Near a zero of the denominator nothing holds.
            return None if abs(y) < 1e-3 else Rounded(x / y, 2 * (dx + abs(x / y) * dy) / abs(y))
        case "neg":
            return Rounded(-x, dx)
        case "square":
            return Rounded(x * x, 2 * abs(x) * dx + dx * dx)
        case "exp":
            return None if x > 13 else Rounded(math.exp(x), 2 * math.exp(x) * dx)
        case "abs":
            return Rounded(abs(x), dx)
        case _:  # sin, cos, tanh, atan: slopes of at most one
            return Rounded(getattr(math, operation)(x), dx)


def staged(tree: Tree, values: Mapping[str, Scalar]) -> Scalar:
    if isinstance(tree, float):
        return tree
    if isinstance(tree, str):
        return values[tree]
    a = [staged(t, values) for t in tree[1:]]
    match tree[0]:
        case "+":
            return a[0] + a[1]
        case "-":
            return a[0] - a[1]
        case "*":
            return a[0] * a[1]
        case "/":
            return a[0] / a[1]
        case "neg":
            return -a[0]
        case "square":
            return power(a[0], 2)
        case "sin":
            return sin(a[0])
        case "cos":
            return cos(a[0])
        case name:
            return call(name, a[0])


def in_sympy(tree: Tree) -> sp.Expr:
    """With real symbols; numbers exact."""
    if isinstance(tree, float):
        return sp.Rational(tree) if tree != 1.7 else sp.Float(1.7, 30)
    if isinstance(tree, str):
        return sp.Symbol(tree, real=True)
    a = [in_sympy(t) for t in tree[1:]]
    match tree[0]:
        case "+":
            return a[0] + a[1]
        case "-":
            return a[0] - a[1]
        case "*":
            return a[0] * a[1]
        case "/":
            return a[0] / a[1]
        case "neg":
            return -a[0]
        case "square":
            return a[0] ** 2
        case "abs":
            return sp.Abs(a[0])
        case name:
            return getattr(sp, name)(a[0])


def text(tree: Tree) -> str:
    """In the language of scenes and of Python."""
    if isinstance(tree, float):
        return repr(tree)
    if isinstance(tree, str):
        return tree
    a = [text(t) for t in tree[1:]]
    match tree[0]:
        case "neg":
            return f"(-{a[0]})"
        case "square":
            return f"{a[0]}**2" if isinstance(tree[1], str) else f"({a[0]})**2"
        case operation if operation in BINARY:
            return f"({a[0]} {operation} {a[1]})"
        case name:
            return f"{name}({a[0]})"

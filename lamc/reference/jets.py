"""Formulas in t with their first two derivatives, as numbers: the motion of a base, for the independent cross-check.

Text goes in, (value, first, second) comes out: arithmetic on truncated Taylor series, by the rules of school. Nothing
is shared with the staged derivatives of the compiler.
"""

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass

from lamc.basics.errors import UnsupportedError
from lamc.reference.expression import NUMBERS, parse

# f, f', f''
_FUNCTIONS: dict[str, Callable[[float], tuple[float, float, float]]] = {
    "sin": lambda x: (math.sin(x), math.cos(x), -math.sin(x)),
    "cos": lambda x: (math.cos(x), -math.sin(x), -math.cos(x)),
    "tan": lambda x: (math.tan(x), 1 / math.cos(x) ** 2, 2 * math.tan(x) / math.cos(x) ** 2),
    "exp": lambda x: (math.exp(x), math.exp(x), math.exp(x)),
    "log": lambda x: (math.log(x), 1 / x, -1 / x**2),
    "sqrt": lambda x: (math.sqrt(x), 0.5 / math.sqrt(x), -0.25 / math.sqrt(x) ** 3),
    "sinh": lambda x: (math.sinh(x), math.cosh(x), math.sinh(x)),
    "cosh": lambda x: (math.cosh(x), math.sinh(x), math.cosh(x)),
    "tanh": lambda x: (math.tanh(x), 1 / math.cosh(x) ** 2, -2 * math.tanh(x) / math.cosh(x) ** 2),
    "atan": lambda x: (math.atan(x), 1 / (1 + x * x), -2 * x / (1 + x * x) ** 2),
}


@dataclass(frozen=True)
class Jet:
    """A value with its first and second derivative by t."""

    value: float
    first: float = 0.0
    second: float = 0.0

    def __add__(self, other: "Jet") -> "Jet":
        return Jet(self.value + other.value, self.first + other.first, self.second + other.second)

    def __neg__(self) -> "Jet":
        return Jet(-self.value, -self.first, -self.second)

    def __mul__(self, other: "Jet") -> "Jet":
        a, b = self, other
        return Jet(
            a.value * b.value,
            a.first * b.value + a.value * b.first,
            a.second * b.value + 2.0 * a.first * b.first + a.value * b.second,
        )

    def through(self, f: tuple[float, float, float]) -> "Jet":
        """A function of it, given with its two derivatives at the value."""
        return Jet(f[0], f[1] * self.first, f[1] * self.second + f[2] * self.first**2)

    def power(self, exponent: float) -> "Jet":
        x, n = self.value, exponent
        lower = n * x ** (n - 1.0) if n else 0.0
        return self.through((x**n, lower, n * (n - 1.0) * x ** (n - 2.0) if n not in (0.0, 1.0) else 0.0))


def jet(told: float | str, t: float) -> Jet:
    """A number, or a formula in t, at the time t. Raises UnsupportedError for a function without a rule here."""
    if not isinstance(told, str):
        return Jet(float(told))
    parse(told)  # refuses what is not in the language
    return _walk(ast.parse(told.strip().replace("^", "**"), mode="eval").body, told, t)


def _walk(node: ast.expr, text: str, t: float) -> Jet:
    match node:
        case ast.Constant(value=int() | float() as value):
            return Jet(float(value))
        case ast.Name(id="t"):
            return Jet(t, 1.0)
        case ast.Name(id=name) if name in NUMBERS:
            return Jet(NUMBERS[name])
        case ast.UnaryOp(op=op, operand=inner):
            inside = _walk(inner, text, t)
            return -inside if isinstance(op, ast.USub) else inside
        case ast.BinOp(left=left, op=op, right=right):
            a, b = _walk(left, text, t), _walk(right, text, t)
            match op:
                case ast.Add():
                    return a + b
                case ast.Sub():
                    return a + -b
                case ast.Mult():
                    return a * b
                case ast.Div():
                    return a * b.power(-1.0)
                case ast.Pow() if (b.first, b.second) == (0.0, 0.0):
                    return a.power(b.value)
        case ast.Call(func=ast.Name(id=name), args=[argument]) if name in _FUNCTIONS:
            inside = _walk(argument, text, t)
            return inside.through(_FUNCTIONS[name](inside.value))
    raise UnsupportedError(
        f"the independent cross-check has no derivatives of {ast.unparse(node)[:60]!r} in the motion {text[:60]!r}; "
        f"leave "
        "the effect out of the scene to check the rest"
    )

"""The functions of one and two numbers that an expression may hold, with their values and derivatives.

One table for everyone: the store folds constants with it, derivatives come from it, the C printer and the scene's
expression language refuse what is not in it.
"""

import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any


@dataclass(frozen=True)
class Elementary:
    """`value` on floats; `sympy_name` the name in sympy, from which C text, LaTeX and derivatives follow."""

    arity: int
    value: Callable[..., float]
    sympy_name: str
    meaning: str  # for people


# What sums, products and signs of a store are, on whatever adds and multiplies: numbers, staged values, sympy.
ARITHMETIC: Mapping[str, Callable[..., Any]] = MappingProxyType(
    {"+": operator.add, "-": operator.sub, "*": operator.mul, "neg": operator.neg}
)


def _sign(x: float) -> float:
    return float((x > 0.0) - (x < 0.0))


FUNCTIONS: Mapping[str, Elementary] = MappingProxyType(
    {
        "sqrt": Elementary(1, math.sqrt, "sqrt", "square root; of 0 or more"),
        "sin": Elementary(1, math.sin, "sin", "sine, of rad"),
        "cos": Elementary(1, math.cos, "cos", "cosine, of rad"),
        "tan": Elementary(1, math.tan, "tan", "tangent, of rad"),
        "asin": Elementary(1, math.asin, "asin", "rad, of -1 to 1"),
        "acos": Elementary(1, math.acos, "acos", "rad, of -1 to 1"),
        "atan": Elementary(1, math.atan, "atan", "rad"),
        "atan2": Elementary(2, math.atan2, "atan2", "angle of the point (x, y), rad"),
        "sinh": Elementary(1, math.sinh, "sinh", "hyperbolic sine"),
        "cosh": Elementary(1, math.cosh, "cosh", "hyperbolic cosine"),
        "tanh": Elementary(1, math.tanh, "tanh", "hyperbolic tangent; a smooth step"),
        "exp": Elementary(1, math.exp, "exp", "e to the power"),
        "log": Elementary(1, math.log, "log", "natural logarithm; of what is above 0"),
        "abs": Elementary(1, abs, "Abs", "magnitude; has a kink at 0"),
        "sign": Elementary(1, _sign, "sign", "-1, 0 or 1; jumps at 0"),
        "min": Elementary(2, min, "Min", "the smaller of two"),
        "max": Elementary(2, max, "Max", "the larger of two"),
        "pow": Elementary(2, math.pow, "Pow", "x to the power of y, x^y"),
    }
)

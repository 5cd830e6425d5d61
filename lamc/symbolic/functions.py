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


# What sums, products and signs of a store are, on whatever adds and multiplies: numbers, staged values, sympy.
ARITHMETIC: Mapping[str, Callable[..., Any]] = MappingProxyType(
    {"+": operator.add, "-": operator.sub, "*": operator.mul, "neg": operator.neg}
)


def _sign(x: float) -> float:
    return float((x > 0.0) - (x < 0.0))


FUNCTIONS: Mapping[str, Elementary] = MappingProxyType(
    {
        "sqrt": Elementary(1, math.sqrt, "sqrt"),
        "sin": Elementary(1, math.sin, "sin"),
        "cos": Elementary(1, math.cos, "cos"),
        "tan": Elementary(1, math.tan, "tan"),
        "asin": Elementary(1, math.asin, "asin"),
        "acos": Elementary(1, math.acos, "acos"),
        "atan": Elementary(1, math.atan, "atan"),
        "atan2": Elementary(2, math.atan2, "atan2"),
        "sinh": Elementary(1, math.sinh, "sinh"),
        "cosh": Elementary(1, math.cosh, "cosh"),
        "tanh": Elementary(1, math.tanh, "tanh"),
        "exp": Elementary(1, math.exp, "exp"),
        "log": Elementary(1, math.log, "log"),
        "abs": Elementary(1, abs, "Abs"),
        "sign": Elementary(1, _sign, "sign"),
        "min": Elementary(2, min, "Min"),
        "max": Elementary(2, max, "Max"),
        "pow": Elementary(2, math.pow, "Pow"),
    }
)

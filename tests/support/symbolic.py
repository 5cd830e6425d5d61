"""Numbers from staged symbolic equations, by sympy's lambdify."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import sympy as sp

from lamc.mechanics.equations import Assignment, Equations
from tests.support.mechanisms import Array


def inputs_of(equations: Equations) -> list[sp.Symbol]:
    """t, angles, rates, parameters, as symbols."""
    names = ["t", *(f"q_{j}" for j in equations.joints), *(f"u_{j}" for j in equations.joints)]
    return [sp.Symbol(name) for name in (*names, *(p.name for p in equations.parameters))]


def evaluator(
    equations: Equations, assignments: Sequence[Assignment], outputs: Sequence[sp.Expr]
) -> Callable[[float, Array, Array, Mapping[str, float]], Array]:
    """(t, q, u, parameters) → values of `outputs` after the assignments, one after the other."""
    staged = [(a.symbol, a.expression) for a in assignments]
    function = sp.lambdify(inputs_of(equations), list(outputs), modules="math", cse=lambda e: (staged, e))

    def evaluate(t: float, q: Array, u: Array, parameters: Mapping[str, float]) -> Array:
        values = {p.name: p.default for p in equations.parameters} | dict(parameters)
        return np.array(function(t, *q, *u, *values.values()), dtype=float)

    return evaluate

"""sympy's KanesMethod, lambdify with cse and scipy's RK45 as a peer: the road most users take today."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import sympy as sp
from scipy.integrate import solve_ivp

from lamc.reference.sympy_kane import KaneModel

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class LambdifyPeer:
    """acceleration(q, u, t) → du/dt; build_seconds is the time lambdify takes."""

    acceleration: Callable[[Array, Array, float], Array]
    build_seconds: float

    def run(self, start: Array, t_end: float, rtol: float, atol: float) -> Array:
        """State at t_end with scipy's RK45, shape (2n,)."""
        n = len(start) // 2

        def rhs(t: float, y: Array) -> Array:
            return np.concatenate([y[n:], self.acceleration(y[:n], y[n:], t)])

        final: Array = solve_ivp(rhs, (0.0, t_end), start, "RK45", rtol=rtol, atol=atol).y[:, -1]
        return final


def build(model: KaneModel) -> LambdifyPeer:
    """The tuned form: n x n mass matrix and forcing in one function, common subexpressions shared."""
    started = time.perf_counter()
    acceleration = model.lambdified(cse=True)
    return LambdifyPeer(acceleration, time.perf_counter() - started)


def build_textbook(model: KaneModel, cse: bool) -> LambdifyPeer:
    """The form of sympy's own tutorials: `mass_matrix_full` and `forcing_full`, a function each.

    lambdify's own default is cse=False.
    """
    started = time.perf_counter()
    arguments = [model.q, model.u]
    mass = sp.lambdify(arguments, model.method.mass_matrix_full, modules="numpy", cse=cse)
    force = sp.lambdify(arguments, model.method.forcing_full, modules="numpy", cse=cse)
    n = len(model.q)

    def acceleration(q: Array, u: Array, t: float = 0.0) -> Array:
        solution: Array = np.linalg.solve(mass(q, u), force(q, u)).ravel()
        return solution[n:]

    return LambdifyPeer(acceleration, time.perf_counter() - started)

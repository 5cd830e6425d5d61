"""PyDy's Cython generator as a peer: sympy's Kane equations in, PyDy's compiled right-hand side and runs out.

Numbers are baked into the equations, which spares PyDy the passing of constants; it needs at least one, so
one is passed that nothing reads. Needs the `bench` extra.
"""

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy as sp
from pydy.codegen.ode_function_generators import CythonODEFunctionGenerator
from scipy.integrate import odeint, solve_ivp

from lamc.reference.sympy_kane import KaneModel

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class PydyPeer:
    """rhs(y, t) → dy/dt with y = (q, u), shape (2n,); build_seconds is generation and compilation."""

    rhs: Any
    constants: Array
    build_seconds: float

    def acceleration(self, q: Array, u: Array) -> Array:
        """du/dt, shape (n,), rad/s²."""
        result: Array = np.array(self.rhs(np.concatenate([q, u]), 0.0, self.constants))[len(q) :]
        return result

    def run_rk45(self, start: Array, t_end: float, rtol: float, atol: float) -> Array:
        """State at t_end with scipy's RK45, shape (2n,)."""
        solution = solve_ivp(
            lambda t, y: self.rhs(y, t, self.constants), (0.0, t_end), start, "RK45", rtol=rtol, atol=atol
        )
        final: Array = solution.y[:, -1]
        return final

    def run_odeint(self, start: Array, t_end: float, rtol: float, atol: float) -> Array:
        """State at t_end with odeint (LSODA), PyDy's own default, shape (2n,)."""
        final: Array = odeint(
            self.rhs, start, [0.0, t_end], args=(self.constants,), rtol=rtol, atol=atol, mxstep=100_000
        )[-1]
        return final


def build(model: KaneModel, solver: str = "numpy") -> PydyPeer:
    """Generates and compiles; `solver` is PyDy's `linear_sys_solver`, e.g. "numpy" or "sympy:CH"."""
    started = time.perf_counter()
    unused = sp.Symbol("unused")
    generator = CythonODEFunctionGenerator(
        sp.Matrix(model.forcing),
        list(model.q),
        list(model.u),
        constants=[unused],
        mass_matrix=sp.Matrix(model.mass_matrix),
        coordinate_derivatives=sp.Matrix(model.u),
        linear_sys_solver=solver,
        constants_arg_type="array",
    )
    function = generator.generate()
    return PydyPeer(function, np.array([0.0]), time.perf_counter() - started)

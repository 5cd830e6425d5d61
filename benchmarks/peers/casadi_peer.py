"""The triple pendulum in CasADi, integrated by CVODES (SUNDIALS), as CasADi's own documentation does it.

In: tolerances and an end. Out: hinge angles. The closed form in absolute angles is written down once more, in CasADi's
symbols; CasADi solves by M with a QR of its own in symbols. Both of CVODES' methods can be had, and C
code made of the equations instead of CasADi's virtual machine.
"""

from collections.abc import Callable

import casadi as ca
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

BDF = {"linear_multistep_method": "bdf", "nonlinear_solver_iteration": "newton"}
PARAMETERS = (100.0, 100.0, 100.0, 10.0, 10.0, 10.0)  # N·m/rad, then N·m·s/rad
ADAMS = {"linear_multistep_method": "adams", "nonlinear_solver_iteration": "functional"}


def equations() -> tuple[ca.SX, ca.SX, ca.SX]:
    """State [a, u] (6,), parameters (6,): stiffness and damping of the hinges, and the state's derivative, of the
    paper's three unit plates."""
    p = ca.SX.sym("p", 6)
    a, u = ca.SX.sym("a", 3), ca.SX.sym("u", 3)
    inner = np.minimum.outer(range(3), range(3))
    outer = np.maximum.outer(range(3), range(3))
    beyond = 2 - outer
    weights = np.where(inner == outer, 1.0 / 12.0 + 0.25, 0.5) + beyond
    mass = ca.SX(3, 3)
    force = ca.SX(3, 1)
    for i in range(3):
        force[i] = 9.81 * (0.5 + 2 - i) * ca.cos(a[i])
        for j in range(3):
            mass[i, j] = weights[i, j] * ca.cos(a[i] - a[j])
            force[i] -= weights[i, j] * ca.sin(a[i] - a[j]) * u[j] ** 2
    bent = ca.vertcat(a[0], a[1] - a[0], a[2] - a[1])
    rate = ca.vertcat(u[0], u[1] - u[0], u[2] - u[1])
    torque = p[:3] * bent + p[3:] * rate
    force -= torque - ca.vertcat(torque[1], torque[2], 0.0)
    return ca.vertcat(a, u), p, ca.vertcat(u, ca.solve(mass, force))


class CasadiTriple:
    """One method of CVODES. compiled: as C made by CasADi and a compiler at -O2."""

    def __init__(self, method: dict[str, str], *, compiled: bool = False) -> None:
        state, parameters, slope = equations()
        self._problem = {"x": state, "p": parameters, "ode": slope}
        self._options: dict[str, object] = dict(method)
        if compiled:
            self._options |= {
                "jit": True,
                "compiler": "shell",
                "jit_options": {"flags": ["-O2"], "verbose": False},
            }

    def _integrator(self, times: Array, rtol: float, atol: float) -> ca.Function:
        options = self._options | {"reltol": rtol, "abstol": atol, "max_num_steps": 10_000_000}
        return ca.integrator("run", "cvodes", self._problem, 0.0, list(times), options)

    def angles(self, times: Array, rtol: float, atol: float) -> Array:
        """Hinge angles at times (m,), s, as (m, 3), rad, from rest in the flat position."""
        found = self._integrator(times, rtol, atol)(x0=np.zeros(6), p=PARAMETERS)
        return np.diff(np.array(found["xf"])[:3].T, axis=1, prepend=0.0)

    def job(self, t_end: float, rtol: float, atol: float) -> Callable[[], object]:
        """The bare run, to be timed; making the integrator is not part of it."""
        function, start = self._integrator(np.array([t_end]), rtol, atol), ca.DM.zeros(6)
        return lambda: function(x0=start, p=PARAMETERS)

    def gradient(self, t_end: float, rtol: float, atol: float) -> Callable[[], Array]:
        """d(hinge angles)/d(parameters) at t_end, (3, 6), by CVODES' forward sensitivities, whose errors count as those
        of the state do."""
        function = self._integrator(np.array([t_end]), rtol, atol)
        slopes, start = function.factory("slopes", ["x0", "p"], ["jac:xf:p"]), ca.DM.zeros(6)

        def run() -> Array:
            absolute = np.array(slopes(x0=start, p=PARAMETERS)["jac_xf_p"])[:3]
            return np.diff(absolute, axis=0, prepend=np.zeros((1, 6)))

        return run

"""Runs of the reference voices: a right-hand side in, angles and rates at requested times out.

scipy's solvers by name, and a fixed-step Dormand-Prince of our own in plain numpy, whose order can be
observed. Neither shares code with the C runtime.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from lamc.errors import DesignError, SimulationError
from lamc.mechanism.records import Mechanism
from lamc.reference.interpreter import Interpreter
from lamc.reference.maximal import MaximalCoordinates
from lamc.reference.newton_euler import NewtonEuler
from lamc.scene import Scene

Array = npt.NDArray[np.float64]
Acceleration = Callable[[Array, Array, float], Array]

METHODS = ("RK45", "RK23", "DOP853", "Radau", "BDF", "LSODA")

# Dormand and Prince 1980, table 2: nodes, coefficients, and weights of the fifth-order solution.
_NODES = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0])
_STAGES = (
    np.array([]),
    np.array([1 / 5]),
    np.array([3 / 40, 9 / 40]),
    np.array([44 / 45, -56 / 15, 32 / 9]),
    np.array([19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729]),
    np.array([9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656]),
)
_WEIGHTS = np.array([35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84])


@dataclass(frozen=True)
class Run:
    """Angles q (m, n), rad, and rates u (m, n), rad/s, at times t (m,), s, in the order of `joints`."""

    t: Array
    q: Array
    u: Array
    joints: tuple[str, ...]
    evaluations: int

    def angle(self, joint: str) -> Array:
        """Angle of one joint, shape (m,), rad."""
        return self.q[:, self.joints.index(joint)]

    def rate(self, joint: str) -> Array:
        """Rate of one joint, shape (m,), rad/s."""
        return self.u[:, self.joints.index(joint)]


def voice(
    name: str,
    mechanism: Mechanism,
    scene: Scene,
    joints: Sequence[str],
    interpreter: Interpreter | None = None,
    parameters: Mapping[str, float] | None = None,
) -> Acceleration:
    """The acceleration (q, u, t) → du/dt of "interpreter", "newton-euler" or "maximal".

    The numeric voices need `scene.effects` stated (not None). Raises DesignError for another name.
    """
    effects = scene.effects or ()
    if name == "newton-euler":
        return NewtonEuler(mechanism, effects, joints).acceleration
    if name == "maximal":
        return MaximalCoordinates(mechanism, effects, joints).acceleration
    if name != "interpreter" or interpreter is None:
        raise DesignError(f"no voice {name!r}; there are interpreter (with a program), newton-euler, maximal")
    program, constants = interpreter, interpreter.constants(parameters)
    return lambda q, u, t: program.acceleration(t, q, u, constants)


def simulate(
    acceleration: Acceleration,
    scene: Scene,
    joints: Sequence[str],
    t_eval: Array,
    rtol: float = 1e-9,
    atol: float = 1e-11,
    method: str = "RK45",
) -> Run:
    """A run from the scene's initial state at t = 0, with the solution at `t_eval` (ascending, s).

    Raises SimulationError if the solver gives up and DesignError for a method scipy does not have.
    """
    if method not in METHODS:
        raise DesignError(f"no method {method!r}; there are {', '.join(METHODS)}")
    n = len(joints)
    start = initial_state(scene, joints)
    solution = solve_ivp(
        lambda t, y: np.concatenate([y[n:], acceleration(y[:n], y[n:], t)]),
        (0.0, float(t_eval[-1])),
        start,
        method=method,
        t_eval=t_eval,
        rtol=rtol,
        atol=atol,
    )
    if not solution.success:
        raise SimulationError(f"the reference run stopped at t = {solution.t[-1]:g} s: {solution.message}")
    return Run(solution.t, solution.y[:n].T, solution.y[n:].T, tuple(joints), int(solution.nfev))


def fixed_steps(
    acceleration: Acceleration, scene: Scene, joints: Sequence[str], t_end: float, steps: int
) -> Array:
    """State (q, u) at t_end, shape (2n,), after equal Dormand-Prince steps of fifth order."""
    n = len(joints)
    state = initial_state(scene, joints)
    h = t_end / steps
    for step in range(steps):
        slopes = np.empty((6, 2 * n))
        for k, coefficients in enumerate(_STAGES):
            y = state + h * (coefficients @ slopes[:k])
            slopes[k, :n] = y[n:]
            slopes[k, n:] = acceleration(y[:n], y[n:], (step + _NODES[k]) * h)
        state = state + h * (_WEIGHTS @ slopes)
    return state


def initial_state(scene: Scene, joints: Sequence[str]) -> Array:
    """(q, u) at t = 0, shape (2n,); joints the scene does not name start at zero."""
    q = [scene.angles.get(name, 0.0) for name in joints]
    u = [scene.rates.get(name, 0.0) for name in joints]
    return np.array(q + u)

"""Runs of the reference cross-checks: a right-hand side in, angles and rates at requested times out.

scipy's solvers by name, and a fixed-step Dormand-Prince of our own in plain numpy, whose order can be
observed. Neither shares code with the C runtime.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.integrate import BDF, DOP853, LSODA, RK23, RK45, Radau

from lamc.basics.errors import DesignError, SimulationError
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.reference.interpreter import Interpreter
from lamc.reference.maximal import MaximalCoordinates
from lamc.reference.newton_euler import NewtonEuler
from lamc.reference.series import following
from lamc.run.following import series_of

Array = npt.NDArray[np.float64]
Acceleration = Callable[[Array, Array, float], Array]

METHODS = {"RK45": RK45, "RK23": RK23, "DOP853": DOP853, "Radau": Radau, "BDF": BDF, "LSODA": LSODA}

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


class EndOfRun(Exception):  # noqa: N818 - a signal, not an error
    """An acceleration raises it to end `simulate` early, with the times reached so far."""


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


def cross_check(
    name: str,
    mechanism: Mechanism,
    scene: Scene,
    joints: Sequence[str],
    interpreter: Interpreter | None = None,
    parameters: Mapping[str, float] | None = None,
) -> Acceleration:
    """The acceleration (q, u, t) → du/dt of "interpreter", "newton-euler" or "maximal".

    The numeric cross-checks need `scene.effects` stated (not None). Raises DesignError for another name.
    """
    voices: Mapping[str, Any] = {"newton-euler": NewtonEuler, "maximal": MaximalCoordinates}
    if name in voices:
        inputs = {n: each.default for n, each in scene.inputs.items()}
        voice = following(
            lambda effects: voices[name](mechanism, effects, joints),
            mechanism,
            scene.effects or (),
            inputs,
            series_of(scene),
        )
        found: Acceleration = voice.acceleration
        return found
    if name != "interpreter" or interpreter is None:
        raise DesignError(
            f"no cross-check {name!r}; there are interpreter (with a program), newton-euler, maximal"
        )
    program, constants = interpreter, interpreter.constants(parameters)
    return lambda q, u, t: program.acceleration(t, q, u, constants)


def simulate(
    acceleration: Acceleration,
    start: Array,
    joints: Sequence[str],
    t_eval: Array,
    rtol: float = 1e-9,
    atol: float = 1e-11,
    method: str = "RK45",
    max_evaluations: int = 10_000_000,
) -> Run:
    """A run from state `start` = (q, u), shape (2n,), at t = 0, with the solution at `t_eval` (ascending, s).

    It ends early, with the times reached so far, once `max_evaluations` are spent, and when `acceleration` raises
    EndOfRun after the first evaluations, which the solver makes as it begins. Raises SimulationError if
    the solver gives up and DesignError for a method scipy does not have.
    """
    if method not in METHODS:
        raise DesignError(f"no method {method!r}; there are {', '.join(METHODS)}")
    n = len(joints)

    def slope(t: float, y: Array) -> Array:
        return np.concatenate([y[n:], acceleration(y[:n], y[n:], t)])

    solver = METHODS[method](slope, 0.0, np.asarray(start), float(t_eval[-1]), rtol=rtol, atol=atol)
    rows = [np.asarray(start) for t in t_eval if t <= 0.0]
    while len(rows) < len(t_eval) and solver.nfev < max_evaluations:
        try:
            message = solver.step()
        except EndOfRun:
            break
        if solver.status == "failed":
            raise SimulationError(f"the reference run stopped at t = {solver.t:g} s: {message}")
        reached = int(np.searchsorted(t_eval, solver.t, side="right"))
        if reached > len(rows):
            dense = solver.dense_output()
            rows += [dense(t) for t in t_eval[len(rows) : reached]]
    states = np.array(rows).reshape(-1, 2 * n)
    return Run(t_eval[: len(rows)], states[:, :n], states[:, n:], tuple(joints), int(solver.nfev))


def fixed_steps(acceleration: Acceleration, start: Array, t_end: float, steps: int) -> Array:
    """State (q, u) at t_end from `start` at t = 0, both (2n,), after equal steps of Dormand-Prince 5."""
    n = len(start) // 2
    state = np.asarray(start)
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

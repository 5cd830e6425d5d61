"""What `check` compares of loops: residuals, Jacobian and the run's closure. Cross-checks in, comparisons out.

The cross-checks choose their equations differently: along other cycles, in other frames, with other rows left out where
nothing moves them. What does not depend on that choice is compared: where they close, and which motions they leave.
"""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from lamc.reference.check_report import Comparison, Largest
from lamc.reference.closing import State
from lamc.reference.constrained import split
from lamc.reference.interpreter import Interpreter
from lamc.reference.kinematics import Array
from lamc.reference.newton_euler import NewtonEuler

KEPT_CLOSED = 1e-9  # of the size, along a run
OPEN = 1e-6  # rad, or of the size: far above round-off, far below the gaps of the places looked at
_KEPT = "what every run of loops is held to, measured on poses of the other cross-check"


class Closing(Protocol):
    """What is needed of a simulator with loops."""

    def closure(self, q: Array) -> tuple[Array, Array]: ...


def closures(
    simulator: Closing,
    interpreter: Interpreter,
    constants: Array,
    newton: NewtonEuler,
    closed: Sequence[State],
    limits: tuple[float, float],
    reasons: tuple[str, str],
) -> list[Comparison]:
    """Residuals and Jacobians at closed states, and residuals at open places beside them.

    `limits` and `reasons`: for the same program, and for the independent formulation. Of the latter: residuals that are
    nought at its closed states and are not beside them, and the projector onto the motions that J leaves free.
    """
    same, other = ("C", "interpreter"), ("C", "Newton-Euler")
    equations = tuple(f"equation {i + 1}" for i in range(interpreter.program.closure_count))
    rows, columns = Largest(equations, same), Largest(equations, same)
    gaps, free = Largest(("all loops",), other), Largest(interpreter.joints, other)
    for k, (_, q, u) in enumerate(closed):
        where = f"state {k}"
        residual, jacobian = simulator.closure(q)
        theirs = split(newton.gaps(q)[1])
        gaps.add(np.array([_largest(residual)]), np.zeros(1), where, 1.0)
        ours = split(jacobian).free
        # Round-off of the rows grows by their condition in the directions that they tell.
        free.add(ours @ ours.T, theirs.free @ theirs.free.T, where, theirs.condition)
        columns.add(jacobian, interpreter.gaps(q, constants)[1], where)
        place = q + 0.3 * u / max(float(np.abs(u).max(initial=0.0)), 1.0) + 0.2  # rad: far off closure
        residual = simulator.closure(place)[0]
        rows.add(residual, interpreter.gaps(place, constants)[0], where, 1.0)
        is_open = [_largest(residual) > OPEN, _largest(newton.gaps(place)[0]) > OPEN * newton.size]
        gaps.add(np.array([float(is_open[0])]), np.array([float(is_open[1])]), where, 1.0)
    return [
        rows.comparison("closure, residuals", limits[0], reasons[0]),
        gaps.comparison("closure, residuals", limits[1], reasons[1]),
        columns.comparison("closure, Jacobian", limits[0], reasons[0]),
        free.comparison("closure, free motions", limits[1], reasons[1]),
    ]


def kept_closed(newton: NewtonEuler, result: Any) -> Comparison:
    """How far the C's run is from closure, of the angles of all hinges."""
    closed = Largest(("all loops",), ("C", "Newton-Euler"))
    for t, q in zip(result.t.tolist(), result.q, strict=True):
        closed.add(np.array([_largest(newton.gaps(q)[0])]), np.zeros(1), f"t = {t:.3g} s", newton.size)
    return closed.comparison("closure of the run", KEPT_CLOSED, _KEPT)


def _largest(residual: Array) -> float:
    return float(np.abs(residual).max(initial=0.0))

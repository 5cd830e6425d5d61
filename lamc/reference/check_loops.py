"""What `check` compares of loops: residuals, Jacobian and hinges of the closure. Cross-checks in, comparisons out.

The cross-checks choose their equations differently, in other frames and with other rows left out where nothing moves
them. What does not depend on that choice is compared: lengths of the residuals, and the products JᵀJ.
"""

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from lamc.reference.check_report import Comparison, Largest
from lamc.reference.closing import State
from lamc.reference.interpreter import Interpreter
from lamc.reference.kinematics import Array
from lamc.reference.newton_euler import NewtonEuler

KEPT_CLOSED = 1e-9  # of the size, along a run
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

    `limits` and `reasons`: for the same program, and for the independent formulation.
    """
    joints = interpreter.joints
    same = ("C", "interpreter")
    other = ("C", "Newton-Euler")
    equations = tuple(f"equation {i + 1}" for i in range(interpreter.program.closure_count))
    rows, columns = Largest(equations, same), Largest(equations, same)
    gaps, products = Largest(("all loops",), other), Largest(joints, other)
    for k, (_, q, u) in enumerate(closed):
        where = f"state {k}"
        residual, jacobian = simulator.closure(q)
        if len(equations):
            columns.add(jacobian, interpreter.gaps(q, constants)[1], where)
        theirs = newton.gaps(q)[1]
        products.add(jacobian.T @ jacobian, theirs.T @ theirs, where)
        place = q + 0.3 * u / max(float(np.abs(u).max(initial=0.0)), 1.0) + 0.2  # rad: far off closure
        residual = simulator.closure(place)[0]
        if len(equations):
            rows.add(residual, interpreter.gaps(place, constants)[0], where, newton.size)
        length = np.linalg.norm(newton.gaps(place)[0])
        gaps.add(np.array([np.linalg.norm(residual)]), np.array([length]), where, newton.size)
    return [
        rows.comparison("closure, residuals", limits[0], reasons[0]),
        gaps.comparison("closure, residuals", limits[1], reasons[1]),
        columns.comparison("closure, Jacobian", limits[0], reasons[0]),
        products.comparison("closure, Jacobian", limits[1], reasons[1]),
    ]


def unchecked_rotations(watched: Sequence[str]) -> list[Comparison]:
    """What no cross-check can say of joints that close loops and whose angle forces read."""
    if not watched:
        return []
    names = ", ".join(repr(name) for name in watched)
    why = "all cross-checks tell these angles within ±180° alike: unchecked; a run ends there"
    return [
        Comparison(f"{names} beyond ±180°", ("C", "Newton-Euler"), math.nan, 0.0, "", "", why, compared=False)
    ]


def cut_hinges(
    interpreter: Interpreter,
    constants: Array,
    newton: NewtonEuler,
    result: Any,
    limits: tuple[float, float],
    reasons: tuple[str, str],
) -> list[Comparison]:
    """Angles and rates of the hinges that close loops along the C's run, and how far they are from closure."""
    names = interpreter.program.cuts
    order = [newton.cuts.index(name) for name in names]
    ours = [(result.angle(name), result.rate(name)) for name in names]
    pairs = (("C", "interpreter"), ("C", "Newton-Euler"))
    angles, rates = ([Largest(names, pair) for pair in pairs] for _ in range(2))
    closed = Largest(("all loops",), pairs[1])
    for k, t in enumerate(result.t.tolist()):
        q, u = result.q[k], result.u[k]
        where = f"t = {t:.3g} s"
        found = np.array([[angle[k], rate[k]] for angle, rate in ours])
        read = np.column_stack(interpreter.cut_states(q, u, constants))
        walked = np.column_stack(newton.cut_states(q, u))[order]
        pace = float(np.abs(u).max(initial=0.0))
        for which, values in enumerate((read, walked)):
            difference = (
                np.remainder(found[:, 0] - values[:, 0] + np.pi, 2.0 * np.pi) - np.pi
            )  # ±π is one place
            angles[which].add(difference, np.zeros(len(names)), where, scale=1.0)
            rates[which].add(found[:, 1], values[:, 1], where, scale=pace)
        gap = np.abs(newton.gaps(q)[0]).max(initial=0.0)
        closed.add(np.array([gap]), np.zeros(1), where, newton.size)
    comparisons = [closed.comparison("closure of the run", KEPT_CLOSED, _KEPT)]
    for what, found_by_pair in (("angles of cut hinges", angles), ("rates of cut hinges", rates)):
        for largest, limit, reason in zip(found_by_pair, limits, reasons, strict=True):
            comparisons.append(largest.comparison(what, limit, reason))
    return comparisons

"""Runs of the reference cross-checks beside the run of the C, within a bound of time.

In: the C's result and the accelerations of the other cross-checks. Out: comparisons of the angles, and notes on what
could not be compared and why. Clocks are read here to bound the work; they never enter a comparison.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import SimulationError
from lamc.reference.check_report import Comparison, Largest
from lamc.reference.closing import nudged, on_closure
from lamc.reference.integrate import Acceleration, EndOfRun, Run, simulate
from lamc.reference.newton_euler import NewtonEuler

Array = npt.NDArray[np.float64]
Progress = Callable[[str, float], None]  # the stage, and the fraction of it that is done

MOTION = 1e-8
RTOL, ATOL = 1e-11, 1e-13  # rad and rad/s; a tenth of what the C is run at
NUDGE = 1e-8  # rad: far above the integrators' errors, far below what is not linear
_NOT_FINITE = (
    15  # accelerations without a value that a run may try before it ends; a step too far tries a few
)
_REASON = "errors of two integrators, times what the motion itself makes of a small change of its start"


@dataclass(frozen=True)
class Budget:
    """What one run of another cross-check may cost: evaluations and seconds, whichever ends first."""

    evaluations: int
    seconds: float


class Watched:
    """An acceleration that tells how far the run is and ends it when its budget is spent or nothing is finite."""

    def __init__(
        self, cross_check: Acceleration, budget: Budget, t_end: float, tell: Callable[[float], None]
    ) -> None:
        self._cross_check, self._budget, self._t_end, self._tell = cross_check, budget, t_end, tell
        self._started = time.perf_counter()
        self._calls = self._missing = 0
        self.why = ""

    def __call__(self, q: Array, u: Array, t: float) -> Array:
        spent = max(
            self._calls / self._budget.evaluations,
            (time.perf_counter() - self._started) / self._budget.seconds,
        )
        if spent >= 1.0:
            self.why = f"a run may take {self._budget.evaluations} evaluations or {self._budget.seconds:g} s"
            raise EndOfRun
        self._calls += 1
        self._tell(min(1.0, max(spent, t / self._t_end if t < self._t_end else 1.0)))
        value = self._cross_check(q, u, t)
        if not np.isfinite(value).all():
            self._missing += 1
            self.why = f"its accelerations are not finite at t = {t:.3g} s"
            if self._missing >= _NOT_FINITE:
                raise EndOfRun
        return value


def motions(
    cross_checks: dict[str, Acceleration],
    budgets: dict[str, Budget],
    newton: NewtonEuler,
    result: Any,
    tell: Progress,
) -> tuple[list[Comparison], list[str]]:
    """Angles of the C's run against scipy's DOP853 on the cross-checks of `budgets`.

    How much a small change of the start grows is found with the last of them, which gives the limit.
    """
    joints, main = newton.joints, list(budgets)[-1]
    rank = max(newton.condition(q)[0] for q in result.q)
    cross_checks = {name: on_closure(newton, cross_check, rank) for name, cross_check in cross_checks.items()}
    notes = [] if result.success else [f"the run of the C did not reach its end: {result.message}"]
    start = np.concatenate([result.q[0], result.u[0]])
    plain, why = _run(main, cross_checks, budgets, start, joints, result.t, tell)
    aside = plain
    if len(plain.t) > 1:
        moved = nudged(newton, start, NUDGE)
        aside, _ = _run(main, cross_checks, budgets, moved, joints, result.t, tell)
    comparisons: list[Comparison] = []
    for name in budgets:
        run, reason = plain, why
        if name != main:
            run, reason = _run(name, cross_checks, budgets, start, joints, result.t[: len(aside.t)], tell)
            reason = reason or why
        rows = min(len(run.t), len(plain.t), len(aside.t), len(result.t))
        if rows < 2:
            said = reason or (result.message if not result.success else "the run has one row")
            comparisons.append(_not_compared(name, f"beyond t = 0: {said}"))
            continue
        growth = float(np.abs(aside.q[:rows] - plain.q[:rows]).max(initial=NUDGE)) / NUDGE
        largest = Largest(joints, ("C", name))
        for k in range(rows):
            largest.add(result.q[k], run.q[k], f"t = {run.t[k]:.3g} s", scale=1.0)
        comparisons.append(largest.comparison("angles of the run", MOTION * growth, _REASON))
        if rows < len(result.t):
            notes.append(
                f"angles of the run, C / {name}: compared up to t = {run.t[rows - 1]:.3g} s only: "
                f"{reason or 'the run from a start nearby ends there'}"
            )
    return comparisons, notes


def _run(
    name: str,
    cross_checks: dict[str, Acceleration],
    budgets: dict[str, Budget],
    start: Array,
    joints: Sequence[str],
    times: Array,
    tell: Progress,
) -> tuple[Run, str]:
    """The run of one cross-check as far as it came, and why it ended before the last of `times`."""
    watched = Watched(cross_checks[name], budgets[name], float(times[-1]), lambda f: tell(f"run {name}", f))
    n = len(joints)
    at_start = Run(times[:1], start[None, :n], start[None, n:], tuple(joints), 0)
    if len(times) < 2:
        return at_start, ""
    try:
        run = simulate(watched, start, joints, times, RTOL, ATOL, "DOP853")
    except EndOfRun:
        run = at_start
    except SimulationError as error:
        return at_start, watched.why or error.message
    return run, watched.why if len(run.t) < len(times) else ""


def _not_compared(name: str, reason: str) -> Comparison:
    return Comparison("angles of the run", ("C", name), math.nan, MOTION, "", "", reason, compared=False)

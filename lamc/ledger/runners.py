"""Integrators as a ledger sees them: something that runs the scene at a setting.

In: a simulator, a horizon, a grid of times. Out: a `Trace` for one setting, and a job to time. lamc's integrators and
scipy's are here; tools from elsewhere are in `peers`. Never: judges an error.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from lamc.ledger.clock import Clock, OutOfTime
from lamc.run.methods import METHODS
from lamc.run.request import Array, Status
from lamc.run.result import Result
from lamc.run.simulator import Simulator

ATOL = 1e-2  # of rtol, as in `Simulator.run`
MOST_STEPS = 20_000_000

# Orders of the methods: of the solution that is carried on, and of the largest error at times between steps, where the
# continuous extension may be of a lower order: 4, 7, 4 and 3, whose errors within one step are of one order more.
ORDERS = {
    **{method.name: (method.order, method.order_between) for method in METHODS.values()},
    "scipy:DOP853": (8.0, 8.0),
    "mujoco": (4.0, 4.0),
}


@dataclass(frozen=True, eq=False)
class Trace:
    """One run. result: on the grid, or None with the reason in `note`. used: what "auto" took. reached: s of motion, of
    a run that was stopped because it took too long."""

    result: Result | None
    note: str = ""
    used: str = ""
    steps: int | None = None
    rejected: int | None = None
    evaluations: int | None = None
    reached: float | None = None


class Runner(Protocol):
    """An integrator and its settings."""

    @property
    def name(self) -> str: ...
    @property
    def is_peer(self) -> bool: ...
    @property
    def is_step(self) -> bool:
        """The settings are steps, s; else tolerances."""

    @property
    def settings(self) -> tuple[float, ...]:
        """Loosest first."""

    def trace(self, setting: float, clock: Clock, seconds: float) -> Trace:
        """The run on the grid; `seconds` of wall time at most."""

    def job(self, setting: float) -> Callable[[], object]:
        """The run as it is timed: the state at the end is all that is kept."""


@dataclass(frozen=True, eq=False)
class Own:
    """An integrator of `Simulator.run`: lamc's own, or scipy's on lamc's compiled equations."""

    name: str
    simulator: Simulator
    times: Array  # (m,), s
    settings: tuple[float, ...]
    is_step: bool = False

    @property
    def is_peer(self) -> bool:
        return self.name.startswith("scipy:")

    def trace(self, setting: float, clock: Clock, seconds: float) -> Trace:
        try:
            result = self.simulator.run(
                float(self.times[-1]),
                setting,
                ATOL * setting,
                self.times,
                self.name,
                max_steps=MOST_STEPS,
                progress=clock.guard(seconds),
            )
        except OutOfTime as out:
            return Trace(None, f"stopped after {seconds:.2g} s", reached=out.reached)
        uncancelled(result)
        stats = result.stats
        counts = {"steps": stats.accepted, "rejected": stats.rejected, "evaluations": stats.evaluations}
        if not result.success or len(result.t) != len(self.times):
            return Trace(None, result.message, stats.integrator, **counts)
        if not np.isfinite(result.q).all():
            return Trace(None, "the result is not finite", stats.integrator, **counts)
        return Trace(result, "", stats.integrator, **counts)

    def job(self, setting: float) -> Callable[[], object]:
        end = float(self.times[-1])
        run, name, steps = self.simulator.run, self.name, MOST_STEPS
        return lambda: uncancelled(run(end, setting, ATOL * setting, [end], name, max_steps=steps))


def uncancelled(result: Result) -> Result:
    """The result of a run; raises KeyboardInterrupt if Ctrl-C ended it, which a run itself takes for an ending."""
    if result.status == Status.CANCELLED:
        raise KeyboardInterrupt
    return result


def grid(t_end: float, rows: int) -> Array:
    """Times at which runs are compared, (rows,), s."""
    return np.linspace(0.0, t_end, rows)

"""Flights with exact derivatives: the variational equations on the run's own steps.

In: tasks. Out: flights. Where there is no derivative, as at a limit that is touched and not passed, it takes
differences of runs instead, and says so. A model with the derivatives by a set of parameters and dimensions is compiled
once, and kept by the cache.
"""

from dataclasses import replace

import numpy as np

from lamc.basics.errors import RequestError
from lamc.fitting.drawn import moving
from lamc.fitting.flights import ATOL, DIFFERENCED, RTOL, Differences, Flight, Task
from lamc.mechanics.tangents import Columns
from lamc.run import integrators
from lamc.run.request import Along, Request
from lamc.run.sensitivities import WHY

_KNOWN = (
    1e-9  # of the largest derivative: steps of 1e-10, some thousand of them, whose errors are none of a kind
)
_KNOWN_DRAWN = 1e-7  # by dimensions: differences of drawings, see `drawn`, and ten times as much
# Of a step, while a solver walks: a run then errs by some 1e-5 of its range, a thousandth of a good sensor's noise,
# and where the walk ends is looked at with RTOL. Its derivatives are those of the run as it is.
_LOOSE_RTOL, _LOOSE_ATOL = 1e-6, 1e-8
_MAX_STEPS = 1_000_000


class Exact:
    """notes: where there were no derivatives, and why."""

    forgets = True

    def __init__(self, integrator: str = "auto") -> None:
        self._plain = Differences(integrator)
        self._how = integrator
        self._own = 0
        self._draws = False
        self.notes: list[str] = []

    @property
    def count(self) -> int:
        return self._own + self._plain.count

    @property
    def derivatives_by(self) -> str:
        return "those of the variational equations" if not self.notes else "differences of runs, where noted"

    @property
    def known_to(self) -> float:
        return DIFFERENCED if self.notes else _KNOWN_DRAWN if self._draws else _KNOWN

    @property
    def at_once(self) -> bool:
        return not self.notes and not self._how.startswith("scipy:")

    def flight(self, task: Task) -> Flight:
        return self._plain.flight(task)

    def sensitive(self, task: Task, *, fine: bool) -> Flight:
        end = float(task.times[-1])
        if end <= task.t_start or self._how.startswith("scipy:"):
            return self._plain.sensitive(task, fine=fine)
        if task.simulator.model.has_clocks:
            self._note("derivatives are differences of runs, as what is sampled is held between samples")
            return self._plain.sensitive(task, fine=fine)
        try:
            columns = Columns(tuple(task.sizes), tuple(task.drawn))
            _, motion, directions = moving(task.simulator, columns, task.drawn, task.parameters)
        except (
            RequestError
        ) as error:  # of dimensions beside which the equations are others, and of large sheets
            self._note(f"derivatives are differences of runs: {error.message}")
            return self._plain.sensitive(task, fine=fine)
        self._own += 1
        self._draws |= bool(task.drawn)
        starts = [each.start[:, None] for each in task.drawn.values()]
        start = np.hstack([np.zeros((len(task.y0), len(task.sizes))), *starts, task.directions])
        along = Along(motion.parameters, directions, np.ascontiguousarray(start))
        y0 = np.ascontiguousarray(task.y0)
        tolerances = (_LOOSE_RTOL, _LOOSE_ATOL) if task.loosely and self.at_once else (RTOL, ATOL)
        request = Request(y0, end, *tolerances, task.times, _MAX_STEPS, np.inf, None, t_start=task.t_start)
        _, done = integrators.integrate(self._how, motion, replace(request, along=along))
        if done.status != 0:
            empty = np.full((len(task.times), len(y0)), np.nan)
            message = f"{done.status.name.lower().replace('_', ' ')} at {done.t_reached:g} s"
            return Flight(motion, empty, np.zeros((*empty.shape, 0)), message)
        if done.lost is not None:
            since = f"from {done.lost[0]:.6g} s on"
            self._note(f"derivatives are differences of runs, as {since} there are none: {WHY[done.lost[1]]}")
            return self._plain.sensitive(task, fine=fine)
        assert done.along is not None
        return Flight(motion, np.hstack([done.q, done.u]), done.along)

    def _note(self, note: str) -> None:
        if not self.notes:
            self.notes.append(note)

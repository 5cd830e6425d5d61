"""Which integrator reaches an accuracy with the least work: short probes of each, at the start and amid the run.

In: a motion, a request, a rough run. Out: a `Choice`, with the work of every candidate in evaluations. Never: looks at
a clock; the same run makes the same choice.

Each method runs a window twice, at a tolerance and at a tenth of it. Their difference is the error at the looser
one, and the two efforts say how the method's work grows: effort ~ error^-s, where s is 1/order, or 0 where stability
dictates the steps. So methods are compared at equal errors, not at equal tolerances.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from lamc.run import native
from lamc.run.methods import EXPLICIT, IMPLICIT, METHODS, TIGHT, TIGHT_FOR_RADAU
from lamc.run.model import Motion
from lamc.run.request import Array, Request, Status, Trajectory
from lamc.run.result import Result

_PART = 0.02  # of the run is a window, and
_LEAST_STEPS = 8  # of the rough run: a run so short that windows have fewer costs less than probes would save
_FINER = 10.0  # ratio of the two tolerances of a probe
_ROWS = 9  # of a window, where errors are taken
_PATIENCE = 20.0  # times the steps of the rough run there
_HELD_BACK = 0.08  # s below this: steps are as short as stability asks; of order 8 it is 1/8
_RIVAL = 2.0  # times the effort of the best so far is given to another
_WORTH_CHANGING = 0.7  # of the effort of one method for all is left where each window has the best for it
_FEWEST = 2.0  # steps that tell anything
_STEEPEST = 0.5  # s of a method of order 2: steeper is chance


@dataclass(frozen=True)
class Candidate:
    """An integrator. effort: evaluations for both windows at the accuracy asked for, with what Jacobians and
    factorisations cost; infinite if it takes far more than another."""

    integrator: str
    effort: float


@dataclass(frozen=True)
class Choice:
    """The integrator to take, a tolerance to begin with, what it was chosen from, and the evaluations it took."""

    integrator: str
    rtol: float
    candidates: tuple[Candidate, ...]
    effort: float


@dataclass(frozen=True, eq=False)
class _Window:
    t: float  # s
    length: float  # s
    y: Array
    steps: int  # of the rough run


@dataclass(frozen=True)
class _Found:
    """A method in one window: error at the looser tolerance, efforts at both, and evaluations spent."""

    error: float
    efforts: tuple[float, float]
    spent: float

    @property
    def growth(self) -> float:
        """s of effort ~ error^-s."""
        if not math.isfinite(self.error):
            return 0.0
        return min(max(math.log(self.efforts[1] / self.efforts[0]) / math.log(_FINER), 0.0), _STEEPEST)

    def effort_at(self, error: float) -> float:
        """Evaluations for another error; infinite where the method did not get through."""
        if not math.isfinite(self.error):
            return math.inf
        return float(self.efforts[0] * (max(self.error, 1e-16) / error) ** self.growth)


def choose(motion: Motion, request: Request, rough: Result, accuracy: float, rtol: float) -> Choice:
    """The integrator of the least effort. rough: a run by "auto"; rtol: about what the run will need.

    Implicit methods are tried where the rough run took one, or an explicit one is held back by stability. A run of few
    steps is not probed.
    """
    windows = _windows(motion, rough, request)
    if not windows:
        return Choice(_unprobed(motion, rough, rtol), rtol, (), 0.0)
    scale = float(np.ptp(rough.q, axis=0).max(initial=0.0)) or 1.0
    probes = [_Probe(motion, request, window, rtol, scale) for window in windows]
    for probe in probes:
        probe.measure(_explicit(motion))
    if rough.stats.switches or any(each.growth < _HELD_BACK for p in probes for each in p.found.values()):
        for probe in probes:
            probe.measure(IMPLICIT)
    # Errors of all parts of the run add up, at the least.
    allowed = accuracy * windows[0].length / request.t_end
    names = tuple(probes[0].found)
    efforts = {name: [probe.found[name].effort_at(allowed) for probe in probes] for name in names}
    candidates = tuple(Candidate(name, sum(efforts[name])) for name in names)
    spent = sum(each.spent for probe in probes for each in probe.found.values())
    best = min(candidates, key=lambda c: c.effort)
    in_turn = sum(min(efforts[name][k] for name in names) for k in range(len(probes)))
    if not math.isfinite(best.effort) or in_turn < _WORTH_CHANGING * best.effort:
        return Choice("auto", rtol, candidates, spent)
    errors = [min(max(probe.found[best.integrator].error / allowed, 1e-3), 1e3) for probe in probes]
    return Choice(best.integrator, rtol / max(errors), candidates, spent)


def _windows(motion: Motion, rough: Result, request: Request) -> list[_Window]:
    """The first part of the run, and one amid what the rough run reached; none where they would tell little."""
    reached = float(rough.t[-1]) if len(rough.t) else 0.0
    length, steps = _PART * reached, math.ceil(_PART * rough.stats.accepted)
    if steps < _LEAST_STEPS or reached <= 0.0:
        return []
    middle = int(np.searchsorted(rough.t, 0.5 * reached))
    y = motion.settled(rough.t[middle], np.concatenate([rough.q[middle], rough.u[middle]]))
    return [_Window(0.0, length, request.y0, steps), _Window(float(rough.t[middle]), length, y, steps)]


def _explicit(motion: Motion) -> tuple[str, ...]:
    """The explicit methods to try. A window may lie between the knots of a table, where order 8 looks better than it
    is over the run."""
    return ("rk45",) if motion.is_rough else EXPLICIT


def _unprobed(motion: Motion, rough: Result, rtol: float) -> str:
    """The integrator for a short run: an implicit one where the rough run took one. Never "auto", whose methods depend
    on the tolerance: errors at two tolerances would tell little of each other."""
    times = [*(t for t, _ in rough.stats.switches), float(rough.t[-1]) if len(rough.t) else 0.0]
    used = dict.fromkeys(IMPLICIT, 0.0)
    for (start, name), end in zip(rough.stats.switches, times[1:], strict=True):
        if name in used:
            used[name] += end - start
    if any(used.values()):
        return "rodas5p" if rtol < TIGHT_FOR_RADAU else max(used, key=lambda name: used[name])
    return "dop853" if rtol < TIGHT and not motion.is_rough else "rk45"


class _Probe:
    """A window, and what the methods do in it."""

    def __init__(self, motion: Motion, request: Request, window: _Window, rtol: float, scale: float) -> None:
        self._motion, self._window, self._scale = motion, window, scale
        end = window.t + window.length
        self._request = replace(
            request,
            y0=np.ascontiguousarray(window.y),
            t_start=window.t,
            t_end=end,
            t_eval=np.linspace(window.t, end, _ROWS),
            progress=None,
            energy_balance=False,
        )
        self._tolerances = (rtol, rtol / _FINER)
        self._ratio = request.atol / request.rtol
        self._jacobian_cost = motion.jacobian_cost
        self.found: dict[str, _Found] = {}

    def measure(self, names: tuple[str, ...]) -> None:
        """Both runs of each method; one that takes much more than another did is not run to its end."""
        for name in names:
            runs: list[Trajectory] = []
            for k, rtol in enumerate(self._tolerances):
                best = min((each.efforts[k] for each in self.found.values()), default=math.inf)
                cost = METHODS[name].least_evaluations + (self._jacobian_cost if name in IMPLICIT else 0.0)
                steps = min(_PATIENCE * self._window.steps, _RIVAL * best / cost)
                if steps >= _FEWEST:
                    runs.append(self._run(name, rtol, math.ceil(steps)))
                if len(runs) <= k or runs[-1].status != Status.REACHED_END:
                    break
            self.found[name] = self._judged(runs)

    def _run(self, name: str, rtol: float, steps: int) -> Trajectory:
        asked = replace(
            self._request, rtol=rtol, atol=self._ratio * rtol, max_steps=min(steps, self._request.max_steps)
        )
        trajectory = native.integrate(self._motion, asked, name)[1]
        if trajectory.status == Status.CANCELLED:
            raise KeyboardInterrupt
        return trajectory

    def _judged(self, runs: list[Trajectory]) -> _Found:
        spent = sum(run.effort for run in runs)
        if len(runs) < 2 or runs[-1].status != Status.REACHED_END:
            return _Found(math.inf, (math.inf, math.inf), spent)
        error = float(np.abs(runs[0].q - runs[1].q).max(initial=0.0)) / self._scale
        return _Found(error, (runs[0].effort, runs[1].effort), spent)

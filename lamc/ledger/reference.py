"""The reference of a ledger: two runs by different methods that agree, and how far they do.

In: a simulator and a sweep. Out: the result that errors are measured against, with its uncertainty. How much the
motion itself makes of a small change of its start is measured too: where that is large no integrator can help.

The tolerance is a thousandth of the tightest in the sweep, or the least that double precision allows. Runs that do not
arrive in time are tried again looser and for longer: a reference that is less exact says so, none says nothing.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from lamc.effects.base import conserves
from lamc.errors import SimulationError
from lamc.ledger.clock import Clock
from lamc.ledger.outputs import Scales, errors, scales
from lamc.ledger.records import Reference, Sweep
from lamc.ledger.runners import ATOL, MOST_STEPS, Own, grid
from lamc.run import integrators
from lamc.run.request import MIN_RTOL, Array, checked_request
from lamc.run.result import Result
from lamc.run.simulator import Simulator

TIGHTER = 1e-3  # than the tightest tolerance of the sweep
SENSITIVE = 1e3  # growth of a small change of the start that is worth a word
_NUDGE = 1e-8  # rad: far above the integrator's errors, far below what is not linear
_FIRST = ("dop853", "rk45")
_OTHER = "scipy:DOP853"  # shares no code with lamc's, and follows neither loops nor events
_FURTHER = ("radau5", "rodas5p")  # tried where the first two do not both arrive, or do not agree
_FINE = 1e-11  # rtol of the runs that show the growth
_AGREED = 1e-10  # relative: no need to try more
_ROUNDS = 4  # of runs, where fewer than two arrive
_LOOSER, _LONGER = 10.0, 2.0  # than the round before: tolerance and time


@dataclass(frozen=True, eq=False)
class Truth:
    """The reference run on the grid, its facts, the scales of errors, and whether its energy should stay as it is."""

    result: Result
    facts: Reference
    scales: Scales
    is_conservative: bool


@dataclass(frozen=True)
class _Pair:
    """The two runs that agree best."""

    first: str
    second: str
    gap: float  # the largest difference of an output, over its range


def make_reference(simulator: Simulator, sweep: Sweep, clock: Clock, seconds: float) -> Truth:
    """Runs at a tight tolerance until two methods agree; each run takes `seconds` of wall time, or more where fewer
    than two arrive by then. Raises SimulationError where they never do."""
    times = grid(sweep.t_end, sweep.rows)
    rtol = max(MIN_RTOL, TIGHTER * min(sweep.tolerances))
    found: dict[str, Result] = {}
    late: dict[str, float] = {}  # how far those came that were stopped, s of motion
    told = ""
    for again in range(_ROUNDS):
        names = sorted(late, key=lambda n: -late[n])[:2] if again else (*_FIRST, _OTHER, *_FURTHER)
        loose, patience = rtol * _LOOSER**again, seconds * _LONGER**again
        for name in names:
            if name == _OTHER and any(r.motion.model.cuts or r.motion.model.guards for r in found.values()):
                continue
            if len(found) > 1 and (again or _pair(found, simulator).gap <= _AGREED or clock.left() <= 0.0):
                break
            trace = Own(name, simulator, times, ()).trace(loose, clock, patience)
            if trace.result is not None:
                found[name] = trace.result
                late.pop(name, None)
                continue
            told = f"{name}: {trace.note}"
            if trace.reached is not None:
                late[name] = trace.reached
        if len(found) > 1 or not late:
            break
    if len(found) < 2:
        raise SimulationError(
            f"there is no reference to measure against: at rtol {rtol:g}, and looser, fewer than two methods reach "
            f"t = {sweep.t_end:g} s in time ({told}); shorten it with --t-end or raise --budget"
        )
    pair = _pair(found, simulator)
    first, second = found[pair.first], found[pair.second]
    scale = scales(first, simulator.scene)
    growth = _growth(first)
    beyond = np.flatnonzero(growth > SENSITIVE)
    facts = Reference(
        integrator=pair.first,
        rtol=first.stats.rtol,
        second=pair.second,
        second_rtol=second.stats.rtol,
        uncertainty=pair.gap,
        rates_uncertainty=errors(first, second, scale).rates,
        growth=float(growth.max(initial=1.0)),
        sensitive_after=float(times[beyond[0]]) if len(beyond) else None,
    )
    return Truth(first, facts, scale, all(conserves(e, first.energies) for e in simulator.effects))


def _pair(found: dict[str, Result], simulator: Simulator) -> _Pair:
    """The two of the runs that agree best, the one that came first before the other."""
    scale = scales(next(iter(found.values())), simulator.scene)
    pairs = [_Pair(a, b, float(errors(found[a], found[b], scale).path)) for a, b in combinations(found, 2)]
    return min(pairs, key=lambda pair: pair.gap)


def _growth(truth: Result) -> Array:
    """How much a change of the start by _NUDGE in every angle has grown at each time in any angle, shape (m,), at
    least 1. Rates are left out: in stiff hinges those of a small angle are large."""
    start = np.concatenate([truth.q[0], truth.u[0]])
    signs = np.zeros(len(start))
    signs[: truth.q.shape[1]] = np.where(np.arange(truth.q.shape[1]) % 2, -1.0, 1.0)
    runs = []
    for y0 in (start, _settled(truth, start + _NUDGE * signs)):
        request = checked_request(
            y0, float(truth.t[-1]), _FINE, ATOL * _FINE, truth.t, MOST_STEPS, None, None
        )
        runs.append(integrators.integrate("auto", truth.motion, request)[1])
    rows = min(len(run.t) for run in runs)
    change: Array = np.abs(runs[1].q[:rows] - runs[0].q[:rows]).max(axis=1)
    return np.maximum(change / max(float(change[0]), _NUDGE), 1.0)


def _settled(truth: Result, y: Array) -> Array:
    """A state near y on closure."""
    model = truth.motion.model
    if model.cuts:
        moved = model.ffi.new("double *")
        model.lib.lamc_motion_settle(truth.motion.handle, 0.0, model.write(y), moved)
    return y

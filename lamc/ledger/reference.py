"""The reference of a ledger: two runs by different methods that agree, and how far they do.

In: a simulator and a sweep. Out: the result that errors are measured against, with its uncertainty. How much the
motion itself makes of a small change of its start is measured too: where that is large no integrator can help.

The tolerance is a thousandth of the tightest in the sweep, or the least that double precision allows.
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


@dataclass(frozen=True, eq=False)
class Truth:
    """The reference run on the grid, its facts, the scales of errors, and whether its energy should stay as it is."""

    result: Result
    facts: Reference
    scales: Scales
    is_conservative: bool


def make_reference(simulator: Simulator, sweep: Sweep, clock: Clock, seconds: float) -> Truth:
    """Runs at a tight tolerance until two methods agree. Raises SimulationError where no two arrive in `seconds`."""
    times = grid(sweep.t_end, sweep.rows)
    rtol = max(MIN_RTOL, TIGHTER * min(sweep.tolerances))
    found: dict[str, Result] = {}
    told = ""
    uncertainty, pair, scale = np.inf, ("", ""), None
    for name in (*_FIRST, _OTHER, *_FURTHER):
        if name == _OTHER and any(r.motion.model.cuts or r.motion.model.guards for r in found.values()):
            continue
        if len(found) > 1 and (uncertainty <= _AGREED or clock.left() <= 0.0):
            break
        trace = Own(name, simulator, times, ()).trace(rtol, clock, seconds)
        if trace.result is None:
            told = f"{name}: {trace.note}"
            continue
        found[name] = trace.result
        scale = scale or scales(trace.result, simulator.scene)
        for a, b in combinations(found, 2):
            gap = errors(found[a], found[b], scale).path
            if gap < uncertainty:
                uncertainty, pair = gap, (a, b)
    if scale is None or len(found) < 2:
        raise SimulationError(
            f"there is no reference to measure against: at rtol {rtol:g} fewer than two methods reach "
            f"t = {sweep.t_end:g} s within {seconds:.2g} s each ({told}); shorten it with --t-end or raise --budget"
        )
    first, second = found[pair[0]], found[pair[1]]
    growth = _growth(first)
    beyond = np.flatnonzero(growth > SENSITIVE)
    facts = Reference(
        integrator=pair[0],
        rtol=rtol,
        second=pair[1],
        second_rtol=rtol,
        uncertainty=float(uncertainty),
        rates_uncertainty=errors(first, second, scale).rates,
        growth=float(growth.max(initial=1.0)),
        sensitive_after=float(times[beyond[0]]) if len(beyond) else None,
    )
    return Truth(first, facts, scale, all(conserves(e, first.energies) for e in simulator.effects))


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

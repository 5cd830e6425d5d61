"""The reference of a ledger: two runs by different methods that agree, and how far they do.

In: a simulator and a sweep. Out: the result that errors are measured against, with its uncertainty. How much the
motion itself makes of a small change of its start is measured too: where that is large no integrator can help.

The tolerance is a thousandth of the tightest in the sweep, or the least that double precision allows. Where fewer than
two methods arrive in time, as with contact, whose many events keep a run from becoming cheap, they are tried again
looser and for longer, as much as what they reached says is needed: a reference that is less exact says so, none says
nothing. Where only one method arrives at any tolerance, it is held against itself at a looser one, which is reported.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, zip_longest

import numpy as np

from lamc.basics.errors import SimulationError
from lamc.ledger.clock import Clock, OutOfTime
from lamc.ledger.outputs import Scales, errors, scales
from lamc.ledger.records import DECADES, Reference, Sweep
from lamc.ledger.runners import ATOL, MOST_STEPS, Own, grid
from lamc.records.effect import conserves
from lamc.run import integrators
from lamc.run.methods import EXPLICIT, IMPLICIT
from lamc.run.request import MIN_RTOL, Array, Progress, Status, checked_request
from lamc.run.result import Result
from lamc.run.run_record import Event
from lamc.run.simulator import Simulator

TIGHTER = 1e-3  # than the tightest tolerance of the sweep
SENSITIVE = 1e3  # growth of a small change of the start that is worth a word
_NUDGE = 1e-8  # rad: far above the integrator's errors, far below what is not linear
_OTHER = "scipy:DOP853"  # shares no code with lamc's, and follows neither loops nor events
_FURTHER = IMPLICIT[::-1]  # tried where the first two do not both arrive, or do not agree
_FINE = 1e-11  # rtol of the runs that show the growth
_AGREED = 1e-10  # relative: no need to try more
LOOSEST = max(DECADES)  # rtol
_LONGER = (
    1.0,
    2.0,
    4.0,
    8.0,
    8.0,
)  # times the patience, by rounds of runs; the last is at the loosest tolerance
_LOOSER = 10.0  # than itself, where only one method arrives
_LEAST_PART = 1e-9  # of the motion is what a run is taken to have come to that was stopped at once
_GROWTH_PATIENCE = 4.0  # times the patience is what a run may take that shows the growth
_GAIN = 3.0  # a run may become n times as cheap at n^3 times the tolerance: not so much looser as order 5 would have it


@dataclass(frozen=True, eq=False)
class Truth:
    """The reference run on the grid, its facts, the scales of errors, and whether its energy should stay as it is.

    seconds  wall time of the slower of its two runs: looser runs of such methods take less
    """

    result: Result
    facts: Reference
    scales: Scales
    is_conservative: bool
    seconds: float = 0.0  # s


@dataclass(frozen=True, eq=False)
class _Arrived:
    """A run that reached the end. seconds: of wall time."""

    name: str
    result: Result
    seconds: float


@dataclass(frozen=True, eq=False)
class _Pair:
    """Two runs, and the largest difference of an output between them, over its range."""

    first: _Arrived
    second: _Arrived
    gap: float


def make_reference(simulator: Simulator, sweep: Sweep, clock: Clock, seconds: float) -> Truth:
    """Runs at a tight tolerance until two methods agree; each run takes `seconds` of wall time, or more where fewer
    than two arrive by then. Raises SimulationError where not even one does at the loosest tolerance of a sweep, and
    KeyboardInterrupt on Ctrl-C."""
    pair = _Search(simulator, sweep, clock, seconds).pair()
    first, second = pair.first.result, pair.second.result
    scale = scales(first, simulator.scene)
    growth = _growth(first, clock.guard(2 * _GROWTH_PATIENCE * seconds))
    beyond = [] if growth is None else np.flatnonzero(growth > SENSITIVE).tolist()
    facts = Reference(
        integrator=pair.first.name,
        rtol=first.stats.rtol,
        second=pair.second.name,
        second_rtol=second.stats.rtol,
        uncertainty=pair.gap,
        rates_uncertainty=errors(first, second, scale).rates,
        growth=None if growth is None else float(growth.max(initial=1.0)),
        sensitive_after=float(first.t[beyond[0]]) if beyond else None,
        events=len(first.events),
        events_differ_after=events_differ_after(
            first.events, second.events, sweep.t_end / max(sweep.rows - 1, 1)
        ),
    )
    conserved = all(conserves(e, first.energies) for e in simulator.effects)
    return Truth(first, facts, scale, conserved, max(pair.first.seconds, pair.second.seconds))


class _Search:
    """Runs of one scene, round by round, until two methods arrive."""

    def __init__(self, simulator: Simulator, sweep: Sweep, clock: Clock, seconds: float) -> None:
        self._simulator, self._clock, self._patience = simulator, clock, seconds
        self._times = grid(sweep.t_end, sweep.rows)
        self._rtol = max(MIN_RTOL, TIGHTER * min(sweep.tolerances))
        self._found: dict[str, _Arrived] = {}
        self._needed: dict[str, float] = {}  # s of wall time, of others; infinite: they broke down
        self._reported = ""

    def pair(self) -> _Pair:
        """The two runs that agree best. Raises as `make_reference` does."""
        self._first_round()
        rtol = self._rtol
        for again, longer in enumerate(_LONGER[1:], start=2):
            if len(self._found) > 1 or not self._needed:
                break
            patience = longer * self._patience
            names = sorted(self._needed, key=lambda n: self._needed[n])[: 2 - len(self._found)]
            if rtol >= LOOSEST and min(self._needed.values()) > _LONGER[-1] * self._patience:
                break
            rtol = LOOSEST if again == len(_LONGER) else self._looser(rtol, patience, names)
            for name in names:
                self._try(name, rtol, patience)
        if len(self._found) == 1:
            self._hold_against_itself()
        if len(self._found) < 2:
            end = self._times[-1]
            raise SimulationError(
                f"there is no reference to measure against: at rtol {self._rtol:g}, and looser down to {rtol:g}, no "
                f"method reaches t = {end:g} s in time ({self._reported}); shorten it with --t-end or raise --budget"
            )
        return self._best()

    def _first_round(self) -> None:
        """All methods, until two agree."""
        for name in (*EXPLICIT, _OTHER, *_FURTHER):
            model = next((run.result.motion.model for run in self._found.values()), None)
            if name == _OTHER and (model is None or model.cuts or model.guards):
                continue
            enough = len(self._found) > 1
            if enough and (self._best().gap <= _AGREED or self._clock.left() <= 0.0):
                break
            self._try(name, self._rtol, self._patience)

    def _try(self, name: str, rtol: float, seconds: float) -> None:
        before = self._clock.spent
        trace = Own(name, self._simulator, self._times, ()).trace(rtol, self._clock, seconds)
        spent = self._clock.spent - before
        if trace.result is not None:
            self._found[name] = _Arrived(name, trace.result, spent)
            self._needed.pop(name, None)
            return
        self._reported = f"{name}: {trace.note}"
        part = math.nan if trace.reached is None else max(trace.reached / float(self._times[-1]), _LEAST_PART)
        self._needed[name] = math.inf if math.isnan(part) else seconds / part

    def _looser(self, rtol: float, patience: float, names: Sequence[str]) -> float:
        """The tolerance, in whole decades, at which the slowest of these may arrive in time."""
        known = [self._needed[name] for name in names if math.isfinite(self._needed[name])]
        decades = int(_GAIN * math.log10(max(max(known, default=0.0) / patience, 1.0)))
        return min(rtol * 10.0 ** max(decades, 1), LOOSEST)

    def _hold_against_itself(self) -> None:
        """Where only one method arrives, a looser run of it takes the place of another's: it has ten times the error,
        so that what they differ by is no less than the error of the tighter one, unless the method itself is wrong."""
        (alone,) = self._found.values()
        rtol = alone.result.stats.rtol * _LOOSER
        trace = Own(alone.name, self._simulator, self._times, ()).trace(
            rtol, self._clock, 2.0 * alone.seconds + self._patience
        )
        if trace.result is not None:
            self._found[f"{alone.name} once more"] = replace(alone, result=trace.result)

    def _best(self) -> _Pair:
        """The two that agree best, the one that came first before the other."""
        found = list(self._found.values())
        scale = scales(found[0].result, self._simulator.scene)
        pairs = [
            _Pair(a, b, float(errors(a.result, b.result, scale).path)) for a, b in combinations(found, 2)
        ]
        return min(pairs, key=lambda pair: pair.gap)


def events_differ_after(mine: Sequence[Event], others: Sequence[Event], apart: float) -> float | None:
    """When two runs cease to have the same events, s: one has an event that the other lacks, or has it later or sooner
    by more than `apart` s. None: never. What happens at one instant may come in any order."""
    moments = []
    for name in {event.name: None for event in (*mine, *others)}:
        a, b = ([event.t for event in events if event.name == name] for events in (mine, others))
        for one, other in zip_longest(a, b):
            if one is None or other is None or abs(one - other) > apart:
                moments.append(min(t for t in (one, other) if t is not None))
                break
    return min(moments, default=None)


def _growth(truth: Result, guard: Progress) -> Array | None:
    """How much a change of the start by _NUDGE in every angle has grown at each time in any angle, shape (m,), at
    least 1. Rates are left out: in stiff hinges those of a small angle are large. None where `guard` ends it."""
    start = np.concatenate([truth.q[0], truth.u[0]])
    signs = np.zeros(len(start))
    signs[: truth.q.shape[1]] = np.where(np.arange(truth.q.shape[1]) % 2, -1.0, 1.0)
    runs = []
    for y0 in (start, _settled(truth, start + _NUDGE * signs)):
        request = checked_request(
            y0, float(truth.t[-1]), _FINE, ATOL * _FINE, truth.t, MOST_STEPS, None, guard
        )
        try:
            run = integrators.integrate("auto", truth.motion, request)[1]
        except OutOfTime:
            return None
        if run.status == Status.CANCELLED:
            raise KeyboardInterrupt
        runs.append(run)
    rows = min(len(run.t) for run in runs)
    change: Array = np.abs(runs[1].q[:rows] - runs[0].q[:rows]).max(axis=1)
    return np.maximum(change / max(float(change[0]), _NUDGE), 1.0)


def _settled(truth: Result, y: Array) -> Array:
    """A state near y on closure."""
    return truth.motion.settled(0.0, y)

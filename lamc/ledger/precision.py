"""Work against precision: every integrator at every tolerance, each with its errors and its time.

In: runners and the reference. Out: a `Point` per setting, failures and what was left out among them, and the observed
orders. Each runner may use an equal part of the time that is left, so that a slow one does not starve the others.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from lamc.ledger.clock import Clock, processor_seconds, shortest
from lamc.ledger.outputs import drift, errors
from lamc.ledger.records import ObservedOrder, Point
from lamc.ledger.reference import Truth
from lamc.ledger.runners import ORDERS, Runner, Trace
from lamc.run.result import Result

Told = Callable[[float, float], None]
Job = Callable[[], object]

_GROWTH = 2.2  # of a run's cost from one tolerance to the next: order 3; higher ones cost less
_HEAD, _TAIL = 0.02, 30.0  # slopes are fitted to errors below this, and above the floor times this
_FLOOR = 1e-13  # relative: below, round-off hides the method
_OFF_LINE = math.log(2.0)
_MORE_STEPS = (
    1.15  # from a tolerance to the next: order 8 has 1.33, and steps that stability dictates do not change
)


@dataclass
class _Queue:
    """What a runner has still to do, and what its last run cost, s of wall time."""

    runner: Runner
    waiting: list[float]
    cost: float = 0.0


@dataclass(frozen=True, eq=False)
class Measured:
    """A point with the job that times it; None for one that failed."""

    point: Point
    job: Job | None


def measure_points(
    runners: Sequence[Runner], truth: Truth, clock: Clock, share: float, tell: Told, found: list[Measured]
) -> None:
    """Runs everything that fits until `share` of the clock's budget is spent, and the loosest setting of lamc's own
    integrators in any case, if it takes no longer than the reference did. found: grows by what is measured."""
    queues = [_Queue(runner, list(runner.settings)) for runner in runners]
    try:
        _measure_queues(queues, truth, clock, share, tell, found)
    except KeyboardInterrupt:
        found += [
            Measured(_empty(queue.runner, setting, "left out: interrupted"), None)
            for queue in queues
            for setting in queue.waiting
        ]
        raise
    for queue in queues:
        for setting in queue.waiting:
            spent = f"it would take more than its part of the budget (the last took {queue.cost:.2g} s)"
            note = f"left out: {spent if queue.cost else 'the budget is spent'}"
            found.append(Measured(_empty(queue.runner, setting, note), None))


def _measure_queues(
    queues: Sequence[_Queue], truth: Truth, clock: Clock, share: float, tell: Told, found: list[Measured]
) -> None:
    """In turns, until nothing waits or nothing of it fits any more."""
    total = sum(len(queue.waiting) for queue in queues)
    moving = True
    while moving:
        moving = False
        for queue in queues:
            if not queue.waiting:
                continue
            allowed = clock.left(share) / sum(bool(q.waiting) for q in queues)
            if not queue.cost and not queue.runner.is_peer:
                allowed = max(allowed, truth.seconds)
            if allowed <= 0.0 or queue.cost * _GROWTH > allowed:
                continue
            moving = True
            before = clock.spent
            found.append(_measured(queue.runner, queue.waiting[0], truth, clock, allowed))
            queue.waiting.pop(0)
            queue.cost = clock.spent - before
            tell(float(total - sum(len(q.waiting) for q in queues)), float(total))


def repeat(measured: list[Measured], seconds: float) -> None:
    """Gives the points the shortest time of further turns, within `seconds` of wall time."""
    able = [k for k, each in enumerate(measured) if each.job is not None]
    jobs = [each.job for each in measured if each.job is not None]
    first = [measured[k].point.seconds or 0.0 for k in able]
    for k, (best, turns) in zip(able, shortest(jobs, first, seconds), strict=True):
        measured[k] = replace(measured[k], point=replace(measured[k].point, seconds=best, repeats=turns))


def in_order(measured: Sequence[Measured]) -> tuple[Point, ...]:
    """The points, peers last, by integrator, the loosest setting first."""
    points = [each.point for each in measured]
    names = list(dict.fromkeys(p.integrator for p in points))
    return tuple(sorted(points, key=lambda p: (p.is_peer, names.index(p.integrator), -p.setting)))


def _measured(runner: Runner, setting: float, truth: Truth, clock: Clock, seconds: float) -> Measured:
    trace = runner.trace(setting, clock, seconds)
    point = _empty(runner, setting, trace.note)
    job = None
    if trace.result is not None:
        job = runner.job(setting)
        point = _filled(point, trace, trace.result, truth)
        point = replace(point, seconds=processor_seconds(job), repeats=1)
    return Measured(point, job)


def _empty(runner: Runner, setting: float, note: str) -> Point:
    return Point(runner.name, runner.is_peer, setting, runner.is_step, succeeded=False, note=note)


def _filled(point: Point, trace: Trace, result: Result, truth: Truth) -> Point:
    off = errors(result, truth.result, truth.scales)
    if not math.isfinite(off.path + off.rates):
        return replace(point, note="the result is not finite")
    loops = result.motion.model.cuts
    return replace(
        point,
        succeeded=True,
        used=trace.used,
        steps=trace.steps,
        rejected=trace.rejected,
        evaluations=trace.evaluations,
        end=off.end,
        path=off.path,
        rates=off.rates,
        closure=float(result.constraint_error.max()) / result.mechanism.size if loops else None,
        drift=drift(result, truth.result) if truth.is_conservative else None,
        is_floor=off.path <= truth.facts.uncertainty,
    )


def observed_orders(points: Sequence[Point], truth: Truth) -> tuple[ObservedOrder, ...]:
    """The order of each integrator as this scene shows it: errors fall as steps^-order.

    Fitted where errors are small enough for the leading term and well above the reference's uncertainty, and where the
    tolerance decides on the steps: at loose ones stability may.
    """
    least = _TAIL * max(truth.facts.uncertainty, _FLOOR)
    found = []
    for name in dict.fromkeys(p.integrator for p in points):
        own = sorted((p for p in points if p.integrator == name and p.steps), key=lambda p: -p.setting)
        kept = [
            p
            for before, p in pairwise(own)
            if p.succeeded and (p.steps or 0) >= _MORE_STEPS * (before.steps or 0)
        ]
        kept += [p for p in own[:1] if p.succeeded and p.is_step]
        theory = ORDERS.get(name)
        ends = [(p.steps or 0, p.end) for p in kept if p.end is not None and least < p.end < _HEAD]
        paths = [(p.steps or 0, p.path) for p in kept if p.path is not None and least < p.path < _HEAD]
        found.append(
            ObservedOrder(
                integrator=name,
                end=slope(ends) if theory else None,
                path=slope(paths) if theory else None,
                theory=theory[0] if theory else None,
                path_theory=theory[1] if theory else None,
                points=len(paths),
            )
        )
    return tuple(found)


def slope(pairs: Sequence[tuple[float, float]]) -> float | None:
    """The order that (steps, error) show: the slope of least squares on logarithms, positive. None for fewer than
    three, and where they lie off that line by a factor of two (root mean square): then no single term rules."""
    if len(pairs) < 3:
        return None
    steps, error = np.log(np.asarray(pairs, dtype=float)).T
    line = np.polyfit(steps, error, 1)
    off = float(np.sqrt(np.mean((np.polyval(line, steps) - error) ** 2)))
    return float(-line[0]) if off < _OFF_LINE else None

"""Least squares: a walk by loose runs, its end by exact ones, weights that follow the noise, and other starts where the
first fails.

In: an objective, a start. Out: a `Solved`. Steps are those of `trust`. Where runs have exact derivatives they are those
of the run as it is computed, however loosely: the walk comes to where that run is nearest to the data, which is off by
the run's error, and a step or two of exact runs go the rest.
"""

from dataclasses import dataclass, replace

import numpy as np

from lamc.basics.errors import LamcError, RequestError, SimulationError
from lamc.fitting.neighbours import likeness
from lamc.fitting.objective import Objective, Weighed, groups_of, residual_sigmas
from lamc.fitting.trust import Box, minimise
from lamc.fitting.unknowns import Unknowns
from lamc.run.request import Array

_GAIN = 1e-8  # of the cost: of a thousand data, numbers are off by 0.003 of their standard error
_CHANGE = 1e-9  # of the numbers' sizes, which runs of 1e-10 a step tell, where there is no noise
# The same for a walk by loose runs, a step before its end: the next comes quadratically nearer, tried by exact runs.
_NEAR_GAIN, _NEAR_CHANGE = 1e-4, 1e-5
_POOR = 0.1  # share of the data's variance that is left, above which other starts are looked at
_NOISE, _MOST = (
    0.3,
    0.5,
)  # neighbours less alike than the one are noise, which may be up to the other of the variance
_LOST = 0.9  # neighbours so much alike
_FAR_OFF = 3.0  # of logarithms: a factor of twenty either way, from where a fit begins
_SAME = 1.01  # times the best cost: another way to the same place
_ROUNDS = 4  # of weights
_SCREENED = 8  # places that are looked at for each start that is gone from
_SHARES = (1 / 16, 1 / 8, 1 / 4, 1 / 2)  # of recordings, one after the other
_DEAD = 1e-9  # of the largest column times its range: a gradient that is zero


@dataclass(frozen=True, eq=False)
class Solved:
    """inner: (p,), the solver's vector; cost: half the sum of squares, or of the loss; message: how it ended."""

    inner: Array
    cost: float
    converged: bool
    message: str
    objective: Objective
    notes: tuple[str, ...] = ()
    steps: int = 0
    back: Array | None = None  # (p,), of a walk whose end is not looked at: where its last run was


def solve(objective: Objective, loss: str, starts: int, seed: int, max_steps: int = 60) -> Solved:
    """The best fit that is found. Raises SimulationError where no start gives a run, RequestError for unknowns that
    change nothing."""
    unknowns = objective.predictor.setting.unknowns
    begin = _inside(objective, unknowns.within(unknowns.start))
    found = _weighted(objective, begin, loss, max_steps)
    if is_poor(found):
        found = _grown(found, begin, loss, max_steps)
    return elsewhere(found, loss, starts, seed, max_steps)


def elsewhere(found: Solved, loss: str, starts: int, seed: int, max_steps: int = 60) -> Solved:
    """The same, or what other starts lead to where it is poor."""
    if starts > 1 and is_poor(found):
        return _other_starts(found, loss, starts, seed, max_steps)
    return found


def is_poor(found: Solved) -> bool:
    """Whether it did not converge, or leaves much of the data that is no noise."""
    if not found.converged:
        return True
    share = left_over(found.objective, found.inner)
    return share > _POOR and (share > _MOST or not _likeness(found) < _NOISE)


def is_lost(found: Solved) -> bool:
    """Whether its run leaves the recording somewhere, however much it explains in all: residuals that change slowly."""
    return _likeness(found) > _LOST


def _likeness(found: Solved) -> float:
    """The largest correlation of neighbouring residuals of a column; NaN where none is known."""
    predictions = found.objective.predictions(found.inner, sloped=False)
    known = [
        each[0]
        for run, prediction in zip(found.objective.predictor.setting.runs, predictions, strict=True)
        if not prediction.message
        for column in (prediction.values - run.measured).T
        if (each := likeness(column)) is not None
    ]
    return max(known, default=np.nan)


def _grown(first: Solved, begin: Array, loss: str, max_steps: int) -> Solved:
    """The better of the first, and of fits of ever longer parts of the recordings: what swings is out of step after a
    few periods where its numbers are off, and the way back is over hills, but not at its first swing."""
    objective, inner = first.objective, begin
    steps = first.steps
    for share in _SHARES:
        part = Objective(objective.predictor, objective.sigmas, share)
        if part.count <= len(begin):
            continue
        found = _walked(part, inner, loss, max_steps)
        steps += found.steps
        inner = found.inner
    grown = _weighted(Objective(objective.predictor, objective.sigmas), inner, loss, max_steps)
    share = left_over(grown.objective, grown.inner)
    if not share < left_over(first.objective, first.inner):
        return replace(first, steps=steps + grown.steps)
    note = "the fit of all rows at once found no way; parts from the begin on, each longer, led here"
    return replace(grown, steps=steps + grown.steps, notes=(note,))


def _inside(objective: Objective, begin: Array) -> Array:
    """The start, or SimulationError where it makes no run; RequestError naming unknowns that nothing measured depends
    on."""
    found = objective.tried(begin, sloped=True, loosely=objective.predictor.at_once)
    if found is None:
        raise SimulationError(
            f"the run from where the fit begins fails: {objective.failures[0]}; begin elsewhere: "
            "lamc.Free(low, high, start=…)"
        )
    unknowns = objective.predictor.setting.unknowns
    felt = np.linalg.norm(objective.jacobian(begin, found), axis=0) * box_of(unknowns).sizes
    dead = [
        name
        for name, norm in zip(unknowns.names, felt, strict=True)
        if not norm > _DEAD * float(felt.max(initial=0.0))
    ]
    if dead:
        verb = "changes" if len(dead) == 1 else "change"
        raise RequestError(
            f"{' and '.join(map(repr, dead))} {verb} nothing that was recorded (the gradient is zero where the "
            "fit begins); "
            "free it no more, begin elsewhere, or record what depends on it"
        )
    return begin


def box_of(unknowns: Unknowns) -> Box:
    """Bounds and sizes of a solver's vector."""
    return Box(*unknowns.bounds, np.array([1.0 if each.log else each.size for each in unknowns.all]))


def _walked(objective: Objective, begin: Array, loss: str, max_steps: int) -> Solved:
    """By loose runs, to where exact ones may end it; by exact ones, where runs do not tell their derivatives."""
    if not objective.predictor.at_once:
        return _ended(objective, begin, loss, max_steps)
    box = box_of(objective.predictor.setting.unknowns)
    problem = Weighed(objective, loss, loosely=True)
    try:
        found = minimise(problem, begin, box, _NEAR_GAIN, _NEAR_CHANGE, max_steps)
    except LamcError as error:
        return Solved(begin, np.inf, False, error.message, objective)
    return Solved(
        found.ahead,
        found.local.cost,
        found.converged,
        "not ended",
        objective,
        steps=found.steps,
        back=found.x,
    )


def _ended(objective: Objective, begin: Array, loss: str, max_steps: int) -> Solved:
    """By exact runs."""
    unknowns = objective.predictor.setting.unknowns
    try:
        problem = Weighed(objective, loss)
        found = minimise(problem, begin, box_of(unknowns), _GAIN, _CHANGE, max_steps)
    except LamcError as error:
        return Solved(begin, np.inf, False, error.message, objective)
    if not np.isfinite(found.local.cost):
        return Solved(begin, np.inf, False, (objective.failures or ["no run"])[-1], objective)
    message = "steps and gains vanish" if found.converged else f"no end after {max_steps} steps"
    inner = unknowns.within(found.x)
    return Solved(inner, found.local.cost, found.converged, message, objective, steps=found.steps)


def _finished(walked: Solved, loss: str, max_steps: int) -> Solved:
    """The end of a walk."""
    if walked.back is None:
        return walked
    found = _ended(walked.objective, walked.inner, loss, max_steps)
    if not np.isfinite(found.cost):  # ahead of the walk no run can be made
        found = _ended(walked.objective, walked.back, loss, max_steps)
    return replace(found, steps=walked.steps + found.steps)


def _weighted(objective: Objective, begin: Array, loss: str, max_steps: int) -> Solved:
    """With weights that follow what is left, where noise of several kinds is not said."""
    found = _walked(objective, begin, loss, max_steps)
    setting = objective.predictor.setting
    names = {name for names in groups_of(objective.predictor) for name in names}
    has_priors = any(each.free.prior is not None for each in setting.unknowns.all)
    unsaid = names - {""}
    if not unsaid or not (len(names) > 1 or has_priors or loss != "linear"):
        return _finished(found, loss, max_steps)
    steps = found.steps
    for _ in range(_ROUNDS):
        if not np.isfinite(found.cost):
            break
        at = found.inner if found.back is None else found.back
        predictions = found.objective.predictions(at, sloped=False, loosely=found.back is not None)
        sigmas = residual_sigmas(objective.predictor, predictions, found.objective.sigmas)
        change = max(
            float(np.max(np.abs(np.log(new / old))))
            for new, old in zip(sigmas, found.objective.sigmas, strict=True)
        )
        found = _walked(Objective(objective.predictor, sigmas), found.inner, loss, max_steps)
        steps += found.steps
        if change < 0.05:  # of the weights: intervals move by less than what they are known to
            break
    return _finished(replace(found, steps=steps), loss, max_steps)


def left_over(objective: Objective, inner: Array) -> float:
    """The share of the data's variance that the model leaves; infinite where it makes no run."""
    left = total = 0.0
    for run, found in zip(
        objective.predictor.setting.runs, objective.predictions(inner, sloped=False), strict=True
    ):
        sigma = objective.sigmas[objective.predictor.setting.runs.index(run)]
        residual = (found.values - run.measured) / sigma
        if found.message:
            return np.inf
        some = np.isfinite(run.measured).any(axis=0)
        around = run.measured[:, some] - np.nanmean(run.measured[:, some], axis=0)
        left += float(np.nansum(residual**2))
        total += float(np.nansum((around / sigma[some]) ** 2))
    return left / total if total > 0.0 else 0.0


def _other_starts(first: Solved, loss: str, starts: int, seed: int, max_steps: int) -> Solved:
    """The best of several: the first, and those that a Latin hypercube screens."""
    objective = first.objective
    unknowns = objective.predictor.setting.unknowns
    low, high = unknowns.bounds
    reach = box_of(unknowns).sizes * [_FAR_OFF if each.log else 1.0 for each in unknowns.all]
    bottom, top = np.maximum(low, unknowns.start - reach), np.minimum(high, unknowns.start + reach)
    from scipy.stats import qmc  # half a second to load, and most fits do not need it

    sampler = qmc.LatinHypercube(len(reach), seed=seed)
    places = bottom + (top - bottom) * sampler.random(_SCREENED * (starts - 1))
    screened = Weighed(objective, "linear")
    costs = np.array([screened.cost(place) for place in places])
    order = np.argsort(costs, kind="stable")[: starts - 1]
    found = [first, *(_weighted(objective, places[k], loss, max_steps) for k in order)]
    best = min(found, key=lambda each: left_over(each.objective, each.inner))
    share = left_over(best.objective, best.inner)
    same = sum(left_over(each.objective, each.inner) <= _SAME * share + 1e-12 for each in found)
    poor = f"the first start left {left_over(first.objective, first.inner):.0%} of the data's variance"
    note = f"{poor}; {len(found)} starts, {same} of which came here"
    return replace(best, notes=(*first.notes, note) if best is first else (note,))

"""NSGA-II (Deb, Pratap, Agarwal & Meyarivan 2002) by the package pymoo: what no other point betters in all goals.

In: a problem of several goals, a seed. Out: numbers of the trials on the front, and whether it still moved.
"""

import warnings
from typing import Any

import numpy as np

from lamc.run.request import Array
from lamc.studies.optimisers.evolution import needed
from lamc.studies.problem import FEASIBLE, Problem, SpentError, Trial

_POPULATION, _GENERATIONS = 40, 60
_STILL = 0.8  # of the trials: what came later is looked at for whether the front moved
_MOVED = 5e-3  # of the box of goals, by which the room below the front may have grown


def front_of(problem: Problem, start: Array, seed: int) -> tuple[list[int], bool]:
    """Trials on the front, in the order of the first goal; whether it stands still. Raises LamcError without pymoo."""
    algorithm = needed("pymoo.algorithms.moo.nsga2", "a front of several goals (NSGA-II)").NSGA2
    base = needed("pymoo.core.problem", "NSGA-II").Problem
    minimize = needed("pymoo.optimize", "NSGA-II").minimize

    class Box(base):  # type: ignore[misc,valid-type]
        def __init__(self) -> None:
            super().__init__(
                n_var=len(start),
                n_obj=len(problem.goals),
                n_ieq_constr=1,
                xl=np.zeros(len(start)),
                xu=np.ones(len(start)),
            )

        def _evaluate(self, x: Array, out: dict[str, Any], *_: Any, **__: Any) -> None:
            places = [np.asarray(each, dtype=np.float64) for each in x]  # of a generation
            problem.ahead(places)
            trials = [problem.at(each) for each in places]
            worst = [1e30] * len(problem.goals)
            out["F"] = np.array([list(each.goals) if each.is_ok else worst for each in trials])
            kept = [problem.violation(t) - _tolerance(problem) if t.is_ok else 1e30 for t in trials]
            out["G"] = np.array(kept)[:, None]

    first = np.random.default_rng(seed).random((_POPULATION, len(start)))
    first[0] = start
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a package that tells of its compiled parts
            minimize(
                Box(), algorithm(pop_size=_POPULATION, sampling=first), ("n_gen", _GENERATIONS), seed=seed
            )
    except SpentError:
        return front(problem, problem.trials), False
    whole = front(problem, problem.trials)
    before = front(problem, problem.trials[: int(_STILL * len(problem.trials))])
    return whole, _gap(problem, whole, before) <= _MOVED


def front(problem: Problem, trials: list[Trial]) -> list[int]:
    """Numbers of the feasible trials that no other betters in one goal without being worse in another."""
    good = [trial for trial in trials if problem.is_feasible(trial)]
    values = np.array([trial.goals for trial in good]).reshape(len(good), len(problem.goals))
    order = np.lexsort(values.T[::-1])
    kept: list[int] = []
    for k in order:
        others = values[kept]
        if not len(kept) or not np.any(np.all(others <= values[k], axis=1)):
            kept.append(int(k))
    return [good[k].index for k in kept]


def knee(problem: Problem, which: list[int]) -> int:
    """Of a front: the trial nearest to the least of all goals, each by its span."""
    values = np.array([problem.trials[k].goals for k in which])
    least, span = values.min(axis=0), np.ptp(values, axis=0)
    return which[int(np.argmin(np.linalg.norm((values - least) / np.where(span > 0.0, span, 1.0), axis=1)))]


def _gap(problem: Problem, whole: list[int], before: list[int]) -> float:
    """How far the front has come, at most, by the spans of goals: for each point, how much better it is than every one
    that was there before, in the goal in which it betters it least."""
    if not whole or not before:
        return np.inf
    now, then = (np.array([problem.trials[k].goals for k in each]) for each in (whole, before))
    span = np.ptp(now, axis=0)
    better = (then[None, :, :] - now[:, None, :]) / np.where(span > 0.0, span, 1.0)
    return float(np.max(np.min(np.max(better, axis=2), axis=1)))


def _tolerance(problem: Problem) -> float:
    return FEASIBLE * max(len(problem.constraints), 1)

"""Whether an optimum is one: what is said of convergence is looked at from all sides.

In: a problem, the optimum that was found. Out: a `Verdict`: a lower trial beside it, if there is one, and in words what
is known. Nothing that a method says of itself is believed.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lamc.run.request import Array
from lamc.studies.derivatives import gradients
from lamc.studies.problem import FEASIBLE, Problem, Trial
from lamc.studies.refinement import SETTLED, Optimum

_STEPS = (1e-6, 1e-4, 1e-3, 1e-2)  # of a range
_ROUGH = 1e-9  # of the size of costs: what values are taken to be known to where slopes tell nothing
_FLAT = 1e-4  # of the size of costs over a range: slopes at which methods end whose last step gains 1e-12 of it or so
_NEAR = 1e-5  # of a range, or of a constraint's size: what is nearer to its bound is held by it
_MOST_LEVELS = 12  # of a choice that are tried


@dataclass(frozen=True)
class Verdict:
    """lower: a trial that is better, None where none was found."""

    converged: bool
    message: str
    lower: Trial | None = None


def verdict_of(problem: Problem, optimum: Optimum) -> Verdict:
    """Tries points on all sides, 1e-6 to 1e-2 of each range away, and the levels beside or in place of those that were
    chosen."""
    middle = problem.at(optimum.places)
    if not problem.is_feasible(middle):
        return Verdict(
            False, f"no point was found that keeps to the constraints: {_violated(problem, middle)}"
        )
    around = list(_beside(problem, optimum.places))
    problem.ahead(around)
    beside = [(places, problem.at(places)) for places in around]
    slack = _slack(optimum)
    lower = [
        (places, trial) for places, trial in beside if problem.merit(trial) < problem.merit(middle) - slack
    ]
    if lower:
        places, trial = min(lower, key=lambda each: problem.merit(each[1]))
        names = [n for n, a, b in zip(problem.space.names, places, optimum.places, strict=True) if a != b]
        return Verdict(False, f"with another {' and '.join(names)} the value is lower", trial)
    if not len(problem.space.real):
        return Verdict(True, "no other level of one parameter alone gives less")
    return _of_reals(problem, optimum, [trial for _, trial in beside])


def verdict_of_many(problem: Problem, places: Array) -> Verdict:
    """Of more numbers than second derivatives can be had for: whether slopes vanish along all that is free."""
    middle = problem.at(places)
    if not problem.is_feasible(middle):
        return Verdict(
            False, f"no point was found that keeps to the constraints: {_violated(problem, middle)}"
        )
    edges = problem.space.real
    gradient, rows = gradients(problem, places, edges, unknown=np.nan)
    if not np.isfinite(gradient).all():
        return Verdict(False, "points beside it make no run, so that nothing is known of its surroundings")
    values, at = problem.violations(middle), places[edges]
    holding = [k for k, c in enumerate(problem.constraints) if c.is_equal or values[k] >= -_NEAR]
    sides = np.where(at <= _NEAR, -1.0, np.where(at >= 1.0 - _NEAR, 1.0, 0.0))
    free = sides == 0.0
    while True:  # each turn lets go of one that pulls the wrong way
        forces = np.linalg.lstsq(rows[np.ix_(holding, free)].T, -gradient[free], rcond=None)[0]
        loose = [
            (f, k)
            for f, k in zip(forces, holding, strict=True)
            if f < 0.0 and not problem.constraints[k].is_equal
        ]
        if not loose:
            break
        holding.remove(min(loose)[1])
    pull = gradient + rows[holding].T @ forces
    left = np.where(free | (pull * sides > 0.0), np.abs(pull), 0.0)
    most = float(np.max(left, initial=0.0))
    told = f"slopes along what is free are {most:.1g} of the value's size over a range at most"
    if most <= _FLAT:
        return Verdict(True, f"{told}; whether the value bends upwards is not looked at for so many numbers")
    return Verdict(False, f"{told}, which is more than {_FLAT:g}: grant more runs, or begin nearer")


def _of_reals(problem: Problem, optimum: Optimum, beside: list[Trial]) -> Verdict:
    if optimum.is_settled:
        vague = _flat_names(problem, optimum)
        if vague:
            return Verdict(
                True,
                f"the value is the least there is, and does not feel {vague} here: any value near is as good",
            )
        return Verdict(True, "slopes vanish along all that is free, and the value rises on all sides")
    if len(problem.space.real) == 1 and not problem.constraints and _is_corner(problem, optimum, beside):
        return Verdict(True, "the value has a kink here, and rises on both sides of it")
    if optimum.slopes is None:
        return Verdict(False, "points beside it make no run, so that nothing is known of its surroundings")
    if not optimum.is_minimum:
        return Verdict(
            False, "the value does not bend upwards in every direction: it is a saddle, or a ridge"
        )
    away = {
        name: f"{abs(step):.1g}"
        for name, step in zip((problem.space.names[k] for k in problem.space.real), optimum.last, strict=True)
        if abs(step) > SETTLED
    }
    told = ", ".join(f"{name} by {step} of its range" for name, step in away.items())
    return Verdict(
        False,
        f"slopes call for another step ({told}), which leads to no lower value: it has a kink here, or runs are not "
        "known well enough (rtol, rows)",
    )


def _is_corner(problem: Problem, optimum: Optimum, beside: list[Trial]) -> bool:
    """Of one real number: whether the next points on both sides, 1e-6 of the range away, are higher by more than
    what noise could do."""
    here = problem.merit(problem.at(optimum.places))
    (edge,) = problem.space.real
    place = optimum.places[edge]
    found = []
    for sign in (-1.0, 1.0):
        at = optimum.places.copy()
        at[edge] = min(max(place + sign * _STEPS[0], 0.0), 1.0)
        found.append(at[edge] == place or problem.merit(problem.at(at)) > here + _ROUGH)
    return all(found) and len(beside) > 1


def _slack(optimum: Optimum) -> float:
    """What merits are known to: noise, and what constraints that hold to their tolerance could give."""
    if optimum.slopes is None:
        return _ROUGH
    return (
        _ROUGH * 1e-3 + 10.0 * optimum.slopes.noise + 2.0 * FEASIBLE * float(np.sum(np.abs(optimum.forces)))
    )


def _beside(problem: Problem, places: Array) -> Iterator[Array]:
    for edge, variable in enumerate(problem.space.variables):
        found = []
        if variable.is_real:
            found = [places[edge] + sign * step for step in _STEPS for sign in (-1.0, 1.0)]
        else:
            count = len(variable.levels)
            level = min(int(places[edge] * count), count - 1)
            near = (level - 1, level + 1) if variable.in_order or count > _MOST_LEVELS else range(count)
            found = [(k + 0.5) / count for k in near if k != level and 0 <= k < count]
        for place in found:
            if 0.0 <= place <= 1.0:
                at = places.copy()
                at[edge] = place
                yield at


def _violated(problem: Problem, trial: Trial) -> str:
    found = [
        (abs(v) if c.is_equal else v, c.text)
        for c, v in zip(problem.constraints, problem.violations(trial).tolist(), strict=True)
    ]
    return f"{max(found)[1]!r} is farthest from holding" if found else trial.reason


def _flat_names(problem: Problem, optimum: Optimum) -> str:
    """Names that flat directions are made of."""
    names = [problem.space.names[k] for k in problem.space.real]
    return ", ".join(
        name for name, row in zip(names, optimum.flat, strict=True) if float(np.linalg.norm(row)) > 0.1
    )

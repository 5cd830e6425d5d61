"""The last digits of an optimum, and what holds it there.

In: a problem and a place near an optimum. Out: an `Optimum`: the place, which bounds and constraints are active, with
their multipliers, and how the cost bends. Values tell a place to the root of their error only; slopes tell it to about
the error itself. So Newton's method goes on by slopes, on the conditions of Karush, Kuhn and Tucker (Nocedal & Wright
2006, Numerical Optimization, section 18.1), to where steps are no longer than what runs leave uncertain.
"""

from dataclasses import dataclass

import numpy as np

from lamc.run.request import Array
from lamc.studies.derivatives import STEP, Slopes, noise_of, slopes
from lamc.studies.problem import Problem

SETTLED = 1e-7  # of a range: a last step this short leaves a parameter known to better than 1e-6
_LONGEST = 0.05  # of the box: of a step, as the slopes are of a neighbourhood
_NEAR = 1e-5  # of a constraint's size: what is nearer to its bound may hold the optimum
_AT_SIDE = 1e-9  # of the box
_MOST_STEPS = 8


@dataclass(frozen=True)
class Optimum:
    """Of n real numbers and c constraints, in edges of the box and by sizes.

    last     (n,), the last step that was called for: what is left of the way, by slopes
    sides    (n,), -1 or 1 of a number that a bound holds, at its least or its most; else 0
    holding  numbers of the constraints that hold it; forces: their multipliers, above zero of inequalities
    slopes   there; None where points beside it make no run
    response  (n, n), how far the place gives way to a slope of the cost: the inverse of how it bends along what is free
    is_minimum  whether it bends upwards along all that is free, by more than the noise of runs, or not at all
    flat     (n, k), directions in which nothing is felt
    """

    places: Array
    last: Array
    sides: Array
    holding: tuple[int, ...]
    forces: Array
    slopes: Slopes | None
    response: Array
    is_minimum: bool
    flat: Array

    @property
    def is_settled(self) -> bool:
        return self.slopes is not None and self.is_minimum and bool(np.all(np.abs(self.last) <= SETTLED))


def refined(problem: Problem, places: Array) -> Optimum:
    """The optimum next to a place, as far as steps get shorter. The cost is the first goal's."""
    noise = noise_of(problem, places, problem.space.real)
    best = _looked(problem, places, noise)
    for _ in range(_MOST_STEPS):
        length = float(np.max(np.abs(best.last), initial=0.0))
        if best.slopes is None or not best.is_minimum or length <= 1e-3 * SETTLED:
            break
        at = best.places.copy()
        at[problem.space.real] = np.clip(
            at[problem.space.real] + best.last * min(1.0, _LONGEST / max(length, 1e-300)), 0.0, 1.0
        )
        trial, before = problem.at(at), problem.at(best.places)
        if not trial.is_ok or _penalised(problem, at, best) > _penalised(problem, best.places, best) + _slack(
            best
        ):
            break
        after = _looked(problem, at, noise)
        shorter = float(np.max(np.abs(after.last), initial=0.0)) < 0.5 * length
        if after.slopes is None or not (shorter or problem.merit(trial) < problem.merit(before)):
            break
        best = after
    return best


def _slack(optimum: Optimum) -> float:
    noise = optimum.slopes.noise if optimum.slopes is not None else 0.0
    return 1e-12 + 20.0 * noise


def _penalised(problem: Problem, places: Array, optimum: Optimum) -> float:
    """Cost and violations, with more than the weights by which constraints pull."""
    trial = problem.at(places)
    weight = 2.0 * float(np.max(np.abs(optimum.forces), initial=0.0)) + 1.0
    return problem.cost(trial) / problem.size + weight * problem.violation(trial)


def _looked(problem: Problem, places: Array, noise: float) -> Optimum:
    edges = problem.space.real
    count = len(edges)
    there = slopes(problem, places, edges, noise)
    nothing = np.zeros(count)
    if there is None:
        return Optimum(
            places,
            nothing,
            nothing,
            (),
            np.zeros(0),
            None,
            np.zeros((count, count)),
            False,
            np.zeros((count, 0)),
        )
    at = places[edges]
    values = problem.violations(problem.at(places))
    holding = [k for k, c in enumerate(problem.constraints) if c.is_equal or values[k] >= -_NEAR]
    sides = np.where(at <= _AT_SIDE, -1.0, np.where(at >= 1.0 - _AT_SIDE, 1.0, 0.0))
    for _ in range(len(holding) + count + 1):  # each turn lets go of one
        step, forces, response, flat, is_minimum = _step(there, values, holding, sides)
        loose = [
            (force, k)
            for force, k in zip(forces, holding, strict=True)
            if force < 0.0 and not problem.constraints[k].is_equal
        ]
        pull = there.gradient + there.rows[holding].T @ forces
        off = [
            (float(-pull[i] * sides[i]), i)
            for i in range(count)
            if sides[i] and -pull[i] * sides[i] <= _weak(there)
        ]
        if loose:
            holding.remove(min(loose)[1])
        elif off:
            sides[min(off)[1]] = 0.0
        else:
            break
    step = np.clip(step, -at, 1.0 - at)  # to a side, and no further: there it is held, next time
    return Optimum(places, step, sides, tuple(holding), forces, there, response, is_minimum, flat)


def _weak(there: Slopes) -> float:
    """A slope that noise alone may have: what pulls less than this is not held by a bound, but lies there."""
    return 10.0 * there.noise / STEP + 1e-10


def _step(
    there: Slopes, values: Array, holding: list[int], sides: Array
) -> tuple[Array, Array, Array, Array, bool]:
    """Newton's step (n,), multipliers of what is held, the response (n, n), flat directions (n, k), and whether the
    cost bends upwards along what is free."""
    count = len(sides)
    free = np.flatnonzero(sides == 0.0)
    rows = there.rows[holding][:, free]
    _, singular, vt = (
        np.linalg.svd(rows, full_matrices=True) if rows.size else (None, np.zeros(0), np.eye(len(free)))
    )
    rank = int(np.sum(singular > 1e-8 * max(float(singular.max(initial=0.0)), 1.0)))
    along = vt[rank:].T  # what constraints leave free
    closing: Array = np.zeros(len(free))
    if rows.size:
        closing = -np.linalg.pinv(rows, rcond=1e-8) @ values[holding]
    gradient, hessian = there.gradient[free], there.hessian[np.ix_(free, free)]
    forces: Array = np.zeros(len(holding))
    for _ in range(2):  # multipliers bend the Hessian, and it them by what the step is long
        bent = hessian + sum(
            (f * there.bends[k][np.ix_(free, free)] for f, k in zip(forces, holding, strict=True)),
            start=np.zeros_like(hessian),
        )
        inner, dull, is_minimum = _inverse(along.T @ bent @ along, there.noise)
        step = closing - along @ (inner @ (along.T @ (gradient + bent @ closing)))
        if rows.size:
            forces = -np.asarray(np.linalg.lstsq(rows.T, gradient + bent @ step, rcond=1e-8)[0])
    response, flat = np.zeros((count, count)), np.zeros((count, dull.shape[1]))
    whole = np.zeros(count)
    whole[free] = step
    response[np.ix_(free, free)] = along @ inner @ along.T
    flat[free] = along @ dull
    return whole, forces, response, flat, is_minimum


def _inverse(bent: Array, noise: float) -> tuple[Array, Array, bool]:
    """The inverse of a Hessian where it is felt, what is not, and whether it is nowhere below zero."""
    if not bent.size:
        return bent, np.zeros((len(bent), 0)), True
    found, vectors = np.linalg.eigh(0.5 * (bent + bent.T))
    weak = max(1e-9 * float(np.max(np.abs(found))), 10.0 * noise / STEP**2)
    felt = np.abs(found) > weak
    inverse = np.asarray((vectors[:, felt] / found[felt]) @ vectors[:, felt].T)
    return inverse, vectors[:, ~felt], bool(np.all(found[felt] > 0.0))

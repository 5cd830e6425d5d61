"""Methods that go downhill from a start, along the edges of real numbers: scipy's.

In: a problem, a place of the unit box. Out: the place at which they end. What they tell of convergence is not believed;
`refinement` and `verdict` look for themselves. Points without a run cost more than all that were seen, so that they
step back.
"""

import warnings
from collections.abc import Callable
from contextlib import suppress

import numpy as np
from scipy import optimize

from lamc.run.request import Array
from lamc.studies.derivatives import MANY, gradients, jacobian
from lamc.studies.problem import Problem, Trial
from lamc.studies.space import Edges

_MOST = 100  # steps of one call
_MOST_OF_MANY = 1000  # the same, of many numbers, whose slopes cost a run and its way back
_BETTER = 1e-12  # of the size of costs: what counts as gain
_IN_VAIN = 40  # runs without gain after which a method ends, for each parameter and one more


class _IdleError(Exception):
    """A method gains nothing any more."""


def least_squares(problem: Problem, start: Array) -> Array:
    """Levenberg and Marquardt's way within bounds: a trust region in the interior (Branch, Coleman & Li 1999), then
    dogleg steps, which reach bounds (Voglis & Lagaris 2004)."""
    edges, first = problem.space.real, problem.at(start).residual
    if first is None or problem.constraints:
        return slsqp(problem, start)

    def residual(x: Array) -> Array:
        found = problem.at(_placed(start, edges, x)).residual
        if found is None or found.shape != first.shape:
            worst = max(float(np.max(np.abs(t.residual))) for t in problem.trials if t.residual is not None)
            return np.full(first.shape, 10.0 * worst + 1.0)
        return found

    def slope(x: Array) -> Array:
        return jacobian(problem, _placed(start, edges, x), edges)

    at = start
    for method in ("trf", "dogbox"):
        begun = problem.at(at)
        if begun.residual is None or begun.residual.shape != first.shape:
            break
        found = optimize.least_squares(
            residual,
            at[edges],
            slope,
            bounds=(0.0, 1.0),
            method=method,
            ftol=_BETTER,
            xtol=1e-9,
            gtol=None,
            max_nfev=_MOST,
        )
        ended = _placed(start, edges, found.x)
        if problem.merit(problem.at(ended)) <= problem.merit(begun):
            at = ended
    return at


def slsqp(problem: Problem, start: Array) -> Array:
    """Sequential quadratic programming (Kraft 1988)."""
    most = _MOST if len(problem.space.real) <= MANY else _MOST_OF_MANY
    return _by_gradients(problem, start, "SLSQP", {"ftol": _BETTER, "maxiter": most})


def trust_constr(problem: Problem, start: Array) -> Array:
    """A trust region with constraints by an interior point (Byrd, Hribar & Nocedal 1999)."""
    return _by_gradients(
        problem,
        start,
        "trust-constr",
        {"gtol": 1e-9, "xtol": 1e-10, "maxiter": _MOST, "initial_tr_radius": 0.1},
    )


def nelder_mead(problem: Problem, start: Array) -> Array:
    """A simplex that needs no derivatives; constraints by the order of merits."""
    edges = problem.space.real
    found = optimize.minimize(
        lambda x: problem.merit(problem.at(_placed(start, edges, x))),
        start[edges],
        method="Nelder-Mead",
        bounds=[(0.0, 1.0)] * len(edges),
        options={"xatol": 1e-9, "fatol": 1e-14, "maxfev": _MOST * (len(edges) + 1), "initial_simplex": None},
    )
    return _better(problem, start, _placed(start, edges, found.x))


def _by_gradients(problem: Problem, start: Array, method: str, options: dict[str, float]) -> Array:
    """With values and slopes of the cost and the constraints. Of what it went through, the best is what counts."""
    edges = problem.space.real
    begun = gained = len(problem.trials)
    least = problem.merit(problem.at(start))

    def cost(x: Array) -> float:
        nonlocal gained, least
        trial = problem.at(_placed(start, edges, x))
        if problem.merit(trial) < least - _BETTER:
            gained, least = len(problem.trials), problem.merit(trial)
        if len(problem.trials) - gained > _IN_VAIN * (len(edges) + 1):
            raise _IdleError
        return problem.cost(trial) / problem.size if trial.is_ok else _worst(problem)

    def slope(x: Array) -> Array:
        return gradients(problem, _placed(start, edges, x), edges)[0]

    ended = start
    with suppress(_IdleError), warnings.catch_warnings():
        # Of goals and constraints that are straight, whose second derivatives trust-constr finds nil.
        warnings.filterwarnings("ignore", "delta_grad == 0.0", UserWarning)
        found = optimize.minimize(
            cost,
            start[edges],
            jac=slope,
            method=method,
            bounds=[(0.0, 1.0)] * len(edges),
            constraints=_constraints(problem, start, method),
            options=options,
        )
        ended = _better(problem, start, _placed(start, edges, found.x))
    visited = [trial for trial in problem.trials[begun:] if _shares(problem, trial, start)]
    best = min(visited, key=problem.merit, default=None)
    if best is not None and problem.merit(best) < problem.merit(problem.at(ended)) - 1e-12:
        return problem.space.places(best.point)
    return ended


def _constraints(problem: Problem, start: Array, method: str) -> list[object]:
    """As scipy's two methods take them."""
    edges = problem.space.real

    def values(x: Array) -> Array:
        trial = problem.at(_placed(start, edges, x))
        return problem.violations(trial) if trial.is_ok else np.ones(len(problem.constraints))

    def rows(x: Array) -> Array:
        return gradients(problem, _placed(start, edges, x), edges)[1]

    made: list[object] = []
    for kind in (False, True):
        which = [k for k, each in enumerate(problem.constraints) if each.is_equal == kind]
        if not which:
            continue
        if method == "SLSQP":
            word = "eq" if kind else "ineq"
            made.append({"type": word, "fun": _part(values, which, -1.0), "jac": _part(rows, which, -1.0)})
        else:
            least = 0.0 if kind else -np.inf
            made.append(
                optimize.NonlinearConstraint(
                    _part(values, which, 1.0), least, 0.0, jac=_part(rows, which, 1.0)
                )
            )
    return made


def _part(function: Callable[[Array], Array], which: list[int], sign: float) -> Callable[[Array], Array]:
    return lambda x: sign * function(x)[which]


def _placed(start: Array, edges: Edges, x: Array) -> Array:
    """The start with other places of real numbers."""
    at = start.copy()
    at[edges] = np.clip(x, 0.0, 1.0)
    return at


def _better(problem: Problem, first: Array, second: Array) -> Array:
    return second if problem.merit(problem.at(second)) <= problem.merit(problem.at(first)) else first


def _shares(problem: Problem, trial: Trial, start: Array) -> bool:
    """Whether a trial has the levels of a start."""
    here = problem.space.point(start)
    return all(
        v.is_real or a == b for v, a, b in zip(problem.space.variables, trial.point, here, strict=True)
    )


def _worst(problem: Problem) -> float:
    """Ten times the most of all costs, by their size."""
    return (
        10.0 * max((abs(problem.cost(t)) for t in problem.trials if t.is_ok), default=1.0) / problem.size
        + 1.0
    )

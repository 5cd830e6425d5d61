"""First and second derivatives of trials over the unit box, by finite differences.

In: a problem, a place, the edges to go along. Out: gradients and Hessians of the cost, by its size, of constraints, by
theirs, and how far the noise of runs reaches into them.

The step suits the error of a run. Differences of values that are known to ε are known to ε/h, and those of 2 points on
either side miss h⁴/30 of the fifth derivative: with steps to 1e-11, ε is some 1e-11 of a value's size, and
h = 1e-3 of a range leaves 1e-8 of the first kind and less than 1e-9 of the second. Points stay within the box: near its
sides they are shifted inwards, and a point that makes no run is left out.
"""

from dataclasses import dataclass

import numpy as np

from lamc.run.request import Array
from lamc.studies.problem import Problem, Trial
from lamc.studies.space import Edges

STEP = 1e-3  # of a range, of 4 points about the middle: see above
COARSE = 1e-4  # of a range, of 2 points: an error of 1e-7 is enough to walk by
_CLOSE = (
    1e-5  # of a range, between points by which noise is told: what is smooth has no fourth differences there
)
MANY = 50  # edges, beyond which slopes come from runs backwards: they cost a few runs, however many edges there are
_LARGER = 70.0**0.5  # are fourth differences of noise than it: the root of 1 + 16 + 36 + 16 + 1


@dataclass(frozen=True)
class Slopes:
    """At one place, along n edges of the box, of c constraints.

    gradient   (n,), hessian (n, n): of the cost, by its size
    rows       (c, n), bends (c, n, n): of constraints, by theirs
    noise      of the cost, by its size: what runs leave uncertain
    """

    gradient: Array
    hessian: Array
    rows: Array
    bends: Array
    noise: float


def gradients(problem: Problem, places: Array, edges: Edges, unknown: float = 0.0) -> tuple[Array, Array]:
    """Gradient (n,) of the cost and Jacobian (c, n) of the constraints along `edges`, by two points each; of many
    edges by the run's own steps backwards, where it has a gradient. unknown: entries that no points that make a run
    are there for."""
    exact = _backwards(problem, places, edges) if len(edges) > MANY else None
    if exact is not None:
        return exact
    found = np.full((len(edges), 1 + len(problem.constraints)), unknown)
    problem.ahead(_shifted(places, e, h) for e in edges for h in _two_sided(places[e], COARSE))
    for row, edge in enumerate(edges):
        offsets, values = _along(problem, places, edge, _two_sided(places[edge], COARSE))
        if len(offsets) >= 2:
            found[row] = _weights(offsets, 1) @ values
    # Each by itself in memory: SLSQP of scipy 1.17 reads a column of a table as if its numbers were side by side.
    return found[:, 0].copy(), found[:, 1:].T.copy()


def _backwards(problem: Problem, places: Array, edges: Edges) -> tuple[Array, Array] | None:
    """The same from one run and its way back."""
    trial = problem.at(places)
    slopes_at = problem.slopes_at(trial.point) if trial.is_ok else None
    if slopes_at is None:
        return None
    spans = [problem.space.variables[e].slope(float(places[e])) for e in edges]
    found = slopes_at[:, edges] * np.array(spans)
    of_cost = found[0] * (2.0 * trial.goals[0] if problem.is_rooted(trial) else 1.0)
    return of_cost / problem.size, np.ascontiguousarray(found[1:] / problem.sizes[:, None])


def jacobian(problem: Problem, places: Array, edges: Edges) -> Array:
    """Jacobian (m, n) of the residual along `edges`, by two points each; columns without points are zero."""
    middle = problem.at(places).residual
    assert middle is not None
    found = np.zeros((len(middle), len(edges)))
    problem.ahead(_shifted(places, e, h) for e in edges for h in _two_sided(places[e], COARSE))
    for column, edge in enumerate(edges):
        trials = [(h, _moved(problem, places, edge, h)) for h in _two_sided(places[edge], COARSE)]
        good = [
            (h, t.residual) for h, t in trials if t.residual is not None and t.residual.shape == middle.shape
        ]
        if len(good) >= 2:
            weights = _weights(np.array([h for h, _ in good]), 1)
            found[:, column] = sum(w * residual for w, (_, residual) in zip(weights, good, strict=True))
    return found


def noise_of(problem: Problem, places: Array, edges: Edges) -> float:
    """What runs leave uncertain of the cost, by its size: of fourth differences of seven points in a row, close to each
    other (Moré & Wild 2011, SIAM J. Sci. Comput. 33, 1292-1314). Points without a run are left out."""
    if not len(edges):
        return 0.0
    inwards = np.where(places[edges] < 0.5, 1.0, -1.0)
    costs = []
    row = [places.copy() for _ in range(7)]
    for k, at in enumerate(row):
        at[edges] += k * _CLOSE * inwards
    problem.ahead(row)
    for at in row:
        trial = problem.at(at)
        if trial.is_ok:
            costs.append(problem.cost(trial) / problem.size)
    fourth = np.diff(costs, 4) if len(costs) > 4 else np.zeros(1)
    return float(np.sqrt(np.mean(np.square(fourth)))) / _LARGER


def slopes(problem: Problem, places: Array, edges: Edges, noise: float) -> Slopes | None:
    """All of first and second order, by four points along each edge and two for each pair; None where points beside
    make no run."""
    n, c = len(edges), 1 + len(problem.constraints)
    first, second = np.zeros((n, c)), np.zeros((n, n, c))
    middle = _values(problem, problem.at(places))
    problem.ahead(_shifted(places, edge, h) for edge in edges for h in _five(places[edge]))
    for i, edge in enumerate(edges):
        offsets, values = _along(problem, places, edge, _five(places[edge]))
        if len(offsets) < 5:
            return None
        first[i], second[i, i] = _weights(offsets, 1) @ values, _weights(offsets, 2) @ values
    for i in range(n):
        for j in range(i):
            mixed = _mixed(problem, places, edges[[i, j]], middle)
            if mixed is None:
                return None
            second[i, j] = second[j, i] = mixed
    return Slopes(first[:, 0], second[:, :, 0], first[:, 1:].T, second[:, :, 1:].transpose(2, 0, 1), noise)


def _mixed(problem: Problem, places: Array, pair: Edges, middle: Array) -> Array | None:
    """Mixed second derivatives (1 + c,) along two edges; within the box from both sides, at its sides inwards. None
    where points make no run."""
    at = places[pair]
    inner = bool(np.all((at >= STEP) & (at <= 1.0 - STEP)))
    steps = [np.array([STEP, STEP]), np.array([-STEP, -STEP])] if inner else [np.where(at < 0.5, STEP, -STEP)]
    found = np.zeros_like(middle)
    for step in steps:
        for mask, sign in (((1, 1), 1.0), ((1, 0), -1.0), ((0, 1), -1.0)):
            moved = places.copy()
            moved[pair] += step * mask
            trial = problem.at(moved)
            if not trial.is_ok:
                return None
            found += sign * _values(problem, trial)
        found += middle
    area = sum(float(step[0] * step[1]) for step in steps)
    return np.asarray(found / area)


def _values(problem: Problem, trial: Trial) -> Array:
    return np.array([problem.cost(trial) / problem.size, *problem.violations(trial)])


def _shifted(places: Array, edge: int, step: float) -> Array:
    at = places.copy()
    at[edge] = min(max(at[edge] + float(step), 0.0), 1.0)
    return at


def _moved(problem: Problem, places: Array, edge: int, step: float) -> Trial:
    return problem.at(_shifted(places, edge, step))


def _along(problem: Problem, places: Array, edge: int, offsets: Array) -> tuple[Array, Array]:
    """Offsets (k,) whose points make a run, and their values (k, 1 + c)."""
    trials = [_moved(problem, places, edge, float(h)) for h in offsets]
    good = [k for k, trial in enumerate(trials) if trial.is_ok]
    values = np.array([_values(problem, trials[k]) for k in good]).reshape(
        len(good), 1 + len(problem.constraints)
    )
    return offsets[good], values


def _two_sided(place: float, step: float) -> Array:
    """One point on either side; at a side of the box, three from there inwards."""
    if step <= place <= 1.0 - step:
        return np.array([-step, 0.0, step])
    return np.array([0.0, step, 2.0 * step]) * (1.0 if place < 0.5 else -1.0)


def _five(place: float) -> Array:
    """Five points in a row about a place, shifted to lie within the box."""
    below, above = int(min(place / STEP, 2.0)), int(min((1.0 - place) / STEP, 2.0))
    shift = (2 - below) - (2 - above)
    return STEP * (np.arange(-2.0, 3.0) + shift)


def _weights(offsets: Array, order: int) -> Array:
    """Weights (k,) of values at offsets whose sum is their polynomial's derivative of `order` at zero."""
    scale = float(np.max(np.abs(offsets)))
    powers = np.vander(offsets / scale, increasing=True).T
    wanted = np.zeros(len(offsets))
    wanted[order] = float(order) / scale**order  # of order 1 and 2: 1! and 2!
    return np.asarray(np.linalg.solve(powers, wanted), dtype=np.float64)

"""Intervals of a fit some of whose numbers stand at bounds.

In: residuals and their Jacobian at the optimum, which numbers are held. Out: how far intervals of the others reach.
Never: moves the optimum.

A number that stands at its bound may be within: noise alone takes it to its bound half of the time where the true one
is near. What the data say of another number is its profile then: the least sum of squares with all the others, held
ones within their range (D. M. Bates, D. G. Watts, Nonlinear regression analysis and its applications, 1988, ch. 6).
"""

import numpy as np
import numpy.typing as npt

from lamc.fitting.trust import triangle_of
from lamc.fitting.unknowns import Unknowns
from lamc.run.request import Array

_FARTHEST = 1e4  # times the reach with held numbers at their bounds: beyond, the data say nothing
_HALVINGS = 30


def within_bounds(
    unknowns: Unknowns,
    inner: Array,
    sizes: Array,
    rows: Array,
    reach: Array,
    inverse: Array,
    held: npt.NDArray[np.bool_],
) -> Array:
    """How far intervals go downwards and upwards (p, 2), in parts of `sizes`.

    sizes    (p,): changes of the solver's numbers that count as one
    rows     (N, p + 1): Jacobian by these, and residuals
    reach    (p,): how far they would go with held numbers at their bounds; inf where nothing is known
    inverse  (p,): diagonal of the inverse of the Jacobian's products, without held numbers

    Held logarithms are taken as numbers themselves, in parts of their value: along its logarithm a number near nought
    changes nothing.
    """
    triangle = triangle_of(rows)
    anywhere = (-np.inf, np.inf)
    ranges = np.array(
        [_range(unknowns, k, inner, sizes[k]) if h else anywhere for k, h in enumerate(held.tolist())]
    )
    found = np.column_stack([reach, reach])
    for k in np.flatnonzero(~held & np.isfinite(reach)):
        allowed = reach[k] ** 2 / inverse[k]
        found[k] = [_end(triangle, ranges, int(k), sign * float(reach[k]), allowed) for sign in (-1.0, 1.0)]
    return found


def _range(unknowns: Unknowns, k: int, inner: Array, size: float) -> tuple[float, float]:
    """How far a number may change, in parts of its value where its logarithm is sought."""
    each, (low, high) = unknowns.all[k], (bound[k] for bound in unknowns.bounds)
    if not each.log:
        return (min(low - inner[k], 0.0) / size, max(high - inner[k], 0.0) / size)
    value = each.value(inner[k])
    return min(each.value(low) / value - 1.0, 0.0), max(each.value(high) / value - 1.0, 0.0)


def _end(triangle: Array, ranges: Array, k: int, reach: float, allowed: float) -> float:
    """Where the profile of one number has risen by what is allowed, `reach` or beyond; inf where it does not."""
    inside, outside = abs(reach), abs(reach)
    while _rise(triangle, ranges, k, np.copysign(outside, reach)) < allowed:
        inside, outside = outside, 2.0 * outside
        if outside > _FARTHEST * abs(reach):
            return float("inf")
    for _ in range(_HALVINGS if outside > inside else 0):
        middle = 0.5 * (inside + outside)
        if _rise(triangle, ranges, k, np.copysign(middle, reach)) < allowed:
            inside = middle
        else:
            outside = middle
    return outside


def _rise(triangle: Array, ranges: Array, k: int, change: float) -> float:
    """By how much the least sum of squares rises where number k changes so far, and all others as they may."""
    from scipy.optimize import lsq_linear  # `import lamc` does without it

    others = [j for j in range(len(ranges)) if j != k]
    wanted = -(triangle[:, -1] + change * triangle[:, k])
    least = float(triangle[:, -1] @ triangle[:, -1])
    if not others:
        return float(wanted @ wanted) - least
    solved = lsq_linear(triangle[:, others], wanted, tuple(ranges[others].T), method="bvls")
    return 2.0 * float(solved.cost) - least

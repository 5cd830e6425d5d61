"""Leading joints to given angles along one branch, by steps in which the closure hardly changes.

In: a `LoopGeometry`, a closed position, angles of some joints. Out: the closed position with these angles that the
branch leads to. Never: leaves a singular position, where branches part; who needs that takes small steps.

Each step goes along the tangent, and Newton's method back to closure. That may end on another branch, and most easily
where two come near to each other: straight on is the other one, and the own one turns off. Between the two the closure
matrix loses a rank. So a step is taken only if the matrix changes by a part of itself, measured by its own
pseudo-inverse: none on the way is singular, as far as the matrix at both ends tells (P. Deuflhard, "Newton methods for
nonlinear problems", 2011, section 2.1, has such bounds for all between). Longer ones are halved.
"""

import numpy as np

from lamc.loops.closing import CLOSED, LONGEST_STEP, SOLVE, STILL, Mask, settle
from lamc.loops.geometry import LoopGeometry
from lamc.loops.linear import Linear
from lamc.records.mechanism import Array

CHANGE = 0.5  # of the closure matrix by itself within a step; from 1 on one between may be singular
CONTRACTION = 0.5  # of the second correction, by the first: Newton's method converges
SHORTEST = 1e-6  # rad, of what is given: the angle at a dead point is no better known by round-off
MOST_STEPS = 4000  # tried; a turn takes some thirty, and a dead point a dozen more


def led_along(geometry: LoopGeometry, start: Array, wanted: Array, free: Mask) -> Array | None:
    """The closed position (n,) on the branch of a regular position `start` (n,) in which what is not `free` (n,) is as
    wanted (n,); None where that is singular, or not led to: the branch turns back before it, or ends."""
    held = np.logical_not(free)
    way = np.where(held, wanted - start, 0.0)
    longest = float(np.abs(way).max(initial=0.0))
    if longest == 0.0:
        return start
    linear = geometry.linear(start)
    rank = linear.rank(SOLVE)
    if linear.columns(free).rank(SOLVE) < rank:
        return None  # a dead point of what is given, or more of it than freedoms
    place, done, step = start, 0.0, LONGEST_STEP / longest
    for _ in range(MOST_STEPS):
        ahead = min(1.0, done + step)
        following = _stepped(geometry, place, np.where(held, start + ahead * way, place), free)
        if following is None:
            step *= 0.5
            if step * longest < SHORTEST:
                return None
            continue
        if geometry.linear(following).rank(SOLVE) != rank:
            return None
        if ahead == 1.0:
            return np.where(held, wanted, following)
        place, done, step = following, ahead, min(2.0 * step, LONGEST_STEP / longest)
    return None


def _stepped(geometry: LoopGeometry, place: Array, ahead: Array, free: Mask) -> Array | None:
    """The closed position with the angles of `ahead` (n,) that are not free, on the branch of `place`; None where the
    step is too long to tell."""
    linear, guess = geometry.linear(place), ahead.copy()
    own = linear.columns(free)
    guess[free] += own.least_change(-linear.matrix @ (ahead - place), SOLVE)
    if np.abs(guess - place).max() > LONGEST_STEP:
        return None
    if not _contracts(geometry, guess, free):
        return None
    found, error = settle(geometry, guess, free)
    if error > CLOSED or np.abs(found - place).max() > LONGEST_STEP:
        return None
    return found if _change(own, geometry.linear(found).columns(free)) <= CHANGE else None


def _contracts(geometry: LoopGeometry, guess: Array, free: Mask) -> bool:
    """Whether Newton's method closes in from a guess (n,), which moves."""
    sizes = []
    for _ in range(2):
        residual, linear = geometry.closure(guess)
        change = linear.columns(free).least_change(-residual, SOLVE)
        guess[free] += change
        sizes.append(float(np.abs(change).max(initial=0.0)))
    return sizes[1] <= max(CONTRACTION * sizes[0], STILL)


def _change(before: Linear, after: Linear) -> float:
    """How much a matrix changes, by itself: the largest size of the eigenvalues of J⁺ J' - 1, of J before and J' after.

    Those are the same in all units and frames. On the straight line from J to J' one is singular where one of them is
    real and -1 or below.
    """
    left, values, right = before.dense
    rank = before.rank(SOLVE)
    seen = left[:, :rank].T @ after.matrix @ right[:rank].T / values[:rank, None]
    return float(np.abs(np.linalg.eigvals(seen) - 1.0).max(initial=0.0))

"""Leading joints to given angles along one branch, by steps as long as it is straight enough.

In: a `LoopGeometry`, a closed position, angles of some joints. Out: the closed position with these angles that the
branch leads to. Never: leaves a singular position, where branches part; who needs that takes small steps.

Each step goes along the tangent, and Newton's method back to closure. Where that contracts fast, it comes to the branch
that the tangent belongs to, and to no other: a longer tangent step contracts less, so that all shorter ones would have
come there too (P. Deuflhard, "Newton methods for nonlinear problems", 2011, chapter 5).
"""

import numpy as np

from lamc.loops.closing import CLOSED, LONGEST_STEP, SOLVE, STILL, Mask, settle
from lamc.loops.geometry import LoopGeometry
from lamc.records.mechanism import Array

CONTRACTION = 0.25  # of the second correction, by the first: the half of what has a unique solution nearby


def led_along(
    geometry: LoopGeometry, start: Array, wanted: Array, free: Mask, shortest: float
) -> Array | None:
    """The closed position (n,) on the branch of a regular position `start` (n,) in which what is not `free` (n,) is as
    wanted (n,); None where that is singular, or steps of what is given would be shorter than `shortest`, rad."""
    held = np.logical_not(free)
    way = np.where(held, wanted - start, 0.0)
    longest = float(np.abs(way).max(initial=0.0))
    place, done, step = start, 0.0, 1.0
    rank = geometry.linear(start).rank(SOLVE)
    while done < 1.0:
        following = _stepped(geometry, place, np.where(held, start + (done + step) * way, place), free)
        if following is None:
            step *= 0.5
            if step * longest < shortest:
                return None
        elif geometry.linear(following).rank(SOLVE) != rank:
            return None
        else:
            place, done = following, done + step
    return np.where(held, wanted, place)


def _stepped(geometry: LoopGeometry, place: Array, ahead: Array, free: Mask) -> Array | None:
    """The closed position with the angles of `ahead` (n,) that are not free, on the branch of `place`; None where the
    step is too long to tell."""
    linear, guess = geometry.linear(place), ahead.copy()
    guess[free] += linear.columns(free).least_change(-linear.matrix @ (ahead - place), SOLVE)
    corrections = []
    for _ in range(2):
        residual, linear = geometry.closure(guess)
        change = linear.columns(free).least_change(-residual, SOLVE)
        guess[free] += change
        corrections.append(float(np.abs(change).max(initial=0.0)))
    first, second = corrections
    if first > LONGEST_STEP or second > max(CONTRACTION * first, STILL):
        return None
    found, error = settle(geometry, guess, free)
    return found if error <= CLOSED else None

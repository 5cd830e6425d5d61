"""Bringing the loops of a mechanism to closure by its angles.

In: a `LoopGeometry`, angles, and which of them may change. Out: angles nearby at which the loops close, or come as
near as they can. Never: looks at rates, masses or a scene.
"""

import numpy as np
import numpy.typing as npt

from lamc.loops.geometry import LoopGeometry
from lamc.loops.linear import DAMPING, DENSE, WEAK, Linear, least_changes
from lamc.records.mechanism import Array

Mask = npt.NDArray[np.bool_]
Places = npt.NDArray[np.int64]

CLOSED = 1e-12  # rad, and of the size: a few hundred units of round-off
SOLVE = 1e-9  # relative to the largest singular value: a smaller one is none of a place on the way to closure
SMALL = WEAK  # likewise: below it a singular value may be a misfit, some hundredths of a radian or of the size at most
LONGEST_STEP = 0.5  # rad; lines of rotation are straight no farther
MAX_ITERATIONS = 60
FRUITLESS = 8  # steps of many loops that fit badly and do not come closer by half: weak directions come and go by turns
FEW_ITERATIONS = 8  # of damped ones
# Along directions so weak that they are damped, steps of many loops leave most of a residual that is so small. So many
# in turn are the last where all that are left would not close it, if each did what three of them do: near a double root
# each does a little more than the one before.
CREEPING, CREEPS = 1e-7, 3
ASTRAY = 3  # steps in turn that end beyond where the place may be: it does not come back
STILL = 1e-10  # rad: a step that leaves open what it should close is the last, if it is as short
NEAREST, NEARER, ARRIVED = (
    40,
    0.2,
    1e-9,
)  # rounds of the search for the nearest place; rad, its longest step and last one


def settle(
    geometry: LoopGeometry,
    angles: Array,
    free: Mask | None = None,
    cutoff: float = SOLVE,
    nullity: int | None = None,
    enough: float = CLOSED,
    still: float = STILL,
    reach: float = np.inf,
) -> tuple[Array, float]:
    """Gauss-Newton from `angles` (n,) on those that are `free` (n,) bool, by least squares and least change.

    Directions with singular values below `cutoff` times the largest are left alone: loops that fit badly are then
    brought as near to closure as their motion allows, instead of to the one place where they close. Or
    else so many of the weakest, `nullity`, of what is free.
    enough: of the largest residual; from there on a step that does not halve it is the last. still: rad, likewise of
    steps that are as short. reach: rad; who does not want what is farther from `angles` does not wait for it.
    Returns the place reached, and its largest residual, rad or parts of lengths.
    """
    begun, angles = angles, angles.copy()
    columns = np.arange(len(angles)) if free is None else np.flatnonzero(free)
    residual, linear = geometry.closure(angles)
    error = float(np.abs(residual).max(initial=0.0))
    part: Linear | None = None
    # Of very large loops that fit badly, steps are damped, and weak directions creep.
    damped = cutoff > DAMPING and nullity is None and linear.is_very_large
    fits_badly = (cutoff > DAMPING or nullity is not None) and not linear.is_small
    least, shortest, fruitless, creeps, astray = error, np.inf, 0, 0, 0
    most = (FEW_ITERATIONS if damped else MAX_ITERATIONS) if len(columns) else 0
    for left in range(most - 1, -1, -1):
        if error <= 1e-2 * CLOSED or (fits_badly and fruitless >= FRUITLESS):
            break
        part = linear.part(columns).after(part)
        if damped:
            step = part.damped_change(-residual, cutoff)
        else:
            step = part.least_change(-residual, cutoff if nullity is None else part.amid(nullity))
        longest = float(np.abs(step).max())
        if longest < 1e-15:
            break
        angles[columns] += step * min(1.0, LONGEST_STEP / longest)
        residual, linear = geometry.closure(angles)
        before, error = error, float(np.abs(residual).max(initial=0.0))
        if error > 0.5 * before and (error <= enough or longest < still):
            break
        is_vain = 0.0 < error < CREEPING and error * min(error / before, 1.0) ** (3 * left) > enough
        creeps = creeps + 1 if is_vain and not linear.is_small else 0
        astray = astray + 1 if np.abs(angles - begun).max() > reach else 0
        if creeps == CREEPS or astray == ASTRAY:
            break
        fruitless = 0 if error < 0.5 * least or longest < 0.5 * shortest else fruitless + 1
        if not fruitless:
            least, shortest = min(least, error), min(shortest, longest)
    return angles, error


def settle_all(geometry: LoopGeometry, guesses: Array, free: Mask, cutoff: float) -> tuple[Array, Array]:
    """`settle` from rows of guesses (s, n) at once: the places (s, n), and their errors (s,)."""
    places, rows = guesses.copy(), np.arange(len(guesses))
    at, columns = places, np.flatnonzero(free)  # places of the rows that are still on the way
    errors, longest = np.full((2, len(guesses)), np.inf)
    for left in range(MAX_ITERATIONS if len(rows) else -1, -1, -1):
        steps, error = _steps(geometry, at, columns, None, cutoff)
        before, last = errors[rows], longest[rows]
        now = np.abs(steps).max(axis=1, initial=0.0)
        errors[rows], longest[rows] = error, now
        over = (error > 0.5 * before) & ((error <= CLOSED) | (last < STILL))
        on = ~over & (error > 1e-2 * CLOSED) & (now >= 1e-15)
        if np.count_nonzero(on) < len(on):
            rows, steps, now, at = rows[on], steps[on], now[on], at[on]
        if not len(rows) or not left:
            break
        at[:, columns] += steps * np.minimum(1.0, LONGEST_STEP / now)[:, None]
        places[rows] = at
    return places, errors


def approach(geometry: LoopGeometry, angles: Array, wanted: Array, free: Mask, cutoff: float) -> Array:
    """Places (s, n), nearly closed, where the squares of the distance from `wanted` (n,) are least around closed rows
    of angles (s, n), by what is free."""
    places, rows, columns = angles.copy(), np.arange(len(angles)), np.flatnonzero(free)
    for _ in range(NEAREST):
        back = (wanted - places[rows])[:, columns]
        steps, _ = _steps(geometry, places[rows], columns, back, cutoff)
        longest = np.abs(steps).max(axis=1, initial=0.0)
        places[np.ix_(rows, columns)] += (
            steps * np.minimum(1.0, NEARER / np.maximum(longest, NEARER))[:, None]
        )
        rows = rows[longest >= ARRIVED]
        if not len(rows):
            break
    return places


def _steps(
    geometry: LoopGeometry, places: Array, free: Places, back: Array | None, cutoff: float
) -> tuple[Array, Array]:
    """Steps (s, f) towards closure by what is free, indices (f,), of least difference from steps `back` (s, f), which
    are nil where there are none; and how far the places (s, n) are from it, (s,)."""
    if len(geometry.names) > DENSE:
        return _large_steps(geometry, places, free, back, cutoff)
    residual, matrices = geometry.closures(places)
    matrices = matrices.take(free, axis=2)
    error = np.abs(residual).max(axis=1, initial=0.0)
    if back is None:
        return -least_changes(matrices, residual, cutoff), error
    goal = residual + (matrices @ back[:, :, None])[:, :, 0]
    return back - least_changes(matrices, goal, cutoff), error


def _large_steps(
    geometry: LoopGeometry, places: Array, free: Places, back: Array | None, cutoff: float
) -> tuple[Array, Array]:
    """The same of many joints, place by place."""
    back = np.zeros((len(places), len(free))) if back is None else back
    closures = [geometry.closure(place) for place in places]
    columns = [linear.part(free) for _, linear in closures]
    goals = [r + c.matrix @ b for (r, _), c, b in zip(closures, columns, back, strict=True)]
    changes = np.array([c.least_change(g, cutoff) for c, g in zip(columns, goals, strict=True)])
    return back - changes, np.array([np.abs(residual).max(initial=0.0) for residual, _ in closures])

"""Bringing the loops of a mechanism to closure by its angles.

In: a `LoopGeometry`, angles, and which of them may change. Out: angles nearby at which the loops close, or come as
near as they can. Never: looks at rates, masses or a scene.
"""

import numpy as np
import numpy.typing as npt

from lamc.loops.geometry import LoopGeometry
from lamc.records.mechanism import Array

Mask = npt.NDArray[np.bool_]

CLOSED = 1e-12  # rad, and of the size: a few hundred units of round-off
SOLVE = 1e-9  # relative to the largest singular value: a smaller one is none of a place on the way to closure
SMALL = 2e-2  # likewise: below it a singular value may be a misfit, some hundredths of a radian or of the size at most
LONGEST_STEP = 0.5  # rad; lines of rotation are straight no farther
MAX_ITERATIONS = 60
STILL = 1e-10  # rad: a step that leaves open what it should close is the last, if it is as short


def settle(
    geometry: LoopGeometry,
    angles: Array,
    free: Mask | None = None,
    cutoff: float = SOLVE,
    nullity: int | None = None,
) -> tuple[Array, float]:
    """Gauss-Newton from `angles` (n,) on those that are `free` (n,) bool, by least squares and least change.

    Directions with singular values below `cutoff` times the largest are left alone: loops that fit badly are then
    brought as near to closure as their motion allows, instead of to the one place where they close. Or
    else so many of the weakest, `nullity`, of what is free.
    Returns the place reached, and its largest residual, rad or parts of lengths.
    """
    angles = angles.copy()
    columns = np.ones(len(angles), dtype=bool) if free is None else free
    residual, linear = geometry.closure(angles)
    error = float(np.abs(residual).max(initial=0.0))
    for _ in range(MAX_ITERATIONS):
        if error <= 1e-2 * CLOSED or not columns.any():
            break
        part = linear.columns(columns)
        step = part.least_change(-residual, cutoff if nullity is None else part.amid(nullity))
        longest = float(np.abs(step).max())
        if longest < 1e-15:
            break
        angles[columns] += step * min(1.0, LONGEST_STEP / longest)
        residual, linear = geometry.closure(angles)
        before, error = error, float(np.abs(residual).max(initial=0.0))
        if error > 0.5 * before and (error <= CLOSED or longest < STILL):
            break
    return angles, error

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
EXACT = 1e-11  # relative to the largest singular value: below it a closure matrix has round-off only
SOLVE = 1e-9  # likewise: below it a singular value is none of a place on the way to closure
SMALL = 2e-2  # likewise: below it a singular value may be a misfit, some hundredths of a radian or of the size at most
LONGEST_STEP = 0.5  # rad; lines of rotation are straight no farther
MAX_ITERATIONS = 60


def settle(
    geometry: LoopGeometry, angles: Array, free: Mask | None = None, cutoff: float = SOLVE
) -> tuple[Array, float]:
    """Gauss-Newton from `angles` (n,) on those that are `free` (n,) bool, by least squares and least change.

    Directions with singular values below `cutoff` times the largest are left alone: with SMALL, loops that fit badly
    are brought as near to closure as their motion allows, instead of to the one place where they close.
    Returns the place reached, and its largest residual, rad or units.
    """
    angles = angles.copy()
    columns = np.ones(len(angles), dtype=bool) if free is None else free
    residual, jacobian = geometry.closure(angles)
    for _ in range(MAX_ITERATIONS):
        if np.abs(residual).max(initial=0.0) <= 1e-2 * CLOSED or not columns.any():
            break
        step = _least_change(jacobian[:, columns], -residual, cutoff)
        longest = float(np.abs(step).max())
        if longest < 1e-15:
            break
        angles[columns] += step * min(1.0, LONGEST_STEP / longest)
        residual, jacobian = geometry.closure(angles)
    return angles, float(np.abs(residual).max(initial=0.0))


def _least_change(matrix: Array, goal: Array, cutoff: float) -> Array:
    """The smallest least-squares solution, singular values below `cutoff` times the largest counted as zero.

    A coarse cutoff allows the normal equations, whose eigenvalues are the squares: ten times as fast for large loops.
    """
    if cutoff < 1e-5:
        return np.asarray(np.linalg.lstsq(matrix, goal, rcond=cutoff)[0], dtype=np.float64)
    squares, vectors = np.linalg.eigh(matrix.T @ matrix)
    taken = squares > cutoff**2 * squares[-1]
    basis = vectors[:, taken]
    return np.asarray(basis @ ((basis.T @ (matrix.T @ goal)) / squares[taken]), dtype=np.float64)


def directions(geometry: LoopGeometry, angles: Array) -> tuple[Array, Array]:
    """Singular values (n,), descending, zeros included, and right singular vectors (n, n) by rows, of the closure
    matrix at `angles`: the last rows are the rates with which the loops stay closed."""
    jacobian = geometry.jacobian(angles)
    _, values, vectors = np.linalg.svd(jacobian, full_matrices=jacobian.shape[0] < jacobian.shape[1])
    return np.concatenate([values, np.zeros(len(vectors) - len(values))]), np.asarray(vectors)

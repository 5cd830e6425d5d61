"""Derivatives by differences that choose their own width (C. J. F. Ridders, Advances in Engineering Software 4, 1982).

In: a function of a number, with values of any shape. Out: its derivative, and an estimate of its error. Central
differences over ever smaller widths are extrapolated to none; of all entries of the tableau the one whose neighbours
agree best is taken.
"""

from collections.abc import Callable

import numpy as np

from lamc.run.request import Array

_SHRINK = 2.0
_ROWS = 8  # widths of one tableau
_WORSE = 2.0  # times the best error: round-off has the better of it, and so it goes on


def derivative(function: Callable[[float], Array], x: float, width: float) -> tuple[Array, float]:
    """Of the function at x, with widths from `width` on; and its error, largest of all entries, inf where no width
    gives finite values."""
    best, error = np.full_like(function(x), np.nan), np.inf
    rows: list[Array] = []
    for k in range(_ROWS):
        h = width / _SHRINK**k
        row = [(function(x + h) - function(x - h)) / (2.0 * h)]
        for j in range(1, k + 1):
            factor = _SHRINK ** (2 * j)
            row.append((factor * row[j - 1] - rows[-1][j - 1]) / (factor - 1.0))
            told = max(_size(row[j] - row[j - 1]), _size(row[j] - rows[-1][j - 1]))
            if told < error:
                best, error = row[j], told
        if k and _size(row[k] - rows[-1][k - 1]) > _WORSE * error and np.isfinite(error):
            break
        rows.append(np.array(row))
    return best, error


def derivative_any(function: Callable[[float], Array], x: float) -> tuple[Array, float]:
    """Where nothing is known of the width on which the function changes: the best of several."""
    starts = [abs(x) * part for part in (0.25, 1e-2, 1e-4)] if x else [10.0**-k for k in range(0, 13, 2)]
    tried = [derivative(function, x, width) for width in starts]
    return min(tried, key=lambda each: each[1])


def _size(values: Array) -> float:
    """Largest entry; inf where one is not finite."""
    return float(np.abs(values).max(initial=0.0)) if np.all(np.isfinite(values)) else np.inf

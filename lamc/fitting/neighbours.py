"""Whether residuals are noise: how alike those of neighbouring rows are.

In: residuals of columns. Out: correlations. Never: decides what follows.
"""

import numpy as np

from lamc.run.request import Array

_FEWEST = 20  # rows, of which a correlation says something


def likeness(residual: Array) -> tuple[float, int] | None:
    """The correlation of neighbouring residuals (m,), NaN: gaps, and of how many; None where there are too few, or all
    are equal."""
    r = residual[np.isfinite(residual)]
    if len(r) < _FEWEST or not r.std() > 0.0:
        return None
    r = r - r.mean()
    return float(np.sum(r[1:] * r[:-1]) / np.sum(r * r)), len(r)

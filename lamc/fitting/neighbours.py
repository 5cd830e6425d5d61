"""Whether residuals are noise: how alike those of neighbouring rows are, and whether they lie to one side.

In: residuals of columns. Out: correlations and means. Never: decides what follows.
"""

import numpy as np

from lamc.run.request import Array

_FEWEST = 20  # rows, of which a correlation says something
_SURE, _ONE_SIDED = (
    5.0,
    0.3,
)  # standard errors of a mean that is none of noise's, and of the spread that it is worth a word


def likeness(residual: Array) -> tuple[float, int] | None:
    """The correlation of neighbouring residuals (m,), NaN: gaps, and of how many; None where there are too few, or all
    are equal."""
    r = residual[np.isfinite(residual)]
    if len(r) < _FEWEST or not r.std() > 0.0:
        return None
    r = r - r.mean()
    return float(np.sum(r[1:] * r[:-1]) / np.sum(r * r)), len(r)


def offset(residual: Array) -> float:
    """The mean of residuals (m,), NaN: gaps, where it is no noise of their spread; else zero."""
    r = residual[np.isfinite(residual)]
    spread = float(r.std()) if len(r) >= _FEWEST else 0.0
    mean = float(r.mean()) if len(r) else 0.0
    return mean if spread and abs(mean) > max(_SURE / np.sqrt(len(r)), _ONE_SIDED) * spread else 0.0

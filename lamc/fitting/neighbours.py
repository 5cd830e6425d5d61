"""Whether residuals are noise: how alike those of neighbouring rows are, and whether they lie to one side.

In: residuals of columns. Out: correlations and means. Never: decides what follows.
"""

import numpy as np

from lamc.run.request import Array

_FEWEST = 20  # rows, of which a correlation says something
# A mean that is worth a word: standard errors, as none of noise's has (one of two million), and of the spread, as less
# hardly shifts what is fitted; of what was measured, as recordings of three digits have less; and in each third of the
# run so much of it, as it is no offset that comes or goes.
_SURE, _ONE_SIDED, _LEAST, _STEADY = 5.0, 0.3, 1e-3, 0.5


def likeness(residual: Array) -> tuple[float, int] | None:
    """The correlation of neighbouring residuals (m,), NaN: gaps, and of how many; None where there are too few, or all
    are equal."""
    r = residual[np.isfinite(residual)]
    if len(r) < _FEWEST or not r.std() > 0.0:
        return None
    r = r - r.mean()
    return float(np.sum(r[1:] * r[:-1]) / np.sum(r * r)), len(r)


def offset(residual: Array, size: float) -> float:
    """The mean of residuals (m,), NaN: gaps, where all along the run it is no noise of their spread, and more than a
    thousandth of the size of what was measured; else zero."""
    r = residual[np.isfinite(residual)]
    if len(r) < _FEWEST:
        return 0.0
    mean, least = float(r.mean()), max(_SURE / np.sqrt(len(r)), _ONE_SIDED) * float(r.std())
    thirds = [float(part.mean()) / mean if mean else 0.0 for part in np.array_split(r, 3)]
    return mean if abs(mean) > max(least, _LEAST * size) and min(thirds) > _STEADY else 0.0

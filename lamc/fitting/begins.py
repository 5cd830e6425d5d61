"""Where angles and rates stand in a recording, as far as its columns tell: where a fit begins.

In: a recording, a hinge, a time. Out: numbers, or None where no column tells. They are guesses: a polynomial through
the nearest rows.
"""

import numpy as np

from lamc.records.recording import Recording
from lamc.run.request import Array

_ROWS = 9  # that a guess looks at


def angle_and_rate(recording: Recording, joint: str, kind: str, at: float | None = None) -> float | None:
    """The angle, rad, or rate, rad/s, of a hinge at a time of the recording's clock; None: its first."""
    time = float(recording.t[0]) if at is None else at
    if kind == "rate" and f"{joint}.rate" in recording.values:
        return _near(recording.t, recording.values[f"{joint}.rate"], time, 0)
    if joint not in recording.values:
        return None
    return _near(recording.t, recording.values[joint], time, 0 if kind == "angle" else 1)


def _near(t: Array, values: Array, at: float, order: int) -> float | None:
    """A value (order 0) or its rate (1) near a time, by a parabola through the nearest rows."""
    good = np.flatnonzero(np.isfinite(values))
    if len(good) <= order:
        return None
    nearest = good[np.argsort(np.abs(t[good] - at), kind="stable")[:_ROWS]]
    degree = min(2, len(nearest) - 1)
    found = np.polynomial.polynomial.polyfit(t[nearest] - at, values[nearest], degree)
    return float(found[order]) if order <= degree else 0.0

"""How what is read off samples follows from each of them: derivatives of `samples`, by the values at the rows.

In: samples. Out: derivatives (m,) of one number by the values at the rows. Raises NoSlopeError where there is none:
of a time that stays at its row, of what is no number.
"""

import math

import numpy as np

from lamc.basics.errors import RequestError
from lamc.run.request import Array
from lamc.studies.samples import Samples, first_above, highest, rms, stencil, turned

ROUND_OFF = 1e-12  # of a distance of rows: a peak or a crossing that close to a row is at it


class NoSlopeError(RequestError):
    """A measure has no derivative here."""


def mean_slope(samples: Samples) -> Array:
    span = float(samples.t[-1] - samples.t[0])
    return integral_slope(samples) / span if span > 0.0 else last_slope(samples)


def integral_slope(samples: Samples) -> Array:
    """Weights of the trapezoidal rule."""
    found = np.zeros(len(samples.t))
    steps = 0.5 * np.diff(samples.t)
    found[:-1] += steps
    found[1:] += steps
    return found


def rms_slope(samples: Samples) -> Array:
    value = rms(samples)
    if not value > 0.0:
        raise NoSlopeError("the root mean square of what is zero has no derivative")
    return mean_slope(samples) * samples.y / value


def first_slope(samples: Samples) -> Array:
    return row_slope(samples, 0)


def last_slope(samples: Samples) -> Array:
    return row_slope(samples, -1)


def row_slope(samples: Samples, index: int) -> Array:
    found = np.zeros(len(samples.t))
    found[index] = 1.0
    return found


def highest_slope(samples: Samples) -> Array:
    """Of the largest value: where it is stays out of it, as the slope there is zero, or the row it is at stays."""
    value, at = highest(samples)
    return at_slope(samples, _finite(at, value))


def lowest_slope(samples: Samples) -> Array:
    return highest_slope(turned(samples))


def at_slope(samples: Samples, moment: float) -> Array:
    """Of the value at a time."""
    return _weights(samples, moment, 0)


def highest_time_slope(samples: Samples) -> Array:
    """Of the time of the largest value."""
    moment = _finite(highest(samples)[1])
    slopes, bends = (_weights(samples, moment, order) for order in (1, 2))
    bend = float(bends @ samples.y)
    if _is_row(samples, moment) or not bend < 0.0:
        raise NoSlopeError(
            "the time of an extreme that lies at a row, such as the last one, has no derivative: it stays there"
        )
    return -slopes / bend


def lowest_time_slope(samples: Samples) -> Array:
    return -highest_time_slope(turned(samples))


def crossing_slope(samples: Samples) -> Array:
    """Of the first time above zero."""
    moment = _finite(first_above(samples))
    rate = float(_weights(samples, moment, 1, before=True) @ samples.y)
    if moment <= samples.t[0] or not rate > 0.0:
        raise NoSlopeError("the time of what holds from the start on, or jumps, has no derivative")
    return -_weights(samples, moment, 0, before=True) / rate


def _finite(*numbers: float) -> float:
    if not all(math.isfinite(number) for number in numbers):
        raise NoSlopeError("a measure that is no number has no derivative")
    return numbers[0]


def _is_row(samples: Samples, moment: float) -> bool:
    distances = np.abs(samples.t - moment)
    return bool(np.min(distances) <= ROUND_OFF * max(float(np.ptp(samples.t)), 1e-300))


def _weights(samples: Samples, moment: float, order: int, *, before: bool = False) -> Array:
    """Weights (m,) of the derivative of that order, at a time, of the polynomial between the rows about it. before:
    at a row, of the polynomial that ends there."""
    t = samples.t
    found = np.zeros(len(t))
    after = int(np.searchsorted(t, moment))
    if order == 0 and t[after] == moment:
        found[after] = 1.0
        return found
    i = max(after - 1, 0) if before or t[after] != moment else min(after, len(t) - 2)
    rows = stencil(samples, i)
    x = t[rows] - moment
    scale = float(np.max(np.abs(x)))
    powers = np.vander(x / scale, increasing=True).T
    if order >= len(rows):
        return found
    wanted = np.zeros(len(rows))
    wanted[order] = math.factorial(order) / scale**order
    found[rows] = np.linalg.solve(powers, wanted)
    return found


OVER_TIME = {
    "max": highest_slope,
    "min": lowest_slope,
    "mean": mean_slope,
    "rms": rms_slope,
    "integral": integral_slope,
    "first": first_slope,
    "last": last_slope,
}

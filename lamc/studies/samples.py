"""What is read off samples of a quantity over time: peaks, crossings, averages, values between rows.

In: times t (m,), ascending, s, values y (m,), and breaks: times of events, at which a quantity may jump or have a kink.
Out: numbers. Between rows a quantity is the cubic through the four nearest of them, whose error falls with the fourth
power of their distance; where a break lies among the four, or there are fewer, it is the straight line.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lamc.run.request import Array


class Samples(NamedTuple):
    """t: (m,), s; y: (m,); breaks: (k,), s, ascending."""

    t: Array
    y: Array
    breaks: Array


def turned(samples: Samples) -> Samples:
    """Those of less."""
    return samples._replace(y=-samples.y)


def mean(samples: Samples) -> float:
    """Average over time, by the trapezoidal rule on the rows."""
    span = float(samples.t[-1] - samples.t[0])
    return integral(samples) / span if span > 0.0 else float(samples.y[-1])


def integral(samples: Samples) -> float:
    """Over time, by the trapezoidal rule on the rows."""
    y = samples.y
    return 0.5 * float(np.sum((y[1:] + y[:-1]) * np.diff(samples.t)))


def rms(samples: Samples) -> float:
    """Square root of the average of the square."""
    return float(np.sqrt(mean(samples._replace(y=samples.y**2))))


def highest(samples: Samples) -> tuple[float, float]:
    """The largest value and its time: of the largest row, and of the cubics on both sides of it."""
    t, y, _ = samples
    if not np.isfinite(y).all():
        return float("nan"), float("nan")
    k = int(np.argmax(y))
    best, at = float(y[k]), float(t[k])
    sides = [i for i in (k - 1, k) if 0 <= i < len(t) - 1]
    most = best + max((abs(float(y[i + 1] - y[i])) for i in sides), default=0.0)
    for i in sides:
        cubic = _cubic(samples, i)
        if cubic is None:
            continue
        for x in _turns(cubic):
            value = _polynomial(cubic, x)
            if (
                t[i] < t[i] + x < t[i + 1] and best < value <= most
            ):  # one that swings out does not follow its rows
                best, at = value, float(t[i] + x)
    return best, at


def value_at(samples: Samples, moment: float) -> float:
    """The value at a time, s; NaN outside of the rows."""
    t, y, _ = samples
    if not t[0] <= moment <= t[-1]:
        return float("nan")
    i = int(np.searchsorted(t, moment))
    if t[i] == moment:
        return float(y[i])
    return _between(samples, i - 1, moment)


def first_above(samples: Samples) -> float:
    """The first time at which the value is above zero, s; NaN if no row is."""
    t, y, _ = samples
    above = np.flatnonzero(y > 0.0)
    if not above.size or not np.isfinite(y[: above[0] + 1]).all():
        return float("nan")
    k = int(above[0])
    if k == 0:
        return float(t[0])
    below, beyond = float(t[k - 1]), float(t[k])
    while below < (middle := 0.5 * (below + beyond)) < beyond:  # halved to the last bit, 60 times at most
        if _between(samples, k - 1, middle) > 0.0:
            beyond = middle
        else:
            below = middle
    return beyond


def _between(samples: Samples, i: int, moment: float) -> float:
    """The value at a time between rows i and i + 1."""
    t, y, _ = samples
    if moment in (t[i], t[i + 1]):
        return float(y[i] if moment == t[i] else y[i + 1])
    cubic = _cubic(samples, i)
    if cubic is None:
        return float(np.interp(moment, t[i : i + 2], y[i : i + 2]))
    return _polynomial(cubic, float(moment - t[i]))


def _cubic(samples: Samples, i: int) -> tuple[float, float, float, float] | None:
    """Coefficients c of c[0] x³ + c[1] x² + c[2] x + c[3], x = t - t[i], through the four rows about i and i + 1; None
    where there is none."""
    t, y, _ = samples
    first = _first_of_cubic(samples, i)
    if first is None:
        return None
    x = [float(each - t[i]) for each in t[first : first + 4]]
    d = [float(each) for each in y[first : first + 4]]
    for order in (1, 2, 3):  # Newton's divided differences
        for k in range(3, order - 1, -1):
            d[k] = (d[k] - d[k - 1]) / (x[k] - x[k - order])
    c = [d[3]]
    for k in (2, 1, 0):  # multiplied out: c(x) (x - x[k]) + d[k]
        c = [*c, d[k]]
        for n in range(len(c) - 1, 0, -1):
            c[n] -= x[k] * c[n - 1]
    return c[0], c[1], c[2], c[3]


def _first_of_cubic(samples: Samples, i: int) -> int | None:
    """The first of the four rows about i and i + 1; None where a break lies among them, or there are fewer."""
    t, _, breaks = samples
    if len(t) < 4:
        return None
    first = min(max(i - 1, 0), len(t) - 4)
    return None if ((breaks >= t[first]) & (breaks <= t[first + 3])).any() else first


def stencil(samples: Samples, i: int) -> npt.NDArray[np.intp]:
    """The rows that what lies between rows i and i + 1 goes through."""
    first = _first_of_cubic(samples, i)
    return np.arange(i, i + 2) if first is None else np.arange(first, first + 4)


def _polynomial(c: tuple[float, float, float, float], x: float) -> float:
    return ((c[0] * x + c[1]) * x + c[2]) * x + c[3]


def _turns(c: tuple[float, float, float, float]) -> list[float]:
    """Where the cubic's derivative 3 c[0] x² + 2 c[1] x + c[2] is zero."""
    under = c[1] * c[1] - 3.0 * c[0] * c[2]
    if under < 0.0:
        return []
    q = -(c[1] + math.copysign(math.sqrt(under), c[1]))  # without cancellation
    return [over / below for over, below in ((q, 3.0 * c[0]), (c[2], q)) if below != 0.0]

"""Functions of one number that are given by a table: piecewise polynomials, and the curves that make them of points.

Goes in: points of a curve. Comes out: a `Piecewise`, whose derivatives and integral are piecewise polynomials too,
so that torque, stiffness and energy of one table agree to round-off. Outside its points a curve goes on straight.
Never: meets a symbol; `staging.py` makes a node of it.
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

Row = tuple[float, ...]


@dataclass(frozen=True)
class Piecewise:
    """Row 0 of `pieces` counts left of the first break, row i from break i - 1 on.

    breaks  strictly ascending, at least one
    pieces  len(breaks) + 1 rows of equal length: coefficients by rising power of the distance from the row's break
            (of row 0: from the first)
    """

    breaks: Row
    pieces: tuple[Row, ...]

    def value(self, x: float, order: int = 0) -> float:
        """The derivative of that order at x; at a break that of the piece on its right."""
        row = bisect_right(self.breaks, x)
        return _polynomial(self.pieces[row], x - self.breaks[max(row - 1, 0)], order)

    @property
    def degree(self) -> int:
        return len(self.pieces[0]) - 1

    def integral(self) -> "Piecewise":
        """The antiderivative that is zero at x = 0."""
        rows = [(0.0, *(c / (k + 1) for k, c in enumerate(row))) for row in self.pieces]
        for i in range(2, len(rows)):  # rows 0 and 1 share a break, where both are zero so far
            start = _polynomial(rows[i - 1], self.breaks[i - 1] - self.breaks[i - 2], 0)
            rows[i] = (start, *rows[i][1:])
        at_zero = Piecewise(self.breaks, tuple(rows)).value(0.0)
        return Piecewise(self.breaks, tuple((row[0] - at_zero, *row[1:]) for row in rows))


def _polynomial(row: Row, distance: float, order: int) -> float:
    total = 0.0
    for power in range(len(row) - 1, order - 1, -1):
        total = total * distance + math.perm(power, order) * row[power]
    return total


def spline(x: Sequence[float], y: Sequence[float]) -> Piecewise:
    """The natural cubic spline: twice smoothly differentiable everywhere, its straight ends included.

    With second derivatives m: h₋ m₋ + 2 (h₋ + h₊) m + h₊ m₊ = 6 (slope₊ - slope₋) at inner points, m = 0 at the ends
    (de Boor, A Practical Guide to Splines, 1978, ch. IV). Between points of a smooth curve the error is O(h⁴), next to
    the ends O(h²) unless the curve is straight there.
    """
    steps = [b - a for a, b in pairwise(x)]
    slopes = [(b - a) / h for (a, b), h in zip(pairwise(y), steps, strict=True)]
    count = len(x)
    second = [0.0] * count
    above, right = [0.0] * count, [0.0] * count  # of the eliminated rows: m = right - above · m₊
    for i in range(1, count - 1):
        pivot = 2.0 * (steps[i - 1] + steps[i]) - steps[i - 1] * above[i - 1]
        above[i] = steps[i] / pivot
        right[i] = (6.0 * (slopes[i] - slopes[i - 1]) - steps[i - 1] * right[i - 1]) / pivot
    for i in range(count - 2, 0, -1):
        second[i] = right[i] - above[i] * second[i + 1]
    rows = [
        (
            y[i],
            slopes[i] - h * (2.0 * second[i] + second[i + 1]) / 6.0,
            second[i] / 2.0,
            (second[i + 1] - second[i]) / (6.0 * h),
        )
        for i, h in enumerate(steps)
    ]
    last = slopes[-1] + steps[-1] * second[-2] / 6.0
    return _continued(x, y, rows, last)


def monotone(x: Sequence[float], y: Sequence[float]) -> Piecewise:
    """The cubic Hermite curve that rises where the points rise and falls where they fall, without overshoot.

    Once smoothly differentiable; slopes after Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304, at the
    ends the three-point formula kept within the shape (Moler, Numerical Computing with MATLAB, 2004, ch. 3).
    """
    steps = [b - a for a, b in pairwise(x)]
    secants = [(b - a) / h for (a, b), h in zip(pairwise(y), steps, strict=True)]
    slopes = [_end_slope(steps, secants), *(0.0 for _ in steps)]
    for i in range(1, len(steps)):
        before, after = secants[i - 1], secants[i]
        if before * after > 0.0:
            first, second = 2.0 * steps[i] + steps[i - 1], steps[i] + 2.0 * steps[i - 1]
            slopes[i] = (first + second) / (first / before + second / after)
    slopes[-1] = _end_slope(steps[::-1], secants[::-1])
    rows = [
        (
            y[i],
            slopes[i],
            (3.0 * secants[i] - 2.0 * slopes[i] - slopes[i + 1]) / h,
            (slopes[i] + slopes[i + 1] - 2.0 * secants[i]) / (h * h),
        )
        for i, h in enumerate(steps)
    ]
    return _continued(x, y, rows, slopes[-1])


def _end_slope(steps: Sequence[float], secants: Sequence[float]) -> float:
    if len(steps) == 1:
        return secants[0]
    slope = ((2.0 * steps[0] + steps[1]) * secants[0] - steps[0] * secants[1]) / (steps[0] + steps[1])
    if slope * secants[0] <= 0.0:
        return 0.0
    if secants[0] * secants[1] <= 0.0 and abs(slope) > abs(3.0 * secants[0]):
        return 3.0 * secants[0]
    return slope


def _continued(x: Sequence[float], y: Sequence[float], rows: Sequence[Row], last: float) -> Piecewise:
    """The pieces between the points, and straight lines before and after them."""
    before = (y[0], rows[0][1], 0.0, 0.0)
    after = (y[-1], last, 0.0, 0.0)
    return Piecewise(tuple(x), (before, *rows, after))

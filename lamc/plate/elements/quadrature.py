"""Gauss's points on the square, for integrands that are no polynomials: cells whose sides are not parallel.

In: a degree. Out: points and weights. Never: triangles, whose integrals are exact without.
"""

from typing import TypeAlias

import numpy as np

Point: TypeAlias = tuple[float, float, float]  # ξ, η, weight; weights sum to 4


def square_points(degree: int) -> tuple[Point, ...]:
    """Exact up to `degree` in each of ξ and η."""
    x, weights = np.polynomial.legendre.leggauss(degree // 2 + 1)
    return tuple(
        (float(a), float(b), float(p * q))
        for a, p in zip(x, weights, strict=True)
        for b, q in zip(x, weights, strict=True)
    )

"""Gauss's points on a cell, for integrands that are no polynomials: cells whose sides are not parallel, and a user's
functions of the place.

In: a degree. Out: points and weights. Never: shape functions of triangles, whose integrals are exact without.
"""

from typing import TypeAlias

import numpy as np
from scipy.special import roots_jacobi

Point: TypeAlias = tuple[float, float, float]  # ξ, η, weight; weights sum to the area, 4 or 1/2


def square_points(degree: int) -> tuple[Point, ...]:
    """Exact up to `degree` in each of ξ and η."""
    x, weights = np.polynomial.legendre.leggauss(degree // 2 + 1)
    return tuple(
        (float(a), float(b), float(p * q))
        for a, p in zip(x, weights, strict=True)
        for b, q in zip(x, weights, strict=True)
    )


def triangle_points(degree: int) -> tuple[Point, ...]:
    """Exact up to `degree` in ξ and η together: Gauss's points along lines from one corner, by Gauss-Jacobi's (A. H.
    Stroud, Approximate Calculation of Multiple Integrals, 1971, section 2.5)."""
    count = degree // 2 + 1
    along, own = np.polynomial.legendre.leggauss(count)
    across, other = roots_jacobi(count, 1, 0)
    return tuple(
        (float((1 + a) * (1 - b) / 4), float((1 + b) / 2), float(p * q / 8))
        for a, p in zip(along, own, strict=True)
        for b, q in zip(across, other, strict=True)
    )

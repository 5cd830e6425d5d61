"""Polynomials in ξ and η with exact coefficients, and their integrals over a triangle or a square.

In: sympy expressions. Out: {(i, j): coefficient of ξ^i η^j}, sorted. Never: floats, coordinates of corners.
"""

from collections.abc import Mapping
from fractions import Fraction
from math import factorial
from typing import TypeAlias

from lamc.plate.elements.definition import TRIANGLE

Polynomial: TypeAlias = Mapping[tuple[int, int], Fraction]


def derivative(p: Polynomial, *axes: int) -> Polynomial:
    """By ξ (0) and η (1), one after the other."""
    for axis in axes:
        p = {
            (i - (axis == 0), j - (axis == 1)): c * (i, j)[axis]
            for (i, j), c in p.items()
            if (i, j)[axis] > 0
        }
    return p


def product(p: Polynomial, q: Polynomial) -> Polynomial:
    result: dict[tuple[int, int], Fraction] = {}
    for (i, j), c in p.items():
        for (k, m), d in q.items():
            result[i + k, j + m] = result.get((i + k, j + m), Fraction(0)) + c * d
    return {key: c for key, c in sorted(result.items()) if c}


def integral(p: Polynomial, cell: str) -> Fraction:
    """Over L1, L2, L3 ≥ 0 (area 1/2), by i! j! / (i + j + 2)!, or over [-1, 1]² (area 4)."""
    total = Fraction(0)
    for (i, j), c in p.items():
        if cell == TRIANGLE:
            total += c * Fraction(factorial(i) * factorial(j), factorial(i + j + 2))
        elif i % 2 == 0 and j % 2 == 0:
            total += c * Fraction(4, (i + 1) * (j + 1))
    return total

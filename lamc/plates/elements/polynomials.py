"""Polynomials in ξ and η with exact coefficients, and their integrals over a triangle or a square.

In: sympy expressions. Out: {(i, j): coefficient of ξ^i η^j}, sorted. Never: floats, coordinates of corners.
"""

from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from math import factorial
from typing import TypeAlias

from lamc.plates.elements.definition import CORNERS, SQUARE, TRIANGLE

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


@cache
def monomial_integral(i: int, j: int, cell: str) -> Fraction:
    """Of ξ^i η^j over L1, L2, L3 ≥ 0 (area 1/2), by i! j! / (i + j + 2)!, or over [-1, 1]² (area 4)."""
    if cell == TRIANGLE:
        return Fraction(factorial(i) * factorial(j), factorial(i + j + 2))
    return Fraction(4, (i + 1) * (j + 1)) if i % 2 == 0 and j % 2 == 0 else Fraction(0)


def inner(p: Polynomial, q: Polynomial, cell: str) -> Fraction:
    """Integral of the product over the natural cell."""
    total = Fraction(0)
    for (i, j), c in p.items():
        for (k, m), d in q.items():
            integrated = monomial_integral(i + k, j + m, cell)
            if integrated:
                total += c * d * integrated
    return total


def hats(cell: str) -> tuple[Polynomial, ...]:
    """Functions that are 1 at one corner and linear (bilinear) between."""
    one = Fraction(1)
    if cell == SQUARE:
        quarter = Fraction(1, 4)
        return tuple(
            {(0, 0): quarter, (0, 1): quarter * b, (1, 0): quarter * a, (1, 1): quarter * a * b}
            for a, b in CORNERS[SQUARE]
        )
    return {(0, 0): one, (0, 1): -one, (1, 0): -one}, {(1, 0): one}, {(0, 1): one}

"""Shape functions of plate elements as tables of numbers: polynomials found from what they must be at the nodes.

In: nodes and powers of ξ and η. Out: values and derivatives of the polynomials at points, and rules of integration.
Never: sympy, or formulas of shape functions; every table is the inverse of a matrix of nodal conditions.

Triangles have ξ = L2, η = L3; squares ξ and η in [-1, 1]. Sources: P. G. Ciarlet, The Finite Element Method for
Elliptic Problems, 1978, section 2.2; F. K. Bogner, R. L. Fox and L. A. Schmit, Proc. Conf. Matrix Methods in Structural
Mechanics, 1965; O. C. Zienkiewicz, The Finite Element Method, 3rd ed. 1977, chapter 7.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lamc.reference.plate_layout import CORNERS, Point, places

Numbers = NDArray[np.floating[Any]]  # float64, or long double where a residual is refined
Powers = Sequence[tuple[int, int]]

_CUBIC = [(i, j) for i in range(4) for j in range(4) if i + j <= 3]
_BICUBIC = [(i, j) for i in range(4) for j in range(4)]
_SERENDIPITY = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (2, 1), (1, 2)]
_POWERS: dict[str, Powers] = {
    "cst": [(0, 0), (1, 0), (0, 1)],
    "lst": [(i, j) for i in range(3) for j in range(3) if i + j <= 2],
    "q4": [(0, 0), (1, 0), (0, 1), (1, 1)],
    "q8": _SERENDIPITY,
    "q9": [(i, j) for i in range(3) for j in range(3)],
    "q12": [*_SERENDIPITY, (3, 0), (0, 3), (3, 1), (1, 3)],
}


@dataclass(frozen=True, eq=False)
class Polynomials:
    """Polynomials in ξ, η: `coefficients` (n, k) of the monomials ξ^i η^j with the powers `powers` (k, 2)."""

    powers: Powers
    coefficients: Numbers

    def __call__(self, xi: Numbers, derivative: tuple[int, int] = (0, 0)) -> Numbers:
        """Values, or derivatives of that order in ξ and η, at `xi` (m, 2): shape (m, n), in its precision."""
        return np.asarray(_monomials(self.powers, xi, derivative) @ self.coefficients.T.astype(xi.dtype))

    def gradient(self, xi: Numbers) -> Numbers:
        """By ξ and η at `xi` (m, 2): shape (m, 2, n)."""
        return np.stack([self(xi, (1, 0)), self(xi, (0, 1))], axis=1)

    def hessian(self, xi: Numbers) -> Numbers:
        """Second derivatives at `xi` (m, 2): shape (m, 2, 2, n)."""
        twist = self(xi, (1, 1))
        rows = [[self(xi, (2, 0)), twist], [twist, self(xi, (0, 2))]]
        return np.stack([np.stack(row, axis=1) for row in rows], axis=1)


def _monomials(powers: Powers, xi: Numbers, derivative: tuple[int, int] = (0, 0)) -> Numbers:
    value = np.ones((len(xi), len(powers)), dtype=xi.dtype)
    for axis in range(2):
        power = np.array(powers)[:, axis]
        factor = np.ones_like(power)
        for _ in range(derivative[axis]):
            factor, power = factor * power, power - 1
        value = value * factor * xi[:, axis, None] ** np.maximum(power, 0)
    return value


def _solved(powers: Powers, conditions: Numbers, count: int) -> Polynomials:
    """For each of the first `count` conditions the polynomial that makes it 1 and all others 0.

    All coefficients here are multiples of 1/64; rounding to these takes away the round-off of the inverse.
    """
    found = np.linalg.inv(conditions).T[:count]
    exact = np.round(64.0 * found) / 64.0
    assert np.abs(found - exact).max() < 1e-10
    return Polynomials(powers, exact)


def _at(powers: Powers, node: Point, *orders: tuple[int, int]) -> list[Numbers]:
    return [_monomials(powers, np.array([node], dtype=float), order)[0] for order in orders]


def membrane_polynomials(cell: str, name: str) -> Polynomials:
    """One polynomial per node of a membrane element, 1 there and 0 at the other nodes."""
    nodes, powers = places(cell, name), _POWERS[name]
    return _solved(powers, _monomials(powers, np.array(nodes, dtype=float)), len(nodes))


def zienkiewicz_triangle() -> Polynomials:
    """Nine cubics for (w, w_ξ, w_η) at the corners that contain all quadratics: Ciarlet's (2.2.38) at the centroid.

    This is the interpolation of Bazeley, Cheung, Irons and Zienkiewicz 1965.
    """
    conditions, reduced = [], 6.0 * _monomials(_CUBIC, np.full((1, 2), 1 / 3))[0]
    for corner in CORNERS["triangle"]:
        value, by_xi, by_eta = _at(_CUBIC, corner, (0, 0), (1, 0), (0, 1))
        conditions += [value, by_xi, by_eta]
        out = np.array(corner, dtype=float) - 1 / 3
        reduced = reduced - 2.0 * value + out[0] * by_xi + out[1] * by_eta
    return _solved(_CUBIC, np.array([*conditions, reduced]), 9)


def bicubic_square() -> Polynomials:
    """Sixteen for (w, w_ξ, w_η, w_ξη) at the corners."""
    orders = [(0, 0), (1, 0), (0, 1), (1, 1)]
    conditions = [row for corner in CORNERS["square"] for row in _at(_BICUBIC, corner, *orders)]
    return _solved(_BICUBIC, np.array(conditions), 16)


def _gauss(count: int) -> tuple[Numbers, Numbers]:
    """Gauss's points in [-1, 1] and weights, in long double: numpy's, and two steps of Newton's method."""
    x: Numbers = np.polynomial.legendre.leggauss(count)[0].astype(np.longdouble)
    for _ in range(3):
        before, value = np.ones_like(x), x  # P_0 and P_1
        for n in range(1, count):
            before, value = value, ((2 * n + 1) * x * value - n * before) / (n + 1)
        slope = count * (before - x * value) / (1 - x * x)
        weight = 2 / ((1 - x * x) * slope * slope)
        x = x - value / slope  # the last step is idle
    return x, weight


def triangle_rule(degree: int) -> tuple[Numbers, Numbers]:
    """Points (p, 2) and weights (p,), sum 1/2, exact up to `degree`: Gauss's rule on a square folded to a triangle.

    In long double, as the points of every rule here.
    """
    x, weight = _gauss(degree // 2 + 1)
    y, weight_y = _gauss((degree + 1) // 2 + 1)
    a, b = np.meshgrid((x + 1) / 2, (y + 1) / 2, indexing="ij")
    points = np.stack([a * (1 - b), b], axis=-1).reshape(-1, 2)
    return points, (np.outer(weight, weight_y) * (1 - b) / 4).ravel()


def square_rule(count: int) -> tuple[Numbers, Numbers]:
    """Gauss's rule of count × count points: points (p, 2) and weights (p,), sum 4."""
    x, weight = _gauss(count)
    points = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    return points, np.outer(weight, weight).ravel()


def bubbles() -> Polynomials:
    """L1 L2 L3 times L1, L2 and L3."""
    powers = [(1, 1), (2, 1), (1, 2), (3, 1), (2, 2), (1, 3)]
    by_l2, by_l3 = [0, 1, 0, -1, -1, 0], [0, 0, 1, 0, -1, -1]
    by_l1 = [1, -2, -2, 1, 2, 1]
    return Polynomials(powers, np.array([by_l1, by_l2, by_l3], dtype=float))

"""Rectangular plates by the Rayleigh–Ritz method: a reference that has no elements, and converges from above.

Deflections are Legendre polynomials in x times those in y, each times what its two supports ask for: x for a simple
support at the lower end, x² for a clamped one. Source: A. W. Leissa, Vibration of Plates, NASA SP-160, 1969; the basis
is that of R. B. Bhat, J. Sound Vib. 102, 1985, in other words.
"""

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import Legendre, leggauss
from scipy.linalg import eigh

HELD = {"F": 0, "S": 1, "C": 2}  # free, simply supported, clamped: the power of the distance to that end


def _functions(ends: str, count: int, at: np.ndarray) -> list[np.ndarray]:
    """Values, first and second derivatives, each (count, len(at)), on [0, 1]."""
    x = Polynomial([0.0, 1.0])
    edge = [x ** HELD[ends[0]] * (1 - x) ** HELD[ends[1]]]
    edge += [edge[0].deriv(1), edge[0].deriv(2)]
    e = [derivative(at) for derivative in edge]
    rows: list[list[np.ndarray]] = [[], [], []]
    for k in range(count):
        # Leibniz' rule on values: coefficients in powers of x would lose all digits near the 12th function.
        basis = Legendre.basis(k, domain=[0, 1])
        p = [basis(at), basis.deriv(1)(at), basis.deriv(2)(at)]
        rows[0].append(e[0] * p[0])
        rows[1].append(e[1] * p[0] + e[0] * p[1])
        rows[2].append(e[2] * p[0] + 2 * e[1] * p[1] + e[0] * p[2])
    return [np.array(row) for row in rows]


def matrices(
    a: float, b: float, D: np.ndarray, supports: str, N: tuple[float, float, float], count: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stiffness, mass for one kg/m², and geometric stiffness under (N_x, N_y, N_xy) N/m, tension positive.

    supports: ends x=0, x=a, y=0, y=b, such as "CFFF"; D (3, 3), N·m.
    """
    s, weight = leggauss(count + 6)
    at, weight = 0.5 * (s + 1), 0.5 * weight
    X, Y = _functions(supports[:2], count, at), _functions(supports[2:], count, at)

    def field(i: int, j: int) -> np.ndarray:
        """∂ⁱ⁺ʲw/∂xⁱ∂yʲ of every function at every point, (count², points²)."""
        product = np.einsum("kp,lq->klpq", X[i] / a**i, Y[j] / b**j)
        return product.reshape(count * count, -1)

    area = a * b * np.outer(weight, weight).ravel()
    bend = -np.stack([field(2, 0), field(0, 2), 2 * field(1, 1)])
    slope = np.stack([field(1, 0), field(0, 1)])
    tension = np.array([[N[0], N[2]], [N[2], N[1]]])
    w = field(0, 0)
    return _form(bend, D, area), (w * area) @ w.T, _form(slope, tension, area)


def _form(rows: np.ndarray, matrix: np.ndarray, area: np.ndarray) -> np.ndarray:
    """∫ rowsᵀ matrix rows dA; rows (i, functions, points)."""
    right = np.tensordot(matrix, rows, 1) * area
    return sum(left @ r.T for left, r in zip(rows, right, strict=True))


def frequencies(a: float, b: float, D: np.ndarray, supports: str, count: int = 12) -> np.ndarray:
    """ω √(ρh), ascending, rad/s √(kg/m²); rigid motions are the first, near zero."""
    K, M, _ = matrices(a, b, D, supports, (0.0, 0.0, 0.0), count)
    return np.sqrt(np.maximum(eigh(K, M, eigvals_only=True), 0.0))


def buckling_factors(
    a: float, b: float, D: np.ndarray, supports: str, N: tuple[float, float, float], count: int = 12
) -> np.ndarray:
    """Positive factors of N, ascending."""
    K, _, G = matrices(a, b, D, supports, N, count)
    inverse = eigh(-G, K, eigvals_only=True)
    return 1.0 / inverse[inverse > 1e-9 * inverse.max()][::-1]

"""How a cell lies in the plane: staged derivatives of x and y by ξ and η, and strains by natural derivatives.

In: staged corners. Out: polynomials in ξ and η with staged coefficients, as lists of (polynomial, factor). Never: shape
functions.

All gradients here are multiplied by the Jacobian's determinant, so that a cell's area is divided by once only.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from lamc.plates.elements.definition import SQUARE, Element
from lamc.plates.elements.polynomials import Polynomial, product
from lamc.symbolic.scalars import Scalar

ONE: Polynomial = {(0, 0): Fraction(1)}
Varying: TypeAlias = tuple[tuple[Polynomial, Scalar], ...]  # Σ polynomial · factor
_HALF, _QUARTER = Fraction(1, 2), Fraction(1, 4)


@dataclass(frozen=True)
class CellMap:
    """Of one cell.

    determinant  of ∂(x, y)/∂(ξ, η), m²: area per unit of natural area
    by_x, by_y   determinant · (∂ξ/∂x, ∂η/∂x) and (∂ξ/∂y, ∂η/∂y), m
    """

    determinant: Varying
    by_x: tuple[Varying, Varying]
    by_y: tuple[Varying, Varying]


def frame(element: Element, corners: Sequence[tuple[Scalar, Scalar]]) -> CellMap:
    """Affine for triangles and, where the element bends, for rectangles along x and y; else bilinear."""
    (xa, ya), (xb, yb), *_ = corners
    x_xi: Scalar
    y_xi: Scalar
    x_eta: Scalar
    y_eta: Scalar
    if element.is_affine:
        if element.cell == SQUARE:
            x_xi, y_xi = _HALF * (xb - xa), 0
            x_eta, y_eta = 0, _HALF * (corners[3][1] - ya)
        else:
            x_xi, y_xi = xb - xa, yb - ya
            x_eta, y_eta = corners[2][0] - xa, corners[2][1] - ya
        determinant = x_xi * y_eta - y_xi * x_eta
        return CellMap(
            ((ONE, determinant),),
            (((ONE, y_eta),), ((ONE, -y_xi),)),
            (((ONE, -x_eta),), ((ONE, x_xi),)),
        )
    (x_xi, x_eta, x_twist), (y_xi, y_eta, y_twist) = (
        _bilinear([corner[axis] for corner in corners]) for axis in range(2)
    )
    along_xi, along_eta = {(1, 0): Fraction(1)}, {(0, 1): Fraction(1)}
    return CellMap(
        (
            (ONE, x_xi * y_eta - y_xi * x_eta),
            (along_xi, x_xi * y_twist - y_xi * x_twist),
            (along_eta, x_twist * y_eta - y_twist * x_eta),
        ),
        (((ONE, y_eta), (along_xi, y_twist)), ((ONE, -y_xi), (along_eta, -y_twist))),
        (((ONE, -x_eta), (along_xi, -x_twist)), ((ONE, x_xi), (along_eta, x_twist))),
    )


def _bilinear(values: Sequence[Scalar]) -> tuple[Scalar, Scalar, Scalar]:
    """Factors of ξ, η and ξη of the function with these values at the corners of the square."""
    bottom, top = values[1] - values[0], values[2] - values[3]
    left, right = values[3] - values[0], values[2] - values[1]
    return _QUARTER * (bottom + top), _QUARTER * (left + right), _QUARTER * (top - bottom)


def times(first: Varying, second: Varying) -> Varying:
    return tuple((product(p, q), a * b) for p, a in first for q, b in second)


def scaled(varying: Varying, factor: Scalar) -> Varying:
    return tuple((p, factor * a) for p, a in varying)


def stretching_rows(frame: CellMap, sign: int) -> tuple[tuple[Varying, ...], ...]:
    """determinant · (ε_x, ε_y, γ_xy), each by (u_ξ, u_η, v_ξ, v_η); `sign` -1: κ by the derivatives of w_x and w_y."""
    by_x = tuple(scaled(varying, sign) for varying in frame.by_x)
    by_y = tuple(scaled(varying, sign) for varying in frame.by_y)
    return (*by_x, (), ()), ((), (), *by_y), (*by_y, *by_x)


def bending_rows(frame: CellMap) -> tuple[tuple[Varying, ...], ...]:
    """determinant² · κ by (w_ξξ, w_ηη, w_ξη)."""
    (a, b), (c, d) = frame.by_x, frame.by_y
    return (
        (scaled(times(a, a), -1), scaled(times(b, b), -1), scaled(times(a, b), -2)),
        (scaled(times(c, c), -1), scaled(times(d, d), -1), scaled(times(c, d), -2)),
        (
            scaled(times(a, c), -2),
            scaled(times(b, d), -2),
            scaled((*times(a, d), *times(b, c)), -2),
        ),
    )


def constant(varying: Varying) -> Scalar:
    """The value where nothing varies, as in an affine cell."""
    total: Scalar = 0
    for polynomial, factor in varying:
        total = total + polynomial.get((0, 0), Fraction(0)) * factor
    return total

"""Squares: Q4, Q8, Q9 and Q12 for the membrane, the Bogner-Fox-Schmit rectangle for bending.

In: nothing. Out: elements. Never: anything that is not in the papers named.

The membranes are isoparametric with straight sides: x and y are bilinear in ξ and η. The bending rectangle has its
sides along x and y, as its unknowns w_x, w_y and w_xy are along its own sides only there.
"""

from collections.abc import Callable, Sequence
from fractions import Fraction

import sympy as sp

from lamc.plates.elements.definition import CORNERS, SQUARE, Element, Node, corners, edges, eta, side, xi

_PLANE = ("u", "v")
_CORNERS = corners(SQUARE, _PLANE)
_MIDDLES = edges(SQUARE, _PLANE)
_THIRDS = edges(SQUARE, _PLANE, (Fraction(1, 3), Fraction(2, 3)))
_CENTRE = (Node((Fraction(0), Fraction(0)), _PLANE),)
_SOURCE = "O. C. Zienkiewicz, R. L. Taylor, The Finite Element Method, 5th ed. 2000, vol. 1, section 8"


def _rational(number: Fraction) -> sp.Rational:
    return sp.Rational(number.numerator, number.denominator)


def _membrane(
    name: str, nodes: Sequence[Node], shape: Callable[[Node], sp.Expr], degree: int, source: str = _SOURCE
) -> Element:
    functions = [shape(node) for node in nodes]
    return Element(name, SQUARE, nodes, u=functions, v=functions, degree=degree, source=source)


def _q4(node: Node) -> sp.Expr:
    a, b = map(_rational, node.at)
    return (1 + a * xi) * (1 + b * eta) / 4


def _q8(node: Node) -> sp.Expr:
    a, b = map(_rational, node.at)
    if a == 0:
        return (1 - xi**2) * (1 + b * eta) / 2
    if b == 0:
        return (1 + a * xi) * (1 - eta**2) / 2
    return (1 + a * xi) * (1 + b * eta) * (a * xi + b * eta - 1) / 4


def _parabola(t: sp.Symbol, at: sp.Rational) -> sp.Expr:
    """1 at `at`, 0 at the other two of -1, 0, 1."""
    return 1 - t**2 if at == 0 else t * (t + at) / 2


def _q9(node: Node) -> sp.Expr:
    a, b = map(_rational, node.at)
    return _parabola(xi, a) * _parabola(eta, b)


def _q12(node: Node) -> sp.Expr:
    a, b = map(_rational, node.at)
    if abs(a) != 1:
        return sp.Rational(9, 32) * (1 - xi**2) * (1 + 9 * a * xi) * (1 + b * eta)
    if abs(b) != 1:
        return sp.Rational(9, 32) * (1 - eta**2) * (1 + 9 * b * eta) * (1 + a * xi)
    return (1 + a * xi) * (1 + b * eta) * (9 * (xi**2 + eta**2) - 10) / 32


def _hermite(t: sp.Symbol, at: int) -> tuple[sp.Expr, sp.Expr]:
    """Cubics on [-1, 1] with value 1, and with slope 1, at the end `at` and nothing else at the ends."""
    return (2 + 3 * at * t - at * t**3) / 4, (t + at) ** 2 * (t - at) / 4


def _bfs() -> Element:
    half_width, half_height = side("x", 2, 1) / 2, side("y", 4, 1) / 2
    functions = []
    for a, b in CORNERS[SQUARE]:
        (value_x, slope_x), (value_y, slope_y) = _hermite(xi, a), _hermite(eta, b)
        functions += [
            value_x * value_y,
            half_width * slope_x * value_y,
            half_height * value_x * slope_y,
            half_width * half_height * slope_x * slope_y,
        ]
    return Element(
        "bfs",
        SQUARE,
        corners(SQUARE, ("w", "w_x", "w_y", "w_xy")),
        w=tuple(functions),
        degree=6,
        source="F. K. Bogner, R. L. Fox, L. A. Schmit, Proc. Conf. Matrix Methods in Structural Mechanics, "
        "Wright-Patterson AFB, 1965",
    )


Q4 = _membrane("q4", _CORNERS, _q4, 2, "I. C. Taig, English Electric Rep. S017, 1961")
Q8 = _membrane("q8", (*_CORNERS, *_MIDDLES), _q8, 4)
Q9 = _membrane("q9", (*_CORNERS, *_MIDDLES, *_CENTRE), _q9, 4)
Q12 = _membrane("q12", (*_CORNERS, *_THIRDS), _q12, 6)
BFS = _bfs()

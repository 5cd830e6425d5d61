"""Triangles: BCIZ, DKT, Specht and DKMT for bending, CST and LST for the membrane.

In: nothing. Out: elements. Never: anything that is not in the papers named.

The slope of an edge's end i relative to its chord, turned from i to j, is ψ_ij = x_ji w_x,i + y_ji w_y,i - (w_j - w_i).
Along an edge every w here is the cubic of its ends' deflections and slopes: w_i L_i + w_j L_j + ψ_ij L_i² L_j +
ψ_ji L_j² L_i. The elements differ in what the edges' functions are inside.
"""

from collections.abc import Mapping
from dataclasses import replace

import sympy as sp

from lamc.plates.elements.definition import L1, L2, L3, TRIANGLE, Element, corners, edges, side

_L = (L1, L2, L3)
_EDGES = ((0, 1), (1, 2), (2, 0))
_BUBBLE = L1 * L2 * L3
_HALF = sp.Rational(1, 2)
_BENDING = corners(TRIANGLE, ("w", "w_x", "w_y"))


def _deflection(ends: Mapping[tuple[int, int], sp.Expr]) -> tuple[sp.Expr, ...]:
    """Shape functions of w from the functions that the ψ_ij multiply."""
    functions = []
    for i in range(3):
        others = [j for j in range(3) if j != i]
        functions.append(_L[i] + sum(ends[i, j] - ends[j, i] for j in others))
        functions += [sum(side(axis, j + 1, i + 1) * ends[i, j] for j in others) for axis in "xy"]
    return tuple(functions)


def _bciz() -> Element:
    ends = {(i, j): _L[i] ** 2 * _L[j] + _HALF * _BUBBLE for i in range(3) for j in range(3) if i != j}
    return Element(
        "bciz",
        TRIANGLE,
        _BENDING,
        w=_deflection(ends),
        source="G. P. Bazeley, Y. K. Cheung, B. M. Irons, O. C. Zienkiewicz, Proc. Conf. Matrix Methods in Structural "
        "Mechanics, Wright-Patterson AFB, 1965",
    )


def _dkt(cubic: Element) -> Element:
    """Slopes: linear between the corners, and along each edge a parabola that makes its middle that of the cubic.

    The edge's bow α = w_j - w_i - (x_ji, y_ji)·(slopes at i + slopes at j)/2 adds 6 L_i L_j α / length² times the edge.
    Inside, w is not defined; loads and mass take BCIZ's cubic, which is the same on the edges.
    """
    w, w_x, w_y = (cubic.unknowns[k::3] for k in range(3))
    geometry: dict[sp.Symbol, sp.Expr] = {}
    amounts: list[sp.Expr] = [*w_x, *w_y]
    zero = sp.Integer(0)
    by_x: list[sp.Expr] = [*_L, zero, zero, zero]
    by_y: list[sp.Expr] = [zero, zero, zero, *_L]
    for i, j in _EDGES:
        x, y = side("x", j + 1, i + 1), side("y", j + 1, i + 1)
        inverse, along_x, along_y = sp.symbols(f"r{i + 1}{j + 1} a{i + 1}{j + 1} b{i + 1}{j + 1}", real=True)
        geometry |= {inverse: 1 / (x**2 + y**2), along_x: inverse * x, along_y: inverse * y}
        amounts.append(w[j] - w[i] - _HALF * x * (w_x[i] + w_x[j]) - _HALF * y * (w_y[i] + w_y[j]))
        by_x.append(6 * along_x * _L[i] * _L[j])
        by_y.append(6 * along_y * _L[i] * _L[j])
    return Element(
        "dkt",
        TRIANGLE,
        _BENDING,
        w=cubic.w,
        slopes=(tuple(by_x), tuple(by_y)),
        source="J.-L. Batoz, K.-J. Bathe, L.-W. Ho, Int. J. Numer. Meth. Engng 15, 1980; J.-L. Batoz, ibid. 18, 1982",
        geometry=geometry,
        amounts=tuple(amounts),
    )


def _specht() -> Element:
    """Bubbles are added to BCIZ's kind of edge functions such that mean slopes across edges agree between elements."""
    geometry: dict[sp.Symbol, sp.Expr] = {}
    lengths = []
    for k in range(3):  # edge opposite corner k
        i, j = (k + 1) % 3, (k + 2) % 3
        length = sp.Symbol(f"q{k + 1}", real=True)
        geometry[length] = side("x", j + 1, i + 1) ** 2 + side("y", j + 1, i + 1) ** 2
        lengths.append(length)
    ends: dict[tuple[int, int], sp.Expr] = {}
    for i, j in _EDGES:
        k = 3 - i - j
        mu = sp.Symbol(f"m{k + 1}", real=True)
        geometry[mu] = (lengths[j] - lengths[i]) / lengths[k]
        inner = 3 * (1 - mu) * _L[i] - (1 + 3 * mu) * _L[j] + (1 + 3 * mu) * _L[k]
        ends[i, j] = _L[i] ** 2 * _L[j] + _HALF * _BUBBLE * inner
        ends[j, i] = _L[i] * _L[j] - ends[i, j]
    return Element(
        "specht",
        TRIANGLE,
        _BENDING,
        w=_deflection(ends),
        degree=4,
        source="B. Specht, Int. J. Numer. Meth. Engng 26, 1988",
        geometry=geometry,
    )


def _dkmt(thin: Element) -> Element:
    """DKT with shear (`sheared.py`). The deflection that loads, mass and membrane forces meet is a parabola along
    edges, w_i L_i + ½ (edge)·(slope_i - slope_j) L_i L_j: exact for constant curvature with any constant shear,
    where BCIZ's cubic would have the slopes of the cross-section."""
    ends = {(i, j): _HALF * _L[i] * _L[j] for i in range(3) for j in range(3) if i != j}
    return replace(
        thin,
        name="dkmt",
        w=_deflection(ends),
        source="I. Katili, Int. J. Numer. Meth. Engng 36, 1993, 1859-1883",
        shear=True,
    )


CST = Element(
    "cst",
    TRIANGLE,
    corners(TRIANGLE, ("u", "v")),
    u=_L,
    v=_L,
    degree=0,
    source="M. J. Turner, R. W. Clough, H. C. Martin, L. J. Topp, J. Aeronaut. Sci. 23, 1956",
)
_QUADRATIC = (*(L * (2 * L - 1) for L in _L), *(4 * _L[i] * _L[j] for i, j in _EDGES))
LST = Element(
    "lst",
    TRIANGLE,
    (*corners(TRIANGLE, ("u", "v")), *edges(TRIANGLE, ("u", "v"))),
    u=_QUADRATIC,
    v=_QUADRATIC,
    source="B. M. Fraeijs de Veubeke, in: Stress Analysis, Wiley 1965",
)
BCIZ = _bciz()
DKT = _dkt(BCIZ)
DKMT = _dkmt(DKT)
SPECHT = _specht()

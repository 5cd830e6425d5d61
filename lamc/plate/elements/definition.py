"""What a finite element is: nodes, unknowns, and the shape functions between them.

In: sympy expressions in natural coordinates and corner coordinates. Out: the record that everything else is derived
from. Never: numbers, stiffness, C.

Triangles have area coordinates L1, L2, L3, with ξ = L2 and η = L3; squares have ξ and η in [-1, 1]. Corner k of a cell
is at (x_k, y_k), counter-clockwise from (ξ, η) = (0, 0) or (-1, -1). Edge k runs from corner k to the next. x21 is
short for x2 - x1, and so on for every pair of corners.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from types import MappingProxyType

import sympy as sp

TRIANGLE, SQUARE = "triangle", "square"
CORNERS: dict[str, tuple[tuple[int, int], ...]] = {
    TRIANGLE: ((0, 0), (1, 0), (0, 1)),
    SQUARE: ((-1, -1), (1, -1), (1, 1), (-1, 1)),
}
DOFS = ("u", "v", "w", "w_x", "w_y", "w_xy")  # m, m, m, -, -, 1/m; the order in which a node has them

xi, eta = sp.symbols("xi eta", real=True)
L1, L2, L3 = 1 - xi - eta, xi, eta
x1, y1, x2, y2, x3, y3, x4, y4 = sp.symbols("x1 y1 x2 y2 x3 y3 x4 y4", real=True)


def side(axis: str, end: int, start: int) -> sp.Symbol:
    """x21 for side("x", 2, 1): how far corner `end` lies from corner `start` along an axis; corners count from 1."""
    return sp.Symbol(f"{axis}{end}{start}", real=True)


@dataclass(frozen=True)
class Node:
    """A place in the cell and the unknowns that live there."""

    at: tuple[Fraction, Fraction]  # ξ, η
    dofs: tuple[str, ...]  # of DOFS, in that order


@dataclass(frozen=True)
class Element:
    """Shape functions, one per unknown: node by node, in the order of each node's dofs.

    u, v      displacement in the plane; empty for an element that only bends
    w         deflection; empty for a membrane
    slopes    (w_x, w_y) where they have shape functions of their own (DKT); empty: the gradient of w
    degree    polynomials in ξ, η up to this are integrated exactly for the stiffness of a cell whose sides are not
              parallel; all other integrals are exact
    geometry  symbols of the element's own for functions of the corner coordinates, such as 1/length²; what is not a
              polynomial in the coordinates must be written so
    amounts   combinations of the unknowns (symbols of `unknowns`) that `slopes` are written in, one pair of shape
              functions each; empty: the unknowns themselves
    """

    name: str
    cell: str
    nodes: Sequence[Node]
    u: Sequence[sp.Expr] = ()
    v: Sequence[sp.Expr] = ()
    w: Sequence[sp.Expr] = ()
    slopes: Sequence[Sequence[sp.Expr]] = ()
    degree: int = 2
    source: str = ""
    geometry: Mapping[sp.Symbol, sp.Expr] = field(default_factory=lambda: MappingProxyType({}))
    amounts: Sequence[sp.Expr] = ()

    @property
    def dofs(self) -> tuple[str, ...]:
        """The unknowns' names, in order."""
        return tuple(dof for node in self.nodes for dof in node.dofs)

    @property
    def unknowns(self) -> tuple[sp.Symbol, ...]:
        """The unknowns as symbols: w1, w_x1, …, numbered as the nodes are, from 1."""
        return tuple(
            sp.Symbol(f"{dof}{number}", real=True)
            for number, node in enumerate(self.nodes, start=1)
            for dof in node.dofs
        )

    @property
    def corner_count(self) -> int:
        return len(CORNERS[self.cell])

    @property
    def stretches(self) -> bool:
        """Whether it has displacements in the plane."""
        return bool(self.u)

    @property
    def bends(self) -> bool:
        """Whether it has a deflection."""
        return bool(self.w) or bool(self.slopes)

    @property
    def is_affine(self) -> bool:
        """Whether ξ and η are linear in x and y: triangles, and rectangles along the axes, which bending needs."""
        return self.cell == TRIANGLE or self.bends

    @property
    def fields(self) -> tuple[str, ...]:
        """The displacements that it has, of u, v, w."""
        return ("u", "v") * self.stretches + ("w",) * self.bends


def corners(cell: str, dofs: Sequence[str]) -> tuple[Node, ...]:
    """A node with `dofs` at every corner of a cell ("triangle" or "square")."""
    return tuple(Node((Fraction(a), Fraction(b)), tuple(dofs)) for a, b in CORNERS[cell])


def edges(cell: str, dofs: Sequence[str], at: Sequence[Fraction] = (Fraction(1, 2),)) -> tuple[Node, ...]:
    """Nodes with `dofs` on every edge, at these parts of its way from corner k to the next."""
    ends = CORNERS[cell]
    return tuple(
        Node((p[0] + (q[0] - p[0]) * part, p[1] + (q[1] - p[1]) * part), tuple(dofs))
        for p, q in zip(ends, ends[1:] + ends[:1], strict=True)
        for part in at
    )

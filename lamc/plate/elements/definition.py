"""What a finite element is: nodes, unknowns, and the shape functions between them.

In: sympy expressions in natural coordinates and corner coordinates. Out: the record that everything else is derived
from. Never: numbers, stiffness, C.

Triangles have area coordinates L1, L2, L3, with ξ = L2 and η = L3; squares have ξ and η in [-1, 1]. Corner k of a cell
is at (x_k, y_k), counter-clockwise from (ξ, η) = (0, 0) or (-1, -1). Edge k runs from corner k to the next.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

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


@dataclass(frozen=True)
class Node:
    """A place in the cell and the unknowns that live there."""

    at: tuple[Fraction, Fraction]  # ξ, η
    dofs: tuple[str, ...]  # of DOFS, in that order


@dataclass(frozen=True)
class Element:
    """Shape functions, one per unknown: node by node, in the order of each node's dofs.

    u, v    displacement in the plane; empty for an element that only bends
    w       deflection; empty for a membrane
    slopes  (w_x, w_y) where they have shape functions of their own (DKT); empty: the gradient of w
    degree  polynomials in ξ, η up to this are integrated exactly for the stiffness
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

    @property
    def dofs(self) -> tuple[str, ...]:
        """The unknowns' names, in order."""
        return tuple(dof for node in self.nodes for dof in node.dofs)

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

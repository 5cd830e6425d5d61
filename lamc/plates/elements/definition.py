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
from typing import Any

import sympy as sp

from lamc.basics.checks import checked_name, checked_records, shown
from lamc.basics.errors import DesignError
from lamc.basics.once import lazy
from lamc.basics.readonly import ReadOnlyDict

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
    """A place in the cell and the unknowns that live there. Raises DesignError for unknowns that are not in DOFS."""

    at: tuple[Fraction, Fraction]  # ξ, η
    dofs: tuple[str, ...]  # of DOFS, in that order

    def __post_init__(self) -> None:
        try:
            a, b = (Fraction(part) for part in self.at)
        except (TypeError, ValueError, OverflowError) as error:
            raise DesignError(
                f"a node of an element is at {shown(self.at)}; give its ξ and η, two numbers"
            ) from error
        dofs = (self.dofs,) if isinstance(self.dofs, str) else tuple(self.dofs)
        if not dofs or list(dofs) != [name for name in DOFS if name in dofs]:
            raise DesignError(
                f"a node of an element has the unknowns {shown(dofs)}; name some of {', '.join(DOFS)}, in this order"
            )
        object.__setattr__(self, "at", (a, b))
        object.__setattr__(self, "dofs", dofs)


@dataclass(frozen=True)
class Element:
    """Shape functions, one per unknown: node by node, in the order of each node's dofs.

    u, v      displacement in the plane; empty for an element that only bends. One function per unknown, or per
              unknown of that name only
    w         deflection; empty for a membrane. One function per unknown, or per unknown of w, w_x, w_y, w_xy only
    slopes    (w_x, w_y) where they have shape functions of their own (DKT); empty: the gradient of w. With these, w
              serves loads and mass only
    degree    polynomials in ξ, η up to this are integrated exactly for the stiffness of a cell whose sides are not
              parallel; all other integrals are exact
    geometry  symbols of the element's own for functions of the corner coordinates, such as 1/length²; what is not a
              polynomial in the coordinates must be written so
    amounts   combinations of the unknowns (symbols of `unknowns`) that `slopes` are written in, one pair of shape
              functions each; empty: the unknowns themselves
    shear     whether it is sheared through its thickness (DKMT): w_x and w_y are then slopes of the cross-section, not
              of w, and the last three amounts, the edges' bows, are shared between bending and shear (`sheared.py`)

    Raises DesignError for text in place of sympy expressions, and for shape functions of another number than the
    unknowns. Whether the functions fit the nodes is checked before anything is derived; see `checks.py`.
    """

    name: str
    cell: str  # "triangle" or "square"
    nodes: Sequence[Node]
    u: Sequence[sp.Expr] = ()
    v: Sequence[sp.Expr] = ()
    w: Sequence[sp.Expr] = ()
    slopes: Sequence[Sequence[sp.Expr]] = ()
    degree: int = 2
    source: str = ""
    geometry: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    amounts: Sequence[sp.Expr] = ()
    shear: bool = False

    def __post_init__(self) -> None:
        checked_name(self.name, "an element")
        if self.cell not in CORNERS:
            raise DesignError(
                f"element {self.name!r} has the cell {shown(self.cell)}; it must be one of {', '.join(CORNERS)}"
            )
        if isinstance(self.degree, bool) or not isinstance(self.degree, int) or self.degree < 0:
            raise DesignError(
                f"element {self.name!r} has the degree {shown(self.degree)}; it must be a whole number, 0 or more"
            )
        self._put("nodes", checked_records(self.nodes, Node, "nodes", f"element {self.name!r}"))
        self._put("amounts", self._expressions("amounts", self.amounts))
        for name, own in (("u", ("u",)), ("v", ("v",)), ("w", DOFS[2:])):
            self._put(name, self._spread(name, own))
        self._put("slopes", tuple(self._expressions("slopes", part) for part in self.slopes))
        self._put(
            "geometry",
            ReadOnlyDict(
                zip(self.geometry, self._expressions("geometry", self.geometry.values()), strict=True)
            ),
        )
        self._check_fields()

    @lazy
    def written(self) -> str:
        """The whole element as text, which takes sympy some 30 ms to write."""
        return repr(self)

    def _put(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)

    def _expressions(self, name: str, values: Any) -> tuple[sp.Expr, ...]:
        found = []
        for value in values:
            if not isinstance(value, sp.Expr | int | float | Fraction):
                raise DesignError(
                    f"element {self.name!r} has {shown(value)} in {name}; give sympy expressions in xi and eta"
                )
            expr = _exact(value)
            if expr.has(sp.nan, sp.oo, -sp.oo, sp.zoo):
                raise DesignError(f"element {self.name!r} has {expr} in {name}; every number must be finite")
            # Symbols are known by name, whatever a user assumed of his.
            found.append(expr.xreplace({s: sp.Symbol(s.name, real=True) for s in expr.free_symbols}))
        return tuple(found)

    def _spread(self, name: str, own: Sequence[str]) -> tuple[sp.Expr, ...]:
        """The shape functions of a field, one per unknown."""
        given = self._expressions(name, getattr(self, name))
        dofs = self.dofs
        count = sum(dof in own for dof in dofs)
        if not given or len(given) == len(dofs):
            return given
        if len(given) != count:
            raise DesignError(
                f"element {self.name!r} has {len(given)} shape functions for {name}; its nodes have {count} unknowns "
                f"of {', '.join(own)}, and {len(dofs)} altogether: give one function each"
            )
        each = iter(given)
        return tuple(next(each) if dof in own else sp.Integer(0) for dof in dofs)

    def _check_fields(self) -> None:
        there = {name: bool(getattr(self, name)) for name in ("u", "v", "w")}
        if not any(there.values()) or there["u"] != there["v"]:
            given = ", ".join(name for name in there if there[name]) or "nothing"
            raise DesignError(
                f"element {self.name!r} has shape functions for {given}; "
                "an element stretches (u and v), bends (w), or both"
            )
        for name in there:
            if there[name] != any(dof[0] == name for dof in self.dofs):
                raise DesignError(
                    f"element {self.name!r} has {'shape functions' if there[name] else 'unknowns'} for {name}, and no "
                    f"{'unknowns' if there[name] else 'shape functions'}; give both or neither"
                )
        for amount in self.amounts:
            unknowns = self.unknowns
            weights = [sp.diff(amount, d) for d in unknowns]
            if any(weight.has(*unknowns) for weight in weights) or amount.xreplace(
                dict.fromkeys(unknowns, sp.S.Zero)
            ):
                raise DesignError(
                    f"element {self.name!r} has the amount {amount}; it must be linear in the unknowns, which are "
                    f"{', '.join(map(str, unknowns))}"
                )
        count = len(self.amounts or self.dofs)
        counts = [len(part) for part in self.slopes]
        if self.amounts and not self.slopes:
            raise DesignError(
                f"element {self.name!r} has amounts and no slopes; only slopes are written in amounts"
            )
        if self.shear and (self.cell != TRIANGLE or len(self.amounts) < 4):
            raise DesignError(
                f"element {self.name!r} has shear and {len(self.amounts)} amounts on {self.cell}s; it needs triangles, "
                "and amounts of which the last three are the bows of the edges 1-2, 2-3 and 3-1"
            )
        if self.slopes and (not self.w or counts != [count, count]):
            raise DesignError(
                f"element {self.name!r} has slopes of {counts} shape functions; "
                f"it needs w, and functions for w_x and for w_y, {count} each"
            )

    @property
    def dofs(self) -> tuple[str, ...]:
        """The unknowns' names, in order."""
        return tuple(dof for node in self.nodes for dof in node.dofs)

    @property
    def unknowns(self) -> tuple[sp.Symbol, ...]:
        """The unknowns as symbols: w1, w_x1, …, numbered as the nodes are, from 1."""
        return symbols_of(self.nodes)

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


def _exact(value: sp.Expr | int | float | Fraction) -> sp.Expr:
    """A number as sympy's, a Fraction without rounding; nothing is parsed."""
    if isinstance(value, sp.Expr):
        return value
    if isinstance(value, float):
        return sp.Float(value)
    return sp.Rational(value.numerator, value.denominator)


def symbols_of(nodes: Sequence[Node]) -> tuple[sp.Symbol, ...]:
    """Symbols of the unknowns of `nodes`."""
    return tuple(
        sp.Symbol(f"{dof}{number}", real=True)
        for number, node in enumerate(nodes, start=1)
        for dof in node.dofs
    )


def corners(cell: str, dofs: Sequence[str]) -> tuple[Node, ...]:
    """A node with `dofs` at every corner of a cell ("triangle" or "square")."""
    return tuple(Node((Fraction(a), Fraction(b)), tuple(dofs)) for a, b in _corners_of(cell))


def _corners_of(cell: str) -> tuple[tuple[int, int], ...]:
    if cell not in CORNERS:
        raise DesignError(f"there is no cell {shown(cell)}; it must be one of {', '.join(CORNERS)}")
    return CORNERS[cell]


def edges(cell: str, dofs: Sequence[str], at: Sequence[Fraction] = (Fraction(1, 2),)) -> tuple[Node, ...]:
    """Nodes with `dofs` on every edge, at these parts of its way from corner k to the next."""
    ends = _corners_of(cell)
    return tuple(
        Node((p[0] + (q[0] - p[0]) * part, p[1] + (q[1] - p[1]) * part), tuple(dofs))
        for p, q in zip(ends, ends[1:] + ends[:1], strict=True)
        for part in at
    )

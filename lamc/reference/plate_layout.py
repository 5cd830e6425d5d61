"""Which unknowns a plate element has, and where: from its name alone.

In: "dkt", "cst", "dkt+cst", … Out: nodes and unknowns in order. Never: shape functions.
"""

from dataclasses import dataclass
from fractions import Fraction

from lamc.basics.errors import UnsupportedError

Point = tuple[Fraction, Fraction]
CORNERS: dict[str, tuple[Point, ...]] = {
    "triangle": tuple((Fraction(x), Fraction(y)) for x, y in ((0, 0), (1, 0), (0, 1))),
    "square": tuple((Fraction(x), Fraction(y)) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))),
}
TRIANGLES = ("bciz", "dkt", "specht", "cst", "lst")
SQUARES = ("bfs", "q4", "q8", "q9", "q12")
BENDING = ("bciz", "dkt", "specht", "bfs")
MEMBRANES = ("cst", "lst", "q4", "q8", "q9", "q12")
_ON_EDGES = {
    "lst": (Fraction(1, 2),),
    "q8": (Fraction(1, 2),),
    "q9": (Fraction(1, 2),),
    "q12": (Fraction(1, 3), Fraction(2, 3)),
}


@dataclass(frozen=True)
class NodeLayout:
    """A place in the cell, in natural coordinates, and the unknowns that live there."""

    at: Point
    dofs: tuple[str, ...]


@dataclass(frozen=True)
class Layout:
    """An element without its shape functions; `bending` and `membrane` name its parts, "" where it has none."""

    name: str
    cell: str
    bending: str
    membrane: str
    nodes: tuple[NodeLayout, ...]

    @property
    def dofs(self) -> tuple[str, ...]:
        """The unknowns' names, node by node."""
        return tuple(dof for node in self.nodes for dof in node.dofs)

    @property
    def corner_count(self) -> int:
        return len(CORNERS[self.cell])

    @property
    def stretches(self) -> bool:
        """Whether it has displacements in the plane."""
        return bool(self.membrane)

    @property
    def bends(self) -> bool:
        """Whether it has a deflection."""
        return bool(self.bending)


def places(cell: str, membrane: str) -> tuple[Point, ...]:
    """Nodes of a membrane: corners, then edge by edge from corner k to the next, then the middle."""
    corners = CORNERS[cell]
    nodes = list(corners)
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        nodes += [(x0 + (x1 - x0) * s, y0 + (y1 - y0) * s) for s in _ON_EDGES.get(membrane, ())]
    return tuple(nodes + [(Fraction(0), Fraction(0))] * (membrane == "q9"))


def layout(name: str) -> Layout:
    """Nodes and unknowns of the element of that name. Raises UnsupportedError with the names there are."""
    parts = name.split("+")
    bending = next((part for part in parts if part in BENDING), "")
    membrane = next((part for part in parts if part in MEMBRANES), "")
    like = all(part in TRIANGLES for part in parts) or all(part in SQUARES for part in parts)
    if not like or len(parts) != bool(bending) + bool(membrane):
        raise UnsupportedError(
            f"there is no reference element {name!r}; take one of {', '.join(BENDING + MEMBRANES)}, or two of like "
            "cells, one that bends and one that stretches, with a plus between them"
        )
    cell = "triangle" if parts[0] in TRIANGLES else "square"
    bent = ("w", "w_x", "w_y", "w_xy") if bending == "bfs" else ("w", "w_x", "w_y")
    nodes = tuple(
        NodeLayout(at, ("u", "v") * bool(membrane) + bent * (bool(bending) and at in CORNERS[cell]))
        for at in places(cell, membrane)
    )
    return Layout(name, cell, bending, membrane, nodes)

"""How much memory a problem takes, before anything of that size is made.

In: an element and a number of cells. Out: bytes. Never: a mesh, arrays.

A plane mesh has about half as many points and three halves as many edges as triangles, six of which meet at a point; as
many points and twice as many edges as quadrilaterals, four of which meet (Euler). A node meets all nodes of its cells.
"""

from dataclasses import dataclass

from lamc.plate.elements.definition import CORNERS, SQUARE, TRIANGLE, Element

# Corners, edges and cells per cell of a large mesh.
_COUNTS = {TRIANGLE: (0.5, 1.5, 1.0), SQUARE: (1.0, 2.0, 1.0)}
# Corners, edges and cells that a corner, an edge and a cell meet, themselves included.
_MET = {
    TRIANGLE: ((7, 12, 6), (4, 5, 2), (3, 3, 1)),
    SQUARE: ((9, 12, 4), (6, 7, 2), (4, 4, 1)),
}


@dataclass(frozen=True)
class Memory:
    """Of a problem, in numbers and bytes.

    unknowns  rows of the matrix
    entries   of the matrix, both triangles
    matrix    B, one sparse matrix
    assembly  B, what the assembly keeps, and the most that it needs for a moment
    """

    unknowns: int
    entries: int
    matrix: int
    assembly: int


def estimate_memory(element: Element, cell_count: int) -> Memory:
    """What `cell_count` cells of `element` take; some per cent too little for small meshes, which have more rim."""
    counts = [cell_count * each for each in _COUNTS[element.cell]]
    own = _unknowns(element)
    unknowns = sum(count * dofs for count, dofs in zip(counts, own, strict=True))
    entries = sum(
        count * dofs * sum(met * other for met, other in zip(row, own, strict=True))
        for count, dofs, row in zip(counts, own, _MET[element.cell], strict=True)
    )
    nodes, corners, size = len(element.nodes), element.corner_count, len(element.dofs)
    kept = cell_count * 4 * (corners + nodes + nodes**2 + 2)
    passing = 4 * (5 * unknowns + cell_count * (nodes + 4 * size))
    return Memory(int(unknowns), int(entries), int(12 * entries + 4 * unknowns), int(kept + passing))


def _unknowns(element: Element) -> tuple[float, float, float]:
    """Unknowns per corner, per edge and per inside of a cell."""
    at_corner = at_edge = inside = 0
    for node in element.nodes:
        xi, eta = node.at
        on_edge = 0 in (xi, eta, 1 - xi - eta) if element.cell == TRIANGLE else 1 in (abs(xi), abs(eta))
        if any(xi == a and eta == b for a, b in CORNERS[element.cell]):
            at_corner += len(node.dofs)
        elif on_edge:
            at_edge += len(node.dofs)
        else:
            inside += len(node.dofs)
    corners = element.corner_count
    return at_corner / corners, at_edge / corners, float(inside)

"""How much memory a problem takes, before anything of that size is made.

In: an element and a number of cells. Out: bytes, or a refusal where there are not so many. Never: a mesh, arrays.

A plane mesh has about half as many points and three halves as many edges as triangles, six of which meet at a point; as
many points and twice as many edges as quadrilaterals, four of which meet (Euler). A node meets all nodes of its cells.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError
from lamc.plates.elements.definition import CORNERS, SQUARE, TRIANGLE, Element
from lamc.plates.elements.library import checked_element

# Corners, edges and cells per cell of a large mesh.
_COUNTS = {TRIANGLE: (0.5, 1.5, 1.0), SQUARE: (1.0, 2.0, 1.0)}
# Corners, edges and cells that a corner, an edge and a cell meet, themselves included.
_MET = {
    TRIANGLE: ((7, 12, 6), (4, 5, 2), (3, 3, 1)),
    SQUARE: ((9, 12, 4), (6, 7, 2), (4, 4, 1)),
}
# Entries that a Cholesky factor has besides those of the matrix: so many times n log2(n) (unknowns per point)² for n
# points, where those of one edge count to the point, as a line that cuts a mesh has one edge per point. The order is
# that of nested dissection (A. George, SIAM J. Numer. Anal. 10, 1973); CHOLMOD and SuperLU came to 2.3 to 3.4 on grids
# of 14 000 and 40 000 points, and to less on smaller ones.
_FILL = 2.6
_MATRICES = 3  # at once: all unknowns, the free ones, and a copy that is scaled


@dataclass(frozen=True)
class Memory:
    """Of a problem, in numbers and bytes.

    unknowns  rows of the matrix
    entries   of the matrix, both triangles
    matrix    B, one sparse matrix
    assembly  B, what the assembly keeps, and the most that it needs for a moment
    factor    B, one triangle of the factored matrix; SuperLU makes two. Long strips take less
    """

    unknowns: int
    entries: int
    matrix: int
    assembly: int
    factor: int


def estimate_memory(element: Element | str, cell_count: int) -> Memory:
    """What `cell_count` cells of `element` take; some per cent too little for small meshes, which have more rim."""
    element = checked_element(element)
    if isinstance(cell_count, bool) or not isinstance(cell_count, int | np.integer) or cell_count < 0:
        raise DesignError(f"the number of cells is {shown(cell_count)}; it must be a whole number, 0 or more")
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
    on_line, points = own[0] + own[1], max(counts[0], 2.0)
    factor = 8 * (entries / 2 + _FILL * points * math.log2(points) * on_line**2)
    matrix = 12 * entries + 4 * unknowns
    return Memory(int(unknowns), int(entries), int(matrix), int(kept + passing), int(factor))


def check_memory(
    element: Element, cell_count: int, solver: str, available: int | None = None, *, least: bool = False
) -> None:
    """Raises DesignError where solving needs more memory than is there; `available`, B, None: what the system tells.

    least  for the message: there will be so many cells or more
    """
    free = available_memory() if available is None else available
    guessed = estimate_memory(element, cell_count)
    triangles = 2 if solver == "superlu" else 1
    needed = _MATRICES * guessed.matrix + guessed.assembly + triangles * guessed.factor
    if free is not None and needed > free:
        raise DesignError(
            f"{'at least ' * least}{cell_count} cells of element {shown(element.name)} have {guessed.unknowns} "
            f"unknowns and take some {needed / 2**30:.2g} GiB to solve with {solver}; {free / 2**30:.2g} GiB are free: "
            "mesh coarser where little happens"
        )


def available_memory() -> int | None:
    """What this process may still take, B, as Linux tells it: of the machine, or of its container; else None."""
    found = []
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        found += [1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:")]
        group = Path("/sys/fs/cgroup")
        limit = (group / "memory.max").read_text(encoding="ascii").strip()
        if limit != "max":
            found.append(int(limit) - int((group / "memory.current").read_text(encoding="ascii")))
    except (OSError, ValueError, IndexError):
        pass  # another system, or another kind of container
    return min(found) if found else None


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

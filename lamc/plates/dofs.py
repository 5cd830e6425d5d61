"""Which unknowns an element puts on a mesh, and their numbers.

In: a mesh and an element. Out: nodes, the unknowns that live on each, and for every cell the numbers of its unknowns in
the element's own order. Never: stiffness, supports.

Nodes are the mesh's points first, in its order; then those on edges, edge by edge in the order of `mesh.edges`, each
from the end with the lower number to the other; then those inside cells; then copies along hinge lines (`doubling.py`).
Unknowns are numbered node by node, at each node in the order of `definition.DOFS`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from lamc.basics.checks import Array, shown
from lamc.basics.errors import DesignError
from lamc.plates.doubling import doubled
from lamc.plates.elements.cells import check_cells
from lamc.plates.elements.definition import CORNERS, DOFS, TRIANGLE, Element, Node
from lamc.plates.meshing.mesh import Integers, Mesh

_MOST = np.iinfo(np.int32).max  # sparse matrices index by int32
_KINDS = {3: "triangles", 4: "quadrilaterals"}

Place = tuple[str, int, Fraction]  # "corner", "edge" or "cell"; which one; how far along the edge, 0 to 1


@dataclass(frozen=True, eq=False)
class Dofs:
    """The unknowns of `element` on `mesh`.

    hinges    numbers of edges of the mesh across which slopes may jump: each side has nodes of its own
    origin    (nodes,) int32: the node that each is a copy of; of all others their own number

    points    (nodes, 2), m
    of_nodes  (m, k) int32: nodes of the cells, in the element's order
    of_cells  (m, nd) int32: numbers of the cells' unknowns, in the element's order
    table     (nodes, 6) int32: number of each unknown of DOFS at each node, -1 where the node has none

    Raises DesignError where the element is for cells of another kind or shape, where its nodes on an edge would not
    meet those of the neighbour, and where there are more unknowns than an int32 counts.
    """

    mesh: Mesh
    element: Element
    hinges: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int32), repr=False)
    origin: Integers = field(init=False, repr=False)
    points: Array = field(init=False, repr=False)
    of_nodes: Integers = field(init=False, repr=False)
    of_cells: Integers = field(init=False, repr=False)
    table: Integers = field(init=False, repr=False)

    def __post_init__(self) -> None:
        corners = len(CORNERS[self.element.cell])
        if self.mesh.corner_count != corners:
            raise DesignError(
                f"element {shown(self.element.name)} is for {_KINDS[corners]}, and the mesh has "
                f"{_KINDS[self.mesh.corner_count]}; choose an element for these, or mesh anew"
            )
        check_cells(self.element, self.mesh.corners)
        of_nodes, points, edge_of = _nodes(self.mesh, self.element)
        origin = np.arange(len(points), dtype=np.int32)
        if len(self.hinges):
            slopes = np.array(["w_x" in node.dofs or "w_y" in node.dofs for node in self.element.nodes])
            of_nodes, copied = doubled(self.mesh, of_nodes, edge_of, slopes, self.hinges)
            origin, points = np.concatenate([origin, copied]), np.concatenate([points, points[copied]])
        has = np.zeros((len(points), len(DOFS)), dtype=bool)
        for k, node in enumerate(self.element.nodes):
            for name in node.dofs:
                has[of_nodes[:, k], DOFS.index(name)] = True
        count = int(np.count_nonzero(has))
        if count > _MOST:
            raise DesignError(
                f"a mesh of {len(self.mesh.cells)} cells has {count} unknowns with element "
                f"{shown(self.element.name)}; at most {_MOST} can be numbered: mesh coarser"
            )
        table = np.full(has.shape, -1, dtype=np.int32)
        table[has] = np.arange(count, dtype=np.int32)
        columns = [
            table[of_nodes[:, k], DOFS.index(name)]
            for k, node in enumerate(self.element.nodes)
            for name in node.dofs
        ]
        of_cells = np.ascontiguousarray(np.stack(columns, axis=1))
        for name, value in (
            ("origin", origin),
            ("points", points),
            ("of_nodes", of_nodes),
            ("of_cells", of_cells),
            ("table", table),
        ):
            value.flags.writeable = False
            object.__setattr__(self, name, value)

    @property
    def count(self) -> int:
        """How many unknowns there are."""
        return int(self.table.max()) + 1

    @property
    def names(self) -> tuple[str, ...]:
        """The unknowns that some node has, in the order of DOFS."""
        return tuple(name for k, name in enumerate(DOFS) if (self.table[:, k] >= 0).any())

    def of(self, name: str) -> Integers:
        """Numbers of the unknown `name` at all nodes, shape (nodes,), -1 where a node has none."""
        return np.asarray(self.table[:, DOFS.index(name)])

    @property
    def of_corners(self) -> Integers:
        """What tells apart the corners of cells that are one point of one part of the plate, (m, corners): the mesh's
        points, and copies of these along hinge lines."""
        if not len(self.hinges):
            return self.mesh.cells
        places = [_place(self.element.cell, node)[:2] for node in self.element.nodes]
        return self.of_nodes[:, [places.index(("corner", c)) for c in range(self.mesh.corner_count)]]

    def on_edges(self, cells: Integers, edges: Integers) -> Integers:
        """Nodes on edge `edges[i]` of cell `cells[i]`, both ends included, shape (len(cells), nodes of an edge)."""
        own = edge_nodes(self.element)
        local = np.array(own, dtype=np.int32)[edges]
        return np.asarray(self.of_nodes[cells[:, None], local])


def edge_nodes(element: Element) -> tuple[tuple[int, ...], ...]:
    """For every edge of a cell the element's nodes on it, from its first corner to its last."""
    corners = len(CORNERS[element.cell])
    places = [_place(element.cell, node) for node in element.nodes]
    result = []
    for edge in range(corners):
        on: list[tuple[Fraction, int]] = []
        for k, (kind, which, along) in enumerate(places):
            if kind == "edge" and which == edge:
                on.append((along, k))
            elif kind == "corner" and which == edge:
                on.append((Fraction(0), k))
            elif kind == "corner" and which == (edge + 1) % corners:
                on.append((Fraction(1), k))
        result.append(tuple(k for _, k in sorted(on)))
    return tuple(result)


def _place(cell: str, node: Node) -> Place:
    """Where in a cell a node lies."""
    a, b = (Fraction(value) for value in node.at)
    corners = [(Fraction(x), Fraction(y)) for x, y in CORNERS[cell]]
    if (a, b) in corners:
        return "corner", corners.index((a, b)), Fraction(0)
    distances: tuple[Fraction, ...] = (b, 1 - a - b, a)
    along: tuple[Fraction, ...] = (a, b, 1 - b)
    if cell != TRIANGLE:
        distances = (b + 1, 1 - a, 1 - b, a + 1)
        along = ((a + 1) / 2, (b + 1) / 2, (1 - a) / 2, (1 - b) / 2)
    if 0 in distances:
        edge = distances.index(Fraction(0))
        return "edge", edge, along[edge]
    return "cell", 0, Fraction(0)


def _nodes(mesh: Mesh, element: Element) -> tuple[Integers, Array, Integers]:
    """Nodes of the cells, (m, k), where all nodes are, (nodes, 2), and the edge of those between its ends, (nodes,), -1
    for others."""
    places = [_place(element.cell, node) for node in element.nodes]
    corners = mesh.corner_count
    per_edge = _checked_edges(element, places, corners)
    inner = [k for k, place in enumerate(places) if place[0] == "cell"]
    m, n = mesh.cells.shape[0], len(mesh.points)
    edge_count = len(mesh.edges) if per_edge else 0
    of_nodes = np.empty((m, len(places)), dtype=np.int64)
    points = np.empty((n + edge_count * len(per_edge) + m * len(inner), 2))
    points[:n] = mesh.points
    forward = mesh.cells < np.roll(mesh.cells, -1, axis=1)  # edge k runs from the lower end to the higher
    for k, (kind, which, along) in enumerate(places):
        if kind == "corner":
            of_nodes[:, k] = mesh.cells[:, which]
            continue
        if kind == "edge":
            slot = np.where(forward[:, which], per_edge.index(along), per_edge.index(1 - along))
            of_nodes[:, k] = n + mesh.cell_edges[:, which].astype(np.int64) * len(per_edge) + slot
        else:
            start = n + edge_count * len(per_edge)
            of_nodes[:, k] = start + np.arange(m) * len(inner) + inner.index(k)
        points[of_nodes[:, k]] = mapped(
            element.cell, mesh.corners, np.array(element.nodes[k].at, dtype=float)
        )
    edge_of = np.full(len(points), -1, dtype=np.int32)
    edge_of[n : n + edge_count * len(per_edge)] = np.repeat(np.arange(edge_count), len(per_edge))
    return of_nodes.astype(np.int32), points, edge_of


def _checked_edges(element: Element, places: Sequence[Place], corners: int) -> list[Fraction]:
    """Where along an edge its own nodes lie, ascending: the same on every edge, and from either end."""
    kinds = [
        [(place[2], element.nodes[k].dofs) for k, place in enumerate(places) if place[:2] == ("edge", edge)]
        for edge in range(corners)
    ]
    first = sorted(kinds[0])
    rotated = sorted((1 - along, dofs) for along, dofs in first)
    if rotated != first or any(sorted(kind) != first for kind in kinds):
        raise DesignError(
            f"element {shown(element.name)} does not have the same nodes on every edge, seen from either end; cells "
            "would not fit together: give every edge the same, symmetric about its middle"
        )
    return [along for along, _ in first]


def mapped(cell: str, corners: Array, at: Array) -> Array:
    """Places at natural coordinates `at`, (2,) or (m, 2), in cells with `corners`, (m, c, 2); shape (m, 2), m."""
    xi, eta = np.moveaxis(np.broadcast_to(at, (len(corners), 2)), 1, 0)
    if cell == TRIANGLE:
        weights = np.stack([1.0 - xi - eta, xi, eta], axis=1)
    else:
        weights = 0.25 * np.stack([(1 + a * xi) * (1 + b * eta) for a, b in CORNERS[cell]], axis=1)
    return np.asarray(np.einsum("mc,mci->mi", weights, corners))

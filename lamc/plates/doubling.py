"""Nodes along hinge lines, one for each side.

In: the nodes of a mesh's cells, and the edges that are hinges. Out: the same with a node of its own for every part of
the plate that meets at a point of a hinge. Never: what ties them together; `solving/ties.py` does.

About a point, cells that share an edge which is no hinge are one part: two at an inner point of a line, as many as
lines where several meet, one where a line ends inside the plate. The first part, that of the lowest cell, keeps the
node; copies for the others follow after all nodes, in the order of nodes and of parts.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from lamc.basics.errors import DesignError
from lamc.plates.meshing.checks import place
from lamc.plates.meshing.mesh import Integers, Mesh


def doubled(
    mesh: Mesh, of_nodes: Integers, edge_of: Integers, slopes: NDArray[np.bool_], hinges: Integers
) -> tuple[Integers, Integers]:
    """Nodes of the cells with copies, (m, k), and the nodes that the copies are of, (copies,).

    of_nodes  (m, k): nodes of the cells without copies; the mesh's points have the lowest numbers
    edge_of   (nodes,): the edge of nodes between its ends, -1 for all others
    slopes    (k,): which nodes of an element have slopes; the others need no copy
    hinges    edges, numbers into `mesh.edges`

    Raises DesignError where a hinge passes a point at which parts of the plate touch without an edge in common.
    """
    is_hinge = np.zeros(len(mesh.edges), dtype=bool)
    is_hinge[hinges] = True
    touched = np.zeros(len(mesh.points), dtype=bool)
    touched[mesh.edges[hinges]] = True
    _check_fans(mesh, touched)
    part = np.full(of_nodes.shape, -1, dtype=np.int64)  # of the node of each cell, where there may be several
    parts = parts_of_fans(mesh, ~is_hinge)
    for c in range(mesh.corner_count):
        corner = mesh.cells[:, c]
        part += (of_nodes == corner[:, None]) * (touched[corner] * (parts[:, c] + 1))[:, None]
    edge = edge_of[of_nodes]
    between = (edge >= 0) & is_hinge[edge]
    part[between] = np.nonzero(between)[0]  # between the ends of an edge its two cells are the parts
    part[:, ~slopes] = -1
    cell, slot = np.nonzero(part >= 0)
    keys = np.stack([of_nodes[cell, slot], part[cell, slot]], axis=1)
    pairs, inverse = np.unique(keys, axis=0, return_inverse=True)
    again = np.concatenate([[False], pairs[1:, 0] == pairs[:-1, 0]])
    number = pairs[:, 0].copy()
    number[again] = len(edge_of) + np.arange(np.count_nonzero(again))
    result = of_nodes.copy()
    result[cell, slot] = number[inverse.ravel()]
    return result, pairs[again, 0].astype(np.int32)


def parts_of_fans(mesh: Mesh, joins: NDArray[np.bool_]) -> NDArray[np.int64]:
    """For each corner of each cell the lowest cell of its part about that point, (m, corners); parts hang together by
    the edges that `joins` (edges,) names."""
    corners, size = mesh.corner_count, mesh.cells.size
    order = np.argsort(mesh.cell_edges.ravel(), kind="stable")
    edge = mesh.cell_edges.ravel()[order]
    pair = np.flatnonzero((edge[1:] == edge[:-1]) & joins[edge[:-1]])
    one, other = order[pair], order[pair + 1]  # cell times corners plus local edge
    # Edge k of a cell runs from its corner k to the next; in the other cell it runs the other way.
    links = np.concatenate([one, _next(one, corners)]), np.concatenate([_next(other, corners), other])
    graph = sp.coo_array((np.ones(len(links[0]), dtype=np.int8), links), shape=(size, size)).tocsr()
    count, label = connected_components(graph, directed=False)
    lowest = np.full(count, len(mesh.cells), dtype=np.int64)
    np.minimum.at(lowest, label, np.arange(size) // corners)
    return np.asarray(lowest[label].reshape(mesh.cells.shape))


def _next(at: NDArray[np.intp], corners: int) -> NDArray[np.intp]:
    return at - at % corners + (at + 1) % corners


def _check_fans(mesh: Mesh, touched: NDArray[np.bool_]) -> None:
    """Raises DesignError where parts of the plate touch at a point of a hinge without an edge in common."""
    fan = parts_of_fans(mesh, np.ones(len(mesh.edges), dtype=bool))
    least, most = np.full(len(mesh.points), len(mesh.cells)), np.full(len(mesh.points), -1)
    np.minimum.at(least, mesh.cells, fan)
    np.maximum.at(most, mesh.cells, fan)
    bad = np.flatnonzero((most > least) & touched)
    if len(bad):
        raise DesignError(
            f"a hinge line passes {place(mesh.points[bad[0]])}, where parts of the plate touch at a point only; give "
            "the neck a width, or end the line before it"
        )

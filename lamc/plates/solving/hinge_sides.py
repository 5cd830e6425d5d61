"""The two sides of every edge of a hinge line, and how much they turn against each other.

In: unknowns with copies along hinge lines. Out: nodes of both sides, and the rotation between them as a function of
the unknowns. Never: springs, supports.

The rotation is that of the side to the left of the edge less that of the right one, by their slopes along the normal to
the left, φ = w_n(left) - w_n(right): positive where both sides rise from the line, a valley. It does not depend on the
direction of the edge. Between the nodes it is the polynomial of its values there (linear for an element with slopes at
corners alone, as DKT has them), with w_xy a cubic. So it is zero all along the edge where it is zero at the nodes, and
rigid motion turns no hinge, whatever the element's own functions do between the nodes.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from lamc.basics.checks import Array
from lamc.plates.dofs import Dofs, edge_nodes
from lamc.plates.elements.definition import CORNERS
from lamc.plates.meshing.mesh import Integers


@dataclass(frozen=True, eq=False)
class HingeSides:
    """Of h edges, all that `dofs` has as hinges, in their order.

    nodes   (h, 2, q): nodes of the left and of the right side, from the edge's begin to its end
    at      (q,): where they are, 0 to 1
    begin   (h, 2), m; along (h, 2), unit vector; length (h,), m
    """

    dofs: Dofs
    nodes: Integers
    at: Array
    begin: Array
    along: Array
    length: Array

    @property
    def normal(self) -> Array:
        """(h, 2), to the left."""
        return np.stack([-self.along[:, 1], self.along[:, 0]], axis=1)

    def rotations(self, edges: Integers, s: Array) -> sp.csr_array:
        """Rows (k, N) that give φ of the unknowns on `edges` (k,), numbers of these h, at `s` (k,), 0 to 1."""
        table = self.dofs.table
        slopes = np.flatnonzero((table[self.nodes[:, 0], 3] >= 0).all(axis=0))  # of the q nodes
        twists = np.flatnonzero((table[self.nodes[:, 0], 5] >= 0).all(axis=0))
        values = _hermite(s) if len(twists) else _lagrange(self.at[slopes], s)  # (k, functions)
        normal, along = self.normal[edges], self.along[edges]
        rows, columns, data = [], [], []

        def add(side: int, node: int, column: int, factor: Array) -> None:
            rows.append(np.arange(len(edges)))
            columns.append(table[self.nodes[edges, side, node], column])
            data.append((1.0, -1.0)[side] * factor)

        for side in (0, 1):
            for k, node in enumerate(slopes):
                for axis in (0, 1):
                    add(side, int(node), 3 + axis, values[:, k] * normal[:, axis])
            for k, node in enumerate(
                twists
            ):  # along an axis: w_xx and w_yy are no part of the slope's change
                share = normal[:, 0] * along[:, 1] + normal[:, 1] * along[:, 0]
                add(side, int(node), 5, values[:, len(slopes) + k] * share * self.length[edges])
        entries = (np.concatenate(data), (np.concatenate(rows), np.concatenate(columns)))
        return sp.csr_array(sp.coo_array(entries, shape=(len(edges), self.dofs.count)))


def hinge_sides(dofs: Dofs) -> HingeSides:
    """Of the hinges of `dofs`."""
    mesh, corners = dofs.mesh, dofs.mesh.corner_count
    order = np.argsort(mesh.cell_edges.ravel(), kind="stable")
    first = np.searchsorted(mesh.cell_edges.ravel()[order], dofs.hinges)
    (left, local), (right, other) = (np.divmod(order[first + k], corners) for k in (0, 1))
    nodes = np.stack([dofs.on_edges(left, local), dofs.on_edges(right, other)[:, ::-1]], axis=1)
    begin, end = mesh.corners[left, local], mesh.corners[left, (local + 1) % corners]
    length = np.linalg.norm(end - begin, axis=1)
    along = (end - begin) / length[:, None]
    return HingeSides(dofs, nodes, _places(dofs), begin, along, length)


def _places(dofs: Dofs) -> Array:
    """Where the nodes of an edge are along it, of the first edge of a cell as of all, 0 to 1."""
    a, b = (np.array(CORNERS[dofs.element.cell][k], dtype=float) for k in (0, 1))
    at = np.array([dofs.element.nodes[k].at for k in edge_nodes(dofs.element)[0]], dtype=float)
    return np.asarray((at - a) @ (b - a) / ((b - a) @ (b - a)))


def _lagrange(at: Array, s: Array) -> Array:
    """Polynomials that are 1 at one of `at` and 0 at the others, at `s` (k,), shape (k, len(at))."""
    columns = []
    for k, own in enumerate(at):
        others = np.delete(at, k)
        columns.append(np.prod((s[:, None] - others) / (own - others), axis=1))
    return np.stack(columns, axis=1)


def _hermite(s: Array) -> Array:
    """The cubics of the values at both ends, then those of the changes per length there, (k, 4)."""
    return np.stack(
        [
            1.0 - s * s * (3.0 - 2.0 * s),
            s * s * (3.0 - 2.0 * s),
            s * (1.0 - s) ** 2,
            -s * s * (1.0 - s),
        ],
        axis=1,
    )

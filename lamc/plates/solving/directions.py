"""Directions along edges at the nodes where they meet: one for a smooth line, none for a corner.

In: places, and which edges. Out: for every node on them a unit vector along the line and one across, and whether it is
a corner. Never: what is held there.

Two edges that turn by less than a given angle are pieces of one curve, as a mesh gives it; the node has their mean
direction. Two that turn by more are a corner, and so are more than two that are not on one line.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians, tan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lamc.basics.checks import Array
from lamc.plates.locator import MeshLocator
from lamc.plates.meshing.mesh import Integers
from lamc.plates.supports import Where

Indices = NDArray[Any]  # integers of any width, or flags
_AXIS = 1e-9  # radians; a direction this near to an axis is the axis
PARALLEL = 1e-12  # of the same squares: directions that differ by less than 2e-6 are one


@dataclass(frozen=True, eq=False)
class EdgeNodes:
    """Nodes on edges.

    nodes   (k,), ascending
    along   (k, 2): mean direction of the node's edges; across (k, 2): a quarter turn from it
    corner  (k,): whether there is no such direction
    owners  (k,): the first of the places that the node's edges are of
    """

    nodes: Integers
    along: Array
    across: Array
    corner: NDArray[np.bool_]
    owners: Integers


def edge_nodes_on(places: MeshLocator, wheres: Sequence[tuple[int, Where]], rotation: float) -> EdgeNodes:
    """Of all edges on any of `wheres`, given with the numbers of their owners; corners turn by over `rotation`
    degrees."""
    found = [(index, places.edges_on(where)) for index, where in wheres]
    edges = np.concatenate([np.zeros((0, 2), dtype=np.int32), *(e for _, e in found)])
    owner_of = np.concatenate(
        [np.zeros(0, dtype=np.int32), *(np.full(len(e), i, dtype=np.int32) for i, e in found)]
    )
    _, first = np.unique(places.dofs.mesh.cell_edges[edges[:, 0], edges[:, 1]], return_index=True)
    edges, owner_of = edges[first], owner_of[first]  # an edge of two supports counts once
    on = places.dofs.on_edges(edges[:, 0], edges[:, 1])
    along = places.dofs.points[on[:, -1]] - places.dofs.points[on[:, 0]]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    outwards = np.repeat(along[:, None], on.shape[1], axis=1)
    outwards[:, -1] *= -1.0  # from each end into the edge
    nodes, group = np.unique(on.ravel(), return_inverse=True)
    tangents = outwards.reshape(-1, 2)
    mean, normal, ratio = principal(gram(tangents, group, len(nodes)))
    ahead = np.einsum("ki,ki->k", tangents, mean[group]) > 0.0
    folded = np.maximum(
        np.bincount(group[ahead], minlength=len(nodes)), np.bincount(group[~ahead], minlength=len(nodes))
    )
    owners = np.full(len(nodes), np.iinfo(np.int32).max, dtype=np.int32)
    np.minimum.at(owners, group, np.repeat(owner_of, on.shape[1]))
    smooth = tan(radians(rotation / 2.0)) ** 2  # of the squares of the tangents' deviation and mean
    corner = (ratio > smooth) | ((folded > 1) & (ratio > PARALLEL))
    return EdgeNodes(nodes.astype(np.int32), mean, normal, corner, owners)


def gram(directions: Array, group: Indices, count: int) -> Array:
    """Σ d dᵀ over each group, as rows (xx, xy, yy)."""
    x, y = directions.T
    return np.stack([np.bincount(group, product, count) for product in (x * x, x * y, y * y)], axis=1)


def principal(sums: Array) -> tuple[Array, Array, Array]:
    """Unit vectors of the larger and the smaller principal value of `gram`, and the smaller over the larger."""
    xx, xy, yy = sums.T
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    c, s = np.cos(angle), np.sin(angle)
    on_x, on_y = np.abs(s) < _AXIS, np.abs(c) < _AXIS
    c, s = (
        np.where(on_x, np.sign(c), np.where(on_y, 0.0, c)),
        np.where(on_y, np.sign(s), np.where(on_x, 0.0, s)),
    )
    larger = xx * c * c + 2.0 * xy * c * s + yy * s * s
    smaller = np.maximum(xx * s * s - 2.0 * xy * c * s + yy * c * c, 0.0)
    return np.stack([c, s], axis=1), np.stack([-s, c], axis=1), smaller / larger

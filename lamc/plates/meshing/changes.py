"""Meshes from meshes: finer, or shaken.

In: a `Mesh`. Out: another one of the same plate. Never: other outlines; a curved border stays the polygon that it was.
"""

import numpy as np
from numpy.typing import NDArray

from lamc.basics.checks import checked_kind, checked_number, shown
from lamc.basics.errors import DesignError
from lamc.plates.meshing.mesh import MAKING, Mesh

_SURVIVE = ("one-diagonal", "squares")  # patterns whose cells, each cut in four, make the same pattern again


def refined(mesh: Mesh) -> Mesh:
    """Every cell cut into four of its shape, at the middles of its edges; half the size.

    Points of `mesh` keep their numbers, and the middle of edge e follows as point n + e; quadrilaterals have their
    centres after those. The four of cell c are 4 c to 4 c + 3: at corner 0, 1, 2, then inside, or at corner 3.
    """
    checked_kind(mesh, Mesh, "the mesh to refine", MAKING)
    middles = mesh.points[mesh.edges].mean(axis=1)
    corner, middle = mesh.cells, len(mesh.points) + mesh.cell_edges  # middle k: between corner k and the next
    before = np.roll(middle, 1, axis=1)
    if mesh.corner_count == 3:
        points = np.concatenate([mesh.points, middles])
        parts = [np.stack([corner[:, k], middle[:, k], before[:, k]], axis=1) for k in range(3)]
        parts.append(middle[:, [0, 1, 2]])
    else:
        centre = len(mesh.points) + len(middles) + np.arange(len(mesh.cells))
        points = np.concatenate([mesh.points, middles, mesh.corners.mean(axis=1)])
        parts = [np.stack([corner[:, k], middle[:, k], centre, before[:, k]], axis=1) for k in range(4)]
    cells = np.stack(parts, axis=1).reshape(-1, mesh.corner_count).astype(np.int32)
    pattern = mesh.pattern if mesh.pattern in _SURVIVE else ""
    return Mesh(points, cells, np.repeat(mesh.regions, 4), mesh.region_names, pattern)


def jittered(mesh: Mesh, fraction: float = 0.25, seed: int = 0) -> Mesh:
    """Points inside regions moved by up to `fraction` of the shortest edge there, in x and in y; the same for the same
    seed. Points on borders, of the plate or between regions, stay.

    For trying what a result owes to the regularity of a grid. Raises DesignError for a fraction outside 0 to 1, and for
    one by which a cell turns over.
    """
    checked_kind(mesh, Mesh, "the mesh of a jitter", MAKING)
    part = checked_number(fraction, "the fraction of a jitter", minimum=0.0)
    if part > 1.0:
        raise DesignError(f"the fraction of a jitter is {part:g}; it must be between 0 and 1: 0.25 is usual")
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise DesignError(f"the seed of a jitter is {shown(seed)}; it must be a whole number, 0 or more")
    ends = mesh.points[mesh.edges]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    reach = np.full(len(mesh.points), np.inf)
    np.minimum.at(reach, mesh.edges, lengths[:, None])
    reach[mesh.edges[border_edges(mesh)]] = 0.0
    shift = np.random.default_rng(seed).uniform(-1.0, 1.0, mesh.points.shape) * (part * reach)[:, None]
    try:
        return Mesh(mesh.points + shift, mesh.cells, mesh.regions, mesh.region_names)
    except DesignError as error:
        raise DesignError(f"a jitter of {part:g} is too large for this mesh: {error.message}") from error


def border_edges(mesh: Mesh) -> NDArray[np.intp]:
    """Numbers of the edges between two regions, and of those of one cell only; ascending."""
    count = len(mesh.edges)
    lowest, highest = np.full(count, len(mesh.region_names)), np.full(count, -1)
    region = np.repeat(mesh.regions, mesh.corner_count)
    np.minimum.at(lowest, mesh.cell_edges.ravel(), region)
    np.maximum.at(highest, mesh.cell_edges.ravel(), region)
    uses = np.bincount(mesh.cell_edges.ravel(), minlength=count)
    return np.flatnonzero((uses == 1) | (lowest != highest))

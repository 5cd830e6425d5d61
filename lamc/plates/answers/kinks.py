"""Lines inside a plate across which moments have a kink or a jump, so that no smooth curve fits both sides.

In: a `Solution`. Out: for the corners of cells, which of them patches may take together. Never: fits.

Along an inner line, a support reacts and a load pushes: shear forces jump across it, and moments have a kink; where
slopes are held, or a moment acts, moments jump. At a hinge line curvatures do. One polynomial across it would cut off
the peak, which is where a plate fails first.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from lamc.plates.doubling import parts_of_fans
from lamc.plates.loads import EdgeLoad, EdgeMoment
from lamc.plates.meshing.mesh import Integers

if TYPE_CHECKING:
    from lamc.plates.answers.solution import Solution


def corners_by_side(solution: "Solution") -> Integers:
    """What tells apart the corners of cells that patches take together, (m, corners): `Dofs.of_corners`, and on lines
    that hold or push, one for each side."""
    dofs = solution.problem.dofs
    breaks = _breaks(solution)
    if not breaks.any():
        return dofs.of_corners
    breaks[dofs.hinges] = True
    part = parts_of_fans(dofs.mesh, ~breaks)
    keys = dofs.of_corners.astype(np.int64) * len(dofs.mesh.cells) + part
    _, number = np.unique(keys, return_inverse=True)
    return np.asarray(number.reshape(keys.shape), dtype=np.int32)


def _breaks(solution: "Solution") -> NDArray[np.bool_]:
    """Which edges of the mesh lie on inner lines that hold or push, (edges,). Of areas, only their rims do."""
    places = solution.problem.places
    mesh = places.dofs.mesh
    breaks = np.zeros(len(mesh.edges), dtype=bool)
    holders = [support.where for support in solution.problem.supports]
    pushers = [load.where for load in solution.loads if isinstance(load, EdgeLoad | EdgeMoment)]
    for where in (*holders, *pushers):
        if not isinstance(where, BaseGeometry):
            continue
        cells, local = places.edges_on(where).T
        on = np.zeros(len(mesh.edges), dtype=bool)
        on[mesh.cell_edges[cells, local]] = True
        outside = ~on[mesh.cell_edges].all(axis=1)  # a cell with all of its edges on an area is in it
        rim = np.zeros(len(mesh.edges), dtype=bool)
        rim[mesh.cell_edges[outside].ravel()] = True
        breaks |= on & rim & ~places.on_boundary
    return breaks

"""Parts of a plate that touch at single points.

In: a mesh. Out: nothing, or a refusal with the place. Never: supports.

Slopes and displacements of a node go through it, so that such parts would be solved as one plate, clamped to each other
over a width of nothing; what a point really carries depends on a neck that is not drawn.
"""

import numpy as np

from lamc.basics.errors import DesignError
from lamc.plates.meshing.checks import place
from lamc.plates.meshing.mesh import Mesh


def check_pinches(mesh: Mesh) -> None:
    """Raises DesignError where cells around a node hang together by that node only."""
    cell, side = mesh.boundary_edges.T
    starts = mesh.cells[cell, side]
    meeting = np.flatnonzero(np.bincount(starts, minlength=len(mesh.points)) > 1)
    if len(meeting):
        raise DesignError(
            f"parts of the plate touch at the single point {place(mesh.points[meeting[0]])}; a plate cannot carry "
            "anything there, and its parts would be solved as if they were clamped to each other: give the neck a "
            "width, or each part a node of its own there"
        )

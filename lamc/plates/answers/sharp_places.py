"""Places where moments of thin-plate theory grow without bound, so that every finer mesh gives a larger stress.

In: a `Solution`, a place. Out: what makes it sharp, in words. Never: says how large stresses are there.

Source for corners: M. L. Williams, Proc. 1st US Nat. Congr. Appl. Mech., 1951. An end of a support is one where the
plate goes on beyond it, by more than a right angle: a line across the plate that ends at its free edges leaves right
angles on both sides.
"""

import numpy as np
from numpy.typing import NDArray
from shapely.geometry import MultiPoint, Point
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array
from lamc.plates.answers.solution import Solution
from lamc.plates.doubling import parts_of_fans
from lamc.plates.loads import PointLoad
from lamc.plates.locator import MeshLocator
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.meshing.report import corner_angles

_NOTCH = 210.0  # degrees: less is taken for a piece of an arc, of twelve or more to the turn
_PAST_AN_END = 120.0  # degrees


def sharp_place(solution: Solution, at: Array, reach: float) -> str:
    """What makes a place within `reach`, m, of `at` (2,) sharp; "" where nothing does."""
    problem = solution.problem
    here = Point(at)
    for load in solution.loads:
        if isinstance(load, PointLoad) and here.distance(Point(load.at)) <= reach:
            return "under a force at a point"
    angles, border = _angles(problem.mesh)
    near = np.hypot(*(problem.mesh.points - at).T) <= reach
    if (near & border & (angles > _NOTCH)).any():
        return "in a corner that cuts into the plate"
    for support in problem.supports:
        where = support.where
        if not isinstance(where, BaseGeometry):
            continue
        if isinstance(where, Point | MultiPoint) and here.distance(where) <= reach:
            return "at a support at a point"
        if "LineString" not in where.geom_type:
            continue
        for end in getattr(where.boundary, "geoms", ()):
            if here.distance(end) <= reach and _goes_on(problem.places, where, end):
                return "at an end of a support"
    return ""


def _goes_on(places: MeshLocator, where: BaseGeometry, end: Point) -> bool:
    """Whether the plate goes on beyond the end of a line."""
    mesh = places.dofs.mesh
    cells, local = places.edges_on(where).T
    free = np.ones(len(mesh.edges), dtype=bool)
    free[mesh.cell_edges[cells, local]] = False
    nearest = np.argmin(np.hypot(*(mesh.points - (end.x, end.y)).T))
    here = mesh.cells == nearest
    beyond = np.bincount(parts_of_fans(mesh, free)[here], corner_angles(mesh)[here])
    return bool(beyond.max() > _PAST_AN_END)


def _angles(mesh: Mesh) -> tuple[Array, NDArray[np.bool_]]:
    """Of the plate at each of the mesh's points, degrees, and whether it is on the border; both (points,)."""
    angles = np.zeros(len(mesh.points))
    np.add.at(angles, mesh.cells, corner_angles(mesh))
    alone = np.bincount(mesh.cell_edges.ravel(), minlength=len(mesh.edges)) == 1
    border = np.zeros(len(mesh.points), dtype=bool)
    border[mesh.edges[alone].ravel()] = True
    return angles, border

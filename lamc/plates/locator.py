"""From a place, "boundary" or a shapely geometry, to nodes and edges of a mesh.

In: the nodes of a problem and a tolerance. Out: numbers of nodes; edges as (cell, local edge). Never: supports, loads.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.plates.dofs import Dofs
from lamc.plates.meshing.mesh import Integers
from lamc.plates.supports import Where, where_text

Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class MeshLocator:
    """Where nodes and edges are.

    tolerance  m; nearer than this is "on it"
    """

    dofs: Dofs
    tolerance: float

    @cached_property
    def edges(self) -> Integers:
        """All edges, each once, as (cell, local edge), shape (e, 2), in the order of `mesh.edges`."""
        corners = self.dofs.mesh.corner_count
        _, first = np.unique(self.dofs.mesh.cell_edges.ravel(), return_index=True)
        return np.stack(np.divmod(first, corners), axis=1).astype(np.int32)

    @cached_property
    def edge_boxes(self) -> tuple[Array, Array]:
        """The least and the greatest x and y of each of `edges`, two of shape (2, e), m."""
        one, other = np.ascontiguousarray(self.dofs.mesh.points.T)[:, self.dofs.mesh.edges.T].swapaxes(0, 1)
        return np.minimum(one, other), np.maximum(one, other)

    @cached_property
    def nodes_drawn(self) -> NDArray[np.object_]:
        """The nodes as shapely points: making them takes longer than asking whether they lie on a place."""
        return np.asarray(shapely.points(self.dofs.points))

    @cached_property
    def corners_drawn(self) -> NDArray[np.object_]:
        """The points of the mesh, likewise."""
        return np.asarray(shapely.points(self.dofs.mesh.points))

    @cached_property
    def on_boundary(self) -> Flags:
        """Which of `edges` belong to one cell only, shape (e,)."""
        mesh = self.dofs.mesh
        return np.asarray(np.bincount(mesh.cell_edges.ravel(), minlength=len(mesh.edges)) == 1)

    @cached_property
    def covered(self) -> BaseGeometry:
        """What the mesh covers; of pieces with what they enclose taken out."""
        mesh = self.dofs.mesh
        rings = shapely.union_all(shapely.linestrings(mesh.points[mesh.edges[self.on_boundary]]))
        faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(rings)))
        inside = mesh.locate(shapely.get_coordinates(shapely.point_on_surface(faces)))[0] >= 0
        return shapely.union_all(faces[inside])

    @cached_property
    def plate(self) -> BaseGeometry:
        """What the mesh covers, and a tolerance around it."""
        return shapely.buffer(self.covered, self.tolerance)

    def nodes(self, where: Where, what: str) -> Integers:
        """Nodes on `where`, ascending. Raises DesignError, naming `what`, if there is none."""
        if isinstance(where, str):
            cells, edges = self.edges[self.on_boundary].T
            return np.unique(self.dofs.on_edges(cells, edges)).astype(np.int32)
        on = np.flatnonzero(self._on(where, self.nodes_drawn))
        if not len(on):
            distance = np.min(shapely.distance(where, self.nodes_drawn))
            raise DesignError(
                f"{what} at {where_text(where)} touches no node of the mesh; the nearest is {distance:.3g} m away, and "
                f"the tolerance is {self.tolerance:.3g} m: move it, or mesh along it"
            )
        return on.astype(np.int32)

    def edges_on(self, where: Where) -> Integers:
        """Edges with their ends and their middle on `where`, as (cell, local edge), each once, shape (k, 2)."""
        if isinstance(where, str):
            return np.asarray(self.edges[self.on_boundary])
        on = self._on(where, self.corners_drawn)
        ends = self.dofs.mesh.edges
        both = np.flatnonzero(on[ends].all(axis=1))
        middle = self.dofs.mesh.points[ends[both]].mean(axis=1)
        return np.asarray(self.edges[both[self._on(where, shapely.points(middle))]])

    def checked_edges_on(self, where: Where, what: str) -> Integers:
        """As `edges_on`. Raises DesignError, naming `what`, if there is none."""
        edges = self.edges_on(where)
        if not len(edges):
            assert not isinstance(where, str)
            middle = self.dofs.mesh.points[self.dofs.mesh.edges].mean(axis=1)
            distance = np.min(shapely.distance(where, shapely.points(middle)))
            raise DesignError(
                f"{what} at {where_text(where)} lies along no edge of the mesh; the middle of the nearest is "
                f"{distance:.3g} m away, and the tolerance is {self.tolerance:.3g} m: move it, or mesh along it"
            )
        return edges

    def cells_under(self, points: Array, what: str) -> tuple[Integers, Array]:
        """Cells under `points` (k, 2) and natural coordinates there, (k, 2).

        A point outside by no more than the tolerance is taken at the nearest place of the boundary. Raises DesignError,
        naming `what`, the first point that is further away, and its distance.
        """
        mesh = self.dofs.mesh
        cells, xi = mesh.locate(points)
        outside = np.flatnonzero(cells < 0)
        if not len(outside):
            return cells, xi
        sides = shapely.linestrings(mesh.points[mesh.edges[self.on_boundary]])
        lost = shapely.points(points[outside])
        nearest = sides[shapely.STRtree(sides).nearest(lost)]
        distance = shapely.distance(nearest, lost)
        far = np.flatnonzero(distance > self.tolerance)
        if len(far):
            x, y = points[outside[far[0]]]
            others = f", and {len(far) - 1} more points are outside" if len(far) > 1 else ""
            raise DesignError(
                f"{what} is at ({x:.6g}, {y:.6g}), which is {distance[far[0]]:.3g} m outside the plate{others}; it "
                "must be on the mesh"
            )
        there = shapely.line_interpolate_point(nearest, shapely.line_locate_point(nearest, lost))
        cells[outside], xi[outside] = mesh.locate(shapely.get_coordinates(there))
        return cells, xi

    def _on(self, where: BaseGeometry, points: NDArray[np.object_]) -> Flags:
        shapely.prepare(where)
        return np.asarray(shapely.dwithin(where, points, self.tolerance))


def points_at(x: npt.ArrayLike, y: npt.ArrayLike) -> tuple[Array, tuple[int, ...]]:
    """Points (k, 2) of coordinates that a user gives, m, and the shape of both. Raises DesignError for other things."""
    try:
        at_x, at_y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
    except (TypeError, ValueError) as error:
        raise DesignError(f"x and y must be numbers, or arrays of one shape: {error}") from error
    return np.stack([at_x.ravel(), at_y.ravel()], axis=1), at_x.shape

"""A mesh: points in the plane, and the triangles or quadrilaterals between them.

In: arrays. Out: the same, checked and turned counter-clockwise, with edges, areas, and the cell under any point. Never:
elements, materials, how a mesh is made.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lamc.basics.brief import brief, counted
from lamc.basics.checks import Array
from lamc.basics.once import lazy
from lamc.plates.meshing.checks import (
    checked_cells,
    checked_neighbours,
    checked_points,
    checked_regions,
    counter_clockwise_cells,
)
from lamc.plates.meshing.locate import Locator

Integers = NDArray[np.int32]


MAKING = "make one by plate.grid or plate.mesh"


@dataclass(frozen=True, eq=False)
class Mesh:
    """Cells of one kind, all counter-clockwise.

    points        (n, 2), m; each belongs to a cell
    cells         (m, 3) triangles or (m, 4) quadrilaterals: rows of `points`; clockwise ones are turned, the first
                  corner stays
    regions       (m,) index into `region_names`, per cell
    region_names  what laminates and sizes are given by
    pattern       "one-diagonal", "criss-cross", "union-jack", "squares" where `grid` made it with equal spacing; ""
                  otherwise

    Points may coincide: the plate is cut between them.

    Raises DesignError with the cell and its centre for corners that are no points, cells without area, quadrilaterals
    that are not convex, cells that are there twice, edges of more than two cells, and cells that lie upon their
    neighbours; and for points that are not finite or belong to no cell.
    """

    points: Array
    cells: Integers
    regions: Integers = field(
        default_factory=lambda: np.zeros(0, dtype=np.int32)
    )  # none: all in the first region
    region_names: Sequence[str] = ("",)
    pattern: str = ""

    def __post_init__(self) -> None:
        points = checked_points(self.points)
        cells = counter_clockwise_cells(points, checked_cells(self.cells, points))
        names, regions = checked_regions(self.region_names, self.regions, len(cells))
        for name, value in (("points", points), ("cells", cells), ("regions", regions)):
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        object.__setattr__(self, "region_names", names)
        checked_neighbours(points, cells, self.cell_edges, len(self.edges))

    def __repr__(self) -> str:
        kind = "triangle" if self.corner_count == 3 else "quadrilateral"
        regions = len(self.region_names)
        return brief(
            "Mesh",
            "",
            counted(len(self.points), "point"),
            counted(len(self.cells), kind),
            counted(regions, "region") if regions > 1 else "",
        )

    @property
    def corner_count(self) -> int:
        """Corners of a cell: 3 or 4."""
        return int(self.cells.shape[1])

    @lazy
    def corners(self) -> Array:
        """Coordinates of the cells' corners, shape (m, 3 or 4, 2), m."""
        return np.asarray(self.points[self.cells])

    @lazy
    def areas(self) -> Array:
        """Of the cells, shape (m,), m²."""
        x, y = np.moveaxis(
            self.corners - self.corners[:, :1], 2, 0
        )  # far from the origin products lose digits
        return np.asarray(0.5 * np.sum(x * np.roll(y, -1, 1) - np.roll(x, -1, 1) * y, axis=1))

    @lazy
    def _edges(self) -> tuple[Integers, Integers]:
        ends = np.stack([self.cells, np.roll(self.cells, -1, axis=1)], axis=2).reshape(-1, 2)
        low, high = ends.min(axis=1).astype(np.int64), ends.max(axis=1).astype(np.int64)
        keys, index = np.unique(low * len(self.points) + high, return_inverse=True)
        edges = np.stack(np.divmod(keys, len(self.points)), axis=1)
        return edges.astype(np.int32), index.reshape(self.cells.shape).astype(np.int32)

    @property
    def edges(self) -> Integers:
        """Ends of all edges, shape (e, 2), the lower first, in ascending order."""
        return self._edges[0]

    @property
    def cell_edges(self) -> Integers:
        """Index into `edges`, shape as `cells`; edge k of a cell runs from its corner k to the next."""
        return self._edges[1]

    @lazy
    def boundary_edges(self) -> Integers:
        """Edges of one cell only, as (cell, local edge), shape (b, 2)."""
        count = np.bincount(self.cell_edges.ravel(), minlength=len(self.edges))
        return np.argwhere(count[self.cell_edges] == 1).astype(np.int32)

    @lazy
    def _locator(self) -> Locator:
        return Locator(self.corners)

    def locate(self, points: object) -> tuple[Integers, Array]:
        """The cell under each of `points`, shape (k, 2), m, and where in it.

        Gives cells, shape (k,), and natural coordinates (ξ, η), shape (k, 2): triangles have ξ = L2 and η = L3, squares
        [-1, 1]². A point up to 1e-9 of the mesh's extent outside still belongs, so points on edges do, to the first of
        their cells. Elsewhere the cell is -1 and the coordinates are nan. Raises DesignError for what are no points.
        """
        return self._locator.locate(checked_points(points, "the points to locate", empty=True))

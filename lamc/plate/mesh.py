"""A mesh: points in the plane, and the triangles or quadrilaterals between them.

In: arrays. Out: the same, checked and turned counter-clockwise, with edges and areas. Never: elements, materials.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lamc.mechanism.checks import Array

Integers = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Cells of one kind, all counter-clockwise.

    points        (n, 2), m
    cells         (m, 3) triangles or (m, 4) quadrilaterals: rows of `points`
    regions       (m,) index into `region_names`, per cell
    region_names  what laminates and sizes are given by
    pattern       "one-diagonal", "criss-cross", "union-jack" where `grid` made it; "" otherwise
    """

    points: Array
    cells: Integers
    regions: Integers = field(
        default_factory=lambda: np.zeros(0, dtype=np.int32)
    )  # none: all in the first region
    region_names: Sequence[str] = ("",)
    pattern: str = ""

    def __post_init__(self) -> None:
        for name, value in (
            ("points", np.array(self.points, dtype=float)),
            ("cells", np.array(self.cells, dtype=np.int32)),
            ("regions", np.array(self.regions, dtype=np.int32)),
        ):
            if name == "regions" and not value.size:
                value = np.zeros(len(self.cells), dtype=np.int32)
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        object.__setattr__(self, "region_names", tuple(self.region_names))

    @property
    def corner_count(self) -> int:
        """Corners of a cell: 3 or 4."""
        return int(self.cells.shape[1])

    @cached_property
    def corners(self) -> Array:
        """Coordinates of the cells' corners, shape (m, 3 or 4, 2), m."""
        return np.asarray(self.points[self.cells])

    @cached_property
    def areas(self) -> Array:
        """Of the cells, shape (m,), m²."""
        x, y = np.moveaxis(self.corners, 2, 0)
        return np.asarray(0.5 * np.sum(x * np.roll(y, -1, 1) - np.roll(x, -1, 1) * y, axis=1))

    @cached_property
    def _edges(self) -> tuple[Integers, Integers]:
        ends = np.stack([self.cells, np.roll(self.cells, -1, axis=1)], axis=2).reshape(-1, 2)
        edges, index = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
        return edges.astype(np.int32), index.reshape(self.cells.shape).astype(np.int32)

    @property
    def edges(self) -> Integers:
        """Ends of all edges, shape (e, 2), the lower first, in ascending order."""
        return self._edges[0]

    @property
    def cell_edges(self) -> Integers:
        """Index into `edges`, shape as `cells`; edge k of a cell runs from its corner k to the next."""
        return self._edges[1]

    @cached_property
    def boundary_edges(self) -> Integers:
        """Edges of one cell only, as (cell, local edge), shape (b, 2)."""
        count = np.bincount(self.cell_edges.ravel(), minlength=len(self.edges))
        return np.argwhere(count[self.cell_edges] == 1).astype(np.int32)

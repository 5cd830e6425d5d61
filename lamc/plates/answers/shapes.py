"""Shapes that belong to a problem: modes, buckling shapes. Their displacements anywhere.

In: a problem and vectors of its unknowns. Out: displacements at nodes and points. Never: how the vectors were found.
"""

from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array, shown
from lamc.basics.errors import DesignError
from lamc.plates.elements.kernels import kernels
from lamc.plates.problem import Problem

AXES = ("u", "v", "w")


@dataclass(frozen=True, eq=False)
class Shapes:
    """Columns of `vectors` (unknowns, k), in the order of `problem.dofs`."""

    problem: Problem
    vectors: Array

    def __len__(self) -> int:
        return int(self.vectors.shape[1])

    def displacement(self, k: int, x: object, y: object) -> Array:
        """(u, v, w) of shape k at points x, y of one shape (…), m; shape (…, 3). Zero for what the element has not.

        Raises DesignError for a number that no shape has, and for points off the plate.
        """
        problem, vector = self.problem, self.vectors[:, self._checked(k)]
        at_x, at_y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        points = np.stack([at_x.ravel(), at_y.ravel()], axis=1)
        cells, xi = problem.places.cells_under(points, "a point of a shape")
        element = problem.dofs.element
        found = kernels(element).displacement(
            problem.mesh.corners[cells], xi, vector[problem.dofs.of_cells[cells]]
        )
        result = np.zeros((len(points), 3))
        fields = [AXES.index(name) for name in element.fields]
        result[:, fields] = found[:, : len(fields)]
        return result.reshape(*at_x.shape, 3)

    def deflection(self, k: int, x: object, y: object) -> Array:
        """w of shape k at points x, y, m, of their shape. Raises DesignError as `displacement` does."""
        return np.asarray(self.displacement(k, x, y)[..., 2])

    @property
    def shapes(self) -> Array:
        """w at all nodes, (nodes, k), m; nan at nodes without it. Nodes are those of `problem.dofs.points`."""
        number = self.problem.dofs.of("w")
        values = np.full((len(number), len(self)), np.nan)
        values[number >= 0] = self.vectors[number[number >= 0]]
        return values

    def _checked(self, k: int) -> int:
        if not isinstance(k, int | np.integer) or not 0 <= k < len(self):
            raise DesignError(f"shape {shown(k)} is asked for; there are {len(self)}, counted from 0")
        return int(k)

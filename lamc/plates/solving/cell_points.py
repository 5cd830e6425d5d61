"""Points of cells by which functions of the place are integrated.

In: corners of cells. Out: natural coordinates, places and shares of the area, in batches of bounded size. Never: knows
what is integrated.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.plates.dofs import mapped
from lamc.plates.elements.definition import CORNERS, TRIANGLE
from lamc.plates.elements.quadrature import square_points, triangle_points
from lamc.plates.meshing.mesh import Integers

# 16 points: exact for a cubic deflection under a load of degree four, so that what is left falls faster with the cells
# than what any element leaves.
_DEGREE = 7
_BATCH = 10_000  # cells at a time: unit deflections at one point of each take some 10 MB for every unknown of a cell


@dataclass(frozen=True, eq=False)
class CellPoints:
    """One point in each of k cells.

    cells  (k,), numbers
    xi     (k, 2), natural coordinates
    places (k, 2), m
    areas  (k,), m²: the point's share of its cell
    """

    cells: Integers
    xi: Array
    places: Array
    areas: Array


def cell_points(kind: str, corners: Array, cells: Integers) -> Iterator[CellPoints]:
    """Points of `cells`, all those of a batch before the next; `corners` (m, c, 2) are those of all cells."""
    rule = triangle_points(_DEGREE) if kind == TRIANGLE else square_points(_DEGREE)
    for start in range(0, len(cells), _BATCH):
        batch = cells[start : start + _BATCH]
        own = corners[batch]
        for xi, eta, weight in rule:
            at = np.tile([xi, eta], (len(batch), 1))
            yield CellPoints(batch, at, mapped(kind, own, at), weight * _stretch(kind, own, xi, eta))


def _stretch(kind: str, corners: Array, xi: float, eta: float) -> Array:
    """Determinant of the Jacobian of the map from natural coordinates, (m,), m²."""
    if kind == TRIANGLE:
        slopes = np.array([(-1.0, 1.0, 0.0), (-1.0, 0.0, 1.0)])
    else:
        a, b = np.array(CORNERS[kind], dtype=float).T
        slopes = 0.25 * np.array([a * (1.0 + b * eta), b * (1.0 + a * xi)])
    (x1, y1), (x2, y2) = np.einsum("kc,mci->kim", slopes, corners)
    return np.asarray(x1 * y2 - x2 * y1)

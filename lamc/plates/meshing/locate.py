"""Which cell of a mesh is under a point, and where in the cell.

In: corners of counter-clockwise convex cells, and points. Out: cell numbers and natural coordinates. Never: knows what
is found there.
"""

import numpy as np
import shapely
from numpy.typing import NDArray

from lamc.basics.checks import Array

Integers = NDArray[np.int32]

TOLERANCE = 1e-9  # of the mesh's extent: a point this far outside of a cell still belongs to it
_BATCH = 100_000  # points at a time: bounds the memory for candidates


class Locator:
    """Search tree over the cells' boxes; `corners` has shape (m, 3 or 4, 2)."""

    def __init__(self, corners: Array) -> None:
        self._corners = corners
        low, high = corners.min(axis=1), corners.max(axis=1)
        self._tolerance = TOLERANCE * float(np.linalg.norm(high.max(axis=0) - low.min(axis=0)))
        low, high = low - self._tolerance, high + self._tolerance
        self._tree = shapely.STRtree(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))

    def locate(self, points: Array) -> tuple[Integers, Array]:
        """Cells, shape (k,), -1 where there is none, and natural coordinates, shape (k, 2), nan there."""
        cells = np.full(len(points), -1, dtype=np.int32)
        for start in range(0, len(points), _BATCH):
            batch = slice(start, start + _BATCH)
            cells[batch] = self._cells_under(points[batch])
        natural = np.full((len(points), 2), np.nan)
        inside = np.flatnonzero(cells >= 0)
        corners = self._corners[cells[inside]]
        to_natural = _in_triangles if corners.shape[1] == 3 else _in_quadrilaterals
        natural[inside] = to_natural(corners, points[inside])
        return cells, natural

    def _cells_under(self, points: Array) -> Integers:
        of_point, candidate = self._tree.query(shapely.points(points))
        corners = self._corners[candidate]
        edges = np.roll(corners, -1, axis=1) - corners
        away = points[of_point][:, None, :] - corners
        height = edges[..., 0] * away[..., 1] - edges[..., 1] * away[..., 0]
        height /= np.linalg.norm(edges, axis=2)  # m, above each edge's line, inwards
        holds = (height >= -self._tolerance).all(axis=1)
        none = len(self._corners)
        first = np.full(len(points), none)
        np.minimum.at(first, of_point[holds], candidate[holds])
        return np.where(first == none, -1, first).astype(np.int32)


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _in_triangles(corners: Array, points: Array) -> Array:
    """(L2, L3), shape (k, 2)."""
    along, up, away = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], points - corners[:, 0]
    area = _cross(along, up)
    return np.stack([_cross(away, up) / area, _cross(along, away) / area], axis=1)


def _in_quadrilaterals(corners: Array, points: Array) -> Array:
    """(ξ, η) of the bilinear map, shape (k, 2).

    point = c + ξ b + η d + ξη e. Eliminating ξ leaves a quadratic in η; of its roots the one whose (ξ, η) is nearer to
    the middle of the square is meant. Two steps of Newton's method then remove what the elimination lost.
    """
    signs = np.array([[-1, 1, 1, -1], [-1, -1, 1, 1], [1, -1, 1, -1]]) / 4.0
    away = points - corners.mean(axis=1)
    b, d, e = (np.einsum("c,kcx->kx", row, corners) for row in signs)
    # (b + η e) × (away - η d) = 0
    square, linear, constant = -_cross(e, d), _cross(e, away) - _cross(b, d), _cross(b, away)
    root = np.sqrt(np.maximum(linear * linear - 4.0 * square * constant, 0.0))
    q = -0.5 * (linear + np.copysign(root, linear))
    best = np.full((len(points), 2), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for eta in (q / square, constant / q):
            side = b + eta[:, None] * e
            xi = np.sum(side * (away - eta[:, None] * d), axis=1) / np.sum(side * side, axis=1)
            found = np.stack([xi, eta], axis=1)
            nearer = np.abs(found).max(axis=1) < np.abs(best).max(axis=1)  # False where not a number
            best[nearer] = found[nearer]
    for _ in range(2):
        xi, eta = best[:, :1], best[:, 1:]
        rest = away - (xi * b + eta * d + xi * eta * e)
        d_xi, d_eta = b + eta * e, d + xi * e
        area = _cross(d_xi, d_eta)[:, None]
        best = best + np.stack([_cross(rest, d_eta), _cross(d_xi, rest)], axis=1) / area
    return best

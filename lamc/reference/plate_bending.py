"""How plate elements bend: rows of deflection, slope and curvature over the unknowns, at a point of every cell.

In: corners and natural coordinates. Out: `Bending`. Never: sections, integrals, sympy.

Elements are stated by their conditions, not by formulas. Discrete Kirchhoff triangle: slopes are quadratics that agree
with the cubic w on each edge, along it at its middle, and vary linearly across it (J.-L. Batoz, K.-J. Bathe and
L.-W. Ho, Int. J. Numer. Meth. Engng 15, 1980). Specht: cubics and three bubbles L1 L2 L3 Li such that the mean slope
across an edge is that of its ends (B. Specht, Int. J. Numer. Meth. Engng 26, 1988; Z.-C. Shi and M. Wang, Finite
Element Methods, 2013).
"""

from dataclasses import dataclass

import numpy as np

from lamc.reference.plate_layout import CORNERS
from lamc.reference.plate_shapes import (
    Numbers,
    Polynomials,
    bicubic_square,
    bubbles,
    membrane_polynomials,
    zienkiewicz_triangle,
)

_TRIANGLE = np.array(CORNERS["triangle"], dtype=float)
_EDGES = ((0, 1), (1, 2), (2, 0))
_MIDDLES = np.array([[0.5, 0.0], [0.5, 0.5], [0.0, 0.5]])  # of these edges, ξ and η


@dataclass(frozen=True, eq=False)
class CellMap:
    """The map from natural coordinates, at one point of every cell."""

    jacobian: Numbers  # (m, 2, 2), rows the derivatives of (x, y) by ξ and by η, m
    inverse: Numbers  # (m, 2, 2), rows the gradients of ξ and of η, 1/m
    area: Numbers  # (m,), m² per unit of natural area


@dataclass(frozen=True, eq=False)
class Bending:
    """Rows over the unknowns of bending, at one point of every cell."""

    w: Numbers  # (m, n)
    slopes: Numbers  # (m, 2, n), w_x and w_y
    curvature: Numbers  # (m, 3, n), -(w_xx, w_yy, 2 w_xy)


def frame(geometry: Polynomials, corners: Numbers, xi: Numbers) -> CellMap:
    """The map at `xi` (m, 2) of the cells with these corners (m, c, 2)."""
    jacobian = geometry.gradient(xi) @ corners
    (a, b), (c, d) = jacobian[:, 0].T, jacobian[:, 1].T
    area = a * d - b * c
    adjugate = np.stack([np.stack([d, -c], axis=1), np.stack([-b, a], axis=1)], axis=1)
    return CellMap(jacobian, adjugate / area[:, None, None], area)


class BendingShapes:
    """Of the element of that name: "bciz", "dkt", "specht" or "bfs"."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._deflection = bicubic_square() if name == "bfs" else zienkiewicz_triangle()
        self._quadratic = membrane_polynomials("triangle", "lst")
        self._bubbles = bubbles()

    def __call__(self, at: CellMap, corners: Numbers, xi: Numbers) -> Bending:
        """At `xi` (m, 2), where the map is `at`. For DKT w is the cubic of BCIZ; its slopes are not the gradient."""
        nodal = self._natural_unknowns(at)
        smooth = _in_plate_axes(at, self._deflection, xi, nodal)
        if self.name == "specht":
            extra = _in_plate_axes(at, self._bubbles, xi, self._bubble_weights(at, xi) @ nodal)
            return Bending(
                smooth.w + extra.w, smooth.slopes + extra.slopes, smooth.curvature + extra.curvature
            )
        if self.name == "dkt":
            return Bending(smooth.w, *self._discrete_kirchhoff(at, corners, xi))
        return smooth

    def _natural_unknowns(self, at: CellMap) -> Numbers:
        """From (w, w_x, w_y[, w_xy]) to (w, w_ξ, w_η[, w_ξη]) at the corners, (m, n, n); w_xy on rectangles only."""
        size, count = (4, 4) if self.name == "bfs" else (3, 3)
        node = np.zeros((len(at.area), size, size), dtype=at.area.dtype)
        node[:, 0, 0] = 1.0
        node[:, 1:3, 1:3] = at.jacobian
        node[:, 3:, 3:] = at.area[:, None, None]
        blocks = np.einsum("kl,mij->mkilj", np.eye(count, dtype=node.dtype), node)
        return np.asarray(blocks.reshape(-1, size * count, size * count))

    def _bubble_weights(self, at: CellMap, xi: Numbers) -> Numbers:
        """What each of the nine cubics takes of Specht's bubbles L1 L2 L3 Li, (m, 3, 9).

        Across the edge Lk = 0 only the bubbles of its two ends have a slope, each with the mean |∇Lk| / 12. The slope
        of a cubic there is quadratic along the edge; by Simpson's rule its mean lacks 2/3 of what its middle lacks.
        """
        gradients = np.concatenate(
            [-at.inverse.sum(axis=1, keepdims=True), at.inverse], axis=1
        )  # of L1, L2, L3
        sums = np.zeros(
            (len(xi), 3, 9), dtype=xi.dtype
        )  # row k: of the weights at the ends of the edge Lk = 0
        for (i, j), middle in zip(_EDGES, _MIDDLES, strict=True):
            k = 3 - i - j
            across = gradients[:, k] / np.sum(gradients[:, k] ** 2, axis=1)[:, None]
            first, last, between = (
                self._deflection.gradient(np.broadcast_to(point.astype(xi.dtype), xi.shape))
                for point in (_TRIANGLE[i], _TRIANGLE[j], middle)
            )
            gap = 0.5 * (first + last) - between
            sums[:, k] = 8.0 * np.einsum("ma,mia,min->mn", across, at.inverse, gap)
        return np.asarray(0.5 * sums.sum(axis=1, keepdims=True) - sums)

    def _discrete_kirchhoff(self, at: CellMap, corners: Numbers, xi: Numbers) -> tuple[Numbers, Numbers]:
        """Slopes (m, 2, 9) and curvature (m, 3, 9): quadratics between the slopes at corners and edge middles."""
        nodes = np.zeros((len(xi), 6, 2, 9), dtype=xi.dtype)
        identity = np.eye(2, dtype=xi.dtype)
        for k in range(3):
            nodes[:, k, :, 3 * k + 1 : 3 * k + 3] = identity
        for k, (i, j) in enumerate(_EDGES):
            along = corners[:, j] - corners[:, i]
            per_length = along / np.sum(along**2, axis=1)[:, None]
            # along: 3/2 (w_j - w_i) / l - 1/4 of both ends' slopes; across: 1/2 of both
            ends = 0.5 * identity - 0.75 * per_length[:, :, None] * along[:, None, :]
            for node, sign in ((i, -1.5), (j, 1.5)):
                nodes[:, 3 + k, :, 3 * node] = sign * per_length
                nodes[:, 3 + k, :, 3 * node + 1 : 3 * node + 3] = ends
        slopes = np.einsum("mk,mkan->man", self._quadratic(xi), nodes)
        gradient = np.einsum("mib,mik->mbk", at.inverse, self._quadratic.gradient(xi))
        second = np.einsum("mbk,mkan->mabn", gradient, nodes)
        twice = second[:, 0, 1] + second[:, 1, 0]
        return slopes, -np.stack([second[:, 0, 0], second[:, 1, 1], twice], axis=1)


def _in_plate_axes(at: CellMap, shapes: Polynomials, xi: Numbers, weights: Numbers) -> Bending:
    """Polynomials, weighted by `weights` (m, k, n), with derivatives by x and y; the map must be affine."""
    slopes = np.einsum("mia,mik->mak", at.inverse, shapes.gradient(xi))
    second = np.einsum("mia,mjb,mijk->mabk", at.inverse, at.inverse, shapes.hessian(xi))
    curvature = -np.stack([second[:, 0, 0], second[:, 1, 1], 2.0 * second[:, 0, 1]], axis=1)
    w = (shapes(xi)[:, None] @ weights)[:, 0]
    return Bending(w, slopes @ weights, curvature @ weights)

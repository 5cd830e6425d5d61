"""Plate and membrane elements by numeric quadrature: corner coordinates in, element matrices out. Numbers only.

The third cross-check of the plate half: it shares no code with the symbolic derivation and takes another road.

κ = -(w_xx, w_yy, 2 w_xy). Strain rows are (ε_x, ε_y, γ_xy), then κ. The unique entries of a symmetric 3 × 3 are in the
order 11, 12, 16, 22, 26, 66; a coupled section has those of A, B and D. Quadrature is exact for affine cells; on other
quadrilaterals it is Gauss's rule that is usual for the element (K.-J. Bathe, Finite Element Procedures, 1996, section
5.5.5).
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lamc.basics.errors import DesignError
from lamc.reference.plate_bending import BendingShapes, frame
from lamc.reference.plate_layout import layout
from lamc.reference.plate_shapes import Numbers, membrane_polynomials, square_rule, triangle_rule

_ENTRIES = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])  # where a symmetric 3 × 3 finds its unique entries
_STRAIN_DEGREE = {"cst": 0, "lst": 1, "bciz": 1, "dkt": 1, "specht": 2, "": 0}
_FIELD_DEGREE = {"cst": 1, "lst": 2, "bciz": 3, "dkt": 3, "specht": 4, "": 0}
_GAUSS = {"q4": 2, "q8": 3, "q9": 3, "q12": 4, "bfs": 4, "": 0}  # points per direction


class ReferenceElement:
    """Matrices of m cells at once, from their corners (m, c, 2), m, counter-clockwise.

    name  "dkt", "cst", … or one that bends and one that stretches: "dkt+cst"

    DKT has no deflection within; loads and mass take the cubic of BCIZ, which is the same on the edges. BFS is for
    rectangles along x and y. Raises UnsupportedError for a name that is not known, DesignError for another number of
    corners.
    """

    def __init__(self, name: str) -> None:
        self.element = layout(name)
        self._square = self.element.cell == "square"
        dofs = np.array(self.element.dofs)
        self._u, self._v = np.flatnonzero(dofs == "u"), np.flatnonzero(dofs == "v")
        self._bent = np.flatnonzero((dofs != "u") & (dofs != "v"))
        simplest = "q4" if self._square else "cst"
        self._geometry = membrane_polynomials(self.element.cell, simplest)
        self._membrane = membrane_polynomials(self.element.cell, self.element.membrane or simplest)
        self._bend = BendingShapes(self.element.bending)

    def stiffness(self, corners: ArrayLike, sections: ArrayLike) -> Numbers:
        """∫ Bᵀ S B dA, shape (m, n, n), from the unique entries of S (m, 6 or 18)."""
        x, S, total = self._checked(corners), _section(np.asarray(sections, dtype=float)), self._zero(corners)
        for area, xi in self._points(x, self._degree(strains=2)):
            B = self._strains(x, xi)
            total = total + B.swapaxes(1, 2) @ (area[:, None, None] * S @ B)
        return total

    def mass(self, corners: ArrayLike, areal_mass: ArrayLike) -> Numbers:
        """∫ ρ (u u + v v + w w) dA, shape (m, n, n), from the mass per area (m,), kg/m²."""
        x, total = self._checked(corners), self._zero(corners)
        for area, xi in self._points(x, self._degree(fields=2)):
            N = self._fields(x, xi)
            total = total + N.swapaxes(1, 2) @ ((area * np.asarray(areal_mass))[:, None, None] * N)
        return total

    def geometric(self, corners: ArrayLike, forces: ArrayLike) -> Numbers:
        """∫ ∇wᵀ N ∇w dA, shape (m, n, n), from (N_x, N_y, N_xy) (m, 3), N/m, tension positive."""
        x, total = self._checked(corners), self._zero(corners)
        N = np.asarray(forces, dtype=float)[:, [[0, 2], [2, 1]]]
        for area, xi in self._points(x, self._degree(fields=2)):
            G = self._slopes(x, xi)
            total = total + G.swapaxes(1, 2) @ (area[:, None, None] * N @ G)
        return total

    def load(self, corners: ArrayLike, intensity: ArrayLike) -> Numbers:
        """∫ p · (u, v, w) dA, shape (m, n), from forces per area at the corners (m, fields, c), Pa, linear between."""
        x, total = self._checked(corners), self._zero(corners)[:, 0]
        at_corners = np.asarray(intensity, dtype=float)
        for area, xi in self._points(x, self._degree(fields=1) + 1):
            p = np.einsum("mfc,mc->mf", at_corners, self._geometry(xi))
            total = total + np.einsum("m,mf,mfa->ma", area, p, self._fields(x, xi))
        return total

    def prestress(self, corners: ArrayLike, resultants: ArrayLike) -> Numbers:
        """∫ Bᵀ r dA, shape (m, n), from resultants (m, 3 or 6): N/m, then N."""
        x, total = self._checked(corners), self._zero(corners)[:, 0]
        for area, xi in self._points(x, self._degree(strains=1)):
            total = total + np.einsum("m,mia,mi->ma", area, self._strains(x, xi), np.asarray(resultants))
        return total

    def strain(self, corners: ArrayLike, xi: ArrayLike, d: ArrayLike) -> Numbers:
        """Strain and curvature, shape (m, 3 or 6), at one point `xi` (m, 2) of every cell, from unknowns (m, n)."""
        x = self._checked(corners)
        at = np.broadcast_to(np.asarray(xi, dtype=float), (len(x), 2))
        return np.asarray(np.einsum("mia,ma->mi", self._strains(x, at), np.asarray(d)))

    def displacement(self, corners: ArrayLike, xi: ArrayLike, d: ArrayLike) -> Numbers:
        """(u, v) if it stretches, then (w, w_x, w_y) if it bends, at one point `xi` (m, 2) of every cell."""
        x = self._checked(corners)
        at = np.broadcast_to(np.asarray(xi, dtype=float), (len(x), 2))
        rows = np.concatenate([self._fields(x, at), self._slopes(x, at)], axis=1)
        return np.asarray(np.einsum("mia,ma->mi", rows, np.asarray(d)))

    def force(self, corners: ArrayLike, sections: ArrayLike, d: ArrayLike, dtype: Any = float) -> Numbers:
        """∫ Bᵀ (S (B d)) dA, shape (m, n): strain first, so that rigid motion meets no round-off of the stiffness."""
        x, S = self._checked(corners, dtype), _section(np.asarray(sections, dtype=dtype))
        moved, total = np.asarray(d, dtype=dtype), self._zero(corners)[:, 0]
        for area, xi in self._points(x, self._degree(strains=2)):
            B = self._strains(x, xi)
            stress = np.einsum("mij,mj->mi", S, np.einsum("mia,ma->mi", B, moved))
            total = total + np.einsum("m,mia,mi->ma", area, B, stress)
        return total

    # --- integration -------------------------------------------------------------------------------------------------

    def _checked(self, corners: ArrayLike, dtype: Any = float) -> Numbers:
        x, count = np.asarray(corners, dtype=dtype), self.element.corner_count
        if x.ndim != 3 or x.shape[1:] != (count, 2):
            raise DesignError(
                f"corners for {self.element.name!r} have shape {x.shape}; it must be (m, {count}, 2): give x and y of "
                "every corner of every cell"
            )
        return x

    def _zero(self, corners: ArrayLike) -> Numbers:
        size = len(self.element.dofs)
        return np.zeros((len(np.asarray(corners)), size, size))

    def _degree(self, *, strains: int = 0, fields: int = 0) -> int:
        """Of a product of so many strains and fields; on squares, of the element's own rule for each direction."""
        parts = (self.element.bending, self.element.membrane)
        if self._square:
            return 2 * max(_GAUSS[part] for part in parts) - 1
        return max(strains * _STRAIN_DEGREE[part] + fields * _FIELD_DEGREE[part] for part in parts)

    def _points(self, corners: Numbers, degree: int) -> Iterator[tuple[Numbers, Numbers]]:
        """Area (m,) and place (m, 2) of every point of a rule."""
        rule = square_rule((degree + 2) // 2) if self._square else triangle_rule(degree)
        for point, weight in zip(*rule, strict=True):
            xi = np.broadcast_to(point.astype(corners.dtype), (len(corners), 2))
            yield weight.astype(corners.dtype) * frame(self._geometry, corners, xi).area, xi

    # --- rows over all unknowns, at a point --------------------------------------------------------------------------

    def _rows(self, count: int, xi: Numbers) -> Numbers:
        return np.zeros((len(xi), count, len(self.element.dofs)), dtype=xi.dtype)

    def _strains(self, corners: Numbers, xi: Numbers) -> Numbers:
        at, rows = frame(self._geometry, corners, xi), []
        if self.element.stretches:
            by_x, by_y = np.einsum("mia,mik->amk", at.inverse, self._membrane.gradient(xi))
            stretched = self._rows(3, xi)
            stretched[:, 0, self._u] = stretched[:, 2, self._v] = by_x
            stretched[:, 1, self._v] = stretched[:, 2, self._u] = by_y
            rows.append(stretched)
        if self.element.bends:
            bent = self._rows(3, xi)
            bent[:, :, self._bent] = self._bend(at, corners, xi).curvature
            rows.append(bent)
        return np.concatenate(rows, axis=1)

    def _fields(self, corners: Numbers, xi: Numbers) -> Numbers:
        """u, v, w: those that there are."""
        rows = self._rows(3, xi)
        if self.element.stretches:
            rows[:, 0, self._u] = rows[:, 1, self._v] = self._membrane(xi)
        if self.element.bends:
            rows[:, 2, self._bent] = self._bend(frame(self._geometry, corners, xi), corners, xi).w
        return rows[:, [self.element.stretches] * 2 + [self.element.bends]]

    def _slopes(self, corners: Numbers, xi: Numbers) -> Numbers:
        """w_x and w_y; nothing if it does not bend."""
        rows = self._rows(2 * self.element.bends, xi)
        if self.element.bends:
            rows[:, :, self._bent] = self._bend(frame(self._geometry, corners, xi), corners, xi).slopes
        return rows


def _section(entries: Numbers) -> Numbers:
    """Symmetric matrices (m, 3, 3) or (m, 6, 6) from their unique entries (m, 6) or (m, 18)."""
    if entries.shape[1] == 6:
        return np.asarray(entries[:, _ENTRIES])
    A, B, D = (entries[:, 6 * k + _ENTRIES] for k in range(3))
    return np.concatenate([np.concatenate([A, B], axis=2), np.concatenate([B, D], axis=2)], axis=1)

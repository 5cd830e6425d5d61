"""Triangles with shear through the thickness by numeric quadrature: the third cross-check of "dkmt".

In: corners, sections, unknowns. Out: matrices. Never: sympy, code of the symbolic derivation, its formulas.

The element is stated by its conditions. Slopes of the cross-section are quadratics: at corners the unknowns, at the
middle of an edge the mean of its ends and, along the edge, δ more. Each edge is a beam, D_s θ'' + Q = 0 and Q = H_s
γ, with γ = w' - θ in the mean; that gives δ. Shear inside is linear between corners, where it has the components
along both edges that these beams have (I. Katili, Int. J. Numer. Meth. Engng 36, 1993). Deflection, for loads and
mass: quadratic, at the middle of an edge that of a beam without load whose shear is constant.

Sections are the entries of D, or of A, B and D, then 11, 12, 22 of H, then those of D - B A⁻¹ B.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lamc.basics.errors import UnsupportedError
from lamc.reference.plate_bending import frame
from lamc.reference.plate_shapes import Numbers, membrane_polynomials, triangle_rule

_ENTRIES = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
_EDGES = ((0, 1), (1, 2), (2, 0))
_DEGREE = 4  # of all products of two: quadratics


@dataclass(frozen=True, eq=False)
class _Edges:
    """Rows over the nine unknowns of bending."""

    middle: Numbers  # (m, 3, 2, 9), slopes at the middles of edges
    shear: Numbers  # (m, 3, 9), γ along the edges
    along: Numbers  # (m, 3, 2), from end to end, m


class ReferenceShearElement:
    """Of "dkmt", "dkmt+cst" or "dkmt+lst"; methods and shapes as `ReferenceElement` has them, with sections where
    strains go by these. Raises UnsupportedError for another name."""

    def __init__(self, name: str) -> None:
        bending, plus, membrane = name.partition("+")
        if bending != "dkmt" or (plus and membrane not in ("cst", "lst")):
            raise UnsupportedError(
                f"there is no reference element with shear {name!r}; take dkmt, dkmt+cst or dkmt+lst"
            )
        self.stretches = bool(membrane)
        self._linear = membrane_polynomials("triangle", "cst")
        self._quadratic = membrane_polynomials("triangle", "lst")
        self._membrane = membrane_polynomials("triangle", membrane or "cst")
        names: list[str] = []
        for node in range(6 if membrane == "lst" else 3):
            names += [*("u", "v") * self.stretches, *("w", "w_x", "w_y") * (node < 3)]
        self.dofs = tuple(names)
        kinds = np.array(names)
        self._u, self._v = np.flatnonzero(kinds == "u"), np.flatnonzero(kinds == "v")
        self._bent = np.flatnonzero((kinds != "u") & (kinds != "v"))

    def stiffness(self, corners: ArrayLike, sections: ArrayLike) -> Numbers:
        """∫ Bᵀ S B dA, shape (m, n, n)."""
        x, s = np.asarray(corners, dtype=float), np.asarray(sections, dtype=float)
        S, H, _ = self._section(s)
        total = np.zeros((len(x), len(self.dofs), len(self.dofs)))
        for area, xi in self._points(x):
            B, G = self._strains(x, s, xi), self._shears(x, s, xi)
            total += area[:, None, None] * (B.swapaxes(1, 2) @ S @ B + G.swapaxes(1, 2) @ H @ G)
        return total

    def mass(self, corners: ArrayLike, areal_mass: ArrayLike) -> Numbers:
        """∫ ρ (u u + v v + w w) dA."""
        x = np.asarray(corners, dtype=float)
        total = np.zeros((len(x), len(self.dofs), len(self.dofs)))
        for area, xi in self._points(x):
            N = self._fields(x, xi)
            total += N.swapaxes(1, 2) @ ((area * np.asarray(areal_mass))[:, None, None] * N)
        return total

    def geometric(self, corners: ArrayLike, forces: ArrayLike) -> Numbers:
        """∫ ∇wᵀ N ∇w dA."""
        x, N = np.asarray(corners, dtype=float), np.asarray(forces, dtype=float)[:, [[0, 2], [2, 1]]]
        total = np.zeros((len(x), len(self.dofs), len(self.dofs)))
        for area, xi in self._points(x):
            G = np.zeros((len(x), 2, len(self.dofs)))
            inverse = frame(self._linear, x, xi).inverse
            G[:, :, self._bent] = np.einsum(
                "mia,mik,mkn->man", inverse, self._quadratic.gradient(xi), self._deflections(x)
            )
            total += G.swapaxes(1, 2) @ (area[:, None, None] * N @ G)
        return total

    def load(self, corners: ArrayLike, intensity: ArrayLike) -> Numbers:
        """∫ p · (u, v, w) dA, shape (m, n), from (m, fields, 3), Pa."""
        x, p = np.asarray(corners, dtype=float), np.asarray(intensity, dtype=float)
        total = np.zeros((len(x), len(self.dofs)))
        for area, xi in self._points(x):
            at = np.einsum("mfc,mc->mf", p, self._linear(xi))
            total += np.einsum("m,mf,mfa->ma", area, at, self._fields(x, xi))
        return total

    def prestress(self, corners: ArrayLike, resultants: ArrayLike, sections: ArrayLike) -> Numbers:
        """∫ Bᵀ r dA, shape (m, n)."""
        x, s = np.asarray(corners, dtype=float), np.asarray(sections, dtype=float)
        total = np.zeros((len(x), len(self.dofs)))
        for area, xi in self._points(x):
            total += np.einsum("m,mia,mi->ma", area, self._strains(x, s, xi), np.asarray(resultants))
        return total

    def strain(self, corners: ArrayLike, xi: ArrayLike, d: ArrayLike, sections: ArrayLike) -> Numbers:
        """Strains and curvatures at one point of every cell, shape (m, 3 or 6)."""
        x, s = np.asarray(corners, dtype=float), np.asarray(sections, dtype=float)
        return np.asarray(np.einsum("mia,ma->mi", self._strains(x, s, np.asarray(xi)), np.asarray(d)))

    def shear(self, corners: ArrayLike, xi: ArrayLike, d: ArrayLike, sections: ArrayLike) -> Numbers:
        """(γ_x, γ_y) through the thickness at one point of every cell, shape (m, 2)."""
        x, s = np.asarray(corners, dtype=float), np.asarray(sections, dtype=float)
        return np.asarray(np.einsum("mia,ma->mi", self._shears(x, s, np.asarray(xi)), np.asarray(d)))

    # --- inside ------------------------------------------------------------------------------------------------------

    def _points(self, x: Numbers) -> list[tuple[Numbers, Numbers]]:
        found = []
        for point, weight in zip(*triangle_rule(_DEGREE), strict=True):
            xi = np.broadcast_to(point, (len(x), 2))
            found.append((weight * frame(self._linear, x, xi).area, xi))
        return found

    def _section(self, s: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        """Of membrane and bending, of shear, and of bending about the neutral surface."""
        H = s[:, -9:][:, [[0, 1], [1, 2]]]
        if not self.stretches:
            return s[:, _ENTRIES], H, s[:, -6:][:, _ENTRIES]
        A, B, D = (s[:, 6 * k + _ENTRIES] for k in range(3))
        plane = np.concatenate([np.concatenate([A, B], axis=2), np.concatenate([B, D], axis=2)], axis=1)
        return plane, H, D - B @ np.linalg.solve(A, B)

    def _edges(self, x: Numbers, s: Numbers) -> _Edges:
        _, H, N = self._section(s)
        count = len(x)
        middle, shear = np.zeros((count, 3, 2, 9)), np.zeros((count, 3, 9))
        along = np.stack([x[:, j] - x[:, i] for i, j in _EDGES], axis=1)
        for k, (i, j) in enumerate(_EDGES):
            length = np.linalg.norm(along[:, k], axis=1)
            t = along[:, k] / length[:, None]
            bend = np.stack([t[:, 0] ** 2, t[:, 1] ** 2, 2.0 * t[:, 0] * t[:, 1]], axis=1)
            stiff = np.einsum("mi,mij,mj->m", bend, N, bend)
            slide = np.einsum("mi,mij,mj->m", t, H, t)
            mean = np.zeros((count, 2, 9))
            mean[:, 0, [3 * i + 1, 3 * j + 1]] = mean[:, 1, [3 * i + 2, 3 * j + 2]] = 0.5
            gap = -np.einsum("ma,man->mn", t, mean)  # (w_j - w_i)/L less the mean slope
            gap[:, 3 * j] += 1.0 / length
            gap[:, 3 * i] -= 1.0 / length
            # θ = line + 4 r (1 - r) δ, r from 0 to 1: its mean is 2/3 δ more, D θ'' = -8 D δ / L², so γ = 8 D δ / (H
            # L²)
            delta = gap / (2.0 / 3.0 + 8.0 * stiff / (slide * length**2))[:, None]
            middle[:, k] = mean + t[:, :, None] * delta[:, None, :]
            shear[:, k] = gap - 2.0 / 3.0 * delta
        return _Edges(middle, shear, along)

    def _strains(self, x: Numbers, s: Numbers, xi: Numbers) -> Numbers:
        at, edges = frame(self._linear, x, xi), self._edges(x, s)
        nodes = np.zeros((len(x), 6, 2, 9))
        for k in range(3):
            nodes[:, k, 0, 3 * k + 1] = nodes[:, k, 1, 3 * k + 2] = 1.0
        nodes[:, 3:] = edges.middle
        by = np.einsum("mib,mik->mbk", at.inverse, self._quadratic.gradient(xi))
        rotation = np.einsum("mbk,mkan->mabn", by, nodes)  # slope a by axis b
        curvature = -np.stack(
            [rotation[:, 0, 0], rotation[:, 1, 1], rotation[:, 0, 1] + rotation[:, 1, 0]], axis=1
        )
        rows = np.zeros((len(x), 3 + 3 * self.stretches, len(self.dofs)))
        rows[:, -3:, self._bent] = curvature
        if self.stretches:
            by_x, by_y = np.einsum("mia,mik->amk", at.inverse, self._membrane.gradient(xi))
            rows[:, 0, self._u] = rows[:, 2, self._v] = by_x
            rows[:, 1, self._v] = rows[:, 2, self._u] = by_y
        return rows

    def _shears(self, x: Numbers, s: Numbers, xi: Numbers) -> Numbers:
        edges = self._edges(x, s)
        length = np.linalg.norm(edges.along, axis=2)
        at_corners = np.zeros((len(x), 3, 2, 9))
        for corner, (one, other) in enumerate(((0, 2), (1, 0), (2, 1))):  # the edges that meet there
            directions = edges.along[:, [one, other]] / length[:, [one, other], None]
            at_corners[:, corner] = np.linalg.solve(directions, edges.shear[:, [one, other]])
        rows = np.zeros((len(x), 2, len(self.dofs)))
        rows[:, :, self._bent] = np.einsum("mc,mcan->man", self._linear(xi), at_corners)
        return rows

    def _deflections(self, x: Numbers) -> Numbers:
        """w at corners and middles of edges, (m, 6, 9)."""
        rows = np.zeros((len(x), 6, 9))
        for k in range(3):
            rows[:, k, 3 * k] = 1.0
        for k, (i, j) in enumerate(_EDGES):
            edge = x[:, j] - x[:, i]
            rows[:, 3 + k, [3 * i, 3 * j]] = 0.5
            rows[:, 3 + k, 3 * i + 1 : 3 * i + 3] = 0.125 * edge
            rows[:, 3 + k, 3 * j + 1 : 3 * j + 3] = -0.125 * edge
        return rows

    def _fields(self, x: Numbers, xi: Numbers) -> Numbers:
        rows = np.zeros((len(x), 1 + 2 * self.stretches, len(self.dofs)))
        rows[:, -1, self._bent] = np.einsum("mk,mkn->mn", self._quadratic(xi), self._deflections(x))
        if self.stretches:
            rows[:, 0, self._u] = rows[:, 1, self._v] = self._membrane(xi)
        return rows

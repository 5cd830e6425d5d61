"""Curvatures and strains that are better than those of the elements, from patches of cells.

In: a mesh, and strains sampled inside its cells. Out: strains anywhere. Never: elements, solving. Patches do not reach
into another region, where the stiffness may jump and strains with it, nor across a hinge line.

About each corner of the mesh, a polynomial is fitted to the samples of the cells around it by least squares. Inside a
cell those of its corners are blended by the functions that are 1 at one corner and linear or bilinear between. With
samples where the element's own strains are best, the result is of higher order than they are. Source: O. C.
Zienkiewicz, J. Z. Zhu, The superconvergent patch recovery and a posteriori error estimates, Int. J. Numer. Meth. Engng
33, 1992; blending as in their part 2.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse

from lamc.mechanism.checks import Array
from lamc.plate.dofs import mapped
from lamc.plate.elements.definition import CORNERS, SQUARE, TRIANGLE
from lamc.plate.meshing.mesh import Integers, Mesh

# Samples over coefficients that a patch has at least; with fewer it also takes the neighbours of its cells.
ENOUGH = 1.5
# Samples in one row leave the slopes across it open: relative to the largest moment of the patch, this is none.
_FLAT = 1e-9


def sample_points(cell: str, degree: int) -> Array:
    """Where the strains of an element are sampled, ξ and η, (q, 2): where they are best (J. Barlow, Int. J. Numer.
    Meth. Engng 10, 1976)."""
    if degree == 1:
        return np.array([[1 / 3, 1 / 3]]) if cell == TRIANGLE else np.zeros((1, 2))
    if cell == TRIANGLE:
        return np.array([[0.5, 0.0], [0.5, 0.5], [0.0, 0.5]])
    points, _ = np.polynomial.legendre.leggauss(2)
    return np.stack(np.meshgrid(points, points), axis=-1).reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class Recovered:
    """Polynomials about the corners of a mesh, one for each region that meets there.

    of_corner     (m, corners) polynomial of each corner of each cell
    centre, size  (p, 2) and (p,), m: what their coordinates are counted from, and in
    coefficients  (p, terms, k)
    """

    mesh: Mesh
    degree: int
    of_corner: Integers
    centre: Array
    size: Array
    coefficients: Array

    def at(self, cells: Integers, xi: Array) -> Array:
        """Values (n, k) in `cells` (n,) at natural coordinates `xi` (n, 2)."""
        kind = _kind(self.mesh)
        corners = self.mesh.corners[cells]
        points = mapped(kind, corners, xi)
        total = np.zeros((len(cells), self.coefficients.shape[2]))
        for c, weight in enumerate(_weights(kind, xi)):
            patch = self.of_corner[cells, c]
            place = (points - self.centre[patch]) / self.size[patch, None]
            terms = monomials(place, self.degree)
            total += weight[:, None] * np.einsum("nt,ntk->nk", terms, self.coefficients[patch])
        return total


@dataclass(frozen=True, eq=False)
class RecoveredStrains:
    """Of several parts, one after the other."""

    parts: tuple[Recovered, ...]

    def at(self, cells: Integers, xi: Array) -> Array:
        """Values (n, k) of all parts in `cells` (n,) at natural coordinates `xi` (n, 2)."""
        return np.concatenate([part.at(cells, xi) for part in self.parts], axis=1)


def recover(
    mesh: Mesh, xi: Array, samples: Array, degree: int, of_corners: Integers | None = None
) -> Recovered:
    """From `samples` (m, q, k) taken at `xi` (q, 2) of every cell; `of_corners` (m, corners) as `Dofs` has them, None:
    the mesh's points."""
    of_corner, member = _patches(mesh, mesh.cells if of_corners is None else of_corners, len(xi), degree)
    found = member.tocoo()
    patch, cell = found.coords
    count, pairs = member.shape[0], len(patch)
    gather = sparse.csr_array((np.ones(pairs), (patch, np.arange(pairs))), shape=(count, pairs))
    at = np.stack([mapped(_kind(mesh), mesh.corners, point) for point in xi], axis=1)  # (m, q, 2)
    number = len(xi) * (gather @ np.ones(pairs))
    centre = gather @ at.sum(axis=1)[cell] / number[:, None]
    place = at[cell] - centre[patch, None, :]
    size = np.zeros(count)
    np.maximum.at(size, patch, np.abs(place).max(axis=(1, 2)))
    size[size == 0.0] = 1.0  # a cell on its own with one sample: its strains are all that is known
    terms = monomials(place / size[patch, None, None], degree)  # (pairs, q, terms)
    width = terms.shape[2]
    moments = gather @ np.einsum("pqs,pqt->pst", terms, terms).reshape(pairs, -1)
    loads = gather @ np.einsum("pqt,pqk->ptk", terms, samples[cell]).reshape(pairs, -1)
    inverse = np.linalg.pinv(moments.reshape(count, width, width), rcond=_FLAT, hermitian=True)
    coefficients = inverse @ loads.reshape(count, width, -1)
    return Recovered(mesh, degree, of_corner, centre, size, coefficients)


def monomials(place: Array, degree: int) -> Array:
    """1, x, y, x², xy, y², … up to `degree`, along a new last axis."""
    x, y = place[..., 0], place[..., 1]
    return np.stack([x ** (d - k) * y**k for d in range(degree + 1) for k in range(d + 1)], axis=-1)


def _patches(
    mesh: Mesh, of_corners: Integers, per_cell: int, degree: int
) -> tuple[Integers, sparse.csr_array]:
    """Patch of every corner of every cell, and which cells each patch takes, (p, m)."""
    regions = np.broadcast_to(mesh.regions[:, None], mesh.cells.shape)
    keys = of_corners.astype(np.int64) * len(mesh.region_names) + regions
    unique, index = np.unique(keys.ravel(), return_inverse=True)
    of_corner = index.reshape(mesh.cells.shape).astype(np.int32)
    cells = np.repeat(np.arange(len(mesh.cells)), mesh.corner_count)
    ones = np.ones(of_corner.size)
    member = sparse.csr_array((ones, (of_corner.ravel(), cells)), shape=(len(unique), len(mesh.cells)))
    beside = sparse.csr_array(member.T @ member)
    needed = ENOUGH * (degree + 1) * (degree + 2) / 2
    for _ in range(2):
        few = per_cell * np.diff(member.indptr) < needed
        if not few.any():
            break
        member = sparse.csr_array(member + sparse.diags_array(few.astype(float)) @ member @ beside)
    return of_corner, member


def _kind(mesh: Mesh) -> str:
    return TRIANGLE if mesh.corner_count == 3 else SQUARE


def _weights(kind: str, xi: Array) -> list[Array]:
    """Of the corners, at each of `xi` (n, 2)."""
    a, b = xi.T
    if kind == TRIANGLE:
        return [1.0 - a - b, a, b]
    return [0.25 * (1 + p * a) * (1 + q * b) for p, q in CORNERS[kind]]

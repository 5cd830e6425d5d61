"""Curvatures and strains that are better than those of the elements, from patches of cells.

In: a mesh, and strains sampled inside its cells. Out: strains anywhere. Never: elements, solving. Patches do not reach
into another region, where the stiffness may jump and strains with it, nor across a hinge line.

About each corner of the mesh, a polynomial is fitted to the samples of the cells around it by least squares. Inside a
cell those of its corners are blended by the functions that are 1 at one corner and linear or bilinear between. With
samples where the element's own strains are best, the result is of higher order than they are. Source: O. C.
Zienkiewicz, J. Z. Zhu, The superconvergent patch recovery and a posteriori error estimates, Int. J. Numer. Meth. Engng
33, 1992; blending as in their part 2.

At a border, of the plate or of a region, patches reach one way only: their polynomials are continued outwards, and
errors of the elements do not cancel. There a patch takes the neighbours of its cells too, and `Rows` of what is known
beside the samples, where there are any (`edge_rows.py`).
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from lamc.basics.checks import Array
from lamc.plates.dofs import mapped
from lamc.plates.elements.definition import CORNERS, SQUARE, TRIANGLE
from lamc.plates.meshing.mesh import Integers, Mesh

# Samples over coefficients that a patch has at least; with fewer it also takes the neighbours of its cells. A sample on
# an edge is taken in both cells that meet there, and counts half.
ENOUGH = 1.5
# Samples in one row leave the slopes across it open: relative to the largest moment of the patch, this is none.
_FLAT = 1e-9
# Of samples beside rows, in squares. Clamped squares of 20 x 20 cells under pressure, five kinds of mesh, DKT, and BCIZ
# on three directions: the moment at the edge is up to 2.3 % low with samples of weight 1, up to 3.3 % high without
# samples, and between 0.2 % low and 2.7 % high with this.
_SAMPLE = 0.2
_BATCH = 500  # patches at a time: with rows each takes some 100 kB


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
class Rows:
    """What is known of the fields beside their samples: `across` · fields = `values` at `places`.

    places  (m, r, 2), m
    across  (m, r, k)
    values  (m, r)
    """

    places: Array
    across: Array
    values: Array


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
    mesh: Mesh,
    xi: Array,
    samples: Array,
    degree: int,
    of_corners: Integers | None = None,
    rows: Rows | None = None,
) -> Recovered:
    """From `samples` (m, q, k) taken at `xi` (q, 2) of every cell; `of_corners` (m, corners) as `Dofs` has them, None:
    the mesh's points. With `rows`, patches at a border take these too."""
    corners = mesh.cells if of_corners is None else of_corners
    of_corner, member, border = _patches(mesh, corners, xi, degree, reach=rows is not None)
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
    moments, loads = moments.reshape(count, width, width), loads.reshape(count, width, -1)
    coefficients = np.linalg.pinv(moments, rcond=_FLAT, hermitian=True) @ loads
    result = Recovered(mesh, degree, of_corner, centre, size, coefficients)
    if rows is not None:
        for chosen in np.array_split(np.flatnonzero(border).astype(np.int32), 1 + len(border) // _BATCH):
            if not len(chosen):
                continue
            coefficients[chosen] = _with_rows(result, chosen, member, rows, moments[chosen], loads[chosen])
    return result


def _with_rows(
    fitted: Recovered, chosen: Integers, member: sparse.csr_array, rows: Rows, moments: Array, loads: Array
) -> Array:
    """Coefficients (c, terms, k) of the patches `chosen` (c,) from `rows` and the normal equations of the samples,
    `moments` (c, terms, terms) and `loads` (c, terms, k). Rows tie the fields of a patch together."""
    count, width, fields = loads.shape
    found = member[chosen].tocoo()
    patch, cell = found.coords
    gather = sparse.csr_array(
        (np.ones(len(patch)), (patch, np.arange(len(patch)))), shape=(count, len(patch))
    )
    own = chosen[patch]
    place = (rows.places[cell] - fitted.centre[own, None, :]) / fitted.size[own, None, None]
    terms = monomials(place, fitted.degree)
    joint = (rows.across[cell][..., :, None] * terms[..., None, :]).reshape(*place.shape[:2], -1)
    square = (gather @ np.einsum("prs,prt->pst", joint, joint).reshape(len(patch), -1)).reshape(
        count, fields * width, -1
    )
    right = gather @ np.einsum("prt,pr->pt", joint, rows.values[cell])
    for k in range(fields):
        part = slice(k * width, (k + 1) * width)
        square[:, part, part] += _SAMPLE * moments
        right[:, part] += _SAMPLE * loads[:, :, k]
    solved = np.linalg.pinv(square, rcond=_FLAT, hermitian=True) @ right[:, :, None]
    return np.asarray(solved.reshape(count, fields, width).transpose(0, 2, 1))


def monomials(place: Array, degree: int) -> Array:
    """1, x, y, x², xy, y², … up to `degree`, along a new last axis."""
    x, y = place[..., 0], place[..., 1]
    return np.stack([x ** (d - k) * y**k for d in range(degree + 1) for k in range(d + 1)], axis=-1)


def _patches(
    mesh: Mesh, of_corners: Integers, xi: Array, degree: int, *, reach: bool
) -> tuple[Integers, sparse.csr_array, NDArray[np.bool_]]:
    """Patch of every corner of every cell, which cells each patch takes, (p, m), and which lie at a border, (p,).
    With `reach` these take the neighbours of their cells, however many samples they have."""
    regions = np.broadcast_to(mesh.regions[:, None], mesh.cells.shape)
    keys = of_corners.astype(np.int64) * len(mesh.region_names) + regions
    unique, index = np.unique(keys.ravel(), return_inverse=True)
    of_corner = index.reshape(mesh.cells.shape).astype(np.int32)
    cells = np.repeat(np.arange(len(mesh.cells)), mesh.corner_count)
    ones = np.ones(of_corner.size)
    member = sparse.csr_array((ones, (of_corner.ravel(), cells)), shape=(len(unique), len(mesh.cells)))
    beside = sparse.csr_array(member.T @ member)
    border = _at_border(of_corner, len(unique))
    on_edge = np.isclose(_weights(_kind(mesh), xi), 0.0).any(axis=0)  # of triangles
    per_cell = len(xi) - 0.5 * np.count_nonzero(on_edge)
    needed = ENOUGH * (degree + 1) * (degree + 2) / 2
    for round_ in range(2):
        few = per_cell * np.diff(member.indptr) < needed
        if reach and not round_:
            few |= border
        if not few.any():
            break
        member = sparse.csr_array(member + sparse.diags_array(few.astype(float)) @ member @ beside)
    return of_corner, member, border


def _at_border(of_corner: Integers, count: int) -> NDArray[np.bool_]:
    """Which patches have an edge at their corner that belongs to one cell only, (count,)."""
    ends = np.sort(np.stack([of_corner, np.roll(of_corner, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    edges, times = np.unique(ends.astype(np.int64) @ (count, 1), return_counts=True)
    alone = edges[times == 1]
    border = np.zeros(count, dtype=bool)
    border[alone // count] = border[alone % count] = True
    return border


def _kind(mesh: Mesh) -> str:
    return TRIANGLE if mesh.corner_count == 3 else SQUARE


def _weights(kind: str, xi: Array) -> list[Array]:
    """Of the corners, at each of `xi` (n, 2)."""
    a, b = xi.T
    if kind == TRIANGLE:
        return [1.0 - a - b, a, b]
    return [0.25 * (1 + p * a) * (1 + q * b) for p, q in CORNERS[kind]]

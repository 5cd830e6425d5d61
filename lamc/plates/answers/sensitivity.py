"""How forms of the stiffness and mass matrices change with the sections of the regions.

In: an element's kernels, cells, and unknowns on the two sides of the form. Out: derivatives by the unique entries of
each region's section, by its expansion and by its mass. Never: plies, solving.

K is linear in the section s, so that lᵀ (∂K/∂s_k) d = Σ l · ∫ Bᵀ E_k B d dA, with E_k the section that has a one in
place k: the element's own forces give it exactly as the stiffness is integrated, and nothing is differenced.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lamc.basics.checks import Array
from lamc.plates.elements.kernels import ElementKernels
from lamc.plates.meshing.mesh import Integers
from lamc.plates.solving.cell_points import cell_points

Flags = NDArray[np.bool_]


def by_sections(
    kernels: ElementKernels,
    corners: Array,
    regions: Integers,
    left: Array,
    right: Array,
    shape: tuple[int, int],
) -> Array:
    """Derivatives of leftᵀ K right by the sections, (R, S) = `shape`; left and right are (m, nd)."""
    result = np.empty(shape)
    for k in range(shape[1]):
        sections = np.zeros((len(corners), shape[1]))
        sections[:, k] = 1.0
        work = np.einsum("ma,ma->m", left, kernels.force(corners, sections, right))
        result[:, k] = np.bincount(regions, work, shape[0])
    return result


def by_resultants(
    kernels: ElementKernels, corners: Array, regions: Integers, left: Array, shape: tuple[int, int]
) -> Array:
    """Derivatives of leftᵀ ∫ Bᵀ r dA by the resultants r of the regions, (R, 3 or 6) = `shape`."""
    result = np.empty(shape)
    for k in range(shape[1]):
        resultants = np.zeros((len(corners), shape[1]))
        resultants[:, k] = 1.0
        work = np.einsum("ma,ma->m", left, kernels.prestress(corners, resultants))
        result[:, k] = np.bincount(regions, work, shape[0])
    return result


def by_varying(
    kernels: ElementKernels, corners: Array, chosen: Flags, left: Array, factor: Callable[[Array], Array]
) -> Array:
    """Derivatives of leftᵀ ∫ Bᵀ r f dA by r, (3 or 6,), over the cells of `chosen` (m,); f is `factor` at places
    (k, 2)."""
    total = np.zeros(kernels.strain_count)
    cells = np.flatnonzero(chosen).astype(np.int32)
    for point in cell_points(kernels.element.cell, corners, cells):
        strain = kernels.strain(corners[point.cells], point.xi, left[point.cells])
        total += (point.areas * factor(point.places)) @ strain
    return total


def by_mass(
    kernels: ElementKernels, corners: Array, regions: Integers, left: Array, right: Array, count: int
) -> Array:
    """Derivatives of leftᵀ M right by the areal masses of the regions, (R,) = (`count`,)."""
    each = kernels.mass(corners, np.ones(len(corners)))
    work = np.einsum("ma,mab,mb->m", left, each, right)
    return np.asarray(np.bincount(regions, work, count), dtype=float)


def by_weight(
    kernels: ElementKernels, corners: Array, regions: Integers, left: Array, acceleration: Array, count: int
) -> Array:
    """Derivatives of leftᵀ f by the regions' areal masses, (R,), with f their weight under `acceleration` (3,)."""
    element = kernels.element
    along = [acceleration["uvw".index(name)] for name in element.fields]
    intensity = np.broadcast_to(
        np.array(along)[None, :, None], (len(corners), len(along), element.corner_count)
    )
    work = np.einsum("ma,ma->m", left, kernels.load(corners, intensity))
    return np.asarray(np.bincount(regions, work, count), dtype=float)

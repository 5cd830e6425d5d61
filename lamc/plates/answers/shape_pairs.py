"""Frequencies and critical loads on a mesh and on one of halved cells, paired by the shapes that belong to them.

In: modes or buckling loads of a problem. Out: of each, the same on halved cells and what both tend to. Never: pairs by
rank, which changes where two are near each other.

The pair of a shape is the one that it is most like, by the modal assurance criterion, MAC = (a·b)² / (a·a)(b·b), with
products over the plate's mass (R. J. Allemang, D. L. Brown, Proc. IMAC 1, 1982). Of shapes that repeat, any turn is as
good, so their MACs are added up.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from lamc.basics.checks import Array
from lamc.plates.answers.buckling import Buckling, buckling
from lamc.plates.answers.convergence import QuantityError, error_of_values, halved
from lamc.plates.answers.modes import PlateModes, modes
from lamc.plates.answers.shapes import Shapes
from lamc.plates.problem import Problem

_MORE = 4  # shapes more than asked for on halved cells: some that came late may come earlier there
_ALIKE = 0.5  # MAC below which two are not the same shape
_REPEATED = 1e-2  # relative: values nearer than this share their shapes


@dataclass(frozen=True)
class ShapePair:
    """number: of the shape, counted from 0; mac: 0 to 1, how alike the two are; error: None where none is alike."""

    number: int
    mac: float
    error: QuantityError | None


def halved_modes(found: PlateModes, finer: Problem | None = None) -> tuple[ShapePair, ...]:
    """Of every mode that is no rigid motion, in Hz, by one more answer on halved cells, or of the problem `finer`."""
    problem = halved(found.problem) if finer is None else finer
    fine = modes(problem, _count(found, problem), in_plane_inertia=found.in_plane_inertia)
    rigid, over = len(found.rigid), len(fine.rigid)
    pairs = paired(found, fine, found.frequencies, fine.frequencies, rigid, over)
    return tuple(pairs)


def halved_buckling(found: Buckling, finer: Problem | None = None) -> tuple[ShapePair, ...]:
    """Of every positive factor, by one more answer on halved cells, or of the problem `finer`."""
    problem = halved(found.problem) if finer is None else finer
    forces = np.repeat(found.forces, 4, axis=0) if found.given else None
    fine = buckling(problem, _count(found, problem), forces=forces)
    return tuple(paired(found, fine, found.factors, fine.factors, 0, 0))


def paired(
    coarse: Shapes, fine: Shapes, values: Array, finer: Array, first: int, first_fine: int
) -> list[ShapePair]:
    """From the shapes `first` and `first_fine` on, as many as there are values."""
    own, other = range(first, len(values)), range(first_fine, len(finer))
    if not len(own) or not len(other):
        return [ShapePair(k, 0.0, None) for k in own]
    alike = _mac(coarse, fine, own, other)
    lines, columns = linear_sum_assignment(-alike)
    partner = dict(zip(lines.tolist(), columns.tolist(), strict=True))
    result = []
    for row, number in enumerate(own):
        if row not in partner:
            result.append(ShapePair(number, 0.0, None))
            continue
        value = float(finer[other[partner[row]]])
        near = np.abs(finer[first_fine:] / value - 1.0) < _REPEATED
        mac = min(float(alike[row, near].sum()), 1.0)
        error = error_of_values(float(values[number]), value) if mac >= _ALIKE else None
        result.append(ShapePair(number, mac, error))
    return result


def _mac(coarse: Shapes, fine: Shapes, own: range, other: range) -> Array:
    """Of each of `own` with each of `other`, at the middles of the cells of the coarse mesh."""
    problem = coarse.problem
    mesh = problem.mesh
    x, y = mesh.corners.mean(axis=1).T
    heavy = np.array([laminate.areal_mass for laminate in problem.laminates])
    rho = heavy if heavy.any() else np.ones(len(heavy))  # buckling needs no mass
    weight = np.sqrt(rho[mesh.regions] * np.abs(mesh.areas))[:, None]
    a, b = (
        np.array([(weight * shapes.displacement(k, x, y)).ravel() for k in which])
        for shapes, which in ((coarse, own), (fine, other))
    )
    sizes = np.outer(np.sum(a * a, axis=1), np.sum(b * b, axis=1))
    return np.asarray(np.square(a @ b.T) / np.maximum(sizes, np.finfo(float).tiny))


def _count(found: Shapes, finer: Problem) -> int:
    """Shapes to ask for on a finer mesh; fewer where a small mesh has no more."""
    return min(len(found) + _MORE, max(finer.dofs.count // 3, len(found)))

"""What pictures and files show of a solution: values at the corners of cells, and where they are largest.

In: a `Solution`. Out: deflection at the mesh's points; recovered moments, forces and ply stresses at the corners of its
cells, where they may jump between regions. Never: solves, draws.

Ply stress is told by von Mises' equivalent, the largest over all plies and their two faces; where the strengths of
every material are known, by Tsai and Wu's index too, 1 at failure.
"""

from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.plates.answers.solution import Solution
from lamc.plates.elements.definition import CORNERS
from lamc.plates.laminates.failure import tsai_wu_index
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.materials import STRENGTHS
from lamc.plates.laminates.sections import matrices

_NOTHING = 1e-11  # of the terms of a sum: less is round-off


@dataclass(frozen=True, eq=False)
class CornerFields:
    """Of one solution, m cells of c corners; None for what the element does not have.

    moments   (m, c, 3) M_x, M_y, M_xy, N
    forces    (m, c, 3) N_x, N_y, N_xy, N/m
    stress    (m, c) Pa, the largest equivalent stress of all plies
    tsai_wu   (m, c), the largest index of all plies; nan in regions of unknown strengths

    smallest_force, smallest_energy  N and J: less is round-off of terms that cancel
    """

    moments: Array | None
    forces: Array | None
    stress: Array
    tsai_wu: Array | None
    smallest_force: float
    smallest_energy: float


@dataclass(frozen=True)
class Extreme:
    """A largest or smallest value and its place."""

    value: float
    at: tuple[float, float]  # m


def corner_fields(solution: Solution) -> CornerFields:
    """Recovered fields of `solution`."""
    problem = solution.problem
    mesh, element = problem.mesh, problem.dofs.element
    better = solution.recovered_strains
    cells = np.arange(len(mesh.cells), dtype=np.int32)
    places = np.array(CORNERS[element.cell], dtype=float)
    strains = np.stack([better.at(cells, np.tile(xi, (len(cells), 1))) for xi in places], axis=1)
    stiffness = matrices(problem.laminates, element)[mesh.regions]
    free = np.stack([solution.expansion.at(cells, mesh.corners[:, c]) for c in range(len(places))], axis=1)
    resultants = np.einsum("mij,mcj->mci", stiffness, strains) - free
    terms = np.einsum("mij,mcj->mci", np.abs(stiffness), np.abs(strains)) + np.abs(free)
    sizes = np.repeat(terms.max(axis=(0, 1)).reshape(-1, 3).max(axis=1), 3)  # of forces, of moments
    resultants[np.abs(resultants) < _NOTHING * sizes] = 0.0
    energy = float(np.einsum("mci,mci,m->", terms, np.abs(strains), mesh.areas)) / mesh.corner_count
    stress = np.zeros(mesh.cells.shape)
    index = np.full(mesh.cells.shape, np.nan)
    none = np.zeros(3)
    for region, laminate in enumerate(problem.laminates):
        chosen = mesh.regions == region
        climate = solution.climates[region].at(mesh.corners[chosen])
        plies = laminate.material_stress(
            strains[chosen][..., :3] if element.stretches else none,
            strains[chosen][..., -3:] if element.bends else none,
            temperature=climate.temperature,
            moisture=climate.moisture,
            fields=climate.fields,
        )
        stress[chosen] = _equivalent(plies).max(axis=(-2, -1))
        if _known(laminate):
            index[chosen] = _largest_index(laminate, plies)
    return CornerFields(
        moments=resultants[..., -3:] if element.bends else None,
        forces=resultants[..., :3] if element.stretches else None,
        stress=stress,
        tsai_wu=None if np.isnan(index).all() else index,
        smallest_force=_NOTHING * float(sizes[0]) * (problem.size if element.stretches else 1.0),
        smallest_energy=_NOTHING * energy,
    )


def extremes(points: Array, values: Array) -> tuple[Extreme, Extreme]:
    """The least and the largest of `values` (...) at `points` (..., 2); nan counts for neither."""
    flat, places = np.array(values, dtype=float).ravel(), np.reshape(points, (-1, 2))
    flat[np.abs(flat) < _NOTHING * np.nanmax(np.abs(flat))] = 0.0
    found = []
    for k in (int(np.nanargmin(flat)), int(np.nanargmax(flat))):
        found.append(Extreme(float(flat[k]), (float(places[k, 0]), float(places[k, 1]))))
    return found[0], found[1]


def _equivalent(stress: Array) -> Array:
    """Von Mises' stress of plane stress (..., 3), whatever its axes."""
    along, across, shear = np.moveaxis(stress, -1, 0)
    return np.asarray(np.sqrt(along**2 - along * across + across**2 + 3.0 * shear**2))


def _known(laminate: Laminate) -> bool:
    return all(getattr(ply.material, name) is not None for ply in laminate.plies for name in STRENGTHS)


def _largest_index(laminate: Laminate, stress: Array) -> Array:
    """Over the plies of stresses (..., plies, 2, 3), shape (...)."""
    each = [
        tsai_wu_index(ply.material, stress[..., k, :, :]).max(axis=-1) for k, ply in enumerate(laminate.plies)
    ]
    return np.asarray(np.max(each, axis=0))

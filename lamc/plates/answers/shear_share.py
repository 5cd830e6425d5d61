"""How much a solution of classical theory leaves out: shear through the thickness, by the shear forces that it calls
for.

In: a solution. Out: energy of shear over energy of bending, and a sentence where it matters. Never: a span, which a
plate with holes, supports inside or clamped edges does not have.

Equilibrium gives the shear forces, Q = div M, with M by patches of cells (`recovery.py`). Their energy ½ ∫ Qᵀ H⁻¹ Q
dA is what the loads would do more of, were shear not held back (Castigliano's second theorem, with M as bending
finds it): over the energy of bending it is the part that is missing of the deflection where the loads act. M itself
would change, so as to store less: nothing of a simply supported square, a third of a clamped one. So this is a bound
from above, but for what patches lose of Q on coarse meshes (a third on 8 cells across of a clamped square), and but
for a layer along free edges, as wide as the plate is thick, in which classical theory lets M_xy end as forces.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from shapely.geometry import MultiPoint, Point

from lamc.basics.checks import Array
from lamc.plates.answers.estimate import integration_points
from lamc.plates.elements.definition import CORNERS
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.loads import PointLoad

if TYPE_CHECKING:
    from lamc.plates.meshing.mesh import Mesh
    from lamc.plates.solving.solution import Solution

TOLD = 0.01  # of the deflection; less is below what a mesh leaves
_TRIANGLES = ("bciz", "dkt", "specht")
# The element's own moments give 0.8 to 2.5 times the share by patches on 3 to 32 cells across, and cost a tenth:
# patches are not made where these give less than this part of TOLD. On few cells patches lose most of it, down to a
# fifth of what is missing on 2 cells across, and the larger of the two is told.
_ROUGH, _FEW = 0.2, 100


def shear_share(solution: "Solution") -> float:
    """Of one solution; inf across a gap, 0 where nothing bends."""
    if any(_has_gap(laminate) for laminate in solution.problem.laminates):
        return math.inf
    if solution.problem.dofs.element.shear:
        return _own_share(solution)
    share = _share(solution, _corner_values(solution, recovered=True))
    if len(solution.problem.mesh.cells) < _FEW:
        share = max(share, _share(solution, _corner_values(solution, recovered=False)))
    return share


def shear_notes(solution: "Solution") -> tuple[str, ...]:
    """A sentence where classical theory leaves out more than `TOLD` of the deflection, or where an element with shear
    has one that no mesh comes to the end of."""
    element = solution.problem.dofs.element
    if not element.bends or not solution.values.any():
        return ()
    if element.shear:
        return _point_notes(solution)
    if any(_has_gap(laminate) for laminate in solution.problem.laminates):
        return (
            "a laminate has a gap, in which nothing bears shear through the thickness: the plies on both sides "
            "would slide past each other, and the plate is softer than classical theory says",
        )
    share = _told_share(solution)
    return (shear_text(share, element.name),) if share >= TOLD else ()


def _point_notes(solution: "Solution") -> tuple[str, ...]:
    """Under a force at a point w goes as P ln(1/r) / 2π √det H, and so by P ln 2 / 2π √det H with every halving."""
    problem = solution.problem
    forces = [abs(load.force[2]) for load in solution.loads if isinstance(load, PointLoad)]  # type: ignore[index]
    points = [each for each in solution.reactions if isinstance(each.where, Point | MultiPoint)]
    forces += [float(np.abs(each.values[:, 2]).max()) for each in points if len(each.values)]
    softest = min(math.sqrt(np.linalg.det(laminate.H)) for laminate in problem.laminates)
    grows = math.log(2.0) * max(forces, default=0.0) / (2.0 * math.pi * softest)
    largest = float(np.abs(solution.at_nodes("w")).max())
    if not largest > 0.0 or grows < TOLD * largest:
        return ()
    return (
        "with shear through the thickness the deflection under a force at a point, or beside a support at one, has no "
        f"bound: it grows by up to {1e6 * grows:.2g} µm, {100.0 * grows / largest:.2g} % of the largest, with every "
        "halving of the cells; spread the force or the support over an area",
    )


def shape_notes(what: str, shapes: Mapping[int, "Solution"], power: float) -> tuple[str, ...]:
    """A sentence where shear takes more than `TOLD` off numbers that belong to shapes, frequencies (`power` 1/2) or
    critical loads (1); `what` is one of them, and `shapes` are by number, without rigid ones, which store nothing."""
    chosen = next((shape.problem.dofs.element for shape in shapes.values()), None)
    if chosen is None or chosen.shear or not chosen.bends:
        return ()
    lost = {k: 1.0 - (1.0 + _told_share(shape)) ** -power for k, shape in shapes.items()}
    worst = max(lost, key=lost.__getitem__)
    if lost[worst] < TOLD:
        return ()
    return (
        f"shear through the thickness, which element {chosen.name!r} leaves out, would lower {what} {worst + 1} by up "
        f"to about {100.0 * lost[worst]:.2g} %, and others less{_instead(chosen.name)}",
    )


def _told_share(solution: "Solution") -> float:
    """Patches only where it is worth their price."""
    if any(_has_gap(laminate) for laminate in solution.problem.laminates):
        return math.inf
    rough = _share(solution, _corner_values(solution, recovered=False))
    return 0.0 if rough < _ROUGH * TOLD else shear_share(solution)


def _instead(element: str) -> str:
    """What has shear."""
    bending, plus, membrane = element.partition("+")
    if bending not in _TRIANGLES:
        return ""
    return f"; element {'dkmt' + plus + membrane!r} has it and tells how much"


def shear_text(share: float, element: str) -> str:
    """The sentence."""
    percent = float(f"{100.0 * share:.2g}")
    return (
        f"shear through the thickness, which element {element!r} leaves out, would add up to about {percent:g} % to "
        f"the deflection where the loads act{_instead(element)}"
    )


def _own_share(solution: "Solution") -> float:
    """Of an element with shear."""
    mesh, laminates = solution.problem.mesh, solution.problem.laminates
    H = np.array([laminate.H for laminate in laminates])[mesh.regions]
    neutral = np.array([_neutral(laminate) for laminate in laminates])[mesh.regions]
    sheared = bent = 0.0
    for point, weight in integration_points(solution.problem.dofs.element.cell):
        xi = np.tile(point, (len(mesh.cells), 1))
        gamma, kappa = solution.cell_shear(xi), solution.cell_strains(xi)[:, -3:]
        sheared += weight * float(np.einsum("m,mi,mij,mj->", mesh.areas, gamma, H, gamma))
        bent += weight * float(np.einsum("m,mi,mij,mj->", mesh.areas, kappa, neutral, kappa))
    bent += 2.0 * math.fsum(solution.hinge_energy(k) for k in range(len(solution.problem.hinges)))
    return sheared / bent if bent > 0.0 else 0.0


def _neutral(laminate: Laminate) -> Array:
    """D about the neutral surface, (3, 3)."""
    return np.asarray(laminate.D - laminate.B @ np.linalg.solve(laminate.A, laminate.B))


def _has_gap(laminate: Laminate) -> bool:
    return any(ply.gap > 0.0 for ply in laminate.plies)


def _corner_values(solution: "Solution", *, recovered: bool) -> Array:
    """Strains at the corners of cells, (m, c, 3 or 6): by patches, or the element's own."""
    problem = solution.problem
    cells = np.arange(len(problem.mesh.cells), dtype=np.int32)
    found = []
    for corner in CORNERS[problem.dofs.element.cell]:
        xi = np.tile(np.array(corner, dtype=float), (len(cells), 1))
        found.append(solution.recovered_strains.at(cells, xi) if recovered else solution.cell_strains(xi))
    return np.stack(found, axis=1)


def _share(solution: "Solution", strains: Array) -> float:
    """From strains at the corners of cells, (m, c, 3 or 6)."""
    problem = solution.problem
    mesh, stretches = problem.mesh, problem.dofs.element.stretches
    laws = [_laws(laminate, stretches) for laminate in problem.laminates]
    law, neutral, softness = (np.array(part)[mesh.regions] for part in zip(*laws, strict=True))
    cells = np.arange(len(mesh.cells), dtype=np.int32)
    free = np.stack(
        [solution.expansion.at(cells, mesh.corners[:, k])[:, -3:] for k in range(mesh.corner_count)], axis=1
    )
    moments = np.einsum("mij,mcj->mci", law, strains) - free
    slopes = np.einsum("mca,mci->mai", _gradients(mesh), moments)
    Q = np.stack([slopes[:, 0, 0] + slopes[:, 1, 2], slopes[:, 0, 2] + slopes[:, 1, 1]], axis=1)
    sheared = 0.5 * float(np.einsum("m,mi,mij,mj->", mesh.areas, Q, softness, Q))
    curvature = strains[..., -3:]
    bent = 0.5 * float(np.einsum("m,mci,mij,mcj->", mesh.areas, curvature, neutral, curvature))
    bent /= mesh.corner_count
    bent += math.fsum(solution.hinge_energy(k) for k in range(len(problem.hinges)))
    return sheared / bent if bent > 0.0 else 0.0


def _laws(laminate: Laminate, stretches: bool) -> tuple[Array, Array, Array]:
    """Moments by strains (3, 3 or 6), bending about the neutral surface (3, 3), H⁻¹."""
    law = np.concatenate([laminate.B, laminate.D], axis=1) if stretches else laminate.D
    return np.asarray(law), _neutral(laminate), np.asarray(np.linalg.inv(laminate.H), dtype=float)


def _gradients(mesh: "Mesh") -> Array:
    """At the centres of cells, of the functions that are 1 at one corner and linear or bilinear between, (m, c, 2),
    1/m."""
    if mesh.corner_count == 3:
        natural = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    else:
        natural = 0.25 * np.array(CORNERS["square"], dtype=float)
    jacobian = np.einsum("ca,mci->mai", natural, mesh.corners)  # rows by ξ and η
    return np.asarray(np.linalg.solve(jacobian[:, None], natural[None, :, :, None])[..., 0])

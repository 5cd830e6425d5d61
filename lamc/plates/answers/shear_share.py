"""How much a solution of classical theory leaves out: shear through the thickness, by the shear forces that it calls
for.

In: a solution. Out: energy of shear over energy of bending (`shear_energy.py`), and a sentence where it matters. Never:
a second solve.

The share is what is missing of the work of the loads, and so of the deflection where these act: the middle of a clamped
square under pressure has two thirds of it (19 % where the share is 28 %). Against what 'dkmt' adds, on meshes that show
both, it is between 0.78 and 1.3 (`tests/plates/test_plate_shear_truth.py`), and it stays as cells are halved.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from shapely.geometry import MultiPoint, Point

from lamc.basics.checks import Array
from lamc.plates.answers.estimate import integration_points
from lamc.plates.answers.shear_energy import ShearEnergy, neutral_bending, shear_energy
from lamc.plates.elements.definition import CORNERS
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.loads import PointLoad

if TYPE_CHECKING:
    from lamc.plates.answers.solution import Solution

REPORTED = 0.01  # of the deflection; less is below what a mesh leaves
_TRIANGLES = ("bciz", "dkt", "specht")
# The element's own moments give 0.8 to 2.5 times the share by patches on 3 to 32 cells across, and cost a tenth:
# patches are not made where these give less than this part of TOLD. On few cells patches lose most of it, down to a
# fifth of what is missing on 2 cells across, and the larger of the two is reported.
_ROUGH, _FEW = 0.2, 100


def shear_share(solution: "Solution") -> float:
    """Of one solution; inf across a gap, 0 where nothing bends."""
    if any(_has_gap(laminate) for laminate in solution.problem.laminates):
        return math.inf
    if solution.problem.dofs.element.shear:
        return _own_share(solution)
    return _energy(solution).share


def shear_notes(solution: "Solution") -> tuple[str, ...]:
    """A sentence where classical theory leaves out more than `REPORTED` of the deflection, or where an element with
    shear has one that no mesh comes to the end of."""
    element = solution.problem.dofs.element
    if not element.bends or not solution.values.any():
        return ()
    if element.shear:
        return (*_point_notes(solution), *_layer_notes(solution))
    if any(_has_gap(laminate) for laminate in solution.problem.laminates):
        return (
            "a laminate has a gap, in which nothing bears shear through the thickness: the plies on both sides "
            "would slide past each other, and the plate is softer than classical theory says",
        )
    found = _reported_energy(solution)
    return (_shear_text(found, element.name),) if found.share >= REPORTED else ()


def _point_notes(solution: "Solution") -> tuple[str, ...]:
    """Under a force at a point w goes as P ln(1/r) / 2π √det H, and so by P ln 2 / 2π √det H with every halving."""
    problem = solution.problem
    forces = [abs(load.force[2]) for load in solution.loads if isinstance(load, PointLoad)]  # type: ignore[index]
    points = [each for each in solution.reactions if isinstance(each.where, Point | MultiPoint)]
    forces += [float(np.abs(each.values[:, 2]).max()) for each in points if len(each.values)]
    softest = min(math.sqrt(np.linalg.det(laminate.H)) for laminate in problem.laminates)
    grows = math.log(2.0) * max(forces, default=0.0) / (2.0 * math.pi * softest)
    largest = float(np.abs(solution.at_nodes("w")).max())
    if not largest > 0.0 or grows < REPORTED * largest:
        return ()
    return (
        "with shear through the thickness the deflection under a force at a point, or beside a support at one, has no "
        f"bound: it grows by up to {1e6 * grows:.2g} µm, {100.0 * grows / largest:.2g} % of the largest, with every "
        "halving of the cells; spread the force or the support over an area",
    )


def _layer_notes(solution: "Solution") -> tuple[str, ...]:
    """Of an element with shear, on cells that do not show the layers along free edges."""
    found = _layers(solution)
    if found.missed < REPORTED:
        return ()
    return (
        f"{_layer_text(found)} add about {100.0 * found.missed:.2g} % to the deflection where the loads act",
    )


def _layer_text(found: ShearEnergy) -> str:
    return (
        f"along free edges shear through the thickness keeps to layers {1e3 * found.layer:.2g} mm wide, and cells are "
        f"{found.cells / found.layer:.2g} times as long there: finer ones would"
    )


def shape_notes(what: str, shapes: Mapping[int, "Solution"], power: float) -> tuple[str, ...]:
    """A sentence where shear takes more than `REPORTED` off numbers that belong to shapes, frequencies (`power` 1/2) or
    critical loads (1); `what` is one of them, and `shapes` are by number, without rigid ones, which store nothing.
    Of an element with shear it is the shear that its cells do not show."""
    chosen = next((shape.problem.dofs.element for shape in shapes.values()), None)
    if chosen is None or not chosen.bends:
        return ()
    layers = {k: _layers(shape) for k, shape in shapes.items()} if chosen.shear else {}
    if chosen.shear:
        shares = {k: found.missed for k, found in layers.items()}
    elif any(_has_gap(laminate) for laminate in next(iter(shapes.values())).problem.laminates):
        shares = dict.fromkeys(shapes, math.inf)
    else:
        shares = {k: _reported_energy(shape).share for k, shape in shapes.items()}
    lost = {k: 1.0 - (1.0 + share) ** -power for k, share in shares.items()}
    worst = max(lost, key=lost.__getitem__)
    if lost[worst] < REPORTED:
        return ()
    lowered = f"lower {what} {worst + 1} by about {100.0 * lost[worst]:.2g} %, and others less"
    if chosen.shear:
        return (f"{_layer_text(layers[worst])} {lowered}",)
    left_out = f"shear through the thickness, which element {chosen.name!r} leaves out"
    return (f"{left_out}, would {lowered}{_instead(chosen.name)}",)


def _reported_energy(solution: "Solution") -> ShearEnergy:
    """Patches only where they are worth their price."""
    rough = _energy_of(solution, recovered=False)
    return rough if rough.share < _ROUGH * REPORTED else _energy(solution)


def _energy(solution: "Solution") -> ShearEnergy:
    """By patches; of few cells the larger of both."""
    ways = (True, False) if len(solution.problem.mesh.cells) < _FEW else (True,)
    return max((_energy_of(solution, recovered=way) for way in ways), key=lambda found: found.share)


def _layers(solution: "Solution") -> ShearEnergy:
    """Of an element with shear: what it shows least of."""
    return shear_energy(solution, _corner_values(solution, recovered=False), layers_only=True)


def _energy_of(solution: "Solution", *, recovered: bool) -> ShearEnergy:
    """From strains by patches, or the element's own."""
    return shear_energy(solution, _corner_values(solution, recovered=recovered))


def _instead(element: str, found: ShearEnergy | None = None) -> str:
    """What has shear, and on which cells where layers along free edges are most of `found`."""
    bending, plus, membrane = element.partition("+")
    if bending not in _TRIANGLES:
        return ""
    text = f"; element {'dkmt' + plus + membrane!r} has it and tells how much"
    if found is None or found.along <= found.inside or found.cells <= found.layer:
        return text
    finer = found.cells / found.layer
    return f"{text}, with cells {finer:.2g} times as fine along free edges, where most of it is"


def _shear_text(found: ShearEnergy, element: str) -> str:
    """The sentence."""
    percent = float(f"{100.0 * found.share:.2g}")
    return (
        f"shear through the thickness, which element {element!r} leaves out, would add about {percent:g} % to the "
        f"deflection where the loads act{_instead(element, found)}"
    )


def _own_share(solution: "Solution") -> float:
    """Of an element with shear."""
    mesh, laminates = solution.problem.mesh, solution.problem.laminates
    H = np.array([laminate.H for laminate in laminates])[mesh.regions]
    neutral = np.array([neutral_bending(laminate) for laminate in laminates])[mesh.regions]
    sheared = bent = 0.0
    for point, weight in integration_points(solution.problem.dofs.element.cell):
        xi = np.tile(point, (len(mesh.cells), 1))
        gamma, kappa = solution.cell_shear(xi), solution.cell_strains(xi)[:, -3:]
        sheared += weight * float(np.einsum("m,mi,mij,mj->", mesh.areas, gamma, H, gamma))
        bent += weight * float(np.einsum("m,mi,mij,mj->", mesh.areas, kappa, neutral, kappa))
    bent += 2.0 * solution.spring_energy
    return sheared / bent if bent > 0.0 else 0.0


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

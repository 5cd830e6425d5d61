"""Where a plate fails first: the ply, its face and the place at which the strength ratio is least.

In: a `Solution`. Out: one record. Never: what the plate still carries afterwards.

Strains are the recovered ones (`estimate.py`), at the corners of cells. Where they grow without bound, as in a notch or
under a point load, so does the index with every finer mesh, and the ratio means nothing: the record says so.
"""

from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array, shown
from lamc.basics.errors import DesignError
from lamc.plates.answers.recovery import RecoveredStrains
from lamc.plates.answers.sharp_places import sharp_place
from lamc.plates.answers.solution import Solution
from lamc.plates.elements.definition import CORNERS
from lamc.plates.laminates.failure import (
    CRITERIA,
    INTERACTION,
    MODES,
    PlyFailure,
    ply_failures,
    require_strengths,
)
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.plies import Ply
from lamc.plates.laminates.sections import couples
from lamc.plates.meshing.mesh import Integers

_FACES = ("lower", "upper")
# Clamped squares of 20 cells under pressure are within it, with ratios within 3 %.
COARSE = 0.1
_SAME = 1e-9  # relative: ratios nearer to each other than this differ by round-off


@dataclass(frozen=True, eq=False)
class PlateFailure:
    """The first failure of a plate when all that acts grows together; `str` says it in a line.

    at        m
    ratio     times all that acts: loads, prescribed displacements, expansion; inf where nothing makes stress
    number    of the ply in its laminate, 1 for the lowest
    unjudged  regions left out, since the strengths of a material there are not known
    off       part by which the ratio differs from that by the element's own strains there: large where cells are too
              coarse to show what the moments do
    sharp     what makes strains grow without bound there; "" if nothing does
    stiff     whether the plies couple bending and stretching there and the membrane is of constant strains
    """

    criterion: str
    ratio: float
    at: tuple[float, float]
    region: str
    number: int
    ply: Ply
    face: str  # "lower" or "upper"
    mode: str  # of the largest stress over strength there: one of failure.MODES
    unjudged: tuple[str, ...]
    off: float = 0.0
    sharp: str = ""
    stiff: bool = False

    @property
    def notes(self) -> tuple[str, ...]:
        """Why the ratio may not hold."""
        found = []
        if self.sharp:
            found.append(
                f"the first failure is {self.sharp}, where stress of thin-plate theory has no bound: the ratio falls "
                "with every finer mesh and is no strength; round the corner, or spread the force or the support"
            )
        if self.off > COARSE:
            found.append(
                f"the strength ratio is {100.0 * self.off:.0f} % from the one by the element's own strains: cells are "
                "too coarse there; make them finer until it stays"
            )
        if self.stiff:
            found.append(
                "the plies that fail couple bending and stretching, and element 'cst' is too stiff for that: the "
                "strength ratio may be 10 % too large on 20 cells a side, and 25 % on ten; take 'dkt+lst'"
            )
        return tuple(found)

    def __str__(self) -> str:
        where = f" of region {self.region!r}" if self.region else ""
        x, y = (coordinate * 1e3 for coordinate in self.at)
        return (
            f"ply {self.number} from the bottom{where} ({self.ply.angle:g}°) fails first, at ({x:.4g}, {y:.4g}) mm on "
            f"its {self.face} face in {self.mode}, at {self.ratio:.4g} times what acts ({self.criterion})"
        )


def first_failure(
    solution: Solution, criterion: str = "tsai-wu", interaction: float = INTERACTION
) -> PlateFailure:
    """The ply and place of a solution that fail first.

    criterion    "tsai-wu" or "max-stress"
    interaction  F12 / sqrt(F11 F22) of Tsai-Wu

    Raises DesignError where no region has the strengths of all its materials, and for an unknown criterion.
    """
    if criterion not in CRITERIA:
        raise DesignError(f"the criterion is {shown(criterion)}; it must be one of {', '.join(CRITERIA)}")
    problem = solution.problem
    mesh, element = problem.mesh, problem.dofs.element
    judged = [k for k, laminate in enumerate(problem.laminates) if _is_known(laminate)]
    if not judged:
        require_strengths(problem.laminates[0])
    recovered = solution.recovered_strains
    best: tuple[float, int, PlyFailure, int, int] | None = None
    for region in judged:
        cells = np.flatnonzero(mesh.regions == region).astype(np.int32)
        if not len(cells):
            continue
        strains = _at_corners(recovered, cells, element.cell)
        climate = solution.climates[region].at(mesh.corners[cells])
        plies = ply_failures(
            problem.laminates[region],
            strains[..., :3] if element.stretches else np.zeros(3),
            strains[..., -3:] if element.bends else np.zeros(3),
            temperature=climate.temperature,
            moisture=climate.moisture,
            fields=climate.fields,
            interaction=interaction,
        )
        for ply in plies:
            ratio = ply.tsai_wu_ratio if criterion == "tsai-wu" else ply.max_stress_ratio
            least = float(ratio.min())
            if best is None or least < best[0] * (1.0 - _SAME):
                place = int(np.flatnonzero(ratio.ravel() <= least * (1.0 + _SAME))[0])
                best = (least, region, ply, place, int(cells[place // (2 * strains.shape[1])]))
    assert best is not None
    least, region, ply, place, cell = best
    corner, face = (place // 2) % mesh.corner_count, place % 2
    at = mesh.corners[cell, corner]
    own = _own_ratio(solution, criterion, interaction, (cell, corner, region, ply.number, face))
    return PlateFailure(
        criterion=criterion,
        ratio=least,
        at=(float(at[0]), float(at[1])),
        region=mesh.region_names[region],
        number=ply.number,
        ply=ply.ply,
        face=_FACES[face],
        mode=MODES[int(ply.mode.ravel()[place])],
        unjudged=tuple(mesh.region_names[k] for k in range(len(problem.laminates)) if k not in judged),
        off=_apart(least, own),
        stiff="cst" in element.name and couples(problem.laminates[region]),
        sharp=sharp_place(solution, at, float(np.hypot(*(mesh.corners[cell] - at).T).max()))
        if np.isfinite(least)
        else "",
    )


def _apart(one: float, other: float) -> float:
    """Part of the larger by which two ratios differ; either may be 0 or inf."""
    if one == other:
        return 0.0
    return 1.0 - min(one, other) / max(one, other)


def _own_ratio(
    solution: Solution, criterion: str, interaction: float, where: tuple[int, int, int, int, int]
) -> float:
    """Strength ratio by the element's own strains: at a corner of a cell, of a region, of a ply, on a face."""
    cell, corner, region, number, face = where
    problem = solution.problem
    element = problem.dofs.element
    xi = np.tile(np.array(CORNERS[element.cell][corner], dtype=float), (len(problem.mesh.cells), 1))
    strains = solution.cell_strains(xi)[cell]
    climate = solution.climates[region].at(problem.mesh.corners[cell, corner])
    plies = ply_failures(
        problem.laminates[region],
        strains[:3] if element.stretches else np.zeros(3),
        strains[-3:] if element.bends else np.zeros(3),
        temperature=climate.temperature,
        moisture=climate.moisture,
        fields=climate.fields,
        interaction=interaction,
    )
    ply = next(one for one in plies if one.number == number)
    ratio = ply.tsai_wu_ratio if criterion == "tsai-wu" else ply.max_stress_ratio
    return float(ratio[face])


def _is_known(laminate: Laminate) -> bool:
    try:
        require_strengths(laminate)
    except DesignError:
        return False
    return True


def _at_corners(recovered: RecoveredStrains, cells: Integers, kind: str) -> Array:
    """Strains at the corners of cells, shape (cells, corners, 3 or 6)."""
    places = np.array(CORNERS[kind], dtype=float)
    return np.stack([recovered.at(cells, np.tile(xi, (len(cells), 1))) for xi in places], axis=1)

"""Regions beside each other whose laminates lie about their own middles: a patch on one face that became concentric.

In: a problem. Out: sentences. Never: raises for it, as thickening on both faces is as good a design.
"""

import numpy as np

from lamc.plates.laminates.laminate import Laminate
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.problem import Problem

_SAME = 1e-6  # of the thickness: heights nearer to each other are one
_MOST = 3  # pairs that are reported


def offset_texts(problem: Problem) -> tuple[str, ...]:
    """A note on each pair of regions side by side, both about the middle of their thickness, where the thinner one does
    not go on in the thicker one at its own height: then both faces jump at their border."""
    found = []
    names = problem.mesh.region_names
    for one, other in beside(problem.mesh):
        thin, thick = sorted((one, other), key=lambda region: problem.laminates[region].thickness)
        base, patch = problem.laminates[thin], problem.laminates[thick]
        step = patch.thickness - base.thickness
        if base.reference != "middle" or patch.reference != "middle" or step <= _SAME * patch.thickness:
            continue
        if _goes_on(base, patch):
            continue
        found.append(
            f"region {names[thick] or 'the rest'!r} is {1e3 * step:.4g} mm thicker than {names[thin] or 'the rest'!r} "
            "beside it, and both lie about their own middle, so half of that is taken to be below, half above: right "
            "for thickening on both faces; for a patch on one face give both laminates reference: bottom (the patch is "
            "on top) or top, or their heights, as otherwise a pull does not bend the plate there"
        )
    more = len(found) - _MOST
    return (*found[:_MOST], *([f"{more} more pairs of regions lie so"] if more > 0 else []))


def beside(mesh: Mesh) -> list[tuple[int, int]]:
    """Pairs of regions that share an edge, each once, ascending."""
    region = np.repeat(mesh.regions, mesh.corner_count)
    low, high = np.full(len(mesh.edges), len(mesh.region_names)), np.full(len(mesh.edges), -1)
    np.minimum.at(low, mesh.cell_edges.ravel(), region)
    np.maximum.at(high, mesh.cell_edges.ravel(), region)
    pairs = np.unique(np.stack([low, high], axis=1)[low < high], axis=0)
    return [(int(one), int(other)) for one, other in pairs]


def _goes_on(base: Laminate, patch: Laminate) -> bool:
    """Whether every ply of `base` is in `patch` too, at the same height: plies were added on both faces."""
    if len(patch.plies) <= len(base.plies):
        return False
    near = _SAME * patch.thickness
    there = list(zip(patch.plies, patch.heights, strict=True))
    return all(
        any(
            (other.material, other.angle) == (ply.material, ply.angle) and np.abs(z - height).max() <= near
            for other, z in there
        )
        for ply, height in zip(base.plies, base.heights, strict=True)
    )

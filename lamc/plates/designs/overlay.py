"""Sheets above one another, seen from above: regions in which the stack is one and the same.

In: the polygons of each layer. Out: disjoint regions, each with the layers that lie there. Never: materials, bodies.

Edges that are drawn twice, once per layer, coincide up to round-off or not quite; what lies between them is a sliver.
All is brought to a grid far finer than the tolerance first, and slivers are given to the neighbour with which they
share most of their edge.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from lamc.design.work import Account

GRID = 1e-3  # largest spacing of the grid of coordinates, in tolerances

Stack = tuple[int, ...]  # layers from the bottom up


@dataclass(frozen=True, eq=False)
class Overlay:
    """Disjoint regions by stack, in ascending order of stacks."""

    regions: Mapping[Stack, MultiPolygon]
    moved: float  # m², area of the slivers that went to a neighbour
    slivers: int  # how many these were


def overlay(layers: Sequence[BaseGeometry], tolerance: float) -> Overlay:
    """Regions of equal stack.

    layers     the area of each layer, m
    tolerance  what is narrower is a sliver, m

    Raises DesignError where outlines of different layers cross too often, or are too many.
    """
    grid = _spacing(tolerance)
    _check_work(layers)
    cells: dict[Stack, MultiPolygon] = {}
    covered = MultiPolygon()
    for index, sheet in enumerate(layers):
        with np.errstate(all="ignore"):  # GEOS leaves flags of divisions behind whose results it does not use
            area = areas_of(shapely.set_precision(sheet, grid))
        parted: dict[Stack, MultiPolygon] = {
            (index,): areas_of(shapely.difference(area, covered, grid_size=grid))
        }
        for stack, cell in cells.items():
            parted[stack] = areas_of(shapely.difference(cell, area, grid_size=grid))
            parted[(*stack, index)] = areas_of(shapely.intersection(cell, area, grid_size=grid))
        cells = {stack: part for stack, part in parted.items() if not part.is_empty}
        covered = areas_of(shapely.union(covered, area, grid_size=grid))
    return _without_slivers({stack: list(cells[stack].geoms) for stack in sorted(cells)}, tolerance)


def _check_work(layers: Sequence[BaseGeometry]) -> None:
    """Layers that are alike, as most are, make no regions of their own."""
    account, distinct = Account(), dict.fromkeys(layer.wkb for layer in layers)
    account.overlay([*shapely.from_wkb(list(distinct))], "the outlines of the plate's layers")


def areas_of(geometry: BaseGeometry) -> MultiPolygon:
    """Lines and points, where areas touch, are left out."""
    return MultiPolygon(polygons_of(geometry))


def polygons_of(geometry: BaseGeometry) -> list[Polygon]:
    """The polygons in any geometry, in an order that depends on geometry alone."""
    parts: list[Polygon] = []
    queue = list(shapely.get_parts(shapely.normalize(geometry)))
    while queue:
        part = queue.pop(0)
        if hasattr(part, "geoms"):
            queue = [*part.geoms, *queue]
        elif isinstance(part, Polygon) and part.area > 0.0:
            parts.append(part)
    return sorted(parts, key=lambda p: (*p.bounds, p.area))


def is_sliver(polygon: Polygon, tolerance: float) -> bool:
    """Whether no circle of that diameter fits into it."""
    return bool(shapely.buffer(polygon, -0.5 * tolerance).is_empty)


def _spacing(tolerance: float) -> float:
    """Of the grid, m: a power of ten, which leaves coordinates where they are that were drawn in mm or µm."""
    return float(10.0 ** math.floor(math.log10(GRID * tolerance)))


def _without_slivers(cells: Mapping[Stack, Sequence[Polygon]], tolerance: float) -> Overlay:
    grid = _spacing(tolerance)
    kept = {stack: [p for p in parts if not is_sliver(p, tolerance)] for stack, parts in cells.items()}
    slivers = [p for parts in cells.values() for p in parts if is_sliver(p, tolerance)]
    whole = {stack: shapely.MultiPolygon(parts) for stack, parts in kept.items() if parts}
    given: dict[Stack, list[Polygon]] = {}
    moved, count = 0.0, 0
    for sliver in slivers:
        near = shapely.buffer(sliver, 2.0 * grid)
        shared = [
            (shapely.intersection(near, region.boundary).length, stack) for stack, region in whole.items()
        ]
        longest, stack = max(shared, key=lambda pair: (pair[0], [-k for k in pair[1]]), default=(0.0, ()))
        if longest > 0.0:
            given.setdefault(stack, []).append(sliver)
            moved, count = moved + sliver.area, count + 1
    for stack, parts in given.items():
        # Closed by the width of the grid, for edges that meet in round-off only.
        joined = shapely.union_all([whole[stack], *parts], grid_size=grid)
        whole[stack] = shapely.MultiPolygon([p for p in polygons_of(joined) if not is_sliver(p, tolerance)])
    ordered = {stack: shapely.MultiPolygon(polygons_of(whole[stack])) for stack in sorted(whole)}
    return Overlay(ordered, moved, count)


def stack_name(stack: Stack, names: Sequence[str], present: Sequence[int]) -> str:
    """What a region is called: its layers, bottom to top, or those it lacks where these are fewer.

    names    of all layers
    present  the layers that occur in any region
    """
    lacking = [k for k in present if k not in stack]
    if not lacking and len(present) > 1:
        return "all layers"
    if len(stack) > 2 and len(lacking) < len(stack):
        return "all but " + "+".join(names[k] for k in lacking)
    return "+".join(names[k] for k in stack)


def default_tolerance(size: float, narrowest: float) -> float:
    """What counts as a sliver, m: a millionth of the drawing's size, and at most a fiftieth of the narrowest hinge."""
    return min(1e-6 * size, narrowest / 50.0) if math.isfinite(narrowest) else 1e-6 * size

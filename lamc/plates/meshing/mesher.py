"""Triangles for any polygon: with holes, regions that share borders, and a size for each.

In: shapely polygons in m. Out: a `Mesh` whose edges follow every border. Never: materials, supports.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array, checked_number, shown
from lamc.basics.errors import DesignError
from lamc.plates.memory import available_memory
from lamc.plates.meshing.checks import MOST_CELLS, PEAK_BYTES, memory_of, place
from lamc.plates.meshing.linework import Divided, Linework, corner_sizes, count_of_parts, divide, linework
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.meshing.native import Full, Lines, MesherError, Triangulation, triangulate
from lamc.plates.meshing.outlines import (
    TOLERANCE,
    Area,
    check_area,
    checked_followed,
    checked_regions,
    extent_of,
    paths_of,
)
from lamc.plates.meshing.scaling import MeshScaling, frame_of

Integers = NDArray[np.int32]

GRADING = 0.3

_LEAST = 3e-4  # of the wanted size: no shorter edges for the sake of angles
_PER_PART = (
    2.5  # triangles from a part of a border on one side until they have their full size, times the grading
)
_SPARE = 1.3  # triangles there are over those of wanted edges on the area
_NARROW = 0.6  # triangles of a narrow plate over its border in widths, measured
_DIGITS = 1e-6  # of the size: coarsest step between coordinates
_AROUND = 8.0  # half the side of the box around all, over the extent


def mesh(
    polygon: Area,
    size: float,
    *,
    regions: Mapping[str, Area] | None = None,
    sizes: Mapping[str, float] | None = None,
    follow: Sequence[BaseGeometry] = (),
    grading: float = GRADING,
    limit: int = MOST_CELLS,
) -> Mesh:
    """Triangles with edges of about `size` m, all corners and borders of the polygon among theirs.

    regions   polygons inside by name, which may share borders but not area; what is in none belongs to region ""
    sizes     size per region, m, where it is not `size`; "" for what is in none
    follow    lines and points inside, which edges and corners shall be on, for supports and loads there
    grading   how much edges grow per length from where they are short, 0.05 to 1
    limit     largest number of triangles

    Edges are shorter where the outline has short segments or narrow strips, and grow away from there. Edges are 0.9
    of the size on average and 1.5 at most. Angles are 25° at least; beside corners of the outline below 60°, about two
    fifths of the corner's; and any where gaps or segments are below a thousandth of the size. The same input gives the
    same mesh, byte for byte.

    Raises DesignError for polygons that are empty or cross themselves, or hang together at a point only; for regions
    that overlap, and regions, lines or points that lie outside; for sizes that are not positive or would give more
    triangles than the limit. Raises BuildError without a C compiler.
    """
    plan = _planned(polygon, size, regions or {}, sizes or {}, follow, grading)
    most = checked_number(limit, "the limit of a mesh", minimum=1.0)
    _check_count(plan.expected, most, plan.wanted)
    divided = divide(plan.lines, plan.at_corners, plan.grading)
    return _mesh_of(_triangulate(plan, divided, most), plan)


def expected_cells(
    polygon: Area,
    size: float,
    *,
    regions: Mapping[str, Area] | None = None,
    sizes: Mapping[str, float] | None = None,
    follow: Sequence[BaseGeometry] = (),
    grading: float = GRADING,
) -> float:
    """About how many triangles `mesh` makes of the same, before it makes any; raises DesignError as it does."""
    return _planned(polygon, size, regions or {}, sizes or {}, follow, grading).expected


@dataclass(frozen=True, eq=False)
class _Plan:
    """What is to be meshed, in the coordinates of `frame`.

    sizes       of what is in no region, then of each region; wanted: the same, m, for messages
    at_corners  size at each corner of the lines
    expected    triangles, about
    """

    polygon: Area
    regions: Mapping[str, Area]
    sizes: Array
    wanted: Array
    grading: float
    lines: Linework
    at_corners: Array
    expected: float
    frame: MeshScaling

    def regions_at(self, points: Array) -> Integers:
        """Number of the region, from 1; 0 for none, and -1 outside the plate."""
        places = shapely.points(points)
        index = np.where(shapely.contains(self.polygon, places), 0, -1).astype(np.int32)
        for number, area in enumerate(self.regions.values(), start=1):
            index[shapely.contains(area, places)] = number
        return index


def _planned(
    polygon: Area,
    size: float,
    regions: Mapping[str, Area],
    sizes: Mapping[str, float],
    follow: Sequence[BaseGeometry],
    grading: float,
) -> _Plan:
    check_area(polygon, "the polygon of a mesh")
    named = checked_regions(polygon, regions)
    wanted = _checked_sizes(size, named, sizes)
    slope = checked_number(grading, "the grading of a mesh")
    if not 0.05 <= slope <= 1.0:
        raise DesignError(f"the grading of a mesh is {slope:g}; it must be between 0.05 and 1: 0.3 is usual")
    _check_digits(polygon, float(wanted.min()))
    try:
        paths = paths_of(polygon, named, wanted, checked_followed(polygon, follow))
        frame = frame_of(polygon, paths)
        area, parts = frame.moved(polygon), {name: frame.moved(part) for name, part in named.items()}
        sizes_there = frame.lengths(wanted)
        lines = linework([frame.moved_path(path) for path in paths], TOLERANCE)
    except shapely.errors.GEOSException as error:
        raise DesignError(f"the outlines cannot be compared: {error}; round their coordinates") from error
    at_corners = corner_sizes(lines, slope)
    expected = _expected(area, parts, sizes_there, count_of_parts(lines, at_corners, slope), slope)
    return _Plan(area, parts, sizes_there, wanted, slope, lines, at_corners, expected, frame)


def _checked_sizes(size: float, regions: Mapping[str, Area], sizes: Mapping[str, float]) -> Array:
    """Of what is in no region, then of each region."""
    wanted = {"": size, **dict.fromkeys(regions, size)}
    if not isinstance(sizes, Mapping):
        raise DesignError(f"the sizes of a mesh are {shown(sizes)}; give a size by name of region")
    for name, value in sizes.items():
        if name not in wanted:
            raise DesignError(
                f"a size is given for {shown(name)}, which is no region; regions are "
                f"{', '.join(map(repr, wanted))}: correct the name"
            )
        wanted[name] = value
    for name, value in wanted.items():
        what = f"the size of region {name!r}" if name and name in sizes else "the size of a mesh"
        wanted[name] = checked_number(value, what)
        if wanted[name] <= 0.0:
            raise DesignError(f"{what} is {wanted[name]:g} m; it must be positive: the length of an edge")
    return np.array(list(wanted.values()))


def _check_digits(polygon: Area, size: float) -> None:
    farthest, extent = float(np.abs(polygon.bounds).max()), extent_of(polygon)
    if farthest > 2.0 * extent and np.spacing(farthest) > _DIGITS * min(size, extent):
        raise DesignError(
            f"the polygon of a mesh lies {farthest:g} m from the origin, where coordinates have not the digits for a "
            f"size of {size:g} m: move it to the origin"
        )


def _expected(
    polygon: Area, regions: Mapping[str, Area], wanted: Array, parts: float, grading: float
) -> float:
    """About how many triangles there will be: those of wanted edges on the area, and those of the borders; or, where
    that are more, those as high as a plate or a region is wide on average, if cells become that small for it."""
    areas = np.array([polygon.area, *(area.area for area in regions.values())])
    around = np.array([polygon.length, *(area.length for area in regions.values())])
    with np.errstate(over="ignore"):  # beyond all limits is as good as infinite
        width = 2.0 * areas / around
        narrow = np.where(width > _LEAST * wanted, _NARROW * around / np.maximum(width, _LEAST * wanted), 0.0)
        areas[0] = max(0.0, areas[0] - areas[1:].sum())
        on_area = np.sum(areas / wanted / wanted) / (math.sqrt(3.0) / 4.0)
    return float(max(_SPARE * on_area + 2.0 * _PER_PART / grading * parts, narrow.max()))


def _check_count(expected: float, most: float, wanted: Array) -> None:
    """Raises DesignError above the limit, or where there is no memory for so many triangles."""
    if expected > most:
        raise DesignError(_too_many(f"about {expected:.2g}", expected, most, wanted))
    free = available_memory()
    if free is not None and expected * PEAK_BYTES > free:
        raise DesignError(
            f"a mesh of size {wanted.min():g} m would have about {expected:.2g} triangles, {memory_of(expected)}; "
            f"{free / 2**30:.2g} GiB are free: take a larger size, or give a small one to single regions only"
        )


def _too_many(number: str, count: float, most: float, wanted: Array) -> str:
    return (
        f"a mesh of size {wanted.min():g} m would have {number} triangles, {memory_of(count)}; the limit is "
        f"{most:.0f}: take a larger size, or give a small one to single regions only (in Python, `limit` can be raised)"
    )


def _triangulate(plan: _Plan, divided: Divided, most: float) -> Triangulation:
    """Without the box and its points. Doubles the room until it is enough."""
    box = _AROUND * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    native = Lines(
        np.concatenate([box, divided.points]),
        np.concatenate([np.full(4, 2.0 * _AROUND), divided.sizes]),
        np.concatenate([np.full(4, -1, dtype=np.int32), divided.segment_of]),
        divided.parts + np.int32(4),
        plan.lines.segments + np.int32(4),
    )
    capacity = int(1.2 * plan.expected) + 1000
    while True:
        try:
            made = triangulate(native, plan.regions_at, plan.sizes, plan.grading, _LEAST, capacity)
            break
        except MesherError as error:
            raise DesignError(
                f"lines of the polygon or of regions cross near {place(plan.frame.metres(error.at))}; they must meet "
                "in corners: give both the same corners there"
            ) from error
        except Full:
            if capacity > 2.0 * most + 1000:
                raise DesignError(_too_many(f"more than {most:.0f}", most, most, plan.wanted)) from None
            capacity *= 2
    if len(made.cells) > most:
        raise DesignError(_too_many(str(len(made.cells)), len(made.cells), most, plan.wanted))
    return Triangulation(made.points[4:], made.segment_of[4:], made.cells - np.int32(4), made.regions)


def _mesh_of(made: Triangulation, plan: _Plan) -> Mesh:
    """In m, without what is outside; given points exactly where they were."""
    if not len(made.cells):
        raise DesignError(
            f"the polygon of a mesh is thinner than {TOLERANCE:g} of its length; it has no area to mesh"
        )
    points = plan.frame.placed(made.points, len(plan.lines.corners), made.segment_of, plan.lines.segments)
    used, cells = np.unique(made.cells, return_inverse=True)
    cells = cells.reshape(-1, 3)
    present = np.unique(made.regions)
    names = ("", *plan.regions)
    index = np.searchsorted(present, made.regions).astype(np.int32)
    result = Mesh(points[used], cells.astype(np.int32), index, [names[k] for k in present])
    _check_connected(result)
    return result


def _check_connected(mesh: Mesh) -> None:
    cell, side = mesh.boundary_edges.T
    starts = mesh.cells[cell, side]
    meeting = np.flatnonzero(np.bincount(starts, minlength=len(mesh.points)) > 1)
    if len(meeting):
        raise DesignError(
            f"parts of the polygon touch at the single point {place(mesh.points[meeting[0]])}; a plate cannot carry "
            "anything there: give the neck a width, or move the parts apart"
        )

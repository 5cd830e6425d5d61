"""Structured meshes of rectangles.

In: sides and counts, or the lines of the grid. Out: a `Mesh`. Never: other shapes, which are the mesher's.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array, checked_array, checked_number, shown
from lamc.basics.errors import DesignError
from lamc.plates.meshing.checks import MOST_CELLS, memory_of, place
from lamc.plates.meshing.mesh import Integers, Mesh

Geometries = NDArray[np.object_]
Flags = NDArray[np.bool_]

PER_SQUARE = {"one-diagonal": 2, "criss-cross": 4, "union-jack": 2, "squares": 1}  # cells
PATTERNS = tuple(PER_SQUARE)

_UNEQUAL = 1e-9  # of the mean spacing: more than this apart, and the spacing is not equal
_MISFIT = 1e-6  # of a region's area: more than this wrong, and its border does not follow the cells


def grid(
    a: float,
    b: float,
    nx: int,
    ny: int,
    pattern: str = "one-diagonal",
    *,
    origin: Sequence[float] = (0.0, 0.0),
    regions: Mapping[str, BaseGeometry] | None = None,
    limit: int = MOST_CELLS,
) -> Mesh:
    """Rectangle a × b m with its lower left corner at `origin`, in nx × ny equal squares, each

        "one-diagonal"  cut from lower left to upper right: BCIZ converges to the plate's answer on this one only
        "criss-cross"   cut by both diagonals into four triangles
        "union-jack"    cut by diagonals that alternate, so that they meet eight triangles to a point
        "squares"       left whole, for elements with four corners

    regions: polygon by name; a cell belongs to the one that its centre is in, and to "" where there is none.
    limit: largest number of cells.

    Raises DesignError for sides or counts that are not positive, for more cells than the limit, and for a region whose
    border does not follow the edges of cells.
    """
    corner = checked_array(origin, (2,), "the origin of a grid")
    most = checked_number(limit, "the limit of a grid", minimum=1.0)
    positions = []
    for side, count, start, name in ((a, nx, corner[0], "a"), (b, ny, corner[1], "b")):
        length = checked_number(side, f"side {name} of a grid")
        if length <= 0.0:
            raise DesignError(f"side {name} of a grid is {length:g} m; it must be positive")
        _check_count(count, "nx" if name == "a" else "ny", most)
        positions.append(start + length * (np.arange(count + 1) / count))
    return grid_of_lines(positions[0], positions[1], pattern, regions=regions, limit=limit)


def lines(stops: Sequence[float], counts: Sequence[int]) -> Array:
    """Positions of grid lines, m: `counts[k]` equal steps from `stops[k]` to `stops[k + 1]`.

    A hinge 0.1 mm wide between two links, two cells across it: lines((0, 10e-3, 10.1e-3, 20.1e-3), (8, 2, 8)).
    Raises DesignError where there is not one count fewer than stops, or a count is no positive whole number.
    """
    try:
        ends = checked_array(stops, (len(counts) + 1,), "the stops of grid lines")
    except TypeError as error:
        raise DesignError(
            f"the counts of grid lines are {shown(counts)}; give one per step between stops"
        ) from error
    for count in counts:
        _check_count(count, "a count of grid lines", MOST_CELLS)
    parts = [
        start + (end - start) * (np.arange(count) / count)
        for start, end, count in zip(ends[:-1], ends[1:], counts, strict=True)
    ]
    return np.concatenate([*parts, ends[-1:]])


def grid_of_lines(
    x: Sequence[float] | Array,
    y: Sequence[float] | Array,
    pattern: str = "one-diagonal",
    *,
    regions: Mapping[str, BaseGeometry] | None = None,
    limit: int = MOST_CELLS,
) -> Mesh:
    """As `grid`, between lines at x and at y, m, ascending: fine where it matters. `lines` makes such arrays.

    Raises DesignError as `grid` does, and for lines that do not ascend.
    """
    if pattern not in PATTERNS:
        raise DesignError(
            f"the pattern of a grid is {shown(pattern)}; it must be one of {', '.join(PATTERNS)}"
        )
    across, up = _checked_lines(x, "x"), _checked_lines(y, "y")
    nx, ny = len(across) - 1, len(up) - 1
    count = nx * ny * PER_SQUARE[pattern]
    if count > checked_number(limit, "the limit of a grid", minimum=1.0):
        raise DesignError(_too_many(f"a grid of {nx} × {ny}", count, limit))
    points = np.stack([np.tile(across, ny + 1), np.repeat(up, nx + 1)], axis=1)
    if pattern == "criss-cross":
        middle_x, middle_y = 0.5 * (across[1:] + across[:-1]), 0.5 * (up[1:] + up[:-1])
        middles = np.stack([np.tile(middle_x, ny), np.repeat(middle_y, nx)], axis=1)
        points = np.concatenate([points, middles])
    cells = _cells(nx, ny, pattern)
    names, index = _regions_of(points[cells], regions or {})
    equal = all(np.ptp(np.diff(line)) <= _UNEQUAL * np.mean(np.diff(line)) for line in (across, up))
    return Mesh(points, cells, index, names, pattern if equal else "")


def _cells(nx: int, ny: int, pattern: str) -> Integers:
    """Cells of square after square, rows from below."""
    i, j = np.tile(np.arange(nx), ny), np.repeat(np.arange(ny), nx)
    p = i + (nx + 1) * j  # lower left; then counter-clockwise
    q, r, s = p + 1, p + nx + 2, p + nx + 1
    rising = pattern == "one-diagonal" or (i + j) % 2 == 0  # from lower left to upper right
    parts: tuple[tuple[NDArray[np.int_], ...], ...]
    if pattern == "squares":
        parts = ((p, q, r, s),)
    elif pattern == "criss-cross":
        middle = (nx + 1) * (ny + 1) + i + nx * j
        parts = ((p, q, middle), (q, r, middle), (r, s, middle), (s, p, middle))
    else:
        parts = ((p, q, np.where(rising, r, s)), (np.where(rising, p, q), r, s))
    cells = np.stack([np.stack(corners, axis=1) for corners in parts], axis=1)
    return cells.reshape(-1, cells.shape[2]).astype(np.int32)


def _regions_of(corners: Array, regions: Mapping[str, BaseGeometry]) -> tuple[tuple[str, ...], Integers]:
    """Names of the regions that have cells, and the index of each cell's."""
    index = np.zeros(len(corners), dtype=np.int32)
    if not regions:
        return ("",), index
    centres, cells = shapely.points(corners.mean(axis=1)), shapely.polygons(corners)
    for number, (name, polygon) in enumerate(regions.items(), start=1):
        if not isinstance(polygon, BaseGeometry) or not polygon.is_valid or polygon.area <= 0.0:
            raise DesignError(
                f"region {shown(name)} of a grid is {shown(polygon)}; it must be a valid shapely polygon"
            )
        shapely.prepare(polygon)
        inside = shapely.contains(polygon, centres)
        if (index[inside] > 0).any():
            cell = int(np.flatnonzero(inside & (index > 0))[0])
            other = list(regions)[index[cell] - 1]
            raise DesignError(
                f"regions {other!r} and {name!r} of a grid overlap at {place(corners[cell].mean(axis=0))}; "
                "a cell has one region: cut one region at the other"
            )
        _check_follows(name, polygon, cells, inside)
        index[inside] = number
    names = ("", *regions)
    return (names, index) if (index == 0).any() else (names[1:], index - np.int32(1))


def _check_follows(name: str, polygon: BaseGeometry, cells: Geometries, inside: Flags) -> None:
    """Raises DesignError where a region covers parts of cells, or reaches beyond the grid."""
    areas = shapely.area(cells)
    covered = np.where(inside, areas, 0.0)
    crossed = np.flatnonzero(shapely.intersects(polygon, cells))
    crossed = crossed[~shapely.contains_properly(polygon, cells[crossed])]
    covered[crossed] = shapely.area(shapely.intersection(cells[crossed], polygon))
    wrong = np.abs(covered - np.where(inside, areas, 0.0))
    if wrong.sum() > _MISFIT * polygon.area:
        at = np.array(cells[int(np.argmax(wrong))].centroid.coords[0])
        raise DesignError(
            f"the border of region {name!r} of a grid passes through the cell at {place(at)}; it must follow the "
            "edges of cells: use grid_of_lines with lines at the border, or mesh()"
        )
    beyond = polygon.area - covered.sum()
    if beyond > _MISFIT * polygon.area:
        raise DesignError(
            f"region {name!r} of a grid reaches beyond the grid with {beyond:.6g} m² of its {polygon.area:.6g} m²; "
            "cut it at the grid's border"
        )


def _checked_lines(value: object, name: str) -> Array:
    array = np.asarray(value)
    count = len(array) if array.ndim == 1 else 0
    if count < 2:
        raise DesignError(f"the {name} lines of a grid are {shown(value)}; give at least two positions, m")
    positions = checked_array(value, (count,), f"the {name} lines of a grid")
    down = np.flatnonzero(np.diff(positions) <= 0.0)
    if len(down):
        raise DesignError(
            f"{name} line {down[0] + 1} of a grid is at {positions[down[0] + 1]:g} m, not beyond the one before at "
            f"{positions[down[0]]:g} m; lines must ascend: sort them and leave out doubles"
        )
    return positions


def _check_count(value: object, what: str, most: float) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise DesignError(f"{what} of a grid is {shown(value)}; it must be a whole number of at least 1")
    if value > most:
        raise DesignError(_too_many(f"a grid with {what} = {shown(value)}", float(min(value, 10**18)), most))


def _too_many(what: str, count: float, most: float) -> str:
    return (
        f"{what} would have {count:.0f} cells or more, {memory_of(count)}; the limit is {most:.0f}: take fewer (in "
        "Python, `limit` can be raised)"
    )

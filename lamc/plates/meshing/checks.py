"""Whether arrays are a mesh.

In: points, cells and regions as a user or a file gives them. Out: arrays of the proper type, cells counter-clockwise,
or a DesignError that names a cell and where it is. Never: repairs more than the sense of rotation.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lamc.basics.checks import MAX_NAME_LENGTH, Array, shown
from lamc.basics.errors import DesignError

Integers = NDArray[np.int32]

_FLAT = 1e-12  # area over the square of the longest edge, below which a cell has no area; 1:1000 slivers have 5e-4
FARTHEST = 1e100  # m; squares of products must not overflow
_MOST = np.iinfo(np.int32).max
MOST_CELLS = 5_000_000  # that a mesh has unless a higher limit is given
PEAK_BYTES = 360  # per cell, measured, while a mesh is made and checked; 60 of these stay


def checked_points(value: object, what: str = "the points of a mesh", *, empty: bool = False) -> Array:
    """`value` as finite floats of shape (n, 2), at least one unless `empty`; or DesignError."""
    try:
        points = np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise DesignError(f"{what} are {shown(value)}; they must be numbers of shape (n, 2)") from error
    if empty and points.size == 0:
        return np.zeros((0, 2))
    if points.ndim != 2 or points.shape[1] != 2 or not len(points):
        raise DesignError(
            f"{what} have shape {points.shape}; it must be (n, 2) with at least one point: x and y in m"
        )
    bad = np.flatnonzero(~(np.abs(points) < FARTHEST).all(axis=1))
    if len(bad):
        raise DesignError(
            f"point {bad[0]} of {what} is at {place(points[bad[0]])}; every coordinate must be finite, and below "
            f"{FARTHEST:g} m"
        )
    return points


def checked_cells(value: object, points: Array) -> Integers:
    """`value` as rows of three or four different points, or DesignError."""
    try:
        given = np.asarray(value)
        cells = given.astype(np.int64) if given.dtype.kind in "iuf" else None
    except (TypeError, ValueError, OverflowError):
        cells = None
    if cells is None or not np.array_equal(cells, given):
        raise DesignError(
            f"the cells of a mesh are {shown(value)}; they must be whole numbers: rows of points"
        )
    if cells.ndim != 2 or cells.shape[1] not in (3, 4) or not len(cells):
        raise DesignError(
            f"the cells of a mesh have shape {cells.shape}; it must be (m, 3) for triangles or (m, 4) for "
            "quadrilaterals, with at least one cell"
        )
    if max(len(points), cells.size) > _MOST:
        raise DesignError(
            f"the mesh has {len(cells)} cells; at most {_MOST // 4} can be numbered: take a larger size"
        )
    outside = (cells < 0) | (cells >= len(points))
    if outside.any():
        cell = int(np.argmax(outside.any(axis=1)))
        raise DesignError(
            f"cell {cell} has the corners {cells[cell].tolist()}; a corner is a row of the {len(points)} points, "
            f"0 to {len(points) - 1}"
        )
    ordered = np.sort(cells, axis=1)
    twice = (ordered[:, 1:] == ordered[:, :-1]).any(axis=1)
    if twice.any():
        cell = int(np.argmax(twice))
        raise DesignError(
            f"{name_cell(points, cells, cell)} has the corners {cells[cell].tolist()}; all its corners must be "
            "different points: leave the cell out, or write a mesh of triangles"
        )
    _check_all_used(points, cells)
    return cells.astype(np.int32)


def _check_all_used(points: Array, cells: NDArray[np.int64]) -> None:
    unused = np.flatnonzero(np.bincount(cells.ravel(), minlength=len(points)) == 0)
    if len(unused):
        more = f" and {len(unused) - 1} more" if len(unused) > 1 else ""
        raise DesignError(
            f"point {unused[0]} at {place(points[unused[0]])}{more} belongs to no cell, and its unknowns would have "
            "no stiffness: leave out points that no cell uses"
        )


def counter_clockwise_cells(points: Array, cells: Integers) -> Integers:
    """The cells, counter-clockwise; the first corner stays. Raises DesignError for cells without area, and for
    quadrilaterals that are not convex, whose inside maps to itself twice."""
    corners = points[cells]
    edges = np.roll(corners, -1, axis=1) - corners
    before = np.roll(edges, 1, axis=1)
    turnings = (
        before[..., 0] * edges[..., 1] - before[..., 1] * edges[..., 0]
    )  # twice the area at each corner
    longest = np.max(np.sum(edges * edges, axis=2), axis=1)
    # The corners are rounded numbers: far from the origin they may not be able to tell a flat cell from a thin one.
    noise = 4.0 * np.finfo(float).eps * np.max(np.abs(corners), axis=(1, 2)) * np.sqrt(longest)
    flat = np.abs(turnings) <= 2.0 * (_FLAT * longest + noise)[:, None]
    if (flat.all(axis=1) if cells.shape[1] == 4 else flat.any(axis=1)).any():
        cell = int(np.argmax(flat.any(axis=1)))
        raise DesignError(
            f"{name_cell(points, cells, cell)} has no area: its corners {cells[cell].tolist()} are in line; "
            "leave it out or move a corner"
        )
    signs = np.where(flat, 0, np.sign(turnings)).sum(axis=1)
    bad = np.flatnonzero(np.abs(signs) != cells.shape[1])
    if len(bad):
        raise DesignError(
            f"{name_cell(points, cells, int(bad[0]))} is a quadrilateral that is not convex, or whose corners do not "
            f"go round: {cells[bad[0]].tolist()}; order them round the cell, or cut it into two triangles"
        )
    rotated = np.array(cells)
    clockwise = signs < 0
    rotated[clockwise, 1:] = rotated[clockwise, :0:-1]
    return rotated


def checked_neighbours(points: Array, cells: Integers, cell_edges: Integers, edge_count: int) -> None:
    """Raises DesignError for cells that are there twice, edges of more than two cells, and neighbours that lie on the
    same side of their common edge."""
    uses = np.bincount(cell_edges.ravel(), minlength=edge_count)
    forward = cells < np.roll(cells, -1, axis=1)
    same_way = np.bincount(cell_edges[forward], minlength=edge_count)
    crowded = (uses > 2) | ((uses == 2) & (same_way != 1))
    if not crowded.any():
        return
    order = np.lexsort(np.sort(cells, axis=1).T)
    ordered = np.sort(cells, axis=1)[order]
    equal = np.flatnonzero((ordered[1:] == ordered[:-1]).all(axis=1))
    if len(equal):
        first, second = sorted(int(c) for c in order[equal[0] : equal[0] + 2])
        raise DesignError(
            f"cell {second} is {name_cell(points, cells, first)} again, with the same corners; leave one of them out"
        )
    edge = int(np.argmax(crowded))
    owners = np.flatnonzero((cell_edges == edge).any(axis=1))
    local = int(np.argmax(cell_edges[owners[0]] == edge))
    ends = sorted(int(cells[owners[0], (local + k) % cells.shape[1]]) for k in (0, 1))
    where = f"the edge from {place(points[ends[0]])} to {place(points[ends[1]])}"
    if uses[edge] > 2:
        raise DesignError(
            f"{where} belongs to {uses[edge]} cells: {', '.join(map(str, owners[:5].tolist()))}; a plate has at most "
            "two cells at an edge: leave one out"
        )
    raise DesignError(
        f"{name_cell(points, cells, int(owners[0]))} and {name_cell(points, cells, int(owners[1]))} lie on the same "
        f"side of {where}, one upon the other; one of them is inverted: move or leave out its far corner"
    )


def checked_regions(names: object, regions: object, count: int) -> tuple[tuple[str, ...], Integers]:
    """Names and index per cell, or DesignError; no `regions` at all: every cell is in the first."""
    if isinstance(names, str) or not isinstance(names, Sequence) or not names:
        raise DesignError(f"the region names of a mesh are {shown(names)}; they must be a tuple of names")
    for name in names:
        if not isinstance(name, str) or not (name.isprintable() and len(name) <= MAX_NAME_LENGTH):
            raise DesignError(
                f"a region of a mesh has the name {shown(name)}; a name is a printable text of at most "
                f"{MAX_NAME_LENGTH} characters"
            )
        if list(names).count(name) > 1:
            raise DesignError(f"two regions of a mesh have the name {name!r}; names must differ: rename one")
    try:
        given = np.asarray(regions)
        index = given.astype(np.int32)
    except (TypeError, ValueError, OverflowError) as error:
        raise DesignError(
            f"the regions of a mesh are {shown(regions)}; give one whole number per cell"
        ) from error
    if not index.size:
        return tuple(names), np.zeros(count, dtype=np.int32)
    if index.shape != (count,) or not np.array_equal(index, given):
        raise DesignError(
            f"the regions of a mesh have shape {index.shape}; give one whole number for each of the {count} cells"
        )
    outside = (index < 0) | (index >= len(names))
    if outside.any():
        cell = int(np.argmax(outside))
        raise DesignError(
            f"cell {cell} is in region {index[cell]}; there are {len(names)} region names, 0 to {len(names) - 1}"
        )
    return tuple(names), index


def memory_of(count: float) -> str:
    """What so many cells take, as messages tell it."""
    return f"{count * PEAK_BYTES / 2.0**30:.2g} GiB while it is made and many times that to solve"


def name_cell(points: Array, cells: NDArray[np.integer], cell: int) -> str:
    """A cell as messages name it: its number and its centre."""
    return f"cell {cell} at {place(points[cells[cell]].mean(axis=0))}"


def place(point: Array) -> str:
    """A point as messages show it."""
    return f"({point[0]:.6g}, {point[1]:.6g}) m"

"""A mesh is checked when it is made, knows what lies under a point, and grids have the pattern that was asked for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely.geometry import Polygon, box

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plates.meshing.grid import PATTERNS
from lamc.plates.meshing.mesh import Mesh

SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
TWO = np.array([(0, 1, 2), (0, 2, 3)])
ROUND_OFF = 1e-13  # of a few dozen operations on numbers near 1


def test_clockwise_cells_are_turned_and_keep_their_first_corner() -> None:
    mesh = Mesh(SQUARE, [(0, 2, 1), (2, 3, 0)])
    assert mesh.cells.tolist() == [[0, 1, 2], [2, 3, 0]]
    assert mesh.areas.tolist() == [0.5, 0.5]
    assert Mesh(SQUARE, [(3, 2, 1, 0)]).cells.tolist() == [[3, 0, 1, 2]]


def test_areas_keep_their_digits_far_from_the_origin() -> None:
    # Coordinates near 2^20 are multiples of 2^-32, so these are exact; products of them are not.
    mesh = Mesh(SQUARE * 2.0**-10 + 2.0**20, TWO)
    assert mesh.areas.tolist() == [2.0**-21, 2.0**-21]


BAD = {
    "corner is no point": (SQUARE, [(0, 1, 2), (0, 2, 4)], r"cell 1 .*\[0, 2, 4\].* 4 points"),
    "negative corner": (SQUARE, [(0, 1, 2), (0, 2, -1)], r"cell 1 .*\[0, 2, -1\]"),
    "fraction": (SQUARE, [(0, 1, 2.5)], "whole numbers"),
    "text": (SQUARE, [("a", "b", "c")], "whole numbers"),
    "two corners": (SQUARE, [(0, 1)], r"shape \(1, 2\)"),
    "ragged": (SQUARE, [(0, 1, 2), (0, 1, 2, 3)], "whole numbers"),
    "no cells": (SQUARE, np.zeros((0, 3)), "at least one cell"),
    "no points": (np.zeros((0, 2)), TWO, r"shape \(0, 2\)"),
    "3-D": (np.zeros((4, 3)), TWO, r"shape \(4, 3\)"),
    "not finite": ([*SQUARE[:3], (0.0, np.nan)], TWO, r"point 3 .*nan"),
    "too far": ([*SQUARE[:3], (0.0, 1e200)], TWO, r"point 3 .*below 1e\+100 m"),
    "unused": ([*SQUARE, (5.0, 6.0)], TWO, r"point 4 at \(5, 6\) m belongs to no cell"),
    "same corner twice": (SQUARE, [(0, 1, 2), (0, 2, 3), (0, 1, 1)], r"cell 2 at .*\[0, 1, 1\]"),
    "in line": ([*SQUARE, (0.5, 0.0)], [*TWO, (0, 1, 4)], r"cell 2 at \(0.5, 0\) m has no area"),
    "twice": (SQUARE, [*TWO, (2, 0, 1)], r"cell 2 is cell 0 at \(0.666667, 0.333333\) m again"),
    "three at an edge": (
        [*SQUARE, (2.0, 0.5)],
        [*TWO, (0, 2, 4)],
        r"\(0, 0\) m to \(1, 1\) m belongs to 3 cells",
    ),
    "folded over": ([*SQUARE[:3], (0.9, 0.2)], TWO, r"cell 0 at .* and cell 1 at .* inverted"),
    "not convex": ([*SQUARE[:3], (0.9, 0.2)], [(0, 1, 2, 3)], r"cell 0 at .* not convex"),
    "bow tie": (SQUARE, [(0, 2, 1, 3)], r"cell 0 at \(0.5, 0.5\) m .* not convex"),
    "180° corner": ([(0, 0), (1, 0), (2, 0), (0, 2)], [(0, 1, 2, 3)], "cell 0 .* not convex"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_mesh_is_refused_with_the_cell_and_its_place(case: str) -> None:
    points, cells, message = BAD[case]
    with pytest.raises(DesignError, match=message):
        Mesh(points, cells)


@pytest.mark.parametrize(
    ("regions", "names", "message"),
    [
        ([0, 2], ("a", "b"), "cell 1 is in region 2; there are 2"),
        ([0], ("a",), "one whole number for each of the 2 cells"),
        ([0, 0.5], ("a",), "whole number"),
        ([0, 1], ("a", "a"), "'a'; names must differ"),
        ([0, 1], ("a", 3), "name 3"),
        ([0, 1], "ab", "tuple of names"),
        ([0, 1], (), "tuple of names"),
    ],
)
def test_regions_are_checked(regions: list[int], names: tuple[str, ...], message: str) -> None:
    with pytest.raises(DesignError, match=message):
        Mesh(SQUARE, TWO, regions, names)


def test_slivers_of_one_to_a_million_are_cells() -> None:
    mesh = Mesh(SQUARE * (1.0, 1e-6), TWO)
    assert mesh.areas.sum() == pytest.approx(1e-6, rel=ROUND_OFF)


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize(("nx", "ny"), [(1, 1), (5, 3), (4, 6)])
def test_a_grid_fills_its_rectangle(pattern: str, nx: int, ny: int) -> None:
    mesh = plate.grid(3.0, 0.5, nx, ny, pattern, origin=(-1.0, 2.0))
    assert mesh.pattern == pattern
    assert mesh.areas.sum() == pytest.approx(1.5, rel=ROUND_OFF)
    assert mesh.areas.min() == pytest.approx(mesh.areas.max(), rel=ROUND_OFF)
    assert len(mesh.points) - len(mesh.edges) + len(mesh.cells) == 1  # Euler: a disk
    assert mesh.points.min(axis=0).tolist() == [-1.0, 2.0]
    assert mesh.points.max(axis=0).tolist() == [2.0, 2.5]
    assert len(mesh.boundary_edges) == 2 * (nx + ny)


@pytest.mark.parametrize(("pattern", "most"), [("one-diagonal", 6), ("criss-cross", 8), ("union-jack", 8)])
def test_as_many_triangles_meet_as_the_pattern_says(pattern: str, most: int) -> None:
    mesh = plate.grid(1.0, 1.0, 6, 6, pattern)
    meeting = np.bincount(mesh.cells.ravel())
    inner = np.all((mesh.points > 0.01) & (mesh.points < 0.99), axis=1)
    assert meeting[inner].max() == most
    if pattern == "one-diagonal":
        assert set(meeting[inner]) == {6}
        ends = mesh.points[mesh.edges]
        slopes = np.unique(np.round(ends[:, 1] - ends[:, 0], 9), axis=0)
        assert {tuple(np.sign(s)) for s in slopes} == {(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)}
    else:
        assert set(meeting[inner]) == {4, 8}


def test_hinge_lines_are_as_fine_as_asked() -> None:
    x = plate.lines((0.0, 10e-3, 10.1e-3, 20.1e-3), (8, 2, 8))
    assert len(x) == 19
    assert x[[0, 8, 10, 18]].tolist() == [0.0, 10e-3, 10.1e-3, 20.1e-3]
    y = plate.lines((0.0, 5e-3), (4,))
    links = {"left": box(0, 0, 10e-3, 5e-3), "hinge": box(10e-3, 0, 10.1e-3, 5e-3)}
    mesh = plate.grid_of_lines(x, y, regions={**links, "right": box(10.1e-3, 0, 20.1e-3, 5e-3)})
    assert mesh.pattern == ""  # unequal spacing: not three-directional
    assert mesh.region_names == ("left", "hinge", "right")
    assert np.bincount(mesh.regions).tolist() == [64, 16, 64]
    area = mesh.areas[mesh.regions == 1].sum()
    assert area == pytest.approx(0.1e-3 * 5e-3, rel=1e-11)  # 10.1 mm - 10 mm has lost two digits
    rest = plate.grid_of_lines(x, y, regions=links)
    assert rest.region_names == ("", "left", "hinge")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"a": 0.0}, "side a of a grid is 0 m"),
        ({"b": -1.0}, "side b of a grid is -1 m"),
        ({"b": float("nan")}, "side b"),
        ({"nx": 0}, "nx of a grid is 0"),
        ({"ny": 2.0}, r"ny of a grid is 2\.0"),
        ({"nx": 10**9}, r"nx = 1000000000 .* GiB .* limit is 5000000"),
        ({"nx": 10**4, "ny": 10**4}, r"200000000 cells or more, 67 GiB .* limit is 5000000"),
        ({"limit": 31}, "32 cells or more, .* limit is 31"),
        ({"nx": 10**400}, "nx = 1000"),
        ({"pattern": "delaunay"}, "'delaunay'; it must be one of one-diagonal"),
        ({"origin": (0.0,)}, "origin"),
        ({"regions": {"r": box(0.0, 0.0, 0.3, 1.0)}}, r"border of region 'r' .* passes through the cell at"),
        ({"regions": {"r": Polygon([(0, 0), (1, 1), (0, 0.5)])}}, "border of region 'r'"),
        ({"regions": {"r": box(0.5, 0.0, 1.5, 1.0)}}, r"'r' .* beyond the grid with 0\.5 m² of its 1 m²"),
        (
            {"regions": {"r": box(0, 0, 0.5, 1), "s": box(0, 0.5, 1, 1)}},
            r"'r' and 's' of a grid overlap at \(",
        ),
        ({"regions": {"r": Polygon([(0, 0), (1, 1), (1, 0), (0, 1)])}}, "'r' .* valid shapely polygon"),
        ({"regions": {"r": "box"}}, "valid shapely polygon"),
    ],
)
def test_a_grid_that_cannot_be_is_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(DesignError, match=message):
        plate.grid(**{"a": 1.0, "b": 1.0, "nx": 4, "ny": 4, **arguments})  # type: ignore[arg-type]


def test_grid_lines_ascend() -> None:
    with pytest.raises(DesignError, match="x line 2 of a grid is at 1 m"):
        plate.grid_of_lines([0.0, 1.0, 1.0], [0.0, 1.0])
    with pytest.raises(DesignError, match="at least two"):
        plate.grid_of_lines([0.0], [0.0, 1.0])


def quadrilaterals() -> Mesh:
    """Squares whose inner corners are out of place, so that no cell is a parallelogram."""
    mesh = plate.grid(1.0, 1.0, 4, 4, "squares")
    points = np.array(mesh.points)
    inner = np.all((points > 0.01) & (points < 0.99), axis=1)
    points[inner] += 0.06 * np.sin(37.0 * points[inner, ::-1] + 1.0)
    return Mesh(points, mesh.cells)


MESHES = {
    **{p: plate.grid(1.0, 1.0, 4, 3, p) for p in PATTERNS},
    "quadrilaterals": quadrilaterals(),
    "slivers": plate.grid(1.0, 1.0, 2, 2000),
}


@pytest.mark.parametrize("name", MESHES)
@given(x=st.floats(0.0, 1.0), y=st.floats(0.0, 1.0))
def test_a_point_is_where_its_cell_and_natural_coordinates_say(name: str, x: float, y: float) -> None:
    mesh = MESHES[name]
    (cell,), ((xi, eta),) = mesh.locate([(x, y)])
    assert cell >= 0
    if mesh.corner_count == 3:
        shape = np.array([1.0 - xi - eta, xi, eta])
        assert shape.min() > -1e-5  # 1e-9 of the extent, over a height of 1/2000
    else:
        shape = 0.25 * np.array(
            [(1 - xi) * (1 - eta), (1 + xi) * (1 - eta), (1 + xi) * (1 + eta), (1 - xi) * (1 + eta)]
        )
        assert max(abs(xi), abs(eta)) < 1.0 + 1e-6
    assert shape @ mesh.corners[cell] == pytest.approx(np.array([x, y]), abs=ROUND_OFF)


@pytest.mark.parametrize("name", MESHES)
def test_points_outside_have_no_cell_and_points_on_edges_have_the_first(name: str) -> None:
    mesh = MESHES[name]
    cells, natural = mesh.locate([(1.1, 0.5), (0.5, -1e-6), (50.0, 50.0)])
    assert cells.tolist() == [-1, -1, -1]
    assert np.isnan(natural).all()
    middles = mesh.points[mesh.edges].mean(axis=1)
    cells, _ = mesh.locate(middles)
    first = np.full(len(mesh.edges), len(mesh.cells))
    np.minimum.at(first, mesh.cell_edges.ravel(), np.repeat(np.arange(len(mesh.cells)), mesh.corner_count))
    assert cells.tolist() == first.tolist()
    assert (mesh.locate(mesh.points)[0] >= 0).all()


def test_holes_are_outside() -> None:
    whole = plate.grid(3.0, 3.0, 3, 3)
    kept = np.abs(whole.corners.mean(axis=1) - 1.5).max(axis=1) > 0.5
    used, cells = np.unique(whole.cells[kept], return_inverse=True)
    mesh = Mesh(whole.points[used], cells.reshape(-1, 3))
    assert mesh.locate([(1.5, 1.5), (0.5, 1.5), (1.0, 1.5)])[0].tolist()[0] == -1
    assert (mesh.locate([(0.5, 1.5), (1.0, 1.5)])[0] >= 0).all()
    assert len(mesh.points) - len(mesh.edges) + len(mesh.cells) == 0  # Euler: a ring


def test_many_points_are_found_as_one_by_one() -> None:
    mesh = MESHES["union-jack"]
    points = np.random.default_rng(5).uniform(-0.1, 1.1, (250_000, 2))
    cells, natural = mesh.locate(points)
    for k in (0, 99_999, 100_000, 249_999):
        one, coordinates = mesh.locate(points[k : k + 1])
        assert one[0] == cells[k]
        assert np.array_equal(coordinates[0], natural[k], equal_nan=True)
    assert mesh.locate([])[0].shape == (0,)
    with pytest.raises(DesignError, match=r"the points to locate .* \(2,\)"):
        mesh.locate((0.5, 0.5))

"""What exported C says at any point of a plate: what lamc says there, and what print says."""

import ctypes
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shapely

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plates.problem import Problem
from lamc.plates.solving.system import system
from tests.support.ctools import needs_cc, sanitizer_works
from tests.support.exported_folders import cc, does, put
from tests.support.exported_plates import MAKERS, SIDE, STEEL, Array, Library, exported, problem

pytestmark = needs_cc

Load = Callable[..., Library]
OUTSIDE, BAD_INPUT, BAD_ARGUMENT = -26, -23, -5


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    return lambda name, **options: Library(name, tmp_path_factory.mktemp(name), **options)


def _solution(name: str) -> plate.Solution:
    solved = plate.solve(problem(name))
    return solved if isinstance(solved, plate.Solution) else next(iter(solved.values()))


def _free(solution: plate.Solution) -> Array:
    """The free unknowns of a solution, so that C starts from the same numbers."""
    made = system(solution.problem).constraints
    free = made.free
    rest = solution.values - made.fixed.T @ made.values
    # Columns of `free` are orthogonal: unknowns along oblique supports and hinges are turned, not stretched.
    return np.asarray((free.T @ rest) / np.asarray(free.multiply(free).sum(axis=0)).ravel())


def _points(own: Problem, count: int) -> Array:
    """All over the plate: random ones, nodes, middles of edges, and some a hair outside of the boundary."""
    rng = np.random.default_rng(3)
    corners = own.mesh.corners[rng.integers(0, len(own.mesh.cells), count)]
    weights = rng.dirichlet(np.ones(own.mesh.corner_count), count)
    inside = np.einsum("kc,kci->ki", weights, corners)
    ends = own.mesh.points[own.mesh.edges]
    rim = ends[own.places.on_boundary]
    normal = np.stack([rim[:, 1, 1] - rim[:, 0, 1], rim[:, 0, 0] - rim[:, 1, 0]], axis=1)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    away = rim.mean(axis=1) + 0.5 * own.places.tolerance * np.sign(rng.normal(size=(len(rim), 1))) * normal
    return np.concatenate([inside, own.mesh.points, ends.mean(axis=1), away])


@pytest.mark.parametrize("name", sorted(MAKERS))
def test_every_point_moves_as_lamc_says(load: Load, name: str) -> None:
    """From the same unknowns, by the same shape functions: within 1e-13 of the largest, as interpolation has some
    hundred operations. Slopes on edges too, where the first cell counts."""
    solution, library = _solution(name), load(name)
    x = _free(solution)
    points = _points(solution.problem, 500)
    found = np.full((len(points), 6), np.nan)
    for row, (px, py) in zip(found, points.tolist(), strict=True):
        assert library.at(x, px, py, row) == 0
    expected = np.zeros_like(found)
    expected[:, :3] = solution.displacement(*points.T)
    if solution.problem.dofs.element.bends:
        expected[:, 3:5] = solution.slope(*points.T)
    for column in range(6):
        error = np.abs(found[:, column] - expected[:, column]).max()
        assert error <= 1e-13 * np.abs(expected[:, column]).max()


@pytest.mark.parametrize("name", ["square", "coupled"])
def test_points_inside_have_the_bits_of_lamc(load: Load, name: str) -> None:
    """Where every unknown is free or held, and in triangles, each operation is lamc's own."""
    solution, library = _solution(name), load(name)
    x = _free(solution)
    points = _points(solution.problem, 500)[:500]
    found = np.full((len(points), 6), np.nan)
    for row, (px, py) in zip(found, points.tolist(), strict=True):
        assert library.at(x, px, py, row) == 0
    assert np.array_equal(found[:, 2], solution.deflection(*points.T))
    assert np.array_equal(found[:, 3:5], solution.slope(*points.T))


@pytest.mark.parametrize("name", sorted(MAKERS))
def test_cells_are_those_of_the_mesh_and_points_outside_are_reported(load: Load, name: str) -> None:
    own, library = problem(name), load(name)
    order = system(own).assembly.order
    points = _points(own, 300)
    cells, _ = own.places.cells_under(points, "a point")
    assert [order[library.cell(*point)] for point in points.tolist()] == cells.tolist()
    rng = np.random.default_rng(5)
    low, high = own.mesh.points.min(axis=0), own.mesh.points.max(axis=0)
    x, out = np.zeros(library.counts["row"]), np.zeros(6)
    outside = 0
    for point in rng.uniform(low - 0.3 * (high - low), high + 0.3 * (high - low), (400, 2)):
        try:
            own.places.cells_under(point[None], "a point")
        except DesignError:
            outside += 1
            assert library.cell(*point) == -1
            assert library.at(x, *point, out) == OUTSIDE
        else:
            assert library.cell(*point) >= 0
    assert outside > 100
    for point in ((np.nan, 0.0), (0.0, np.inf), (-np.inf, 0.0)):
        assert library.cell(*point) == -1
        assert library.at(x, *point, out) == BAD_INPUT
    for point in ((1e300, 0.0), (0.0, -1e300)):
        assert library.at(x, *point, out) == OUTSIDE
    assert library.at(None, 0.0, 0.0, out) == library.at(x, 0.0, 0.0, None) == BAD_ARGUMENT


def test_solutions_that_are_not_finite_are_refused(load: Load) -> None:
    """By a status, and what is there stays."""
    own, library = problem("square"), load("square")
    out = np.ones(6)
    middle = own.mesh.corners[0].mean(axis=0).tolist()
    for number in (np.nan, np.inf):
        x = np.full(library.counts["row"], number)
        assert library.at(x, *middle, out) == BAD_INPUT
        assert (out == 1.0).all()
        nodes = {library.call("displacement", x, node, np.zeros(6)) for node in range(library.counts["node"])}
        assert BAD_INPUT in nodes <= {0, BAD_INPUT}  # those that are held stay where they are


@pytest.mark.slow
def test_a_plate_with_holes_and_fine_corners_is_found_within_the_cells_that_are_reported(load: Load) -> None:
    """The bound that the header states is that of the tables; in a hole there is no plate."""
    outline = shapely.box(0.0, 0.0, 0.2, 0.1).difference(shapely.Point(0.05, 0.05).buffer(0.02))
    fine = shapely.box(0.15, 0.0, 0.2, 0.02)
    mesh = plate.mesh(outline, 0.02, regions={"fine": fine}, sizes={"fine": 0.002})
    laminate = plate.Laminate([plate.Ply(STEEL, 1e-3)])
    left = shapely.LineString([(0.0, 0.0), (0.0, 0.1)])
    own = Problem(mesh, laminate, supports=[plate.Clamped(left)], loads=[plate.Pressure(100.0)])
    library = load("holes", made=own)
    solution = plate.solve(own)
    assert isinstance(solution, plate.Solution)
    points, x, row = _points(own, 200), _free(solution), np.zeros(6)
    expected = solution.deflection(*points.T)
    for point, w in zip(points.tolist(), expected, strict=True):
        assert library.at(x, *point, row) == 0
        assert abs(row[2] - w) <= 1e-13 * np.abs(expected).max()
    assert library.at(x, 0.05, 0.05, row) == OUTSIDE


_SWEEP = """#include "{name}.h"
#include <math.h>
#include <stdio.h>

int main(void) {{
  static double x[{name}_row_count];
  int found = 0;
  for (int i = 0; i < {name}_row_count; i++) x[i] = sin(i);
  for (int i = -20; i <= 120; i++) {{
    for (int j = -20; j <= 120; j++) {{
      const double at_x = {x} + 0.01 * i * {width}, at_y = {y} + 0.01 * j * {height};
      {name}_motion motion;
      const int is_on = {name}_displacement_at(x, at_x, at_y, &motion) == 0;
      if (is_on != ({name}_cell_at(at_x, at_y) >= 0)) return 1;
      found += is_on;
    }}
  }}
  {name}_cell_at(NAN, 0.0);
  {name}_cell_at(1e308, -1e308);
  printf("%d", found);
  return 0;
}}
"""


@pytest.mark.parametrize("name", ["oblique", "squares"])
@pytest.mark.quick("oblique")
def test_points_are_looked_up_cleanly_under_the_sanitizers(name: str, tmp_path: Path) -> None:
    """On and around the plate; as many are on it as its area, give or take the squares that its rim crosses."""
    flags = ("-std=c99", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    if not sanitizer_works(tmp_path, *flags):
        pytest.skip("this compiler has no address and undefined-behaviour sanitizers")
    mesh = problem(name).mesh
    (x, y), (width, height) = mesh.points.min(axis=0), np.ptp(mesh.points, axis=0)
    folder = put(exported(name), tmp_path)
    (folder / "sweep.c").write_text(_SWEEP.format(name=name, x=x, y=y, width=width, height=height))
    cc(folder, *flags, "sweep.c", f"{name}.c", "-lm", "-o", "sweep")
    share = float(mesh.areas.sum()) / (width * height)
    rim = 2 * 101 * 2
    assert abs(int(does([folder / "sweep"], folder)) - share * 101**2) <= rim


def test_the_middle_of_a_square_is_that_of_print_on_a_mesh_without_a_node_there(
    load: Load, shared: Path
) -> None:
    """15 by 15 squares: the point lies inside of a cell, and 0.5 % is DKT's error of h² on so many. The nearest node is
    off by more: w falls by (π/30)²/2 on its way there, along x and along y, 1.1 % together."""
    cases = json.loads((shared / "reference" / "plates.json").read_text(encoding="utf-8"))["cases"]
    (expected,) = [case["expected"] for case in cases if case["id"] == "ssss_unif"]
    own = Problem(
        plate.grid(SIDE, SIDE, 15, 15, "one-diagonal"),
        plate.Laminate([plate.Ply(STEEL, 1e-3)]),
        supports=[plate.SimplySupported(shapely.box(0.0, 0.0, SIDE, SIDE).exterior)],
        loads=[plate.Pressure(1000.0)],
    )
    library = load("odd", made=own)
    rhs, work, x = (library.array(name) for name in ("row", "work", "row"))
    row = np.zeros(6)
    assert library.call("load", ctypes.byref(library.parameters), 0, rhs) == 0
    assert library.call("solve", library.matrix(), rhs, work, x) == 0
    assert library.at(x, SIDE / 2, SIDE / 2, row) == 0
    D = 200e9 * 1e-9 / (12 * (1 - 0.3**2))
    scale = D / (1000.0 * SIDE**4)
    assert row[2] * scale == pytest.approx(expected, rel=5e-3)
    assert (
        np.abs(row[3:5]).max() < 1e-2 * row[2] / SIDE
    )  # level there, but for the diagonals, all of one direction
    node = library.lib.odd_nearest_node(ctypes.c_double(SIDE / 2), ctypes.c_double(SIDE / 2))
    assert library.call("displacement", x, node, row) == 0
    assert abs(row[2] * scale / expected - 1) > 5e-3

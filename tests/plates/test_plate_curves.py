"""Simply supported edges that are curves drawn as polygons: closed forms, whatever the corners and the cells."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from shapely.geometry import Point, Polygon, box

from lamc import plate
from lamc.basics.times import Times
from lamc.commands.plate_work import answers
from lamc.plates.answers.convergence import error_of_values
from lamc.plates.problem import Problem
from lamc.plates.solving.curves import CurveNodes, curve_nodes
from lamc.readers.plates.problem_file import plate_of_text
from lamc.readers.plates.problem_make import halved_problem_of, problem_of

R, THICK, E, NU, RHO, P = 0.1, 1e-3, 70e9, 0.3, 2700.0, 1e3
D = E * THICK**3 / (12.0 * (1.0 - NU**2))
SHEET = plate.Laminate([plate.Ply(plate.Material.isotropic(E, NU, RHO), THICK)])
DISK = P * R**4 * (5.0 + NU) / (64.0 * (1.0 + NU) * D)
Array = NDArray[np.float64]


def ring(count: int, radius: float = R, other: float | None = None, turn: float = 2.0 * np.pi) -> Polygon:
    """Corners on a circle, or on an ellipse of two half axes, or on a part of a turn."""
    angles = np.linspace(0.0, turn, count + 1)
    points = np.stack([radius * np.cos(angles), (other or radius) * np.sin(angles)], axis=1)
    return Polygon(points)


def held(polygon: Polygon, size: float, kind: str = "hard") -> Problem:
    mesh = plate.mesh(polygon, size)
    support = plate.SimplySupported("boundary", kind=kind)
    return Problem(mesh, SHEET, supports=[support], loads=[plate.Pressure(P)])


def curve(problem: Problem) -> CurveNodes:
    return curve_nodes(problem.places, ["boundary"])


def middle(problem: Problem, x: float = 0.0, y: float = 0.0) -> float:
    solution = plate.solve(problem)
    # What is held balances the load, as rows of supports and free unknowns are orthogonal.
    load = P * float(problem.mesh.areas.sum())
    assert solution.reactions[0].force[2] == pytest.approx(-load, rel=1e-9)
    return float(solution.deflection(x, y))


@pytest.mark.quick(
    "32-0.02-soft", "32-0.02-hard", "64-0.01-hard", "64-0.01-soft", "128-0.004-soft", "32-0.004-hard"
)
@pytest.mark.parametrize("kind", ["hard", "soft"])
@pytest.mark.parametrize(
    ("corners", "size"), [(32, 0.02), (32, 0.004), (64, 0.01), (64, 0.004), (128, 0.004)]
)
def test_a_disk_is_right_whatever_its_corners_and_cells(corners: int, size: float, kind: str) -> None:
    # Of the area beyond the polygon, 0.16 % of 64 corners, the load is missing near the edge; cells of a fifth of the
    # radius are off by 0.5 %. Held along its sides the plate of 32 corners was 8 % too stiff.
    assert middle(held(ring(corners), size, kind)) == pytest.approx(DISK, rel=6e-3 if size > 0.01 else 3e-3)


@pytest.mark.parametrize("size", [0.02, 0.006])
def test_the_first_mode_of_a_disk(size: float) -> None:
    omega = plate.modes(held(ring(64), size), 1).omega[0]
    # A. W. Leissa, Vibration of Plates, 1969: λ² = 4.935 for ν = 0.3; cells of a fifth of the radius give 0.5 % less.
    assert omega * R**2 * np.sqrt(RHO * THICK / D) == pytest.approx(
        4.9351, rel=5e-3 if size > 0.01 else 1.5e-3
    )


def annulus(inner: float) -> Callable[[float], float]:
    """w of a ring held along both edges: w = 0 and M_r = 0 there (S. Timoshenko, Plates and Shells, art. 17)."""

    def rows(r: float) -> tuple[Array, Array]:
        log = np.log(r / R)
        w = np.array([1.0, r * r, log, r * r * log])
        first = np.array([0.0, 2.0 * r, 1.0 / r, 2.0 * r * log + r])
        second = np.array([0.0, 2.0, -1.0 / r**2, 2.0 * log + 3.0])
        return w, second + NU * first / r

    def load(r: float) -> tuple[float, float]:
        return P * r**4 / (64.0 * D), P * (12.0 + 4.0 * NU) * r * r / (64.0 * D)

    matrix = np.stack([rows(r)[k] for r in (inner, R) for k in (0, 1)])
    amounts = np.linalg.solve(matrix, [-load(r)[k] for r in (inner, R) for k in (0, 1)])
    return lambda r: float(rows(r)[0] @ amounts + load(r)[0])


@pytest.mark.parametrize("size", [0.01, 0.003])
def test_a_ring_held_along_both_edges(size: float) -> None:
    inner = 0.3 * R
    shape = Polygon(ring(64).exterior, [ring(48, inner).exterior.coords])
    # 1 %: cells are a seventh of the ring's width at the larger size.
    assert middle(held(shape, size), 0.0, 0.065) == pytest.approx(annulus(inner)(0.065), rel=0.01)


@pytest.mark.parametrize("size", [0.01, 0.004])
def test_an_ellipse(size: float) -> None:
    # S. Timoshenko, Plates and Shells, table 67: w = 1.26 q b⁴ / E h³ for a / b = 1.5 and ν = 0.3, to three digits.
    found = middle(held(ring(64, 0.15, 0.1), size)) * E * THICK**3 / (P * 0.1**4)
    assert found == pytest.approx(1.26, rel=0.01)


@pytest.mark.parametrize(
    ("drawn", "finer"),
    [
        (ring(24, turn=np.pi), ring(96, turn=np.pi)),  # a half circle with its straight side
        (
            box(-0.05, -0.02, 0.05, 0.02).buffer(0.03, quad_segs=6),
            box(-0.05, -0.02, 0.05, 0.02).buffer(0.03, quad_segs=24),
        ),
    ],
)
@pytest.mark.quick("drawn0-*")
def test_curves_that_end_at_straight_sides(drawn: Polygon, finer: Polygon) -> None:
    """Against four times the corners, of which cells see each as an edge of their own."""
    at = (0.0, 0.04) if drawn.bounds[1] == 0.0 else (0.0, 0.0)
    fine = middle(held(finer, 0.003), *at)
    for size in (0.01, 0.003):
        assert middle(held(drawn, size), *at) == pytest.approx(fine, rel=0.01)


@pytest.mark.parametrize(
    "polygon",
    [
        box(0, 0, 1, 1),
        Polygon([(-1, 0), (0, -0.1), (1, 0), (0, 0.1)]),  # a flat rhombus, which was told that it is a curve
        Polygon([(0, 0), (1, -0.1), (2, 0), (2, 1), (0, 1)]),  # one blunt corner
        ring(8),
    ],
)
def test_polygons_are_no_curves(polygon: Polygon) -> None:
    problem = held(polygon, 0.1 * polygon.length)
    assert not len(curve(problem).nodes)
    assert not any("curve" in note for note in plate.solve(problem).report.notes)


def test_heights_and_directions_are_those_of_the_circle() -> None:
    problem = held(ring(48), 0.002)
    found = curve(problem)
    radius = np.linalg.norm(problem.mesh.points[found.nodes], axis=1)
    out = problem.mesh.points[found.nodes] / radius[:, None]
    sagitta = R * (1.0 - np.cos(np.pi / 48))
    side = np.sign(np.sum(found.across * out, axis=1))
    # The cubic is a parabola here: off by the fourth order of the angle, 0.1 % of the height.
    assert np.abs(found.height * side - (R - radius)).max() < 2e-3 * sagitta
    assert np.abs(np.sum(found.along * out, axis=1)).max() < 2e-4
    assert len(found.nodes) == len(problem.mesh.boundary_edges)


def test_a_curve_held_by_single_unknowns_is_reported() -> None:
    mesh = plate.mesh(Point(0, 0).buffer(R, quad_segs=8), 0.005)
    problem = Problem(mesh, SHEET, supports=[plate.Support("boundary", ("w",))], loads=[plate.Pressure(P)])
    assert any("SimplySupported" in note for note in plate.solve(problem).report.notes)


# --- files: circles whose corners grow with the mesh -----------------------------------------------------------------

FILE = """\
kind: plate
units: mm
materials: {al: {E: 70 GPa, nu: 0.3, density: 2700}}
laminate: {material: al, thickness: 1}
geometry: {circle: {center: [0, 0], radius: 100}, size: 10}
supports: [{%s: boundary}]
loads: [{pressure: 1000}]
outputs: [{at: [0, 0]}]
"""


@pytest.mark.parametrize("size", [10e-3, 5e-3, 2.5e-3])
@pytest.mark.parametrize(("kind", "exact"), [("simply_supported", DISK), ("clamped", P * R**4 / (64.0 * D))])
@pytest.mark.quick("*-0.01", "*-0.005", others="campaign")
def test_a_circle_of_a_file_gets_better_with_its_mesh_and_the_estimate_knows(
    kind: str, exact: float, size: float
) -> None:
    file = plate_of_text(FILE % kind, "disk.yaml").drawn_for(size)
    problem = problem_of(file, size=size)
    finer = halved_problem_of(file, problem, size)
    assert len(finer.mesh.boundary_edges) == 2 * len(problem.mesh.boundary_edges)
    found = error_of_values(middle(problem), middle(finer))
    off = abs(found.value - exact)
    # 0.5 % at a tenth of the radius; it falls at least with the size.
    assert off < 0.005 * exact * size / 10e-3
    assert (
        off < 1.5 * found.error + 1e-4 * exact
    )  # the estimate is none of a bound, and round-off of meshes is 1e-4


def test_circles_of_a_file_have_corners_for_its_edges() -> None:
    file = plate_of_text(FILE % "clamped", "disk.yaml")
    for size, corners in ((10e-3, 128), (4.95e-3, 128), (2.5e-3, 256), (1e-3, 1024)):
        outline = file.drawn_for(size).geometry.outline
        assert len(outline.exterior.coords) - 1 == corners
        assert outline.area == pytest.approx(np.pi * R**2, rel=1e-12)
    once = file.drawn_for(1e-3)
    assert once.drawn_for(1e-3) is once
    assert dataclasses.replace(file, supports=()).drawn_for(1e-3).supports == ()  # what was changed stays


def test_what_lies_on_circles_is_drawn_with_them() -> None:
    """A ring as a circle with a hole, held along the hole's border, with a region that shares it."""
    text = (FILE % "clamped").replace(
        "size: 10}", "size: 4, holes: [{circle: {center: [0, 0], radius: 30}}]}"
    ).replace(
        "clamped: boundary", "simply_supported: {circle: {center: [0, 0], radius: 30}}"
    ) + "regions: {rim: {circle: {center: [0, 0], radius: 50}, size: 2}}\n"
    text = text.replace("at: [0, 0]", "at: [100, 0]")
    file = plate_of_text(text, "ring.yaml")
    for size in (4e-3, 1.5e-3):
        problem = problem_of(file, size=size)
        (support,) = problem.supports
        inner = np.linalg.norm(problem.mesh.points, axis=1) < 0.0301
        assert len(problem.places.nodes(support.where, "")) == inner.sum()
        assert len(problem.places.edges_on(support.where)) == inner.sum()


# --- what is reported
# ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("corners", "reported"), [(7, False), (8, True), (12, True), (17, True), (24, False)]
)
def test_a_supported_polygon_that_may_stand_for_a_circle_is_reported(corners: int, reported: bool) -> None:
    """A circle of 12 corners is held as a polygon, and so a fifth too stiff."""
    problem = held(ring(corners), 0.02)
    wanted = f"regular polygon of {corners} corners"
    assert any(wanted in note for note in plate.solve(problem).report.notes) == reported
    assert any(wanted in note for note in plate.modes(problem, 1).notes) == reported


def test_other_polygons_and_edges_that_do_not_turn_go_without_a_word() -> None:
    tapered = Polygon([(x, 0.5 * y) for x, y in ring(12).exterior.coords])
    clamped = dataclasses.replace(held(ring(12), 0.02), supports=[plate.Clamped("boundary")])
    for problem in (held(tapered, 0.02), clamped):
        assert not any("regular polygon" in note for note in plate.solve(problem).report.notes)


def test_halved_cells_that_keep_the_corners_of_a_circle_say_so() -> None:
    quantity = lambda solution: float(solution.deflection(0.01, 0.01))  # noqa: E731
    found = plate.error_of(held(ring(32), 0.02), quantity)
    assert "curved edges" in found.note
    assert found.note in str(plate.converge(held(ring(32), 0.02), quantity, meshes=2))
    assert plate.error_of(held(box(0, 0, R, R), 0.02), quantity).note == ""


@pytest.mark.slow
def test_a_second_mesh_grows_circles_of_files_and_says_where_it_keeps_corners() -> None:
    """Modes on halved cells are those of the finer circle; a polygon in well-known text stays what it is."""
    text = FILE % "simply_supported" + "modes: 1\n"
    circle = plate_of_text(text, "disk.yaml")
    drawn = plate_of_text(
        text.replace("circle: {center: [0, 0], radius: 100}", f"wkt: '{ring(32, 100.0).wkt}'"), "drawn.yaml"
    )
    found = answers(circle, "", None, "auto", Times(), two_meshes=True)
    finer = halved_problem_of(circle, found.problem)
    (pair,) = found.shapes["modes"].halved
    assert pair.error is not None
    assert pair.error.finer == pytest.approx(
        plate.modes(finer, 1).frequencies[0], rel=1e-9
    )  # the same problem
    assert not any("curved edges" in note for note in found.cases[0].notes)
    kept = answers(drawn, "", None, "auto", Times(), two_meshes=True)
    assert any("curved edges" in note for note in kept.cases[0].notes)

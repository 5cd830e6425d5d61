"""Recovered strains, halved meshes, orders of convergence, and error estimates against errors that are known."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import LineString, box

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plates.answers.convergence import error_of, observed_order
from lamc.plates.answers.recovery import recover, sample_points
from lamc.plates.dofs import mapped
from lamc.plates.meshing.mesh import Mesh

PATTERNS = ["one-diagonal", "criss-cross", "union-jack", "squares"]


def places(mesh: Mesh, xi: np.ndarray) -> np.ndarray:
    """The same natural coordinates in every cell, (m, len(xi), 2)."""
    cell = "triangle" if mesh.corner_count == 3 else "square"
    return np.stack([mapped(cell, mesh.corners, point) for point in xi], axis=1)


DEGREES = [
    (pattern, degree) for pattern in PATTERNS for degree in (1, 2, 3) if pattern == "squares" or degree < 3
]


@pytest.mark.parametrize(("pattern", "degree"), DEGREES)
def test_polynomial_strains_are_recovered_exactly(pattern: str, degree: int) -> None:
    """Also at corners of the plate, where a patch has to look further than the cells around it."""
    cell = "square" if pattern == "squares" else "triangle"
    mesh = plate.jittered(plate.grid(2.0, 1.0, 5, 4, pattern), 0.2)

    def strain(at: np.ndarray) -> np.ndarray:
        x, y = at[..., 0], at[..., 1]
        return np.stack([3 - x + 2 * y, (x + y) ** degree, x**degree - 4 * y], axis=-1)

    xi = sample_points(cell, degree)
    found = recover(mesh, xi, strain(places(mesh, xi)), degree)
    elsewhere = np.array([[0.1, 0.7], [0.0, 0.0], [0.2, 0.1]])
    for point, at in zip(elsewhere, np.moveaxis(places(mesh, elsewhere), 1, 0), strict=True):
        cells = np.arange(len(mesh.cells))
        # Least squares by normal equations, and fitted far from the samples at the plate's corners: some thousand ulp.
        np.testing.assert_allclose(
            found.at(cells, np.tile(point, (len(cells), 1))), strain(at), rtol=0.0, atol=1e-11
        )


def corner_values(mesh: Mesh, values: np.ndarray) -> np.ndarray:
    """One value per cell recovered at its corners, (m, corners)."""
    cell = "triangle" if mesh.corner_count == 3 else "square"
    found = recover(mesh, sample_points(cell, 1), values[:, None, None], 1)
    ends = np.array(
        {"triangle": [[0, 0], [1, 0], [0, 1]], "square": [[-1, -1], [1, -1], [1, 1], [-1, 1]]}[cell], float
    )
    cells = np.arange(len(mesh.cells))
    return np.stack([found.at(cells, np.tile(end, (len(cells), 1)))[:, 0] for end in ends], axis=1)


def test_recovery_keeps_what_jumps_between_regions() -> None:
    mesh = plate.grid(2.0, 1.0, 6, 3, "criss-cross", regions={"left": box(0, 0, 1, 1)})
    steps = np.array([1.0, 1000.0])[mesh.regions]
    np.testing.assert_allclose(corner_values(mesh, steps), np.repeat(steps[:, None], 3, axis=1), rtol=1e-12)


def test_a_single_row_of_cells_is_recovered_along_itself() -> None:
    """A strip of one square: all samples on one line say nothing across it, and are kept as they are there."""
    mesh = plate.grid(6.0, 0.1, 6, 1, "squares")
    centres = mesh.corners[:, :, 0].mean(axis=1)
    np.testing.assert_allclose(
        corner_values(mesh, 2.0 * centres), 2.0 * mesh.corners[:, :, 0], rtol=0.0, atol=1e-12
    )


# --- estimates against errors that are known -------------------------------------------------------------------------

NU = 0.3
PLATE = plate.Laminate([plate.Ply(plate.Material.isotropic(12 * (1 - NU**2), NU, 1.0), 1.0)])  # D = 1 N·m
SIMPLE = plate.SimplySupported("boundary")


def wave(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Pressure under which a simply supported square of D = 1 takes the shape sin πx sin πy."""
    return 4 * np.pi**4 * np.sin(np.pi * x) * np.sin(np.pi * y)


def wave_curvature(at: np.ndarray) -> np.ndarray:
    x, y = np.pi * at[..., 0], np.pi * at[..., 1]
    same, mixed = np.sin(x) * np.sin(y), np.cos(x) * np.cos(y)
    return np.pi**2 * np.stack([same, same, -2 * mixed], axis=-1)


def dent(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Pressure under which a clamped square of D = 1 takes the shape 256 x² (1-x)² y² (1-y)²."""
    f, g = x**2 * (1 - x) ** 2, y**2 * (1 - y) ** 2
    f2, g2 = 2 - 12 * x + 12 * x**2, 2 - 12 * y + 12 * y**2
    return 256 * (24 * g + 2 * f2 * g2 + 24 * f)


def dent_curvature(at: np.ndarray) -> np.ndarray:
    x, y = at[..., 0], at[..., 1]
    f, g = x**2 * (1 - x) ** 2, y**2 * (1 - y) ** 2
    f1, g1 = 2 * x - 6 * x**2 + 4 * x**3, 2 * y - 6 * y**2 + 4 * y**3
    f2, g2 = 2 - 12 * x + 12 * x**2, 2 - 12 * y + 12 * y**2
    return -256 * np.stack([f2 * g, f * g2, 2 * f1 * g1], axis=-1)


def uniform_curvature(at: np.ndarray) -> np.ndarray:
    """Of a simply supported square of D = 1 under 1 Pa: Navier's double series (Timoshenko and Woinowsky-Krieger 1959,
    section 28), to a remainder of 1e-5."""
    x, y = at[..., 0], at[..., 1]
    n = np.arange(1, 160, 2)
    sines, cosines = (f(np.multiply.outer(y, n) * np.pi) for f in (np.sin, np.cos))
    total = np.zeros((*x.shape, 3))
    for m in range(1, 80, 2):
        a = 16 / np.pi**4 / (m * n * (m * m + n * n) ** 2)
        sine, cosine = np.sin(m * np.pi * x), np.cos(m * np.pi * x)
        total[..., 0] += m * m * sine * (sines @ a)
        total[..., 1] += sine * (sines @ (a * n * n))
        total[..., 2] -= 2 * m * cosine * (cosines @ (a * n))
    return total


KNOWN = {
    "uniform": (SIMPLE, 1.0, uniform_curvature),
    "wave": (SIMPLE, wave, wave_curvature),
    "dent": (plate.Clamped("boundary"), dent, dent_curvature),
}


def energy_of(
    mesh: Mesh, off: Callable[[np.ndarray, np.ndarray], np.ndarray], stiffness: np.ndarray = PLATE.D
) -> float:
    """½ ∫ off · S off dA by three points per triangle or nine per square; off(at, xi) for one point in every cell."""
    if mesh.corner_count == 3:
        rule = [((a, b), 1 / 3) for a, b in ((1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3))]
    else:
        s, w = np.polynomial.legendre.leggauss(3)
        rule = [((a, b), p * q / 4) for a, p in zip(s, w, strict=True) for b, q in zip(s, w, strict=True)]
    total = 0.0
    for point, weight in rule:
        at = places(mesh, np.array([point]))[:, 0]
        e = off(at, np.tile(point, (len(mesh.cells), 1)))
        total += 0.5 * weight * float(mesh.areas @ np.einsum("mi,ij,mj->m", e, stiffness, e))
    return total


CASES = [
    *[("dkt", pattern, 12, False) for pattern in PATTERNS[:3]],
    ("dkt", "criss-cross", 8, True),
    ("specht", "one-diagonal", 12, True),
    ("bfs", "squares", 12, False),
]


@pytest.mark.parametrize(
    ("name", "element", "pattern", "n", "uneven"), [(name, *entry) for entry in CASES for name in KNOWN]
)
def test_estimate_is_within_a_factor_of_the_error(
    name: str, element: str, pattern: str, n: int, uneven: bool
) -> None:
    support, pressure, curvature = KNOWN[name]
    mesh = plate.grid(1.0, 1.0, n, n, pattern)
    if uneven:
        mesh = plate.jittered(mesh, 0.15)
    solution = plate.solve(plate.Problem(mesh, PLATE, element, [support], [plate.Pressure(pressure)]))
    assert isinstance(solution, plate.Solution)
    estimate = solution.error_estimate
    error = energy_of(mesh, lambda at, xi: curvature(at) - solution.cell_strains(xi))
    assert 1 / 3 < math.sqrt(estimate.energy / error) < 3
    stored = energy_of(mesh, lambda at, xi: curvature(at))
    assert 1 / 3 < estimate.relative / math.sqrt(error / stored) < 3
    assert estimate.cells.sum() == pytest.approx(estimate.energy, rel=1e-12)  # round-off
    better = solution.recovered
    left = energy_of(mesh, lambda at, xi: curvature(at) - better.curvature(at[:, 0], at[:, 1]))
    assert left < error


@pytest.mark.parametrize(
    ("element", "pattern"),
    [
        ("cst", "criss-cross"),
        ("lst", "criss-cross"),
        ("q4", "squares"),
        ("q9", "squares"),
        ("q12", "squares"),
    ],
)
def test_estimate_of_a_membrane_is_within_a_factor_of_the_error(element: str, pattern: str) -> None:
    """The displacement ∇(sin 2x cosh 2y) is in equilibrium without forces; the border moves with it."""

    def strain(at: np.ndarray) -> np.ndarray:
        x, y = 2 * at[..., 0], 2 * at[..., 1]
        along, shear = -4 * np.sin(x) * np.cosh(y), 8 * np.cos(x) * np.sinh(y)
        return np.stack([along, -along, shear], axis=-1)

    supports = [
        plate.Support("boundary", ("u",), lambda x, y: 2 * np.cos(2 * x) * np.cosh(2 * y)),
        plate.Support("boundary", ("v",), lambda x, y: 2 * np.sin(2 * x) * np.sinh(2 * y)),
    ]
    mesh = plate.grid(1.0, 1.0, 6, 6, pattern)
    solution = plate.solve(plate.Problem(mesh, PLATE, element, supports))
    error = energy_of(mesh, lambda at, xi: strain(at) - solution.cell_strains(xi), PLATE.A)
    assert 1 / 3 < math.sqrt(solution.error_estimate.energy / error) < 3
    if element != "q12":  # cubic, its strains on six cells are as good as cubics can be fitted to them
        left = energy_of(mesh, lambda at, xi: strain(at) - solution.recovered.strain(*at.T), PLATE.A)
        assert left < error


@pytest.mark.parametrize(("element", "pattern", "own"), [("dkt", "criss-cross", 1), ("bfs", "squares", 2)])
def test_recovered_moments_gain_an_order(element: str, pattern: str, own: int) -> None:
    errors = []
    for n in (8, 16):
        mesh = plate.grid(1.0, 1.0, n, n, pattern)
        solution = plate.solve(plate.Problem(mesh, PLATE, element, [SIMPLE], [plate.Pressure(1.0)]))
        better = solution.recovered
        at = np.array([0.31, 0.33]), np.array([0.42, 0.56])
        assert better.moments(*at) == pytest.approx(better.curvature(*at) @ PLATE.D, rel=1e-9)
        errors.append(energy_of(mesh, lambda at, xi, b=better: uniform_curvature(at) - b.curvature(*at.T)))
    # At the plate's edge patches reach one way only, which costs up to half an order on so few cells.
    assert 0.5 * math.log2(errors[0] / errors[1]) > own + 0.5


def test_plate_of_two_stiffnesses_under_one_moment_has_no_error() -> None:
    """Each region has the same curvature everywhere, a million times larger in a hinge of one cell: elements have it
    exactly, and recovery must not smear it into the links."""
    beam = plate.Material.isotropic(12.0, 0.0, 1.0)
    soft = plate.Material.isotropic(12.0e-6, 0.0, 1.0)
    mesh = plate.grid_of_lines(
        [0.0, 0.5, 1.0, 1.01, 1.5, 2.0],
        [0.0, 0.5, 1.0],
        "one-diagonal",
        regions={"hinge": box(1, 0, 1.01, 1)},
    )
    laminates = {"": plate.Laminate([plate.Ply(beam, 1.0)]), "hinge": plate.Laminate([plate.Ply(soft, 1.0)])}
    left, right = (LineString([(x, 0), (x, 1)]) for x in (0, 2))
    problem = plate.Problem(mesh, laminates, "dkt", [plate.Clamped(left)], [plate.EdgeMoment(right, 1.0)])
    solution = plate.solve(problem)
    # Round-off of curvatures over the solution's: 1e-9 after the digits that a hinge of 1e-6 costs.
    assert solution.error_estimate.relative < 1e-8
    assert solution.error_estimate.sizes(0.01) == pytest.approx({"": math.sqrt(1.99), "hinge": 0.1}, rel=1e-9)
    x, y = np.array([0.7, 1.005, 1.99]), np.array([0.3, 0.5, 0.9])
    np.testing.assert_allclose(solution.recovered.moments(x, y), [[1, 0, 0]] * 3, rtol=0.0, atol=1e-7)


def test_estimate_holds_on_a_mesh_of_the_mesher() -> None:
    solution = plate.solve(
        plate.Problem(plate.mesh(box(0, 0, 1, 1), 0.1), PLATE, "dkt", [SIMPLE], [plate.Pressure(wave)])
    )
    mesh = solution.problem.mesh
    error = energy_of(mesh, lambda at, xi: wave_curvature(at) - solution.cell_strains(xi))
    assert 1 / 3 < math.sqrt(solution.error_estimate.energy / error) < 3


def test_worst_region_is_where_the_load_changes_quickly() -> None:
    regions = {"loaded": box(0, 0, 0.25, 0.25)}
    mesh = plate.grid(1.0, 1.0, 16, 16, "criss-cross", regions=regions)
    load = plate.Pressure(lambda x, y: 1e4 * np.exp(-((x - 0.125) ** 2 + (y - 0.125) ** 2) / 0.003))
    solution = plate.solve(plate.Problem(mesh, PLATE, "dkt", [plate.Clamped("boundary")], [load]))
    estimate = solution.error_estimate
    assert estimate.worst_region == "loaded"
    assert sum(estimate.regions.values()) == pytest.approx(1.0, rel=1e-12)
    sizes = estimate.sizes(0.5 * estimate.relative)
    assert sizes["loaded"] < sizes[""]
    assert sizes["loaded"] < 1 / 16
    assert "loaded" in str(estimate)
    with pytest.raises(DesignError, match=r"relative error .* is 0; it must be positive"):
        estimate.sizes(0.0)


def test_advised_sizes_bring_the_error_where_it_was_asked_for() -> None:
    coarse = plate.grid(1.0, 1.0, 8, 8, "criss-cross")
    problem = plate.Problem(coarse, PLATE, "dkt", [SIMPLE], [plate.Pressure(wave)])
    estimate = plate.solve(problem).error_estimate
    # Legs of criss-cross triangles are 1/√2 of the grid's squares.
    n = math.ceil(1 / math.sqrt(2) / estimate.sizes(0.5 * estimate.relative)[""])
    fine = plate.solve(replace(problem, mesh=plate.grid(1.0, 1.0, n, n, "criss-cross"))).error_estimate
    # Equal cells cannot have equal errors, and the coarse estimate was itself a fifth off.
    assert fine.relative == pytest.approx(0.5 * estimate.relative, rel=0.3)


def test_error_of_a_deflection_is_known_by_halving() -> None:
    """Halved, a mesh of one diagonal keeps its pattern, and so the constant of its error."""
    problem = plate.Problem(
        plate.grid(1.0, 1.0, 8, 8, "one-diagonal"), PLATE, "dkt", [SIMPLE], [plate.Pressure(wave)]
    )
    found = error_of(problem, lambda solution: float(solution.deflection(0.5, 0.5)))
    assert 1 / 3 < found.error / abs(found.value - 1.0) < 3
    assert abs(found.extrapolated - 1.0) < 0.1 * found.error


def test_table_of_convergence_shows_order_cost_and_limit(shared: Path) -> None:
    cases = json.loads((shared / "reference" / "plates.json").read_text(encoding="utf-8"))["cases"]
    exact = next(entry for entry in cases if entry["id"] == "ssss_unif")

    def problem(size: float) -> plate.Problem:
        n = round(1.0 / size)
        return plate.Problem(
            plate.grid(1.0, 1.0, n, n, "criss-cross"), PLATE, "dkt", [SIMPLE], [plate.Pressure(1.0)]
        )

    found = plate.converge(
        problem,
        lambda solution: float(solution.deflection(0.5, 0.5)),
        [1 / 6, 1 / 12, 1 / 24],
        answer=plate.solve,
    )
    assert found.rows[-1].order == pytest.approx(2.0, abs=0.15)  # next order's share on so coarse meshes
    assert found.extrapolated == pytest.approx(exact["expected"], rel=exact["rel_tol"])
    assert 1 / 3 < found.error / abs(found.rows[-1].value - exact["expected"]) < 3
    assert [row.unknowns for row in found.rows] == sorted(row.unknowns for row in found.rows)
    assert all(row.seconds > 0.0 for row in found.rows)
    assert len(str(found).splitlines()) == 5
    halved = plate.converge(
        problem(1 / 6), lambda modes: float(modes.omega[0]), answer=lambda p: plate.modes(p, 1), meshes=3
    )
    assert halved.extrapolated == pytest.approx(2 * math.pi**2, rel=1e-4)
    with pytest.raises(DesignError, match="cell sizes of a convergence study are"):
        plate.converge(problem, lambda solution: 0.0, [0.1, 0.2])
    with pytest.raises(DesignError, match="asked for on 1 meshes; it takes two"):
        plate.converge(problem(0.5), lambda solution: 0.0, meshes=1)


def test_order_of_a_known_power_is_seen() -> None:
    for order in (1.0, 2.0, 3.7):
        points = [(h, 5.0 - 3.0 * h**order) for h in (0.4, 0.25, 0.1)]
        assert observed_order(points) == pytest.approx(order, rel=1e-9)  # brentq's own tolerance is 1e-12
    assert math.isnan(observed_order([(0.4, 1.0), (0.2, 2.0), (0.1, 1.5)]))  # it swings: no order shows
    assert math.isnan(observed_order([(0.4, 1.0), (0.2, 2.0)]))

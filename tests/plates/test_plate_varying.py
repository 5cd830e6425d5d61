"""Loads that are functions of the place: pressure within cells, temperature, moisture and electric fields over a plate,
against closed forms and an element that shares no code with ours."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from shapely.geometry import LineString, box

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plates.answers.corner_fields import corner_fields
from lamc.plates.elements.kernels import kernels
from lamc.plates.elements.quadrature import square_points, triangle_points
from lamc.plates.solving.cell_points import cell_points
from lamc.plates.solving.expansion import Expansion
from lamc.plates.solving.load_vectors import load_vector
from lamc.reference.plate_elements import ReferenceElement
from lamc.reference.plate_shapes import square_rule, triangle_rule
from tests.support.plates import isotropic, jittered, richardson

ALPHA = 20e-6
SHEET = plate.Laminate([plate.Ply(plate.Material.isotropic(E=70e9, nu=0.3, density=2700, alpha=ALPHA), 1e-3)])
FIBRES = plate.Laminate([plate.Ply(plate.material("T300/5208"), 1e-3)])
X, Y = np.array([0.11, 0.5, 0.83]), np.array([0.2, 0.31, 0.66])


def ramp(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 20.0 + 100.0 * x - 50.0 * y


# --- quadrature ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("degree", [1, 4, 7])
def test_points_integrate_polynomials_of_their_degree(degree: int) -> None:
    """∫ ξⁱ ηʲ over the triangle is i! j! / (i + j + 2)!, over the square 4 / ((i + 1) (j + 1)) for even powers."""
    for i in range(degree + 1):
        for j in range(degree + 1 - i):
            on_triangle = sum(w * a**i * b**j for a, b, w in triangle_points(degree))
            expected = math.factorial(i) * math.factorial(j) / math.factorial(i + j + 2)
            assert on_triangle == pytest.approx(expected, rel=1e-13)  # round-off
            on_square = sum(w * a**i * b**j for a, b, w in square_points(degree))
            even = 4.0 / ((i + 1) * (j + 1)) if i % 2 == j % 2 == 0 else 0.0
            assert on_square == pytest.approx(even, abs=1e-13)


@pytest.mark.parametrize("pattern", ["union-jack", "squares"])
def test_points_of_skew_cells_cover_them(pattern: str) -> None:
    mesh = jittered(plate.grid(2.0, 1.0, 4, 3, pattern), 0.3)
    kind = "triangle" if mesh.corner_count == 3 else "square"
    points = list(cell_points(kind, mesh.corners, np.arange(len(mesh.cells), dtype=np.int32)))
    share = np.zeros(len(mesh.cells))
    for point in points:
        share[point.cells] += point.areas
    assert share == pytest.approx(mesh.areas, rel=1e-13)  # round-off
    first_moment = sum(float(point.areas @ point.places[:, 0]) for point in points)
    assert first_moment == pytest.approx(2.0, rel=1e-13)  # of the whole rectangle, about its left side


# --- pressure --------------------------------------------------------------------------------------------------------


def test_a_pressure_that_no_corner_sees_is_carried_whole() -> None:
    """A spot of 1 kPa in one of four squares; the force of exp(-(x - m)² / 2 s²) on [0, 1] is s √(π/2) times the
    difference of erf((x - m) / s √2) at the ends."""
    spot, middle = 0.1, 0.25
    load = plate.Pressure(lambda x, y: 1e3 * np.exp(-((x - middle) ** 2 + (y - middle) ** 2) / (2 * spot**2)))
    ends = [math.erf((x - middle) / (spot * math.sqrt(2))) for x in (0.0, 1.0)]
    whole = 1e3 * (spot * math.sqrt(math.pi / 2) * (ends[1] - ends[0])) ** 2
    # Four points across five widths of the spot, and across one and a quarter.
    for n, allowed in ((2, 0.03), (8, 1e-6)):
        mesh = plate.grid(1.0, 1.0, n, n, "squares")
        problem = plate.Problem(mesh, isotropic(), "bfs", [plate.Clamped("boundary")], [load])
        solution = plate.solve(problem)
        assert isinstance(solution, plate.Solution)
        assert -solution.reactions[0].force[2] == pytest.approx(whole, rel=allowed)


def test_conforming_rectangles_keep_their_order_under_a_pressure_that_varies() -> None:
    """A simply supported square of D = 1 under 4 π⁴ sin πx sin πy takes the shape sin πx sin πy."""
    load = plate.Pressure(lambda x, y: 4 * np.pi**4 * np.sin(np.pi * x) * np.sin(np.pi * y))
    errors = []
    for n in (4, 8):
        mesh = plate.grid(1.0, 1.0, n, n, "squares")
        supports = [plate.SimplySupported("boundary")]
        solution = plate.solve(plate.Problem(mesh, isotropic(), "bfs", supports, [load]))
        assert isinstance(solution, plate.Solution)
        errors.append(float(solution.deflection(0.5, 0.5)) - 1.0)
    assert errors[1] < 1e-4
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.1)  # still a little before the limit


@pytest.mark.parametrize(
    ("element", "pattern"), [("dkt", "union-jack"), ("specht", "criss-cross"), ("bfs", "squares")]
)
def test_a_linear_pressure_is_integrated_as_the_element_does(element: str, pattern: str) -> None:
    mesh = plate.grid(1.0, 0.7, 4, 3, pattern)
    problem = plate.Problem(mesh, SHEET, element, [plate.Clamped("boundary")])
    own = kernels(problem.dofs.element)
    at_corners = (1.0 + 2.0 * mesh.corners[..., 0] - mesh.corners[..., 1])[:, None, :]
    expected = np.bincount(
        problem.dofs.of_cells.ravel(), own.load(mesh.corners, at_corners).ravel(), problem.dofs.count
    )
    found = load_vector(problem, own, [plate.Pressure(lambda x, y: 1.0 + 2.0 * x - y)])
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-14 * np.abs(expected).max())  # round-off


# --- temperature, moisture, field ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("element", "pattern"), [("lst", "union-jack"), ("dkt+lst", "criss-cross"), ("q9", "squares")]
)
@pytest.mark.parametrize("laminate", [SHEET, FIBRES], ids=["isotropic", "fibres"])
@pytest.mark.quick("isotropic-lst-*", "fibres-*")
def test_a_free_plate_that_warms_linearly_is_free_of_stress(
    element: str, pattern: str, laminate: plate.Laminate
) -> None:
    """Strains α T(x, y) of a linear T are compatible, so that no stress is needed (B. A. Boley and J. H. Weiner, Theory
    of Thermal Stresses, 1960, section 3.9); their displacement is quadratic, which these elements hold exactly."""
    mesh = plate.grid(1.0, 0.7, 6, 4, pattern)
    problem = plate.Problem(mesh, laminate, element, loads=[plate.Temperature(ramp)])
    solution = plate.solve(problem)
    assert isinstance(solution, plate.Solution)
    material = laminate.plies[0].material
    strain = solution.strain(X, Y)
    expected = np.multiply.outer(ramp(X, Y), [material.alpha1, material.alpha2, 0.0])
    # Round-off: of the strain, of what expansion alone would make, and of the energy of a plate that is held.
    np.testing.assert_allclose(strain, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
    held = np.abs(laminate.expansion(120.0).force).max()
    assert np.abs(solution.forces(X, Y)).max() < 1e-11 * held
    assert abs(solution.strain_energy) < 1e-11 * held * np.abs(expected).max()
    for state in solution.ply_states(0.4, 0.6):
        assert np.abs(state.stress).max() < 1e-11 * held / laminate.thickness
    assert corner_fields(solution).stress.max() < 1e-9 * held / laminate.thickness  # least squares of patches


def test_linear_membranes_tend_to_no_stress() -> None:
    """Constant strains follow a linear temperature with the first power of the cells."""
    left = []
    for n in (12, 24):
        mesh = plate.grid(1.0, 1.0, n, n, "union-jack")
        solution = plate.solve(plate.Problem(mesh, SHEET, "cst", loads=[plate.Temperature(ramp)]))
        assert isinstance(solution, plate.Solution)
        left.append(solution.strain_energy)
    assert math.log2(left[0] / left[1]) == pytest.approx(2.0, abs=0.05)  # energy: the square of the strain


@pytest.mark.parametrize(
    ("load", "unit"),
    [
        (lambda f: plate.Temperature(f), "alpha1"),
        (lambda f: plate.Moisture(f), "beta1"),
        (lambda f: plate.ElectricField([0.0, f]), "d31"),
    ],
    ids=["temperature", "moisture", "field"],
)
def test_a_strip_of_two_layers_bends_as_each_section_would(load: Callable[[Any], Any], unit: str) -> None:
    """Two layers of one modulus, of which the upper one expands, between mirrors: M_x = N_x = 0 and ε_y = κ_y = 0 make
    κ = 3 (1 + ν) e / (2 h) in every section of two layers h/2 thick (S. Timoshenko, J. Opt. Soc. Am. 11, 1925; times
    1 + ν where the strip is kept from bending across), so that with e linear along x, w'' = -κ makes a cubic w."""
    modulus, nu, half, length, width = 3e9, 0.3, 1e-4, 0.02, 0.004
    amounts = {"alpha1": 0.0, "alpha2": 0.0, "beta1": 0.0, "beta2": 0.0, "d31": 0.0, "d32": 0.0}
    still = plate.Material(modulus, modulus, nu, modulus / (2 * (1 + nu)), 0.0, **amounts)
    active = amounts | {unit: 1e-5, unit.replace("1", "2"): 1e-5}
    upper = plate.Material(modulus, modulus, nu, modulus / (2 * (1 + nu)), 0.0, **active)
    laminate = plate.Laminate([plate.Ply(still, half), plate.Ply(upper, half)])
    start, end = 10.0, 70.0
    sides = [plate.Symmetry(LineString([(0, y), (length, y)])) for y in (0.0, width)]
    per_unit = 1.5 * (1 + nu) * 1e-5 / (2 * half)
    tips = []
    for n in (10, 20):
        problem = plate.Problem(
            plate.grid(length, width, n, 2 * n // 10, "criss-cross"),
            laminate,
            "dkt+lst",
            [plate.Clamped(LineString([(0, 0), (0, width)])), *sides],
            [load(lambda x, y: start + (end - start) * x / length)],
        )
        solution = plate.solve(problem)
        assert isinstance(solution, plate.Solution)
        tips.append(float(solution.deflection(length, width / 2)))
    tip = -per_unit * length**2 * (start / 2 + (end - start) / 6)
    # DKT is of second order here; what is left after that is a thousandth of the coarse mesh's error.
    assert tips[0] == pytest.approx(tip, rel=1e-3)
    assert richardson(*tips) == pytest.approx(tip, rel=1e-7)
    middle = solution.recovered.curvature(length / 2, width / 2)[0]
    assert middle == pytest.approx(per_unit * (start + end) / 2, rel=1e-3)  # as the deflection's


@pytest.mark.slow
def test_expansion_agrees_with_an_element_written_independently() -> None:
    """∫ Bᵀ r(x, y) dA of a cubic r by the numpy elements and a rule of degree 12."""

    def cubic(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 3.0 - x + 2.0 * y**2 + x * y - x**3

    laminate = plate.Laminate.parse("[0/30]", plate.material("T300/5208"), 1e-3)
    for name, pattern in (("dkt+lst", "union-jack"), ("specht+cst", "criss-cross"), ("bfs+q9", "squares")):
        mesh = plate.grid(1.3, 0.9, 3, 2, pattern)
        problem = plate.Problem(mesh, laminate, name)
        found = Expansion(problem, [plate.Temperature(cubic)]).forces(kernels(problem.dofs.element))
        reference = ReferenceElement(name)
        count = found.shape[1]
        per_kelvin = np.concatenate([laminate.thermal.force, laminate.thermal.moment])
        rule = triangle_rule(12) if mesh.corner_count == 3 else square_rule(7)
        whole = float(rule[1].sum())
        expected = np.zeros_like(found)
        for xi, weight in zip(*(part.astype(float) for part in rule), strict=True):
            at = np.tile(xi, (len(mesh.cells), 1))
            rows = np.stack(
                [
                    reference.strain(mesh.corners, at, np.tile(unit, (len(mesh.cells), 1)))
                    for unit in np.eye(count)
                ],
                axis=1,
            )
            natural = (
                np.array([1 - xi[0] - xi[1], *xi])
                if mesh.corner_count == 3
                else 0.25
                * np.array(
                    [(1 + a * xi[0]) * (1 + b * xi[1]) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
                )
            )
            x, y = np.einsum("c,mci->im", natural, mesh.corners)
            share = weight / whole * mesh.areas * cubic(x, y)
            expected += share[:, None] * (rows @ per_kelvin)
        np.testing.assert_allclose(
            found, expected, rtol=0.0, atol=1e-13 * np.abs(expected).max()
        )  # round-off


def test_a_constant_function_is_its_value() -> None:
    laminate = plate.Laminate(
        [plate.Ply(plate.material("T300/5208"), 125e-6, angle) for angle in (0.0, 90.0)]
    )
    mesh = plate.grid(0.1, 0.1, 4, 4, "union-jack", regions={"hot": box(0, 0, 0.05, 0.1)})
    supports = [plate.Clamped(LineString([(0, 0), (0, 0.1)]))]
    loads: list[list[Any]] = [
        [plate.Temperature(-150.0, "hot"), plate.Moisture(0.01)],
        [plate.Temperature(lambda x, y: -150.0, "hot"), plate.Moisture(lambda x, y: 0.01 + 0 * x)],
    ]
    one, other = (plate.solve(plate.Problem(mesh, laminate, "dkt", supports, own)) for own in loads)
    assert isinstance(one, plate.Solution)
    assert isinstance(other, plate.Solution)
    assert one.problem.dofs.element.name == other.problem.dofs.element.name == "dkt+cst"
    # Round-off of quadrature, grown by the condition of a thin laminate.
    np.testing.assert_allclose(other.values, one.values, rtol=0.0, atol=1e-9 * np.abs(one.values).max())
    assert other.strain_energy == pytest.approx(one.strain_energy, rel=1e-9)
    fields = [corner_fields(solution) for solution in (one, other)]
    assert fields[1].stress == pytest.approx(fields[0].stress, rel=1e-7)
    failures = [plate.first_failure(solution).ratio for solution in (one, other)]
    assert failures[1] == pytest.approx(failures[0], rel=1e-7)


def test_what_varies_changes_with_the_plies_as_differences_say() -> None:
    laminate = plate.Laminate([plate.Ply(plate.material("T300/5208"), 0.01, a) for a in (20.0, -40.0)])
    loads = [
        plate.Temperature(lambda x, y: 30.0 * x * y),
        plate.Temperature(5.0),
        plate.Moisture(lambda x, y: 1e-3 * y),
    ]
    supports = [plate.Clamped(LineString([(0, 0), (0, 1)]))]
    problem = plate.Problem(plate.grid(2.0, 1.0, 3, 2), laminate, "dkt", supports, loads)
    solution = plate.solve(problem)
    found = plate.gradient(solution, ("deflection", (2.0, 0.5)), ["ply[1].angle", "ply[0].thickness"])
    for step, name, changed in (
        (
            1e-3,
            "ply[1].angle",
            lambda h: [
                plate.Ply(laminate.plies[0].material, 0.01, 20.0),
                plate.Ply(laminate.plies[0].material, 0.01, -40.0 + h),
            ],
        ),
        (
            1e-6,
            "ply[0].thickness",
            lambda h: [
                plate.Ply(laminate.plies[0].material, 0.01 + h, 20.0),
                plate.Ply(laminate.plies[0].material, 0.01, -40.0),
            ],
        ),
    ):
        ends = [
            float(plate.solve(problem.with_laminate(plate.Laminate(changed(h)))).deflection(2.0, 0.5))  # type: ignore[no-untyped-call,union-attr]
            for h in (step, -step)
        ]
        # Central differences leave the square of the relative step.
        assert found[name] == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-6)


def test_functions_that_fail_are_named() -> None:
    mesh = plate.grid(1.0, 1.0, 2, 2)
    for load, words in (
        (
            plate.Temperature(lambda x, y: 1.0 / (x + 1.0 - np.ceil(x + 0.5))),
            "rise of a Temperature is a function",
        ),
        (plate.Moisture(lambda x: x), "the content of a Moisture is a function that fails"),
        (plate.ElectricField([lambda x, y: x[:1]]), "the field of an ElectricField in ply 0 is a function"),
    ):
        problem = plate.Problem(mesh, SHEET, "lst", loads=[load])
        with np.errstate(divide="ignore"), pytest.raises(DesignError, match=words):
            plate.solve(problem)
    with pytest.raises(DesignError, match="the rise of a Temperature is 'x'; it must be a number"):
        plate.Temperature("x")  # type: ignore[arg-type]
    with pytest.raises(DesignError, match="an ElectricField has 2 fields"):
        plate.Problem(mesh, SHEET, "lst", loads=[plate.ElectricField([1.0, lambda x, y: x])])

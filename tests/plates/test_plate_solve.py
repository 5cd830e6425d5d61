"""Plates under load against closed forms and series: deflection, moments, reactions, energy."""

from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import LineString, Point, box

from lamc import plate
from lamc.basics.errors import DesignError, SimulationError
from lamc.plates.meshing.mesh import Mesh
from tests.support.plates import case, cross_ply, disk, isotropic, jittered, richardson, turned

BOUNDARY = "boundary"
LEFT, RIGHT = LineString([(0, 0), (0, 1)]), LineString([(1, 0), (1, 1)])
BOTTOM, TOP = LineString([(0, 0), (1, 0)]), LineString([(0, 1), (1, 1)])
PATTERNS = ("one-diagonal", "criss-cross", "union-jack")


def square(n: int, pattern: str = "one-diagonal") -> Mesh:
    return plate.grid(1.0, 1.0, n, n, pattern)


def centre(mesh: Mesh, support: object, load: object, element: str = "dkt", laminate: object = None) -> float:
    """Deflection of the middle of the unit square; D = 1 N·m, ν = 0.3 unless a laminate is given."""
    problem = plate.Problem(mesh, laminate or isotropic(), element, supports=[support], loads=[load])
    return float(plate.solve(problem).deflection(0.5, 0.5))


SQUARES = [
    ("ssss_unif", plate.SimplySupported(BOUNDARY), plate.Pressure(1.0)),
    ("ssss_point", plate.SimplySupported(BOUNDARY), plate.PointLoad((0.5, 0.5), 1.0)),
    ("cccc_unif", plate.Clamped(BOUNDARY), plate.Pressure(1.0)),
]


@pytest.mark.parametrize("element", ["dkt", "specht", "bciz"])
@pytest.mark.parametrize(("name", "support", "load"), SQUARES)
@pytest.mark.quick("ssss_unif-*", "ssss_point-*-dkt", "cccc_unif-*")
def test_square_plates_approach_the_series(
    shared: Path, name: str, support: object, load: object, element: str
) -> None:
    # A point load's error is h² log h: extrapolation gains less there, so it has smaller cells.
    answer, n = case(shared, name), 48 if name == "ssss_point" else 24
    got = richardson(*(centre(square(m), support, load, element) for m in (n, 2 * n)))
    assert got == pytest.approx(answer["expected"], rel=answer["rel_tol"])


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("element", ["dkt", "specht"])
def test_deflection_converges_with_the_square_of_the_cell(shared: Path, element: str, pattern: str) -> None:
    exact = case(shared, "ssss_unif")["expected"]
    load, support = plate.Pressure(1.0), plate.SimplySupported(BOUNDARY)
    errors = [abs(centre(square(n, pattern), support, load, element) / exact - 1.0) for n in (16, 32)]
    assert 1.9 < np.log2(errors[0] / errors[1]) < 2.1  # the next term of the error is of order h⁴


def test_conforming_rectangles_converge_with_the_fourth_power(shared: Path) -> None:
    exact = case(shared, "cccc_unif")["expected"]
    values = [
        centre(square(n, "squares"), plate.Clamped(BOUNDARY), plate.Pressure(1.0), "bfs") for n in (16, 32)
    ]
    errors = [abs(value / exact - 1.0) for value in values]
    assert np.log2(errors[0] / errors[1]) > 3.7  # cubic shape functions: h⁴ in energy and in deflection
    assert errors[1] < 1e-6


def test_a_clamped_disk_deflects_as_in_timoshenko(shared: Path) -> None:
    answer = case(shared, "disk_clamped_unif")
    for load, exact in zip(
        (plate.Pressure(1.0), plate.PointLoad((0.0, 0.0), 1.0)), answer["expected"], strict=True
    ):
        problems = (
            plate.Problem(disk(n), isotropic(), supports=[plate.Clamped(BOUNDARY)], loads=[load])
            for n in (16, 32)
        )
        got = richardson(*(float(plate.solve(p).deflection(0.0, 0.0)) for p in problems))
        assert got == pytest.approx(exact, rel=answer["rel_tol"])


def test_moments_and_curvature_of_a_clamped_disk() -> None:
    # Timoshenko and Woinowsky-Krieger, section 16: M_r = q/16 (R² (1 + ν) - r² (3 + ν)), w'' likewise.
    solution = plate.solve(
        plate.Problem(disk(32), isotropic(), supports=[plate.Clamped(BOUNDARY)], loads=[plate.Pressure(1.0)])
    )
    r = np.array([0.1, 0.3, 0.5, 0.7])
    a = 0.1  # rad; off the lines of symmetry of the mesh
    M = solution.moments(r * np.cos(a), r * np.sin(a))
    rotation = np.array([np.cos(a) ** 2, np.sin(a) ** 2, 2 * np.sin(a) * np.cos(a)])
    exact = (1.3 - r**2 * 3.3) / 16.0
    # Curvature within a cell is linear and of order h: 1/32 of the largest moment, 0.08.
    assert M @ rotation == pytest.approx(exact, abs=0.08 / 32)
    kappa = solution.curvature(r * np.cos(a), r * np.sin(a))
    D = isotropic().D
    assert pytest.approx(kappa @ D, rel=1e-12) == M  # the same numbers, multiplied


def test_a_strip_between_mirrors_bends_as_a_beam() -> None:
    # Symmetry along both sides: κ_y = 0, so w = q x (L³ - 2 L x² + x³) / 24 D.
    mesh = plate.grid(1.0, 0.25, 32, 8)
    sides = LineString([(0, 0), (1, 0)]), LineString([(0, 0.25), (1, 0.25)])
    ends = LineString([(0, 0), (0, 0.25)]), LineString([(1, 0), (1, 0.25)])
    supports = [*(plate.Symmetry(line) for line in sides), *(plate.SimplySupported(line) for line in ends)]
    solution = plate.solve(plate.Problem(mesh, isotropic(), supports=supports, loads=[plate.Pressure(2.0)]))
    x = np.linspace(0.0, 1.0, 9)
    exact = 2.0 * x * (1.0 - 2.0 * x**2 + x**3) / 24.0
    assert solution.deflection(x, 0.1) == pytest.approx(exact, abs=1e-3 * exact.max())  # h² = 1/1024


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("element", ["dkt", "specht"])
def test_prescribed_edges_of_constant_curvature_give_it_everywhere(element: str, pattern: str) -> None:
    # The patch test as a problem: w = x²/2 - x y + y² on the boundary, nothing inside.
    mesh = jittered(square(6, pattern))
    supports = [
        plate.Support(BOUNDARY, ("w",), lambda x, y: 0.5 * x**2 - x * y + y**2),
        plate.Support(BOUNDARY, ("w_x",), lambda x, y: x - y),
        plate.Support(BOUNDARY, ("w_y",), lambda x, y: -x + 2 * y),
    ]
    solution = plate.solve(plate.Problem(mesh, isotropic(), element, supports=supports))
    x, y = np.random.default_rng(1).uniform(0.0, 1.0, (2, 200))
    assert solution.curvature(x, y) == pytest.approx(np.broadcast_to([-1.0, -2.0, 2.0], (200, 3)), abs=1e-10)


def test_a_strip_under_end_moments_needs_no_support(shared: Path) -> None:
    # The moments are in balance, so the free strip is accepted; curvature is d = D⁻¹ on any mesh.
    answer = case(shared, "strip_pure_moment")
    cfrp = plate.Material(E1=350e9, E2=7e9, nu12=0.33, G12=5e9, density=1600)
    laminate = plate.Laminate([plate.Ply(cfrp, 50e-6, angle) for angle in (45.0, 22.5, 45.0)])
    mesh = jittered(plate.grid(10e-3, 2e-3, 20, 5, "union-jack"))
    ends = LineString([(0, 0), (0, 2e-3)]), LineString([(10e-3, 0), (10e-3, 2e-3)])
    for element in ("dkt", "specht"):
        solution = plate.solve(
            plate.Problem(mesh, laminate, element, loads=[plate.EdgeMoment(end, 1.0) for end in ends])
        )
        kappa = solution.curvature(np.array([1e-3, 5.1e-3, 9.9e-3]), 1.03e-3)
        expected = np.broadcast_to(answer["expected"], (3, 3))
        assert kappa == pytest.approx(expected, rel=answer["rel_tol"])
        assert "may rise" in solution.report.free


def test_the_actuator_strip_twists_under_a_straight_load(shared: Path) -> None:
    answer = case(shared, "strip_45_22_45")
    cfrp = plate.Material(E1=350e9, E2=7e9, nu12=0.33, G12=5e9, density=1600)
    laminate = plate.Laminate([plate.Ply(cfrp, 50e-6, angle) for angle in (45.0, 22.5, 45.0)])
    a, b = 10e-3, 2e-3
    rows = []
    for n in (1, 2):  # finer towards the clamped corners, where moments are infinite
        u = np.linspace(-1.0, 1.0, 16 * n + 1)
        y = 0.5 * b * (1.0 + np.sign(u) * (1.0 - (1.0 - np.abs(u)) ** 2))
        mesh = plate.grid_of_lines(a * np.linspace(0.0, 1.0, 40 * n + 1) ** 2, y, "criss-cross")
        solution = plate.solve(
            plate.Problem(
                mesh,
                laminate,
                supports=[plate.Clamped(LineString([(0, 0), (0, b)]))],
                loads=[plate.EdgeLoad(LineString([(a, 0), (a, b)]), 1e-3 / b)],
            )
        )
        w = solution.deflection(a, np.array([0.5, 0.0, 1.0]) * b)
        rows.append(np.append(w, solution.slope(a, 0.5 * b)[1]))
    got = [richardson(coarse, fine) for coarse, fine in zip(*rows, strict=True)]
    assert got == pytest.approx(answer["expected"], rel=answer["rel_tol"])


def test_a_heated_free_laminate_curls_as_theory_says(shared: Path) -> None:
    answer = case(shared, "thermal_0_90")
    material = plate.material("T300/5208")
    laminate = plate.Laminate([plate.Ply(material, 125e-6, angle) for angle in (0.0, 90.0)])
    mesh = jittered(plate.grid(0.1, 0.1, 6, 6, "union-jack"))
    solution = plate.solve(plate.Problem(mesh, laminate, loads=[plate.Temperature(-150.0)]))
    assert solution.problem.dofs.element.name == "dkt+cst"
    x, y = np.array([0.01, 0.05, 0.093]), np.array([0.02, 0.051, 0.01])
    strain, kappa = solution.strain(x, y), solution.curvature(x, y)
    got = np.concatenate([strain[:, :2], kappa[:, :2]], axis=1)
    assert got == pytest.approx(np.broadcast_to(answer["expected"], (3, 4)), rel=answer["rel_tol"])
    free = laminate.expansion(-150.0)
    # Nothing resists: resultants are round-off of those that expansion alone would make.
    assert np.abs(solution.forces(x, y)).max() < 1e-9 * np.abs(free.force).max()
    assert np.abs(solution.moments(x, y)).max() < 1e-9 * np.abs(free.moment).max()
    assert abs(solution.strain_energy) < 1e-9 * np.abs(free.force).max() * np.abs(strain).max() * 0.01


@pytest.mark.parametrize(
    ("layup", "angles", "held"),
    [
        ("[0/90/90/0]", (0.0, 90.0, 90.0, 0.0), ("v", "u")),
        ("[0/90]", (0.0, 90.0), ("v", "u")),
        ("[45/-45]", (45.0, -45.0), ("u", "v")),
    ],
)
@pytest.mark.quick("*-angles1-*")
def test_laminated_squares_deflect_as_naviers_series(
    shared: Path, layup: str, angles: tuple[float, ...], held: tuple[str, str]
) -> None:
    answer = case(shared, f"nav_E25_{layup}")
    laminate = cross_ply(angles)
    supports = [
        plate.SimplySupported(BOUNDARY),
        *(plate.Support(edge, (held[0],)) for edge in (LEFT, RIGHT)),
        *(plate.Support(edge, (held[1],)) for edge in (BOTTOM, TOP)),
    ]
    loads = {
        "sinusoidal": [plate.Pressure(lambda x, y: np.sin(np.pi * x) * np.sin(np.pi * y))],
        "uniform": [plate.Pressure(1.0)],
    }
    rows = []
    for n in (24, 48):
        # Four diagonals to a point: one-diagonal meshes favour one of +45 and -45.
        solutions = plate.solve(
            plate.Problem(square(n, "union-jack"), laminate, supports=supports, cases=loads)
        )
        rows.append([100.0 * solutions[name].deflection(0.5, 0.5) * laminate.thickness**3 for name in loads])
    got = [richardson(coarse, fine) for coarse, fine in zip(*rows, strict=True)]
    assert got == pytest.approx(answer["expected"], rel=answer["rel_tol"])


def everything(mesh: Mesh, laminate: plate.Laminate) -> plate.Problem:
    """A coupled plate with supports and loads of every kind."""
    return plate.Problem(
        mesh,
        laminate,
        supports=[
            plate.Clamped(LEFT),
            plate.SimplySupported(BOTTOM),
            plate.Hinged(LineString([(1, 0.5), (1, 1)]), stiffness=2.0),
            plate.Support(Point(0.5, 1), ("v", "w"), 1e-4),
        ],
        loads=[
            plate.PointLoad((0.31, 0.42), (1.0, -2.0, 3.0)),
            plate.EdgeLoad(TOP, (0.5, 0.25, -1.0)),
            plate.EdgeMoment(RIGHT, 0.7),
            plate.Pressure(lambda x, y: x - 2.0 * y),
            plate.SelfWeight((1.0, 2.0, -9.81)),
            plate.Temperature(3.0),
        ],
    )


def test_reactions_balance_the_loads() -> None:
    laminate = plate.Laminate([plate.Ply(plate.material("T300/5208"), 1e-3, angle) for angle in (0.0, 30.0)])
    solution = plate.solve(everything(jittered(square(8)), laminate))
    force = sum(reaction.force for reaction in solution.reactions)
    moment = sum(reaction.moment for reaction in solution.reactions)
    rho = laminate.areal_mass
    # By hand: point, edge of length 1 at y = 1, moment 0.7 about +y along x = 1, pressure, weight at (1/2, 1/2).
    applied = np.array([1.0, -2.0, 3.0]) + [0.5, 0.25, -1.0] + rho * np.array([1.0, 2.0, -9.81])
    applied[2] += 0.5 - 1.0
    turning = np.array([0.42 * 3.0, -0.31 * 3.0, 0.31 * -2.0 - 0.42 * 1.0])
    turning += [1.0 * -1.0, -0.5 * -1.0, 0.5 * 0.25 - 1.0 * 0.5]
    turning += [0.0, 0.7, 0.0]
    turning += [1.0 / 4 - 2.0 / 3, -(1.0 / 3 - 2.0 / 4), 0.0]
    turning += rho * np.array([0.5 * -9.81, -0.5 * -9.81, 0.5 * 2.0 - 0.5 * 1.0])
    # Sums of a few hundred numbers, the largest of them thermal forces of 1e5 N/m that cancel.
    assert force == pytest.approx(-applied, abs=1e-8)
    assert moment == pytest.approx(-turning, abs=1e-8)


def test_strain_energy_is_half_the_work() -> None:
    problem = plate.Problem(
        jittered(square(8)),
        cross_ply((0.0, 90.0)),
        supports=[plate.Clamped(LEFT), plate.Hinged(RIGHT, stiffness=0.5)],
        loads=[plate.PointLoad((0.5, 0.7), (0.0, 1e-3, 2e-3)), plate.EdgeMoment(TOP, 1e-3)],
    )
    solution = plate.solve(problem)
    assert solution.strain_energy == pytest.approx(0.5 * solution.compliance, rel=1e-12)
    # And it is what curvature and moments store, integrated by the middle of cells: linear strains, so h² of 1.
    fine = plate.solve(
        plate.Problem(
            square(24), isotropic(), supports=[plate.Clamped(BOUNDARY)], loads=[plate.Pressure(1.0)]
        )
    )
    middle = fine.problem.mesh.corners.mean(axis=1).T
    stored = 0.5 * np.einsum(
        "ki,ki,k->", fine.moments(*middle), fine.curvature(*middle), fine.problem.mesh.areas
    )
    assert stored == pytest.approx(fine.strain_energy, rel=0.02)


def test_work_of_one_load_along_the_deflection_of_another_is_the_same_the_other_way() -> None:
    # Maxwell and Betti, for a point load and an edge moment of a coupled plate.
    problem = plate.Problem(jittered(square(7)), cross_ply((0.0, 90.0)), supports=[plate.Clamped(LEFT)])
    model = plate.FactoredPlate(problem)
    at = (0.62, 0.33)
    one, other = model.solve([plate.PointLoad(at, 2.0)]), model.solve([plate.EdgeMoment(RIGHT, 3.0)])
    y = np.linspace(0.0, 1.0, 8)
    ends = [float(one.slope(1.0, value)[0]) for value in y]
    # The edge's slope is linear between its nodes for this element, so the trapezoidal rule is exact.
    turned_by_one = -3.0 * np.trapezoid(ends, y)
    assert turned_by_one == pytest.approx(2.0 * float(other.deflection(*at)), rel=1e-9)


def test_cases_share_a_model_and_add_up() -> None:
    first, second = [plate.Pressure(1.0)], [plate.PointLoad((0.3, 0.4), 5.0)]
    weight = plate.SelfWeight()
    mesh, laminate = square(8), isotropic(density=1000.0)
    support = plate.SimplySupported(BOUNDARY)
    problem = plate.Problem(
        mesh, laminate, supports=[support], loads=[weight], cases={"snow": first, "man": second}
    )
    solutions = plate.solve(problem)
    assert list(solutions) == ["snow", "man"]
    alone = plate.solve(plate.Problem(mesh, laminate, supports=[support], loads=[weight, *first, *second]))
    own = plate.solve(plate.Problem(mesh, laminate, supports=[support], loads=[weight]))
    total = solutions["snow"].values + solutions["man"].values - own.values
    assert total == pytest.approx(alone.values, abs=1e-13 * np.abs(alone.values).max())


def test_a_case_that_cannot_be_solved_is_named_and_leaves_the_others() -> None:
    pull = [plate.EdgeLoad(LineString([(1, 0), (1, 1)]), (1.0, 0.0, 0.0))]
    held = [plate.Support(BOUNDARY, ("w",))]
    problem = plate.Problem(
        square(4), isotropic(), supports=held, cases={"pull": pull, "up": [plate.Pressure(1.0)]}
    )
    with pytest.raises(DesignError, match="case 'pull': the plate is not held"):
        plate.solve(problem)
    model = plate.FactoredPlate(problem)
    alone = plate.Problem(square(4), isotropic(), "dkt+cst", held, [plate.Pressure(1.0)])
    assert np.array_equal(model.solve_case("up").values, plate.solve(alone).values)
    with pytest.raises(DesignError, match="the problem has no case 'down'; it has 'pull', 'up'"):
        model.solve_case("down")


def test_settling_supports_move_a_plate_rigidly() -> None:
    # Three points of a plane: w = 0.01 + 0.02 x - 0.03 y, nothing bends.
    points = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
    supports = [plate.Support(Point(p), ("w",), 0.01 + 0.02 * p[0] - 0.03 * p[1]) for p in points]
    solution = plate.solve(plate.Problem(jittered(square(5)), isotropic(), supports=supports))
    x, y = np.random.default_rng(2).uniform(0.0, 1.0, (2, 50))
    assert solution.deflection(x, y) == pytest.approx(0.01 + 0.02 * x - 0.03 * y, rel=1e-12)
    assert np.abs(solution.moments(x, y)).max() < 1e-12  # D = 1 N·m; digits of w = 0.05 over cells of 1/25 m²
    assert abs(solution.strain_energy) < 1e-20


@pytest.mark.parametrize("factor", [1e3, 1e6])
def test_units_do_not_matter(factor: float) -> None:
    # A plate in m and N, and in mm or µm and N: lengths times factor, moduli over its square.
    def solved(unit: float) -> plate.Solution:
        ply = plate.Material(E1=150e9 / unit**2, E2=9e9 / unit**2, nu12=0.3, G12=5e9 / unit**2, density=0.0)
        laminate = plate.Laminate([plate.Ply(ply, 1e-4 * unit, angle) for angle in (0.0, 45.0)])
        mesh = plate.grid(0.02 * unit, 0.01 * unit, 40, 20, "criss-cross")
        side = LineString([(0, 0), (0, 0.01 * unit)])
        load = plate.PointLoad((0.015 * unit, 0.004 * unit), (0.0, 1.0, 0.1))
        return plate.solve(plate.Problem(mesh, laminate, supports=[plate.Clamped(side)], loads=[load]))

    one, other = solved(1.0), solved(factor)
    x, y = np.array([0.005, 0.015, 0.02]), np.array([0.001, 0.004, 0.01])
    moved = other.displacement(x * factor, y * factor) / factor
    # Refined solutions differ by the rounding of coordinates alone; 1e-8 is asked for.
    assert moved == pytest.approx(one.displacement(x, y), rel=1e-11)
    assert other.moments(x * factor, y * factor) == pytest.approx(one.moments(x, y), rel=1e-9)
    assert other.compliance / factor == pytest.approx(one.compliance, rel=1e-11)


def hinged_links(r: float, links: int, across: int, rows: int = 4) -> plate.Problem:
    """Two unit links and a strip of width 0.01 and stiffness r between them, a unit moment at the tip."""
    x = np.concatenate(
        [
            np.linspace(0, 1, links + 1),
            1 + np.linspace(0, 0.01, across + 1)[1:],
            1.01 + np.linspace(0, 1, links + 1)[1:],
        ]
    )
    mesh = plate.grid_of_lines(x, np.linspace(0, 1, rows + 1), regions={"hinge": box(1.0, 0.0, 1.01, 1.0)})
    laminates = {"": isotropic(1.0, nu=0.0), "hinge": isotropic(r, nu=0.0)}
    tip = LineString([(2.01, 0), (2.01, 1)])
    return plate.Problem(mesh, laminates, supports=[plate.Clamped(LEFT)], loads=[plate.EdgeMoment(tip, 1.0)])


@pytest.mark.parametrize(("links", "across"), [(2, 1), (10, 4), (40, 20), (40, 100)])
@pytest.mark.parametrize("k", [0, 1, 2])
def test_soft_hinges_turn_right_on_coarse_and_fine_meshes(
    shared: Path, k: int, links: int, across: int
) -> None:
    answer = case(shared, "hinge")
    r, exact = answer["inputs"]["r"][k], answer["expected"][k]
    solution = plate.solve(hinged_links(r, links, across))
    # 1e-9 is asked for; refined unknowns are right to double round-off, and -w_x at the tip is one of them.
    assert -float(solution.slope(2.01, 0.5)[0]) == pytest.approx(exact, rel=1e-11)
    assert solution.report.accuracy.forward_error < 1e-12
    # Curvature of the links is 1 although they have turned by up to 1e7 rad: of deflections of 1e7 m long double keeps
    # 1e-12 m, which over cells of 1/40 m is 1e-9 of curvature.
    assert solution.curvature(1.7, 0.3) == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)


def test_digits_that_cannot_be_had_are_an_error_and_not_an_answer() -> None:
    with pytest.raises(SimulationError, match=r"no digits are left.*condition \d\.\de\+1[5-9]"):
        plate.solve(hinged_links(1e-13, 40, 100))


def test_slivers_of_a_thousand_to_one_stay_within_five_per_cent(shared: Path) -> None:
    answer = case(shared, "sliver")
    exact = case(shared, "ssss_unif")["expected"]
    got = centre(plate.grid(1.0, 1.0, 4, 4000), plate.SimplySupported(BOUNDARY), plate.Pressure(1.0))
    assert got / exact == pytest.approx(answer["expected"], rel=answer["rel_tol"])
    assert abs(got / exact - 1.0) < 0.05


def test_other_laminates_on_the_same_mesh_are_as_solved_anew() -> None:
    problem = everything(square(6), cross_ply((0.0, 90.0)))
    model = plate.FactoredPlate(problem)
    model.solve()
    for angles in ((30.0, 60.0), (0.0, 15.0)):
        laminate = cross_ply(angles)
        again = model.with_laminates(laminate).solve()
        anew = plate.solve(everything(square(6), laminate))
        assert again.values == pytest.approx(anew.values, abs=1e-12 * np.abs(anew.values).max())


@pytest.mark.parametrize("solver", ["cholmod", "pardiso"])
def test_solvers_agree(solver: str) -> None:
    pytest.importorskip({"cholmod": "sksparse.cholmod", "pardiso": "pypardiso"}[solver])
    problem = everything(jittered(square(8)), cross_ply((0.0, 45.0)))
    one, other = plate.solve(problem, "superlu"), plate.solve(problem, solver)
    assert other.report.solver == solver
    assert other.values == pytest.approx(one.values, abs=1e-13 * np.abs(one.values).max())
    model = plate.FactoredPlate(problem, solver)
    model.solve()
    again = model.with_laminates(cross_ply((10.0, 50.0))).solve()
    anew = plate.solve(everything(jittered(square(8)), cross_ply((10.0, 50.0))), "superlu")
    assert again.values == pytest.approx(anew.values, abs=1e-12 * np.abs(anew.values).max())


def test_ply_states_carry_the_moment() -> None:
    # ∫ stress z dz over the plies is the moment, by Simpson's rule on stresses that are linear in a ply.
    laminate = cross_ply((0.0, 90.0, 30.0))
    problem = plate.Problem(
        square(6),
        laminate,
        supports=[plate.Clamped(LEFT)],
        loads=[plate.EdgeLoad(RIGHT, 1e-6), plate.Temperature(0.0)],
    )
    solution = plate.solve(problem)
    states = solution.ply_states(0.41, 0.37)
    moment, force = np.zeros(3), np.zeros(3)
    for state in states:
        (low, high), (below, above) = state.z, state.stress
        middle = 0.5 * (below + above)
        moment += (high - low) / 6.0 * (low * below + 4.0 * 0.5 * (low + high) * middle + high * above)
        force += (high - low) * middle
    assert moment == pytest.approx(solution.moments(0.41, 0.37), rel=1e-9, abs=1e-18)
    assert force == pytest.approx(solution.forces(0.41, 0.37), rel=1e-9, abs=1e-15)


def test_results_take_the_shape_of_the_points() -> None:
    solution = plate.solve(
        plate.Problem(square(4), isotropic(), supports=[plate.Clamped(BOUNDARY)], loads=[plate.Pressure(1.0)])
    )
    x, y = np.meshgrid(np.linspace(0, 1, 3), np.linspace(0, 1, 5))
    assert solution.deflection(x, y).shape == (5, 3)
    assert solution.deflection(0.5, 0.5).shape == ()
    assert solution.deflection(0.5, np.linspace(0, 1, 7)).shape == (7,)
    assert solution.slope(x, y).shape == (5, 3, 2)
    for method in (
        solution.curvature,
        solution.moments,
        solution.displacement,
        solution.strain,
        solution.forces,
    ):
        assert method(x, y).shape == (5, 3, 3)
    assert solution.at_nodes("w").shape == (25,)
    assert solution.at_nodes("w").max() == pytest.approx(float(solution.deflection(0.5, 0.5)))


def test_a_plate_far_away_and_turned_behaves_the_same() -> None:
    laminate = isotropic()
    here = square(6)
    there = turned(here, 33.0, (20.0, -7.0))
    load, support = plate.Pressure(1.0), plate.Clamped(BOUNDARY)
    one = plate.solve(plate.Problem(here, laminate, supports=[support], loads=[load]))
    other = plate.solve(plate.Problem(there, laminate, supports=[support], loads=[load]))
    # Coordinates of 20 m with 16 digits, over cells of 1/6 m: 1e-14 in strains, twice differentiated.
    assert other.at_nodes("w") == pytest.approx(one.at_nodes("w"), abs=1e-11 * one.at_nodes("w").max())

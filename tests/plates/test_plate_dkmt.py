"""The element with shear through the thickness: three cross-checks, patches, closed forms, thin and thick."""

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import shapely

import lamc
from lamc import plate
from lamc.basics.errors import DesignError, ExportError, UnsupportedError
from lamc.plates.elements.library import element
from lamc.plates.laminates.sections import sections
from lamc.reference.plate_shear import ReferenceShearElement

NAMES = ("dkmt", "dkmt+cst", "dkmt+lst")
ALUMINIUM = plate.Material.isotropic(70e9, 0.3, 2700)
SKEW = plate.Material(140e9, 10e9, 0.3, 5e9, 1600, G13=5e9, G23=3.5e9)
CORE = plate.Material(60e6, 60e6, 0.0, 30e6, 50, G13=30e6, G23=30e6)
SANDWICH = plate.Laminate.sandwich(plate.Ply(ALUMINIUM, 1e-3), plate.Ply(CORE, 10e-3))
RNG = np.random.default_rng(41)
CORNERS = np.array([[0.0, 0.0], [1.0, 0.1], [0.2, 0.9]]) + 0.1 * RNG.normal(size=(7, 3, 2))


def stacks(scale: float) -> list[plate.Laminate]:
    """Uneven and anisotropic: A, B, D and H without zeros."""
    return [
        plate.Laminate(
            [plate.Ply(SKEW, scale * t, angle) for t, angle in ((1.0, 20), (2.0, -65), (0.5, k * 11))]
        )
        for k in range(len(CORNERS))
    ]


def section_rows(name: str, scale: float) -> np.ndarray:
    return sections(stacks(scale), element(name))


def relative(found: Any, expected: Any) -> float:
    return float(np.abs(found - expected).max() / np.abs(expected).max())


# --- three cross-checks
# ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("backend", ["c", "interpreted"])
@pytest.mark.parametrize("scale", [1e-4, 0.1, 10.0])  # thin, thick, and far thicker than long
@pytest.mark.quick("*-dkmt", others="campaign")
def test_c_and_program_agree_with_numeric_quadrature(name: str, backend: Any, scale: float) -> None:
    own, reference = plate.kernels(name, backend), ReferenceShearElement(name)
    assert own.element.dofs == reference.dofs
    rng, count = np.random.default_rng(5), len(CORNERS)
    rows, d = section_rows(name, scale), rng.normal(size=(count, own.unknown_count))
    xi = rng.uniform(0.1, 0.4, size=(count, 2))
    r = rng.normal(size=(count, own.strain_count))
    p, N, rho = (
        rng.normal(size=(count, len(own.element.fields), 3)),
        rng.normal(size=(count, 3)),
        rng.random(count),
    )
    K = reference.stiffness(CORNERS, rows)
    pairs = [
        (own.stiffness(CORNERS, rows), K),
        (own.force(CORNERS, rows, d), np.einsum("mij,mj->mi", K, d)),
        (own.mass(CORNERS, rho), reference.mass(CORNERS, rho)),
        (own.geometric(CORNERS, N), reference.geometric(CORNERS, N)),
        (own.load(CORNERS, p), reference.load(CORNERS, p)),
        (own.prestress(CORNERS, r, rows), reference.prestress(CORNERS, r, rows)),
        (own.strain(CORNERS, xi, d, rows), reference.strain(CORNERS, xi, d, rows)),
        (own.shear(CORNERS, xi, d, rows), reference.shear(CORNERS, xi, d, rows)),
    ]
    for k, (found, expected) in enumerate(pairs):
        # Some hundred roundings of 1e-16. γ of a thin cell is what is left here of a difference of φ = 1e-6 in 1.
        assert relative(found, expected) < (1e-14 if k < 7 else 1e-9), k


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.quick("dkmt")
def test_c_gives_the_bits_of_the_program(name: str) -> None:
    one, other = (plate.kernels(name, backend) for backend in ("c", "interpreted"))  # type: ignore[arg-type]
    rng = np.random.default_rng(6)
    rows, d = section_rows(name, 0.1), rng.normal(size=(len(CORNERS), one.unknown_count))
    xi = rng.uniform(0.1, 0.4, size=(len(CORNERS), 2))
    assert np.array_equal(one.stiffness(CORNERS, rows), other.stiffness(CORNERS, rows))
    assert np.array_equal(one.strain(CORNERS, xi, d, rows), other.strain(CORNERS, xi, d, rows))
    extended = [made.force(CORNERS, rows, d, np.longdouble) for made in (one, other)]
    assert np.array_equal(*extended)


def test_rigid_motion_strains_nothing_and_nothing_else_does() -> None:
    for scale in (1e-4, 0.1, 10.0):
        K = plate.kernels("dkmt").stiffness(CORNERS, section_rows("dkmt", scale))
        for matrix in K:
            values = np.linalg.eigvalsh(matrix)
            assert np.abs(values[:3]).max() < 1e-12 * values[-1]
            assert values[3] > 0.0


# --- patches ---------------------------------------------------------------------------------------------------------


def patch(h: float, deflection: Any, n: int = 4) -> tuple[plate.Solution, np.ndarray]:
    """A jittered patch, held on its boundary to `deflection`, (w, w_x, w_y) of x and y."""
    mesh = plate.jittered(plate.grid(1.0, 1.0, n, n))
    held = [
        plate.Support("boundary", (dof,), value=lambda x, y, k=k: deflection(x, y)[k])
        for k, dof in enumerate(("w", "w_x", "w_y"))
    ]
    laminate = plate.Laminate([plate.Ply(ALUMINIUM, h)])
    found = plate.solve(plate.Problem(mesh, laminate, "dkmt", supports=held))
    assert isinstance(found, plate.Solution)
    return found, mesh.points


@pytest.mark.parametrize("h", [1e-5, 1e-2, 0.1, 1.0])
def test_constant_curvature_is_exact_at_any_thickness(h: float) -> None:
    def field(x: Any, y: Any) -> tuple[Any, Any, Any]:
        return 0.5 * x * x - 0.3 * x * y + 0.7 * y * y, x - 0.3 * y, -0.3 * x + 1.4 * y

    found, points = patch(h, field)
    for k, name in enumerate(("w", "w_x", "w_y")):
        assert np.allclose(found.at_nodes(name)[: len(points)], field(*points.T)[k], atol=1e-9)
    assert np.allclose(found.curvature(0.31, 0.42), [-1.0, -1.4, 0.6], rtol=1e-8)  # digits of the solver
    assert np.abs(found.cell_shear(np.full((32, 2), 1 / 3))).max() < 1e-8 * h  # κ is 1 / m


def test_a_patch_under_constant_shear_force_converges() -> None:
    """M_x = Q x, γ_x = Q / H: w = Q x / H - Q x³ / (6 D), slope -Q x² / (2 D). DKMT has no cubics, and spends a part
    1 / (1 + φ), φ = 12 D / (H L²), of a constant γ on bending: halving cells takes the error to a fourth."""
    made = plate.Laminate([plate.Ply(ALUMINIUM, 0.5)])
    D, H = made.D[0, 0], made.H[0, 0]
    Q = 1e-3 * D
    errors = []
    for n in (4, 8, 16):
        found, _ = patch(0.5, lambda x, y: (Q * x / H - Q * x**3 / (6 * D), -Q * x**2 / (2 * D), 0.0 * y), n)
        off = found.cell_shear(np.full((2 * n * n, 2), 1 / 3)) / (Q / H) - [1.0, 0.0]
        errors.append(float(np.abs(off).mean()))
    assert errors[2] < 0.02
    assert all(fine < coarse / 2.5 for coarse, fine in pairwise(errors))  # in the mean of jittered cells


# --- closed forms ----------------------------------------------------------------------------------------------------


def middle(h: float, n: int, support: type, laminate: plate.Laminate | None = None, a: float = 1.0) -> float:
    made = laminate or plate.Laminate([plate.Ply(ALUMINIUM, h)])
    problem = plate.Problem(
        plate.grid(a, a, n, n), made, "dkmt", supports=[support("boundary")], loads=[plate.Pressure(1.0)]
    )
    found = plate.solve(problem)
    assert isinstance(found, plate.Solution)
    return float(found.deflection(a / 2, a / 2)) * made.D[0, 0] / a**4


def navier(h: float, laminate: plate.Laminate | None = None, a: float = 1.0, terms: int = 200) -> float:
    """Mindlin's hard simply supported square under uniform pressure, w D / (p a⁴): Navier's series, each term with
    1 + k² D / H. For laminates that are isotropic in their plane."""
    made = laminate or plate.Laminate([plate.Ply(ALUMINIUM, h)])
    ratio = made.D[0, 0] / (made.H[0, 0] * a * a)
    m, n = np.meshgrid(np.arange(1, terms, 2), np.arange(1, terms, 2))
    k2 = math.pi**2 * (m**2 + n**2)
    term = 16.0 / (math.pi**2 * m * n) / k2**2 * (1.0 + k2 * ratio)
    return float(np.sum(term * np.sin(m * math.pi / 2) * np.sin(n * math.pi / 2)))


@pytest.mark.parametrize("h", [1e-5, 1e-3, 0.01, 0.1, 0.3])
def test_simply_supported_square_is_mindlins_at_any_thickness(h: float) -> None:
    errors = [abs(middle(h, n, plate.SimplySupported) / navier(h) - 1.0) for n in (8, 16, 32)]
    assert errors[2] < 1e-3  # DKT's own error on this mesh is 0.9e-3
    assert all(fine < coarse / 3.0 for coarse, fine in pairwise(errors))  # second order: 4


def test_sandwich_is_as_soft_as_its_series_says() -> None:
    """9.2 % softer than without shear, of which solid elements say 9.1."""
    found = middle(0.0, 32, plate.SimplySupported, SANDWICH, 1.591)
    assert found == pytest.approx(navier(0.0, SANDWICH, 1.591), rel=1e-3)
    assert found / 0.00406235 == pytest.approx(1.092, abs=0.002)


@pytest.mark.parametrize(("h", "expected"), [(1e-5, 0.00126532), (0.1, 0.001505)])
def test_clamped_square_is_the_published_one(h: float, expected: float) -> None:
    """Thin: G. I. Taylor and others, 0.00126532; h/a = 0.1: 0.1505e-2 in tables of Mindlin plates, to four digits."""
    assert middle(h, 32, plate.Clamped) == pytest.approx(expected, rel=2.5e-3)


def test_clamped_circle_is_mindlins() -> None:
    """w = p R⁴ / (64 D) + p R² / (4 H) in the middle; the polygon is its own 0.5 % smaller."""
    disk = shapely.Point(0.0, 0.0).buffer(1.0, quad_segs=32)
    for h in (0.01, 0.2):
        made = plate.Laminate([plate.Ply(ALUMINIUM, h)])
        problem = plate.Problem(
            plate.mesh(disk, 0.08),
            made,
            "dkmt",
            supports=[plate.Clamped("boundary")],
            loads=[plate.Pressure(1e3)],
        )
        expected = 1e3 / (64.0 * made.D[0, 0]) + 1e3 / (4.0 * made.H[0, 0])
        assert float(plate.solve(problem).deflection(0.0, 0.0)) == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("h", [1e-3, 0.3])
def test_cantilever_is_timoshenkos(h: float) -> None:
    """A strip without Poisson's effect under an edge load: F L³ / (3 D b) + F L / (H b), exact at nodes of a beam."""
    bar = plate.Material(70e9, 70e9, 0.0, 35e9, 2700)
    made = plate.Laminate([plate.Ply(bar, h)])
    root, tip = (shapely.LineString([(x, 0.0), (x, 0.2)]) for x in (0.0, 1.0))
    problem = plate.Problem(
        plate.grid(1.0, 0.2, 20, 4),
        made,
        "dkmt",
        supports=[plate.Clamped(root)],
        loads=[plate.EdgeLoad(tip, 1e3)],
    )
    found = plate.solve(problem)
    expected = 1e3 / (3.0 * made.D[0, 0]) + 1e3 / made.H[0, 0]
    assert float(found.deflection(1.0, 0.1)) == pytest.approx(expected, rel=2e-3)
    if h > 0.1:  # in thin cells γ is what a bow leaves, and scatters
        assert found.shear_share == pytest.approx(3.0 * made.D[0, 0] / made.H[0, 0], rel=0.01)


# --- frequencies, buckling, heat -------------------------------------------------------------------------------------


def test_frequencies_are_those_of_mindlin_without_rotary_inertia() -> None:
    """ω² ρ h = D k⁴ / (1 + k² D / H), k² = π² (m² + n²) / a²."""
    made = plate.Laminate([plate.Ply(ALUMINIUM, 0.1)])
    problem = plate.Problem(
        plate.grid(1.0, 1.0, 24, 24), made, "dkmt", supports=[plate.SimplySupported("boundary")]
    )
    k2 = math.pi**2 * np.array([2, 5, 5, 8])
    D, H = made.D[0, 0], made.H[0, 0]
    expected = np.sqrt(D * k2**2 / (1.0 + k2 * D / H) / made.areal_mass)
    assert plate.modes(problem, 4).omega == pytest.approx(
        expected, rel=6e-3
    )  # second order: 0.5 (k / 24)², k = 2.8 π


def test_buckling_is_mindlins() -> None:
    """Uniaxial, simply supported: N = D k⁴ / (k_x² (1 + k² D / H)), of one half wave each way."""
    for h in (0.001, 0.1):
        made = plate.Laminate([plate.Ply(ALUMINIUM, h)])
        problem = plate.Problem(
            plate.grid(1.0, 1.0, 24, 24), made, "dkmt", supports=[plate.SimplySupported("boundary")]
        )
        k2 = 2.0 * math.pi**2
        expected = made.D[0, 0] * k2**2 / (math.pi**2 * (1.0 + k2 * made.D[0, 0] / made.H[0, 0]))
        found = plate.buckling(problem, 1, forces=(-1.0, 0.0, 0.0)).critical
        assert found == pytest.approx(expected, rel=5e-3)


@pytest.mark.slow
def test_heat_bends_a_free_bimetal_without_shear() -> None:
    """κ of the free laminate all over, whatever the shear stiffness is; so the corner of a square lifts by κ a²."""
    hot = plate.Material(70e9, 70e9, 0.3, 70e9 / 2.6, 2700, alpha1=23e-6, alpha2=23e-6)
    cold = plate.Material(200e9, 200e9, 0.3, 200e9 / 2.6, 7800, alpha1=12e-6, alpha2=12e-6)
    made = plate.Laminate([plate.Ply(hot, 0.02), plate.Ply(cold, 0.02)])
    middle_ = plate.Support(shapely.Point(0.5, 0.5), ("u", "v", "w", "w_x", "w_y"))
    free = plate.Support(shapely.Point(1.0, 0.5), ("v",))
    problem = plate.Problem(
        plate.grid(1.0, 1.0, 4, 4),
        made,
        "dkmt+lst",
        supports=[middle_, free],
        loads=[plate.Temperature(10.0)],
    )
    found = plate.solve(problem)
    kappa = made.deformation(temperature=10.0).curvature
    assert float(found.deflection(1.0, 1.0)) == pytest.approx(-0.5 * 0.25 * (kappa[0] + kappa[1]), rel=1e-6)


def test_coupled_laminates_do_not_mind_where_they_are_measured_from() -> None:
    """About its lower face a plate has B, and the same deflection; with LST, whose strains are linear as curvatures."""
    answers = []
    for reference, name in (("middle", "dkmt"), ("bottom", "dkmt+lst")):
        made = plate.Laminate([plate.Ply(ALUMINIUM, 0.1)], reference)
        problem = plate.Problem(
            plate.grid(1.0, 1.0, 12, 12),
            made,
            name,
            supports=[plate.Support("boundary", ("w", "w_x", "w_y"))],
            loads=[plate.Pressure(1e3)],
        )
        answers.append(float(plate.solve(problem).deflection(0.5, 0.5)))
    assert answers[1] == pytest.approx(answers[0], rel=5e-3)


def test_a_stiff_hinge_line_is_no_hinge() -> None:
    line = shapely.LineString([(0.5, 0.0), (0.5, 1.0)])
    made = plate.Laminate([plate.Ply(ALUMINIUM, 0.1)])
    whole, folded, free = (
        plate.solve(
            plate.Problem(
                plate.grid(1.0, 1.0, 12, 12),
                made,
                "dkmt",
                supports=[plate.Clamped("boundary")],
                loads=[plate.Pressure(1e3)],
                hinges=hinges,
            )
        )
        for hinges in ([], [plate.HingeLine(line, 1e16)], [plate.HingeLine(line, 0.0)])
    )
    w = float(whole.deflection(0.5, 0.5))
    assert float(folded.deflection(0.5, 0.5)) == pytest.approx(w, rel=1e-6)
    assert float(free.deflection(0.5, 0.5)) > 1.1 * w


# --- what it does not do
# -----------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_what_the_element_cannot_do_is_refused_by_name() -> None:
    made = plate.Laminate([plate.Ply(ALUMINIUM, 0.1)])
    problem = plate.Problem(
        plate.grid(1.0, 1.0, 4, 4),
        made,
        "dkmt",
        supports=[plate.Clamped("boundary")],
        loads=[plate.Pressure(1.0)],
    )
    found = plate.solve(problem)
    with pytest.raises(UnsupportedError, match=r"'dkmt'.*take 'dkt'"):
        plate.gradient(found, ("w", (0.5, 0.5)))
    with pytest.raises(ExportError, match="'dkmt' has shear"):
        lamc.export(problem)
    hollow = plate.Laminate([plate.Ply(ALUMINIUM, 1e-3), plate.Ply(ALUMINIUM, 1e-3, gap=5e-3)])
    with pytest.raises(DesignError, match="nothing in it bears shear"):
        plate.solve(
            plate.Problem(problem.mesh, hollow, "dkmt+cst", supports=problem.supports, loads=problem.loads)
        )
    with pytest.raises(UnsupportedError, match="has no shear"):
        plate.solve(replace(problem, element="dkt")).cell_shear(np.zeros((32, 2)))
    with pytest.raises(DesignError, match="give sections"):
        plate.kernels("dkmt").strain(CORNERS, np.zeros((7, 2)), np.zeros((7, 9)))


def test_errors_of_modes_count_shear() -> None:
    """A sandwich that is six times as soft in shear as in bending: nearly all of its error is of shear. Told within a
    third of the truth, which is 0.7 to 3.2 % on twelve cells."""
    core = plate.Material(60e6, 60e6, 0.0, 30e6, 50.0, G13=30e6, G23=30e6)
    made = plate.Laminate.sandwich(plate.Ply(ALUMINIUM, 1e-3), plate.Ply(core, 10e-3))
    a = 0.2
    found = plate.modes(
        plate.Problem(plate.grid(a, a, 12, 12), made, "dkmt", supports=[plate.SimplySupported("boundary")]), 4
    )
    k2 = math.pi**2 * np.array([2, 5, 5, 8]) / a**2
    D, H = made.D[0, 0], made.H[0, 0]
    expected = np.sqrt(D * k2**2 / (1.0 + k2 * D / H) / made.areal_mass)
    np.testing.assert_allclose(found.errors, found.omega / expected - 1.0, rtol=1 / 3)
    assert "mode 4" in " ".join(found.notes)


@pytest.mark.parametrize("kind", ["force", "support"])
def test_deflections_without_bound_are_reported(kind: str) -> None:
    """By P ln 2 / 2πH with each halving: found within 10 %, from 16 to 32 cells across, of a force. A thin plate's are
    finite, but for a part of 1e-4."""
    a, P = 0.2, 100.0

    def solved(h: float, n: int) -> Any:
        made = plate.Laminate([plate.Ply(ALUMINIUM, h)])
        loads: list[Any] = [plate.PointLoad((a / 2, a / 2), P)]
        supports: list[Any] = [plate.SimplySupported("boundary")]
        if kind == "support":
            middle_ = plate.Support(shapely.Point(a / 2, a / 2), ("w",))
            loads, supports = [plate.Pressure(P / a**2)], [*supports, middle_]
        mesh = plate.grid(a, a, n, n, "union-jack")
        return plate.solve(plate.Problem(mesh, made, "dkmt", supports=supports, loads=loads))

    thick, finer = solved(0.02, 16), solved(0.02, 32)
    assert "has no bound" in " ".join(thick.report.notes)
    assert not solved(0.002, 16).report.notes
    if kind == "force":
        made = plate.Laminate([plate.Ply(ALUMINIUM, 0.02)])
        grows = P * math.log(2.0) / (2.0 * math.pi * made.H[0, 0])
        found = float(finer.deflection(a / 2, a / 2) - thick.deflection(a / 2, a / 2))
        assert found == pytest.approx(grows, rel=0.1)

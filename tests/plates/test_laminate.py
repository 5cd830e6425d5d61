"""Classical laminate theory against reference answers, closed forms, invariances and bad input."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plate import Laminate, Material, Ply

# Sums of a few products of like size, each rounded once: some ulp.
ROUND_OFF = 1e-14

CFRP = Material(E1=350e9, E2=7e9, nu12=0.33, G12=5e9, density=1600)
REDDY = Material(E1=25.0, E2=1.0, nu12=0.25, G12=0.5, density=1.0)
STEEL = Material.isotropic(E=210e9, nu=0.3, density=7850, alpha=12e-6)


def stack(
    material: Material, thickness: float, *angles: float, reference: str | float = "middle"
) -> Laminate:
    return Laminate([Ply(material, thickness, angle) for angle in angles], reference)


def close(actual: object, expected: object, tolerance: float, scale: float) -> None:
    np.testing.assert_allclose(actual, expected, rtol=0.0, atol=tolerance * scale)  # type: ignore[arg-type]


def case(shared: Path, name: str) -> dict[str, Any]:
    cases = json.loads((shared / "reference" / "plates.json").read_text(encoding="utf-8"))["cases"]
    return next(entry for entry in cases if entry["id"] == name)


# --- reference answers -----------------------------------------------------------------------------------------------


def navier(laminate: Laminate, span: float, angle_ply: bool, terms: int) -> np.ndarray:
    """Deflection amplitudes (terms, terms) of a square, simply supported plate per unit amplitude of load.

    Each term has u, v, w of one wave in x and y that fit the supports; strains are then either sin sin or cos cos, and
    only stiffnesses between strains of one shape do work over the square.
    """
    wave = np.pi * np.arange(1, terms + 1) / span
    a, b = np.meshgrid(wave, wave, indexing="ij")
    zero = np.zeros_like(a)
    if angle_ply:  # u = U sin ax cos by, v = V cos ax sin by, w = W sin ax sin by
        strains = [[a, zero, zero], [zero, b, zero], [-b, -a, zero]]
        sine_sine = np.array([False, False, True, True, True, False])
    else:  # u = U cos ax sin by, v = V sin ax cos by, w = W sin ax sin by
        strains = [[-a, zero, zero], [zero, -b, zero], [b, a, zero]]
        sine_sine = np.array([True, True, False, True, True, False])
    strains += [[zero, zero, a * a], [zero, zero, b * b], [zero, zero, -2 * a * b]]
    G = np.array(strains).transpose(2, 3, 0, 1)
    block = np.block([[laminate.A, laminate.B], [laminate.B, laminate.D]])
    K = G.swapaxes(-1, -2) @ np.where(sine_sine[:, None] == sine_sine, block, 0.0) @ G
    return np.linalg.inv(K)[..., 2, 2]


@pytest.mark.parametrize("layup", ["[0/90/90/0]", "[0/90]", "[45/-45]"])
def test_square_laminate_deflects_as_published(shared: Path, layup: str) -> None:
    entry = case(shared, f"nav_E25_{layup}")
    angles = [float(text) for text in layup.strip("[]").split("/")]
    span, h = 1.0, 0.01
    laminate = stack(REDDY, h / len(angles), *angles)
    amplitude = navier(laminate, span, layup == "[45/-45]", terms=199)
    order = np.arange(1, 200)
    centre = np.sin(np.pi * order / 2)
    uniform = np.where(order % 2 == 1, 4 / (np.pi * order), 0.0)  # Fourier coefficients of 1
    w_sine = amplitude[0, 0]
    w_uniform = (amplitude * np.outer(uniform * centre, uniform * centre)).sum()
    found = 100 * h**3 / span**4 * np.array([w_sine, w_uniform])
    assert found == pytest.approx(entry["expected"], rel=entry["rel_tol"])


def test_coupled_strip_under_pure_moment(shared: Path) -> None:
    entry = case(shared, "strip_pure_moment")
    bent = stack(CFRP, 50e-6, 45, 22.5, 45).deformation(moment=(1, 0, 0))
    assert bent.curvature == pytest.approx(entry["expected"], rel=entry["rel_tol"])
    # Symmetric stack, so no stretch: round-off of a strain as large as the one at the faces.
    close(bent.strain, np.zeros(3), ROUND_OFF, np.abs(bent.curvature).max() * 150e-6)
    assert bent.curvature[2] / bent.curvature[0] == pytest.approx(-0.9363098622, rel=1e-9)


def test_long_strip_has_its_known_asymptote(shared: Path) -> None:
    """The note of `strip_45_22_45`: a narrow strip's tip goes down by d11 P L³ / (3 b) = 3.8870e-5 m."""
    assert "3.8870e-5" in case(shared, "strip_45_22_45")["note"]
    d11 = stack(CFRP, 50e-6, 45, 22.5, 45).deformation(moment=(1, 0, 0)).curvature[0]
    # Five digits are printed.
    assert d11 * 1e-3 * 10e-3**3 / (3 * 2e-3) == pytest.approx(3.8870e-5, rel=2e-5)


def test_cooled_cross_ply_takes_its_published_shape(shared: Path) -> None:
    entry = case(shared, "thermal_0_90")
    cooled = stack(plate.material("T300/5208"), 125e-6, 0, 90).deformation(temperature=-150)
    found = [*cooled.strain[:2], *cooled.curvature[:2]]
    assert found == pytest.approx(entry["expected"], rel=entry["rel_tol"])


# --- closed forms ----------------------------------------------------------------------------------------------------


def test_isotropic_plate_has_its_textbook_stiffness() -> None:
    E, nu, h = 210e9, 0.3, 1.5e-3
    laminate = stack(STEEL, h / 3, 0, 33, 71)  # angles mean nothing to it
    shape = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    D = E * h**3 / (12 * (1 - nu**2))
    close(laminate.D, D * shape, ROUND_OFF, D)
    close(laminate.A, E * h / (1 - nu**2) * shape, ROUND_OFF, E * h)
    close(laminate.B, np.zeros((3, 3)), ROUND_OFF, E * h**2)
    constants = laminate.engineering_constants
    assert [constants.Ex, constants.Ey, constants.Gxy] == pytest.approx([E, E, E / 2.6], rel=1e-13)
    assert constants.nuxy == pytest.approx(nu, rel=1e-13)
    assert laminate.areal_mass == pytest.approx(7850 * h, rel=1e-14)
    assert laminate.thickness == pytest.approx(h, rel=1e-15)


def test_reduced_stiffness_undoes_the_compliance() -> None:
    """Strains under unit stresses are the columns of S, by what E1, E2, nu12 and G12 mean."""
    m = CFRP
    S = np.array([[1 / m.E1, -m.nu12 / m.E1, 0], [-m.nu12 / m.E1, 1 / m.E2, 0], [0, 0, 1 / m.G12]])
    close(m.Q @ S, np.eye(3), ROUND_OFF, 1.0)


@pytest.mark.parametrize("angle", [0.0, 17.0, -30.0, 45.0, 60.0, 90.0, 121.0, -160.0])
def test_turned_stiffness_is_the_textbook_polynomial(angle: float) -> None:
    """Jones section 2.6, in powers of sine and cosine."""
    (q11, q12, _), (_, q22, _), (_, _, q66) = CFRP.Q
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    xx = q11 * c**4 + 2 * (q12 + 2 * q66) * s**2 * c**2 + q22 * s**4
    yy = q11 * s**4 + 2 * (q12 + 2 * q66) * s**2 * c**2 + q22 * c**4
    xy = (q11 + q22 - 4 * q66) * s**2 * c**2 + q12 * (s**4 + c**4)
    ss = (q11 + q22 - 2 * q12 - 2 * q66) * s**2 * c**2 + q66 * (s**4 + c**4)
    xs = (q11 - q12 - 2 * q66) * s * c**3 + (q12 - q22 + 2 * q66) * s**3 * c
    ys = (q11 - q12 - 2 * q66) * s**3 * c + (q12 - q22 + 2 * q66) * s * c**3
    close(CFRP.stiffness(angle), [[xx, xy, xs], [xy, yy, ys], [xs, ys, ss]], ROUND_OFF, q11)


def test_positive_angle_turns_the_stiff_direction_from_x_towards_y() -> None:
    """Fibres at +30°: shear that lengthens them, γ > 0, must meet A16 > 0; at -30° the opposite."""
    assert stack(CFRP, 1e-4, 30).A[0, 2] > 0 > stack(CFRP, 1e-4, -30).A[0, 2]


def test_off_axis_modulus_is_the_textbook_one() -> None:
    """1/Ex = c⁴/E1 + (1/G12 - 2 nu12/E1) s² c² + s⁴/E2."""
    c, s = math.cos(math.radians(25)), math.sin(math.radians(25))
    m = CFRP
    compliance = c**4 / m.E1 + (1 / m.G12 - 2 * m.nu12 / m.E1) * s**2 * c**2 + s**4 / m.E2
    # Inverting A with a condition number of E1/G12 or so loses two digits.
    assert stack(m, 1e-4, 25).engineering_constants.Ex == pytest.approx(1 / compliance, rel=1e-12)


def test_two_directions_of_fibres_open_like_scissors() -> None:
    """Fibres that hardly stretch, in two directions d: the free strain keeps their lengths, dᵀ ε d = 0 for both. For
    45° and 22.5° that gives ε_y / ε_x = 1 + √2 under any pull: a negative Poisson ratio.
    """

    def miss(E1: float) -> float:
        stiff = Material(E1=E1, E2=1e9, nu12=0.3, G12=1e9, density=1)
        return abs(stack(stiff, 1e-4, 45, 22.5).engineering_constants.nuxy + (1 + math.sqrt(2)))

    # What fibres do stretch is of first order in E2/E1: ten times stiffer, ten times closer, to second order.
    assert miss(1e15) < 1e-3
    assert miss(1e14) / miss(1e15) == pytest.approx(10, rel=0.02)


def test_symmetric_stack_does_not_couple_stretch_and_bending() -> None:
    laminate = stack(CFRP, 50e-6, 10, -35, 80, 80, -35, 10)
    close(laminate.B, np.zeros((3, 3)), ROUND_OFF, CFRP.E1 * laminate.thickness**2)


def test_balanced_stack_does_not_couple_stretch_and_shear() -> None:
    laminate = stack(CFRP, 50e-6, 30, 45, -30, -45, 90, 0)
    close(laminate.A[:2, 2], np.zeros(2), ROUND_OFF, CFRP.E1 * laminate.thickness)


def test_cross_ply_has_no_shear_coupling_at_all() -> None:
    laminate = stack(CFRP, 50e-6, 0, 90, 270, -180)
    for matrix in (laminate.A, laminate.B, laminate.D):
        assert np.all(matrix[:2, 2] == 0.0)  # exactly: quarter turns are free of round-off


def test_two_cross_plies_couple_as_in_closed_form() -> None:
    """[0/90], the lower ply along x: B11 = -(Q11 - Q22) h²/8 = -B22, all else zero (Jones section 4.3.3)."""
    laminate = stack(CFRP, 75e-6, 0, 90)
    rest = 1 - CFRP.nu12**2 * CFRP.E2 / CFRP.E1
    b = (CFRP.E1 - CFRP.E2) / rest * laminate.thickness**2 / 8
    close(laminate.B, np.diag([-b, b, 0.0]), ROUND_OFF, b)


@pytest.mark.parametrize("height", [-2e-3, 0.0, 1.3e-4])
def test_parallel_axis_rule(height: float) -> None:
    """z' = z - r: A' = A, B' = B - r A, D' = D - 2 r B + r² A."""
    middle, moved = (stack(CFRP, 50e-6, 0, 30, 90, reference=r) for r in ("middle", height))
    A, B, D = middle.A, middle.B, middle.D
    np.testing.assert_array_equal(moved.A, A)
    size = abs(height) + middle.thickness
    close(moved.B, B - height * A, ROUND_OFF, A.max() * size)
    close(moved.D, D - 2 * height * B + height**2 * A, ROUND_OFF, A.max() * size**2)


def test_named_surfaces_are_where_their_names_say() -> None:
    plies = [Ply(CFRP, 1e-4), Ply(STEEL, 3e-4)]
    assert Laminate(plies, "bottom").interfaces == pytest.approx([0, 1e-4, 4e-4], abs=1e-18)
    assert Laminate(plies, "top").interfaces == pytest.approx([-4e-4, -3e-4, 0], abs=1e-18)
    assert Laminate(plies).interfaces == pytest.approx([-2e-4, -1e-4, 2e-4], abs=1e-18)
    assert Laminate(plies, 2e-4).reference_height == pytest.approx(Laminate(plies, "top").reference_height)


def test_sandwich_bends_as_its_faces_do() -> None:
    """Faces E t d²/2 and their own E t³/6, soft core E_c c³/12, all over 1 - nu² (nu is the same)."""
    core = Material.isotropic(E=1e6, nu=0.3, density=50)
    t, c = 0.5e-3, 10e-3
    D = Laminate([Ply(STEEL, t), Ply(core, c), Ply(STEEL, t)]).D[0, 0]
    d = c + t
    expected = (210e9 * (t * d**2 / 2 + t**3 / 6) + 1e6 * c**3 / 12) / (1 - 0.3**2)
    assert pytest.approx(expected, rel=1e-13) == D


def test_bimetal_bends_as_timoshenko_says() -> None:
    """κ = 6 (α2 - α1) ΔT (1 + m)² / (h (3 (1+m)² + (1 + m n) (m² + 1/(m n)))), m = t1/t2, n = E1/E2 (J. Opt. Soc. Am.
    11, 1925, eq. 4); 1 below. With equal Poisson ratios a plate bends so in both directions. The upper metal expands
    more, so the strip bows upwards: w_xx < 0, κ > 0.
    """
    low = Material.isotropic(E=120e9, nu=0.3, density=1, alpha=2e-6)
    high = Material.isotropic(E=70e9, nu=0.3, density=1, alpha=23e-6)
    t1, t2, rise = 0.4e-3, 0.7e-3, 50.0
    m, n, h = t1 / t2, 120 / 70, t1 + t2
    kappa = 6 * 21e-6 * rise * (1 + m) ** 2 / (h * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n))))
    for reference in ("middle", "bottom"):
        bent = Laminate([Ply(low, t1), Ply(high, t2)], reference).deformation(temperature=rise)
        assert bent.curvature[:2] == pytest.approx([kappa, kappa], rel=1e-12)


# --- strains and stresses in the plies -------------------------------------------------------------------------------


def test_bent_isotropic_plate_has_six_m_over_h_squared_at_its_faces() -> None:
    h, moment = 2e-3, 7.0
    laminate = Laminate([Ply(STEEL, h)])
    bent = laminate.deformation(moment=(moment, 0, 0))
    (state,) = laminate.ply_states(bent.strain, bent.curvature)
    close(state.stress, [[-6 * moment / h**2, 0, 0], [6 * moment / h**2, 0, 0]], 1e-13, moment / h**2)


def test_fibre_stress_of_a_ply_pulled_along_its_fibres() -> None:
    """Pure stress along fibres at 35°: σ1 = s and nothing else, and the strain is s/E1 along, -nu12 s/E1 across."""
    c, s = math.cos(math.radians(35)), math.sin(math.radians(35))
    laminate = stack(CFRP, 1e-4, 35)
    pull = 5e6  # Pa
    stretched = laminate.deformation(force=np.array([c * c, s * s, c * s]) * pull * 1e-4)
    (state,) = laminate.ply_states(stretched.strain, stretched.curvature)
    # Inverting A with a condition number of E1/G12 or so loses two digits.
    close(state.stress_material, [[pull, 0, 0]] * 2, 1e-12, pull)
    strain = pull / CFRP.E1
    close(state.strain_material, [[strain, -0.33 * strain, 0]] * 2, 1e-12, strain)


def test_free_expansion_of_a_single_ply_is_without_stress() -> None:
    ply = Material(181e9, 10.3e9, 0.28, 7.17e9, 1600, 0.02e-6, 22.5e-6, 0.0, 0.6)
    laminate = stack(ply, 1e-4, 20)
    free = laminate.deformation(temperature=80, moisture=0.005)
    (state,) = laminate.ply_states(free.strain, free.curvature, temperature=80, moisture=0.005)
    close(state.strain_material, [[1.6e-6, 22.5e-6 * 80 + 0.003, 0]] * 2, 1e-12, 0.005)
    close(state.stress, np.zeros((2, 3)), 1e-12, 181e9 * 0.005)


def test_thermal_and_moisture_resultants_of_a_held_isotropic_plate() -> None:
    """Held plate: N = E α h / (1 - nu) per kelvin in all directions; no moment about the middle, N h/2 about the
    bottom. Moisture does the same with β."""
    metal = Material.isotropic(E=70e9, nu=0.25, density=1, alpha=23e-6, beta=0.1)
    laminate = Laminate([Ply(metal, 1e-3, 50)], reference="bottom")
    for resultants, expansion in ((laminate.thermal, 23e-6), (laminate.moisture, 0.1)):
        N = 70e9 * expansion * 1e-3 / 0.75
        close(resultants.force, [N, N, 0], ROUND_OFF, N)
        close(resultants.moment, [N * 0.5e-3, N * 0.5e-3, 0], ROUND_OFF, N * 1e-3)


finite = st.floats(-1.0, 1.0)
vectors = st.tuples(finite, finite, finite)
angles = st.floats(-360.0, 360.0)


@st.composite
def materials(draw: st.DrawFn) -> Material:
    E1, E2, G12 = (10.0 ** draw(st.floats(6.0, 12.0)) for _ in range(3))
    nu12 = draw(st.floats(-0.95, 0.95)) * math.sqrt(E1 / E2)
    alpha = draw(st.tuples(st.floats(-1e-4, 1e-4), st.floats(-1e-4, 1e-4)))
    return Material(E1, E2, nu12, G12, 1000.0, *alpha)


@st.composite
def laminates(draw: st.DrawFn) -> Laminate:
    plies = draw(st.lists(st.builds(Ply, materials(), st.floats(1e-6, 1e-2), angles), min_size=1, max_size=6))
    return Laminate(plies, draw(st.sampled_from(["bottom", "middle", "top"]) | st.floats(-1e-2, 1e-2)))


@given(laminates(), vectors, vectors, st.floats(-100, 100))
def test_resultants_are_the_integrals_of_ply_stress(
    laminate: Laminate, strain: tuple[float, ...], bend: tuple[float, ...], rise: float
) -> None:
    """∫ stress dz by Simpson's rule, exact for the linear stress and its first moment."""
    size = laminate.thickness + abs(laminate.reference_height)
    kappa = np.array(bend) / size
    N, M = np.zeros(3), np.zeros(3)
    for state in laminate.ply_states(strain, kappa, temperature=rise):
        z, stress = state.z, state.stress
        t = state.ply.thickness  # the difference of z far from the reference has lost digits
        N += t * stress.mean(axis=0)
        M += t / 6 * (z[0] * stress[0] + 4 * z.mean() * stress.mean(axis=0) + z[1] * stress[1])
    thermal = laminate.thermal
    A, B, D = laminate.A, laminate.B, laminate.D
    # A strain of one and Q's largest entry bound every term; 100 roundings of terms of that size.
    scale = np.abs(A).max() * (1 + 1e-2)
    close(N, A @ strain + B @ kappa - rise * thermal.force, 1e-13, scale)
    close(M, B @ strain + D @ kappa - rise * thermal.moment, 1e-13, scale * size)


# --- invariances -----------------------------------------------------------------------------------------------------


@given(laminates())
def test_stiffness_is_symmetric_and_positive_definite(laminate: Laminate) -> None:
    for matrix in (laminate.A, laminate.D):
        np.testing.assert_array_equal(matrix, matrix.T)
        # Plies of E1/E2 = 1e6 bring one eigenvalue to 1e-6 of the largest and |nu| near its bound a digit more;
        # round-off is 1e-16, so a sign is certain.
        assert np.linalg.eigvalsh(matrix).min() > 0.0
    np.testing.assert_array_equal(laminate.B, laminate.B.T)
    assert not laminate.A.flags.writeable


@given(materials(), st.integers(-360, 360))
def test_half_turn_changes_nothing(material: Material, angle: int) -> None:
    there, back = (stack(material, 1e-4, turned, turned + 13) for turned in (angle, angle + 180))
    for one, other in ((there.A, back.A), (there.B, back.B), (there.D, back.D)):
        np.testing.assert_array_equal(one, other)  # exactly: half turns are free of round-off


@given(laminates(), angles, vectors, vectors)
def test_energy_does_not_depend_on_the_axes(
    laminate: Laminate, rotation: float, strain: tuple[float, ...], bend: tuple[float, ...]
) -> None:
    """Plies and deformation turned together store the same energy; the tensors are turned as matrices, R ε Rᵀ."""
    c, s = math.cos(math.radians(rotation)), math.sin(math.radians(rotation))
    R = np.array([[c, -s], [s, c]])

    def turned(vector: np.ndarray) -> np.ndarray:
        x, y, shear = vector
        tensor = R @ np.array([[x, shear / 2], [shear / 2, y]]) @ R.T
        return np.array([tensor[0, 0], tensor[1, 1], 2 * tensor[0, 1]])

    def energy(stack: Laminate, e: np.ndarray, k: np.ndarray) -> float:
        return float(0.5 * e @ stack.A @ e + e @ stack.B @ k + 0.5 * k @ stack.D @ k)

    size = laminate.thickness + abs(laminate.reference_height)
    e, k = np.array(strain), np.array(bend) / size
    other = Laminate(
        [Ply(p.material, p.thickness, p.angle + rotation) for p in laminate.plies], laminate.reference
    )
    # The angle of 720° at most is rounded to 1e-13°, 2e-15 rad; each term is at most the largest A.
    close(energy(other, turned(e), turned(k)), energy(laminate, e, k), 1e-12, np.abs(laminate.A).max())


@given(laminates(), vectors, vectors)
def test_deformation_undoes_the_stiffness(
    laminate: Laminate, force: tuple[float, ...], moment: tuple[float, ...]
) -> None:
    M = np.array(moment) * laminate.thickness
    answer = laminate.deformation(force, M)
    N_back = laminate.A @ answer.strain + laminate.B @ answer.curvature
    M_back = laminate.B @ answer.strain + laminate.D @ answer.curvature
    # Backward error of a 6 by 6 solve: some ulp of the terms that are added up.
    terms = np.abs(laminate.ABD) @ np.abs(np.concatenate([answer.strain, answer.curvature]))
    h = laminate.thickness
    scale = max(terms[:3].max(), terms[3:].max() / h)
    close(N_back, force, 1e-13, scale)
    close(M_back / h, np.array(moment), 1e-13, scale)


# --- refusals --------------------------------------------------------------------------------------------------------


def material_with(**changes: Any) -> Material:
    return Material(**{"E1": 40e9, "E2": 10e9, "nu12": 0.3, "G12": 4e9, "density": 1.0, **changes})


BAD_MATERIALS = {
    "zero modulus": ({"E1": 0.0}, r"E1 of a material is 0 Pa; a modulus must be positive"),
    "negative modulus": ({"E2": -1e9}, r"E2 of a material is -1e\+09 Pa"),
    "zero shear modulus": ({"G12": 0}, r"G12 of a material is 0 Pa"),
    "not finite": ({"E1": math.inf}, r"E1 of a material is inf; it must be finite"),
    "no number": ({"alpha1": "hot"}, r"alpha1 of a material is 'hot'; it must be a number"),
    "not a number": ({"beta2": math.nan}, r"beta2 of a material is nan"),
    "negative density": ({"density": -1}, r"density of a material is -1"),
    "ratio at its bound": ({"nu12": 2.0}, r"\|nu12\| must be below sqrt\(E1/E2\) = 2: .* nu21"),
    "ratio beyond": ({"nu12": -2.5, "name": "glass"}, r"nu12 of material 'glass' is -2.5; .*= 2"),
    "huge ratio": ({"nu12": 1e200}, r"nu12 of a material is 1e\+200"),
    "name": ({"name": 7}, r"name of a material is 7; it must be text"),
}


@pytest.mark.parametrize("name", BAD_MATERIALS)
def test_impossible_material_is_refused(name: str) -> None:
    changes, message = BAD_MATERIALS[name]
    with pytest.raises(DesignError, match=message) as caught:
        material_with(**changes)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("nu", [-1.0, 0.51, math.nan])
def test_impossible_isotropic_ratio_is_refused(nu: float) -> None:
    with pytest.raises(DesignError, match="nu of material 'cork'"):
        Material.isotropic(E=1e9, nu=nu, density=1, name="cork")


def test_isotropic_bounds_are_named() -> None:
    with pytest.raises(DesignError, match="-1 < nu <= 1/2"):
        Material.isotropic(E=1e9, nu=0.6, density=1)
    with pytest.raises(DesignError, match="E of a material is -1 Pa"):
        Material.isotropic(E=-1, nu=0.3, density=1)
    assert Material.isotropic(E=3.0, nu=0.5, density=1).G12 == 1.0  # rubber is a material


BAD_PLIES = {
    "no material": (lambda: Ply(None, 1e-4), "the material of a ply is None; it must be a Material"),  # type: ignore[arg-type]
    "no thickness": (lambda: Ply(CFRP, 0.0), "the thickness of a ply is 0 m; it must be positive"),
    "negative thickness": (lambda: Ply(CFRP, -1e-4), "the thickness of a ply is -0.0001 m"),
    "endless": (lambda: Ply(CFRP, math.inf), "the thickness of a ply is inf; it must be finite"),
    "angle": (lambda: Ply(CFRP, 1e-4, math.nan), "the angle of a ply is nan"),
    "no plies": (lambda: Laminate([]), "a laminate has no plies; give one at least"),
    "one ply": (lambda: Laminate(Ply(CFRP, 1e-4)), "put it into a tuple"),  # type: ignore[arg-type]
    "materials": (lambda: Laminate([CFRP]), "plies of a laminate holds Material.* each must be a Ply"),  # type: ignore[list-item]
    "surface": (
        lambda: Laminate([Ply(CFRP, 1e-4)], "centre"),
        "'centre'; it must be one of bottom, middle, top",
    ),
    "offset": (lambda: Laminate([Ply(CFRP, 1e-4)], math.nan), "the reference surface of a laminate is nan"),
    "too small": (lambda: Laminate([Ply(CFRP, 1e-120)]), "out of the range .* check the units"),
    "too large": (lambda: Laminate([Ply(CFRP, 1e120)]), "out of the range .* check the units"),
    "force": (lambda: Laminate([Ply(CFRP, 1e-4)]).deformation((1, 0)), "the force per width .* shape"),
    "strain": (lambda: Laminate([Ply(CFRP, 1e-4)]).ply_states((1, 0, math.inf)), "the strain of a laminate"),
    "library": (lambda: plate.material("unobtainium"), "no material 'unobtainium' .* Kapton HN, Mylar"),
}


@pytest.mark.parametrize("name", BAD_PLIES)
def test_impossible_laminate_is_refused(name: str) -> None:
    make, message = BAD_PLIES[name]
    with pytest.raises(DesignError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_library_names_its_sources() -> None:
    for name, entry in plate.LIBRARY.items():
        assert entry.name == name
        assert entry.source
        assert plate.material(name) is entry


def test_equal_laminates_are_equal_and_can_be_keys() -> None:
    one, other = stack(CFRP, 1e-4, 0, 90), stack(CFRP, 1e-4, 0, 90)
    assert one == other
    assert len({one, other}) == 1
    assert one != stack(CFRP, 1e-4, 90, 0)

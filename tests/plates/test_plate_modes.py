"""Natural frequencies and modes against closed forms, published tables and a Ritz method without elements."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely.geometry import LineString, box

from lamc import plate
from lamc.plates.meshing.mesh import Mesh
from tests.support.plate_ritz import frequencies
from tests.support.plates import assert_refused

NU = 0.3
UNIT = plate.Material.isotropic(12 * (1 - NU**2), NU, 1.0)  # D = 1 N·m and 1 kg/m² at a thickness of 1 m
ISOTROPIC = plate.Laminate([plate.Ply(UNIT, 1.0)])
CFRP = plate.Material(E1=350e9, E2=7e9, nu12=0.33, G12=5e9, density=1600)
REDDY = plate.Material(E1=25.0, E2=1.0, nu12=0.25, G12=0.5, density=1.0)
LEFT, RIGHT = LineString([(0, 0), (0, 1)]), LineString([(1, 0), (1, 1)])
BOTTOM, TOP = LineString([(0, 0), (1, 0)]), LineString([(0, 1), (1, 1)])
SIMPLE, CLAMPED = plate.SimplySupported("boundary"), plate.Clamped("boundary")


def square(
    n: int, *supports: Any, pattern: str = "criss-cross", element: str = "dkt", **more: Any
) -> plate.Problem:
    return plate.Problem(
        plate.grid(1.0, 1.0, n, n, pattern), more.pop("laminate", ISOTROPIC), element, supports, **more
    )


def extrapolated(coarse: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """To no cell size, from halved cells: DKT's frequencies are of second order."""
    return np.asarray((4.0 * fine - coarse) / 3.0)


def case(shared: Path, name: str) -> dict[str, Any]:
    cases = json.loads((shared / "reference" / "plates.json").read_text(encoding="utf-8"))["cases"]
    return next(entry for entry in cases if entry["id"] == name)


# --- reference answers -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "support"), [("freq_cccc", CLAMPED), ("freq_ssss", SIMPLE)])
@pytest.mark.quick("freq_ssss*", others="campaign")
def test_square_vibrates_as_published(shared: Path, name: str, support: Any) -> None:
    entry = case(shared, name)
    count = len(entry["expected"])
    omega = [plate.modes(square(n, support), count).omega for n in (24, 48)]
    assert extrapolated(*omega) == pytest.approx(entry["expected"], rel=entry["rel_tol"])


@pytest.mark.parametrize("layup", ["[0/90/90/0]", "[0/90]", "[45/-45]"])
def test_laminates_vibrate_as_navier_says(shared: Path, layup: str) -> None:
    """ω a² / h √(ρ/E2) = 10/√w̄ with the deflection w̄ of the case under a wave of pressure, and its supports: a
    cross-ply may slide along the normal of its edges only, an angle-ply along the edges only."""
    entry = case(shared, f"nav_E25_{layup}")
    h, angles = 0.01, [float(text) for text in layup.strip("[]").split("/")]
    laminate = plate.Laminate([plate.Ply(REDDY, h / len(angles), angle) for angle in angles])
    held = ("u", "v") if layup == "[45/-45]" else ("v", "u")
    slides = [plate.Support(e, held[:1]) for e in (LEFT, RIGHT)] + [
        plate.Support(e, held[1:]) for e in (BOTTOM, TOP)
    ]
    omega = [
        plate.modes(square(n, SIMPLE, *slides, laminate=laminate), 1, in_plane_inertia=False).omega
        for n in (8, 16)
    ]
    expected = 10.0 / math.sqrt(entry["expected"][0]) * h
    # ω is as exact as the square root of the deflection that the case allows its tolerance for.
    assert extrapolated(*omega)[0] == pytest.approx(expected, rel=0.5 * entry["rel_tol"])


@pytest.mark.parametrize(
    ("supports", "held", "published"),
    [
        # A. W. Leissa, The free vibration of rectangular plates, J. Sound Vib. 31, 1973, squares with ν = 0.3: Ritz
        # with beam functions that are too stiff at free edges, so that the plate is below by up to 1 %.
        ("CFFF", [plate.Clamped(LEFT)], [3.4917, 8.5246, 21.429, 27.331, 31.111]),
        ("FFFF", [], [13.489, 19.789, 24.432, 35.024, 35.024]),
    ],
)
def test_plates_with_free_edges_vibrate_as_tabulated(
    supports: str, held: list[Any], published: list[float]
) -> None:
    rigid = 3 if supports == "FFFF" else 0
    omega = [plate.modes(square(n, *held), 5 + rigid).omega[rigid:] for n in (12, 24)]
    found = extrapolated(*omega)
    # Ritz with 12 × 12 polynomials: its fifth frequency still falls by 4e-5 from 12 to 14.
    exact = frequencies(1.0, 1.0, ISOTROPIC.D, supports)[rigid : rigid + 5]
    assert found == pytest.approx(exact, rel=3e-4)
    assert (found < published).all()
    assert found == pytest.approx(published, rel=0.01)


def test_anisotropic_plate_vibrates_as_ritz_says() -> None:
    """Three plies 45°/22.5°/45°, free: bending and twisting are coupled, and no corner is singular."""
    laminate = plate.Laminate([plate.Ply(CFRP, 50e-6, angle) for angle in (45, 22.5, 45)])
    a, b = 10e-3, 4e-3
    meshes = [plate.grid(a, b, 5 * n, 2 * n, "criss-cross") for n in (4, 8)]
    omega = [plate.modes(plate.Problem(mesh, laminate), 7).omega[3:] for mesh in meshes]
    exact = frequencies(a, b, laminate.D, "FFFF")[3:7] / math.sqrt(laminate.areal_mass)
    # Ritz is within 2e-5; what the extrapolation leaves of four waves on 40 cells is more.
    assert extrapolated(*omega) == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize(("element", "order"), [("dkt", 2), ("specht", 2), ("bfs", 4)])
@pytest.mark.quick("dkt-*", "specht-*", others="campaign")
def test_frequencies_converge_with_the_order_of_the_element(element: str, order: int) -> None:
    pattern = "squares" if element == "bfs" else "criss-cross"
    sizes = (3, 6) if element == "bfs" else (8, 16)
    off = [
        abs(
            plate.modes(square(n, SIMPLE, pattern=pattern, element=element), 1).omega[0] / (2 * math.pi**2)
            - 1
        )
        for n in sizes
    ]
    # Terms of the next order still bend the slope on so few cells.
    assert math.log2(off[0] / off[1]) == pytest.approx(order, abs=0.25)


# --- shapes and masses -----------------------------------------------------------------------------------------------


def test_first_mode_is_a_wave_with_a_quarter_of_the_mass() -> None:
    """sin πx sin πy: a modal mass of 1/4 and an effective one of 64/π⁴ of the plate's."""
    found = plate.modes(square(16, SIMPLE), 1)
    x, y = np.meshgrid(np.linspace(0.05, 0.95, 7), np.linspace(0.1, 0.9, 5))
    wave = np.sin(np.pi * x) * np.sin(np.pi * y)
    # Deflections of second order in 1/16: 0.3 % of the largest.
    np.testing.assert_allclose(found.deflection(0, x, y), wave, rtol=0.0, atol=3e-3)
    assert found.modal_mass[0] == pytest.approx(0.25, rel=3e-3)
    assert found.effective_mass[0] == pytest.approx([0.0, 0.0, 64 / math.pi**4], abs=3e-3)
    assert found.frequencies[0] == found.omega[0] / (2 * math.pi)
    assert np.abs(found.shapes).max() == pytest.approx(1.0, rel=1e-15)


def test_modes_of_a_shaken_plate_share_its_mass() -> None:
    """All modes together: everything but what the shape functions of the clamped edge carry with them."""
    problem = square(3, plate.Clamped(LEFT), laminate=plate.Laminate([plate.Ply(UNIT, 0.5)]))
    every = plate.modes(problem, problem.dofs.count - 3 * 4)  # three unknowns at the four nodes of the edge
    assert 0.75 * 0.5 < every.effective_mass[:, 2].sum() < 0.5
    free = plate.modes(square(3), 3)
    # Of a free plate rigid motions carry everything: round-off.
    assert free.effective_mass.sum(axis=0) == pytest.approx([0.0, 0.0, 1.0], rel=1e-9)
    assert free.modal_mass == pytest.approx([1.0, 1 / 3, 1 / 3], rel=1e-9)  # turns, with 1 m at the edge


def test_free_plate_has_its_rigid_motions_first() -> None:
    found = plate.modes(square(6), 5)
    assert (found.omega[:3] == 0.0).all()  # exactly: they are not computed
    assert len(found.rigid) == 3
    assert any("rise" in name for name in found.rigid)
    assert (found.omega[3:] > 1.0).all()
    coupled = plate.modes(square(4, element="dkt+cst"), 8)
    assert (coupled.omega[:6] == 0.0).all()
    assert coupled.omega[6] > 1.0
    # Without mass in the plane, motion there is no mode.
    light = plate.modes(square(4, element="dkt+cst"), 5, in_plane_inertia=False)
    assert light.rigid == found.rigid
    assert light.omega[3:] == pytest.approx(plate.modes(square(4), 5).omega[3:], rel=1e-8)  # round-off


def test_two_plates_that_do_not_touch_have_six_rigid_motions() -> None:
    one = plate.grid(1.0, 1.0, 4, 4)
    points = np.concatenate([one.points, one.points + np.array([2.0, 0.0])])
    both = Mesh(points, np.concatenate([one.cells, one.cells + len(one.points)]))
    found = plate.modes(plate.Problem(both, ISOTROPIC), 10)
    alone = plate.modes(plate.Problem(one, ISOTROPIC), 5)
    assert (found.omega[:6] == 0.0).all()
    # Every frequency of one plate twice: round-off of the two factorisations.
    assert found.omega[6:] == pytest.approx(np.repeat(alone.omega[3:], 2), rel=1e-8)


def test_link_on_a_soft_hinge_swings_like_a_pendulum() -> None:
    """k = D_hinge / width per metre; ω² = k / (m L³/3), for a link that is 1e6 times stiffer than its hinge."""
    width, length = 0.01, 1.0
    stiff = plate.Material.isotropic(12.0, 0.0, 1.0)
    soft = plate.Material.isotropic(12.0e-6, 0.0, 0.001)
    mesh = plate.grid_of_lines(
        np.concatenate([np.linspace(0, width, 3), np.linspace(width, width + length, 9)[1:]]),
        np.linspace(0, 1, 5),
        "one-diagonal",
        regions={"hinge": box(0, 0, width, 1)},
    )
    layers = {"hinge": plate.Laminate([plate.Ply(soft, 1.0)]), "": plate.Laminate([plate.Ply(stiff, 1.0)])}
    found = plate.modes(plate.Problem(mesh, layers, supports=[plate.Clamped(LEFT)]), 2)
    k = 1e-6 / width
    # Torque about the hinge's middle: the link turns about it, and its arm is longer by half the hinge.
    inertia = ((length + width / 2) ** 3 - (width / 2) ** 3) / 3.0
    # The hinge also bends under the link's transverse force: of order (width / length)².
    assert found.omega[0] == pytest.approx(math.sqrt(k / inertia), rel=1e-3)
    assert found.omega[1] > 50.0 * found.omega[0]


def test_link_on_an_elastic_hinge_swings_on_its_spring() -> None:
    """A rigid link hinged to the ground: ω² = k / (m L³ / 3) for a stiffness k per metre of the line."""
    rigid = plate.Laminate([plate.Ply(plate.Material.isotropic(12.0, 0.0, 1.0), 1.0)])
    for k in (0.0, 1e-6):
        found = plate.modes(square(4, plate.Hinged(LEFT, k), laminate=rigid), 2)
        # The link bends by about k over its own stiffness, 1e-6.
        assert found.omega[0] == pytest.approx(math.sqrt(3 * k), rel=1e-5)
        assert len(found.rigid) == (k == 0.0)


def test_membrane_vibrates_along_itself_like_a_bar() -> None:
    """Held at one end, Poisson's ratio zero: ω = π/2 √(E/ρ) / L."""
    bar = plate.Laminate([plate.Ply(plate.Material.isotropic(12.0, 0.0, 1.0), 1.0)])
    held = [plate.Support(LEFT, ("u", "v")), plate.Support(BOTTOM, ("v",)), plate.Support(TOP, ("v",))]
    found = plate.modes(square(6, *held, laminate=bar, pattern="squares", element="q9"), 1)
    # Quadratic shape functions: order four in a quarter wave on six cells.
    assert found.omega[0] == pytest.approx(math.pi / 2 * math.sqrt(12.0), rel=1e-4)
    assert found.displacement(0, 1.0, 0.5) == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)
    assert np.isnan(found.shapes).all()


def test_modes_in_which_nodes_only_turn_have_a_size_too() -> None:
    """One free node: the plate rises, or turns about x or about y, and then moves between the nodes only."""
    found = plate.modes(square(2, CLAMPED, pattern="one-diagonal"), 3)
    assert np.isfinite(found.vectors).all()
    assert np.abs(found.vectors).max() < 100.0  # slopes of some 1 m per cell
    assert (found.modal_mass > 0.0).all()
    assert (found.modal_mass < 10.0).all()  # kg; the plate has 1
    twisting = plate.modes(square(2, CLAMPED, pattern="squares", element="bfs"), 4)
    assert np.isfinite(twisting.vectors).all()
    assert (twisting.modal_mass < 100.0).all()


def test_frequencies_do_not_depend_on_the_unit_of_length() -> None:
    """All lengths, moduli and densities in mm, N, t and s."""
    metres = plate.modes(square(6, SIMPLE, laminate=plate.Laminate([plate.Ply(CFRP, 1e-3, 30)])), 3)
    material = plate.Material(E1=350e3, E2=7e3, nu12=0.33, G12=5e3, density=1600e-12)
    mesh = plate.grid(1000.0, 1000.0, 6, 6, "criss-cross")
    other = plate.modes(
        plate.Problem(mesh, plate.Laminate([plate.Ply(material, 1.0, 30)]), supports=[SIMPLE]), 3
    )
    assert other.omega == pytest.approx(metres.omega, rel=1e-9)  # round-off times the matrices' condition


def test_the_same_problem_gives_the_same_bits() -> None:
    first, second = (plate.modes(square(10, CLAMPED), 4) for _ in range(2))
    np.testing.assert_array_equal(first.omega, second.omega)
    np.testing.assert_array_equal(first.vectors, second.vectors)


# --- refusals --------------------------------------------------------------------------------------------------------

BAD_REQUESTS = {
    "no mass": (
        lambda: plate.modes(
            square(2, SIMPLE, laminate=plate.Laminate([plate.Ply(plate.Material(1, 1, 0, 1, 0), 1)]))
        ),
        "the plate has no mass, .* give its materials a density",
    ),
    "too many": (
        lambda: plate.modes(square(2, CLAMPED), 50),
        "50 modes are asked for, and the mesh has unknowns for",
    ),
    "no problem": (lambda: plate.modes(ISOTROPIC), "the problem is .*; it must be a Problem"),  # type: ignore[arg-type]
    "none": (lambda: plate.modes(square(2, SIMPLE), 0), "the count of modes is 0; it must be a whole number"),
    "no number": (lambda: plate.modes(square(2, SIMPLE), 2.5), "the count of modes is 2.5"),  # type: ignore[arg-type]
    "shape": (
        lambda: plate.modes(square(2, SIMPLE), 2).deflection(2, 0.5, 0.5),
        "shape 2 is asked for; there are 2",
    ),
    "outside": (
        lambda: plate.modes(square(2, SIMPLE), 1).deflection(0, 1.5, 0.5),
        r"\(1.5, 0.5\).* outside the plate",
    ),
}


@pytest.mark.parametrize("name", BAD_REQUESTS)
def test_impossible_request_is_refused(name: str) -> None:
    assert_refused(*BAD_REQUESTS[name])

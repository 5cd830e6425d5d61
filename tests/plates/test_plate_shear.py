"""Shear through the thickness: what bears it, and how much classical theory leaves out."""

import math
from pathlib import Path

import numpy as np
import pytest

from lamc import plate
from lamc.basics.errors import DesignError

ALUMINIUM = plate.Material.isotropic(70e9, 0.3, 2700)
CORE = plate.Material(60e6, 60e6, 0.0, 30e6, 50, G13=30e6, G23=30e6)
SANDWICH = plate.Laminate.sandwich(plate.Ply(ALUMINIUM, 1e-3), plate.Ply(CORE, 10e-3))
G = 70e9 / 2.6


def square(laminate: plate.Laminate, a: float, support: type, n: int, element: str = "dkt") -> plate.Problem:
    return plate.Problem(
        plate.grid(a, a, n, n),
        laminate,
        element,
        supports=[support("boundary")],
        loads=[plate.Pressure(1e3)],
    )


# --- the stiffness of a laminate -------------------------------------------------------------------------------------


def test_one_isotropic_ply_bears_five_sixths() -> None:
    for count, reference in ((1, "middle"), (7, "bottom"), (3, 0.02)):
        made = plate.Laminate([plate.Ply(ALUMINIUM, 0.02 / count)] * count, reference)
        assert np.allclose(made.H, 5 / 6 * G * 0.02 * np.eye(2), rtol=1e-12, atol=1e-6 * G)


def test_a_sandwich_shears_in_its_core() -> None:
    """Thin faces: G d²/c. Here they are a tenth of the core, and what they bear of the shear is of the order t/c ·
    t/d."""
    assert np.allclose(np.diag(SANDWICH.H), 30e6 * 11e-3**2 / 10e-3, rtol=0.01)
    thin = plate.Laminate.sandwich(plate.Ply(ALUMINIUM, 1e-5), plate.Ply(CORE, 10e-3))
    assert np.allclose(
        np.diag(thin.H), 30e6 * 10.01e-3**2 / 10e-3, rtol=0.02
    )  # the core bends a little, 1 % of D


def test_shear_of_an_unsymmetric_stack_is_that_of_its_own_stresses() -> None:
    """Two plies of E1 and E2 with ν = 0: τ = Q/D ∫ E (ζ - z0) dζ by hand, by a sum over 20 000 slices."""
    stiff, soft = (plate.Material(E, E, 0.0, E / 2, 1000.0) for E in (70e9, 10e9))
    made = plate.Laminate([plate.Ply(stiff, 2e-3), plate.Ply(soft, 5e-3)])
    z = (np.arange(20_000) + 0.5) * 7e-3 / 20_000
    E, dz = np.where(z < 2e-3, 70e9, 10e9), 7e-3 / 20_000
    arm = z - np.sum(E * z) / np.sum(E)
    tau = np.cumsum(E * arm) * dz / np.sum(E * arm**2 * dz)
    expected = 1.0 / np.sum(tau**2 / (E / 2) * dz)
    assert np.allclose(
        made.H, expected * np.eye(2), rtol=1e-3, atol=1e-3 * expected
    )  # slices: one half of one is 1e-4


def test_shear_stiffness_turns_with_the_laminate() -> None:
    ply = plate.Material(140e9, 10e9, 0.3, 5e9, 1600, G13=5e9, G23=3.5e9)
    one, rotated = (
        plate.Laminate([plate.Ply(ply, 1e-3, angle + by) for angle in (0, 90, 0)]).H for by in (0, 90)
    )
    assert np.allclose(rotated, one[::-1, ::-1], rtol=1e-12)
    slanted = plate.Laminate([plate.Ply(ply, 1e-3, 30.0)]).H
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    assert slanted[0, 0] == pytest.approx(
        5 / 6 * 1e-3 * (c * c * 5e9 + s * s * 3.5e9), rel=0.05
    )  # near: a_32 is not 0


def test_a_gap_bears_no_shear() -> None:
    hollow = plate.Laminate([plate.Ply(ALUMINIUM, 1e-3), plate.Ply(ALUMINIUM, 1e-3, gap=5e-3)])
    with pytest.raises(DesignError, match=r"gap of 0\.005 m between the plies 0 and 1"):
        _ = hollow.H
    found = plate.solve(square(hollow, 1.0, plate.Clamped, 4))
    assert any("has a gap" in note for note in found.report.notes)


# --- what classical theory leaves out --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("support", "solids"),
    [(plate.SimplySupported, 0.091), (plate.Clamped, 0.321)],
)
def test_the_note_tells_of_a_sandwich_what_solids_say(support: type, solids: float) -> None:
    """A sandwich of h/a = 1/133 that solid elements show 9.1 and 32.1 % softer in the middle. The share is of the
    load's mean deflection: 15 % above that of the middle where edges turn freely, 60 % where they are clamped."""
    found = plate.solve(square(SANDWICH, 1.591, support, 32))
    (note,) = [note for note in found.report.notes if "shear" in note]
    assert "would add about" in note
    assert solids < found.shear_share < 1.65 * solids


def test_the_note_on_a_thick_plate_is_not_less_than_what_is_missing() -> None:
    """h/a = 0.1: Mindlin's theory adds 5.2 % in the middle, simply supported, and 19 % clamped."""
    thick = plate.Laminate([plate.Ply(ALUMINIUM, 0.02)])
    for support, mindlin in ((plate.SimplySupported, 0.052), (plate.Clamped, 0.19)):
        share = plate.solve(square(thick, 0.2, support, 32)).shear_share
        assert mindlin < share < 1.6 * mindlin


def test_the_share_of_one_half_wave_is_exact() -> None:
    """A load of one half wave each way on a simply supported square: w_s / w_b = 2 π² D / (H a²)."""
    thick = plate.Laminate([plate.Ply(ALUMINIUM, 0.02)])
    a = 0.2
    wave = plate.Pressure(lambda x, y: 1e3 * np.sin(np.pi * x / a) * np.sin(np.pi * y / a))
    problem = plate.Problem(
        plate.grid(a, a, 40, 40), thick, supports=[plate.SimplySupported("boundary")], loads=[wave]
    )
    expected = 2 * math.pi**2 * thick.D[0, 0] / (thick.H[0, 0] * a**2)
    assert plate.solve(problem).shear_share == pytest.approx(
        expected, rel=0.02
    )  # patches: 0.5 (π / 40)² and edges


def test_supports_inside_count_and_the_outline_does_not() -> None:
    """A long strip on supports every 5 thicknesses bends between these; its outline is 100 thicknesses long and
    wide."""
    h = 0.01
    lines = [0.05 * k for k in range(21)]
    mesh = plate.grid(1.0, 1.0, 80, 4)
    import shapely

    held = [plate.Support(shapely.LineString([(x, 0.0), (x, 1.0)]), ("w",)) for x in lines]
    problem = plate.Problem(
        mesh,
        plate.Laminate([plate.Ply(ALUMINIUM, h)]),
        supports=held,
        loads=[plate.Pressure(lambda x, y: np.where((x // 0.05) % 2 == 0, 1e3, -1e3))],
    )
    assert any("shear" in note for note in plate.solve(problem).report.notes)


def test_thin_plates_go_without_a_word() -> None:
    for h in (1e-3, 4e-3):
        thin = plate.Laminate([plate.Ply(ALUMINIUM, h)])
        assert plate.solve(square(thin, 0.2, plate.SimplySupported, 16)).report.notes == ()


# --- which element ---------------------------------------------------------------------------------------------------


def test_the_element_with_shear_is_taken_where_shear_matters() -> None:
    thick, thin = (plate.Laminate([plate.Ply(ALUMINIUM, h)]) for h in (0.02, 1e-3))
    for laminate, a, name in ((thick, 0.2, "dkmt"), (thin, 0.2, "dkt"), (SANDWICH, 1.591, "dkmt")):
        choice = plate.choose_element(square(laminate, a, plate.SimplySupported, 8))
        assert choice.element == name
        assert f"element '{name}' was taken" in choice.why


def test_without_loads_a_pressure_decides_and_higher_modes_have_more_shear() -> None:
    made = plate.Laminate([plate.Ply(ALUMINIUM, 6e-3)])  # h/a = 0.03: 0.5 % in the first shape
    problem = plate.Problem(plate.grid(0.2, 0.2, 8, 8), made, supports=[plate.SimplySupported("boundary")])
    first, tenth = plate.choose_element(problem), plate.choose_element(problem, waves=10)
    assert (first.element, tenth.element) == ("dkt", "dkmt")
    assert "under a uniform pressure" in first.why
    free = plate.choose_element(plate.Problem(problem.mesh, made))
    assert free.element == "dkmt"
    assert math.isnan(free.share)


def test_quadrilaterals_are_refused_and_gaps_go_without_shear() -> None:
    made = plate.Laminate([plate.Ply(ALUMINIUM, 0.02)])
    squares = plate.Problem(plate.grid(0.2, 0.2, 4, 4, "squares"), made, "bfs")
    with pytest.raises(DesignError, match="mesh of quadrilaterals"):
        plate.choose_element(squares)
    hollow = plate.Laminate([plate.Ply(ALUMINIUM, 1e-3), plate.Ply(ALUMINIUM, 1e-3, gap=5e-3)])
    assert plate.choose_element(square(hollow, 1.0, plate.Clamped, 4)).element == "dkt"


FILE = """\
kind: plate
units: mm
materials: {al: {E: 70 GPa, nu: 0.3, density: 2700 kg/m^3}}
laminate: {material: al, thickness: %s}
geometry: {rect: [0, 0, 200, 200], grid: [8, 8]}
supports: [{clamped: boundary}]
loads: [{pressure: 1 kPa}]
element: auto
"""


@pytest.mark.quick("1-dkt", others="campaign")
@pytest.mark.parametrize(("thickness", "name"), [("20", "dkmt"), ("1", "dkt")])
def test_a_file_may_leave_the_element_open(tmp_path: Path, thickness: str, name: str) -> None:
    path = tmp_path / "plate.yaml"
    path.write_text(FILE % thickness)
    problem = plate.problem_of(plate.load_plate(path))
    assert problem.dofs.element.name == name
    found = plate.solve(problem)
    assert any(f"element '{name}' was taken" in note for note in found.report.notes)


# --- modes and buckling ----------------------------------------------------------------------------------------------


def test_modes_and_critical_loads_without_shear_say_how_much_too_high_they_are() -> None:
    """Simply supported square of h/a = 0.1: 1/ω² and 1/λ grow by k² D / H, k² = 2 π² / a² and 5 π² / a² and so on."""
    thick = plate.Laminate([plate.Ply(ALUMINIUM, 0.02)])
    problem = plate.Problem(plate.grid(0.2, 0.2, 24, 24), thick, supports=[plate.SimplySupported("boundary")])
    (note,) = [note for note in plate.modes(problem, 1).notes if "shear" in note]
    share = 2 * math.pi**2 * thick.D[0, 0] / (thick.H[0, 0] * 0.2**2)
    reported = float(note.split("by about ")[1].split(" %")[0])
    assert reported == pytest.approx(100 * (1 - (1 + share) ** -0.5), rel=0.1)  # two digits are reported
    (note,) = [note for note in plate.buckling(problem, 1, forces=(-1, 0, 0)).notes if "shear" in note]
    reported = float(note.split("by about ")[1].split(" %")[0])
    assert reported == pytest.approx(100 * (1 - 1 / (1 + share)), rel=0.1)
    free = plate.modes(plate.Problem(problem.mesh, thick), 6)  # 1 to 3 are rigid
    assert any("would lower mode 4" in note for note in free.notes)  # it twists: the layers at free edges


def test_modes_of_thin_plates_and_of_the_element_with_shear_go_without_a_word() -> None:
    for h, name in ((1e-3, "dkt"), (0.02, "dkmt")):
        made = plate.Laminate([plate.Ply(ALUMINIUM, h)])
        held = [plate.SimplySupported("boundary")]
        problem = plate.Problem(plate.grid(0.2, 0.2, 16, 16), made, name, supports=held)
        assert not any("shear" in note for note in plate.modes(problem, 2).notes)

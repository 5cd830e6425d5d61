"""Hinge stiffness from geometry and material: closed forms, invariances, and designs with it."""

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

import lamc
from lamc import plate
from lamc.basics.errors import BuildError, DesignError
from lamc.cli import main
from lamc.plate import Laminate, Material, Ply
from lamc.plates.designs import hinges as design_hinges
from lamc.plates.designs.hinges import with_material_stiffness
from lamc.plates.records import FilmStiffness
from lamc.readers.load import load_text
from lamc.records.design import Design

KAPTON = plate.material("Kapton HN")
T300 = plate.material("T300/5208")
# Some products and one inverse of a small, well-conditioned matrix.
ROUND_OFF = 1e-12

# --- closed forms ----------------------------------------------------------------------------------------------------


def test_isotropic_film_has_the_textbook_stiffness() -> None:
    """E t³ b / (12 L) as a beam, and 1/(1 - ν²) times that as a plate."""
    t, L, b = 25e-6, 0.5e-3, 10e-3
    found = plate.hinge_stiffness(Laminate([Ply(KAPTON, t)]), L, b, cells=0)
    beam = 2.5e9 * t**3 * b / (12 * L)
    assert found.beam_formula == pytest.approx(beam, rel=ROUND_OFF)
    assert found.plate_formula == pytest.approx(beam / (1 - 0.34**2), rel=ROUND_OFF)


def test_fibres_across_the_axis_are_what_bends() -> None:
    """At 0° the fibres run from link to link: E1; at 90° along the axis: E2."""
    t, L, b = 125e-6, 1e-3, 20e-3
    for angle, E in ((0.0, T300.E1), (90.0, T300.E2)):
        found = plate.hinge_stiffness(Laminate([Ply(T300, t, angle)]), L, b, cells=0)
        assert found.beam_formula == pytest.approx(E * t**3 * b / (12 * L), rel=ROUND_OFF)
        rest = 1 - T300.nu12**2 * T300.E2 / T300.E1
        assert found.plate_formula == pytest.approx(found.beam_formula / rest, rel=ROUND_OFF)


def test_bonded_films_bend_about_their_neutral_surface() -> None:
    """Two isotropic layers of equal ν: the composite beam about its neutral axis, whatever surface is the reference."""
    soft, hard = (Material.isotropic(E=E, nu=0.3, density=1) for E in (1e9, 5e9))
    t1, t2, L, b = 20e-6, 50e-6, 1e-3, 10e-3
    neutral = (1e9 * t1 * t1 / 2 + 5e9 * t2 * (t1 + t2 / 2)) / (1e9 * t1 + 5e9 * t2)
    EI = 1e9 * (t1**3 / 12 + t1 * (neutral - t1 / 2) ** 2) + 5e9 * (
        t2**3 / 12 + t2 * (neutral - t1 - t2 / 2) ** 2
    )
    for reference in ("middle", "bottom", 3e-4):
        found = plate.hinge_stiffness(Laminate([Ply(soft, t1), Ply(hard, t2)], reference), L, b, cells=0)
        # A reference surface ten thicknesses away costs two digits.
        assert found.beam_formula == pytest.approx(EI * b / L, rel=1e-9)
        assert found.plate_formula == pytest.approx(EI * b / L / (1 - 0.3**2), rel=1e-9)


# --- finite elements -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [0.5, 1.0, 7.0, 30.0])
def test_elements_are_exact_where_nothing_curls(ratio: float) -> None:
    """ν = 0: the strip bends to a cylinder, both formulas are one, and elements hold the quadratic deflection."""
    flat = Laminate([Ply(Material.isotropic(E=2e9, nu=0.0, density=1), 50e-6)])
    found = plate.hinge_stiffness(flat, 1e-3, ratio * 1e-3, cells=4)
    assert found.plate_formula == pytest.approx(found.beam_formula, rel=ROUND_OFF)
    # What is refined in strain form keeps the digits but for those of the sums.
    assert found.finite_element == pytest.approx(found.plate_formula, rel=1e-10)


STRIPS = {
    "film": Laminate([Ply(KAPTON, 25e-6)]),
    "fibres askew": Laminate([Ply(T300, 125e-6, 30)]),
    "two bonded": Laminate([Ply(KAPTON, 25e-6), Ply(T300, 25e-6, 30)]),
}


@pytest.mark.parametrize("name", STRIPS)
@pytest.mark.quick("film", "fibres askew")
def test_elements_lie_between_beam_and_plate(name: str) -> None:
    """Nearer to the beam for short strips, nearer to the plate for long ones."""
    parts = []
    for ratio in (0.3, 1.0, 5.0, 40.0):
        found = plate.hinge_stiffness(STRIPS[name], 1e-3, ratio * 1e-3, cells=8)
        assert found.finite_element is not None
        parts.append((found.finite_element - found.beam_formula) / (found.plate_formula - found.beam_formula))
    assert parts == sorted(parts)
    assert parts[0] > 0
    assert 0.98 < parts[-1] < 1  # one width of strip at each end is free to curl, in part


def test_short_film_is_a_beam_to_elements() -> None:
    """b = L/20: what is clamped at its ends, of length b, keeps a few per cent of the difference."""
    found = plate.hinge_stiffness(STRIPS["film"], 1e-3, 0.05e-3, cells=100)
    assert found.finite_element is not None
    part = (found.finite_element - found.beam_formula) / (found.plate_formula - found.beam_formula)
    assert 0 < part < 0.06


def test_long_film_lacks_a_third_of_a_width_of_strip_to_be_a_plate() -> None:
    """The share that the two free ends lose is a length over b: doubled b, half of it."""
    lost = []
    for ratio in (5.0, 10.0, 20.0):
        found = plate.hinge_stiffness(STRIPS["film"], 1e-3, ratio * 1e-3)
        assert found.finite_element is not None
        gap = found.plate_formula - found.finite_element
        lost.append(gap / (found.plate_formula - found.beam_formula) * ratio)
    assert lost == pytest.approx([lost[0]] * 3, rel=1e-3)  # ends three widths long decay to that
    assert 0.3 < lost[0] < 0.4


def test_elements_do_not_depend_on_the_reference_surface() -> None:
    plies = STRIPS["two bonded"].plies
    one, other = (plate.hinge_stiffness(Laminate(plies, r), 1e-3, 2e-3, cells=6) for r in ("middle", 1e-4))
    assert one.finite_element == pytest.approx(other.finite_element, rel=1e-9)


def test_finer_elements_come_closer() -> None:
    """The corners where clamped meets free are singular, so the order is between 1 and 2."""
    found = [
        plate.hinge_stiffness(STRIPS["film"], 1e-3, 1e-3, cells=n).finite_element or 0.0
        for n in (4, 8, 16, 32)
    ]
    steps = -np.diff(found)
    assert (steps > 0).all()  # displacement elements that are too stiff
    assert (steps[:-1] / steps[1:] > 1.8).all()


def test_formulas_alone_need_no_elements() -> None:
    assert plate.hinge_stiffness(STRIPS["film"], 1e-3, 1e-3, cells=0).finite_element is None
    with pytest.raises(
        DesignError, match=r"the cells across a hinge are 2\.5; give a whole number from 0 to 200"
    ):
        plate.hinge_stiffness(STRIPS["film"], 1e-3, 1e-3, cells=2.5)  # type: ignore[arg-type]


def test_wide_strips_are_plates_and_narrow_ones_beams() -> None:
    laminate = Laminate([Ply(KAPTON, 25e-6)])
    wide, narrow = (plate.hinge_stiffness(laminate, 1e-3, b, cells=0) for b in (1e-3, 0.9e-3))
    assert (wide.value, wide.formula) == (wide.plate_formula, "plate")
    assert (narrow.value, narrow.formula) == (narrow.beam_formula, "beam")


angles = st.lists(st.floats(-90, 90), min_size=1, max_size=5)


@given(angles, st.floats(-1e-3, 1e-3))
def test_what_is_kept_from_curling_is_stiffer(plies: list[float], reference: float) -> None:
    """The plate has all of the beam's constraints and more; neither depends on the reference surface."""
    stack = [Ply(T300, 1e-4, a) for a in plies]
    found = plate.hinge_stiffness(Laminate(stack, reference), 1e-3, 1e-2, cells=0)
    middle = plate.hinge_stiffness(Laminate(stack), 1e-3, 1e-2, cells=0)
    assert found.plate_formula >= found.beam_formula * (1 - 1e-9) > 0
    # Ten thicknesses off, D is a hundred times what is left of it, and ply stiffnesses differ by 20.
    assert found.plate_formula == pytest.approx(middle.plate_formula, rel=1e-8)
    assert found.beam_formula == pytest.approx(middle.beam_formula, rel=1e-8)


@pytest.mark.parametrize(
    ("width", "length", "message"),
    [
        (0.0, 1e-3, "the width of a hinge is 0 m; it must be positive"),
        (1e-3, -1e-3, "the length of a hinge is -0.001 m"),
        (math.nan, 1e-3, "the width of a hinge is nan"),
    ],
)
def test_hinge_without_size_is_refused(width: float, length: float, message: str) -> None:
    with pytest.raises(DesignError, match=message):
        plate.hinge_stiffness(Laminate([Ply(KAPTON, 25e-6)]), width, length)


# --- designs ---------------------------------------------------------------------------------------------------------

# A crease at 30° from x through a film between boards, 20 mm of it within the film, and fibres at 120°: across it.
CREASE = """
kind: design
units: mm
materials:
  board: {density: 700 kg/m^3, E1: 4 GPa, poisson: 0.2, rigid: true}
  film: {density: 1400 kg/m^3, E1: 8 GPa, E2: 2 GPa, G12: 1 GPa, poisson: 0.3, flexible: true}
layers:
  - {name: film, material: film, thickness: 0.1, angle: 120 deg}
  - {name: board, material: board, thickness: 0.5}
shapes:
  - {polygon: [[17.3205081, 10], [-17.3205081, -10], [-22.3205081, -1.3397460], [12.3205081, 18.6602540]]}
  - {polygon: [[17.3205081, 10], [-17.3205081, -10], [-12.3205081, -18.6602540], [22.3205081, 1.3397460]]}
  - cut:
      polygon:
        [[-17.8205081, -9.1339746], [-16.8205081, -10.8660254], [17.8205081, 9.1339746], [16.8205081, 10.8660254]]
    layers: board
hinges:
  - {name: crease, line: [[-20, -11.5470054], [20, 11.5470054]], gap: 2, layer: film, stiffness: 5 N*mm/rad,
     damping: 1e-6 N*m*s/rad, rest_angle: 10 deg, limits: [-90 deg, 90 deg]}
fixed:
  - {rect: [-30, 0, 0, 30]}
"""


def crease(text: str = CREASE) -> Design:
    design = load_text(text, "crease.yaml")
    assert isinstance(design, Design)
    return design


def test_stiffness_of_a_joint_follows_from_its_film() -> None:
    """k = E1 t³ b / (12 (1 - ν12 ν21) L) with E1 = 8 GPa across the crease, t = 0.1 mm, b = 40 mm within the film and
    L = 2 mm; all else of the joint stays."""
    design, (account,) = with_material_stiffness(crease())
    (joint,) = lamc.split(design).joints
    (drawn,) = lamc.split(crease()).joints
    expected = 8e9 * 1e-4**3 * 40e-3 / (12 * (1 - 0.3**2 * 2 / 8) * 2e-3)
    # The drawing's corners are given to 1e-7 mm.
    assert joint.stiffness == pytest.approx(expected, rel=1e-7)
    assert drawn.stiffness == 5e-3
    for name in ("name", "parent", "child", "damping", "rest_angle", "limits"):
        assert getattr(joint, name) == getattr(drawn, name)
    assert (account.joint, account.layer, account.material.name) == ("crease", "film", "film")
    assert account.angle == pytest.approx(0.0, abs=1e-6)
    assert account.stiffness.length == pytest.approx(40e-3, rel=1e-8)
    assert account.note == ""


def test_fibres_along_the_crease_make_it_softer() -> None:
    along, (account,) = with_material_stiffness(crease(CREASE.replace("angle: 120 deg", "angle: 30 deg")))
    (joint,) = lamc.split(along).joints
    assert joint.stiffness == pytest.approx(
        2e9 * 1e-4**3 * 40e-3 / (12 * (1 - 0.3**2 * 2 / 8) * 2e-3), rel=1e-6
    )
    assert abs(account.angle or 0.0) == pytest.approx(90.0, abs=1e-6)


def test_holes_where_lines_meet_take_their_part() -> None:
    """In `vertex` the four creases end in a hole of one hinge width about the centre, so less of each bends."""
    design = lamc.load(Path(lamc.__file__).parent / "examples" / "vertex.yaml")
    assert isinstance(design, Design)
    _, account = with_material_stiffness(design)
    for hinge in account:
        # The hole's arcs are polygons that fall short of the circle by half a per cent.
        assert hinge.stiffness.length < 40e-3 - 0.995 * 2e-3
        assert "taken as cut open" in hinge.note  # its boards are drawn over the creases


def test_what_the_drawing_does_not_say_is_noted() -> None:
    design = crease(CREASE.replace("gap: 2,", "gap: 1.6,"))
    _, (account,) = with_material_stiffness(design)
    assert account.note == "the stiff layers are drawn 2 mm apart, and the gap says 1.6 mm"
    thick = crease(CREASE.replace("thickness: 0.1", "thickness: 1"))
    assert "too short for a plate" in with_material_stiffness(thick)[1][0].note


def test_unknown_moduli_are_refused_and_can_be_replaced() -> None:
    design = lamc.load(Path(lamc.__file__).parent / "examples" / "pendulum.cad")
    assert isinstance(design, Design)
    with pytest.raises(
        DesignError, match="'flexible' has no E1, poisson: give them in the design's materials"
    ):
        with_material_stiffness(design)
    with pytest.raises(DesignError, match="has no material 'film' to be replaced; known are"):
        with_material_stiffness(design, {"film": KAPTON})
    replaced, account = with_material_stiffness(design, {"flexible": KAPTON})
    assert [hinge.material for hinge in account] == [KAPTON] * 3
    assert {j.stiffness for j in lamc.split(replaced).joints} == {account[0].stiffness.value}


def test_crease_beside_its_film_is_refused() -> None:
    text = CREASE.replace("layers: board\nhinges", "layers: film\nhinges")
    with pytest.raises(
        DesignError, match="hinge 'crease' has nothing of its flexible layer 'film' along its line"
    ):
        with_material_stiffness(crease(text))


# --- command line ----------------------------------------------------------------------------------------------------


def split_as_json(*words: str) -> dict[str, object]:
    done = CliRunner().invoke(main, ["split", *words, "--json"])
    assert done.exit_code == 0, done.output
    data = json.loads(done.stdout)
    assert isinstance(data, dict)
    return data


@pytest.mark.slow
def test_command_line_tells_where_each_stiffness_comes_from(tmp_path: Path) -> None:
    file = tmp_path / "crease.yaml"
    file.write_text(CREASE, encoding="utf-8")
    drawn = split_as_json(str(file), "--out", str(tmp_path / "a"))
    made = split_as_json(str(file), "--out", str(tmp_path / "b"), "--hinge-stiffness", "from-material")
    assert "hinge_stiffness" not in drawn
    assert np.isclose(drawn["joints"][0]["stiffness"], 5e-3)  # type: ignore[index]
    (hinge,) = made["hinge_stiffness"]  # type: ignore[misc]
    assert hinge["taken"] == "plate"
    assert hinge["beam_formula"] < hinge["finite_element"] < hinge["plate_formula"]
    assert made["joints"][0]["stiffness"] == hinge["plate_formula"]  # type: ignore[index]
    reported = CliRunner().invoke(
        main, ["split", str(file), "--out", str(tmp_path / "c"), "--hinge-stiffness", "from-material"]
    )
    assert "hinge stiffness from material, of a strip of the flexible layer" in reported.output
    written = lamc.load(tmp_path / "b" / "crease.mechanism.yaml")
    assert isinstance(written, lamc.Mechanism)
    assert written.joints[0].stiffness == hinge["plate_formula"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--example", "flaps", "--material", "film=Mylar"), "add --hinge-stiffness from-material"),
        (("--example", "flaps", "--hinge-stiffness", "from-material", "--material", "film"), "NAME=VALUE"),
        (
            ("--example", "flaps", "--hinge-stiffness", "from-material", "--material", "film=x"),
            "no material 'x'",
        ),
        (
            ("--example", "stiff_triple", "--hinge-stiffness", "from-material"),
            "holds a mechanism, which has no layers",
        ),
        (
            ("--example", "pendulum.cad", "--hinge-stiffness", "from-material"),
            '--material "flexible=Kapton HN"',
        ),
    ],
)
def test_command_line_refuses_in_one_line(tmp_path: Path, words: tuple[str, ...], message: str) -> None:
    done = CliRunner().invoke(main, ["split", *words, "--quiet", "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert message in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_without_a_compiler_formulas_stand_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_compiler(laminate: Laminate, width: float, length: float, *, cells: int) -> FilmStiffness:
        if cells:
            raise BuildError("no C compiler was found")
        return plate.hinge_stiffness(laminate, width, length, cells=0)

    monkeypatch.setattr(design_hinges, "hinge_stiffness", no_compiler)
    reported = split_as_json(
        "--example", "flaps", "--hinge-stiffness", "from-material", "--out", str(tmp_path / "out")
    )
    assert [h["finite_element"] for h in reported["hinge_stiffness"]] == [None, None]  # type: ignore[index]
    assert "no finite elements stand beside the formulas" in str(reported["notes"])


@pytest.mark.slow
def test_split_as_drawn_does_not_wait_for_plates_to_be_imported() -> None:
    words = "import lamc.commands.split, sys; print([m for m in sys.modules if m.startswith('lamc.plate')])"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"

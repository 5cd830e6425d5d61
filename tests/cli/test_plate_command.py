"""`lamc plate` as a user meets it: answers against print, files, exit codes, errors of one line."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from lamc import examples
from lamc.basics.errors import DesignError
from lamc.cli import main
from lamc.commands import plate_files, plate_work
from lamc.examples import plates
from lamc.readers.plates.problem_file import load_plate
from tests.support.ctools import needs_cc

pytestmark = [needs_cc, pytest.mark.usefixtures("unpainted")]

SQUARE = """\
kind: plate
name: {name}
laminate: {{material: steel, thickness: 1 mm}}
geometry: {{rect: [0, 0, 0.2, 0.2], grid: [{n}, {n}], pattern: {pattern}}}
supports: [{{{support}: boundary}}]
{loads}
"""


@pytest.fixture(autouse=True)
def _own_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every test works in a folder of its own."""
    monkeypatch.chdir(tmp_path)


def call(*words: str) -> Result:
    return CliRunner().invoke(main, ["plate", *words])


def answer(*words: str) -> Any:
    """What --json gives, without pictures."""
    result = call(*words, "--json", "--no-pictures")
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def square(
    path: Path,
    *,
    name: str = "square",
    n: int = 8,
    pattern: str = "one-diagonal",
    support: str = "simply_supported",
    loads: str = "loads: [{point: [0.1, 0.1], force: 10 N}]",
) -> str:
    text = SQUARE.format(name=json.dumps(name), n=n, pattern=pattern, support=support, loads=loads)
    path.write_text(text, encoding="utf-8")
    return str(path)


def value(data: Any, name: str, case: str = "") -> float:
    (found,) = [p["is"] for p in data["cases"][case]["outputs"] if p["name"] == name]
    return float(found)


def middle(data: Any) -> float:
    return float(data["cases"][""]["extremes"]["w"]["largest"])


STEEL = 210e9 * 1e-9 / (12 * (1 - 0.3**2))  # N·m, D of the squares
NAVIER = 0.0116008397722 * 10 * 0.2**2 / STEEL  # m, Timoshenko's series to 12 digits


def case_of(shared: Path, name: str) -> Any:
    cases = json.loads((shared / "reference" / "plates.json").read_text(encoding="utf-8"))["cases"]
    (found,) = [case for case in cases if case["id"] == name]
    return found


# --- the paper's two plates ---------------------------------------------------------------------------------------


def test_the_square_tends_to_the_series_with_the_square_of_the_cells() -> None:
    coarse, fine = (answer("--example", "square", "--size", size) for size in ("10 mm", "5 mm"))
    errors = [value(data, "middle") / NAVIER - 1.0 for data in (coarse, fine)]
    assert 0.0 < errors[1] < 2e-3
    # Of second order with a logarithm, as curvatures are infinite under the force: 4 ln 20 / ln 40 = 3.2.
    assert 3.1 < errors[0] / errors[1] < 4.0
    reported = coarse["cases"][""]["outputs"][0]
    assert reported["expected"] == pytest.approx(NAVIER, rel=1e-12)


@pytest.mark.slow
def test_the_table_tells_the_error_against_the_series() -> None:
    result = call("--example", "square", "--no-pictures")
    assert result.exit_code == 0, result.output
    (line,) = [line for line in result.stdout.splitlines() if line.startswith("middle")]
    assert "241.2975 µm" in line
    assert line.endswith("%")


@pytest.mark.slow
def test_the_strip_twists_under_a_symmetric_load(shared: Path) -> None:
    expected = case_of(shared, "strip_45_22_45")["expected"]
    data = answer("--example", "strip")
    names = ("middle of the tip", "lower corner", "upper corner", "twist at the tip")
    # The case's own tolerance: the mesh is fine where moments are singular.
    assert [value(data, name) for name in names] == pytest.approx(expected, rel=5e-4)
    text = plates.find("strip").text.replace("[45/22.5/45]", "[-45/-22.5/-45]")
    Path("mirror.yaml").write_text(text, encoding="utf-8")
    mirrored = answer("mirror.yaml")
    # The two corners of the clamp are not meshed alike: each answer is within the tolerance above.
    assert value(mirrored, "lower corner") == pytest.approx(value(data, "upper corner"), rel=1e-3)
    assert value(mirrored, "twist at the tip") == pytest.approx(-value(data, "twist at the tip"), rel=1e-3)


def test_bciz_is_right_on_one_diagonal_and_warned_of_on_others(tmp_path: Path) -> None:
    right = answer(square(tmp_path / "a.yaml", n=32), "--element", "bciz")
    wrong = answer(square(tmp_path / "b.yaml", n=32, pattern="union-jack"), "--element", "bciz")
    assert middle(right) == pytest.approx(NAVIER, rel=4e-3)  # what is left at 32 cells
    assert middle(wrong) / NAVIER - 1.0 == pytest.approx(
        0.0323, abs=0.006
    )  # measured limit, and what is left
    assert not right["cases"][""]["notes"]
    (note,) = wrong["cases"][""]["notes"]
    assert "3.2 %" in note


# --- other examples -----------------------------------------------------------------------------------------------


def test_a_cooled_cross_ply_curls_as_laminate_theory_says(shared: Path) -> None:
    expected = case_of(shared, "thermal_0_90")["expected"]
    data = answer("--example", "thermal")
    assert data["element"] == "dkt+cst"  # bending and stretching are coupled
    # Constant strain is exact on any mesh; 1e-9 is the digits of the reference.
    assert value(data, "curvature along x") == pytest.approx(expected[2], rel=1e-9)
    assert value(data, "curvature along y") == pytest.approx(expected[3], rel=1e-9)
    assert (
        data["cases"][""]["extremes"]["M_x"]["largest"] == 0.0
    )  # free of moments, round-off taken for what it is


def test_the_work_of_the_moment_is_the_energy_of_the_hinge() -> None:
    data = answer("--example", "hinge")
    slope = value(data, "slope at the tip")
    # Clapeyron: half of moment per width times width times slope, which varies a little over the width.
    assert data["cases"][""]["strain_energy"] == pytest.approx(0.5 * 0.2e-3 * 12e-3 * slope, rel=2e-3)
    film = 2.5e9 * 25e-6**3 / 12
    lower, upper = (
        film / 0.1e-3,
        film / (1 - 0.34**2) / 0.1e-3,
    )  # N per radian: free to curl, and held straight
    assert lower < 0.2e-3 / slope < upper


@pytest.mark.slow
def test_supports_of_the_perforated_plate_carry_the_pressure_on_its_area() -> None:
    data = answer("--example", "holes")
    path = plates.find("holes").path
    assert path is not None
    area = load_plate(path).geometry.outline.area
    carried = [sum(r["force"][2] for r in data["cases"][c]["reactions"]) for c in ("pressure", "push")]
    assert carried == pytest.approx([-1e4 * area, 20.0], rel=1e-9)  # equilibrium, to round-off


def test_the_first_mode_of_the_cantilever_is_that_of_print() -> None:
    data = answer("--example", "modes")
    factor = 2 * math.pi * data["modes"]["frequencies"][0] * 0.1**2 * math.sqrt(7850 * 1e-3 / STEEL)
    assert factor == pytest.approx(
        3.4711, rel=2e-3
    )  # Leissa's Ritz bound 3.4917 is above; 3.4710 by finer series


def test_a_bimorph_bends_towards_the_plate_that_shortens() -> None:
    data = answer("--example", "bimorph")
    assert value(data, "tip") > 0.0  # the upper one shortens: d31 is negative, its field positive
    forces = [r["force"] for r in data["cases"][""]["reactions"]]
    assert np.abs(forces).max() < 1e-12  # N: nothing pushes; moments at the clamp are 0.1 N


@pytest.mark.parametrize("name", ["four_bar", "pendulum.cad", "miura:4x5"])
def test_a_design_asked_for_as_an_example_of_a_plate_says_what_it_is(name: str) -> None:
    with pytest.raises(
        DesignError, match=f"'{name}' is an example of a design.*lamc examples {name} .*--body"
    ):
        plates.find(name)


@pytest.mark.parametrize("name", plates.names())
def test_each_example_has_a_story_and_one_line(name: str) -> None:
    example = plates.find(name)
    assert example.summary.endswith(".")
    assert example.path is not None
    assert len(load_plate(example.path).story) > 200


# --- a body of a design -------------------------------------------------------------------------------------------


def test_a_body_of_a_design_is_a_plate_without_a_file_of_its_own() -> None:
    call("--example", "folded_link", "--copy", "mine")
    by_file = answer("mine/folded_link.yaml")
    words = ("mine/flaps.yaml", "--body", "link_1", "--hinges", "strips", "--size", "1.5 mm")
    by_words = answer(*words, "--clamp", "hinge: left", "--load", "left=-1 mN")
    assert by_words["cases"][""]["extremes"]["w"]["least"] == by_file["cases"][""]["extremes"]["w"]["least"]
    assert by_words["mesh"]["regions"] == ["all layers", "hinge left"]


def test_a_popupcad_body_is_a_plate_once_its_materials_are_known() -> None:
    """Moduli in popupCAD files are placeholders; the pendulum's links are squares of 1 m, five layers of 0.2 m."""
    drawn = str(examples.path("pendulum.cad"))
    refused = call(drawn, "--body", "link_1", "--clamp", "left")
    assert refused.exit_code == 2
    assert "--material" in refused.stderr
    known = [f"--material={name}={{E: 1 MPa, nu: 0.3}}" for name in ("rigid", "adhesive", "flexible")]
    data = answer(
        drawn, "--body", "link_1", "--clamp", "left", "--load", "right=1 N", "--size", "0.2", *known
    )
    (laminate, *_) = data["laminates"].values()
    assert laminate["thickness"] == pytest.approx(1.0, rel=1e-12)
    assert laminate["D"][0][0] == pytest.approx(1e6 / (12 * (1 - 0.3**2)), rel=1e-9)


def test_places_and_loads_of_options_are_those_of_plate_files() -> None:
    call("--example", "folded_link", "--copy", "mine")
    words = ("mine/flaps.yaml", "--body", "link_1", "--size", "2 mm", "--clamp", "right")
    point = answer(*words, "--load", "-40,6=2 mN", "--load", "pressure: 10 Pa")
    total = sum(r["force"][2] for r in point["cases"][""]["reactions"])
    area = 30e-3 * 12e-3  # less half a slit along the hinge, a thousandth
    assert total == pytest.approx(-2e-3 - 10 * area, rel=1e-3)


def test_a_plate_under_its_critical_load_is_told_what_it_bears(tmp_path: Path) -> None:
    file = tmp_path / "b.yaml"
    file.write_text(
        "kind: plate\nlaminate: {material: steel, thickness: 1 mm}\n"
        "geometry: {rect: [0, 0, 0.2, 0.2], grid: [16, 16]}\n"
        "supports:\n  - simply_supported: boundary\n  - {fixed: [u], where: left}\n"
        "  - {fixed: [v], where: {point: [0, 0]}}\n"
        "loads: [{edge: right, force: [-1 N/m, 0, 0]}]\n",
        encoding="utf-8",
    )
    (factor, *_) = answer(str(file), "--buckling", "1")["buckling"][""]
    exact = 4 * math.pi**2 * STEEL / 0.2**2  # N/m, Bryan 1891
    assert factor == pytest.approx(exact, rel=1e-2)  # second order, at 16 cells


@pytest.mark.slow
def test_strength_is_told_where_it_is_known_and_large_deflections_are_warned_of() -> None:
    cooled = answer("--example", "thermal")["cases"][""]
    # Every point alike: transverse tension beyond cure, Yt over the stress within a few per cent of Tsai-Wu's ratio.
    assert cooled["first_failure"]["mode"] == "tension along 2"
    assert 1.0 < cooled["first_failure"]["ratio"] < 2.0
    assert any("8.17 thicknesses" in note for note in cooled["notes"])
    steel = answer("--example", "square")["cases"][""]
    assert steel["first_failure"] is None
    assert steel["notes"] == []
    (line,) = [
        line for line in call("--example", "thermal", "--no-pictures").stdout.splitlines() if "fails" in line
    ]
    found = cooled["first_failure"]
    for word in (f"{found['ratio']:.4g} times", f"ply {found['ply']} ", f"{found['face']} face", "along 2"):
        assert word in line


# --- files --------------------------------------------------------------------------------------------------------


def test_a_run_writes_pictures_fields_and_a_summary(tmp_path: Path) -> None:
    result = call(square(tmp_path / "s.yaml"), "--modes", "2", "--out", "o", "--quiet")
    assert result.exit_code == 0, result.output
    assert result.output == ""
    reported = json.loads(Path("o/summary.json").read_text(encoding="utf-8"))
    assert sorted(reported["files"]) == sorted(p.name for p in Path("o").iterdir())
    pictures = {"mesh.png", "stack.png", "deflection.png", "moments.png", "stress.png", "modes.png"}
    assert pictures | {"fields.csv", "fields.vtu", "summary.json"} == set(reported["files"])
    table = np.genfromtxt("o/fields.csv", delimiter=",", names=True)
    assert table["w_m"].max() == pytest.approx(middle(reported), rel=1e-15)


def test_pictures_of_an_earlier_run_do_not_pass_for_this_ones(tmp_path: Path) -> None:
    file = square(tmp_path / "s.yaml")
    assert call(file, "--out", "o").exit_code == 0
    Path("o/notes.png").write_text("mine", encoding="utf-8")
    assert call(file, "--out", "o", "--no-pictures").exit_code == 0
    assert {p.name for p in Path("o").iterdir()} == {"fields.csv", "fields.vtu", "summary.json", "notes.png"}


def test_cases_have_files_of_their_own_whatever_their_names(tmp_path: Path) -> None:
    loads = 'cases: {"../up": [{pressure: 1}], "a/b": [{pressure: -1}], wind: [{pressure: 2}]}'
    result = call(square(tmp_path / "s.yaml", n=4, loads=loads), "--out", "o")
    assert result.exit_code == 0, result.output
    names = {p.name for p in Path("o").iterdir()}
    assert {"deflection_up.png", "deflection_a_b.png", "deflection_wind.png"} <= names
    assert not Path("up.png").exists()
    one = answer(str(tmp_path / "s.yaml"), "--case", "wind")
    assert list(one["cases"]) == ["wind"]


def test_json_is_all_on_stdout_and_equals_the_summary(tmp_path: Path) -> None:
    data = answer(square(tmp_path / "s.yaml"), "--out", "o")
    reported = json.loads(Path("o/summary.json").read_text(encoding="utf-8"))
    assert data == reported | {"folder": "o"}


# --- words --------------------------------------------------------------------------------------------------------


def test_the_summary_tells_what_a_reader_must_know(tmp_path: Path) -> None:
    result = call(square(tmp_path / "s.yaml", loads="loads: [{pressure: 2 kPa}]"), "--no-pictures")
    assert result.exit_code == 0, result.output
    for word in (
        "128 triangles (one-diagonal)",
        "45° to 90°",
        "dkt",
        "pressure 2 kPa",
        "80 N along -z",
        "condition",
    ):
        assert word in result.stdout
    assert "superlu" in result.stdout or "cholmod" in result.stdout


def test_an_element_tells_what_it_is() -> None:
    result = call("--element", "dkt")
    assert result.exit_code == 0, result.output
    assert "stiffness" in result.stdout
    assert "Operations" in result.stdout
    assert call("--element", "dkkt").exit_code == 2


def test_examples_are_listed_and_copied_once() -> None:
    listed = call("--examples")
    assert listed.exit_code == 0
    assert all(
        line.split()[0] in plates.names() for line in listed.stdout.splitlines()[: len(plates.names())]
    )
    assert call("--example", "strip", "--copy", "mine").exit_code == 0
    assert Path("mine/strip.yaml").read_text(encoding="utf-8") == plates.find("strip").text
    again = call("--example", "strip", "--copy", "mine")
    assert again.exit_code == 2
    assert "is not replaced" in again.stderr


@pytest.mark.parametrize(
    ("words", "reported"),
    [
        ((), "name a FILE"),
        (("s.yaml", "--example", "square"), "not both"),
        (("square.yaml",), "--example square"),
        (("--example", "sqare"), "did you mean 'square'?"),
        (("none.yaml",), "there is no such file"),
        (("s.yaml", "--clamp", "left"), "is a plate file"),
        (("--example", "square", "--body", "a"), "belong to a design"),
        (("flaps.yaml",), "--body NAME"),
        (("flaps.yaml", "--body", "link_9"), "flaps.yaml: geometry: design 'flaps' has no body 'link_9'"),
        (("flaps.yaml", "--body", "link_1", "--load", "x"), "write PLACE=FORCE"),
        (("flaps.yaml", "--body", "link_1", "--load", "left=1 mM"), "is not a unit"),
        (("s.yaml", "--element", "dkkt"), "did you mean 'dkt'?"),
        (("s.yaml", "--element", "q4"), "triangle"),
        (("s.yaml", "--size", "0"), "above 0"),
        (("s.yaml", "--size", "2 kg"), "not a unit of length"),
        (("s.yaml", "--modes", "-1"), "must be 0 to 1000"),
        (("s.yaml", "--case", "wind"), "no such case"),
        (("free.yaml",), "the plate is not held"),
        (("--copy", "x"), "needs the name of an example"),
    ],
)
def test_what_cannot_be_is_one_line_and_exit_code_2(
    tmp_path: Path, words: tuple[str, ...], reported: str
) -> None:
    square(tmp_path / "s.yaml", n=2)
    text = SQUARE.format(
        name="free", n=2, pattern="one-diagonal", support="symmetry", loads="loads: [{pressure: 1}]"
    )
    (tmp_path / "free.yaml").write_text(
        text.replace("symmetry: boundary", "fixed: [u], where: left"), encoding="utf-8"
    )
    call("--example", "folded_link", "--copy", ".")
    result = call(*words, "--quiet")
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert line.startswith("error: ")
    assert reported in line
    assert not Path("out").exists()


def test_every_problem_of_a_file_is_a_line_with_its_place(tmp_path: Path) -> None:
    file = square(
        tmp_path / "s.yaml", loads="loads: [{point: [9, 9], force: 1 N}]\nmodes: -2\ncases: {a: [{}]}"
    )
    result = call(file, "--json")
    assert result.exit_code == 2
    found = json.loads(result.stdout)["errors"]
    assert [error["line"] for error in found] == sorted(error["line"] for error in found)
    assert all(error["file"] == file for error in found)


@pytest.mark.parametrize(
    ("supports", "loads", "line", "reported"),
    [
        ("  - clamped: left\n  - clamped: {point: [5, 5]}\n", "  - pressure: 1\n", 6, "touches no node"),
        ("  - clamped: left\n  - {fixed: [w], where: left, value: 1}\n", "", 6, "contradict"),
        ("  - clamped: left\n", "  - pressure: 1\n  - {point: [5, 5], force: 1 N}\n", 8, "outside the plate"),
        ("  - clamped: left\n", "  - field: [1, 2]\n", 7, "one per ply"),
        ("  - clamped: left\n", "  - {pressure: 'sqrt(x - 1)'}\n", 7, "Pressure: expression"),
        ("  - {fixed: [u], where: left}\n", "  - pressure: 1\n", None, "is not held"),
    ],
)
def test_what_shows_only_when_the_plate_is_solved_has_its_place_in_the_file(
    tmp_path: Path, supports: str, loads: str, line: int | None, reported: str
) -> None:
    head = "kind: plate\nlaminate: {material: steel, thickness: 1 mm}\ngeometry: {rect: [0, 0, 1, 1], grid: [2, 2]}\n"
    file = tmp_path / "p.yaml"
    file.write_text(f"{head}supports:\n{supports}" + (f"loads:\n{loads}" if loads else ""), encoding="utf-8")
    (error,) = json.loads(call(str(file), "--json").stdout)["errors"]
    assert reported in error["message"]
    assert (error["file"], error["line"]) == (str(file), line)


def test_a_mesh_that_cannot_be_is_reported_at_its_geometry_unless_an_option_asked_for_it(
    tmp_path: Path,
) -> None:
    file = tmp_path / "p.yaml"
    text = "kind: plate\nlaminate: {material: steel, thickness: 1 mm}\ngeometry: {rect: [0, 0, 1, 1], size: 1 um}\n"
    file.write_text(text, encoding="utf-8")
    assert f"{file}:3:" in call(str(file)).stderr
    assert f"error: {file}: a mesh of size 2e-06 m" in call(str(file), "--size", "2e-6").stderr


def test_deflections_and_modes_are_told_before_the_error_of_buckling(tmp_path: Path) -> None:
    file = square(tmp_path / "s.yaml", n=4, loads="loads: [{pressure: 1}]\nmodes: 2\nbuckling: 1")
    result = call(file, "--json", "--no-pictures", "--out", "o")
    assert result.exit_code == 2
    reported = json.loads(result.stdout)
    assert not reported["ok"]
    assert len(reported["modes"]["frequencies"]) == 2
    assert middle(reported) > 0.0
    assert reported["buckling"] == {}
    (error,) = reported["errors"]
    assert "no membrane forces" in error["message"]
    assert error["line"] == 8
    assert json.loads((tmp_path / "o/summary.json").read_text())["errors"] == [error]
    assert result.stderr.splitlines()[-1].startswith(f"error: {file}:8:")


HALF_HELD = (
    "kind: plate\nlaminate: {material: steel, thickness: 1 mm}\ngeometry: {rect: [0, 0, 1, 1], grid: [4, 4]}\n"
    "supports: [{fixed: [w], where: boundary}]\n"
)


def test_a_case_that_cannot_be_solved_does_not_take_the_others_with_it(tmp_path: Path) -> None:
    """In the plane nothing holds the plate, so that a pull along x is not borne, and a pressure is."""
    file = tmp_path / "p.yaml"
    cases = ["cases:", "  pull: [{edge: right, force: [1, 0, 0]}]", "  up: [{pressure: 1}]"]
    file.write_text(HALF_HELD + "\n".join(cases) + "\n", encoding="utf-8")
    result = call(str(file), "--json", "--no-pictures", "--out", "o")
    assert result.exit_code == 3
    reported = json.loads(result.stdout)
    assert not reported["ok"]
    assert reported["failed_cases"] == ["pull"]
    assert list(reported["cases"]) == ["up"]
    # Timoshenko and Woinowsky-Krieger 1959, table 8: 0.00406 q a⁴ / D; four cells a side are some per cent off.
    assert reported["cases"]["up"]["extremes"]["w"]["largest"] == pytest.approx(0.00406 / STEEL, rel=0.1)
    (error,) = reported["errors"]
    assert error["message"].startswith("case 'pull': the plate is not held")
    assert json.loads((tmp_path / "o/summary.json").read_text(encoding="utf-8"))["failed_cases"] == ["pull"]
    words = call(str(file), "--no-pictures", "--out", "o")
    assert words.exit_code == 3
    assert "case      pull\nfailed    not solved" in words.stdout
    assert words.stderr.splitlines()[-1].startswith(f"error: {file}: case 'pull': the plate is not held")


def test_cases_none_of_which_can_be_solved_are_all_told(tmp_path: Path) -> None:
    file = tmp_path / "p.yaml"
    cases = ["cases:", "  pull: [{edge: right, force: [1, 0, 0]}]", '  up: [{pressure: "1/x"}]']
    file.write_text(HALF_HELD + "\n".join(cases) + "\n", encoding="utf-8")
    result = call(str(file), "--json", "--out", "o")
    assert result.exit_code == 2
    first, second = json.loads(result.stdout)["errors"]
    assert first["message"].startswith("case 'pull': the plate is not held")
    assert "case 'up': the intensity of a Pressure: expression" in second["message"]
    assert second["line"] == 7
    assert not (tmp_path / "o").exists()


def test_a_plate_that_nothing_acts_on_is_reported_in_a_line_and_still_vibrates(tmp_path: Path) -> None:
    file = square(tmp_path / "s.yaml", n=4, loads="modes: 1")
    words = call(file, "--no-pictures", "--out", "o").stdout
    assert "loads     none, and nothing is prescribed: the plate stays as it is\n\nmodes " in words
    assert "reactions" not in words


def test_a_second_mesh_tells_how_far_outputs_are_off(tmp_path: Path) -> None:
    loads = "loads: [{point: [0.1, 0.1], force: 10 N}]\noutputs: [{name: middle, at: [0.1, 0.1]}]"
    file = square(tmp_path / "s.yaml", n=16, loads=loads)
    reported = answer(file, "--two-meshes", "--out", "o")
    (found,) = reported["cases"][""]["two_meshes"]
    assert found["is"] == value(reported, "middle")
    assert found["finer"] == value(
        answer(square(tmp_path / "f.yaml", n=32, loads=loads), "--out", "f"), "middle"
    )
    # An estimate: the error that the series shows, within a tenth, as it is of second order but for a logarithm.
    assert found["error"] == pytest.approx(abs(found["is"] - NAVIER), rel=0.1)
    words = call(file, "--two-meshes", "--no-pictures", "--out", "o").stdout
    assert "halved    middle, w: " in words
    alone = square(tmp_path / "a.yaml", n=4, loads="loads: [{pressure: 1}]")
    (largest,) = answer(alone, "--two-meshes", "--out", "o")["cases"][""]["two_meshes"]
    assert (largest["name"], largest["at"]) == ("largest w", [0.1, 0.1])
    assert answer(alone, "--out", "o")["cases"][""]["two_meshes"] == []


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        ("kind: plat\ngeometry: {}\n", "1:7: kind: 'plat' is unknown; did you mean 'plate'?"),
        ("kind: [plate]\n", "1:7: kind: a word is expected here"),
        ("hello\n", "1:1: the file holds a single value"),
        ("- 1\n- 2\n", "1:1: the file holds a list"),
        ("a: &a [x, x]\nb: [*a, *a]\n", "1:1: the file has neither a kind nor layers"),
    ],
)
def test_what_is_neither_plate_nor_design_is_not_called_a_design(
    tmp_path: Path, text: str, reported: str
) -> None:
    file = tmp_path / "p.yaml"
    file.write_text(text, encoding="utf-8")
    result = call(str(file), "--quiet")
    assert result.exit_code == 2
    assert f"error: {file}:{reported}" in result.stderr


def test_interrupted_work_ends_with_130_and_leaves_no_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*args: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(plate_work, "FactoredPlate", stop)
    result = call(square(tmp_path / "s.yaml"), "--out", "o")
    assert result.exit_code == 130
    assert not Path("o").exists()


def test_what_was_written_before_an_interruption_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*args: object, **more: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(plate_files, "draw_fields", stop)
    result = call(square(tmp_path / "s.yaml", n=4), "--out", "o")
    assert result.exit_code == 130
    assert "see o" in result.stderr
    reported = json.loads(Path("o/summary.json").read_text(encoding="utf-8"))
    assert reported["interrupted"]
    assert set(reported["files"]) == {p.name for p in Path("o").iterdir()}
    assert "deflection.png" in reported["files"]

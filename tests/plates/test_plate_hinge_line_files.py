"""Hinge lines from designs and from plate files: several bodies in one plate, what the command says and writes."""

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest
import shapely
from click.testing import CliRunner
from shapely.geometry import LineString

from lamc import examples, plate
from lamc.basics.errors import DesignError, DesignErrors
from lamc.cli import main
from lamc.readers.load import load
from lamc.readers.plates.problem_file import plate_of_text
from lamc.readers.plates.problem_make import problem_of
from lamc.records.design import Design
from tests.plates.test_plate_from_design import MM2, SNAPPED, two_links
from tests.support.ctools import needs_cc

pytestmark = needs_cc

CARD = """\
kind: plate
units: mm
materials: {card: {E: 3 GPa, nu: 0, density: 700}}
laminate: {material: card, thickness: 0.4}
geometry: {polygon: [[0, 0], [100, 0], [100, 20], [0, 20]], size: 5}
supports: [{clamped: left}]
loads: [{edge: right, total: -1 mN}]
"""


# --- designs ---------------------------------------------------------------------------------------------------------


def test_links_reach_up_to_a_line_between_them() -> None:
    """Two links of 20 and 30 mm by 10: no film is left, and a window of 20 mm² stays."""
    found = plate.plate_of(two_links(), ("left", "right"), hinges="lines")
    areas = {name: region.area / MM2 for name, region in found.regions.items()}
    assert areas == pytest.approx({"all layers": 480.0, "all but upper": 20.0}, rel=1e-9)
    assert found.hinges == {}
    line = found.lines["h"]
    assert shapely.hausdorff_distance(line.where, LineString([(0, 0), (0, 10e-3)])) < 1e-9
    film = two_links().layers[2]
    E, nu, t = 2.5e9, 0.34, film.thickness
    # No stiffness is drawn: E t³ / 12 (1 - ν²) of a strip two hinge widths, 1 mm, wide.
    assert line.stiffness == pytest.approx(E * t**3 / (12 * (1 - nu**2) * 1e-3), rel=1e-9)
    assert any("no stiffness of its own" in note for note in found.notes)


def four_bar() -> Design:
    design = load(examples.find("four_bar").path)
    assert isinstance(design, Design)
    return design


TAPE = {"foam_tape": plate.Material(E1=5e6, E2=5e6, nu12=0.3, G12=5e6 / 2.6, density=720.0)}


@pytest.mark.parametrize("hinges", ["none", "lines", "strips"])
def test_bodies_above_one_another_are_no_plate(hinges: str) -> None:
    """The arm is in the lower sheet, and the upper sheet of the ground hangs 6 mm over it, unjoined."""
    with pytest.raises(
        DesignError, match=r"'ground' and 'arm' lie above one another at \(.*nothing joins them"
    ):
        plate.plate_of(four_bar(), "all", hinges=hinges, materials=TAPE)


def test_two_bars_in_one_sheet_fold_by_moment_over_stiffness() -> None:
    """0.9 mN on the far edge of the shelf, 30 mm from its hinge with the arm of 0.023 N·mm/rad, which is clamped."""
    found = plate.plate_of(four_bar(), ["arm", "shelf"], hinges="lines", materials=TAPE)
    (line,) = found.lines.values()
    mesh = plate.mesh(found.outline, 5e-3, regions=found.regions, follow=[line.where])
    # The mesher's own promise; borders of neighbours that part by round-off make needles.
    assert plate.mesh_report(mesh).angles[0] > 25.0
    problem = plate.Problem(
        mesh,
        dict(found.laminates),
        supports=[plate.Clamped(found.hinges["arm"].line)],
        loads=[plate.EdgeLoad(LineString([(70e-3, 0), (70e-3, 30e-3)]), -0.03)],
        hinges=[line],
    )
    solution = plate.solve(problem)
    assert isinstance(solution, plate.Solution)
    # Statics alone, on average along the line. The load's middle is 8 mm beside the line's, so the rotation differs
    # along it by what the bars twist, whose D is 0.3 N·m: 0.9 mN · 8 mm · 30 mm / D (14 mm) < 1e-4 rad, of 1.2.
    (turn,) = solution.hinges
    assert turn.rotation.mean() == pytest.approx(-0.9e-3 * 30e-3 / 0.023e-3, rel=2e-3)


def test_a_joints_stiffness_is_spread_along_its_line() -> None:
    design = two_links()
    (drawn,) = design.hinges
    stiff = dataclasses.replace(design, hinges=(dataclasses.replace(drawn, stiffness=4e-3),))
    found = plate.plate_of(stiff, "all", hinges="lines")
    assert found.lines["h"].stiffness == pytest.approx(4e-3 / 10e-3, rel=1e-9)
    assert found.notes == ()


def test_bodies_on_a_line_bend_as_those_on_a_strip() -> None:
    """Both links clamped at the left end, a load at the right: the film turns, and the links add next to nothing."""
    tips = {}
    for hinges in ("lines", "strips"):
        found = plate.plate_of(two_links(), "all", hinges=hinges)
        lines = list(found.lines.values())
        mesh = plate.mesh(
            found.outline,
            2e-3,
            regions=found.regions,
            sizes={name: 0.25e-3 for name in found.regions if name.startswith("hinge")},
            follow=[*(line.where for line in lines), found.fixed.boundary],
        )
        problem = plate.Problem(
            mesh,
            dict(found.laminates),
            supports=[plate.Clamped(found.fixed)],
            loads=[plate.EdgeLoad(LineString([(30e-3, 0), (30e-3, 10e-3)]), 0.1)],
            hinges=lines,
        )
        solution = plate.solve(problem)
        assert isinstance(solution, plate.Solution)
        tips[hinges] = float(solution.deflection(30e-3, 5e-3))
    # The mean of the squared arm over the strip differs by (1 mm)² / 12 / (30 mm)² = 1e-4; what curls at the strip's
    # ends is 0.4 % of k, and its mesh adds some of that.
    assert tips["lines"] == pytest.approx(tips["strips"], rel=8e-3)


@pytest.mark.parametrize("name", ["vertex", "waterbomb", "folding_box", "flaps"])
def test_all_of_a_folded_sheet_is_one_plate_of_panels(name: str) -> None:
    """Panels hang together by hinge lines alone: cut along these there are as many pieces as bodies."""
    design = load(examples.find(name).path)
    assert isinstance(design, Design)
    film = plate.material("Kapton HN")
    materials = {layer.material.name: film for layer in design.layers}
    found = plate.plate_of(design, "all", hinges="lines", materials=materials)
    lines = list(found.lines.values())
    mesh = plate.mesh(found.outline, 5e-3, regions=found.regions, follow=[line.where for line in lines])
    assert mesh.areas.sum() == pytest.approx(found.outline.area, rel=1e-9)
    problem = plate.Problem(mesh, dict(found.laminates), hinges=lines)
    cut = shapely.union_all([line.where for line in lines]).buffer(1e-7)
    panels = shapely.get_parts(shapely.difference(found.outline, cut))
    bodies = [part for part in panels if part.area > SNAPPED]
    labels = _labels(problem)
    assert len(np.unique(labels)) == len(bodies)
    length = sum(line.where.length for line in lines)
    edges = np.concatenate(problem.hinge_edges)
    ends = mesh.points[mesh.edges[edges]]
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(length, rel=1e-6)


def _labels(problem: plate.Problem) -> np.ndarray:
    """Which panel each cell is of: cells that share an edge that is no hinge."""
    mesh = problem.mesh
    label = np.arange(len(mesh.cells))
    hinge = np.zeros(len(mesh.edges), dtype=bool)
    hinge[np.concatenate(problem.hinge_edges)] = True
    while True:
        least = np.full(len(mesh.edges), len(mesh.cells))
        np.minimum.at(least, mesh.cell_edges, label[:, None])
        reach = np.where(hinge[mesh.cell_edges], len(mesh.cells), least[mesh.cell_edges]).min(axis=1)
        new = np.minimum(label, reach)
        if (new == label).all():
            return label
        label = new


# --- files -----------------------------------------------------------------------------------------------------------


def test_hinges_of_a_file_are_lines_with_units() -> None:
    file = plate_of_text(
        CARD
        + "hinges:\n"
        + "  - {name: a, along: {line: [[30, 0], [30, 20]]}, stiffness: 0.05 N*mm/mm/rad}\n"
        + "  - {along: {line: [[60, 0], [60, 12]]}}\n",
        "card.yaml",
    )
    one, two = file.hinges
    assert (one.name, one.stiffness, two.stiffness) == ("a", 0.05, 0.0)
    assert one.where.equals(LineString([(0.03, 0), (0.03, 0.02)]))
    problem = problem_of(file)
    tip = plate.solve(problem).deflection(0.1, 0.01)
    D = 3e9 * 0.4e-3**3 / 12
    # The beam, the fold, and nothing of the free cut: it is no beam's hinge, as it ends inside.
    least = 0.05 * (0.1**3 / (3 * D) + 0.07**2 / 0.05)
    assert 1.0 < -float(tip) / least < 1.3


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("{along: {line: [[30, 0], [30, 20]]}, stiffness: -1}", "8:.*stiffness.*-1"),
        ("{along: {line: [[30, 0], [30, 20]]}, stiffness: 3 mm}", "8:.*stiffness"),
        ("{along: {rect: [0, 0, 10, 10]}}", "8:.*a hinge inside the plate is along a line"),
        ("{along: left}", "8:.*a hinge inside the plate is along a line"),
        ("{along: {line: [[30, 0], [30, 0]]}}", "8:.*points of the line are one point"),
        ("{along: {hinge: knee}}", "8:.*only a plate of a design has hinges"),
        ("{along: {line: [[30, 0], [30, 20]]}, width: 3}", "8:.*width"),
    ],
)
def test_wrong_entries_are_reported_at_their_place(entry: str, message: str) -> None:
    with pytest.raises(DesignErrors) as caught:
        plate_of_text(CARD + f"hinges: [{entry}]\n", "card.yaml")
    (reported,) = {str(problem) for problem in caught.value.problems}
    assert re.search(message, reported), reported


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("[[0, 0], [0, 20]]", "card.yaml:8.*runs along the edge of the plate"),
        ("[[130, 0], [130, 20]]", "card.yaml:8.*lies along no edge"),
    ],
)
def test_lines_that_do_not_fit_the_plate_are_reported_at_their_place(lines: str, message: str) -> None:
    file = plate_of_text(CARD + f"hinges: [{{along: {{line: {lines}}}}}]\n", "card.yaml")
    with pytest.raises(Exception, match=message):
        problem_of(file)


# --- the command -----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_all_bodies_of_a_design_fold_by_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(
        main,
        [
            "plate",
            str(examples.find("flaps").path),
            *("--body", "all", "--hinges", "lines", "--clamp", "fixed", "--load", "right=-1 mN"),
            *("--size", "4 mm", "--modes", "2", "--out", "out", "--json"),
        ],
    )
    assert result.exit_code == 0, result.output
    reported = json.loads(result.stdout)
    hinges = {hinge["name"]: hinge for hinge in reported["cases"][""]["hinges"]}
    # A moment of 1 mN at 40 mm on 4 mN·m/rad; nothing on the other side. The links bend, and so the line turns
    # unevenly, by k / D per radian and length of it: a few millionths.
    assert hinges["right"]["rotation"] == pytest.approx(-0.01, rel=1e-4)
    assert hinges["right"]["energy"] == pytest.approx(0.5 * 4e-3 * 0.01**2, rel=1e-4)
    assert abs(hinges["left"]["rotation"]) < 1e-6 * 0.01  # what bends around the clamp, 2 mm beside it
    assert hinges["left"]["stiffness"] * hinges["left"]["length"] == pytest.approx(4e-3, rel=1e-6)
    assert {file.name for file in (tmp_path / "out").iterdir()} >= {
        "mesh.png",
        "deflection.png",
        "modes.png",
        "fields.vtu",
        "fields.csv",
    }
    rows = (tmp_path / "out" / "fields.csv").read_text().splitlines()
    assert len(rows) == 1 + reported["mesh"]["points"]  # a point on a line is one row
    # A flap on its spring: ω² = k / J about the line, J = m L² / 3; bending adds 1e-4.
    m = 12e-3 * (2 * 0.5e-3 * 1800 + 50e-6 * 1420)
    expected = [np.sqrt(4e-3 / (m * L * L**2 / 3)) / (2 * np.pi) for L in (40e-3, 30e-3)]
    assert reported["modes"]["frequencies"] == pytest.approx(expected, rel=2e-3)


def test_a_hinge_of_the_design_may_be_given_another_stiffness(tmp_path: Path) -> None:
    (tmp_path / "flaps.yaml").write_text(examples.find("flaps").text, encoding="utf-8")
    text = (
        "kind: plate\nunits: mm\ngeometry: {design: flaps.yaml, body: all, hinges: lines, size: 4}\n"
        "hinges: [{along: {hinge: left}, stiffness: 0}]\nsupports: [{clamped: fixed}]\n"
    )
    file = plate_of_text(text, str(tmp_path / "plate.yaml"))
    assert [(hinge.name, hinge.stiffness > 0.0) for hinge in file.hinges] == [
        ("left", False),
        ("right", True),
    ]
    one = text.replace("body: all", "body: link_1")
    with pytest.raises(DesignErrors, match="joins the plate to a body outside"):
        plate_of_text(one, str(tmp_path / "plate.yaml"))


def test_the_command_tells_what_was_done_to_the_drawing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sheets of the shelf are 2.3 mm apart beside the tape; the plate holds them at that distance, and says so."""
    monkeypatch.chdir(tmp_path)
    arguments = ["plate", str(examples.find("four_bar").path), "--body", "shelf", "--body", "arm"]
    arguments += ["--hinges", "lines", "--material", "foam_tape={E: 5 MPa, nu: 0.3}", "--clamp", "hinge: arm"]
    arguments += ["--load", "right=-1 mN", "--size", "5 mm", "--no-pictures", "--out", "out"]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0, result.output
    assert "note      region 'all but tape' is empty in 'tape'" in result.stdout
    (note,) = json.loads(Path("out/summary.json").read_text(encoding="utf-8"))["notes"]
    assert note.endswith("its sheets count as held at their distance")
    reported = [line for line in result.stdout.splitlines() if "shear through the thickness" in line]
    assert len(reported) == len(set(reported)) > 0

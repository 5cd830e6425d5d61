"""FOLD files without faces whose edges cross, touch or run over one another: healed as lines of a drawing are."""

import json
import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import DesignWarning, LamcError
from lamc.records.mechanism import Mechanism
from tests.support import fold_corpus as corpus
from tests.support.quick import tries

Data = dict[str, Any]
RIM = [(-40, -40), (40, -40), (40, 40), (-40, 40)]


def lines(rows: list[tuple[tuple[float, float], tuple[float, float], str, float | None]]) -> Data:
    """A file in which each line has two vertices of its own: ends, kind, angle, degrees."""
    points = [place for row in rows for place in row[:2]]
    return {
        "file_spec": 1.2,
        "frame_unit": "mm",
        "vertices_coords": points,
        "edges_vertices": [[2 * k, 2 * k + 1] for k in range(len(rows))],
        "edges_assignment": [row[2] for row in rows],
        "edges_foldAngle": [row[3] for row in rows],
    }


def square(*creases: tuple[tuple[float, float], tuple[float, float], str, float | None]) -> Data:
    """A square of 80 mm about the origin, with creases."""
    sides = zip(RIM, [*RIM[1:], RIM[0]], strict=True)
    return lines([*((a, b, "B", None) for a, b in sides), *creases])


def loaded(folder: Path, data: Data, **options: Any) -> tuple[Mechanism, list[str]]:
    with pytest.warns(DesignWarning) as told:
        found = lamc.load(corpus.write(folder / "sheet.fold", data), **options)
    assert isinstance(found, Mechanism)
    return found, [str(each.message) for each in told]


def drawn(mechanism: Mechanism) -> list[list[float]]:
    """Of each hinge its line in the plane, as a direction of 0 to 180 degrees and a distance, its stiffness and its
    rest angle without sign; sorted, as numbers of hinges are those of the file's edges."""
    rows = []
    for joint in mechanism.joints:
        x, y = joint.axis[:2] if (joint.axis[0], joint.axis[1]) > (1e-9, 0.0) else -joint.axis[:2]
        away = float(y * joint.point[0] - x * joint.point[1])
        rows.append([x, y, away, joint.stiffness, abs(joint.rest_angle)])
    return sorted([round(value, 12) + 0.0 for value in row] for row in rows)


def test_lines_that_cross_are_the_sheet_that_has_a_vertex_there(tmp_path: Path) -> None:
    """A waterbomb base as three lines from rim to rim, which no vertex parts."""
    exact = corpus.waterbomb()
    exact["edges_foldAngle"] = [{"B": 0.0, "V": 120.0, "M": -80.0}[k] for k in exact["edges_assignment"]]
    crossing = square(
        ((-40, -40), (40, 40), "M", -80.0),
        ((-40, 40), (40, -40), "M", -80.0),
        ((-40, 0), (40, 0), "V", 120.0),
    )
    sheet, told = loaded(tmp_path, crossing)
    same, _ = loaded(tmp_path, exact)
    assert any("edges are healed as lines of a drawing are" in note for note in told)
    assert sorted(body.mass for body in sheet.bodies) == pytest.approx(
        sorted(body.mass for body in same.bodies), rel=1e-12
    )
    np.testing.assert_allclose(drawn(sheet), drawn(same), atol=1e-12)


def test_ends_that_stop_short_are_mended_and_told(tmp_path: Path) -> None:
    sheet, told = loaded(tmp_path, square(((-39.999, 0.0), (39.999, 0.0), "V", 70.0)))
    assert len(sheet.joints) == 1
    assert sum(mend.what == "hinge extended" for mend in sheet.mends) == 2
    assert any("edge 4" in note and "hinge extended: 2" in note for note in told)


def test_what_each_assignment_becomes(tmp_path: Path) -> None:
    """Lines across from rim to rim, 10 mm apart: M and V sprung, U free, F and J join, C parts."""
    heights = zip("MVUFJC", range(-25, 35, 10), strict=True)
    sheet, told = loaded(tmp_path, square(*(((-40, y), (40, y), kind, None) for kind, y in heights)))
    found = {joint.name: joint for joint in sheet.joints}
    assert len(found) == 3
    rests = sorted((joint.stiffness > 0.0, joint.rest_angle > 0.0) for joint in found.values())
    assert rests == [(False, False), (True, False), (True, True)]
    assert len(sheet.bodies) == 5  # seven strips, of which three are one
    assert any("pieces" in note for note in told)
    assert any("edge 8 marked J: read as F" in note for note in told)


def test_lines_over_one_another_are_one(tmp_path: Path) -> None:
    twice = square(((-40, 0), (40, 0), "V", 70.0), ((-40, 0), (10, 0), "V", 70.0))
    sheet, told = loaded(tmp_path, twice)
    assert len(sheet.joints) == 1
    assert any("doubled line" in note for note in told)


def test_an_angle_makes_a_spring_of_an_unassigned_line(tmp_path: Path) -> None:
    sheet, _ = loaded(tmp_path, square(((-40, 0), (40, 0), "U", 30.0)))
    assert sheet.joints[0].stiffness > 0.0
    assert abs(sheet.joints[0].rest_angle) == pytest.approx(np.pi / 6.0)


@pytest.mark.parametrize(
    ("more", "ends", "why"),
    [
        ([(0, -40), (0, 40)], [(4, 5)], r"vertex 4 at \(0, -40\) lies on edge 0"),
        ([(0, -80), (0, 0)], [(4, 5)], r"edges 0 and 4 cross at \(0, -40\)"),
        ([(0, 0), (-40, -40)], [(4, 5), (4, 2)], r"vertices 0 and 5 are one place, \(-40, -40\)"),
        ([(0, 0), (0, 0)], [(4, 5)], "edge 4 has no length"),
    ],
)
def test_the_first_fault_is_told(
    tmp_path: Path, more: list[tuple[float, float]], ends: list[tuple[int, int]], why: str
) -> None:
    rim = [(k, (k + 1) % 4) for k in range(4)]
    data = {"frame_unit": "mm", "vertices_coords": [*RIM, *more], "edges_vertices": [*rim, *ends]}
    data["edges_assignment"] = [*"BBBB", *"C" * len(ends)]
    _, told = loaded(tmp_path, data)
    assert any(re.search(f"{why}: edges are healed", note) for note in told)


def test_every_edge_without_length_is_told(tmp_path: Path) -> None:
    dots = [((10, y), (10, y), "M", None) for y in (5, 15)]
    _, told = loaded(tmp_path, square(((-40, 0), (40, 0), "V", 70.0), *dots))
    assert any("edges 5, 6 left out: no length" in note for note in told)


PLACES = st.tuples(st.integers(-4, 4), st.integers(-4, 4)).map(lambda xy: (10.0 * xy[0], 10.0 * xy[1]))


@settings(max_examples=tries(60), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(PLACES, PLACES, st.sampled_from("MVF")), min_size=1, max_size=6))
def test_lines_are_the_sheet_that_the_same_lines_are_as_svg(
    tmp_path: Path, rows: list[tuple[tuple[float, float], tuple[float, float], str]]
) -> None:
    """Another reader, of the same lines: y runs down in SVG, and the front is the same."""
    creases = [(a, b, kind, {"M": -90.0, "V": 90.0, "F": None}[kind]) for a, b, kind in rows if a != b]
    data = square(((-40.0, 0.0), (40.0, 0.0), "V", 90.0), *creases)
    points, colours = data["vertices_coords"], {"B": "black", "M": "red", "V": "blue", "F": "#ffff00"}
    body = "".join(
        f'<line x1="{points[a][0]}" y1="{-points[a][1]}" x2="{points[b][0]}" y2="{-points[b][1]}" '
        f'stroke="{colours[kind]}" stroke-opacity="0.5"/>'
        for (a, b), kind in zip(data["edges_vertices"], data["edges_assignment"], strict=True)
    )
    file = tmp_path / "sheet.svg"
    box = 'width="80mm" height="80mm" viewBox="-40 -40 80 80"'
    file.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {box}>{body}</svg>')
    found: list[tuple[list[float], list[float]]] = []
    refused: list[bool] = []
    for path in (corpus.write(tmp_path / "sheet.fold", data), file):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DesignWarning)
            try:
                sheet = lamc.load(path, facets="rigid")
            except LamcError as error:  # of lines that end near others
                found.append(([], []))
                refused.append("stop short" in str(error))
                continue
        assert isinstance(sheet, Mechanism)
        found.append((sorted(body.mass for body in sheet.bodies), sorted(j.stiffness for j in sheet.joints)))
    assert all(refused)
    assert len(refused) in (0, 2)
    assert [len(each) for each in found[0]] == [len(each) for each in found[1]]
    for first, second in zip(*found, strict=True):
        assert first == pytest.approx(second, rel=1e-9)


def test_heal_says_within_what_and_is_for_lines(tmp_path: Path) -> None:
    short = square(((-39.0, 0.0), (39.0, 0.0), "V", 70.0))
    with pytest.raises(LamcError, match="edge 4"):
        lamc.load(corpus.write(tmp_path / "short.fold", short))
    sheet, _ = loaded(tmp_path, short, heal="1.5 mm")
    assert len(sheet.joints) == 1
    with pytest.raises(LamcError, match="heal is for lines"):
        lamc.load(corpus.write(tmp_path / "faces.fold", corpus.miura(2, 2, faces=True)), heal=1e-4)


@pytest.mark.slow
def test_folded_lines_and_too_many_stay_refused(tmp_path: Path) -> None:
    folded = square(((-40, 0), (40, 0), "V", 70.0), ((0, -40), (0, 40), "M", -70.0))
    folded["vertices_coords"] = [[*place, 0.1 * k] for k, place in enumerate(folded["vertices_coords"])]
    with pytest.raises(LamcError, match="lists no faces_vertices"):
        lamc.load(corpus.write(tmp_path / "folded.fold", folded))
    many = lines([((0.0, float(k)), (1.0, float(k + 1)), "M", None) for k in range(30_001)])
    (tmp_path / "many.fold").write_text(json.dumps(many))
    with pytest.raises(LamcError, match="30001 edges"):
        lamc.load(tmp_path / "many.fold")


def test_an_angle_of_an_edge_that_does_not_fold_is_told(tmp_path: Path) -> None:
    data = corpus.folded_pair(0.0)
    del data["faces_vertices"]
    data["vertices_coords"] = [place[:2] for place in data["vertices_coords"]]
    data["edges_assignment"][1] = "J"
    data["edges_foldAngle"] = [None, 70, *[None] * 5]
    with pytest.warns(DesignWarning, match="edge 1: the fold angle is left out"):
        lamc.load(corpus.write(tmp_path / "pair.fold", data), card=lamc.Card(), crease=1e-3)


def test_of_a_hinge_in_pieces_the_longer_marks_count_and_are_named(tmp_path: Path) -> None:
    """The first 6 mm are a valley of 45 degrees, the other 14 mm a mountain of 90."""
    corners = [(0, 0), (20, 0), (20, 20), (0, 20)]
    rim = [(a, b, "B", None) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]
    data = lines([*rim, ((10, 0), (10, 6), "V", 45), ((10, 6), (10, 20), "M", -90)])
    with pytest.warns(DesignWarning, match="pieces of one hinge are marked differently; edge 5 counts"):
        made = lamc.load(corpus.write(tmp_path / "pair.fold", data), card=lamc.Card(), crease=1e-3)
    assert isinstance(made, Mechanism)
    (joint,) = made.joints
    assert abs(joint.rest_angle) == pytest.approx(np.pi / 2)


@pytest.mark.slow
def test_scribbles_are_refused_before_all_their_crossings_are_found(tmp_path: Path) -> None:
    random = np.random.default_rng(2)
    data = {
        "file_spec": 1.2,
        "frame_unit": "mm",
        "vertices_coords": random.uniform(0.0, 100.0, (4000, 2)).tolist(),
        "edges_vertices": [[2 * k, 2 * k + 1] for k in range(2000)],
        "edges_assignment": ["M"] * 2000,
    }
    with pytest.raises(lamc.DesignError, match=r"more than 100000 lines.* parted where they cross"):
        lamc.load(corpus.write(tmp_path / "scribble.fold", data), card=lamc.Card(), crease=1e-3)

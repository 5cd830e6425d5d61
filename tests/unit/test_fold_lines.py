"""FOLD files without faces whose edges cross, touch or run over one another: healed as lines of a drawing are."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.basics.errors import DesignWarning, LamcError
from lamc.records.mechanism import Mechanism
from tests.support import fold_corpus as corpus

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


def test_lines_over_one_another_are_one(tmp_path: Path) -> None:
    twice = square(((-40, 0), (40, 0), "V", 70.0), ((-40, 0), (10, 0), "V", 70.0))
    sheet, told = loaded(tmp_path, twice)
    assert len(sheet.joints) == 1
    assert any("doubled line" in note for note in told)


def test_heal_says_within_what_and_is_for_lines(tmp_path: Path) -> None:
    short = square(((-39.0, 0.0), (39.0, 0.0), "V", 70.0))
    with pytest.raises(LamcError, match="edge 4"):
        lamc.load(corpus.write(tmp_path / "short.fold", short))
    sheet, _ = loaded(tmp_path, short, heal="1.5 mm")
    assert len(sheet.joints) == 1
    with pytest.raises(LamcError, match="heal is for lines"):
        lamc.load(corpus.write(tmp_path / "faces.fold", corpus.miura(2, 2, faces=True)), heal=1e-4)


def test_folded_lines_and_too_many_stay_refused(tmp_path: Path) -> None:
    folded = square(((-40, 0), (40, 0), "V", 70.0), ((0, -40), (0, 40), "M", -70.0))
    folded["vertices_coords"] = [[*place, 0.1 * k] for k, place in enumerate(folded["vertices_coords"])]
    with pytest.raises(LamcError, match="lists no faces_vertices"):
        lamc.load(corpus.write(tmp_path / "folded.fold", folded))
    many = lines([((0.0, float(k)), (1.0, float(k + 1)), "M", None) for k in range(30_001)])
    (tmp_path / "many.fold").write_text(json.dumps(many))
    with pytest.raises(LamcError, match="30001 edges"):
        lamc.load(tmp_path / "many.fold")

"""Vertices of a folded sheet and its fold angles say the same side, or that they do not is told."""

import json
import math
import warnings
from pathlib import Path

import pytest

import lamc

TURN = (1, 4)


def read(path: Path, height: float, angle: float | None, kind: str) -> tuple[lamc.Mechanism, list[str]]:
    """Two squares of 20 mm that share an edge, one of them upright, up or down."""
    data = {
        "file_spec": 1.1,
        "frame_unit": "mm",
        "vertices_coords": [
            [0, 0, 0],
            [20, 0, 0],
            [20, 0, height],
            [20, 20, height],
            [20, 20, 0],
            [0, 20, 0],
        ],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], list(TURN)],
        "edges_assignment": ["B"] * 6 + [kind],
        "edges_foldAngle": [0] * 6 + [angle],
        "faces_vertices": [[0, 1, 4, 5], [1, 2, 3, 4]],
    }
    path.write_text(json.dumps(data))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = lamc.load(path, card=lamc.Card(), crease=1e-3, fixed="F0")
    assert isinstance(made, lamc.Mechanism)
    return made, [str(each.message) for each in caught]


@pytest.mark.parametrize(("height", "start"), [(20.0, 90.0), (-20.0, -90.0)])
@pytest.mark.parametrize("angle", [90.0, -90.0, 45.0, -45.0, None])
def test_the_other_side_is_told(tmp_path: Path, height: float, start: float, angle: float | None) -> None:
    sheet, notes = read(tmp_path / "sheet.fold", height, angle, "V" if (angle or start) > 0 else "M")
    (joint,) = sheet.joints
    assert sheet.scene is not None
    assert math.degrees(sheet.scene.angles[joint.name]) == pytest.approx(start)
    assert math.degrees(joint.rest_angle) == pytest.approx(start if angle is None else angle)
    told = any("folded to the other side than the fold angle says" in note for note in notes)
    assert told == (angle is not None and angle * start < 0.0)


@pytest.mark.parametrize(
    ("heights", "told"),
    [
        ([0, 0, 20, 20, 0, 0], "is folded, in three dimensions, and lists no faces_vertices: list its faces"),
        ([0, 10, 20, 20, 10, 0], "lies flat in another plane than x and y"),
    ],
)
def test_places_without_faces_are_those_of_a_level_sheet(
    tmp_path: Path, heights: list[float], told: str
) -> None:
    """What is above, and so which way a mountain folds, is told by faces only."""
    across = [0.0, 20.0, 40.0, 40.0, 20.0, 0.0]
    data = {
        "frame_unit": "mm",
        "vertices_coords": [
            [x, y, z] for x, y, z in zip(across, [0, 0, 0, 20, 20, 20], heights, strict=True)
        ],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], list(TURN)],
        "edges_assignment": [*"BBBBBBM"],
    }
    path = tmp_path / "sheet.fold"
    path.write_text(json.dumps(data))
    with pytest.raises(lamc.DesignError, match=told):
        lamc.load(path, card=lamc.Card(), crease=1e-3)

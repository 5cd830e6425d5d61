"""Sheets that lie in another plane than x and y, and places on sheets that are folded."""

import json
import math
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.records.mechanism import Array, Mechanism

VERTEX = ([[0, 0], [20, 0], [0, 20], [-20, 0], [-8, -18]], "VVVM")  # one of four creases; mm
TURN = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
SPACE = np.asarray(TURN * np.sign(np.linalg.det(TURN)))  # a rotation
SQUARES = {  # side by side, the right one is face 0
    "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]],
    "edges_assignment": list("BBBBBBV"),
    "faces_vertices": [[1, 2, 3, 4], [0, 1, 4, 5]],
}


def read(path: Path, data: Mapping[str, Any], **options: Any) -> tuple[Mechanism, list[str]]:
    path.write_text(json.dumps({"frame_unit": "mm", **data}))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = lamc.load(path, **{"card": lamc.Card(), "crease": 1e-3, **options})
    assert isinstance(made, Mechanism)
    return made, [str(each.message) for each in caught]


def vertex(turn: Array, angles: Sequence[float | None] | None = None, digits: int = 15) -> dict[str, Any]:
    flat, kinds = VERTEX
    places = np.column_stack([flat, np.zeros(5)]) @ turn.T + [3.0, -7.0, 11.0]
    rim = [[k, k % 4 + 1] for k in range(1, 5)]
    data = {
        "vertices_coords": places.round(digits).tolist(),
        "edges_vertices": [*([0, k] for k in range(1, 5)), *rim],
        "edges_assignment": [*kinds, *"BBBB"],
        "faces_vertices": [[0, *pair] for pair in rim],
    }
    return data if angles is None else data | {"edges_foldAngle": [*angles, *[None] * 4]}


def squares(angle: float, shift: float = 0.0) -> dict[str, Any]:
    """The right one is turned up by an angle, rad."""
    x, z = round(20.0 + 20.0 * math.cos(angle), 9), 20.0 * math.sin(angle)
    places = [[0, 0, 0], [20, 0, 0], [x, 0, z], [x, 20, z], [20, 20, 0], [0, 20, 0]]
    return SQUARES | {"vertices_coords": [[p[0] + shift, *p[1:]] for p in places]}


@pytest.mark.parametrize("angles", [None, [0, 0, 0, 0], [70, 30, 80, -20], [None, None, None, -20]])
def test_a_flat_sheet_in_space_rests_as_one_in_x_and_y(
    tmp_path: Path, angles: list[float | None] | None
) -> None:
    level, _ = read(tmp_path / "level.fold", vertex(np.eye(3), angles), fixed="F0")
    tilted, notes = read(tmp_path / "tilted.fold", vertex(SPACE, angles), fixed="F0")
    assert [j.rest_angle for j in tilted.joints] == pytest.approx([j.rest_angle for j in level.joints])
    assert [math.copysign(1.0, j.rest_angle) for j in tilted.joints] == [1.0, 1.0, 1.0, -1.0]
    assert tilted.scene is not None
    assert dict(tilted.scene.angles) == {}
    assert [b.mass for b in tilted.bodies] == pytest.approx([b.mass for b in level.bodies])
    said = (
        "no fold angle"
        if angles is None or angles[0] is None
        else "a fold angle of 0, which is where the flat"
    )
    told = [note for note in notes if "M rests at -60 degrees" in note]
    assert [said in note for note in told] == ([True] if angles is None or angles[0] in (0, None) else [])
    no_gravity = lamc.Scene(without=("gravity",))
    # Round-off of the places, 1e-16 of the size, which swings of some fifty radians over a second make larger
    ends = [lamc.compile(made, no_gravity).run(0.05) for made in (level, tilted)]
    for joint in level.joints:
        assert ends[1].angle(joint.name)[-1] == pytest.approx(ends[0].angle(joint.name)[-1], abs=1e-6)


@pytest.mark.parametrize("digits", [1, 2])
def test_a_sheet_of_few_digits_is_flat_unless_it_says_how_it_is_folded(tmp_path: Path, digits: int) -> None:
    made, notes = read(tmp_path / "sheet.fold", vertex(SPACE, digits=digits), fixed="F0")
    assert made.scene is not None
    assert dict(made.scene.angles) == {}
    assert [round(math.degrees(j.rest_angle)) for j in made.joints] == [60, 60, 60, -60]
    assert any("the vertices miss a plane by" in note and "is taken as flat" in note for note in notes)
    folded, notes = read(tmp_path / "sheet.fold", vertex(SPACE, [50, 50, 50, -50], digits=2), fixed="F0")
    assert not any("miss a plane" in note for note in notes)
    assert folded.scene is not None
    assert folded.scene.angles


@pytest.mark.parametrize(("kind", "angle", "told"), [("V", 40.0, False), ("M", 40.0, True), ("V", 0.3, True)])
def test_a_crease_that_rests_as_it_is_folded_and_not_as_it_is_marked_is_told(
    tmp_path: Path, kind: str, angle: float, told: bool
) -> None:
    data = squares(math.radians(angle)) | {"edges_assignment": [*"BBBBBB", kind]}
    if angle < 1.0:  # another crease keeps the sheet from being taken for flat
        data["vertices_coords"] += [[-14.0, 0.0, 14.0], [-14.0, 20.0, 14.0]]
        data["edges_vertices"] = [*data["edges_vertices"], [0, 6], [6, 7], [7, 5]]
        data["edges_assignment"] = [*"BBBBBV", kind, *"BBB"]
        data["faces_vertices"] = [*data["faces_vertices"], [0, 5, 7, 6]]
    made, notes = read(tmp_path / "s.fold", data)
    crease = made.joint("E6")
    assert math.degrees(crease.rest_angle) == pytest.approx(angle)
    assert any("E6: no fold angle: it rests as it is folded" in note for note in notes) == told


@pytest.mark.parametrize("facets", ["rigid", "bend"])
@pytest.mark.parametrize("shift", [0.0, 100.0])
@pytest.mark.parametrize(("x", "held"), [(10.0, "F1"), (30.0, "F0")])
def test_a_place_on_a_folded_sheet_is_where_the_file_has_it(
    tmp_path: Path, facets: str, shift: float, x: float, held: str
) -> None:
    data = squares(math.radians(40.0), shift)
    made, _ = read(tmp_path / "s.fold", data, fixed=(1e-3 * (x + shift), 0.008), facets=facets)
    (fixed,) = (body for body in made.bodies if body.fixed)
    # Of facets that bend, each of two triangles, the first has its facet's number, and others come after all of these.
    of_face = {"F0": "F0", "F1": "F1", "F2": "F0", "F3": "F1"}
    assert of_face[fixed.name] == held


def test_a_place_within_one_facet_and_on_the_rim_of_another_is_in_the_first(tmp_path: Path) -> None:
    """The right square is folded by 120 degrees: its far side lies above the middle of the left one."""
    made, _ = read(tmp_path / "s.fold", squares(math.radians(120.0)), fixed=(0.01, 0.01))
    assert [body.name for body in made.bodies if body.fixed] == ["F1"]


def test_a_place_where_facets_lie_over_one_another_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        lamc.DesignError, match=r"at \(0\.01, 0\.01\) m several facets lie over one another, F0, F1"
    ):
        read(tmp_path / "s.fold", squares(math.radians(170.0)), fixed=(0.01, 0.01))
    with pytest.raises(lamc.DesignError, match="no facet is at"):
        read(tmp_path / "s.fold", squares(math.radians(40.0)), fixed=(0.039, 0.01))


@pytest.mark.parametrize("angles", [None, [], [None] * 7])
def test_that_no_hinge_has_a_spring_is_told(tmp_path: Path, angles: list[None] | None) -> None:
    data = {k: v for k, v in squares(0.0).items() if k != "edges_assignment"}
    data |= {} if angles is None else {"edges_foldAngle": angles}
    made, notes = read(tmp_path / "s.fold", data, crease=None)
    assert [j.stiffness for j in made.joints] == [0.0]
    assert sum("is a hinge without a spring" in note for note in notes) == 1
    assert not any("creases are taken to have" in note for note in notes)
    assert any(
        "hinges have no spring, and are damped as if they had 0.001 N*mm/rad" in note for note in notes
    )


def test_an_edge_that_parts_nothing_has_the_number_of_the_file(tmp_path: Path) -> None:
    data = {k: v for k, v in squares(0.0).items() if k != "faces_vertices"}
    data["edges_vertices"] = [[0, 1], *data["edges_vertices"], [0, 6]]  # the first one twice
    data["edges_assignment"] = ["B", *data["edges_assignment"], "V"]
    data["vertices_coords"] = [[p[0], p[1]] for p in [*data["vertices_coords"], [5, 5, 0]]]
    _, notes = read(tmp_path / "s.fold", data)
    assert any("edges 8 end within a facet" in note for note in notes)


def test_a_crease_replaces_stiffness_and_damping_that_a_file_of_lamc_has(tmp_path: Path) -> None:
    made, _ = read(tmp_path / "pair.fold", squares(0.5))
    lamc.export(made, "fold", out=tmp_path / "out")
    (written,) = (tmp_path / "out").glob("*.fold")
    other, _ = read(tmp_path / "pair.fold", squares(0.5), crease=1e-2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        again = lamc.load(written, crease=1e-2)
    assert isinstance(again, Mechanism)
    assert again.joints[0].stiffness == pytest.approx(other.joints[0].stiffness)
    assert again.joints[0].damping == pytest.approx(other.joints[0].damping)


def folded_flat(shift: float) -> dict[str, Any]:
    """The right one lies on the left one."""
    places = [[0, 0], [20, 0], [2, 0], [2, 20], [20, 20], [0, 20]]
    return SQUARES | {
        "vertices_coords": [[x + shift, y] for x, y in places],
        "edges_foldAngle": [*[None] * 6, 180.0],
    }


def test_a_place_on_a_sheet_that_is_folded_flat_is_where_the_file_has_it(tmp_path: Path) -> None:
    made, _ = read(tmp_path / "s.fold", folded_flat(100.0), fixed=(0.101, 0.01))
    assert [body.name for body in made.bodies if body.fixed] == ["F1"]
    with pytest.raises(lamc.DesignError, match="several facets lie over one another, F0, F1"):
        read(tmp_path / "s.fold", folded_flat(100.0), fixed=(0.110, 0.01))
    with pytest.raises(lamc.DesignError, match=r"no facet is at .* or name one: F0 to F1"):
        read(tmp_path / "s.fold", folded_flat(100.0), fixed=(0.03, 0.01))


def test_a_sheet_in_space_may_list_a_face_the_other_way_round(tmp_path: Path) -> None:
    data = vertex(SPACE)
    data["faces_vertices"][2] = data["faces_vertices"][2][::-1]
    made, _ = read(tmp_path / "s.fold", data, fixed="F0")
    assert [round(math.degrees(j.rest_angle)) for j in made.joints] == [60, 60, 60, -60]


def test_pieces_in_two_planes_are_laid_side_by_side(tmp_path: Path) -> None:
    below, above = squares(0.0), squares(0.0)
    for place in above["vertices_coords"]:
        place[2] = 0.1
    data = {
        "vertices_coords": [*below["vertices_coords"], *above["vertices_coords"]],
        "edges_vertices": [
            *SQUARES["edges_vertices"],
            *([a + 6, b + 6] for a, b in SQUARES["edges_vertices"]),
        ],
        "edges_assignment": [*SQUARES["edges_assignment"]] * 2,
        "faces_vertices": [
            *SQUARES["faces_vertices"],
            *([v + 6 for v in f] for f in SQUARES["faces_vertices"]),
        ],
    }
    made, _ = read(tmp_path / "s.fold", data)
    assert len(made.bodies) == 4

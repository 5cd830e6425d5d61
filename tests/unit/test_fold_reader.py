"""FOLD files: what becomes a body and a hinge, signs, units, frames; what is told, what is refused; fuzz."""

import copy
import json
import math
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import DesignWarning, LamcError
from lamc.commands.options import Cli
from lamc.records.mechanism import Mechanism
from tests.support import fold_corpus as corpus
from tests.support import large_corpus
from tests.support.quick import tries

CARD = lamc.Card(thickness="0.3 mm", density="700 kg/m^3")
Data = dict[str, Any]


def read(folder: Path, data: Data, **options: Any) -> Mechanism:
    """The mechanism of a file that says all but card and crease, without warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        found = lamc.load(
            corpus.write(folder / "sheet.fold", data), **{"card": CARD, "crease": 1e-3, **options}
        )
    assert isinstance(found, Mechanism)
    return found


def notes(folder: Path, data: Data, **options: Any) -> list[str]:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        lamc.load(corpus.write(folder / "sheet.fold", data), **options)
    return [str(each.message) for each in told]


def counts(mechanism: Mechanism) -> tuple[int, int]:
    return len(mechanism.bodies), len(mechanism.joints)


@pytest.mark.parametrize(
    ("data", "bodies", "joints"),
    [
        (corpus.miura(4, 3), 12, 17),
        (corpus.miura(4, 3, faces=True), 12, 17),
        (corpus.waterbomb(), 6, 6),
        (corpus.yoshimura(3, 4), 24, 29),
        (corpus.box_net(), 6, 5),
    ],
)
def test_facets_are_bodies_and_creases_hinges(tmp_path: Path, data: Data, bodies: int, joints: int) -> None:
    assert counts(read(tmp_path, data)) == (bodies, joints)


def test_faces_found_are_those_that_a_file_lists(tmp_path: Path) -> None:
    found, listed = (read(tmp_path, corpus.miura(3, 3, faces=faces)) for faces in (False, True))
    assert {j.name: j.stiffness for j in found.joints} == {j.name: j.stiffness for j in listed.joints}
    # The same corners in another order: sums round differently in the last digits.
    middles = [sorted(tuple(np.round(b.com, 12)) for b in m.bodies) for m in (found, listed)]
    assert middles[0] == middles[1]


def test_a_valley_is_positive_and_lifts_the_far_side(tmp_path: Path) -> None:
    data = corpus.folded_pair(0.7)
    made = read(tmp_path, data, fixed="F0")
    joint = made.joints[0]
    assert (joint.parent, joint.child) == ("F0", "F1")
    assert made.scene is not None
    assert made.scene.angles["E1"] == pytest.approx(0.7, abs=1e-12)  # rounding of two cosines
    position, _ = lamc.compile(made).run(t_end=1e-3).pose("F1")
    # Where the middle of the second square is in the file, about the middle of the card: 1e-6 m, as 1e-3 s moves it.
    middle = np.mean([data["vertices_coords"][v] for v in (1, 4, 5, 2)], axis=0) * 1e-3 + [0.0, 0.0, 1.5e-4]
    assert position[0] == pytest.approx(middle, abs=1e-9)
    # Laid flat, the second square lies beyond the first one.
    assert made.body("F1").com[:2] == pytest.approx([0.03, 0.01], abs=1e-12)
    assert joint.rest_angle == pytest.approx(0.7, abs=1e-12)


def test_folded_flat_is_told_by_the_assignment(tmp_path: Path) -> None:
    for kind, sign in (("V", 1.0), ("M", -1.0)):
        data = corpus.folded_pair(math.pi)
        data["edges_assignment"][1] = kind
        data["vertices_coords"] = [[x, y] for x, y, _ in data["vertices_coords"]]
        data["faces_vertices"] = [[0, 1, 2, 3], [1, 4, 5, 2]]
        # The second square lies on the first one: its corners are those of the first.
        data["vertices_coords"][4], data["vertices_coords"][5] = [0.0, 0.0], [0.0, 20.0]
        made = read(tmp_path, data)
        assert made.scene is not None
        assert made.scene.angles["E1"] == pytest.approx(sign * math.pi)


def test_an_edge_drawn_twice_is_read_once_and_others_keep_their_numbers(tmp_path: Path) -> None:
    data = corpus.miura(3, 3)
    at = data["edges_assignment"].index("V")
    for key, value in (("edges_vertices", data["edges_vertices"][at][::-1]), ("edges_assignment", "V")):
        data[key] = [*data[key][: at + 1], value, *data[key][at + 1 :]]
    for key in [
        key for key in data if key.startswith("edges_") and len(data[key]) < len(data["edges_vertices"])
    ]:
        data[key] = [*data[key][: at + 1], data[key][at], *data[key][at + 1 :]]
    plain = read(tmp_path, corpus.miura(3, 3))
    twice = read(tmp_path, data)
    assert len(twice.joints) == len(plain.joints)
    assert f"edge {at + 1} is drawn as edge {at} is, and is left out" in " ".join(notes(tmp_path, data))
    moved = {f"E{k}": f"E{k + (k > at)}" for k in range(len(data["edges_vertices"]))}
    assert {moved[j.name] for j in plain.joints} == {j.name for j in twice.joints}
    data["edges_assignment"][at + 1] = "M"
    with pytest.raises(LamcError, match=f"edges {at} and {at + 1} both join .* fold otherwise; keep one"):
        read(tmp_path, data)


def test_units_are_those_of_the_file_the_user_or_such_that_one_can_fold_it(tmp_path: Path) -> None:
    for unit, options, scale in (
        ("cm", {}, 0.01),
        ("cm", {"units": "in"}, 0.0254),
        ("unit", {}, 0.1 / 8.0),  # eight wide: no sheet of 8 mm
        (None, {}, 0.1 / 8.0),
        (None, {"units": "mm"}, 1e-3),
    ):
        net = read(tmp_path, corpus.box_net(unit), **options)
        # 4 square units; six digits: areas are sums of products
        assert net.bodies[0].mass == pytest.approx(4.0 * scale**2 * 3e-4 * 700.0, rel=1e-6)
    assert any("8, is taken for 100 mm" in note for note in notes(tmp_path, corpus.box_net(None)))
    wide = corpus.miura(3, 3, unit=None)
    assert any("1 is taken for 1 mm" in note for note in notes(tmp_path, wide))
    assert not any("no unit" in note for note in notes(tmp_path, corpus.box_net("cm")))


def test_what_is_assumed_is_told_and_what_is_given_is_not(tmp_path: Path) -> None:
    told = " ".join(notes(tmp_path, corpus.miura(2, 2)))
    assert "--card" in told
    assert "--crease" in told
    assert "no fold angle" in told
    assert notes(tmp_path, corpus.box_net("cm"), card=CARD, crease="1e-3 N*mm/rad/mm") == []


def test_stiffness_goes_by_length(tmp_path: Path) -> None:
    net = read(tmp_path, corpus.box_net("cm"), crease="2e-3 N*mm/rad/mm")
    assert [j.stiffness for j in net.joints] == pytest.approx([2e-3 * 0.02] * 5)
    assert [j.rest_angle for j in net.joints] == pytest.approx([math.pi / 2] * 5)


def test_flat_edges_and_joins_hold_and_cuts_part(tmp_path: Path) -> None:
    for kind, expected in (("F", (5, 4)), ("J", (5, 4)), ("C", (6, 4)), ("U", (6, 5))):
        data = corpus.box_net()
        hinge = data["edges_assignment"].index("V")
        data["edges_assignment"][hinge], data["edges_foldAngle"][hinge] = kind, None
        made = read(tmp_path, data)
        assert counts(made) == expected
        assert sum(body.fixed for body in made.bodies) == (2 if kind == "C" else 1)
        if kind == "U":
            assert made.joint(f"E{hinge}").stiffness == 0.0


def test_pieces_in_line_are_one_hinge(tmp_path: Path) -> None:
    data = corpus.box_net()
    hinge = data["edges_assignment"].index("V")
    a, b = data["edges_vertices"][hinge]
    middle = np.mean([data["vertices_coords"][v] for v in (a, b)], axis=0).tolist()
    data["vertices_coords"].append(middle)
    new = len(data["vertices_coords"]) - 1
    data["edges_vertices"][hinge] = [a, new]
    data["edges_vertices"].append([new, b])
    data["edges_assignment"].append("V")
    data["edges_foldAngle"].append(90)
    made = read(tmp_path, data)
    assert counts(made) == (6, 5)
    assert made.joint(f"E{hinge}").stiffness == pytest.approx(1e-3 * 0.02)


def windowed(spokes: int) -> Data:
    """A square of 20 mm with a hole of 10 mm, joined by edges F from corner to corner."""
    outer, inner = [(0, 0), (20, 0), (20, 20), (0, 20)], [(5, 5), (15, 5), (15, 15), (5, 15)]
    ring = [[k, (k + 1) % 4] for k in range(4)]
    edges = [*ring, *([a + 4, b + 4] for a, b in ring), *([k, k + 4] for k in range(spokes))]
    kinds = ["B"] * 8 + ["F"] * spokes
    points = [list(map(float, p)) for p in (*outer, *inner)]
    return {"frame_unit": "mm", "vertices_coords": points, "edges_vertices": edges, "edges_assignment": kinds}


def test_what_the_rim_encloses_amid_facets_is_a_hole(tmp_path: Path) -> None:
    for spokes in (2, 4):
        made = read(tmp_path, windowed(spokes))
        assert counts(made) == (1, 0)
        assert made.bodies[0].mass == pytest.approx(3e-4 * 3e-4 * 700.0, rel=1e-12)  # 300 mm²
        assert any("is a hole" in note for note in notes(tmp_path, windowed(spokes)))
    with pytest.raises(LamcError, match="by two edges F"):
        read(tmp_path, windowed(0))


def test_edges_that_part_nothing_are_told_once(tmp_path: Path) -> None:
    data = corpus.box_net()
    for key, value in (("vertices_coords", [3.0, 0.5]), ("edges_vertices", [0, 14])):
        data[key].append(value)
    data["edges_assignment"].append("M")
    data["edges_foldAngle"].append(None)
    data["edges_vertices"][-1] = [corner_at(data, 2.0, 0.0), 14]
    told = notes(tmp_path, data, card=CARD, crease=1e-3)
    assert len(told) == 1
    assert "left out" in told[0]
    assert counts(read(tmp_path, data)) == (6, 5)


def square(**more: Any) -> Data:
    """A square with a crease inside it that reaches no side."""
    return {
        "frame_unit": "mm",
        "vertices_coords": [[0, 0], [40, 0], [40, 40], [0, 40], [10, 30], [30, 10]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5]],
        "edges_assignment": ["B", "B", "B", "B", "V"],
        **more,
    }


@pytest.mark.parametrize("listed", [True, False])
@pytest.mark.parametrize("facets", ["rigid", "bend"])
def test_a_crease_beside_no_facet_is_told_by_its_number(tmp_path: Path, facets: str, listed: bool) -> None:
    data = square(faces_vertices=[[0, 1, 2, 3]]) if listed else square()
    told = notes(tmp_path, data, card=CARD, crease=1e-3, facets=facets)
    assert sum("left out" in note for note in told) == 1
    assert any(note.split(": ", 1)[-1].startswith(("edge 4: beside no", "edges 4 end")) for note in told)


def test_a_key_that_is_nearly_one_of_folds_is_told(tmp_path: Path) -> None:
    told = notes(tmp_path, square(edges_foldAngel=[0, 0, 0, 0, 90], faces_layer=[0], **{"my:faceOrder": []}))
    assert [note for note in told if "none of FOLD's" in note] == [
        f"{tmp_path / 'sheet.fold'}: the key 'edges_foldAngel' is none of FOLD's, and is not read; is "
        "'edges_foldAngle' meant?"
    ]
    data = square()
    data["vertices_coord"] = data.pop("vertices_coords")
    with pytest.raises(LamcError, match=r"no vertices_coords.*; 'vertices_coord' is none of FOLD's keys"):
        read(tmp_path, data)


def corner_at(data: Data, x: float, y: float) -> int:
    return int(data["vertices_coords"].index([x, y]))


def test_creases_at_an_angle_between_two_facets_hold_them(tmp_path: Path) -> None:
    data = corpus.box_net()
    hinge = data["edges_assignment"].index("V")
    a, b = data["edges_vertices"][hinge]
    off = (np.mean([data["vertices_coords"][v] for v in (a, b)], axis=0) + 0.3).tolist()
    data["vertices_coords"].append(off)
    new = len(data["vertices_coords"]) - 1
    data["edges_vertices"][hinge] = [a, new]
    data["edges_vertices"].append([new, b])
    data["edges_assignment"].append("V")
    data["edges_foldAngle"].append(90)
    assert counts(read(tmp_path, data)) == (5, 4)
    assert any("to one side of a line" in note for note in notes(tmp_path, data))


def test_creases_at_an_angle_on_two_sides_of_a_window_hold_their_facets(tmp_path: Path) -> None:
    path = tmp_path / "window.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="20mm" viewBox="0 0 40 20" fill="none">'
        '<rect width="40" height="20" stroke="#000"/><rect x="18" y="8" width="6" height="4" stroke="#000"/>'
        '<path d="M20 0V8M23 12L26 20" stroke="#f00" opacity="0.5"/></svg>'
    )
    with pytest.warns(DesignWarning, match="lines at an angle cannot turn and are one body"):
        sheet = lamc.load(path, facets="rigid")
    assert counts(sheet) == (1, 0)


@pytest.mark.slow
def test_the_fixed_facet_is_in_the_middle_named_or_pointed_at(tmp_path: Path) -> None:
    def fixed(**options: Any) -> list[str]:
        made = read(tmp_path, corpus.miura(5, 5, faces=True), **options)
        return [body.name for body in made.bodies if body.fixed]

    assert fixed() == ["F12"]
    assert fixed(fixed="F3") == ["F3"]
    assert fixed(fixed=(0.012, 0.005)) == ["F0"]
    for wrong in ("F99", (5.0, 5.0)):
        with pytest.raises(LamcError, match="no facet"):
            fixed(fixed=wrong)


def test_a_place_where_facets_meet_is_of_none(tmp_path: Path) -> None:
    data = {
        "vertices_coords": [[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [0, 1]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]],
        "edges_assignment": ["B"] * 6 + ["V"],
        "frame_unit": "m",
    }
    for place in ((1.0, 0.5), (1.0, 0.0), (1.0 + 1e-12, 0.5)):
        with pytest.raises(lamc.DesignError, match="lies where facets meet, F0, F1: give a place amid one"):
            read(tmp_path, data, fixed=place)
    assert [body.name for body in read(tmp_path, data, fixed=(1.01, 0.5)).bodies if body.fixed] == ["F1"]


def test_frames_inherit_and_a_bare_key_frame_gives_way(tmp_path: Path) -> None:
    flat = corpus.miura(2, 2)
    data = {"file_spec": 1.2, "file_frames": [flat, {"frame_parent": 1, "frame_inherit": True}]}
    assert counts(read(tmp_path, data)) == (4, 4)
    base = {k: v for k, v in flat.items() if k != "edges_vertices"}
    own = {"frame_parent": 0, "frame_inherit": True, "edges_vertices": flat["edges_vertices"]}
    assert counts(read(tmp_path, {**base, "file_frames": [own]})) == (4, 4)
    loop = [{"frame_parent": 2, "frame_inherit": True}, {"frame_parent": 1, "frame_inherit": True}]
    with pytest.raises(LamcError, match="frame 1 has no end of parents: 1, 2 inherit from one another"):
        read(tmp_path, {**base, "file_frames": loop})


def test_other_frames_that_draw_a_sheet_are_told(tmp_path: Path) -> None:
    folded = {
        "frame_inherit": True,
        "frame_parent": 0,
        "vertices_coords": corpus.box_net()["vertices_coords"],
    }
    told = notes(tmp_path, {**corpus.box_net(), "file_frames": [folded]}, card=CARD, crease=1e-3)
    assert not any("only frame" in note for note in told)
    several = {**corpus.box_net(), "file_frames": [folded, corpus.miura(2, 2), corpus.miura(3, 2)]}
    told = notes(tmp_path, several, card=CARD, crease=1e-3)
    assert [note.split(": ", 1)[1].split(":")[0] for note in told if "only frame" in note] == [
        "only frame 0 is read, and 2, 3 draw sheets of their own"
    ]


def set_at(*path: Any) -> Callable[[Any], Callable[[Data], None]]:
    def of(value: Any) -> Callable[[Data], None]:
        def change(data: Data) -> None:
            at: Any = data
            for key in path[:-1]:
                at = at[key]
            at[path[-1]] = value

        return change

    return of


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (set_at("vertices_coords", 3, 0)(math.nan), "NaN, which is no JSON"),
        (set_at("vertices_coords", 3, 0)("7"), "vertex 3 is"),
        (set_at("vertices_coords", 3, 0)(10**400), "vertex 3 has a coordinate that is not finite"),
        (set_at("vertices_coords", 3)([1]), "vertex 3 is"),
        (set_at("vertices_coords")([]), "no vertices_coords"),
        (set_at("edges_vertices", 2)([0, 99]), "edge 2 names vertex 99; vertices are 0 to 8"),
        (set_at("edges_vertices", 2)([0, 0]), "edge 2 has the vertices"),
        (set_at("edges_vertices", 2)([0, 1]), "edges 0 and 2 both join"),
        (set_at("edges_vertices", 2)([True, 1]), "edge 2 names vertex True"),
        (set_at("edges_vertices")(7), "edges_vertices is 7; it must be a list"),
        (set_at("edges_vertices")([]), "no frame|neither"),
        (set_at("edges_assignment", 1)("X"), "edge 1 has the assignment 'X'"),
        (set_at("edges_assignment")(["M"]), "1 entries for 12 edges"),
        (set_at("edges_foldAngle")([400] * 12), "edge 0 has the fold angle 400"),
        (set_at("frame_unit")("parsec"), "frame_unit is 'parsec'"),
        (set_at("faces_vertices")([[0, 1, 99]]), "face 0 names vertex 99"),
        (set_at("faces_vertices")([[0, 1, 1]]), "face 0 has the vertices"),
        (set_at("faces_vertices")([[0, 1, 5, 4]]), "face 0 has a side from vertex"),
        (set_at("faces_vertices")([[0, 1, 4, 3], [0, 1, 4, 3]]), "faces 0 and 1 lie over one another"),
        (set_at("vertices_coords", 4, slice(2, 3))([5.0]), "lists no faces_vertices"),
        (set_at("file_frames")("x"), "file_frames must be a list"),
        (set_at("lamc:card")({"thickness": 0}), "lamc:card has"),
    ],
)
def test_what_is_wrong_is_told_with_its_number(
    tmp_path: Path, change: Callable[[Data], None], told: str
) -> None:
    data = copy.deepcopy(corpus.miura(2, 2))
    change(data)
    with pytest.raises(LamcError, match=told) as caught:
        read(tmp_path, data)
    assert "sheet.fold" in str(caught.value)


def test_text_that_is_no_json_is_told_with_its_line(tmp_path: Path) -> None:
    file = tmp_path / "sheet.fold"
    file.write_text('{"file_spec": 1.2,\n "vertices_coords": [[0, 1],]}')
    with pytest.raises(LamcError, match=r"sheet\.fold:2:.*no JSON"):
        lamc.load(file)


def test_a_closed_box_cannot_be_laid_flat(tmp_path: Path) -> None:
    with pytest.raises(LamcError, match="cannot be laid flat: about vertex"):
        read(tmp_path, corpus.cube())


def test_a_folded_form_of_stretched_facets_is_told_the_way_out(tmp_path: Path) -> None:
    """As programs of bars and springs leave them; a box is no such thing."""
    data = large_corpus.in_space(large_corpus.PATTERNS["yoshimura"](3, 3))
    ends = [vertex for edge in data["edges_vertices"] for vertex in edge]
    size = max(map(max, data["vertices_coords"]))
    data["vertices_coords"][max(ends, key=ends.count)][2] += 0.05 * size  # a vertex amid the sheet
    with pytest.raises(LamcError, match="or take the flat crease pattern, if facets were stretched"):
        read(tmp_path, data)
    with pytest.raises(LamcError) as caught:
        read(tmp_path, corpus.cube())
    assert "stretched" not in str(caught.value)


def test_an_edge_of_four_faces_is_told_with_them(tmp_path: Path) -> None:
    """As of tubes that are joined: the faces lie on either side by turns, and none is listed clockwise."""
    edge = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    around = [[x, y, z] for x, y in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)) for z in (0.0, 1.0)]
    faces = [[0, 1, 2 * k + 3, 2 * k + 2][:: (-1) ** k] for k in range(4)]
    sides = {tuple(sorted(side)) for face in faces for side in zip(face, face[1:] + face[:1], strict=True)}
    data = {
        "file_spec": 1.2,
        "frame_classes": ["foldedForm"],
        "vertices_coords": edge + around,
        "faces_vertices": faces,
        "edges_vertices": [list(side) for side in sorted(sides)],
        "edges_assignment": ["V" if side == (0, 1) else "B" for side in sorted(sides)],
    }
    with pytest.raises(
        LamcError, match="the edge from vertex 0 to 1 has 4 faces, 0, 1, 2, 3: an edge joins two"
    ):
        read(tmp_path, data)


def test_of_a_folded_form_that_tears_the_crease_pattern_is_read(tmp_path: Path) -> None:
    """Where the file has one: folded corners of few digits cannot be laid flat, those of the pattern can."""
    pattern = {**corpus.box_net(), "frame_classes": ["creasePattern"]}
    other = {**corpus.miura(2, 2), "frame_classes": ["foldedForm"]}
    data = {**corpus.cube(), "frame_classes": ["foldedForm"], "file_frames": [other, pattern]}
    assert counts(read(tmp_path, data)) == counts(read(tmp_path, corpus.box_net()))
    told = [note for note in notes(tmp_path, data) if "cannot be laid flat" in note]
    assert len(told) == 1
    assert "frame 2, the file's crease pattern, is read" in told[0]
    with pytest.raises(LamcError, match="cannot be laid flat: about vertex"):
        read(tmp_path, {**data, "file_frames": [other]})
    worse = {**pattern, "edges_assignment": ["M"]}
    with pytest.raises(
        LamcError, match=r"cannot be laid flat.*frame 2, the file's crease pattern, is none either: edges_"
    ):
        read(tmp_path, {**data, "file_frames": [other, worse]})
    lost = {**pattern, "frame_inherit": True, "frame_parent": 9}
    with pytest.raises(
        LamcError, match=r"cannot be laid flat.*of its other frames, frame 2 has frame_parent 9"
    ):
        read(tmp_path, {**data, "file_frames": [other, lost]})
    with pytest.raises(LamcError, match="so it is none that was folded"):
        read(tmp_path, {**data, "frame_classes": ["creasePattern"], "file_frames": [other]})


def test_a_key_that_only_tells_of_a_file_may_stand_twice(tmp_path: Path) -> None:
    file = corpus.write(tmp_path / "sheet.fold", corpus.miura(2, 2))
    text = file.read_text()
    file.write_text(text.replace("{", '{"file_spec": 1.1, "file_author": "A", "file_author": "A", ', 1))
    with pytest.warns(
        DesignWarning, match="'file_spec' stands twice in one map, 1.1 and 1.2: the last is read"
    ):
        assert counts(lamc.load(file, card=CARD, crease=1e-3)) == (4, 4)  # type: ignore[arg-type]
    file.write_text(text.replace("{", "{" + '"file_title": "A", "file_title": "B", ' * 50, 1))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        lamc.load(file, card=CARD, crease=1e-3)
    assert sum("stands twice" in str(each.message) for each in told) == 1
    file.write_text(text.replace("{", '{"edges_vertices": [[0, 1]], ', 1))
    with pytest.raises(LamcError, match="'edges_vertices' stands twice in one map; keep one of them"):
        lamc.load(file)


def test_a_million_edges_are_refused_soon_with_the_limit(tmp_path: Path) -> None:
    file = tmp_path / "big.fold"
    file.write_text('{"vertices_coords": [[0,0],[1,1]], "edges_vertices": [' + "[0,1]," * 10**6 + "[0,1]]}")
    began = time.monotonic()
    with pytest.raises(LamcError, match="limit 'values'"):
        lamc.load(file)
    assert time.monotonic() - began < 5.0  # s; it is some 10 ms


def test_options_of_sheets_are_refused_elsewhere(tmp_path: Path) -> None:
    file = tmp_path / "flat.yaml"
    file.write_text("kind: mechanism\nbodies: [{name: a, fixed: true}]\njoints: []\n")
    with pytest.raises(LamcError, match="units is for sheets"):
        lamc.load(file, units="mm")


def test_the_command_line_takes_what_python_takes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from lamc.cli import main

    assert isinstance(main, Cli)
    file = str(corpus.write(tmp_path / "net.fold", corpus.box_net(None)))
    words = ["--card", "0.5 mm, 900 kg/m^3", "--crease", "2e-3 N*mm/rad/mm", "--units", "cm", "--fixed", "F1"]
    folder = tmp_path / "out"
    assert main.main(["split", file, *words, "--out", str(folder), "--json"], standalone_mode=False) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["ok"]
    made = lamc.load(folder / "net.mechanism.yaml")
    assert isinstance(made, Mechanism)
    assert made.body("F1").fixed
    assert made.bodies[0].mass == pytest.approx(4e-4 * 0.5e-3 * 900.0)
    assert main.main(["split", file, "--card", "thick"], standalone_mode=False) == 2
    # Of "0.3, 700" the thickness had been 0.3 m, without a word.
    with pytest.raises(
        lamc.DesignError, match=r"0\.3 m thick: numbers without a unit are m; write '0\.3 mm, 700'"
    ):
        lamc.Card.of("0.3, 700")
    assert lamc.Card.of("3e-4, 700") == lamc.Card.of("0.3 mm, 700 kg/m^3")
    assert "'0.3 mm, 700 kg/m^3'" in capsys.readouterr().err


FEW = settings(
    max_examples=tries(60), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
WORDS = st.sampled_from(
    ["[", "]", "{", "}", ",", ":", "null", "NaN", "-1", "1e999", '"M"', '"', "[]", "true", "9" * 5000, "0.5"]
)


@FEW
@given(data=st.data())
def test_any_change_of_a_file_is_a_record_or_an_error(tmp_path: Path, data: st.DataObject) -> None:
    base = data.draw(st.sampled_from([corpus.miura(2, 2, faces=True), corpus.folded_pair(0.7)]))
    text = json.dumps(base)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text)))
        text = text[:at] + data.draw(WORDS) + text[at + data.draw(st.integers(0, 6)) :]
    attempt(tmp_path, text)


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 9) | st.floats() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=4),
    max_leaves=8,
)
KEYS = ["vertices_coords", "edges_vertices", "edges_assignment", "edges_foldAngle", "faces_vertices"]
KEYS += [
    "frame_unit",
    "frame_inherit",
    "frame_parent",
    "file_frames",
    "file_spec",
    "frame_title",
    "lamc:card",
]
KEYS += ["lamc:faces_body", "lamc:fixed", "lamc:edges_hinge"]


def test_creases_are_damped_by_half_of_what_is_critical_for_the_lighter_facet(tmp_path: Path) -> None:
    """Two squares of 20 mm, each m w^2 / 3 about the crease, and its thickness: m t^2 / 12."""
    joint = read(tmp_path, corpus.folded_pair(0.5)).joints[0]
    mass, stiffness = 700.0 * 0.3e-3 * 0.02**2, 1e-3 * 0.02  # kg, N m/rad
    about = mass * (0.02**2 / 3.0 + 0.3e-3**2 / 12.0)
    assert joint.stiffness == pytest.approx(stiffness, rel=1e-12)
    assert joint.damping == pytest.approx(
        0.5 * 2.0 * math.sqrt(stiffness * about), rel=1e-9
    )  # areas of polygons


@FEW
@given(key=st.sampled_from(KEYS), value=VALUES)
def test_any_value_of_a_field_is_a_record_or_an_error(tmp_path: Path, key: str, value: Any) -> None:
    attempt(tmp_path, json.dumps({**corpus.miura(2, 2), key: value}))


def attempt(folder: Path, text: str) -> None:
    file = folder / "fuzzed"
    file.write_text(text, encoding="utf-8")
    began = time.monotonic()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        message = ""
        try:
            lamc.load(file)
        except LamcError as error:
            message = str(error)
    assert all(len(line) < 2000 for line in message.splitlines())
    assert time.monotonic() - began < 5.0  # s: a second is the promise, and the machine may be busy


def fan(folder: Path, *directions: float) -> tuple[Mechanism, list[str]]:
    """A disc of card, mm, with creases from its centre, at degrees."""
    turns = sorted({*directions, *range(0, 360, 30)})
    places = [
        [0.0, 0.0],
        *([50.0 * math.cos(math.radians(a)), 50.0 * math.sin(math.radians(a))] for a in turns),
    ]
    rim = [(k, k % len(turns) + 1, "B") for k in range(1, len(turns) + 1)]
    edges = [*rim, *((0, turns.index(a) + 1, "V") for a in directions)]
    data: corpus.Data = {
        "file_spec": 1.1,
        "frame_unit": "mm",
        "vertices_coords": places,
        "edges_vertices": [list(edge[:2]) for edge in edges],
        "edges_assignment": [edge[2] for edge in edges],
        "edges_foldAngle": [None if edge[2] == "B" else 60 for edge in edges],
    }
    options = {"card": CARD, "crease": 1e-3, "facets": "rigid"}
    return read(folder, data, **options), notes(folder, data, **options)


@pytest.mark.parametrize(
    ("directions", "hinges"),
    [
        ((0, 180), 1),  # a line, of two pieces
        ((0, 90, 180), 1),  # a T: the line folds, the crease that meets it does not
        ((0, 40, 90, 130, 180), 1),  # several that meet it from one side
        ((10, 60, 150), 0),  # all to one side
        ((0, 90, 180, 270), 4),  # a cross folds along either line
        ((0, 75, 180, 270), 4),
        ((0, 120, 240), 3),  # rigid, but not to one side
    ],
)
def test_creases_to_one_side_of_a_line_do_not_fold(
    tmp_path: Path, directions: tuple[float, ...], hinges: int
) -> None:
    sheet, told = fan(tmp_path, *directions)
    assert len(sheet.joints) == hinges
    assert any("to one side of a line" in note for note in told) == (hinges < len(directions) > 2)


@pytest.mark.parametrize("noise", [0.0, 1e-15, 1e-11, 1e-10])
def test_facets_with_corners_of_their_own_are_joined_whatever_their_last_digits(
    tmp_path: Path, noise: float
) -> None:
    """A strip of ten, each with four vertices of its own, of which a grid of places would part some."""
    rng = np.random.default_rng(0)
    corners = [[(k, 0.0), (k + 1, 0.0), (k + 1, 1.0), (k, 1.0)] for k in range(10)]
    exact = np.array([[3.7 * x + 0.13 * y, x + 4.1 * y] for facet in corners for x, y in facet])
    data = {
        "vertices_coords": (exact + 37.0 * noise * rng.uniform(-1.0, 1.0, exact.shape)).tolist(),
        "edges_vertices": [[4 * k + i, 4 * k + (i + 1) % 4] for k in range(10) for i in range(4)],
        "edges_assignment": [
            "V" if (i == 1 and k < 9) or (i == 3 and k > 0) else "B" for k in range(10) for i in range(4)
        ],
        "faces_vertices": [list(range(4 * k, 4 * k + 4)) for k in range(10)],
    }
    file = tmp_path / "strip.fold"
    file.write_text(json.dumps(data), encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        found = lamc.load(file)
    assert isinstance(found, lamc.Mechanism)
    assert len(found.joints) == 9


def two_squares(**more: Any) -> Data:
    """Two squares beside one another along x, with a crease between them."""
    return {
        "frame_unit": "mm",
        "vertices_coords": [[0, 0], [20, 0], [40, 0], [40, 20], [20, 20], [0, 20]],
        "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4]],
        "edges_assignment": [*"BBBBBB", "V"],
        **more,
    }


def test_names_of_version_1_0_are_read(tmp_path: Path) -> None:
    """`edges_foldAngles` and `edges_lengths`, which 1.1 renamed."""
    old = two_squares(edges_foldAngles=[None] * 6 + [110], edges_lengths=[20] * 7)
    (joint,) = read(tmp_path, old).joints
    assert joint.rest_angle == pytest.approx(math.radians(110.0))
    assert not notes(tmp_path, old, card=CARD, crease=1e-3)
    both = {**old, "edges_foldAngle": [None] * 6 + [50]}
    (joint,) = read(tmp_path, both).joints
    assert joint.rest_angle == pytest.approx(math.radians(50.0))


def test_faces_that_run_clockwise_are_told(tmp_path: Path) -> None:
    faces = [[0, 5, 4, 1], [1, 4, 3, 2]]
    (told,) = notes(
        tmp_path, two_squares(faces_vertices=faces, edges_foldAngle=[None] * 6 + [50]), card=CARD, crease=1e-3
    )
    assert (
        "all faces are listed clockwise: mountains and valleys of a flat sheet are taken as it is seen"
        in told
    )
    turned = [faces[0][::-1], faces[1]]
    (told,) = notes(
        tmp_path,
        two_squares(faces_vertices=turned, edges_foldAngle=[None] * 6 + [50]),
        card=CARD,
        crease=1e-3,
    )
    assert "1 of 2 faces are listed clockwise" in told


def test_a_crease_without_a_length_in_a_folded_sheet_is_refused(tmp_path: Path) -> None:
    """It was a division by zero."""
    data = {
        "frame_unit": "mm",
        "vertices_coords": [
            [0, 0, 0],
            [20, 0, 0],
            [40, 0, 9],
            [40, 20, 9],
            [20, 20, 0],
            [0, 20, 0],
            [20, 0, 0],
        ],
        "edges_vertices": [[0, 1], [1, 6], [6, 2], [2, 3], [3, 4], [4, 5], [5, 0], [1, 4], [6, 4]],
        "edges_assignment": [*"BVBBBBBVV"],
        "faces_vertices": [[0, 1, 4, 5], [6, 2, 3, 4], [1, 6, 4]],
    }
    with pytest.raises(
        LamcError, match=r"edge \d has no length: its vertices 1 and 6 are at one place|no area"
    ):
        read(tmp_path, data)


def test_several_facets_may_be_held(tmp_path: Path) -> None:
    data = two_squares()
    data["vertices_coords"] += [[60, 0], [60, 20]]
    data["edges_vertices"] += [[2, 6], [6, 7], [7, 3]]
    data["edges_assignment"] = [*"BBVBBBVBBB"]
    for fixed in (["F0", "F2"], [(0.01, 0.01), "F2"], [(0.01, 0.01), ("50 mm", "10 mm")]):
        made = read(tmp_path, data, fixed=fixed)
        assert [body.fixed for body in made.bodies] == [True, False, True]
    made = read(tmp_path, data, fixed=("30 mm", "10 mm"))
    assert [body.name for body in made.bodies if body.fixed] == ["F1"]


def test_a_face_around_a_slit_is_read_of_a_flat_sheet(tmp_path: Path) -> None:
    """The specification lets a face pass a vertex twice."""
    data = two_squares(edges_foldAngle=[None] * 6 + [50])
    data["vertices_coords"] += [[10, 10]]
    data["edges_vertices"] += [[0, 6]]
    data["edges_assignment"] = [*data["edges_assignment"], "B"]
    data["edges_foldAngle"] = [*data["edges_foldAngle"], None]
    data["faces_vertices"] = [[0, 6, 0, 1, 4, 5], [1, 2, 3, 4]]
    made = read(tmp_path, data)
    assert counts(made) == (2, 1)
    assert made.joints[0].rest_angle == pytest.approx(math.radians(50.0))
    assert any("face 0 passes a vertex twice" in note for note in notes(tmp_path, data))
    data["vertices_coords"] = [[x, y, 0.1 * x] for x, y in data["vertices_coords"]]
    with pytest.raises(LamcError, match="not of folded ones; part the face by edges F"):
        read(tmp_path, data)

"""Drawings of lines as sheets: facets, holes, flaps, roles; what is told and what is refused."""

import json
import math
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import DesignError, DesignWarning
from lamc.readers.drawings.sheet import sheet_of
from lamc.records.card import SheetOptions
from lamc.records.drawing import ROLES, Stroke
from lamc.records.mechanism import Mechanism
from lamc.report.bodies_picture import draw_bodies
from lamc.report.plan_view import mend_entry
from lamc.report.split_text import split_data, split_text
from tests.support import fold_corpus as corpus
from tests.support.drawn_corpus import drawing, line, of_fold, square
from tests.support.quick import tries

CARD = lamc.Card(thickness="0.3 mm", density="700 kg/m^3")
SQUARE_MM = 3e-4 * 700.0 * 1e-6  # kg of a square millimetre
HINGE = line((20, 0), (20, 40), source="path #fold")


def read(*strokes: Stroke, **options: Any) -> tuple[Mechanism, list[str]]:
    """The sheet, and what was told."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", DesignWarning)
        made = sheet_of(drawing(*strokes), SheetOptions(**{"card": CARD, "crease": 1e-3, **options}))
    return made, [str(each.message) for each in told]


def geometry(made: Mechanism) -> list[list[tuple[float, ...]]]:
    """What does not depend on names or on which end of an axis comes first, in m and N·m/rad."""
    bodies = sorted((round(1e9 * b.mass, 3), *np.round(1e6 * b.com, 3)) for b in made.bodies)
    joints = sorted(
        (round(1e9 * j.stiffness, 3), *np.round(np.abs(j.axis), 6), round(j.rest_angle, 6))
        for j in made.joints
    )
    return [bodies, joints]


@pytest.mark.parametrize(
    "data", [corpus.miura(4, 3), corpus.waterbomb(), corpus.yoshimura(3, 4), corpus.box_net("mm")]
)
def test_a_drawing_is_the_sheet_that_fold_holds(data: Any, tmp_path: Any) -> None:
    made, told = read(*of_fold(data))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        fold = lamc.load(corpus.write(tmp_path / "a.fold", data), card=CARD, crease=1e-3)
    assert isinstance(fold, Mechanism)
    assert geometry(made) == geometry(fold)
    assert made.mends == ()
    assert not any("healed" in each for each in told)


def test_names_do_not_follow_the_order_of_the_lines() -> None:
    strokes = of_fold(corpus.miura(3, 3))
    turned = [Stroke(s.points[::-1], s.closed, s.role, s.angle, s.layer, s.source) for s in strokes[::-1]]
    assert read(*strokes)[0] == read(*turned)[0]


def test_a_hinge_rests_flat_with_a_spring_and_undriven_has_none() -> None:
    for role, stiffness, rest in (("hinge", 4e-5, 0.0), ("undriven", 0.0, 0.0), ("valley", 4e-5, 0.5)):
        made, _ = read(square(0, 0, 40), line((20, 0), (20, 40), role=role, angle=rest or None))
        joint = made.joints[0]
        assert (joint.stiffness, joint.rest_angle) == (pytest.approx(stiffness), rest)


@pytest.mark.parametrize("role", ["border", "hole"])
def test_outlines_within_outlines_are_holes(role: Any) -> None:
    made, told = read(square(0, 0, 40), square(5, 5, 5, role), HINGE)
    assert sorted(b.mass / SQUARE_MM for b in made.bodies) == pytest.approx([775.0, 800.0])
    assert len(made.joints) == 1
    assert told == []


def test_a_hinge_through_a_hole_is_one_hinge_of_two_pieces() -> None:
    made, told = read(square(0, 0, 40), square(18, 18, 4), HINGE)
    assert [b.mass / SQUARE_MM for b in made.bodies] == pytest.approx([792.0, 792.0])
    assert made.joints[0].stiffness == pytest.approx(1e-3 * 0.036)
    assert "line outside the material: 1" in told[0]


def test_outlines_go_by_turns() -> None:
    made, told = read(square(0, 0, 40), square(10, 10, 20), square(15, 15, 10))
    assert sorted(b.mass / SQUARE_MM for b in made.bodies) == pytest.approx([100.0, 1200.0])
    assert any("2 pieces" in each for each in told)


def test_many_holes_in_a_row_and_a_grid() -> None:
    holes = [square(4.0 * i + 1.0, 4.0 * j + 1.0, 2.0) for i in range(10) for j in range(10)]
    made, _ = read(square(0, 0, 40), *holes, HINGE)
    assert [b.mass / SQUARE_MM for b in made.bodies] == pytest.approx([600.0, 600.0])
    assert len(made.joints) == 1


def test_a_flap_amid_a_facet_turns_on_its_crease() -> None:
    flap = line((10, 10), (10, 20), (20, 20), (20, 10), role="cut")
    made, told = read(square(0, 0, 40), flap, line((10, 10), (20, 10)))
    assert sorted(b.mass / SQUARE_MM for b in made.bodies) == pytest.approx([100.0, 1500.0])
    assert made.joints[0].stiffness == pytest.approx(1e-5)
    assert told == []


def test_outlines_that_touch_at_points_are_holes_all_the_same() -> None:
    touching = [
        line((10, 10), (14, 16), (6, 16), role="border", closed=True),  # one above the other
        line((10, 10), (14, 4), (6, 4), role="border", closed=True),
        line((0, 30), (4, 28), (4, 32), role="border", closed=True),  # the rim, from within
        line((30, 40), (32, 36), (28, 36), role="border", closed=True),
        line((20, 20), (24, 24), (24, 16), role="border", closed=True),  # a hinge
    ]
    made, told = read(square(0, 0, 40), *touching, HINGE)
    holes = 2 * 24.0 + 8.0
    assert sorted(b.mass / SQUARE_MM for b in made.bodies) == pytest.approx(
        [800.0 - holes, 800.0 - 8.0 - 16.0]
    )
    assert len(made.joints) == 1
    assert told == []


def test_without_an_outline_cuts_are_one_and_else_the_lines_are() -> None:
    made, told = read(square(0, 0, 40, "cut"), square(5, 5, 5, "cut"), HINGE)
    assert sorted(b.mass / SQUARE_MM for b in made.bodies) == pytest.approx([775.0, 800.0])
    assert any("cuts that enclose something are taken for outlines" in each for each in told)
    made, told = read(square(0, 0, 40, "hinge"), HINGE)
    assert len(made.joints) == 1
    assert any("no outline is drawn" in each for each in told)


def star(off: float) -> list[Stroke]:
    """A square of 100 mm, and four creases across it that pass its middle at most `off`, mm, beside it."""
    ways = np.radians([20.0, 65.0, 110.0, 155.0])
    lines = []
    for k, (x, y) in enumerate(np.stack([np.cos(ways), np.sin(ways)], axis=1)):
        aside = off * (-1.0, 0.3, 1.0, -0.6)[k] * np.array([-y, x])
        reach = np.array([x, y]) * 50.0 / max(abs(x), abs(y))
        ends = [50.0 + aside + way * (reach + 2.0 * reach / np.hypot(*reach)) for way in (-1.0, 1.0)]
        inside = np.clip(ends, 0.0, 100.0)
        lines.append(line(*map(tuple, inside.tolist()), role="valley"))
    return [square(0, 0, 100), *lines]


def test_lines_that_all_but_meet_in_one_place_leave_no_slivers() -> None:
    # the corners lie up to 0.05 mm apart, and the usual tolerance is 0.01 mm
    made, told = read(*star(0.016))
    assert (len(made.bodies), len(made.joints)) == (8, 8)
    assert [note.endswith("healed within 10 times the usual") for note in told if "narrower" in note] == [
        True
    ]
    made, told = read(*star(0.005))
    assert (len(made.bodies), len(made.joints)) == (8, 8)
    assert [note.endswith("healed within 3 times the usual") for note in told if "part off" in note] == [True]
    # what a tolerance that is given leaves is told with its place
    made, told = read(*star(0.016), heal=0.0)
    assert len(made.bodies) > 8
    assert any("narrower than 0.05 mm" in note and "mm, the first at (" in note for note in told)
    # nothing is healed farther for lines that part facets as wide as these
    made, told = read(*star(2.0))
    assert len(made.bodies) > 8
    assert not any("narrower" in note for note in told)


@pytest.mark.parametrize(
    "data", [corpus.miura(4, 3), corpus.waterbomb(), corpus.yoshimura(3, 4), corpus.box_net("mm")]
)
@pytest.mark.parametrize("off", [6e-4, 1.4e-3])
def test_a_sheet_drawn_by_eye_is_the_sheet_that_was_meant(data: Any, off: float) -> None:
    """Each end lies aside by up to `off` of the sheet's size, some pixels of a screen: no two lines meet."""
    meant, _ = read(*of_fold(data), facets="rigid")
    random = np.random.default_rng(20260108)
    strokes = of_fold(data)
    size = max(np.ptp(np.concatenate([stroke.points for stroke in strokes]), axis=0))
    moved = [
        replace(s, points=s.points + off * size * random.uniform(-0.7, 0.7, s.points.shape)) for s in strokes
    ]
    made, told = read(*moved, facets="rigid")
    assert (len(made.bodies), len(made.joints)) == (len(meant.bodies), len(meant.joints))
    # Each of the four sides of a sheet lies aside by `off` of its size at most.
    assert sum(b.mass for b in made.bodies) == pytest.approx(sum(b.mass for b in meant.bodies), rel=4.0 * off)
    assert any("end points joined" in note for note in told)


def test_lines_farther_apart_than_any_tolerance_are_told_with_what_was_healed() -> None:
    short = line((20, 0.3), (20, 40), source="path #fold")
    with pytest.raises(
        DesignError, match=r"healed within 0\.12 mm, lines still stop short of one another: path"
    ):
        read(square(0, 0, 40), short)


def test_a_crease_that_dangles_is_left_out_and_told() -> None:
    made, told = read(square(0, 0, 40), HINGE, line((20, 20), (30, 20), source="path #mark"))
    assert len(made.bodies) == 2
    assert [m.what for m in made.mends] == ["line that bounds nothing"]
    assert "path #mark" in told[0]


def test_a_gap_is_refused_with_the_tolerance_that_mends_it() -> None:
    outline = line((0, 0), (40, 0), (40, 40), (0, 40), (0, 0.5), role="border", source="path #rim")
    with pytest.raises(
        lamc.DesignError, match=r"path #rim .border. ends at \(0, 0\) mm, 0.5 mm .*--heal '0.51 mm'"
    ):
        read(outline, HINGE)
    made, told = read(outline, HINGE, heal="0.51 mm")
    assert len(made.joints) == 1
    assert "gap in an outline: 1, by up to 0.5 mm" in told[0]
    short = line((20, 0.25), (20, 40), source="path #fold")
    with pytest.raises(
        lamc.DesignError, match=r"path #fold .hinge. ends at \(20, 0.25\) mm.*--heal '0.26 mm'"
    ):
        read(square(0, 0, 40), short)
    made, told = read(square(0, 0, 40), short, heal="0.26 mm")
    assert made.joints[0].stiffness == pytest.approx(4e-5)
    assert "hinge extended: 1, by up to 0.25 mm: (20, 0) mm, path #fold" in told[0]


def test_an_outline_without_its_last_side_is_refused_and_loses_no_facet() -> None:
    """A path without Z: the facet beside it had been left out, and the crease taken for the rim."""
    creases = [line((15, 0), (15, 40)), line((25, 0), (25, 40))]
    sides = [line((0, 0), (40, 0)), line((40, 0), (40, 40)), line((40, 40), (0, 40))]
    for rim in ([line((0, 0), (40, 0), (40, 40), (0, 40))], sides):
        opened = [replace(each, role="border", source="path #rim") for each in rim]
        with pytest.raises(
            lamc.DesignError, match=r"outline is open: path #rim .border. ends at .*: close it \(Z at"
        ):
            read(*opened, *creases)
        made, _ = read(*opened, line((0, 40), (0, 0), role="border"), *creases)
        assert len(made.bodies) == 3
    # Sides that run over their corners, and a mark that touches the rim, are none of that.
    over = [
        line((-2, 0), (42, 0)),
        line((40, -2), (40, 42)),
        line((42, 40), (-2, 40)),
        line((0, 42), (0, -2)),
    ]
    made, told = read(
        *[replace(each, role="border") for each in over], line((20, 40), (20, 48), role="border"), *creases
    )
    assert len(made.bodies) == 3
    assert "line that bounds nothing" in " ".join(told)


@pytest.mark.parametrize("notch", [(10, -5, 8), (36, 16, 8), (60, 0, 8)])
def test_a_cut_over_the_edge_of_an_outline_adds_no_material(notch: tuple[int, int, int]) -> None:
    """A notch drawn as a closed cut: it had been taken for an outline, with what it encloses beyond the sheet."""
    x, y, size = notch
    made, told = read(square(0, 0, 40), HINGE, square(x, y, size, role="cut", source="rect #notch"))
    assert sum(body.mass for body in made.bodies) / SQUARE_MM == pytest.approx(1600.0, rel=1e-12)  # of sums
    assert "line outside the material: 1" in " ".join(told)
    assert "rect #notch" in " ".join(told)


def test_cuts_about_creases_that_no_outline_has_are_outlines() -> None:
    """A piece whose rim is drawn as a cut, beside one with an outline, about a window, beside a title block."""
    beside = [square(50, 0, 40, role="cut"), line((70, 0), (70, 40))]
    made, _ = read(square(0, 0, 40), HINGE, *beside)
    assert (len(made.bodies), len(made.joints)) == (4, 2)
    window = square(10, 10, 5)
    made, _ = read(window, square(0, 0, 40, role="cut"), HINGE)
    assert sum(body.mass for body in made.bodies) / SQUARE_MM == pytest.approx(1600.0 - 25.0, rel=1e-12)
    made, _ = read(square(100, 0, 20), *beside)
    assert len(made.joints) == 1


def test_outlines_that_run_over_a_junction_with_an_inner_one_are_closed() -> None:
    """Two cells of five lines, drawn some millimetres too long."""
    lines = [line((-3, y), (43, y)) for y in (0, 20)] + [line((x, -3), (x, 23)) for x in (0, 20, 40)]
    made, _ = read(*[replace(each, role="border") for each in lines], line((0, 10), (20, 10)))
    assert [body.mass / SQUARE_MM for body in made.bodies] == pytest.approx([200.0, 200.0, 400.0])


def test_no_tolerance_is_offered_that_would_be_refused_or_would_join_the_ends_of_a_side() -> None:
    for far in (1.0, 5.0, 30.0):
        with pytest.raises(lamc.DesignError, match="closes an outline") as caught:
            read(line((0, 0), (40, 0), (40, 40), (0, 40), (0, far), role="border"))
        assert "--heal" not in str(caught.value)
    with pytest.raises(lamc.DesignError, match="to meet") as caught:
        read(square(0, 0, 40), line((20, 3), (20, 40)))
    assert "heal more" not in str(caught.value)


def test_a_short_crease_is_left_out_where_nothing_is_to_be_healed() -> None:
    short = line((20, 0.25), (20, 40), source="path #fold")
    with pytest.raises(lamc.DesignError, match="with --heal 0, creases that end so are left out"):
        read(square(0, 0, 40), short)
    made, told = read(square(0, 0, 40), short, heal=0)
    assert (len(made.bodies), len(made.joints)) == (1, 0)
    assert "nothing folds" in told[0]
    assert "line that bounds nothing: 1: (20, 20.125) mm, path #fold" in told[1]
    with pytest.raises(lamc.DesignError, match=r"--heal '0.51 mm'$"):
        read(line((0, 0), (40, 0), (40, 40), (0, 40), (0, 0.5), role="border"), heal=0)


def test_a_window_that_creases_hold_is_a_hole() -> None:
    creases = [
        line((0, 20), (18, 20)),
        line((22, 20), (40, 20)),
        line((18, 20), (20, 18), (22, 20), role="border"),
    ]
    made, _ = read(square(0, 0, 40), *creases, line((18, 20), (20, 22), (22, 20), role="border"))
    assert [b.mass / SQUARE_MM for b in made.bodies] == pytest.approx([796.0, 796.0])
    assert len(made.joints) == 1
    assert made.joints[0].stiffness == pytest.approx(1e-3 * 0.036)


def test_messages_name_lines_and_not_edges() -> None:
    _, told = read(
        square(0, 0, 40), square(40, 0, 40, source="rect #right"), line((40, 0), (40, 40), role="border")
    )
    assert any("rect #right" in each or "line 0" in each for each in told)
    assert not any("edge" in each for each in told)


@pytest.mark.parametrize(
    ("strokes", "match"),
    [
        ((), "no line"),
        ((line((0, 0), (1, 0), role="ignore"),), "no line"),
        ((line((0, 0), (10, 0)),), "no facet"),
        ((square(0, 0, 10, "hole"),), "no facet"),
        ((square(0, 0, 40), square(0, 0, 10, "border"), line((10, 10), (40, 10))), ""),
    ],
)
def test_what_encloses_nothing_is_refused(strokes: Any, match: str) -> None:
    if match:
        with pytest.raises(lamc.DesignError, match=match):
            read(*strokes)
    else:
        read(*strokes)


@pytest.mark.slow
def test_a_thousand_facets_in_a_second_or_so() -> None:
    made, _ = read(*of_fold(corpus.miura(32, 32)))
    assert len(made.bodies) == 1024


def test_the_sheet_runs() -> None:
    made, _ = read(square(0, 0, 40), line((20, 0), (20, 40), role="valley", angle=1.0))
    result = lamc.compile(made).run(t_end=0.01)
    assert math.isfinite(float(result.q[-1, 0]))
    assert json.dumps([m.what for m in made.mends]) == "[]"


@pytest.mark.slow
@settings(max_examples=tries(200), deadline=None)
@given(
    strokes=st.lists(
        st.tuples(
            st.lists(
                st.tuples(st.integers(0, 6) | st.floats(0, 6), st.integers(0, 6) | st.floats(0, 6)),
                min_size=2,
                max_size=5,
            ),
            st.sampled_from(ROLES),
            st.booleans(),
        ),
        min_size=1,
        max_size=12,
    ),
    heal=st.sampled_from([None, 0.0, 1e-5, 3e-4, 2e-3]),
)
def test_any_lines_are_a_sheet_or_refused(strokes: Any, heal: float | None) -> None:
    """Masses come to no more than what lies within the box around all lines."""
    drawn = [line(*points, role=role, closed=closed) for points, role, closed in strokes]
    try:
        made, _ = read(*drawn, heal=heal)
    except lamc.DesignError:
        return
    places = np.concatenate([stroke.points for stroke in drawn])
    # An end moves by twice the tolerance at most; a billionth for rounding of sums.
    box = np.ptp(places, axis=0) + 4.0 * (heal if heal is not None else 1e-6)
    assert 0.0 < sum(body.mass for body in made.bodies) <= 0.3 * 0.7 * box[0] * box[1] * (1.0 + 1e-9)


def test_mends_are_in_tables_and_pictures(tmp_path: Any) -> None:
    dots = [square(1.0 + i, 5, 1e-3, source=f"rect #dot{i}") for i in range(25)]
    made, told = read(square(0, 0, 40), HINGE, *dots)
    assert sum("stray mark: 25" in each for each in told) == 1
    text = split_text(made)
    assert "stray mark" in text
    assert "rect #dot0\n" in text
    assert "… and 5 more (--json has all)" in text
    found = split_data(made)["mends"]
    assert isinstance(found, list)
    assert len(found) == 25
    assert found[0] == {
        "what": "stray mark",
        "at": pytest.approx([1e-3, 5e-3]),
        "moved": pytest.approx(1.414e-6, rel=1e-3),
        "source": "rect #dot0",
    }
    assert [entry.get_label() for entry in mend_entry(made.mends)] == ["drawing healed here (25)"]
    assert mend_entry(()) == []
    ringed = draw_bodies(made, {}, tmp_path / "ringed.png").read_bytes()
    assert ringed != draw_bodies(replace(made, mends=()), {}, tmp_path / "plain.png").read_bytes()


def test_a_tolerance_in_metres_by_mistake_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "sheet.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="20mm" viewBox="0 0 40 20" fill="none">'
        '<rect width="40" height="20" stroke="#000"/><path d="M20 0V20" stroke="#f00" opacity="0.5"/></svg>'
    )
    with pytest.raises(DesignError, match="200 mm, and the drawing 40 mm wide: it must be at most 2 mm"):
        lamc.load(path, heal=0.2)


@pytest.mark.parametrize("missing", [2.0, 20.0, 40.0])
def test_cuts_that_are_the_outline_are_refused_where_one_is_missing(missing: float) -> None:
    """The facet beside it had been lost, as of a border."""
    creases = [line((15, 0), (15, 40)), line((25, 0), (25, 40))]
    path = [(0.0, 0.0), (40.0, 0.0), (40.0, 40.0), (0.0, 40.0), (0.0, missing)]
    with pytest.raises(lamc.DesignError, match=r"outline is open: path #rim .cut. ends at "):
        read(line(*path, role="cut", source="path #rim"), *creases)
    made, _ = read(line(*path, role="cut"), line((0, missing), (0, 0), role="cut"), *creases)
    assert len(made.bodies) == 3


def test_an_outline_that_goes_on_from_a_crease_that_is_the_rim_is_open() -> None:
    """Where the other end of what is missing is that crease's own."""
    sides = [((10, 10), (90, 10)), ((90, 10), (90, 30)), ((10, 50), (10, 10)), ((10, 50), (50, 50))]
    rim = [line(*side, role="border", source="path #rim") for side in sides]
    with pytest.raises(lamc.DesignError, match="outline is open: path #rim"):
        read(*rim, line((30, 10), (30, 50)), line((50, 10), (50, 50)))


def test_a_line_over_the_corner_of_a_rim_that_ends_in_a_crease_is_no_open_outline() -> None:
    sides = line((0, 0), (40, 0), (40, 40), (0, 40), role="border")
    last, over = line((0, 40), (0, 0)), line((0, 0), (-4, -4), role="border")
    made, told = read(sides, last, over, line((15, 0), (15, 40)))
    assert len(made.bodies) == 2
    assert "line that bounds nothing" in " ".join(told)


@pytest.mark.parametrize("beyond", [0.0, 2.0])
def test_a_crease_that_runs_over_into_a_relief_leaves_a_notch(beyond: float) -> None:
    """Its end within the relief, beyond the rim, had made that material."""
    made, _ = read(square(0, 0, 40), line((20, -beyond), (20, 40)), square(19, -1, 2, role="cut"))
    assert sum(body.mass for body in made.bodies) / SQUARE_MM == pytest.approx(1600.0, rel=1e-12)
    assert len(made.joints) == 2  # the crease, and its piece amid the relief

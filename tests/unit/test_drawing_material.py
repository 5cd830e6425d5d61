"""Material from outlines that touch one another, by areas on a grid of cells or in closed form."""

import itertools
import math
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lamc.readers.drawings.heal import OUTLINES, healed
from lamc.readers.drawings.material import Material, material_of
from lamc.readers.drawings.outlines import hull, parting
from lamc.records.drawing import Role, Stroke

Corners = list[tuple[float, float]]


def closed(points: Corners, role: Role = "border") -> Stroke:
    return Stroke(np.array(points, dtype=float), True, role)


def line(*points: tuple[float, float], role: Role = "border") -> Stroke:
    return Stroke(np.array(points, dtype=float), False, role)


def box(x0: float, y0: float, x1: float, y1: float, role: Role = "border") -> Stroke:
    return closed([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], role)


def circle(x: float, y: float, radius: float, role: Role = "border") -> Stroke:
    turns = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    return closed([(x + radius * math.cos(a), y + radius * math.sin(a)) for a in turns], role)


def lines_of(stroke: Stroke) -> list[Stroke]:
    """The same outline by lines, none of them closed, as DXF has it."""
    points = [tuple(p) for p in stroke.points.tolist()]
    return [line(a, b, role=stroke.role) for a, b in itertools.pairwise([*points, points[0]])]


def material(*strokes: Stroke) -> Material:
    graph = healed(strokes, 0.0)
    return material_of(graph, strokes, parting(graph.points, graph.edges), OUTLINES)


PLATE = box(0, 0, 60, 20)
DIAMOND = closed([(50, 0), (55, 10), (50, 20), (45, 10)])
SLIT_DIAMOND = closed([(50, 5), (55, 10), (50, 15), (45, 10)])  # 50 mm²
SLITS = [line((50, 0), (50, 5)), line((50, 15), (50, 20))]


@pytest.mark.parametrize("by_lines", [False, True])
def test_a_window_that_touches_the_rim_twice_is_a_window(by_lines: bool) -> None:
    strokes = [PLATE, *(lines_of(DIAMOND) if by_lines else [DIAMOND])]
    assert material(*strokes).region.area == pytest.approx(1100.0, rel=1e-12)


def test_lines_from_a_window_to_the_rim_do_not_fill_it() -> None:
    found = material(PLATE, SLIT_DIAMOND, *SLITS)
    assert found.region.area == pytest.approx(1150.0, rel=1e-12)
    assert len(found.within) == 2  # and are told: they have no width


def test_a_line_across_parts_nothing_and_is_told() -> None:
    found = material(PLATE, line((40, 0), (40, 20)))
    assert found.region.area == pytest.approx(1200.0, rel=1e-12)
    assert len(found.region.geoms) == 1
    assert len(found.within) == 1


@pytest.mark.parametrize("role", ["hole", "border"])
@pytest.mark.parametrize("by_lines", [False, True])
def test_a_notch_with_a_side_on_the_rim_is_taken_away(role: Role, by_lines: bool) -> None:
    notch = box(50, 5, 60, 15, role)
    found = material(PLATE, *(lines_of(notch) if by_lines else [notch]))
    assert found.region.area == pytest.approx(1100.0, rel=1e-12)
    assert not found.within


def test_a_hole_beyond_the_rim_is_taken_away_where_material_is() -> None:
    assert material(PLATE, box(50, 5, 70, 15, "hole")).region.area == pytest.approx(1100.0, rel=1e-12)
    assert material(PLATE, circle(60, 10, 5, "hole")).region.area == pytest.approx(
        1200.0 - 0.5 * material(circle(0, 0, 5)).region.area, rel=1e-9
    )


def test_tiles_are_material_whether_each_is_closed_or_shares_a_side() -> None:
    first, second = box(0, 0, 20, 20), box(20, 0, 60, 20)
    shared = line((20, 0), (60, 0), (60, 20), (20, 20))
    for tiles in ([first, second], [first, shared]):
        region = material(*tiles).region
        assert region.area == pytest.approx(1200.0, rel=1e-12)
        assert len(region.geoms) == 1


def test_a_rim_in_pieces_has_windows_too() -> None:
    """Lines that are broken where another one ends, as CAD does, are no ring; a window within them is one."""
    rim = [line((0, 0), (40, 0), (60, 0)), line((60, 0), (60, 20), (40, 20)), line((40, 20), (0, 20), (0, 0))]
    across = line((40, 0), (40, 20))
    broken = [line((0, 0), (40, 0)), line((40, 0), (60, 0)), *rim[1:]]
    for window in (box(10, 5, 20, 15), closed([(10, 0), (15, 10), (10, 20), (5, 10)])):
        found = material(*broken, across, window)
        assert found.region.area == pytest.approx(1100.0, rel=1e-12)
        assert found.within


def test_outlines_that_cross_are_one() -> None:
    first, second = box(0, 0, 40, 20), box(30, 10, 60, 30)
    assert material(first, second).region.area == pytest.approx(800.0 + 600.0 - 100.0, rel=1e-12)
    window = box(32, 12, 38, 18)  # in both
    assert material(first, second, window).region.area == pytest.approx(1300.0 - 36.0, rel=1e-12)


def test_a_piece_in_a_hole_is_material_and_a_hole_in_a_window_is_none() -> None:
    island = box(14, 4, 26, 16)
    assert material(PLATE, box(10, 2, 30, 18, "hole"), island).region.area == pytest.approx(1200 - 320 + 144)
    assert material(PLATE, box(10, 2, 30, 18), box(14, 4, 26, 16, "hole")).region.area == pytest.approx(880.0)


def test_an_outline_drawn_twice_counts_once() -> None:
    assert material(PLATE, PLATE, *lines_of(PLATE)).region.area == pytest.approx(1200.0, rel=1e-12)
    assert material(PLATE, SLIT_DIAMOND, SLIT_DIAMOND).region.area == pytest.approx(1150.0, rel=1e-12)


def test_outlines_that_cross_are_one_whatever_lies_elsewhere() -> None:
    """Which of two counts more faces is no matter: windows in one of them had made a third outline a window."""
    first, second, third = box(0, 0, 30, 35), box(20, 5, 50, 25), box(10, 8, 25, 20)
    windows = [box(40 + 3 * k, 10, 41 + 3 * k, 11) for k in range(3)]
    assert material(first, second, third).region.area == pytest.approx(1450.0, rel=1e-12)
    assert material(first, second, third, *windows).region.area == pytest.approx(1447.0, rel=1e-12)


@pytest.mark.parametrize("by_lines", [False, True])
def test_outlines_by_lines_are_those_of_closed_ones(by_lines: bool) -> None:
    """Lines that follow one another are an outline, though those of another one end at its corners."""

    def drawn(*outlines: Stroke) -> float:
        strokes = [line for each in outlines for line in lines_of(each)] if by_lines else list(outlines)
        return float(material(*strokes).region.area)

    assert drawn(PLATE, box(10, 5, 40, 15), box(10, 5, 20, 10)) == pytest.approx(950.0, rel=1e-12)
    assert drawn(PLATE, box(50, 10, 60, 20)) == pytest.approx(1100.0, rel=1e-12)
    turned = lines_of(box(50, 10, 60, 20))
    turned = [Stroke(each.points[:: (-1) ** k], False, each.role) for k, each in enumerate(turned)]
    assert material(PLATE, *turned).region.area == pytest.approx(1100.0, rel=1e-12)


NOTCH = box(50, 5, 60, 15)


@pytest.mark.parametrize(
    "more",
    [
        [line((0, 0), (60, 0))],  # doubled
        [line((0, 0), (1e-6, 0))],  # dust
        [line((40, 0), (40, 20))],  # across
        [line((-5, 10), (0, 10))],  # ends on the rim
    ],
)
@pytest.mark.parametrize("by_lines", [False, True])
def test_other_lines_on_the_rim_fill_no_notch(more: list[Stroke], by_lines: bool) -> None:
    rim = lines_of(PLATE) if by_lines else [PLATE]
    for strokes in ([*more, *rim, NOTCH], [*rim, NOTCH, *more], [*rim, *more, *lines_of(NOTCH)]):
        graph = healed(strokes, 1e-3)
        found = material_of(graph, strokes, parting(graph.points, graph.edges), OUTLINES)
        assert found.region.area == pytest.approx(1100.0, rel=1e-6)  # dust is joined at one of its ends


def test_a_notch_stays_one_where_lines_of_the_rim_run_past_its_corners() -> None:
    rim = [line((-0.3, 0), (60.3, 0)), line((60, -0.3), (60, 20.3)), line((60.3, 20), (-0.3, 20))]
    strokes = [*rim, line((0, 20.3), (0, -0.3)), NOTCH]
    graph = healed(strokes, 0.5)
    found = material_of(graph, strokes, parting(graph.points, graph.edges), OUTLINES)
    assert found.region.area == pytest.approx(1100.0, rel=1e-12)


def test_a_piece_in_a_hole_is_material_however_often_the_hole_is_drawn() -> None:
    hole, island = box(10, 2, 30, 18, "hole"), box(14, 4, 26, 16)
    for more in ([hole], lines_of(hole), [box(11, 2.5, 29.5, 17, "hole")]):
        assert material(PLATE, hole, *more, island).region.area == pytest.approx(1200 - 320 + 144, rel=1e-12)
    halves = [box(10, 2, 20, 18, "hole"), box(20, 2, 30, 18, "hole")]
    assert material(PLATE, *halves, island).region.area == pytest.approx(1200 - 320 + 144, rel=1e-12)


def test_lines_between_windows_take_nothing_away() -> None:
    windows = [box(10, 5, 20, 15), box(30, 5, 40, 15)]
    found = material(PLATE, *windows, line((20, 7), (30, 7)), line((20, 13), (30, 13)))
    assert found.region.area == pytest.approx(1000.0, rel=1e-12)
    assert len(found.within) == 2
    beside = line((20, 7), (26, 7), (26, 13), (20, 13))
    assert material(PLATE, windows[0], beside).region.area == pytest.approx(1100.0, rel=1e-12)


def test_an_outline_that_crosses_itself_is_told_of_no_line_within_it() -> None:
    found = material(closed([(0, 0), (20, 20), (20, 0), (0, 20)]))
    assert found.region.area == pytest.approx(200.0, rel=1e-12)
    assert not found.within
    turns = np.linspace(0.0, 4.0 * np.pi, 200, endpoint=False)
    twice = closed([(10 * math.cos(a), 10 * math.sin(a)) for a in turns])
    assert not material(twice).within


def test_tiles_that_fill_a_frame_leave_nothing() -> None:
    """Each is a window of the frame: `shape_of` refuses it."""
    assert material(PLATE, box(0, 0, 30, 20), box(30, 0, 60, 20)).region.is_empty


@pytest.mark.parametrize("seed", range(40))
def test_boxes_within_boxes_count_by_turns(seed: int) -> None:
    """Boxes on a grid, each within another or beside it, that touch at corners and share sides; by lines or closed."""
    source = random.Random(seed)
    boxes: list[tuple[int, int, int, int]] = []

    def fill(x0: int, y0: int, x1: int, y1: int, depth: int) -> None:
        boxes.append((x0, y0, x1, y1))
        if depth == 4 or x1 - x0 < 3 or y1 - y0 < 3:
            return
        middle = source.randint(x0 + 1, x1 - 1)
        for left, right in ((x0, middle), (middle, x1)):
            a, b = sorted(source.sample(range(left, right + 1), 2))
            c, d = sorted(source.sample(range(y0, y1 + 1), 2))
            if (a, c, b, d) != (x0, y0, x1, y1) and source.random() < 0.8:
                fill(a, c, b, d, depth + 1)

    fill(0, 0, 12, 12, 0)
    depth = np.zeros((12, 12), dtype=int)
    for x0, y0, x1, y1 in boxes:
        depth[x0:x1, y0:y1] += 1
    strokes = [box(*each) for each in boxes]
    source.shuffle(strokes)
    assert material(*strokes).region.area == pytest.approx(np.count_nonzero(depth % 2), rel=1e-12)


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=2, max_size=6),
            st.booleans(),
            st.sampled_from(["border", "hole"]),
        ),
        min_size=1,
        max_size=8,
    ),
    st.sampled_from([0.0, 1e-3, 0.3]),
)
def test_any_lines_have_material_within_their_hull(
    drawn: list[tuple[list[tuple[int, int]], bool, Role]], tolerance: float
) -> None:
    """Lines over one another, crossing themselves, of no length: no error, and nothing beyond what they enclose."""
    strokes = [Stroke(np.array(points, dtype=float), is_closed, role) for points, is_closed, role in drawn]
    graph = healed(strokes, tolerance)
    kept = parting(graph.points, graph.edges)
    found = material_of(graph, strokes, kept, OUTLINES)
    whole = hull(graph.points, [graph.edges[k] for k in kept])
    assert found.region.is_valid
    assert found.region.area <= whole.area * (1.0 + 1e-9)  # round-off of unions of some dozen faces
    assert set(found.within) <= set(kept)

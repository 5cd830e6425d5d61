"""Healing: defects put into drawings at random places; what was mended is the clean sheet, and each mend is told."""

import math
import time
import warnings
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import DesignWarning
from lamc.readers.drawings.heal import healed
from lamc.readers.drawings.sheet import sheet_of
from lamc.records.card import SheetOptions
from lamc.records.drawing import Stroke
from lamc.records.mechanism import Mechanism
from tests.support import fold_corpus as corpus
from tests.support.drawn_corpus import drawing, line, of_fold, square
from tests.support.quick import tries

HEAL = 5e-5  # m; the patterns' shortest lines are 18 mm long
OPTIONS = SheetOptions(card=lamc.Card(thickness=1e-3, density=1e3), crease=1e-3, heal=HEAL)
PATTERNS = [
    of_fold(corpus.miura(4, 3)),
    of_fold(corpus.waterbomb()),
    of_fold(corpus.yoshimura(3, 4)),
    of_fold(corpus.box_net(), 1e-2),
]
Strokes = list[Stroke]


def sheet(strokes: Sequence[Stroke], options: SheetOptions = OPTIONS) -> Mechanism:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        return sheet_of(drawing(*strokes), options)


CLEAN = [sheet(strokes) for strokes in PATTERNS]


def areas(made: Mechanism) -> list[float]:
    """m², ascending."""
    return sorted(body.mass for body in made.bodies)  # 1 kg/m²


def same(made: Mechanism, clean: Mechanism, off: float) -> None:
    """As many facets and hinges; off: m, how far places may be from the clean sheet's."""
    assert (len(made.bodies), len(made.joints)) == (len(clean.bodies), len(clean.joints))
    # A facet's rim is at most 0.2 m long, and moves by `off`; 1e-9 of 1e-3 m^2 is rounding of sums.
    assert areas(made) == pytest.approx(areas(clean), abs=0.2 * off + 1e-12)
    lengths = [sorted(joint.stiffness / 1e-3 for joint in m.joints) for m in (made, clean)]
    assert lengths[0] == pytest.approx(lengths[1], abs=2.0 * off + 1e-12)


def like(stroke: Stroke, points: np.ndarray, note: str = "") -> Stroke:
    return Stroke(np.asarray(points), False, stroke.role, stroke.angle, stroke.layer, stroke.source + note)


def unit(stroke: Stroke) -> np.ndarray:
    along = stroke.points[1] - stroke.points[0]
    return np.asarray(along / np.linalg.norm(along))


def jittered(strokes: Strokes, k: int, at: float, angle: float) -> Strokes:
    """One end is off, by less than half of the tolerance."""
    points = strokes[k].points.copy()
    points[int(2 * at)] += 0.45 * HEAL * np.array([math.cos(angle), math.sin(angle)])
    return [*strokes[:k], like(strokes[k], points), *strokes[k + 1 :]]


def doubled(strokes: Strokes, k: int, at: float, angle: float) -> Strokes:
    """A part of a line once more, the other way round."""
    a, b = strokes[k].points
    part = np.array([b, a + at * (b - a)]) if angle < 3.0 else strokes[k].points[::-1]
    return [*strokes, like(strokes[k], part, " again")]


def beside(strokes: Strokes, k: int, at: float, angle: float) -> Strokes:
    """A line once more, a fifth of the tolerance aside."""
    aside = 0.2 * HEAL * np.array([-unit(strokes[k])[1], unit(strokes[k])[0]])
    return [*strokes, like(strokes[k], strokes[k].points + aside, " again")]


def broken(strokes: Strokes, k: int, at: float, angle: float) -> Strokes:
    """A gap in a line."""
    a, b = strokes[k].points
    middle = a + (0.1 + 0.8 * at) * (b - a)
    gap = 0.45 * HEAL * unit(strokes[k])
    pieces = [
        like(strokes[k], np.array(p), n)
        for p, n in (((a, middle - gap), " left"), ((middle + gap, b), " right"))
    ]
    return [*strokes[:k], *pieces, *strokes[k + 1 :]]


def short(strokes: Strokes, k: int, at: float, angle: float) -> Strokes:
    """A line that stops short of where it ends, or runs past it."""
    a, b = strokes[k].points
    by = (0.9 if angle < 3.0 else -0.9) * at * HEAL * unit(strokes[k])
    return [*strokes[:k], like(strokes[k], np.array([a, b - by])), *strokes[k + 1 :]]


def marked(strokes: Strokes, k: int, at: float, angle: float) -> Strokes:
    """A short stray line on a line, or amid a facet."""
    a, b = strokes[k].points
    start = a + (0.1 + 0.8 * at) * (b - a)
    step = 0.8 * HEAL * np.array([math.cos(angle), math.sin(angle)])
    return [*strokes, like(strokes[k], np.array([start, start + step]), " mark")]


def parted(strokes: Strokes, k: int, at: float, angle: float) -> Strokes:
    """A line in two pieces that overlap."""
    a, b = strokes[k].points
    p, q = a + 0.3 * (b - a), a + (0.4 + 0.5 * at) * (b - a)
    pieces = [like(strokes[k], np.array(each), n) for each, n in (((a, q), " left"), ((b, p), " right"))]
    return [*strokes[:k], *pieces, *strokes[k + 1 :]]


DEFECTS = [jittered, doubled, beside, broken, short, marked, parted]
EXACT = [doubled, parted]  # nothing moves


@pytest.mark.parametrize("defect", DEFECTS)
@settings(max_examples=tries(25), deadline=None)
@given(
    pattern=st.integers(0, len(PATTERNS) - 1),
    which=st.integers(0, 1000),
    at=st.floats(0.05, 0.95),
    angle=st.floats(0.0, 6.28),
)
@pytest.mark.quick("doubled", "jittered", "parted", others="campaign")
def test_a_defect_is_mended_and_told(defect, pattern: int, which: int, at: float, angle: float) -> None:
    strokes = PATTERNS[pattern]
    made = sheet(defect(strokes, which % len(strokes), at, angle))
    same(made, CLEAN[pattern], 0.0 if defect in EXACT else HEAL)
    assert made.mends
    source = strokes[which % len(strokes)].source
    assert any(source in mend.source for mend in made.mends)
    assert all(mend.moved <= 2.0 * HEAL for mend in made.mends)


@settings(max_examples=tries(40), deadline=None)
@given(
    pattern=st.integers(0, len(PATTERNS) - 1),
    found=st.lists(
        st.tuples(
            st.sampled_from(DEFECTS), st.integers(0, 1000), st.floats(0.05, 0.95), st.floats(0.0, 6.28)
        ),
        min_size=1,
        max_size=8,
    ),
)
def test_many_defects_are_mended(pattern: int, found) -> None:
    strokes = PATTERNS[pattern]
    for defect, which, at, angle in found:
        if (
            len(strokes[which % len(strokes)].points) == 2
            and np.linalg.norm(np.ptp(strokes[which % len(strokes)].points, axis=0)) > 2e-3
        ):
            strokes = defect(strokes, which % len(strokes), at, angle)
    # Several defects at one end add up to a gap of a few times each.
    made = sheet(strokes, replace(OPTIONS, heal=4.0 * HEAL))
    clean = CLEAN[pattern]
    assert (len(made.bodies), len(made.joints)) == (len(clean.bodies), len(clean.joints))


def test_a_crease_in_two_pieces_that_meet_at_an_angle_is_one_hinge() -> None:
    """By 2e-3 rad, as an end that was off is joined: no vertex at which rigid facets stay flat."""
    strokes = broken(jittered(PATTERNS[3], 4, 0.5, 1.0), 4, 0.5, 0.0)
    made = sheet(strokes, replace(OPTIONS, heal=4.0 * HEAL))
    assert (len(made.bodies), len(made.joints)) == (len(CLEAN[3].bodies), len(CLEAN[3].joints))


@settings(max_examples=tries(20), deadline=None)
@given(order=st.permutations(range(17)), seed=st.integers(0, 100))
def test_the_order_of_lines_changes_nothing(order, seed: int) -> None:
    rng = np.random.default_rng(seed)
    strokes = [like(s, s.points + rng.uniform(-0.3, 0.3, (2, 2)) * HEAL) for s in of_fold(corpus.miura(2, 2))]
    order = [k for k in order if k < len(strokes)]
    order += sorted(set(range(len(strokes))) - set(order))
    turned = [like(strokes[k], strokes[k].points[:: 1 - 2 * (k % 2)]) for k in order]
    first, second = (healed(each, HEAL) for each in (strokes, turned))
    assert np.array_equal(first.points, second.points)
    assert first.edges == second.edges
    assert [strokes[k].source for k in first.strokes] == [turned[k].source for k in second.strokes]


def test_long_lines_that_cross_are_parted_and_nothing_is_told() -> None:
    lines = [line((10.0 * i, 0), (10.0 * i, 40)) for i in (1, 2, 3)]
    lines += [line((0, 10.0 * i), (40, 10.0 * i)) for i in (1, 2, 3)]
    graph = healed([square(0, 0, 40), *lines], HEAL)
    assert (len(graph.points), len(graph.edges), graph.mends) == (25, 40, ())


def test_three_lines_through_nearly_one_place_meet_there() -> None:
    star = [line((-20, 0), (20, 0)), line((-20, -20), (20, 20)), line((-20, 20.03), (20, -19.97))]
    graph = healed(star, HEAL)
    assert len(graph.edges) == 6
    assert {mend.what for mend in graph.mends} <= {"crossings joined", "T-junction"}
    assert graph.mends


def test_nothing_is_mended_with_zero() -> None:
    strokes = PATTERNS[0]
    off = jittered(strokes, 0, 0.0, 1.0)
    assert healed(off, 0.0).mends == ()
    assert healed(strokes, 0.0).points.tolist() == healed(strokes, HEAL).points.tolist()


def test_of_two_lines_the_border_counts_then_the_cut_then_the_crease() -> None:
    for first, second in (("border", "cut"), ("cut", "hinge"), ("border", "valley"), ("mountain", "hinge")):
        pair = [line((0, 0), (10, 0), role=second, source="b"), line((0, 0), (10, 0), role=first, source="a")]
        for strokes in (pair, pair[::-1]):
            graph = healed(strokes, HEAL)
            assert [strokes[k].source for k in graph.strokes] == ["a"]
            assert f"{first} counts, not {second}" in graph.mends[0].source


def test_curves_finer_than_the_tolerance_stay_as_they_are() -> None:
    turns = np.linspace(0.0, 2.0 * math.pi, 2000, endpoint=False)
    circle = 10.0 * np.column_stack([np.cos(turns), np.sin(turns)])
    graph = healed([line(*circle, role="border", closed=True), line((-10, 0), (10, 0))], HEAL)
    assert len(graph.edges) == 2001
    assert graph.mends == ()


def test_ends_that_fall_short_of_a_corner_are_drawn_on_to_it() -> None:
    corner = [line((0, 0), (9.98, 0)), line((10, 10), (10, 0.02))]
    graph = healed(corner, HEAL)
    assert graph.points[1] == pytest.approx([1e-2, 0.0], abs=1e-15)


@pytest.mark.parametrize("over", [0.01, 0.03, 0.2])
def test_the_end_of_a_curve_beyond_the_corner_that_others_join_is_cut_back(over: float) -> None:
    """Its last corner has more lines than their single ends, and its own end joins no other point of it. By more than
    the tolerance it is no mend, and a piece that parts nothing."""
    ends = [line((0, 20), (19.99, 20), source="left"), line((20, 0), (20, 19.98), source="below")]
    curve = line((20, 40), (20.2, 30), (20, 20), (20 + over, 20 - 0.1 * over), source="curve")
    for strokes in ([square(0, 0, 40), *ends, curve], [curve, *ends[::-1], square(0, 0, 40)]):
        graph = healed(strokes, HEAL)
        loose = (np.bincount(np.array(graph.edges).ravel()) == 1).sum()
        back = [mend for mend in graph.mends if mend.what == "hinge cut back"]
        assert loose == (1 if 1e-3 * over > HEAL else 0)
        assert [mend.source for mend in back] == ([] if loose else ["curve"])
        assert all(mend.moved == pytest.approx(1e-3 * np.hypot(over, 0.1 * over)) for mend in back)
        enclosed = shapely.polygonize(shapely.linestrings(graph.points[np.array(graph.edges)]))
        assert len(enclosed.geoms) == 3


@pytest.mark.parametrize("degrees", [40, 60, 90, 120, 150])
def test_an_end_beside_a_corner_joins_the_rim_and_leaves_the_corner(degrees: int) -> None:
    """Within the tolerance of one edge of it or of both, and farther from the corner, so that it cannot join that: the
    rim is what it was but for the tolerance, and in two parts."""
    random = np.random.default_rng(degrees)
    one, other = (
        np.array([1.0, 0.0]),
        np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))]),
    )
    corners = 40.0 * np.array([0.0 * one, one, one + other, other])
    rim = shapely.Polygon(corners)
    tried = 0
    while tried < 30:
        end = random.uniform(-1.5e3, 1.5e3, 2) * HEAL
        dot, far = shapely.Point(end), float(np.linalg.norm(end))
        beside = rim.contains(dot) and rim.exterior.distance(dot) < 0.999e3 * HEAL
        if not beside or far < 1.001e3 * HEAL:
            continue
        share = random.uniform(0.1, 0.9)
        goal = 40.0 * (other + share * one if random.random() < 0.5 else one + share * other)
        graph = healed([line(*corners, role="border", closed=True, source="rim"), line(end, goal)], HEAL)
        assert np.bincount(np.array(graph.edges).ravel()).min() == 2
        facets = shapely.polygonize(shapely.linestrings(1e3 * graph.points[np.array(graph.edges)]))
        assert len(facets.geoms) == 2
        whole = shapely.union_all(facets.geoms)
        assert shapely.hausdorff_distance(whole.exterior, rim.exterior) < 1.001e3 * HEAL
        if degrees <= 120:  # beside a blunt one a line may go along the rim, and take its corner
            assert np.abs(graph.points).sum(axis=1).min() < 1e-9
            assert not any(mend.source.startswith("rim") for mend in graph.mends)
        tried += 1


def test_dots_are_stray_and_told() -> None:
    made = sheet([square(0, 0, 40), line((20, 0), (20, 40)), square(5, 5, 0.01, source="rect #dot")])
    assert [(m.what, m.source) for m in made.mends] == [("stray mark", "rect #dot")]
    assert len(made.bodies) == 2


def test_five_thousand_lines_are_healed_in_a_second_or_so() -> None:
    rng = np.random.default_rng(1)
    strokes = [
        like(s, s.points + rng.uniform(-0.3, 0.3, (2, 2)) * HEAL) for s in of_fold(corpus.miura(50, 50))
    ]
    start = time.perf_counter()
    graph = healed(strokes, HEAL)
    # 0.5 s on a quiet machine: a square law would be a minute.
    assert time.perf_counter() - start < 10.0
    assert (len(graph.points), len(graph.edges)) == (51 * 51, 2 * 50 * 51)


@pytest.mark.slow
def test_more_lines_than_are_read_are_refused() -> None:
    many = Stroke(np.random.default_rng(0).uniform(size=(100_001, 2)), False, "hinge")
    with pytest.raises(lamc.DesignError, match="more than 100000 lines"):
        healed([many], HEAL)
    comb = [line((i, -1), (i, 1000)) for i in range(500)] + [line((-1, i), (1000, i)) for i in range(500)]
    with pytest.raises(lamc.DesignError, match="more than 100000 lines"):
        healed(comb, HEAL)


def test_lines_over_one_another_in_a_heap_are_refused_before_memory_is_full(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of a heap each end lies on each line: as many pairs as the square of them."""
    monkeypatch.setattr("lamc.readers.drawings.geometry.MOST_NEAR", 10_000)
    heap = [line((0, 1e-6 * k), (100, 1e-6 * k)) for k in range(150)]
    with pytest.raises(lamc.DesignError, match="more than 10000 ends and lines lie within"):
        healed(heap, HEAL)


@pytest.mark.slow
def test_lines_traced_twice_are_counted_once() -> None:
    """They are one, where they are as near as round-off; their crossings would be four times as many."""
    ways = [line((k, -1), (k, 200)) for k in range(160)] + [line((-1, k), (200, k)) for k in range(160)]
    traced = [Stroke(each.points + 1e-14, False, each.role) for each in ways]
    assert len(healed([*ways, *traced], 0.0).edges) == len(healed(ways, 0.0).edges)


def test_lines_drawn_again_and_again_are_one() -> None:
    """They do not cross, which of lines that are the same takes long to tell."""
    again = [line((0, 0), (100, 0)), line((100, 0), (0, 0))] * 60
    assert len(healed([*again, line((50, -100), (50, 100))], HEAL).edges) == 4


@pytest.mark.parametrize("count", [1, 2, 7, 40])
def test_outlines_within_one_another_are_material_and_windows_by_turns(count: int) -> None:
    """Each ring is a body of its own, as wide as those around it leave."""
    rings = [square(k, k, 100 - 2 * k) for k in range(count)]
    made = sheet(rings)
    sides = [100.0 - 2.0 * k for k in range(count)] + [0.0] * (count % 2)
    wanted = sorted(1e-6 * (a * a - b * b) for a, b in zip(sides[::2], sides[1::2], strict=True))
    assert areas(made) == pytest.approx(wanted, rel=1e-9)

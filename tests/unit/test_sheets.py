"""Sheets of many facets, whole and faulty: what splitting makes of them, and what it says where it cannot."""

import ast
import re
from collections import Counter

import pytest

from lamc.basics.errors import DesignError, TopologyError
from lamc.design.split import split
from lamc.examples.miura import _corner, miura
from lamc.loops.cycles import Kind, short_cycles
from lamc.mechanism.plan import plan
from lamc.readers.inert import Limits
from lamc.readers.load import load_text
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism

Points = list[list[float]]


def made(text: str) -> Mechanism:
    design = load_text(text, "sheet.yaml")
    assert isinstance(design, Design)
    return split(design)


def line_of(name: str, text: str) -> str:
    """The file's line that draws a hinge."""
    return next(line for line in text.splitlines(keepends=True) if f"name: {name}, line" in line)


def points_of(name: str, text: str) -> Points:
    found = re.search(r"line: (\[\[.*?\]\])", line_of(name, text))
    assert found is not None
    return ast.literal_eval(found[1])  # type: ignore[no-any-return]


def with_line(name: str, points: Points, text: str) -> str:
    return text.replace("hinges:\n", f"hinges:\n  - {{name: {name}, line: {points}, gap: 1}}\n", 1)


def moved(name: str, points: Points, text: str) -> str:
    line = line_of(name, text)
    return text.replace(line, re.sub(r"line: \[\[.*?\]\]", f"line: {points}", line))


def without_names(text: str) -> str:
    return re.sub(r"  f\d+_\d+: .*\n", "", text).replace("bodies:\n", "")


def with_a_hole(columns: int, rows: int, at: tuple[int, int]) -> str:
    """A Miura-ori with a facet missing, film, card and creases."""
    i, j = at
    text = miura(columns, rows)
    cards = [line for line in text.splitlines(keepends=True) if "layers: [lower, upper]" in line]
    gone = [line_of(name, text) for name in (f"z{i}_{j}", f"z{i + 1}_{j}", f"s{i}_{j}", f"s{i}_{j + 1}")]
    for line in (cards[i * rows + j], *gone, next(re.finditer(rf"  f{i}_{j}: .*\n", text))[0]):
        text = text.replace(line, "", 1)
    corners = [list(_corner(*each)) for each in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
    cut = f"  - {{cut: {{polygon: {corners}}}, layers: film}}\n"
    return text.replace("layers: film}\n", "layers: film}\n" + cut, 1)


@pytest.mark.parametrize("size", [8, pytest.param(32, marks=pytest.mark.campaign)])
def test_a_sheet_has_a_body_a_facet_and_a_cycle_a_vertex(size: int) -> None:
    """32 x 32 facets: the strips of 1984 hinges meet 5766 times, which used to be refused."""
    mechanism = made(miura(size, size))
    assert len(mechanism.bodies) == size * size
    assert len(mechanism.joints) == 2 * size * (size - 1)
    cycles = short_cycles(plan(mechanism))
    assert Counter((cycle.kind, len(cycle.joints)) for cycle in cycles) == {
        (Kind.SPHERICAL, 4): (size - 1) ** 2
    }


def test_a_missing_facet_is_a_cycle_around_it() -> None:
    """Of 16 vertices of 5 x 5 facets the four about the hole are gone; eight creases lead around it."""
    mechanism = made(with_a_hole(5, 5, (2, 2)))
    assert len(mechanism.bodies) == 24
    cycles = short_cycles(plan(mechanism))
    assert Counter((cycle.kind, len(cycle.joints)) for cycle in cycles) == {
        (Kind.SPHERICAL, 4): 12,
        (Kind.SPATIAL, 8): 1,
    }


def test_a_crease_at_the_rim_of_a_hole_is_refused() -> None:
    text = with_line("z2_2", points_of("z2_2", miura(5, 5)), with_a_hole(5, 5, (2, 2)))
    with pytest.raises(
        TopologyError, match=r"sheet.yaml:\d+:.*'z2_2'.*touches 1 body.*material on its left only"
    ):
        made(text)


@pytest.mark.parametrize("turned", [False, True])
def test_a_crease_drawn_twice_is_refused(turned: bool) -> None:
    text = miura(3, 3)
    points = points_of("z1_1", text)
    with pytest.raises(
        DesignError, match=r"sheet.yaml:\d+:.*'z1_1' and hinge 'again' are drawn on the same line"
    ):
        made(with_line("again", points[::-1] if turned else points, text))


@pytest.mark.parametrize("apart", [0.001, 0.3])
def test_a_crease_drawn_almost_twice_is_told_so(apart: float) -> None:
    """Both are swallowed by the hole that they make together; the message used to name their neighbours alone."""
    text = miura(3, 3)
    again = [[x + apart, y] for x, y in points_of("z1_1", text)]
    with pytest.raises(
        TopologyError, match=r"meets hinge '(again|z1_1)' swallow it.*over 25 mm they are.*keep one"
    ):
        made(with_line("again", again, text))


def test_a_crease_along_two_others_is_told_so() -> None:
    text = miura(3, 3)
    along = [points_of("s0_1", text)[0], points_of("s1_1", text)[1]]
    with pytest.raises(TopologyError, match=r"'s0_1'.* meets hinge 'long' .*over 30 mm.*drawn twice"):
        made(with_line("long", along, text))


def test_a_crease_that_ends_inside_a_facet_is_named_where_its_bodies_are() -> None:
    text = miura(3, 3)
    (x0, y0), (x1, y1) = points_of("z1_1", text)
    short = moved("z1_1", [[x0, y0], [(x0 + x1) / 2, (y0 + y1) / 2]], text)
    with pytest.raises(
        DesignError, match=r"'f0_1' and 'f1_1' name the same body.*'z1_1' ends inside it.*lengthen"
    ):
        made(short)
    with pytest.raises(TopologyError, match=r"'h\d+'.*does not cut the body apart; lengthen it") as found:
        made(without_names(short).replace("name: z1_1, ", ""))
    assert found.value.place is not None


def test_two_names_in_one_facet_ask_for_the_crease_between_them() -> None:
    text = miura(3, 3)
    with pytest.raises(
        DesignError, match=r"'f0_1' and 'f1_1' name the same body.*hinge line that is missing"
    ):
        made(text.replace(line_of("z1_1", text), ""))


def test_a_sheet_in_two_pieces_is_told_with_their_number() -> None:
    text = miura(4, 3)
    for j in range(3):
        text = text.replace(line_of(f"z2_{j}", text), "")
    seam = [_corner(2, j) for j in range(4)]
    gap = [[x - 0.6, y + (y > 60) - (y < 1)] for x, y in seam] + [
        [x + 0.6, y + (y > 60) - (y < 1)] for x, y in seam[::-1]
    ]
    text = text.replace(
        "layers: film}\n", f"layers: film}}\n  - {{cut: {{polygon: {gap}}}, layers: film}}\n", 1
    )
    with pytest.raises(
        TopologyError, match=r"6 bodies have no path to the world: .* \(in 1 piece\); join each piece"
    ):
        made(text)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "limits", "told"),
    [
        (
            32,
            Limits(values=40_000),
            r"limit 'values' of 40000.*: 6[0-3]000 or so, .* some [1-9] s and \d\d MB",
        ),
        pytest.param(
            100,
            Limits(),
            r"limit 'values' of 400000.*: [67]\d0000 or so, .* some \d\d s and \d\d\d MB",
            marks=pytest.mark.campaign,
        ),
    ],
)
def test_ten_thousand_facets_are_refused_with_what_they_would_take(
    size: int, limits: Limits, told: str
) -> None:
    """The limit is passed at half of the file; 760 000 values are estimated from there. A tenth of both: 62 000, which
    is what reading it takes."""
    with pytest.raises(DesignError, match=told):
        load_text(miura(size, size), "sheet.yaml", limits=limits)

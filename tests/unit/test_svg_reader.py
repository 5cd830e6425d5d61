"""SVG files: which lines are read as what, where and how large; what is told, what is refused; fuzz."""

import math
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import DesignWarning, LamcError
from lamc.readers.drawings.svg import is_svg, read_svg
from lamc.readers.drawings.telling import full_notes
from lamc.readers.inert import Limits
from lamc.records.card import SheetOptions
from lamc.records.drawing import Drawing, Role, Stroke
from tests.support import fold_corpus, svg_corpus
from tests.support.quick import tries

HEAD = svg_corpus.HEAD
MM = 'width="100mm" height="100mm" viewBox="0 0 100 100"'
ROLES: dict[str, Role] = {
    "M": "mountain",
    "V": "valley",
    "B": "border",
    "C": "cut",
    "F": "flat",
    "U": "undriven",
}
PATTERNS = {
    "miura": fold_corpus.miura(3, 2),
    "waterbomb": fold_corpus.waterbomb(),
    "yoshimura": fold_corpus.yoshimura(2, 2),
    "kresling": fold_corpus.kresling(3, 2),
    "box": fold_corpus.box_net(),
}


def drawn(body: str, root: str = MM, *, limits: Limits = Limits(), **options: Any) -> Drawing:  # noqa: B008
    text = f"<svg {HEAD} {root}>{body}</svg>"
    return read_svg(text.encode(), "sheet.svg", SheetOptions(**options), limits)


def only(body: str, root: str = MM, **options: Any) -> Stroke:
    (stroke,) = drawn(body, root, **options).strokes
    return stroke


def mm(points: Any) -> Any:
    """Of a stroke's points, in the file's own direction of y."""
    return pytest.approx(np.array(points, dtype=float) * [1e-3, -1e-3], abs=1e-15)


LINE = '<line x2="10" stroke="red"/>'


@pytest.mark.parametrize("way", svg_corpus.WAYS)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_however_a_pattern_is_written_it_is_the_same_lines(pattern: str, way: str) -> None:
    data = PATTERNS[pattern]
    read = read_svg(
        svg_corpus.svg(data, way, head=svg_corpus.DOCTYPE).encode(), "a.svg", SheetOptions(), Limits()
    )

    def key(ends: Any, role: str, angle: float | None) -> tuple[Any, ...]:
        # 1e-9 m: what transforms of these sizes round off is a millionth of it.
        places = sorted(tuple(np.round(end, 9) + 0.0) for end in ends)
        return (*places, role, None if angle is None else round(angle, 9))

    found = sorted(key(s.points, s.role, s.angle) for s in read.strokes)
    expected = []
    for line in svg_corpus.lines_of(data):
        sign = {"M": -1.0, "V": 1.0}.get(line.kind)
        ends = 1e-3 * np.array([[line.x1, -line.y1], [line.x2, -line.y2]])
        expected.append(key(ends, ROLES[line.kind], None if sign is None else sign * math.pi * line.opacity))
    assert found == sorted(expected, key=str) or sorted(found, key=str) == sorted(expected, key=str)


def test_a_million_ways_to_say_a_colour_and_an_opacity() -> None:
    for stroke in (
        'stroke="rgb(255,0,0)" stroke-opacity="50%"',
        'style="stroke:#F00;stroke-opacity:.5"',
        'stroke="blue" style="stroke:red" opacity="0.5"',
        'stroke="#ff000080"',
        'color="red" stroke="currentColor" stroke-opacity=".5"',
        'stroke="hsla(0, 100%, 50%, 0.5)"',
    ):
        line = only(f'<line x2="10" {stroke}/>')
        assert line.role == "mountain"
        assert line.angle == pytest.approx(-0.5 * math.pi, abs=0.01)  # 80 of ff is 128/255


@pytest.mark.parametrize(
    ("body", "role"),
    [
        ('<g stroke="currentColor" color="red"><line x2="10" color="blue"/></g>', "valley"),
        ('<g color="blue"><g stroke="currentColor"><line x2="10"/></g></g>', "valley"),
        ('<g stroke="currentColor" color="red"><line x2="10" stroke="blue" color="lime"/></g>', "valley"),
        ('<g stroke="currentColor" color="red"><line x2="10" stroke="inherit" color="blue"/></g>', "valley"),
    ],
)
def test_the_current_color_is_that_of_the_shape_that_inherits_it(body: str, role: Role) -> None:
    assert only(body).role == role


@pytest.mark.parametrize(
    ("root", "millimetres", "told"),
    [
        ('viewBox="0 0 100 50" style="width:100mm;height:50mm"', 10.0, ""),
        ('viewBox="0 0 100 50" width="100mm" style="width:100%;height:auto"', 10.0, ""),
        (
            'viewBox="0 0 100 50" width="100mm" style="width:50mm"',
            10.0,
            "50mm in a style and 100mm as its own",
        ),
        ('viewBox="0 0 100 50" style="width:100"', 254 / 96, "without a unit is none"),
        (
            'viewBox="0 0 100 50" style="width:100vw;height:calc(1px + 2px)"',
            254 / 96,
            "width: 100vw in a style, which",
        ),
        ('viewBox="0 0 100 50" width="100mm" style="width:max-content"', 10.0, "is of a page and not read"),
    ],
)
def test_the_size_of_a_drawing_may_stand_in_a_style(root: str, millimetres: float, told: str) -> None:
    read = drawn(LINE, root)
    assert read.strokes[0].points == mm([[0, 0], [millimetres, 0]])
    assert told in "; ".join(read.notes)
    page = only(f'<svg viewBox="0 0 10 10" width="50" height="50" style="width:50vw">{LINE}</svg>')
    assert page.points == mm([[0, 0], [50, 0]])
    inner = only(f'<svg viewBox="0 0 10 10" style="width:50px; height:50px">{LINE}</svg>')
    assert inner.points == mm([[0, 0], [50, 0]])


def test_opacities_of_groups_multiply_and_of_strokes_do_not() -> None:
    line = only(
        '<g opacity=".5"><g opacity=".5" stroke-opacity=".1" stroke="blue">'
        '<line x2="10" stroke-opacity="0.8"/></g></g>'
    )
    assert line.angle == pytest.approx(0.2 * math.pi)


def test_full_opacity_is_180_degrees_and_told() -> None:
    read = drawn(LINE + '<line x2="10" y2="5" stroke="blue"/><line x2="9" stroke="magenta"/>')
    assert [s.angle for s in read.strokes] == [-math.pi, math.pi, None]
    (note,) = full_notes(read.strokes)
    assert "2 creases have full opacity and rest at 180 degrees" in note
    # A layer may say the angle in place of the opacity.
    line = only('<g id="mountain_45"><line x2="10" stroke="black"/></g>')
    assert (line.role, line.angle, line.layer) == ("mountain", pytest.approx(-math.pi / 4), "mountain_45")


def test_rules_of_style_sheets_go_by_rank_and_order() -> None:
    styles = """<style>
      line { stroke: blue } .a { stroke: black } #x { stroke: lime } .b { stroke: yellow }
      g.outer > line.c { stroke: magenta } .outer .d.e { stroke: red !important }
      @media print { line { stroke: white } } @font-face { font-family: x }
      line:hover { stroke: white }
    </style>"""

    def role(attributes: str) -> Role:
        return only(f'{styles}<g class="outer"><line x2="10" {attributes}/></g>').role

    assert role('stroke="red"') == "valley"  # an attribute is weaker than any rule
    assert role('class="a"') == "border"
    assert role('class="b a"') == "flat"  # of equal ranks the later one
    assert role('class="a" id="x"') == "cut"
    assert role('class="a" id="x" style="stroke:red"') == "mountain"
    assert role('class="c a"') == "undriven"
    assert role('class="d e" style="stroke:black"') == "mountain"
    notes = drawn(f"{styles}{LINE}").notes
    assert any("@media" in note for note in notes)
    assert any("line:hover" in note for note in notes)


def test_transforms_add_up_and_y_is_up() -> None:
    line = only(
        '<g transform="translate(10, 20)"><g transform="rotate(90) scale(2 1)">'
        '<line x1="1" y1="2" x2="5" y2="2" transform="matrix(1 0 0 1 0 1)" stroke="red"/></g></g>'
    )
    assert line.points == mm([[7, 22], [7, 30]])
    skewed = only('<line x2="10" y2="10" transform="skewX(45) skewY(0)" stroke="red"/>')
    assert skewed.points == mm([[0, 0], [20, 10]])


def test_use_and_symbols_are_placed_and_hand_down_styles() -> None:
    body = (
        '<defs><line id="l" x2="10"/></defs><symbol id="s" viewBox="0 0 10 10"><line x2="10" y2="10"/></symbol>'
        '<use xlink:href="#l" x="5" y="6" stroke="red"/><use href="#s" x="20" width="20" height="20" stroke="blue"/>'
    )
    first, second = drawn(body).strokes
    assert (first.role, second.role) == ("mountain", "valley")
    assert first.points == mm([[5, 6], [15, 6]])
    assert second.points == mm([[20, 0], [40, 20]])
    assert first.source == "line #l by use 1 (line 1)"


def test_nested_drawings_have_viewports_of_their_own() -> None:
    body = '<svg x="10" y="10" width="50" height="20" viewBox="0 0 10 10"><line x2="10" stroke="red"/></svg>'
    assert only(body).points == mm([[25, 10], [45, 10]])
    per_cent = '<line x1="10%" x2="100%" y1="50%" y2="50%" stroke="red"/>'
    assert only(per_cent).points == mm([[10, 50], [100, 50]])


def test_shapes_are_outlines() -> None:
    body = """<g stroke="black" fill="none"><rect x="1" y="2" width="3" height="4"/><polygon points="0,0 1 0 1,1"/>
      <polyline points="0 0 1 0 1 1"/><path d="m1 1h2v2h-2z m5 5l1 1"/><path d="M0 0 1 0 1 1 0 0"/></g>"""
    rect, polygon, polyline, first, second, meets = drawn(body).strokes
    assert (rect.closed, rect.points) == (True, mm([[1, 2], [4, 2], [4, 6], [1, 6]]))
    assert (polygon.closed, len(polygon.points)) == (True, 3)
    assert (polyline.closed, len(polyline.points)) == (False, 3)
    assert (first.closed, first.points) == (True, mm([[1, 1], [3, 1], [3, 3], [1, 3]]))
    assert (second.closed, second.points) == (False, mm([[6, 6], [7, 7]]))
    assert (meets.closed, len(meets.points)) == (True, 3)


def test_a_symbol_draws_nothing_where_it_stands_and_needs_no_word() -> None:
    found = drawn(f'<symbol id="s">{LINE}</symbol><use href="#s"/>')
    assert len(found.strokes) == 1
    assert not any("no shape" in note for note in found.notes)


def test_animation_within_a_shape_is_told() -> None:
    found = drawn('<line x2="10" stroke="red"><animate attributeName="x2" to="20"/></line>')
    assert any("is animation and is not played" in note for note in found.notes)


def test_a_stroke_that_is_transparent_is_none() -> None:
    found = drawn(f'<path d="M0 0H10V10Z" stroke="transparent" fill="none"/>{LINE}')
    assert len(found.strokes) == 1
    assert any("it has neither stroke nor fill" in note for note in found.notes)


def test_an_opacity_that_is_no_number_is_told() -> None:
    found = drawn('<line x2="10" stroke="red" stroke-opacity="much"/>')
    assert any("has the stroke-opacity 'much', which is no number" in note for note in found.notes)


def test_curves_are_flat_within_the_tolerance_that_is_told() -> None:
    """A chord's middle is off the circle by less than 10 um, and by less than 5e-5 of the drawing's size."""
    for body, radius in (
        ('<circle cx="50" cy="50" r="20" stroke="black"/>', 20.0),
        ('<ellipse cx="50" cy="50" rx="20" ry="20" stroke="black"/>', 20.0),
        ('<path d="M30 50a20 20 0 0140 0 20 20 0 01-40 0z" stroke="black"/>', 20.0),
        ('<rect x="30" y="30" width="40" height="40" rx="20" stroke="black"/>', 20.0),
        ('<path d="M30 50A20 20 0 1 1 50 70" transform="translate(50 50) scale(.1) translate(-50 -50)" '
         'stroke="black"/>', 2.0),
    ):  # fmt: skip
        points = only(body).points * [1e3, -1e3]
        assert np.hypot(*(points - 50.0).T) == pytest.approx(radius, rel=1e-8)
        middles = 0.5 * (points[1:] + points[:-1])
        off = radius - np.hypot(*(middles - 50.0).T)
        assert np.max(off) < min(0.01, 5e-5 * 2.0 * math.sqrt(2.0) * radius)
        assert len(points) < 400
    # Bézier curves: the circle's usual one is round to 3e-4 of its radius.
    k = 20.0 * 0.5522847498
    curve = only(f'<path d="M70 50C70 {50 + k} {50 + k} 70 50 70" stroke="black"/>').points * [1e3, -1e3]
    assert np.hypot(*(curve - 50.0).T) == pytest.approx(20.0, rel=4e-4)
    assert curve[[0, -1]].tolist() == pytest.approx(np.array([[70, 50], [50, 70]]))
    quadratic = only('<path d="M0 0Q10 10 20 0T40 0" stroke="red"/>').points * [1e3, -1e3]
    half = quadratic[quadratic[:, 0] <= 20.0]
    assert half[:, 1] == pytest.approx(half[:, 0] - half[:, 0] ** 2 / 20.0, abs=1e-9)


@pytest.mark.parametrize(
    ("root", "options", "scale", "told"),
    [
        ('width="210mm" height="297mm" viewBox="0 0 210 297"', {}, 1e-3, ""),
        ('width="10in" height="5in" viewBox="0 0 720 360"', {}, 0.0254 / 72, ""),
        ('width="72pt" height="72pt" viewBox="0 0 96 96"', {}, 0.0254 / 96, ""),
        ('width="10cm" viewBox="0 0 100 50"', {}, 1e-3, ""),
        ('width="100%" height="100%" viewBox="0 0 100 50"', {}, 0.0254 / 96, "no unit: 1 is taken for a px"),
        ('width="200" height="100" viewBox="0 0 100 50"', {}, 2 * 0.0254 / 96, "no unit"),
        ("", {}, 0.0254 / 96, "no unit"),
        ('width="10mm" height="10mm"', {}, 0.0254 / 96, "no unit"),
        ('width="200" height="100" viewBox="0 0 100 50"', {"units": "mm"}, 1e-3, ""),
        ('width="210mm" height="297mm" viewBox="0 0 210 297"', {"units": "in"}, 0.0254, ""),
        ('viewBox="0 0 9 9" inkscape:version="0.48.4 r9939"', {}, 0.0254 / 90, "before 0.92"),
        ('viewBox="0 0 9 9" inkscape:version="1.2 (dc2aedaf03)"', {}, 0.0254 / 96, "no unit"),
        ('width="1000m" viewBox="0 0 10 10"', {}, None, "must be a length|write it in"),
    ],
)
def test_units_are_those_of_the_file_the_user_or_px(
    root: str, options: dict[str, Any], scale: float | None, told: str
) -> None:
    if scale is None:
        with pytest.raises(LamcError, match=told):
            drawn(LINE, root, **options)
        return
    read = drawn(LINE, root, **options)
    assert read.scale == pytest.approx(scale)
    assert read.strokes[0].points[1, 0] == pytest.approx(10.0 * scale)
    assert [note for note in read.notes if "no unit" in note] == [
        note for note in read.notes if told and told in note
    ]
    assert bool(told) == any("--units" in note for note in read.notes)


def test_illustrator_writes_points_and_entities() -> None:
    text = f'{svg_corpus.ADOBE}<svg xmlns="&ns_svg;" width="612px" height="792px" viewBox="0 0 612 792">{LINE}</svg>'
    read = read_svg(text.encode(), "a.svg", SheetOptions(), Limits())
    assert read.scale == pytest.approx(0.0254 / 72)
    assert any("Illustrator" in note for note in read.notes)
    for newer in (
        f'<g data-name="Layer 1">{LINE}</g>',
        f"<defs><style>.cls-1{{fill:none}}</style></defs>{LINE}",
    ):
        assert drawn(newer, 'viewBox="0 0 9 9"').scale == pytest.approx(0.0254 / 72)


def test_layers_are_those_of_inkscape_and_illustrator() -> None:
    body = """<g inkscape:groupmode="layer" inkscape:label="Top plate" id="layer1"><g id="g123">
        <line x2="10" stroke="red"/><g id="holes"><circle r="1" stroke="red"/></g></g></g>
      <g id="Cut_x0020_lines_1_"><g id="a1"><line x2="10" stroke="red"/></g></g>"""
    layers = [(s.layer, s.role) for s in drawn(body).strokes]
    assert layers == [("Top plate", "mountain"), ("holes", "hole"), ("Cut lines", "cut")]
    named = drawn(body, roles={"top plate": "cut", "holes": "ignore"}).strokes
    assert [(s.layer, s.role) for s in named] == [("Top plate", "cut"), ("Cut lines", "cut")]


def test_the_user_says_what_colours_are_for_and_hears_of_those_for_nothing() -> None:
    body = f'{LINE}<line x2="3" stroke="#808080" id="grey"/><line x2="4" stroke="grey"/>'
    read = drawn(body)
    assert len(read.strokes) == 1
    note = next(n for n in read.notes if "#808080" in n)
    assert "line #grey" in note
    assert "--role '#808080=cut'" in note
    assert [s.role for s in drawn(body, roles={"gray": "cut", "red": "border"}).strokes] == [
        "border",
        "cut",
        "cut",
    ]
    assert any("'teal'" in note for note in drawn(body, roles={"teal": "cut"}).notes)
    near = drawn('<line x2="3" stroke="#ed1c24"/>')
    assert any("#ed1c24, taken for red: mountain" in note for note in near.notes)
    assert not any("taken for" in note for note in drawn('<line x2="3" stroke="#ff0100"/>').notes)
    with pytest.raises(LamcError, match=r"no line that is for anything.*#808080"):
        drawn('<line x2="3" stroke="#808080"/>')


def test_layers_that_differ_from_colours_are_told() -> None:
    body = '<g id="outline"><line x2="9" stroke="red"/></g><g id="guides"><line x2="9" stroke="red"/></g>'
    read = drawn(f'{body}<g id="edges">{LINE}</g>')
    assert [s.role for s in read.strokes] == ["border", "mountain"]  # edges may be any
    assert any("on the layer 'outline': border, whatever its colour #ff0000" in note for note in read.notes)
    assert any("its layer 'guides' is for nothing" in note for note in read.notes)
    quiet = drawn(body, roles={"outline": "border", "guides": "ignore"})
    assert not any("layer" in note for note in quiet.notes)


def test_what_is_hidden_or_defined_is_not_drawn() -> None:
    body = f"""{LINE}<defs>{LINE}</defs><g display="none">{LINE}</g><g style="visibility:hidden">{LINE}</g>
      <clipPath id="c">{LINE}</clipPath><symbol>{LINE}</symbol><g clip-path="url(#c)"><line x2="3" stroke="red"/></g>
      <switch><foreignObject requiredExtensions="http://ns.adobe.com/"/><g><line x2="4" stroke="red"/></g></switch>"""
    read = drawn(body)
    assert len(read.strokes) == 3
    told = "\n".join(read.notes)
    assert "display: none" in told
    assert "visibility" in told
    assert "clip-path is not applied" in told
    assert "foreignObject" not in told


def test_filled_shapes_are_outlines_where_there_is_nothing_else_or_it_is_said() -> None:
    square = '<rect width="10" height="10" fill="#123456"/>'
    read = drawn(LINE + square)
    assert len(read.strokes) == 1
    assert any("rect 1 (line 1): is left out: it is filled" in note for note in read.notes)
    assert [s.role for s in drawn(LINE + square, roles={"#123456": "border"}).strokes] == [
        "mountain",
        "border",
    ]
    assert [s.role for s in drawn(f'{LINE}<g id="body">{square}</g>').strokes] == ["mountain", "border"]
    silhouette = drawn('<path d="M0 0h10v10z"/>')
    assert [s.role for s in silhouette.strokes] == ["border"]
    assert any("its rim is taken for an outline" in note for note in silhouette.notes)


def test_what_is_not_read_is_told_with_its_name_and_nothing_is_fetched() -> None:
    body = f"""{LINE}<text id="t">hi</text><image xlink:href="http://example.invalid/a.png"/>
      <script>alert(1)</script><foreignObject><p/></foreignObject><use href="http://example.invalid/b.svg#x"/>
      <use href="#nothing"/><path d=""/><line x1="1" x2="1" stroke="red" id="dot"/><circle r="0" stroke="red"/>
      <defs><script id="hidden">alert(2)</script></defs><a href=" javascript:alert(3)" onclick="alert(4)">{LINE}</a>
      <blob/><style>@import url(http://example.invalid/c.css);</style><path d="M5 5" stroke="red"/>"""
    told = "\n".join(drawn(body).notes)
    for word in (
        "text #t: is text",
        "image 1 (line 1): is a picture",
        "script 1 (line 2), script #hidden, href of a 1 (line 4), onclick of a 1 (line 4): each is a program",
        "is not in the file and is not fetched",
        "'#nothing', which the file does not have",
        "line #dot: draws nothing: its length is 0",
        "circle 1 (line 3), path 2 (line 5): each draws nothing",
        "blob 1",
        "imports a stylesheet, which is not fetched",
    ):
        assert word in told


@pytest.mark.parametrize(
    ("body", "told"),
    [
        (
            '<path d="M0 0 L nan 3" stroke="red" id="p"/>',
            r"sheet.svg:1.*path #p: its d cannot be read at character 7",
        ),
        ('<path d="M0 0 L 1e999 3" stroke="red"/>', "path 1 .line 1.: its d cannot be read"),
        ('<path d="M0 0L1 3" transform="translate(10,)" stroke="red"/>', "has transform='translate.10,.'"),
        (
            '<path d="M0 0L1 3" transform="translate(10,,3)" stroke="red"/>',
            "has transform='translate.10,,3.'",
        ),
        ('<path d="M0 0 X 3" stroke="red"/>', "its d cannot be read at character 6"),
        ('<path d="L 3 3" stroke="red"/>', "its d cannot be read at character 1"),
        ('<path d="M0 0 L 3" stroke="red"/>', "its d cannot be read"),
        ('<path d="M0 0 A 1 1 0 2 0 3 3" stroke="red"/>', "its d cannot be read"),
        ('<polyline points="0 0 1" stroke="red" id="q"/>', "polyline #q has points="),
        ('<polyline points="0 0 1 x" stroke="red"/>', "has points="),
        ('<line x2="NaN" stroke="red"/>', "has x2='NaN'; it must be a length"),
        ('<line x2="3em" stroke="red"/>', "has x2='3em'; write it in mm"),
        ('<line x2="3" stroke="red" transform="turn(3)"/>', "transform='turn.3.', which cannot be read"),
        ('<line x2="3" stroke="red" transform="matrix(1 2)"/>', "transform='matrix"),
        ('<line x2="3" stroke="red" transform="scale(1e300)"/>', "transform="),
        ('<line x2="3" stroke="red" transform="rotate(3)" transform-origin="1 1"/>', "transform-origin"),
        ('<g id="a"><use href="#a" stroke="red"/></g>', "use 1 .line 1. links to '#a', which it lies in"),
        ('<g id="a"><use href="#b"/></g><g id="b"><use href="#a"/></g>', "which it lies in"),
        ("<g>" * 101 + "</g>" * 101, "the limit 'depth' of 100"),
        ("", "no line that is for anything: it draws nothing"),
        ("<text/>", "no line that is for anything: text 1"),
        ('<line x1="1" x2="1" stroke="red"/>', "no line of any length"),
        ("<g>", "not XML: mismatched tag"),
        ("<a:b/><x", "not XML"),
    ],
)
def test_what_is_wrong_is_refused_with_its_name(body: str, told: str) -> None:
    with pytest.raises(LamcError, match=told):
        drawn(body)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (b"<svg", "not XML|ends within"),
        (b"<svg><g id='a'><path", "the file ends within|not XML"),
        (b"<svg><g id='a'>\n<path/>\n", "ends within g #a: it was cut short"),
        (b"<html/>", "XML of <html>, not a drawing"),
        (
            b'<!DOCTYPE svg [<!ENTITY a "x"><!ENTITY b "&a;&a;">]><svg/>',
            "the entity 'b' holds other entities",
        ),
        (
            b'<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/passwd">]><svg>&a;</svg>',
            "the entity 'a' stands for a file",
        ),
        (
            b'<!DOCTYPE svg [<!ENTITY % a SYSTEM "http://example.invalid/">%a;]><svg/>',
            "the entity 'a' stands for",
        ),
        (b'<!DOCTYPE svg [<!ENTITY a "<line/>">]><svg>&a;</svg>', "holds other entities or markup"),
        (b'<!DOCTYPE svg [<!ENTITY a "' + b"x" * 2000 + b'">]><svg>&a;</svg>', "2000 characters"),
        (b'<!DOCTYPE svg SYSTEM "a.dtd"><svg a="&red;"/>', "uses the entity &red; without"),
        (b'<?xml version="1.0" encoding="klingon"?><svg/>', "unknown encoding|cannot be read"),
    ],
)
def test_files_that_are_no_drawing_are_refused(text: bytes, told: str) -> None:
    assert is_svg(text)
    with pytest.raises(LamcError, match=told) as caught:
        read_svg(text, "sheet.svg", SheetOptions(), Limits())
    assert "sheet.svg" in str(caught.value)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_encodings_are_those_of_xml(encoding: str) -> None:
    named = encoding.replace("-sig", "")
    text = f'<?xml version="1.0" encoding="{named}"?><svg {HEAD}><title>Flügel</title>{LINE}</svg>'
    assert read_svg(text.encode(encoding), "a.svg", SheetOptions(), Limits()).name == "Flügel"


@pytest.mark.parametrize(
    ("start", "told"),
    [(b"\x1f\x8b\x08", "gzip"), (b"%PDF-1.4", "PDF"), (b"AC1027", "DWG"), (b"PK\x03\x04", "archive")],
)
def test_packed_and_foreign_files_are_told(tmp_path: Path, start: bytes, told: str) -> None:
    file = tmp_path / "sheet.svg"
    file.write_bytes(start + bytes(100))
    with pytest.raises(LamcError, match=told):
        lamc.load(file)


BOMBS = {
    "edges": '<path stroke="red" d="M0 0' + "h1v1" * 10**6 + '"/>',
    "lines": LINE * 500_000,
    "close_numbers": '<path stroke="red" d="M0 0h' + ".1" * 10**6 + '"/>',
    "use": '<g id="a0">'
    + LINE
    + "</g>"
    + "".join(f'<g id="a{k + 1}">' + f'<use href="#a{k}"/>' * 10 + "</g>" for k in range(12)),
    "styles": "<style>"
    + "g g g g g g line{stroke:red}" * 9000
    + "</style>"
    + "<g>" * 50
    + LINE * 3000
    + "</g>" * 50,
    "rules": "<style>" + "line{stroke:red}" * 20_000 + "</style>" + LINE,
    "curves": LINE + '<path stroke="red" d="M0 0' + "c9 9 9-9 0 0" * 20_000 + '"/>',
}


@pytest.mark.quick("10-curves", "10-close_numbers", "10-edges", "10-rules", others="campaign")
@pytest.mark.parametrize("bomb", BOMBS)
@pytest.mark.parametrize("share", [10, pytest.param(1, marks=pytest.mark.campaign)])
def test_files_beyond_a_limit_are_refused_soon_with_its_name(share: int, bomb: str) -> None:
    """With a tenth of the limits too, in a tenth of the time."""
    limits = Limits(values=Limits().values // share, nodes=Limits().nodes // share)
    began = time.process_time()
    with pytest.raises(LamcError, match=r"limit '(values|nodes)'|more than 10000 rules"):
        drawn(BOMBS[bomb], limits=limits)
    assert time.process_time() - began < 20.0 / share  # s; some 3 for all where nothing else runs


def test_entities_written_out_stay_within_the_limit_of_bytes() -> None:
    text = '<!DOCTYPE svg [<!ENTITY a "' + "x" * 999 + '">]><svg>' + "&a;" * 10**5 + "</svg>"
    with pytest.raises(LamcError, match="limit 'bytes'"):
        read_svg(text.encode(), "a.svg", SheetOptions(), Limits())


FEW = settings(
    max_examples=tries(60), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
WORDS = st.sampled_from(
    [
        *(
            "<",
            ">",
            "/",
            '"',
            "&",
            "]]>",
            "<!--",
            "NaN",
            "1e999",
            "-",
            "9" * 500,
            "#",
            "url(#a)",
            "inherit",
            "em",
            "%",
        ),
        *(
            "(",
            "<use href='#e0'/>",
            "<g>",
            "</g>",
            "<!ENTITY a 'b'>",
            "<style>*{stroke:red}</style>",
            "{",
            "}",
            "0",
        ),
    ]
)
BASE = svg_corpus.svg(fold_corpus.miura(2, 1), head=svg_corpus.ADOBE).replace(
    "</svg>", '<path d="M0 0a1 2 3 0 1 4 5c1 2 3 4 5 6z" transform="rotate(3)" style="stroke:red"/><g/></svg>'
)


@pytest.mark.slow
@FEW
@given(data=st.data())
def test_any_change_of_a_file_is_a_drawing_or_an_error(tmp_path: Path, data: st.DataObject) -> None:
    text = BASE
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text)))
        text = text[:at] + data.draw(WORDS) + text[at + data.draw(st.integers(0, 6)) :]
    attempt(tmp_path, text.encode())


VALUES = (
    st.text(max_size=8)
    | st.floats().map(repr)
    | WORDS
    | st.sampled_from(["M0 0", "1 2 3 4", "scale(0)", "a"])
)
NAMES = [
    "d",
    "points",
    "x1",
    "r",
    "rx",
    "width",
    "viewBox",
    "transform",
    "stroke",
    "style",
    "class",
    "href",
    "id",
]
NAMES += [
    "preserveAspectRatio",
    "opacity",
    "display",
    "fill",
    "stroke-opacity",
    "inkscape:label",
    "xlink:href",
]
TAGS = [
    "path",
    "line",
    "polygon",
    "rect",
    "circle",
    "ellipse",
    "use",
    "g",
    "svg",
    "symbol",
    "switch",
    "style",
    "text",
]


@FEW
@given(
    elements=st.lists(
        st.tuples(st.sampled_from(TAGS), st.dictionaries(st.sampled_from(NAMES), VALUES, max_size=4)),
        max_size=5,
    )
)
def test_any_attributes_are_a_drawing_or_an_error(
    tmp_path: Path, elements: list[tuple[str, dict[str, str]]]
) -> None:
    from xml.sax.saxutils import quoteattr

    body = "".join(
        f"<{tag} {' '.join(f'{k}={quoteattr(v)}' for k, v in attributes.items())}/>"
        for tag, attributes in elements
    )
    attempt(tmp_path, f"<svg {HEAD}>{LINE}{body}</svg>".encode("utf-8", "replace"))


@FEW
@given(data=st.binary(max_size=60))
def test_any_bytes_behind_a_start_are_a_drawing_or_an_error(tmp_path: Path, data: bytes) -> None:
    attempt(tmp_path, b"<svg " + data)


def attempt(folder: Path, data: bytes) -> None:
    file = folder / "fuzzed.svg"
    file.write_bytes(data)
    began = time.process_time()
    message = ""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        try:
            lamc.load(file)
        except LamcError as error:
            message = str(error)
    assert all(len(line) < 3000 for line in message.splitlines())
    assert time.process_time() - began < 5.0  # s: a second is the promise, and the machine may be busy


def test_files_of_other_kinds_are_read_without_the_libraries_of_drawings() -> None:
    program = (
        "import sys, lamc; from lamc.examples import path; lamc.load(path('flaps'))\n"
        "print({'svgelements', 'ezdxf', 'xml.parsers.expat'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_a_tolerance_that_is_larger_than_the_drawing_is_refused(tmp_path: Path) -> None:
    (tmp_path / "dot.svg").write_text(f'<svg {HEAD} {MM}><rect width="1" height="1" stroke="black"/></svg>')
    with pytest.raises(LamcError, match=r"it must be at most 0\.05 mm"):
        lamc.load(tmp_path / "dot.svg", heal="10 mm")
    (tmp_path / "line.svg").write_text(f'<svg {HEAD} {MM}><path d="M0 0H9" stroke="black"/></svg>')
    with pytest.raises(LamcError, match="enclose no facet, of path 1"):
        lamc.load(tmp_path / "line.svg")


def test_css_geometry_goes_before_attributes() -> None:
    """SVG 2, "Geometry properties": shapes are measured in CSS as well; a length in CSS has a unit."""
    styles = "<style>.wide { width: 50px; height: 2cm } .far { d: path('M1 2 L3 4') }</style>"
    rect = only(styles + '<rect class="wide" width="1" height="1" stroke="black"/>')
    assert rect.points.max(axis=0) == pytest.approx([0.05, 0.0], abs=1e-15)
    assert rect.points.min(axis=0) == pytest.approx(
        [0.0, -96.0 / 25.4 * 0.02], abs=1e-12
    )  # 1 cm is 96 / 2.54 px
    assert only(styles + '<path class="far" d="M0 0H9" stroke="red"/>').points == mm([[1, 2], [3, 4]])
    told = drawn('<circle r="3" style="r: 5" stroke="black"/>')
    assert np.ptp(told.strokes[0].points[:, 0]) == pytest.approx(6e-3, rel=1e-2)  # an inscribed polygon's
    assert any("has r: 5 in a style, which without a unit is none" in note for note in told.notes)


def test_a_nested_svg_is_told_to_be_drawn_beyond_its_size() -> None:
    """A viewer clips it."""
    inside = '<line x1="50" x2="60" stroke="red"/>'
    clipped = drawn(f'<svg width="30" height="20">{inside}</svg>')
    assert len(clipped.strokes) == 1
    assert any("svg 2 (line 1): is drawn whole, and not clipped" in note for note in clipped.notes)
    for more in ('overflow="visible"', 'style="overflow: visible"'):
        whole = drawn(f'<svg width="30" height="20" {more}>{inside}</svg>')
        assert not any("clipped" in note for note in whole.notes)


def test_a_line_without_a_stroke_is_not_said_to_be_filled() -> None:
    read = drawn(LINE + '<line x2="9" stroke="none"/>')
    assert any("it has neither stroke nor fill" in note for note in read.notes)
    assert not any("filled" in note for note in read.notes)

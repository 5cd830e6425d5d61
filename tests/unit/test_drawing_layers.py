"""Shapes and hinge lines of native designs that come from drawings: the same device, what is told, what is refused."""

import hashlib
import io
import json
import re
import warnings
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import DesignWarning
from lamc.cli import main
from lamc.readers.drawings.layer_shape import in_a_row, lines_of, shape_of
from lamc.readers.drawings.svg import read_svg
from lamc.readers.inert import Limits
from lamc.readers.load import load_text
from lamc.records.card import SheetOptions
from lamc.records.drawing import ROLES
from tests.support.drawn_corpus import drawing, line, square
from tests.support.four_bar import written_out
from tests.support.quick import tries

FOUR_BAR = written_out()
LAYER = '<g inkscape:groupmode="layer" inkscape:label="{}" fill="none" stroke="black">{}</g>'


def svg(layers: dict[str, str]) -> str:
    """A drawing in mm, y up as in the design."""
    groups = "".join(LAYER.format(name, content) for name, content in layers.items())
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'width="100mm" height="100mm" viewBox="0 0 100 100"><g transform="scale(1 -1)">{groups}</g></svg>'
    )


def rim(x0: str, y0: str, x1: str, y1: str) -> str:
    """A rectangle as four lines, as CAD writes them."""
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    sides = zip(corners, corners[1:] + corners[:1], strict=True)
    return "".join(f'<path d="M{a} {b} L{c} {d}"/>' for (a, b), (c, d) in sides)


def dxf(layers: dict[str, str], version: str) -> str:
    """The same lines as DXF."""
    document = ezdxf.new(version, units=4)  # mm
    for name, content in layers.items():
        document.layers.add(name)
        for a, b, c, d in re.findall(r"M(\S+) (\S+) L(\S+) ([^\s\"]+)", content):
            ends = (float(a), float(b)), (float(c), float(d))
            document.modelspace().add_line(*ends, dxfattribs={"layer": name})
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue()


def drawn_four_bar() -> tuple[str, dict[str, str]]:
    """The example with every shape and hinge line from a drawing, bar.svg; the lines of its layers."""
    layers: dict[str, str] = {}

    def rect(found: re.Match[str]) -> str:
        name = f"shape {len(layers)}"
        layers[name] = rim(*found[1].split(", "))
        return f"shape: {{file: bar.svg, layer: {name}}}"

    def hinge(found: re.Match[str]) -> str:
        name = f"hinge {len(layers)}"
        layers[name] = '<path d="M{} {} L{} {}"/>'.format(*re.findall(r"-?[\d.]+", found[1]))
        return f"lines: {{file: bar.svg, layer: {name}}}"

    text = re.sub(r"rect: \[(.*?)\]", rect, FOUR_BAR)
    text = re.sub(r"line: \[(\[.*?\], \[.*?\])\]", hinge, text)
    assert "rect" not in text
    assert "line:" not in text
    return text, layers


def load(folder: Path, text: str, name: str = "bar.yaml") -> Any:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return lamc.load(path)


@pytest.mark.parametrize("version", ["SVG", "R12", "R2000", "R2010", "R2018"])
def test_a_laminate_from_drawings_is_the_one_drawn_in_yaml(tmp_path: Path, version: str) -> None:
    text, layers = drawn_four_bar()
    bars = svg(layers) if version == "SVG" else dxf(layers, version)
    (tmp_path / "bar.svg").write_text(bars, encoding="utf-8")  # what is in a file counts, not its name
    if version == "R12":  # which has no units
        text = text.replace("file: bar.svg", "file: bar.svg, units: mm")
    found, expected = lamc.split(load(tmp_path, text)), lamc.split(load_text(FOUR_BAR, "four_bar.yaml"))
    assert [b.name for b in found.bodies] == [b.name for b in expected.bodies]
    assert [j.name for j in found.joints] == [j.name for j in expected.joints]
    for a, b in zip(found.bodies, expected.bodies, strict=True):
        assert a.mass == pytest.approx(b.mass, rel=1e-9)
        assert a.com == pytest.approx(b.com, abs=1e-9)
        assert a.inertia == pytest.approx(b.inertia, rel=1e-9, abs=1e-9 * float(np.abs(b.inertia).max()))
    for c, d in zip(found.joints, expected.joints, strict=True):
        assert c.point == pytest.approx(d.point, abs=1e-9)
        assert c.axis == pytest.approx(d.axis, abs=1e-9)
        assert c.stiffness == d.stiffness


def test_a_run_names_its_drawings(tmp_path: Path) -> None:
    text, layers = drawn_four_bar()
    bars = svg(layers)
    (tmp_path / "bar.svg").write_text(bars, encoding="utf-8")
    design = load(tmp_path, text)
    assert design.beside == (("bar.svg", hashlib.sha256(bars.encode()).hexdigest()),)


SMALL = """units: mm
materials: {card: {density: 700, rigid: true}, film: {density: 1390, flexible: true}}
layers: [{name: film, material: film, thickness: 0.03}, {name: card, material: card, thickness: 0.3}]
shapes:
  - shape: {file: top.svg, layer: body}
hinges:
  - {name: fold, lines: {file: top.svg, layer: joint}, gap: 0.4}
fixed: [{rect: [0, 0, 5, 20]}]
"""
BODY = rim("0", "0", "40", "20")
JOINT = '<path d="M20 0 V20" id="j1"/><path d="M30 0 V20" id="j2"/>'


def small(folder: Path, body: str = BODY, joint: str = JOINT, text: str = SMALL) -> tuple[Any, list[str]]:
    (folder / "top.svg").write_text(svg({"body": body, "joint": joint}), encoding="utf-8")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", DesignWarning)
        made = load(folder, text, "small.yaml")
    return made, [str(each.message) for each in told]


def test_several_lines_are_several_hinges_with_numbers(tmp_path: Path) -> None:
    made, told = small(tmp_path)
    assert [each.name for each in made.hinges[0].lines] == ["fold_1", "fold_2"]
    assert [each.line for each in made.hinges[0].lines] == [
        (pytest.approx((0.02, 0.0)), pytest.approx((0.02, 0.02))),
        (pytest.approx((0.03, 0.0)), pytest.approx((0.03, 0.02))),
    ]
    assert told == []
    assert made.mends == ()


@pytest.mark.parametrize(
    ("joint", "told"),
    [
        ('<path d="M20 0 V8 M20 8 V20"/>', True),
        ('<path d="M20 8 V0"/><path d="M20 5 V20"/>', True),  # over one another from 5 to 8
        ('<path d="M20 0 V8 M20 12 V20"/>', False),
        ('<path d="M20 0 V10 V20"/>', False),  # one line
        ('<path d="M20 0 V10 M20 10 V20 M0 10 H40"/>', False),  # a vertex
        ('<path d="M20 0 V10 M20 10 V20 M20 10 H40"/>', False),
    ],
)
def test_hinge_lines_that_go_on_straight_where_they_meet_are_told(joint: str, told: bool) -> None:
    drawing = read_svg(svg({"joint": joint}).encode(), "top.svg", SheetOptions(), Limits())
    found, _ = lines_of(drawing, "joint", None)
    assert bool(in_a_row(found, 1e-5)) == told


def test_pieces_of_a_hinge_line_are_told_with_the_place(tmp_path: Path) -> None:
    made, told = small(tmp_path, joint='<path d="M20 0 V8 M20 8 V20"/>')
    assert len(made.hinges[0].lines) == 2
    assert any(
        "hinge lines go on straight where they meet, at (20, 8) mm: each is a hinge" in note for note in told
    )


@pytest.mark.parametrize(("rest", "told"), [("", True), (", rest_angle: -90 deg", False)])
def test_an_angle_that_a_drawing_says_is_told_not_to_be_read_in_a_design(
    tmp_path: Path, rest: str, told: bool
) -> None:
    text = SMALL.replace("layer: joint}, gap: 0.4", "layer: mountain_90}, gap: 0.4" + rest)
    drawn = svg({"body": BODY, "mountain_90": '<path d="M20 0 V20"/>'})
    (tmp_path / "top.svg").write_text(drawn, encoding="utf-8")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", DesignWarning)
        made = load(tmp_path, text, "small.yaml")
    notes = [str(each.message) for each in caught]
    assert not any("as its name says" in note for note in notes)
    assert any("which is not read here: rest_angle says where" in note for note in notes) == told
    assert np.degrees(made.hinges[0].rest_angle) == pytest.approx(0.0 if told else -90.0)


def test_cuts_and_fixed_regions_come_from_drawings_too(tmp_path: Path) -> None:
    text = SMALL.replace("hinges:", "  - cut: {shape: {file: top.svg, layer: window}}\nhinges:")
    text = text.replace("{rect: [0, 0, 5, 20]}", "{shape: {file: top.svg, layer: held}, layers: card}")
    window, held = rim("2", "2", "4", "4"), rim("0", "0", "5", "20")
    (tmp_path / "top.svg").write_text(
        svg({"body": BODY, "joint": JOINT, "window": window, "held": held}), encoding="utf-8"
    )
    made = load(tmp_path, text)
    assert made.layers[0].geometry.area == pytest.approx(796e-6)
    assert [region.area for region in made.fixed] == pytest.approx([0.0, 100e-6])


def test_hinge_lines_that_stop_short_of_the_material_are_drawn_on_to_its_edge(tmp_path: Path) -> None:
    """Within `heal:`, which had no effect on them; beyond, and where they end amid the material, they stay."""
    short = '<path d="M20 0.03 V19.98" id="j1"/><path d="M30 0 V12" id="j2"/>'
    healing = SMALL.replace("layer: joint}", "layer: joint, heal: 0.1 mm}")
    made, told = small(tmp_path, BODY, short, healing)
    found = [each.line for each in made.hinges[0].lines]
    expected = [((0.02, 0.0), (0.02, 0.02)), ((0.03, 0.0), (0.03, 0.012))]
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-15)  # m: round-off of mm and of a sum
    assert [(mend.what, round(mend.moved, 12)) for mend in made.mends] == [
        ("hinge extended", 3e-5),
        ("hinge extended", 2e-5),
    ]
    assert any("healed: hinge extended: 2, by up to 0.03 mm: (20, 0) mm" in each for each in told)
    plain, _ = small(tmp_path, BODY, short)
    np.testing.assert_allclose(
        plain.hinges[0].lines[0].line, ((0.02, 3e-5), (0.02, 0.01998)), rtol=0.0, atol=1e-15
    )
    assert plain.mends == ()


def test_a_drawing_lies_where_the_design_says(tmp_path: Path) -> None:
    """`at`, by a parameter too: shapes, hinge lines and mends go with it; what is told is the drawing's own place."""
    body = BODY.replace("M0 0 L40 0", "M0.03 0 L40 0")
    text = SMALL.replace("layer: body}", "layer: body, heal: 50 um, at: [dx, -3]}")
    text = text.replace("layer: joint}", "layer: joint, at: [dx, -3]}").replace(
        "[0, 0, 5, 20]", "[7, -3, 12, 17]"
    )
    made, told = small(tmp_path, body, text=f"{text}parameters: {{dx: 7 mm}}\n")
    plain, _ = small(tmp_path, BODY)
    for dx, moved in ((7e-3, made), (9e-3, made.with_parameters({"dx": 9e-3}))):
        low_x, low_y, high_x, high_y = moved.layers[0].geometry.bounds
        expected = (dx, -3e-3, dx + 40e-3, 17e-3)
        np.testing.assert_allclose((low_x, low_y, high_x, high_y), expected, rtol=0.0, atol=1e-15)
        lines = [each.line for each in moved.hinges[0].lines]
        drawn = np.array([each.line for each in plain.hinges[0].lines]) + np.array([dx, -3e-3])
        np.testing.assert_allclose(lines, drawn, rtol=0.0, atol=1e-15)  # m: round-off of a sum
        assert [mend.at for mend in moved.mends] == [pytest.approx((dx, -3e-3))]
    assert any("healed: gap in an outline: 1, by up to 0.03 mm: (0, 0) mm" in each for each in told)
    assert lamc.split(made).bodies[0].fixed
    short = '<path d="M20 0 V19.98" id="j1"/>'
    _, told = small(
        tmp_path, BODY, short, SMALL.replace("layer: joint}", "layer: joint, heal: 0.1 mm, at: [7, -3]}")
    )
    assert not any("hinge extended" in each for each in told)  # there is no edge of the material there
    moved = SMALL.replace("layer: body}", "layer: body, at: [7, -3]}")
    moved = moved.replace("layer: joint}", "layer: joint, heal: 0.1 mm, at: [7, -3]}")
    made, told = small(tmp_path, BODY, short, moved)
    assert any("hinge extended: 1, by up to 0.02 mm: (20, 20) mm" in each for each in told)
    assert [mend.at for mend in made.mends] == [pytest.approx((0.027, 0.017))]
    with pytest.raises(
        lamc.DesignError, match=r"coordinate of 1e\+16 m; it must be finite and within 1e\+06 m"
    ):
        small(tmp_path, text=SMALL.replace("layer: body}", "layer: body, at: [1e16 m, 0]}"))


def test_mends_are_kept_told_and_drawn(tmp_path: Path) -> None:
    body = BODY.replace("M0 0 L40 0", "M0.03 0 L40 0")
    with pytest.raises(
        lamc.DesignError, match=r"small.yaml:5:12: .*top.svg: .* 0.03 mm .*heal more: heal: '0.031 mm'"
    ):
        small(tmp_path, body)
    healing = SMALL.replace("layer: body}", "layer: body, heal: 50 um}")
    made, told = small(tmp_path, body, JOINT + '<path d="M20 20 V5"/>', healing)
    assert sorted(mend.what for mend in made.mends) == ["doubled line", "gap in an outline"]
    assert all(mend.source.startswith("top.svg: ") for mend in made.mends)
    assert any(
        "small.yaml:5:12: top.svg: healed: gap in an outline: 1, by up to 0.03 mm" in each for each in told
    )
    assert lamc.split(made).mends == made.mends
    out = tmp_path / "out"
    done = CliRunner().invoke(main, ["split", str(tmp_path / "small.yaml"), "--json", "--out", str(out)])
    assert done.exit_code == 0
    data = json.loads(done.stdout)
    assert [mend["what"] for mend in data["mends"]] == [mend.what for mend in made.mends]
    assert (out / "split.png").stat().st_size > 0


@pytest.mark.parametrize(
    ("entry", "match"),
    [
        ("{file: nix.svg}", "small.yaml:7:25: .*nix.svg: .*no such file"),
        ("{file: ../top.svg}", "without folders"),
        ("{file: /etc/passwd}", "without folders"),
        ("{file: 'C:top.svg'}", "without folders"),
        ("{file: ..}", "without folders"),
        ("{file: link.svg}", "leads out of its folder"),
        ("{file: small.yaml}", "no drawing"),
        ("{file: top.svg, layer: joints}", "no layer 'joints'; its layers are body, joint"),
        ("{file: top.svg, heal: -1}", "heal"),
        ("{file: top.svg, roles: {red: cute}}", "roles.red"),
        ("{fil: top.svg}", "did you mean 'file'"),
        ("{}", "missing"),
        ("[[1, 2]]", r"lines\[0\]\[0\]: a list"),
        ("[]", "either line"),
    ],
)
def test_what_cannot_be_is_refused_at_its_line(tmp_path: Path, entry: str, match: str) -> None:
    outside = tmp_path / "elsewhere.svg"
    outside.write_text(svg({}), encoding="utf-8")
    folder = tmp_path / "design"
    folder.mkdir()
    (folder / "link.svg").symlink_to(outside)
    with pytest.raises(lamc.DesignError, match=match):
        small(folder, text=SMALL.replace("{file: top.svg, layer: joint}", entry))


def test_a_text_without_a_folder_has_no_drawings() -> None:
    with pytest.raises(lamc.DesignError, match="load the file by its path"):
        load_text(SMALL, "small.yaml")


def test_drawings_count_against_the_limit_of_bytes(tmp_path: Path) -> None:
    small(tmp_path)
    with pytest.raises(lamc.DesignError, match=r"top.svg: .*bytes"):
        lamc.load(tmp_path / "small.yaml", limits=lamc.Limits(bytes=len(SMALL) + 10))


def test_a_layer_that_is_named_counts_whatever_its_colours_say() -> None:
    ring = line((0, 0), (10, 0), (10, 10), (0, 10), role="mountain", closed=True, layer="top")
    assert shape_of(drawing(ring), "top", None)[0].area == pytest.approx(100e-6)
    with pytest.raises(lamc.DesignError, match="has no outlines"):
        shape_of(drawing(ring), None, None)
    both = drawing(ring, line((0, 0), (5, 5), role="hinge", layer="top"))
    assert len(lines_of(both, "top", None)[0]) == 5


def test_shapes_take_holes_by_turns_and_by_role() -> None:
    rings = [square(0, 0, 40), square(10, 10, 20), square(15, 15, 10), square(-5, -5, 10, "hole")]
    region, mends = shape_of(drawing(*rings), None, None)
    assert region.area == pytest.approx(1e-6 * (1600 - 400 + 100 - 25))
    assert mends == ()


def test_crossing_hinge_lines_stay_whole_and_keep_their_direction() -> None:
    found, mends = lines_of(drawing(line((10, 5), (0, 5)), line((5, 10), (5, 0))), None, None)
    assert found == (
        (pytest.approx((10e-3, 5e-3)), pytest.approx((0.0, 5e-3))),
        (pytest.approx((5e-3, 10e-3)), pytest.approx((5e-3, 0.0))),
    )
    assert mends == ()


@settings(max_examples=tries(200), deadline=None)
@given(
    strokes=st.lists(
        st.tuples(
            st.lists(
                st.tuples(st.integers(0, 5), st.integers(0, 5) | st.floats(0, 5)), min_size=2, max_size=5
            ),
            st.sampled_from(ROLES),
            st.booleans(),
        ),
        min_size=1,
        max_size=8,
    ),
    heal=st.sampled_from([None, 0.0, 1e-5, 2e-3]),
)
def test_any_lines_are_a_shape_or_refused(strokes: Any, heal: float | None) -> None:
    drawn = drawing(*(line(*points, role=role, closed=closed) for points, role, closed in strokes))
    for take in (shape_of, lines_of):
        try:
            found, _ = take(drawn, None, heal)
        except lamc.DesignError:
            continue
        if take is shape_of:
            assert found.is_valid
            assert 0.0 < found.area <= 36e-6
        else:
            assert all(start != end for start, end in found)


def test_the_tolerance_is_of_the_whole_drawing_whatever_the_layer() -> None:
    """1e-4 of 100 mm bridges 8 um in a layer that is 10 mm wide."""
    open_ring = line((0, 0), (10, 0), (10, 10), (0, 10), (0, 0.008), role="border", layer="small")
    large = line((-45, -45), (55, -45), (55, 55), role="border", layer="large")
    region, mends = shape_of(drawing(open_ring, large), "small", None)
    assert region.area == pytest.approx(100e-6)
    assert [mend.what for mend in mends] == ["gap in an outline"]
    with pytest.raises(lamc.DesignError, match=r"0.008 mm from"):
        shape_of(drawing(open_ring), None, None)

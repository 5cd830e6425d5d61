"""DXF files of every version: which lines they show, where, for what; units; what is told, what is refused; fuzz."""

import cmath
import math
import time
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import DesignError, LamcError
from lamc.readers.drawings.dxf import read_dxf
from lamc.readers.drawings.dxf_tags import is_dxf
from lamc.readers.inert import Limits
from lamc.records.card import SheetOptions
from lamc.records.drawing import Drawing, Stroke
from tests.support import dxf_corpus as corpus
from tests.support import fold_corpus
from tests.support.dxf_corpus import block, claims, data_of, drawing, entity, insert, line, text
from tests.support.quick import tries

PATTERNS = {
    "miura": fold_corpus.miura(3, 2),
    "waterbomb": fold_corpus.waterbomb(),
    "yoshimura": fold_corpus.yoshimura(2, 2),
    "kresling": fold_corpus.kresling(3, 2),
    "box": fold_corpus.box_net(),
}
PATIENCE = 20.0  # s: no file takes longer
ROUNDING = 1e-15  # m: of coordinates of some 0.1 m, given in mm


def read(data: bytes, units: str | None = "mm", **options: Any) -> Drawing:
    return read_dxf(data, "sheet.dxf", SheetOptions(units=units, **options), Limits())


def only(data: bytes, **options: Any) -> Stroke:
    (stroke,) = read(data, **options).strokes
    return stroke


def refused(data: bytes, **options: Any) -> str:
    with pytest.raises(DesignError) as error:
        read(data, **options)
    return str(error.value)


def told(data: bytes, **options: Any) -> str:
    return "\n".join(read(data, **options).notes)


def mm(stroke: Stroke) -> np.ndarray:
    """x + iy of its points, mm."""
    return 1e3 * (stroke.points[:, 0] + 1j * stroke.points[:, 1])


def area(points: np.ndarray) -> float:
    """Of a closed polyline, positive for counterclockwise."""
    return 0.5 * float(np.imag(np.conj(points) * np.roll(points, -1)).sum())


# Versions and forms


@pytest.mark.parametrize("pattern", sorted(PATTERNS))
@pytest.mark.parametrize(("version", "fmt"), corpus.FORMS)
def test_each_version_holds_the_same_lines(pattern: str, version: str, fmt: str) -> None:
    data = PATTERNS[pattern]
    unit = data["frame_unit"]
    found = read(corpus.pattern(data, version, fmt), units=unit if version == "R12" else None)
    scale = {"mm": 1e-3, "cm": 1e-2}[unit]
    assert found.notes == () or all("rest at" in note for note in found.notes)
    assert found.scale == scale
    for k, (stroke, ends) in enumerate(zip(found.strokes, data["edges_vertices"], strict=True)):
        drawn = scale * np.array([data["vertices_coords"][v][:2] for v in ends])
        assert np.abs(stroke.points - drawn).max() <= ROUNDING
        assert stroke.role == corpus.LAYERS[data["edges_assignment"][k]]
        assert stroke.layer == corpus.layer_of(data, k)
        assert stroke.angle == (math.radians(90) if stroke.layer == "valley_90" else None)


@pytest.mark.parametrize(("version", "fmt"), corpus.FORMS)
def test_a_laminate_has_outlines_holes_and_joints(version: str, fmt: str) -> None:
    strokes = read(corpus.four_bar(version, fmt)).strokes
    assert [stroke.role for stroke in strokes] == ["border", "hole", *4 * ["hinge"]]
    assert [stroke.closed for stroke in strokes] == [True, True, *4 * [False]]
    assert area(mm(strokes[0])) == pytest.approx(2500.0, abs=1e-9)


@pytest.mark.parametrize("kind", sorted(corpus.ENTITIES))
@pytest.mark.parametrize("marks", [True, False])
@pytest.mark.parametrize("version", ["", "AC1009", "AC1014", "AC1015", "AC1032"])
def test_entities_are_read_as_other_programs_write_them(version: str, kind: str, marks: bool) -> None:
    """Files without a header, or of R12, with entities of later versions; entities without their classes' marks."""
    inside = block("A", line(1, 1, 2, 2, "77", "0")) if kind == "INSERT" else ""
    stroke = only(text(entity(kind, marks=marks), blocks=inside, version=version))
    wanted = f"{kind} 2F" if kind != "INSERT" else "LINE 77 of block 'A' (INSERT 2F)"
    assert (stroke.source, stroke.layer, stroke.role) == (wanted, "body", "border")


def test_names_of_layers_keep_their_umlauts() -> None:
    for version, page in (("AC1009", "ANSI_1252"), ("AC1015", "ANSI_1252")):
        data = text(
            line(0, 0, 1, 0, layer="Gehäuse"), version=version, header=f"9\n$DWGCODEPAGE\n3\n{page}\n"
        )
        assert only(data, roles={"Gehäuse": "cut"}).layer == "Gehäuse"
    made, space = drawing("R2018")
    space.add_line((0, 0), (1, 0), dxfattribs={"layer": "Mündung_折"})
    assert only(data_of(made), roles={"Mündung_折": "cut"}).role == "cut"


@pytest.mark.parametrize(
    ("start", "what"),
    [
        (b"0\nSECTION\n2\nENTITIES\n", True),
        (b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n", True),
        (b"\xef\xbb\xbf999\nmade by hand\n0\nSECTION\n2\n", True),
        (b"AutoCAD Binary DXF\r\n\x1a\x00\x00", True),
        (b"layers:\n- 0\n", False),
        (b'{"file_spec": 1}', False),
        (b"<svg/>", False),
        (b"", False),
    ],
)
def test_dxf_is_known_by_its_first_bytes(start: bytes, what: bool) -> None:
    assert is_dxf(start) is what


# Curves


def test_a_bulge_is_an_arc_to_the_right_of_its_chord() -> None:
    made, space = drawing()
    space.add_lwpolyline([(0, 0, 1.0), (10, 0, 0.0)], format="xyb", close=True)
    points = mm(only(data_of(made)))
    assert np.abs(abs(points - 5.0) - 5.0).max() < 1e-12  # the half circle about (5, 0)
    assert points.imag.min() == pytest.approx(
        -5.0, abs=1e-3
    )  # below: counterclockwise from (0, 0) to (10, 0)
    # Chords are 5e-5 of the drawing's size off at most: of a half disc of 39.3 mm^2, 15.7 mm times that.
    size = math.hypot(10.0, 5.0)
    assert 0.0 < 12.5 * math.pi - area(points) < 15.71 * 5e-5 * size


@pytest.mark.parametrize("extrusion", [(0, 0, 1), (0, 0, -1)])
def test_an_arc_is_mirrored_by_its_extrusion(extrusion: tuple[int, int, int]) -> None:
    made, space = drawing()
    space.add_arc((2, 1), 5, 30, 120, dxfattribs={"extrusion": extrusion})
    points = mm(only(data_of(made)))
    wanted = [complex(2, 1) + 5 * cmath.exp(1j * math.radians(turn)) for turn in (30, 120)]
    if extrusion[2] < 0:  # x of object coordinates is -x of the world: the arbitrary axis algorithm
        wanted = [-each.conjugate() for each in wanted]
    assert abs(points[[0, -1]] - wanted).max() < 1e-12
    centre = complex(2 * extrusion[2], 1)
    assert np.abs(abs(points - centre) - 5.0).max() < 1e-12


def test_an_ellipse_lies_on_its_equation() -> None:
    made, space = drawing()
    space.add_ellipse((1, 2), major_axis=(3, 4), ratio=0.4)
    stroke = only(data_of(made))
    along = (mm(stroke) - complex(1, 2)) / complex(0.6, 0.8)
    assert stroke.closed
    assert np.abs((along.real / 5) ** 2 + (along.imag / 2) ** 2 - 1).max() < 1e-12


def test_a_rational_spline_is_the_circle_that_it_says() -> None:
    made, space = drawing()
    half = math.sqrt(0.5)
    space.add_rational_spline([(5, 0), (5, 5), (0, 5)], [1, half, 1], degree=2, knots=[0, 0, 0, 1, 1, 1])
    points = mm(only(data_of(made)))
    assert np.abs(abs(points) - 5.0).max() < 1e-12
    assert len(points) > 10
    assert abs(points[[0, -1]] - [5, 5j]).max() < 1e-12


def test_polylines_of_two_and_three_dimensions_and_solids() -> None:
    made, space = drawing("R12")
    space.add_polyline2d([(0, 0, 1), (10, 0, 0)], format="xyb", dxfattribs={"elevation": (0, 0, 3)})
    space.add_polyline3d([(0, 0, 3), (10, 0, 3), (10, 10, 3)], close=True)
    space.add_solid([(0, 0, 3), (1, 0, 3), (0, 1, 3), (1, 1, 3)])
    arc, triangle, square = read(data_of(made)).strokes
    assert np.abs(abs(mm(arc) - 5.0) - 5.0).max() < 1e-12
    assert (triangle.closed, area(mm(triangle))) == (True, pytest.approx(50.0, abs=1e-9))
    assert (square.closed, area(mm(square))) == (True, pytest.approx(1.0, abs=1e-9))


def test_a_hatch_gives_its_outlines() -> None:
    made, space = drawing()
    hatch = space.add_hatch(dxfattribs={"layer": "body"})
    hatch.paths.add_polyline_path([(0, 0), (30, 0), (30, 20), (0, 20)])
    path = hatch.paths.add_edge_path()
    path.add_arc((15, 10), 5, 0, 360, ccw=False)
    path = hatch.paths.add_edge_path()
    path.add_line((2, 2), (4, 2))
    path.add_ellipse((3, 2), (1, 0), 0.5, 0, 180)
    drawn = read(data_of(made))
    rim, hole, *moon = drawn.strokes
    assert area(mm(rim)) == 600.0
    assert hole.closed
    assert np.abs(abs(mm(hole) - (15 + 10j)) - 5.0).max() < 1e-12
    assert abs(mm(moon[1])[[0, -1]] - [4 + 2j, 2 + 2j]).max() < 1e-12
    assert "the outlines of 1 HATCH" in drawn.notes[0]


# Blocks


def test_inserted_blocks_are_moved_turned_scaled_and_repeated() -> None:
    made, space = drawing()
    arm = made.blocks.new("ARM", base_point=(1, 2))
    arm.add_line((1, 2), (4, 3))
    arm.add_circle((2, 2), 1)
    pair = made.blocks.new("PAIR")
    pair.add_blockref("ARM", (5, 0), dxfattribs={"xscale": 2, "yscale": -0.5, "rotation": 30})
    space.add_blockref(
        "PAIR",
        (100, 50),
        dxfattribs={
            "xscale": -1,
            "yscale": 3,
            "rotation": 70,
            "row_count": 2,
            "column_count": 3,
            "row_spacing": 40,
            "column_spacing": 20,
        },
    )
    strokes = read(data_of(made)).strokes
    inner = corpus.moved(5 + 0j, 30, 2, -0.5, base=1 + 2j)
    turn = cmath.exp(1j * math.radians(70))
    places = [100 + 50j + turn * complex(20 * column, 40 * row) for row in range(2) for column in range(3)]
    for at, lined, ringed in zip(places, strokes[::2], strokes[1::2], strict=True):
        outer = corpus.moved(at, 70, -1, 3)
        assert abs(mm(lined) - [outer(inner(z)) for z in (1 + 2j, 4 + 3j)]).max() < 1e-11
        # Back in the block's coordinates the ellipse is the circle.
        back = [_undone(z, at, 70, -1, 3) for z in mm(ringed)]
        circle = np.array([_undone(z, 5, 30, 2, -0.5) + 1 + 2j for z in back])
        assert np.abs(abs(circle - (2 + 2j)) - 1.0).max() < 1e-11


def _undone(z: complex, at: complex, turn: float, across: float, up: float) -> complex:
    z = (z - at) * cmath.exp(-1j * math.radians(turn))
    return complex(z.real / across, z.imag / up)


def test_a_mirrored_insert_mirrors() -> None:
    made, space = drawing()
    made.blocks.new("ARM").add_line((1, 2), (4, 3))
    space.add_blockref("ARM", (10, 0), dxfattribs={"extrusion": (0, 0, -1)})
    assert abs(mm(only(data_of(made))) - [-11 + 2j, -14 + 3j]).max() < 1e-12


def test_what_blocks_take_from_where_they_are_inserted() -> None:
    """Layer 0 is the INSERT's layer; BYBLOCK is its colour, BYLAYER that of the layer."""
    made, space = drawing()
    made.layers.add("red", color=1)
    made.layers.add("shop", color=5)
    arm = made.blocks.new("ARM")
    arm.add_line((0, 0), (1, 0), dxfattribs={"layer": "0", "color": 256})
    arm.add_line((0, 1), (1, 1), dxfattribs={"layer": "red", "color": 0})
    arm.add_line((0, 2), (1, 2), dxfattribs={"layer": "red", "color": 256})
    arm.add_line((0, 3), (1, 3), dxfattribs={"layer": "fold", "color": 0})
    space.add_blockref("ARM", (0, 0), dxfattribs={"layer": "shop", "color": 6})
    strokes = read(data_of(made)).strokes
    assert [s.layer for s in strokes] == ["shop", "red", "red", "fold"]
    assert [s.role for s in strokes] == ["valley", "undriven", "mountain", "undriven"]


def test_blocks_without_end_are_refused() -> None:
    ring = block("A", insert("B")) + block("B", insert("A"))
    assert "inserts block 'a' in 'b' in 'a': a block within itself" in refused(
        text(insert("A") + line(0, 0, 1, 0), blocks=ring)
    )
    # Nobody inserts it: nothing is lost.
    assert len(read(text(line(0, 0, 1, 0), blocks=ring)).strokes) == 1


def test_bombs_of_blocks_are_counted_not_made() -> None:
    began = time.monotonic()
    assert "5.49756e+12 entities" in refused(text(insert("A0"), blocks=corpus.bomb(40)))
    assert "limit 'values'" in refused(
        text(insert("E", "70\n30000\n71\n30000\n44\n1\n45\n1\n"), blocks=block("E", ""))
    )
    assert read(text(line(0, 0, 1, 0), blocks=corpus.bomb(40))).strokes
    deep = "".join(block(f"A{k}", insert(f"A{k + 1}")) for k in range(500)) + block("A500", "")
    assert "limit 'depth' of 100" in refused(text(insert("A0"), blocks=deep))
    assert time.monotonic() - began < PATIENCE


def test_what_other_files_hold_is_not_fetched() -> None:
    outside = block("X", "", flags=4).replace("\n1\n\n", "\n1\n/etc/passwd\n")
    notes = told(text(insert("X") + line(0, 0, 1, 0), blocks=outside))
    assert "reference to another file, '/etc/passwd', which is not fetched" in notes


def test_blocks_that_are_missing_are_told() -> None:
    assert "without required BLOCK" in told(text(insert("GONE") + line(0, 0, 1, 0)))


# What lines are for


@pytest.mark.parametrize(
    ("attributes", "role"),
    [
        ({"color": 1}, "mountain"),
        ({"color": 5}, "valley"),
        ({"color": 7}, "border"),
        ({"color": 3}, "cut"),
        ({"color": 2}, "flat"),
        ({"color": 6}, "undriven"),
        ({"true_color": 0xFF0000, "color": 5}, "mountain"),
        ({"true_color": 0xFFFFFF}, "border"),
        ({"layer": "red"}, "mountain"),
        ({"layer": "Cuts", "color": 1}, "cut"),
        ({"layer": "FOLD", "color": 5}, "valley"),
        ({"layer": "hinge_mountain", "color": 5}, "mountain"),
    ],
)
def test_layers_and_colours_say_what_lines_are_for(attributes: dict[str, Any], role: str) -> None:
    made, space = drawing()
    made.layers.add("red", color=1)
    space.add_line((0, 0), (10, 0), dxfattribs=attributes)
    assert only(data_of(made)).role == role


def test_a_mapping_comes_first_and_what_nobody_knows_is_told() -> None:
    data = text(line(0, 0, 10, 0, layer="body") + line(0, 5, 10, 5, "30", "30"))
    assert [s.role for s in read(data, roles={"30": "cut", "BODY": "hole"}).strokes] == ["hole", "cut"]
    assert "no line is of the colour or layer 'purpel'" in told(data, roles={"purpel": "cut"})
    made, space = drawing()
    space.add_line((0, 0), (10, 0), dxfattribs={"layer": "Ebene 3", "color": 30})
    space.add_line((0, 5), (10, 5))
    drawn = read(data_of(made))
    assert [s.role for s in drawn.strokes] == ["ignore", "border"]
    assert "1 line on layer 'Ebene 3', colour #ff7f00 (--role 'Ebene 3=cut'" in drawn.notes[0]


@pytest.mark.parametrize(
    ("layer", "colour", "role", "degrees"),
    [
        ("mountain_90", 7, "mountain", -90),
        ("fold(-45)", 7, "mountain", -45),
        ("fold(45)", 7, "valley", 45),
        ("fold_45", 1, "mountain", -45),
        ("valley 30 deg", 7, "valley", 30),
        ("mountain", 7, "mountain", None),
    ],
)
def test_layers_say_where_creases_rest(layer: str, colour: int, role: str, degrees: float | None) -> None:
    made, space = drawing()
    space.add_line((0, 0), (10, 0), dxfattribs={"layer": layer, "color": colour})
    drawn = read(data_of(made))
    (stroke,) = drawn.strokes
    assert stroke.role == role
    if degrees is None:
        assert stroke.angle is None
    else:
        assert stroke.angle == pytest.approx(math.radians(degrees), abs=1e-15)
        assert f"creases on layer {layer!r} rest at {degrees} degrees, as its name says" in drawn.notes


def test_what_is_no_line_or_not_shown_is_told() -> None:
    made, space = drawing()
    for name, method in (("frozen", "freeze"), ("off", "off")):
        getattr(made.layers.add(name), method)()
        space.add_line((0, 0), (1, 0), dxfattribs={"layer": name})
    space.add_line((0, 0), (1, 0), dxfattribs={"invisible": 1})
    space.add_text("a")
    space.add_mtext("b")
    space.add_point((1, 1))
    space.add_xline((1, 1), (1, 0))
    space.add_3dface([(0, 0), (1, 0), (1, 1)])
    made.blocks.new("ARM").add_line((0, 0), (1, 0))
    space.add_blockref("ARM", (0, 0), dxfattribs={"layer": "frozen"})
    space.add_line((0, 0), (10, 0))
    made.layout("Layout1").add_line((0, 0), (9, 9))
    drawn = read(data_of(made))
    assert len(drawn.strokes) == 1
    notes = "\n".join(drawn.notes)
    for wanted in (
        *("1 MTEXT, 1 POINT, 1 TEXT", "1 3DFACE (faces in space"),
        *("1 XLINE (lines without an end)", "2 on layer 'frozen', frozen", "1 on layer 'off', off"),
        *("1 invisible entities", "paper space 'Layout1' has 1 entities"),
    ):
        assert wanted in notes, wanted


@pytest.mark.parametrize("kind", ["REGION", "3DSOLID", "ACAD_PROXY_ENTITY", "IMAGE", "OLE2FRAME", "ODD"])
def test_what_cannot_be_lines_is_told_by_its_kind(kind: str) -> None:
    notes = told(text(f"0\n{kind}\n5\n40\n100\nAcDbEntity\n8\n0\n" + line(0, 0, 10, 0)))
    assert f"1 {kind}" in notes


def test_an_empty_model_space_says_where_the_lines_are() -> None:
    made, _ = drawing()
    made.layout("Layout1").add_line((0, 0), (9, 9))
    assert "the model space is empty; paper space 'Layout1' has 1 entities" in refused(data_of(made))


# Units


@pytest.mark.parametrize(
    ("unit", "width", "scale"),
    [(4, 117.0, 1e-3), (5, 11.7, 1e-2), (6, 0.117, 1.0), (1, 4.6, 0.0254), (13, 900.0, 1e-6), (6, 4.9, 1.0)],
)
def test_a_unit_that_can_be_true_is_taken(unit: int, width: float, scale: float) -> None:
    drawn = read(text(line(0, 0, width, 0), header=claims(unit)), units=None)
    assert (drawn.scale, drawn.notes) == (scale, ())
    assert drawn.strokes[0].points[1, 0] == pytest.approx(width * scale, rel=1e-15)


@pytest.mark.parametrize(
    ("header", "width", "words"),
    [
        (
            claims(6),
            117.0,
            "$INSUNITS says m, and the drawing would be 117 m wide: --units mm (117 mm wide) or",
        ),
        (claims(6), 5.1, "$INSUNITS says m, and the drawing would be 5.1 m wide: --units mm (5.1 mm wide)"),
        (
            claims(2),
            300.0,
            "$INSUNITS says ft, and the drawing would be 91.44 m wide: --units mm (300 mm wide)",
        ),
        (
            claims(4),
            0.117,
            "$INSUNITS says mm, and the drawing would be 117 um wide: --units in (2.972 mm wide)",
        ),
        (claims(18), 3.0, "$INSUNITS says astronomical unit"),
        (
            "",
            9000.0,
            "the file says no unit ($INSUNITS), and in mm the drawing would be 9 m wide: --units um",
        ),
        ("", 1e9, "1000 km wide: --units mm, or another, says which it is"),
    ],
)
def test_a_unit_that_cannot_be_true_is_asked_for(header: str, width: float, words: str) -> None:
    data = text(line(0, 0, width, 0), header=header)
    assert words in refused(data, units=None)
    assert read(data, units="mm").notes == ()  # what the user says is not asked again


def test_no_unit_is_taken_for_millimetres_and_told() -> None:
    for header in ("", claims(0), "9\n$MEASUREMENT\n70\n0\n" + claims(0)):
        notes = told(text(line(0, 0, 117, 0), header=header), units=None)
        assert "1 is taken for 1 mm, and the drawing is 117 mm wide" in notes
        assert ("imperial" in notes) == ("$MEASUREMENT" in header)


# Space


def test_a_drawing_lies_in_one_plane() -> None:
    tilted = entity("LINE").replace("31\n0\n", "31\n5\n")
    assert "LINE 2F on layer 'body' goes from z = 0 at (1, 2) mm to z = 5" in refused(text(tilted))
    above = line(0, 5, 10, 5, "30").replace("0.0\n", "2.5\n")
    assert "laid in one plane: z from 0 mm (LINE 2F) to 2.5 mm (LINE 30)" in told(
        text(line(0, 0, 10, 0) + above)
    )
    level = line(0, 0, 10, 0).replace("0.0\n", "7.0\n")
    assert told(text(level)) == ""


@pytest.mark.parametrize("value", ["nan", "inf", "1e999", "-1e13", "1e300"])
@pytest.mark.parametrize("kind", ["LINE", "LWPOLYLINE", "CIRCLE", "SPLINE", "ELLIPSE"])
def test_numbers_that_are_none_or_too_large_are_refused(kind: str, value: str) -> None:
    wrong = entity(kind).replace("10\n1\n", f"10\n{value}\n")
    message = refused(text(wrong + line(0, 0, 10, 0, "30")))
    assert f"{kind} 2F on layer 'body' has " in message
    assert "not finite" in message or "up to 1e+12 is read" in message


def test_lines_without_a_length_are_told() -> None:
    notes = told(text(line(3, 4, 3, 4) + line(0, 0, 10, 0, "30")))
    assert "left out: 1 lines without a length (first LINE 2F at (3, 4) mm)" in notes


# Damage


def test_a_file_that_is_cut_off_loses_its_last_entity_and_says_so() -> None:
    """Wherever it ends: a half-written line would end at the origin, or at half a number."""
    whole = text(line(1, 2, 3, 4, "2F") + line(5, 6, 7, 8, "30"))
    second, end = whole.index(b"0\nLINE\n5\n30"), whole.index(b"0\nENDSEC\n0\nEOF")
    for at in range(second + 7, end - 1, 3):
        drawn = read(whole[:at])
        assert [s.source for s in drawn.strokes] == ["LINE 2F"]
        assert "it ends without EOF, and LINE" in drawn.notes[0]
    assert "may be cut off" in read(whole[: end + 9]).notes[0]
    for version in ("R12", "R2010"):
        binary = corpus.four_bar(version, "bin")
        cut = read(binary[: binary.rindex(b"\x00LINE\x00") + 60])
        assert len(cut.strokes) == 5
        assert "cut off" in cut.notes[0]


def test_entities_of_one_handle_are_all_read() -> None:
    drawn = read(text(line(0, 0, 1, 0, "2F") + line(0, 1, 1, 1, "2F") + line(0, 2, 1, 2, "2f")))
    assert [s.source for s in drawn.strokes] == ["LINE 2F", "LINE number 2", "LINE number 3"]
    assert "2 entities have a handle that something else has too (first LINE 2F)" in drawn.notes[0]


def test_entities_without_handles_are_numbered() -> None:
    lines = "".join(line(0, k, 1, k).replace("5\n2F\n", "") for k in range(3))
    for version in ("", "AC1009", "AC1015"):
        sources = [s.source for s in read(text(lines, version=version)).strokes]
        assert sources == ["LINE number 1", "LINE number 2", "LINE number 3"]


@pytest.mark.parametrize(
    ("kind", "taken", "words"),
    [
        ("LINE", "11\n3\n21\n4\n31\n0\n", "LINE 2F: it has no end"),
        ("CIRCLE", "40\n5\n", "CIRCLE 2F: it has no radius"),
        ("ARC", "50\n0\n", "ARC 2F: it has no start angle"),
        ("LWPOLYLINE", "10\n2\n20\n5\n", "LWPOLYLINE 2F"),
        ("SPLINE", "40\n0\n", "SPLINE 2F"),
    ],
)
def test_entities_that_lack_something_are_told(kind: str, taken: str, words: str) -> None:
    lacking = entity(kind).replace(taken, "", 1)
    drawn = read(text(lacking + line(0, 0, 10, 0, "30")))
    assert [s.source for s in drawn.strokes] == ["LINE 30"]
    assert words in "\n".join(drawn.notes)


@pytest.mark.parametrize("version", ["", "AC1009", "AC1015"])
@pytest.mark.parametrize("behind", ["", line(0, 0, 5, 5, "30"), "0\nTEXT\n5\n30\n8\n0\n1\nx\n"])
def test_polylines_end_where_the_file_forgets_to_say_so(version: str, behind: str) -> None:
    corners = "".join(f"0\nVERTEX\n5\nA{k}\n8\nbody\n10\n{k}\n20\n{k * k}\n30\n0\n" for k in range(4))
    polyline = f"0\nPOLYLINE\n5\n2F\n8\nbody\n66\n1\n70\n1\n{corners}"
    attributed = insert("A").replace("8\n0\n", "5\n40\n8\n0\n66\n1\n")
    data = text(attributed + polyline + behind, blocks=block("A", line(0, 0, 1, 0, "77")), version=version)
    drawn = read(data)
    assert [s.source for s in drawn.strokes][:2] == ["LINE 77 of block 'A' (INSERT 40)", "POLYLINE 2F"]
    assert np.abs(mm(drawn.strokes[1]) - [k + 1j * k * k for k in range(4)]).max() < 1e-12
    assert len(drawn.strokes) == 2 + ("LINE" in behind)


@pytest.mark.parametrize(
    "wrong",
    ["9\n$ODD\n40\nfoo\n", "9\nNAME\n70\n1\n", "9\n$EXTMIN\n10\n1e999\n9\n$LIMMIN\n", "5\n5\n"],
)
def test_a_header_in_no_order_loses_no_line(wrong: str) -> None:
    """Nor the unit that it says, nor colours and states of layers."""
    tables = (
        "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n2\n0\nLAYER\n2\nred\n70\n0\n62\n1\n6\nCONTINUOUS\n"
        "0\nLAYER\n2\nfar\n70\n1\n62\n7\n6\nCONTINUOUS\n0\nENDTAB\n0\nENDSEC\n"
    )
    data = text(
        line(0, 0, 3, 0, layer="red") + line(0, 0, 300, 0, "30", "far"),
        header=wrong + claims(1),
        version="AC1009",
    ).replace(b"0\nSECTION\n2\nENTITIES", tables.encode() + b"0\nSECTION\n2\nENTITIES")
    drawn = read(data, units=None)
    assert [(s.source, s.role) for s in drawn.strokes] == [("LINE 2F", "mountain")]
    assert drawn.scale == 0.0254
    assert any("layers, blocks and entities alone are read" in note for note in drawn.notes)


def test_what_is_not_dxf_is_refused_at_its_line() -> None:
    assert "sheet.dxf:5: there is 'foo' where a group code should be" in refused(
        b"0\nSECTION\n2\nENTITIES\nfoo\nbar\n"
    )
    assert "the model space shows no line" in refused(b"0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n")


def test_a_million_lines_are_refused_by_the_name_of_the_limit() -> None:
    body = "0\nLINE\n8\nb\n10\n1\n20\n2\n11\n3\n21\n4\n" * 1_000_000
    began = time.monotonic()
    assert "6000009 groups (a code and a value); the limit 'values' of 400000" in refused(text(body))
    assert time.monotonic() - began < PATIENCE


def test_curves_of_too_many_points_are_refused() -> None:
    circles = "".join(f"0\nCIRCLE\n8\nbody\n10\n0\n20\n0\n40\n{k}\n" for k in range(100, 1100))
    with pytest.raises(DesignError, match="limit 'values'"):
        read_dxf(text(circles), "", SheetOptions(units="mm"), Limits(values=10_000))


def test_ezdxf_says_nothing_beside_us(
    capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    read(text(line(0, 0, 1, 0, "2F") + insert("GONE") + entity("HATCH", "31") + "0\nODD\n5\n99\n8\n0\n"))
    assert capfd.readouterr() == ("", "")
    assert caplog.records == []


# Fuzz

SOURCES = [
    corpus.pattern(fold_corpus.waterbomb(), "R12"),
    corpus.four_bar("R2000"),
    corpus.four_bar("R2007", "bin"),
    corpus.four_bar("R12", "bin"),
    text(
        "".join(entity(kind, f"{k + 16:X}") for k, kind in enumerate(corpus.ENTITIES)), blocks=block("A", "")
    ),
]
PIECES = (
    *(
        "0\nSECTION\n",
        "2\nENTITIES\n",
        "2\nBLOCKS\n",
        "0\nENDSEC\n",
        "0\nEOF\n",
        "0\nBLOCK\n2\nA\n",
        "0\nENDBLK\n",
    ),
    *(entity(kind) for kind in corpus.ENTITIES),
    *(entity(kind, "", marks=False) for kind in corpus.ENTITIES),
    *(
        "10\nnan\n",
        "40\n-1e300\n",
        "70\n-32768\n",
        "42\ninf\n",
        "210\n0\n220\n0\n230\n0\n",
        "41\n0\n",
        "71\n99999\n",
    ),
    *(
        "0\nPOLYLINE\n66\n1\n70\n16\n",
        "0\nVERTEX\n10\n1\n20\n2\n",
        "0\nSEQEND\n",
        "67\n1\n",
        "8\n\udc80\n",
        "62\n-300\n",
    ),
    *(
        "9\n$INSUNITS\n70\n6\n",
        "9\n$ACADVER\n1\nAC1032\n",
        "0\nTABLE\n2\nLAYER\n",
        "0\nLAYER\n2\nbody\n70\n1\n",
        "x\n",
    ),
)
FEW = settings(max_examples=tries(40), deadline=None)


def attempt(data: bytes) -> None:
    """Anything but a drawing or a LamcError escapes and fails the test."""
    began, message = time.monotonic(), ""
    try:
        drawn = read_dxf(data, "fuzzed", SheetOptions(), Limits(bytes=200_000, values=20_000))
        for stroke in drawn.strokes:
            assert np.isfinite(stroke.points).all()
            assert len(stroke.points) >= 2
    except LamcError as error:
        message = str(error)
    assert all(len(one) < 2000 for one in message.splitlines())
    assert time.monotonic() - began < 5.0


@FEW
@given(data=st.binary(max_size=300), binary=st.booleans())
def test_any_bytes_are_a_drawing_or_an_error(data: bytes, binary: bool) -> None:
    attempt((b"AutoCAD Binary DXF\r\n\x1a\x00" if binary else b"0\nSECTION\n2\nENTITIES\n") + data)


@FEW
@given(pieces=st.lists(st.sampled_from(PIECES), max_size=12))
def test_any_mixture_of_groups_is_a_drawing_or_an_error(pieces: list[str]) -> None:
    attempt(("0\nSECTION\n2\nENTITIES\n" + "".join(pieces)).encode("utf-8", "surrogateescape"))


@FEW
@given(data=st.data())
def test_any_damage_is_a_drawing_or_an_error(data: st.DataObject) -> None:
    found = bytearray(data.draw(st.sampled_from(SOURCES)))
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, len(found) - 1))
        length = data.draw(st.integers(0, 40))
        found[at : at + length] = data.draw(
            st.binary(max_size=8) | st.sampled_from([b"\n", b"0", b"-", b"9" * 30])
        )
        if len(found) < 2:
            break
    attempt(bytes(found))


def test_memory_is_bounded_by_the_file() -> None:
    """A polyline that says it has 10^9 corners, an array of 10^9 blocks: what they say is not made room for."""
    greedy = entity("LWPOLYLINE").replace("90\n2\n", "90\n1000000000\n") + insert("E", "70\n30000\n44\n0\n")
    tracemalloc.start()
    read(text(greedy + line(0, 0, 10, 0, "30"), blocks=block("E", "")))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 50e6  # ezdxf with its empty document takes 2e6


def test_a_layer_against_its_colour_and_a_mistyped_one_are_told() -> None:
    made, space = drawing()
    space.add_line((0, 0), (10, 0), {"layer": "hinge_valley", "color": 1})
    space.add_line((0, 5), (10, 5), {"layer": "jonit"})
    space.add_line((0, 9), (10, 9), {"layer": "joint"})
    notes = told(data_of(made))
    assert "1 line on layer 'hinge_valley', colour #ff0000: valley, whatever the colour" in notes
    assert (
        "1 line on layer 'jonit', colour #000000: border, by the colour; if the layer is to be 'joint'"
        in notes
    )
    assert "'joint', colour" not in notes


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("0\nSECTION\n2\nENTITIES\n0\nENDSEC\n0\nEOF\n".encode("utf-16"), "the file is in UTF-16"),
        (b"0\rSECTION\r2\rENTITIES\r0\rENDSEC\r0\rEOF\r", "its lines end by CR alone"),
    ],
)
def test_texts_that_no_reader_of_dxf_takes_are_named(tmp_path: Path, content: bytes, told: str) -> None:
    path = tmp_path / "a.dxf"
    path.write_bytes(content)
    with pytest.raises(LamcError, match=told):
        lamc.load(path)


def test_a_link_to_nothing_is_told(tmp_path: Path) -> None:
    (tmp_path / "loop.dxf").symlink_to("loop.dxf")
    with pytest.raises(LamcError, match=r"a link that leads to no file: .loop\.dxf."):
        lamc.load(tmp_path / "loop.dxf")


def sheet_with(*lines: str) -> bytes:
    """A rectangle of 60 mm by 20 mm on `body`, and lines."""
    rim = [(0.0, 0.0, 60.0, 0.0), (60.0, 0.0, 60.0, 20.0), (60.0, 20.0, 0.0, 20.0), (0.0, 20.0, 0.0, 0.0)]
    return text("".join([*(line(*each, handle=f"A{k}") for k, each in enumerate(rim)), *lines]))


@pytest.mark.parametrize("layer", ["ETCH", "Falten", "Logo"])
def test_a_layer_without_a_meaning_is_told_with_the_way_out(layer: str) -> None:
    """White is what lines have whose colour nobody chose: such circles were holes without a word."""
    found = read(sheet_with(line(20.0, 0.0, 20.0, 20.0, layer=layer)))
    assert found.strokes[-1].role == "border"
    (note,) = [each for each in found.notes if layer in each]
    assert note.startswith(
        f"1 line on layer {layer!r}, colour #000000: border, by the colour (--role '{layer}=hinge'"
    )
    assert not told(sheet_with(line(20.0, 0.0, 20.0, 20.0, layer=layer)), roles={layer: "hinge"})


@pytest.mark.parametrize("layer", ["0", "Layer 2", "body", "outline"])
def test_layers_that_mean_a_rim_or_nothing_are_not_told(layer: str) -> None:
    assert not told(sheet_with(line(20.0, 0.0, 20.0, 20.0, layer=layer)))


def coloured(number: int, layer: str = "0") -> str:
    plain = line(20.0, 0.0, 20.0, 20.0, layer=layer)
    return plain.replace(f"8\n{layer}\n", f"8\n{layer}\n62\n{number}\n")


def test_a_colour_without_a_meaning_is_told_by_what_has_no_other_lines() -> None:
    """A role of layer 0 would be that of the rim too."""
    assert "(--role '#00ffff=cut', or another role)" in told(sheet_with(coloured(4)))
    assert "(--role 'Kante=cut', or another role)" in told(sheet_with(coloured(4, "Kante")))


@pytest.mark.parametrize(("layer", "name"), [("Hinge 45", "hinge(45)"), ("joint_90", "joint(90)")])
def test_a_number_that_counts_layers_of_hinges_is_told_where_it_may_be_an_angle(
    layer: str, name: str
) -> None:
    said = told(sheet_with(line(20.0, 0.0, 20.0, 20.0, layer=layer)))
    assert said.startswith(
        f"creases on layer {layer!r} rest flat: a number behind joint or hinge counts layers"
    )
    assert said.endswith(f"; {name!r} is one of degrees")
    assert not told(sheet_with(line(20.0, 0.0, 20.0, 20.0, layer="hinge 2")))

"""What names of layers, groups and colours say of lines: all of it is told, and a part of a layer is of the layer."""

import math
import warnings
from pathlib import Path

import ezdxf
import pytest

import lamc
from lamc.readers.drawings.layer_shape import shape_of
from lamc.readers.drawings.roles import layer_angle, layer_role, meant_layer
from lamc.readers.drawings.svg import read_svg
from lamc.records.card import SheetOptions

HEAD = (
    '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
    'xmlns:serif="http://www.serif.com/" width="60mm" height="20mm" viewBox="0 0 60 20">'
)
RIM = '<rect width="60" height="20" fill="none" stroke="black"/>'
WINDOW = '<rect x="30" y="5" width="10" height="10" fill="none" stroke="black"/>'
CREASE = '<line x1="20" y1="0" x2="20" y2="20" stroke="{}"/>'


def read(path: Path, **options: object) -> tuple[lamc.Mechanism, list[str]]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = lamc.load(path, card=lamc.Card(), crease=1e-3, **options)  # type: ignore[arg-type]
    assert isinstance(made, lamc.Mechanism)
    return made, [str(each.message) for each in caught]


def drawn(folder: Path, body: str) -> Path:
    path = folder / "sheet.svg"
    path.write_text(f"{HEAD}{body}</svg>", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("name", "degrees"),
    [
        ("mountain-2", None),
        ("mountain 2", None),
        ("mountain_3", None),
        ("mountain -5", -5.0),
        ("mountain(-5)", -5.0),
        ("mountain+5", -5.0),
        ("mountain-45", -45.0),
        ("valley_90", 90.0),
        ("fold-45", -45.0),
        ("mountain 270", None),
        ("mountain 45 copy", -45.0),
        ("Mountain_90_copy_2", -90.0),
        ("valley copy 30", None),
        ("hinge_45", None),  # laminates number their joints
        ("joint 12", None),
        ("hinge(45)", 45.0),
        ("joint(-30)", -30.0),
        ("hinge_45deg", 45.0),
        ("joints 30°", 30.0),
        ("M90", None),
        ("v2", None),
        ("M(90)", -90.0),
        ("M90deg", -90.0),
        ("V(-90)", 90.0),
        ("hinge (2)", None),  # a copy
        ("hinge 45.", None),
        ("hinge(2°)", 2.0),
    ],
)
def test_a_small_number_after_a_hyphen_counts_copies(name: str, degrees: float | None) -> None:
    angle = layer_angle(name)
    assert (None if angle is None else round(math.degrees(angle), 9)) == degrees


@pytest.mark.parametrize(
    ("group", "degrees", "told"),
    [
        ('id="mountain-2" serif:id="mountain 2"', -180.0, False),
        ('id="mountain_45"', -45.0, True),
        ('id="_0_" serif:id="valley 30"', 30.0, True),
    ],
)
def test_an_angle_that_a_name_says_is_told(tmp_path: Path, group: str, degrees: float, told: bool) -> None:
    sheet, notes = read(drawn(tmp_path, f"{RIM}<g {group}>{CREASE.format('black')}</g>"))
    (joint,) = sheet.joints
    assert math.degrees(joint.rest_angle) == pytest.approx(degrees)
    assert any("as its name says" in note for note in notes) == told


@pytest.mark.parametrize(
    "inner",
    [
        f'<g inkscape:groupmode="layer" inkscape:label="details" id="layer2">{WINDOW}</g>',
        f'<g id="hole">{WINDOW}</g>',
        f'<g id="window"><g id="g12">{WINDOW}</g></g>',
        f'<g id="outline">{WINDOW}</g>',
    ],
)
def test_a_group_in_a_layer_is_of_the_layer(inner: str) -> None:
    layer = f'<g inkscape:groupmode="layer" inkscape:label="top" id="layer1">{RIM}{inner}</g>'
    drawing = read_svg(f"{HEAD}{layer}</svg>".encode(), "sheet.svg", SheetOptions(), lamc.Limits())
    region, _ = shape_of(drawing, "top", None)
    assert 1e6 * region.area == pytest.approx(1100.0, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "role"),
    [
        ("M", "mountain"),
        ("v", "valley"),
        ("M layer", "mountain"),
        ("M3", None),
        ("M10", None),
        ("V2", None),
        ("m_90", None),
        ("MS", None),
        ("mes", None),
    ],
)
def test_a_letter_says_a_fold_by_itself_alone(name: str, role: str | None) -> None:
    """M3 is a screw, and v2 a version of a drawing."""
    assert layer_role(name) == role
    assert meant_layer("V_45") == "V(45)"
    assert meant_layer("m -30") == "M(30)"


def test_lines_on_a_layer_for_nothing_are_told_of_dxf_as_of_svg(tmp_path: Path) -> None:
    document = ezdxf.new("R2010", units=4)
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (60, 0), (60, 20), (0, 20)], close=True)
    for k, layer in enumerate(("Engrave", "Engrave", "Notes", "M3")):
        space.add_circle((10 * k + 10, 10), 2, dxfattribs={"layer": layer})
    document.saveas(tmp_path / "sheet.dxf")
    sheet, notes = read(tmp_path / "sheet.dxf")
    for lines in ("2 lines on layer 'Engrave'", "1 line on layer 'Notes'"):
        assert any(
            f"{lines}, colour #000000: left out, as the layer is for nothing" in note for note in notes
        )
    area = 1e6 * sum(slab.polygon.area for body in sheet.bodies for slab in body.outline)
    assert area == pytest.approx(1200.0 - 4.0 * math.pi, rel=1e-4)  # chords of the circle


def test_a_colour_that_is_near_one_is_told_of_dxf_as_of_svg(tmp_path: Path) -> None:
    document = ezdxf.new("R2010", units=4)
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (60, 0), (60, 20), (0, 20)], close=True)
    line = space.add_line((20, 0), (20, 20))
    line.rgb = (0xED, 0x1C, 0x24)
    document.saveas(tmp_path / "sheet.dxf")
    sheet, notes = read(tmp_path / "sheet.dxf")
    assert len(sheet.joints) == 1
    assert any("#ed1c24, taken for red: mountain" in note for note in notes)
    _, notes = read(tmp_path / "sheet.dxf", roles={"#ed1c24": "mountain"})
    assert not any("taken for red" in note for note in notes)


def test_creases_over_one_another_that_rest_apart_are_told(tmp_path: Path) -> None:
    first = CREASE.format("blue").replace("/>", ' stroke-opacity="0.5"/>')
    second = CREASE.format("blue").replace("/>", ' stroke-opacity="0.25"/>')
    sheet, notes = read(drawn(tmp_path, RIM + first + second))
    assert math.degrees(sheet.joints[0].rest_angle) == pytest.approx(90.0)
    assert any("90 degrees counts, not 45 degrees" in note for note in notes)
    _, notes = read(drawn(tmp_path, RIM + first + first))
    assert not any("degrees counts" in note for note in notes)


def test_two_words_for_one_colour_are_refused(tmp_path: Path) -> None:
    path = drawn(tmp_path, RIM + CREASE.format("blue"))
    with pytest.raises(lamc.DesignError, match="'blue' is valley, and '#0000ff' is cut"):
        read(path, roles={"blue": "valley", "#0000ff": "cut"})
    assert len(read(path, roles={"blue": "valley", "#0000ff": "valley"})[0].joints) == 1


@pytest.mark.parametrize(
    ("name", "role"),
    [
        ("Holes copy 3", "hole"),
        ("mountain 45 copy", "mountain"),
        ("body-copy", "border"),
        ("photocopy", None),
    ],
)
def test_a_copy_of_a_layer_is_for_the_same(name: str, role: str | None) -> None:
    assert layer_role(name) == role

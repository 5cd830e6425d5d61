"""Lines of which nothing says what they are for: a design that names their layer says it; a refusal tells them."""

import warnings
from pathlib import Path

import pytest

import lamc
from lamc.basics.errors import DesignWarning
from lamc.readers.drawings.roles import layer_role
from lamc.readers.native_drawings import in_keys
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism

GREY = """<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="20mm" viewBox="0 0 40 20">
  <g id="Teil" fill="none" stroke="#808080"><rect width="40" height="20"/></g>
  <g id="Knick" stroke="#808080"><line x1="15" y1="20" x2="15" y2="0"/></g>
</svg>"""
DESIGN = """units: mm
materials:
  card: {density: 700, rigid: true}
  film: {density: 1390, flexible: true}
layers:
  - {name: low, material: card, thickness: 0.3}
  - {name: hinge, material: film, thickness: 25 um}
  - {name: high, material: card, thickness: 0.3}
shapes:
  - shape: {file: grey.FORMAT, layer: Teil}
hinges:
  - {name: fold, lines: {file: grey.FORMAT, layer: Knick}, gap: 0.4, stiffness: 0.5 N*mm/rad, damping: 1e-6}
fixed:
  - {rect: [0, -20, 5, 20]}
"""


def grey_dxf(path: Path) -> None:
    import ezdxf

    document = ezdxf.new("R2010", units=4)
    for name in ("Teil", "Knick"):
        document.layers.add(name, color=8)
    space = document.modelspace()
    rim = [(0, -20), (40, -20), (40, 0), (0, 0)]
    space.add_lwpolyline(rim, close=True, dxfattribs={"layer": "Teil"})
    space.add_line((15, -20), (15, 0), dxfattribs={"layer": "Knick"})
    document.saveas(path)


@pytest.fixture(params=["svg", "dxf"])
def grey(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    """A drawing of grey lines alone, on layers whose names say nothing; beside it a design that names them."""
    path = tmp_path / f"grey.{request.param}"
    if request.param == "svg":
        path.write_text(GREY)
    else:
        grey_dxf(path)
    (tmp_path / "lid.yaml").write_text(DESIGN.replace("FORMAT", request.param))
    return path


def test_a_design_takes_grey_lines_of_the_layer_that_it_names(grey: Path) -> None:
    design = lamc.load(grey.with_name("lid.yaml"))
    assert isinstance(design, Design)
    mechanism = lamc.split(design)
    assert len(mechanism.bodies) == 2
    assert len(mechanism.joints) == 1


def test_the_notes_of_such_a_design_do_not_say_that_its_lines_are_left_out(grey: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", DesignWarning)
        lamc.load(grey.with_name("lid.yaml"))


def test_other_notes_of_such_a_drawing_are_told(tmp_path: Path) -> None:
    (tmp_path / "grey.svg").write_text(GREY.replace("</svg>", "<text id='t'>a</text></svg>"))
    path = tmp_path / "lid.yaml"
    path.write_text(DESIGN.replace("FORMAT", "svg"))
    with pytest.warns(DesignWarning, match="text #t: is text"):
        lamc.load(path)


def test_a_layer_that_there_is_not_is_refused_with_what_there_is(grey: Path) -> None:
    path = grey.with_name("lid.yaml")
    path.write_text(path.read_text().replace("layer: Teil", "layer: teile"))
    with pytest.raises(lamc.DesignError) as caught:
        lamc.load(path)
    assert f"{grey.name}: " in str(caught.value)
    found = "its layers are Knick, Teil" if grey.suffix == ".dxf" else "each is left out: its colour #808080"
    assert found in str(caught.value)


def test_a_sheet_that_is_refused_tells_what_was_left_out(tmp_path: Path) -> None:
    path = tmp_path / "grey.dxf"
    grey_dxf(path)
    with pytest.warns(DesignWarning, match="1 line on layer 'Knick'"), pytest.raises(lamc.DesignError):
        lamc.load(path)


def test_a_near_colour_on_a_layer_of_folds_is_told(tmp_path: Path) -> None:
    path = tmp_path / "folds.svg"
    path.write_text(
        GREY.replace("Teil", "outline")
        .replace("Knick", "score")
        .replace('score" stroke="#808080"', 'score" stroke="#ed1c24" stroke-opacity="0.5"')
    )
    with pytest.warns(DesignWarning, match="colour #ed1c24, taken for red: mountain"):
        sheet = lamc.load(path)
    assert isinstance(sheet, Mechanism)
    assert len(sheet.joints) == 1


@pytest.mark.parametrize(
    ("name", "role"),
    [("Folds mountain", "mountain"), ("Valleys", "valley"), ("Cuts lines", "cut"), ("glass", None)],
)
def test_each_word_of_a_layers_name_may_be_plural(name: str, role: str | None) -> None:
    assert layer_role(name) == role


@pytest.mark.parametrize(
    ("message", "said"),
    [
        ("wide: --units mm (60 mm wide) or --units in", "wide: units: mm (60 mm wide) or units: in"),
        ("(--units says another)", "(units: says another)"),
        ("(--role '#ed1c24=…' says another)", "(roles: {'#ed1c24': …} says another)"),
        ("(--role 'Teil=cut', or another role)", "(roles: {'Teil': cut}, or another role)"),
    ],
)
def test_designs_are_told_keys_and_not_options(message: str, said: str) -> None:
    assert in_keys(message) == said


def test_a_crease_of_no_opacity_rests_flat(tmp_path: Path) -> None:
    path = tmp_path / "open.svg"
    path.write_text(
        GREY.replace('Teil" fill="none" stroke="#808080"', 'border" fill="none" stroke="black"').replace(
            'Knick" stroke="#808080"', 'valley" stroke="blue" stroke-opacity="0"'
        )
    )
    assert rests(path) == [0.0]


def test_a_mountain_of_0_degrees_rests_flat(tmp_path: Path) -> None:
    import ezdxf

    path = tmp_path / "grey.dxf"
    grey_dxf(path)
    document = ezdxf.readfile(path)
    for entity, layer in zip(document.modelspace(), ("body", "mountain(0)"), strict=True):
        entity.dxf.layer = layer
    document.saveas(path)
    assert rests(path) == [0.0]


def test_an_outline_amid_a_sheet_is_told_in_words_of_drawings(tmp_path: Path) -> None:
    path = tmp_path / "black.svg"
    path.write_text(GREY.replace("#808080", "black"))
    with pytest.warns(
        DesignWarning, match=r"line 1 \(line 3\) drawn as outlines with a facet on either side"
    ):
        lamc.load(path)


def test_a_cut_file_has_no_line_from_a_window_to_the_rim(tmp_path: Path) -> None:
    path, again = tmp_path / "window.svg", tmp_path / "again.svg"
    path.write_text(
        GREY.replace('Knick" stroke="#808080"', 'valley" stroke="blue" stroke-opacity="0.5"')
        .replace("#808080", "black")
        .replace("</svg>", '<circle stroke="black" fill="none" cx="30" cy="10" r="4"/></svg>')
    )
    lamc.convert(path, again)
    assert "yellow" not in again.read_text()
    assert "#ffff00" not in again.read_text()
    before, after = lamc.load(path), lamc.load(again)
    assert isinstance(before, Mechanism)
    assert isinstance(after, Mechanism)
    masses = [sorted(body.mass for body in each.bodies) for each in (before, after)]
    assert masses[0] == pytest.approx(masses[1], rel=1e-12)
    assert rests(again) == rests(path)


def rests(path: Path) -> list[float]:
    """Where its hinges rest, rad; no warning may say that an angle is missing."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        sheet = lamc.load(path)
    assert isinstance(sheet, Mechanism)
    assert not any("no fold angle" in str(each.message) for each in told)
    assert all(joint.stiffness for joint in sheet.joints)
    return [joint.rest_angle for joint in sheet.joints]

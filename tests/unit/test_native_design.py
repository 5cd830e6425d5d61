"""Native files: what people write becomes SI, what is wrong is reported all at once with its place."""

import json
import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc import examples
from lamc.basics.errors import DesignError, DesignErrors, LamcError
from lamc.basics.units import ANGLE, ANGLE_RATE, DENSITY, LENGTH, STIFFNESS, Quantity, to_si
from lamc.design.split import split
from lamc.readers.inert import Limits
from lamc.readers.load import load
from lamc.readers.load_scene import scene_of_text
from lamc.readers.mechanism_file import write_mechanism
from lamc.readers.schema import json_schema
from lamc.records.design import Design
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene

GOOD = """\
units: mm
materials:
  card: {density: 700, rigid: true}
  film: {density: 1.4 g/cm^3, flexible: true}
layers:
  - {name: card, material: card, thickness: 0.3, angle: 45 deg}
  - {name: film, material: film, thickness: 25 um}
shapes:
  - rect: [0, 0, 40, 10]
  - {cut: {rect: [19.9, 0, 20.1, 10]}, layers: card}
hinges:
  - {name: h, line: [[20, 0], [20, 10]], gap: 0.2, stiffness: 3 N*mm/deg, limits: [-90 deg, 1.5]}
fixed:
  - rect: [0, 0, 5, 10]
"""


def design(tmp_path: Path, text: str) -> Design:
    file = tmp_path / "given.yaml"
    file.write_text(text, encoding="utf-8")
    record = load(file)
    assert isinstance(record, Design)
    return record


def problems(tmp_path: Path, text: str) -> list[str]:
    """The lines of the error, without the file's name."""
    file = tmp_path / "bad.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(LamcError) as caught:
        load(file)
    return [line.removeprefix(f"{file}:") for line in str(caught.value).splitlines()]


def test_units_become_si_to_the_last_digit(tmp_path: Path) -> None:
    record = design(tmp_path, GOOD)
    card, film = record.layers
    assert (card.thickness, film.thickness) == (0.0003, 2.5e-05)
    assert (card.angle, card.material.density, film.material.density) == (math.pi / 4, 700.0, 1400.0)
    hinge = record.hinges[0]
    assert hinge.width == 0.0001
    # 3e-3 N·m per degree is 3e-3 · 180/π N·m/rad; one rounding in the factor and one in the product
    assert hinge.stiffness == pytest.approx(3e-3 * 180.0 / math.pi, rel=1e-15)
    assert hinge.limits == (-math.pi / 2, 1.5)
    assert hinge.lines[0].line == ((0.02, 0.0), (0.02, 0.01))


def test_cuts_take_material_from_the_layers_they_name(tmp_path: Path) -> None:
    card, film = design(tmp_path, GOOD).layers
    # mm: 40 x 10 less a slot of 0.2 x 10; areas of overlays are good to round-off of the coordinates
    assert card.geometry.area == pytest.approx(398e-6, rel=1e-12)
    assert film.geometry.area == pytest.approx(400e-6, rel=1e-12)


def test_a_cut_that_meets_nothing_has_a_warning_with_both_places(tmp_path: Path) -> None:
    """As of a manifest whose body is from DXF, y up, and whose hole from SVG, y down."""
    vain = "  - cut: {rect: [0, -30, 10, -20]}\n"
    with pytest.warns(lamc.DesignWarning) as told:
        cut = design(tmp_path, GOOD.replace("hinges:", f"{vain}hinges:"))
    (text,) = [str(each.message) for each in told]
    line = GOOD.replace("hinges:", f"{vain}hinges:").split(vain)[0].count("\n") + 1
    assert f":{line}:" in text
    assert (
        "the cut removes nothing: it lies in x from 0 to 10 mm, y from -30 to -20 mm, and what was drawn"
        in text
    )
    plain = design(tmp_path, GOOD)
    assert [layer.geometry.area for layer in cut.layers] == [layer.geometry.area for layer in plain.layers]


def test_the_hinge_bends_in_the_only_flexible_layer(tmp_path: Path) -> None:
    record = design(tmp_path, GOOD)
    assert record.hinges[0].layer == 1
    assert record.hinges[0].sublaminate == (0, 1)


def test_a_hinge_in_a_board_has_a_warning(tmp_path: Path) -> None:
    told = GOOD.replace("{name: h,", "{name: h, layer: card,")
    with pytest.warns(
        lamc.DesignWarning, match=r"bends in layer 'card', whose material is rigid.* flexible is 'film'"
    ):
        record = design(tmp_path, told)
    assert record.hinges[0].layer == 0


def test_a_disc_has_the_area_of_its_circle(tmp_path: Path) -> None:
    text = GOOD + "  - circle: {center: [50, 50], radius: 4}\n"
    fixed = design(tmp_path, text).fixed[0]
    # the polygon is made with the circle's area, so only round-off is left
    assert fixed.area == pytest.approx(50e-6 + math.pi * 16e-6, rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "density: 700",
            "density: .nan",
            "3:19: materials.card.density: the density is nan",
        ),
        (
            "density: 700",
            "density: -1",
            "3:19: materials.card.density: the density is -1 kg/m^3; it must",
        ),
        ("density: 700", "density: 7 kg", "expected kg/m^3"),
        (
            "thickness: 0.3",
            "thickness: -0.3",
            "6:45: layers[0].thickness: the length is -0.0003 m; it must be above 0",
        ),
        ("thickness: 0.3", "thickness: .inf", "the length is inf; it must be finite"),
        ("material: film", "material: filn", "no material is named 'filn'; did you mean 'film'?"),
        ("layers: card", "layers: cart", "no layer is named 'cart'; did you mean 'card'?"),
        ("3 N*mm/deg", "-3", "stiffness: the hinge stiffness is -3 N*m/rad; it must be at least 0"),
        ("3 N*mm/deg", "3 N/mm", "expected N*m/rad"),
        ("-90 deg, 1.5", "1.5, -90 deg", "the lower comes first"),
        ("-90 deg", "-90", "write '-90 deg' for degrees"),
        ("[20, 10]]", "[20, 0]]", "it needs two different ends"),
        (
            "rect: [0, 0, 40, 10]",
            "polygon: [[0,0],[1,1],[1,0],[0,1]]",
            "self-intersection at (0.0005, 0.0005) m",
        ),
        ("rect: [0, 0, 40, 10]", "polygon: []", "the polygon is empty"),
        ("rect: [0, 0, 40, 10]", "polygon: [[0,0],[1,1],[2,2]]", "shapes[0]: the polygon"),
        ("rect: [0, 0, 40, 10]", "rect: [0, 0, 0, 10]", "encloses no area"),
        (
            "rect: [0, 0, 40, 10]",
            "circle: {center: [0, 0], radius: 0}",
            "the length is 0 m; it must be above 0",
        ),
        ("units: mm", "units: kg", "1:8: units: 'kg' is not a unit of length"),
        ("units: mm", "units: mm\nunits: cm", "the key 'units' stands twice"),
        ("units: mm", "name: !!python/object/apply:os.system [ls]", "has no meaning here"),
        ("name: h,", "name: h, layer: all,", "hinges[0].layer: a hinge bends in one layer: card, film"),
        ("name: h", "name: 10", "a text is expected here, and it is 10"),
        ("flexible: true", "flexible: perhaps", "true or false is expected here, and it is 'perhaps'"),
    ],
)
def test_bad_values_are_reported_with_place_and_way_out(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    assert old in GOOD
    lines = problems(tmp_path, GOOD.replace(old, new, 1))
    assert len(lines) == 1
    assert said in lines[0]


def test_all_problems_of_a_file_come_at_once_in_the_order_of_the_file(tmp_path: Path) -> None:
    text = (
        GOOD.replace("700", "-1")
        .replace("0.3", "0")
        .replace("gap: 0.2", "gap: 0 mm")
        .replace("rect", "rekt", 1)
    )
    lines = problems(tmp_path, text)
    assert [line.split(":")[0] for line in lines] == ["3", "6", "9", "12"]


def test_a_misspelt_key_is_reported_with_the_right_one(tmp_path: Path) -> None:
    lines = problems(tmp_path, GOOD.replace("thickness: 0.3", "thicknes: 0.3"))
    assert any("the key 'thicknes' is unknown; did you mean 'thickness'?" in line for line in lines)


def test_no_layers_and_no_shapes_are_errors(tmp_path: Path) -> None:
    lines = problems(tmp_path, "materials: {}\nlayers: []\nshapes: []\n")
    assert lines == [
        "2:9: layers: the design has no layers; list at least one, from the bottom up",
        "3:9: shapes: the design has no shapes; draw at least one",
    ]


@pytest.mark.parametrize("name", ['"; int main', "../../x", "é🙂" * 90])
def test_strange_names_are_kept_as_they_are(tmp_path: Path, name: str) -> None:
    record = design(tmp_path, GOOD.replace("name: h", f"name: {json.dumps(name, ensure_ascii=False)}"))
    assert record.hinges[0].lines[0].name == name


@pytest.mark.parametrize("name", ["🙂" * 2600, "a\\nb", "", " "])
def test_names_that_nobody_can_read_are_refused(tmp_path: Path, name: str) -> None:
    lines = problems(tmp_path, GOOD.replace("name: h", f'name: "{name}"'))
    assert len(lines) == 1
    assert len(lines[0]) < 300


@pytest.mark.parametrize(
    "text",
    [
        "3 m^9^9^9",
        "3 m**999999999",
        "1e99999999 m",
        "3 " + "m" * 5000,
        "9**9**9",
        "3 m*(",
        "3 degC",
        "0x10",
        "__import__('os')",
        "3 m; ls",
        "",
    ],
)
def test_hostile_units_are_refused_at_once(text: str) -> None:
    with pytest.raises(DesignError) as caught:
        to_si(text, LENGTH)
    assert len(str(caught.value)) < 300


def test_units_of_the_trade_are_understood() -> None:
    assert to_si("25 µm", LENGTH) == to_si("25 um", LENGTH) == 2.5e-05
    assert to_si("180°", ANGLE) == math.pi
    assert to_si("2 kg m^-3", DENSITY) == to_si("2 kg/(m^3)", DENSITY) == 2.0
    assert to_si("3 N*mm/rad", STIFFNESS) == 3e-3
    assert to_si(12, LENGTH, "inch") == pytest.approx(0.3048, rel=1e-15)  # one rounding


@pytest.mark.parametrize(
    ("text", "kind", "said"),
    [
        ("3 N*mm", STIFFNESS, "'N*mm' names no angle, and a hinge stiffness is in N*m/rad or the like"),
        ("5 Hz", ANGLE_RATE, "'Hz' names no angle, and an angular rate is in rad/s or the like"),
        ("1 mm*rad", LENGTH, "'mm*rad' names an angle, and a length is in m or the like"),
        ("2 mm/mm", ANGLE, "'mm/mm' names no angle"),
    ],
)
def test_an_angle_that_is_missing_or_too_much_is_reported(text: str, kind: Quantity, said: str) -> None:
    with pytest.raises(DesignError) as caught:
        to_si(text, kind)
    assert said in str(caught.value)


def test_rates_may_be_in_turns() -> None:
    assert to_si("60 rpm", ANGLE_RATE) == pytest.approx(2 * math.pi, rel=1e-15)  # one rounding


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "the file is empty"),
        (b" \n\n", "the file is empty"),
        (b"\x7fELF\x02\x01\xff\xfe", "is not UTF-8: if it is text"),
        (b"- 1\n", "holds a list"),
        (b"hello", "holds a single value"),
        (b"a: 1", "neither layers nor joints"),
        (b"kind: banana", "it is 'design' or 'mechanism'"),
        (b"!!python/object:popupcad.filetypes.sketch.Sketch {a: 1}", "holds a 'Sketch'"),
        (b"!!python/object/apply:os.system ['ls']", "holds a 'system'"),
    ],
)
def test_other_files_are_refused_in_one_line(tmp_path: Path, content: bytes, said: str) -> None:
    file = tmp_path / "other.cad"
    file.write_bytes(content)
    with pytest.raises(LamcError, match=said) as caught:
        load(file)
    assert "\n" not in str(caught.value)


def test_missing_files_and_folders_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match="no such file"):
        load(tmp_path / "missing.yaml")
    with pytest.raises(DesignError, match="folder"):
        load(tmp_path)


def test_a_large_file_is_refused_by_its_limit(tmp_path: Path) -> None:
    file = tmp_path / "large.yaml"
    file.write_text(GOOD)
    with pytest.raises(DesignError, match="limit 'bytes' of 100"):
        load(file, limits=Limits(bytes=100))


@pytest.mark.slow
def test_a_polygon_of_many_corners_is_read_with_progress(tmp_path: Path) -> None:
    corners = [
        (9 * math.cos(a), 9 * math.sin(a)) for a in np.linspace(0, 2 * math.pi, 10_000, endpoint=False)
    ]
    reported: list[str] = []
    file = tmp_path / "many.yaml"
    file.write_text(GOOD.replace("rect: [0, 0, 40, 10]", f"polygon: {[list(c) for c in corners]}"))
    record = load(file, progress=lambda stage, part: reported.append(stage))
    assert isinstance(record, Design)
    assert {"reading", "checking"} <= set(reported)
    # a regular 10^4-gon is its circle to 2π²/3 · 1e-8 of the area
    assert record.layers[1].geometry.area == pytest.approx(math.pi * 81e-6, rel=1e-7)


def test_the_kind_of_file_is_known_by_content_and_not_by_suffix(tmp_path: Path) -> None:
    file = tmp_path / "design.joints"
    file.write_text(GOOD)
    assert isinstance(load(file), Design)


ODD = 'a "name"; 🙂'


def read_scene(data: object) -> Scene:
    return scene_of_text(json.dumps({"scene": data}), "scene.yaml")


def a_mechanism() -> Mechanism:
    rotation = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    bodies = (
        Body("ground", fixed=True),
        Body(ODD, 0.1 + 0.2, (1 / 3, -2e-17, 5.0), rotation @ np.diag([1.0, 2.0, 2.5]) @ rotation.T),
        Body("no", 1e-9, (0, 0, 0), np.eye(3) * 1e-20),
    )
    joints = (
        Joint("1", "ground", ODD, (1e-5, 2 / 3, 0), (1, 2, 3), 1e-5, 1e-7, 0.1, (-1.0, 2 / 3)),
        Joint("true", ODD, "no", (0, 0, 0.1), rotation[0]),
    )
    effects = read_scene({"effects": {"gravity": [0, 0.1, -9.81], "torque": {"1": "sin(t)"}}}).effects
    scene = Scene(effects=effects, angles={"1": 1 / 3}, rates={"true": -1e-5})
    return Mechanism(bodies, joints, "it's", scene)


def test_a_mechanism_file_reads_back_to_the_last_bit(tmp_path: Path) -> None:
    given = a_mechanism()
    write_mechanism(given, tmp_path / "m.yaml")
    assert load(tmp_path / "m.yaml") == given
    assert [p.name for p in tmp_path.iterdir()] == ["m.yaml"]


def test_outlines_read_back_to_the_last_bit(tmp_path: Path) -> None:
    record = load(examples.path("shutter"))
    assert isinstance(record, Design)
    given = split(record)
    write_mechanism(given, tmp_path / "m.yaml")
    assert load(tmp_path / "m.yaml") == given


def test_a_story_goes_from_the_drawing_to_the_mechanism_and_its_file(tmp_path: Path) -> None:
    reported = "story: >\n  A card that opens.\n  It is held at one end.\n" + GOOD
    mechanism = split(design(tmp_path, reported))
    assert mechanism.story == "A card that opens. It is held at one end."
    write_mechanism(mechanism, tmp_path / "m.yaml")
    assert load(tmp_path / "m.yaml") == mechanism
    with pytest.raises(DesignError, match="story of mechanism 'given' is 7; it must be text"):
        Mechanism(mechanism.bodies, mechanism.joints, "given", story=7)  # type: ignore[arg-type]


def test_a_mechanism_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(LamcError, match="cannot be written"):
        write_mechanism(a_mechanism(), tmp_path / "missing" / "m.yaml")
    assert list(tmp_path.iterdir()) == []


def test_problems_of_a_mechanism_file_come_with_their_places(tmp_path: Path) -> None:
    text = """\
kind: mechanism
bodies:
  - {name: a, fixed: true}
  - {name: b, mass: 0}
  - {name: c, mass: 1 g, inertia: [[1, 0, 0], [0, -1, 0], [0, 0, 1]]}
joints:
  - {name: j, parent: a, child: z, point: [0, 0, 0], axis: [0, 0, 0]}
"""
    lines = problems(tmp_path, text)
    assert [line.split(":")[0] for line in lines] == ["4", "5", "7"]


def test_a_mechanism_without_a_fixed_body_is_refused(tmp_path: Path) -> None:
    body = "{name: a, mass: 1, inertia: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}"
    (line,) = problems(tmp_path, f"joints: []\nbodies: [{body}]\n")
    assert "no body is fixed" in line


def test_effects_may_be_a_map_or_a_list() -> None:
    as_map = read_scene({"effects": {"hinge_stiffness": None, "gravity": [0, 0, -1]}})
    as_list = read_scene({"effects": ["hinge_stiffness", {"gravity": [0, 0, -1]}]})
    assert as_map == as_list
    assert read_scene({"effects": {}}).effects == ()
    assert read_scene({"duration": 1}).effects is None


@pytest.mark.parametrize(
    "effects",
    [
        {"gravty": None},
        ["gravity", "gravity"],
        [1],
        "gravity",
        {"torque": {"h": "open('x')"}},
        [{"a": 1, "b": 2}],
    ],
)
def test_scenes_that_make_no_sense_are_refused(effects: object) -> None:
    with pytest.raises(DesignError):
        read_scene({"effects": effects})


def test_the_json_schema_describes_what_designs_say() -> None:
    schema = json_schema()
    text = json.dumps(schema)
    assert schema["$defs"]["Design"]["additionalProperties"] is False
    assert set(schema["$defs"]["Design"]["required"]) == {"materials", "layers", "shapes"}
    for reference in {part.split('"')[0] for part in text.split('"#/$defs/')[1:]}:
        assert reference in schema["$defs"]


def test_an_example_that_is_not_there_names_those_that_are() -> None:
    with pytest.raises(LamcError, match=r"there are bricard, .* in all"):
        examples.path("../../x")


def test_both_errors_and_places_are_kept_apart() -> None:
    error = DesignErrors([DesignError("a"), DesignError("b")])
    assert str(error) == "a\nb"


@pytest.mark.parametrize(
    ("shapes", "said"),
    [
        (
            "{cut: {rect: [20, 2, 30, 8]}}, {rect: [0, 0, 40, 10]}",
            "is drawn after it; shapes are taken in their order",
        ),
        (
            "{rect: [0, 0, 40, 10]}, {cut: {rect: [40, 2, 42, 4]}}",
            "and what was drawn before it in x from 0 to 40 mm",
        ),
        ("{rect: [0, 0, 40, 10]}, {cut: {rect: [20, 2, 30, 8]}}, {rect: [22, 3, 28, 7]}", ""),  # an island
    ],
)
def test_a_cut_that_removes_nothing_is_told(tmp_path: Path, shapes: str, said: str) -> None:
    """Before what it is to cut, and beside its edge."""
    start, end = GOOD.index("shapes:"), GOOD.index("hinges:")
    text = f"{GOOD[:start]}shapes: [{shapes}]\n{GOOD[end:]}"
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        design(tmp_path, text)
    assert [said in str(each.message) for each in told] == ([True] if said else [])

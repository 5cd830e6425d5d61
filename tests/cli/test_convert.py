"""`lamc convert` and `lamc.convert`: the same mechanism in every format, what is lost is told, nothing written over."""

import json
import math
import shlex
import warnings
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import shapely
from click.testing import CliRunner, Result

import lamc
from lamc import examples
from lamc.basics.errors import DesignWarning, ExportError, UnsupportedError
from lamc.cli import main
from lamc.design.mass import body_properties
from lamc.export.conversions import converted
from lamc.export.creased import CreasedSheet
from lamc.export.cuts.creases import crease_of, lines_of_sheet, point_of
from lamc.export.cuts.lines import bounds_of
from lamc.readers.drawings.sheet import sheet_of
from lamc.readers.inert import Limits
from lamc.readers.load import load_text
from lamc.records.card import SheetOptions
from lamc.records.design import Design
from lamc.records.drawing import Drawing, Role, Stroke
from lamc.records.mechanism import Body, Joint, Mechanism, Slab
from tests.support import fold_corpus as corpus

pytestmark = pytest.mark.usefixtures("unpainted")

SAME = 1e-9  # what the issue asks for; sums that begin at another corner differ by some 1e-15
SHEETS = {
    "miura": lambda: corpus.miura(3, 3),
    "waterbomb": corpus.waterbomb,
    "yoshimura": lambda: corpus.yoshimura(3, 4),
    "box": corpus.box_net,
}


def call(*words: str | Path) -> Result:
    return CliRunner().invoke(main, ["convert", *map(str, words)], catch_exceptions=False)


def quiet(path: Path, **options: object) -> Design | Mechanism:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        return lamc.load(path, **options)  # type: ignore[arg-type]


def mechanism_in(path: Path, **options: object) -> Mechanism:
    found = quiet(path, **options)
    return lamc.split(found) if isinstance(found, Design) else found


def sheet(folder: Path, data: corpus.Data) -> Path:
    """A sheet as native YAML: its hinges all rest at angles, as FOLD gave them."""
    quiet_convert(corpus.write(folder / "sheet.fold", data), folder / "sheet.yaml")
    return folder / "sheet.yaml"


def quiet_convert(source: Path, target: Path, **options: object) -> Path:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        return lamc.convert(source, target, **options)


def assert_same(made: Mechanism, drawn: Mechanism) -> None:
    """Bodies and hinges by their names."""
    assert sorted(b.name for b in made.bodies) == sorted(b.name for b in drawn.bodies)
    for body in drawn.bodies:
        other = made.body(body.name)
        assert other.fixed == body.fixed
        assert other.mass == pytest.approx(body.mass, rel=SAME)
        np.testing.assert_allclose(other.com, body.com, rtol=0.0, atol=SAME * drawn.size)
        np.testing.assert_allclose(
            other.inertia, body.inertia, rtol=0.0, atol=SAME * np.abs(body.inertia).max()
        )
    assert sorted(j.name for j in made.joints) == sorted(j.name for j in drawn.joints)
    for joint in drawn.joints:
        assert_same_joint(made.joint(joint.name), joint, drawn.size)


def assert_same_joint(joint: Joint, drawn: Joint, size: float) -> None:
    assert (joint.parent, joint.child) == (drawn.parent, drawn.child)
    np.testing.assert_allclose(joint.axis, drawn.axis, rtol=0.0, atol=SAME)
    off_the_line = np.cross(joint.point - drawn.point, drawn.axis)
    np.testing.assert_allclose(off_the_line, 0.0, rtol=0.0, atol=SAME * size)
    for name in ("stiffness", "damping", "rest_angle", "limits"):
        assert getattr(joint, name) == pytest.approx(getattr(drawn, name), rel=SAME, abs=1e-15)


DESIGNS = [name for name in examples.names() if examples.find(name).path is not None]


@pytest.mark.parametrize("suffix", [".yaml", ".mechanism.yaml", ".joints"])
@pytest.mark.parametrize("name", DESIGNS)
@pytest.mark.quick("five_bar-*", "pendulum-*", "folding_box-*")
def test_examples_come_back_from_each_format_as_the_same_mechanism(
    tmp_path: Path, name: str, suffix: str
) -> None:
    path = examples.find(name).path
    assert path is not None
    drawn = mechanism_in(path)
    if suffix == ".joints" and drawn.design is None:
        pytest.skip("bodies without layers")
    quiet_convert(path, tmp_path / f"{name}{suffix}")
    made = mechanism_in(tmp_path / f"{name}{suffix}")
    assert_same(made, drawn)
    if suffix != ".joints":
        assert made.scene == drawn.scene
        assert dict(made.scenes) == dict(drawn.scenes)


@pytest.mark.parametrize("suffix", [".fold", ".joints", ".mechanism.yaml"])
@pytest.mark.parametrize("name", sorted(SHEETS))
@pytest.mark.quick("miura-*", "box-*")
def test_sheets_come_back_from_each_format_as_the_same_mechanism(
    tmp_path: Path, name: str, suffix: str
) -> None:
    native = sheet(tmp_path, SHEETS[name]())
    quiet_convert(native, tmp_path / f"other{suffix}")
    quiet_convert(tmp_path / f"other{suffix}", tmp_path / "back.yaml")
    assert_same(mechanism_in(tmp_path / "back.yaml"), mechanism_in(native))


def matched(made: Mechanism, drawn: Mechanism, corner: tuple[float, float] = (0.0, 0.0)) -> Mechanism:
    """`made` with the names and the order of hinges' ends that `drawn` has: drawings have no names. corner: m, from
    which its places count."""
    shift = np.array([*corner, 0.0])
    bodies = {}
    for body in made.bodies:
        near = min(drawn.bodies, key=lambda other: float(np.linalg.norm(other.com - body.com - shift)))
        bodies[body.name] = near.name
    assert len(set(bodies.values())) == len(drawn.bodies)
    joints = []
    for drawn_joint in made.joints:
        joint = replace(drawn_joint, point=drawn_joint.point + shift)
        ends = bodies[joint.parent], bodies[joint.child]
        twin = next(
            j
            for j in drawn.joints
            if {j.parent, j.child} == set(ends)
            and np.linalg.norm(np.cross(j.point - joint.point, joint.axis)) < 1e-6 * drawn.size
        )
        axis = joint.axis if ends == (twin.parent, twin.child) else -joint.axis
        joints.append(
            replace(
                joint, name=twin.name, parent=twin.parent, child=twin.child, axis=axis, damping=twin.damping
            )
        )
    return Mechanism(
        tuple(replace(b, name=bodies[b.name], com=b.com + shift) for b in made.bodies),
        tuple(joints),
        drawn.name,
        made.scene,
    )


@pytest.mark.quick("waterbomb-.dxf", "box-.svg", "box-.dxf", "miura-.dxf")
@pytest.mark.parametrize("suffix", [".svg", ".dxf"])
@pytest.mark.parametrize("name", sorted(SHEETS))
def test_sheets_come_back_from_drawings_with_the_options_that_are_told(
    tmp_path: Path, name: str, suffix: str
) -> None:
    """Native, drawing, native: the same but for names and damping, and where the page begins."""
    native = sheet(tmp_path, SHEETS[name]())
    drawn = mechanism_in(native)
    told = json.loads(call(native, tmp_path / f"other{suffix}", "--json").stdout)
    words = shlex.split(told["options"])
    result = call(tmp_path / f"other{suffix}", tmp_path / "back.yaml", *words)
    assert result.exit_code == 0, result.stderr
    assert not any("taken" in line for line in result.stderr.splitlines())  # nothing is assumed
    low, high = bounds_of(lines_of_sheet(CreasedSheet(drawn, "")))
    corner = (float(low[0]), float(high[1])) if suffix == ".svg" else (0.0, 0.0)
    assert_same(matched(mechanism_in(tmp_path / "back.yaml"), drawn, corner), drawn)


@pytest.mark.parametrize("name", sorted(SHEETS))
def test_lines_of_a_sheet_are_the_same_sheet(tmp_path: Path, name: str) -> None:
    """Without the files between: roles and angles as readers of drawings make them of pens."""
    drawn = mechanism_in(sheet(tmp_path, SHEETS[name]()))
    lines = CreasedSheet(drawn, "")
    strokes = tuple(
        Stroke(
            line.points,
            line.closed,
            _role(line.pen.name),
            None if line.angle is None else line.angle * (-1.0 if line.pen.name == "mountain" else 1.0),
        )
        for line in lines_of_sheet(lines)
    )
    x, y = point_of(lines)
    options = SheetOptions(fixed=(float(x), float(y)), card=lines.card, crease=crease_of(lines))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        made = sheet_of(Drawing("sheet", strokes, 1e-3), options)
    assert_same(matched(made, drawn), drawn)


def _role(name: str) -> Role:
    found: Role = name  # type: ignore[assignment]  # pens are named after roles
    return found


def test_what_is_lost_is_told_and_how_the_same_is_read(tmp_path: Path) -> None:
    native = sheet(tmp_path, corpus.waterbomb())
    result = call(native, tmp_path / "x.svg", "--json")
    data = json.loads(result.stdout)
    assert data["lost"][0].startswith("names of hinges and bodies (E1, E3")
    assert not any(
        "damping" in what for what in data["lost"]
    )  # is what lamc takes of a crease that says none
    words = shlex.split(data["options"])
    assert words[:4] == ["--card", "0.0003 m, 700.0 kg/m^3", "--crease", "0.001"]
    assert words[4] == "--fixed"
    with pytest.warns(DesignWarning, match=r"y\.svg does not hold names of hinges and bodies"):
        lamc.convert(native, tmp_path / "y.svg")
    assert (tmp_path / "y.svg").read_bytes() == (tmp_path / "x.svg").read_bytes()


def svg_of(*shapes: str) -> str:
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100" fill="none">'
        + "".join(shapes)
        + "</svg>"
    )


RIM = '<rect x="10" y="10" width="80" height="80" stroke="black"/>'
NESTED = {
    "a window on the crease": (
        RIM,
        '<rect x="40" y="40" width="20" height="20" stroke="black"/>',
        '<path d="M10 50H40M60 50H90" stroke="red"/>',
    ),
    "a sheet in a window": (
        RIM,
        '<path d="M10 30H90" stroke="red"/>',
        '<rect x="30" y="40" width="40" height="40" stroke="black"/>',
        '<rect x="40" y="50" width="20" height="20" stroke="black"/>',
    ),
    "a ring in a window, with a crease": (
        RIM,
        '<rect x="20" y="20" width="60" height="60" stroke="black"/>',
        '<rect x="30" y="30" width="40" height="40" stroke="black"/>',
        '<rect x="40" y="40" width="20" height="20" stroke="black"/>',
        '<path d="M30 50H40M60 50H70" stroke="blue"/>',
    ),
}


@pytest.mark.parametrize("suffix", [".svg", ".dxf"])
@pytest.mark.parametrize("name", sorted(NESTED))
def test_rims_in_rims_come_back_as_they_were(tmp_path: Path, name: str, suffix: str) -> None:
    """The rim of a window on a crease is a hole, that of a piece in a window is an outline."""
    source = tmp_path / "sheet.svg"
    source.write_text(svg_of(*NESTED[name]))
    drawn = mechanism_in(source)
    told = json.loads(call(source, tmp_path / f"other{suffix}", "--json").stdout)
    made = mechanism_in(
        tmp_path / f"other{suffix}", card=lamc.Card(), crease=1e-3, facets="rigid", units="mm"
    )
    assert (len(made.bodies), len(made.joints)) == (len(drawn.bodies), len(drawn.joints))
    masses = (sorted(body.mass for body in each.bodies) for each in (made, drawn))
    assert np.allclose(*masses, rtol=SAME, atol=0.0)
    assert not any(
        "bodies:" in what or "where" in what.split()[0] for what in told["lost"] if "page" not in what
    )


@pytest.mark.parametrize("suffix", [".svg", ".dxf"])
def test_facets_that_bend_come_back_as_they_bent(tmp_path: Path, suffix: str) -> None:
    """Along the same diagonals, ten times as stiff as creases of their length."""
    source = corpus.write(tmp_path / "sheet.fold", corpus.miura(2, 2))
    options = {"card": lamc.Card(), "crease": 1e-3}
    drawn = mechanism_in(source, **options, facets="bend")
    assert len(drawn.facet_creases) == 4
    made = converted(drawn, tmp_path / f"x{suffix}", source)
    assert made.same
    assert made.again.endswith("--facets bend --heal 0")
    assert not any("stiff" in what for what in made.lost)


def test_rings_of_one_centre_and_one_mass_are_told_apart() -> None:
    """And a body that the world holds may have any mass, a sheet no scene."""

    def ring(name: str, outer: float, inner: float) -> Body:
        hole = shapely.box(-inner, -inner, inner, inner)
        return flat_body(name, shapely.box(-outer, -outer, outer, outer).difference(hole))

    far = flat_body("c", shapely.box(0.1, 0.0, 0.12, 0.02))
    bodies = (ring("a", 0.05, 0.04), ring("b", 0.0375, 0.0225), far)
    held = flat_body("d", shapely.box(0.12, 0.0, 0.14, 0.02), fixed=True)
    held = replace(held, mass=0.0, com=np.zeros(3), inertia=np.zeros((3, 3)))
    assert bodies[0].mass == pytest.approx(bodies[1].mass)
    joint = Joint("h", "d", "c", (0.12, 0.0, 1.5e-4), (0.0, 1.0, 0.0), 2e-5, 0.0, 0.5)
    made = converted(Mechanism((*bodies, held), (joint,), "x"), Path("x.svg"), Path("x.yaml"))
    told = [what for what in made.lost if "its page begins" not in what]
    assert not any("where" in what or "masses" in what or "scene" in what for what in told)


def test_a_sheet_that_starts_folded_is_not_told_to_be_the_same(tmp_path: Path) -> None:
    source = corpus.write(tmp_path / "pair.fold", corpus.folded_pair(0.7))
    result = call(source, tmp_path / "x.svg")
    assert "the angles at which it starts: it lies flat" in result.stdout
    assert result.stdout.rstrip().endswith("with these lamc reads it, but for what is lost")


def test_what_a_drawing_does_not_say_back_is_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever went wrong with its lines: it is read as it was written."""
    native = sheet(tmp_path, corpus.waterbomb())
    monkeypatch.setattr(
        import_module("lamc.export.conversions"),
        "lines_of_sheet",
        lambda given: [line for line in lines_of_sheet(given) if not line.pen.name.startswith("valley")],
    )
    told = json.loads(call(native, tmp_path / "x.svg", "--json").stdout)
    assert any(what.startswith("bodies: 6 were drawn, and ") for what in told["lost"])


def test_scenes_story_and_names_are_told_where_they_are_lost(tmp_path: Path) -> None:
    source = examples.find("four_bar").path
    assert source is not None
    result = call(source, tmp_path / "other.joints")
    for what in ("its scene", "its name, 'four_bar'", "its story", "hinges' gaps"):
        assert what in result.stdout
    result = call(source, tmp_path / "four_bar.yaml")
    lost = [line for line in result.stdout.splitlines() if line.startswith(("lost", "   "))]
    assert len(lost) == 1  # a native design holds all of it, but what its numbers followed from
    assert "parameters, whose values are written in: arm_length 40 mm" in lost[0]
    assert "layers and materials" in call(source, tmp_path / "four_bar.mechanism.yaml").stdout
    result = call(tmp_path / "other.joints", tmp_path / "b.yaml")
    assert "layers and materials, and where hinge lines end" in result.stdout


@pytest.mark.parametrize("suffix", [".svg", ".dxf"])
@pytest.mark.parametrize("name", DESIGNS)
@pytest.mark.quick("five_bar-.dxf", "folding_box-.svg", "pendulum-.svg")
def test_laminates_come_back_from_a_drawing_and_the_design_beside_it(
    tmp_path: Path, name: str, suffix: str
) -> None:
    path = examples.find(name).path
    assert path is not None
    drawn = mechanism_in(path)
    if drawn.design is None:
        pytest.skip("bodies without layers")
    result = call(path, tmp_path / f"{name}{suffix}")
    assert result.exit_code == 0
    assert f"{name}{suffix}.yaml  takes its shapes from it: lamc reads the same device" in result.stdout
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # roles, units and healing are said: nothing is guessed
        found = lamc.load(tmp_path / f"{name}{suffix}.yaml")
    assert isinstance(found, Design)
    assert [name for name, _ in found.beside] == [f"{name}{suffix}"]
    made = lamc.split(found)
    assert_same(made, drawn)
    assert made.scene == drawn.scene
    assert dict(made.scenes) == dict(drawn.scenes)


def test_a_laminate_drawn_anew_is_another_device(tmp_path: Path) -> None:
    """What is read is the drawing, and not a copy of the design's own numbers."""
    source = examples.find("flaps").path
    assert source is not None
    quiet_convert(source, tmp_path / "flaps.svg")
    drawing = (tmp_path / "flaps.svg").read_text(encoding="utf-8")
    twice = drawing.replace("<g ", '<g transform="scale(2)" ')
    (tmp_path / "flaps.svg").write_text(twice, encoding="utf-8")
    text = (tmp_path / "flaps.svg.yaml").read_text(encoding="utf-8")
    at = next(line for line in text.splitlines() if "at: " in line)
    (tmp_path / "flaps.svg.yaml").write_text(text.replace(at, "      at: [0, 0]"), encoding="utf-8")
    drawn, made = mechanism_in(source), mechanism_in(tmp_path / "flaps.svg.yaml")
    masses, others = ([body.mass for body in each.bodies] for each in (drawn, made))
    assert others == pytest.approx(
        [4.0 * mass for mass in masses], rel=1e-2
    )  # the gaps are as wide as before


def test_hinge_lines_keep_their_order_names_and_ends(tmp_path: Path) -> None:
    """A drawing is read from the lower left; lines in another order have layers of their own."""
    text = LAMINATE.replace("LINES", "[[[30, 0], [30, 9]], [[20, 9], [20, 0]], [[10, 0], [10, 9]]]")
    for name, named in (("bare", ""), ("named", "name: fold, ")):
        (tmp_path / f"{name}.yaml").write_text(text.replace("NAME", named), encoding="utf-8")
        drawn = mechanism_in(tmp_path / f"{name}.yaml")
        for suffix in (".dxf", ".svg"):
            assert call(tmp_path / f"{name}.yaml", tmp_path / f"{name}{suffix}").exit_code == 0
            assert_same(mechanism_in(tmp_path / f"{name}{suffix}.yaml"), drawn)


LAMINATE = """
name: odd
units: mm
materials: {card: {density: 700, rigid: true}, film: {density: 1390, flexible: true}}
layers:
  - {name: "dimension: 3/4 <\u00fc>", material: card, thickness: 0.3}
  - {name: hinge, material: film, thickness: 0.1}
  - {name: text, material: card, thickness: 0.3}
shapes:
  - {rect: [0, 0, 40, 9]}
  - {cut: {circle: {center: [5, 4], radius: 2}}, layers: [text]}
  - {cut: {polygon: [[33, 1], [38, 1], [38, 8], [33, 8]]}, layers: [text, hinge]}
  - {rect: [34, 3, 37, 6], layers: [text, hinge]}
hinges: [{NAMElines: LINES, layer: hinge, gap: 0.4, stiffness: 1e-3}]
fixed: [{rect: [0, 0, 5, 9], layers: [hinge]}]
"""


def laminate(folder: Path, lines: str, name: str = "a.yaml") -> Path:
    (folder / name).write_text(LAMINATE.replace("NAME", "").replace("LINES", lines), encoding="utf-8")
    return folder / name


def test_hinge_lines_on_one_another_have_layers_of_their_own(tmp_path: Path) -> None:
    """In one layer of a drawing they are one stroke."""
    source = laminate(tmp_path, "[[[10, 0], [10, 6]], [[10, 4], [10, 9]]]")
    assert call(source, tmp_path / "a.dxf").exit_code == 0
    assert_same(mechanism_in(tmp_path / "a.dxf.yaml"), mechanism_in(source))


@pytest.mark.parametrize("suffix", [".svg", ".dxf"])
@pytest.mark.parametrize("degrees", [3, 19, 28, 84])
def test_oblique_cuts_that_end_at_a_rim_are_the_same_shapes(
    tmp_path: Path, degrees: int, suffix: str
) -> None:
    """Overlays leave spikes of no width there, of which a reader of lines makes gaps."""
    turn = math.radians(degrees)
    along, across = np.array([math.cos(turn), math.sin(turn)]), np.array([-math.sin(turn), math.cos(turn)])
    plate = [(x * along + y * across).tolist() for x, y in ((0, 0), (40, 0), (40, 20), (0, 20))]
    slit = [(x * along + y * across).tolist() for x, y in ((19.8, 0), (20.2, 0), (20.2, 20), (19.8, 20))]
    notch = [(x * along + y * across).tolist() for x, y in ((5, 10), (9, 10), (9, 20), (5, 20))]
    text = f"""
units: mm
materials: {{card: {{density: 700, rigid: true}}, film: {{density: 1390, flexible: true}}}}
layers: [{{name: film, material: film, thickness: 0.1}}, {{name: card, material: card, thickness: 0.3}}]
shapes:
  - polygon: {plate}
  - {{cut: {{polygon: {slit}}}, layers: [card]}}
  - cut: {{polygon: {notch}}}
hinges: [{{line: [{(20 * along).tolist()}, {(20 * along + 20 * across).tolist()}], layer: film, gap: 0.4}}]
fixed: [{{polygon: {[*notch[:2], (7 * along).tolist()]}}}]
"""
    (tmp_path / "a.yaml").write_text(text, encoding="utf-8")
    assert call(tmp_path / "a.yaml", tmp_path / f"b{suffix}").exit_code == 0
    assert_same(mechanism_in(tmp_path / f"b{suffix}.yaml"), mechanism_in(tmp_path / "a.yaml"))


def test_a_pair_that_would_be_read_otherwise_is_not_written(tmp_path: Path) -> None:
    source = laminate(tmp_path, "[[[10, 0], [10, 9]]]")
    result = call(source, tmp_path / "run 12:30.dxf")
    assert result.exit_code == 2
    assert "would not be read as the device that is drawn" in result.stderr
    assert "name a file that lies beside this one, without folders; `lamc export" in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["a.yaml"]


def test_nothing_that_is_read_is_written_over(tmp_path: Path) -> None:
    """Neither the design beside the drawing, nor a drawing that a design takes shapes from; forced or not."""
    source = laminate(tmp_path, "[[[10, 0], [10, 9]]]")
    assert call(source, tmp_path / "b.svg").exit_code == 0
    beside, drawing = tmp_path / "b.svg.yaml", tmp_path / "b.svg"
    before = beside.read_bytes(), drawing.read_bytes()
    for target in (drawing, tmp_path / "b.svg.yaml"):
        assert "is the file that is read; name another" in call(beside, target, "--force").stderr
    (tmp_path / "c.yaml").write_bytes(before[0])
    assert (
        "b.svg' is the file that is read; name another"
        in call(tmp_path / "c.yaml", drawing, "--force").stderr
    )
    assert (beside.read_bytes(), drawing.read_bytes()) == before
    (tmp_path / "d.dxf.yaml").write_text("precious", encoding="utf-8")
    result = call(source, tmp_path / "d.dxf")
    assert result.exit_code == 2
    assert "d.dxf.yaml' is there; name another file, or replace it with --force" in result.stderr
    assert not (tmp_path / "d.dxf").exists()
    assert (tmp_path / "d.dxf.yaml").read_text(encoding="utf-8") == "precious"


@pytest.mark.parametrize("length", [250, 300])
def test_a_name_that_is_too_long_is_one_line(tmp_path: Path, length: int) -> None:
    """250: the drawing's fits, and that of the design beside it does not."""
    result = call(laminate(tmp_path, "[[[10, 0], [10, 9]]]"), tmp_path / f"{'x' * length}.svg")
    assert result.exit_code == 2
    assert "cannot be written: File name too long" in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["a.yaml"]


def test_what_is_lost_of_hinges_and_moduli_is_told(tmp_path: Path) -> None:
    """A hinge on a face of the card, limits, an angle that counts the other way, half of a material."""
    source = sheet(tmp_path, corpus.miura(2, 2))
    text = source.read_text(encoding="utf-8")
    drawn = quiet(source)
    assert isinstance(drawn, Mechanism)
    one = drawn.joints[0]
    for suffix in (".dxf", ".fold"):
        moved = replace(
            drawn, joints=(replace(one, point=one.point + np.array([0.0, 0.0, 1e-4])), *drawn.joints[1:])
        )
        made = converted(moved, Path(f"a{suffix}"), source)
        assert f"hinges elsewhere than in the middle of the card: {one.name}" in made.lost
        assert not made.same
    limited = replace(drawn, joints=(replace(one, limits=(-1.0, 1.0)), *drawn.joints[1:]))
    assert converted(limited, Path("a.dxf"), source).same is False
    turned = replace(one, axis=-one.axis, rest_angle=-one.rest_angle)
    made = converted(replace(drawn, joints=(turned, *drawn.joints[1:])), Path("a.fold"), source)
    assert any(f"turn the other way there: {one.name}" in lost for lost in made.lost)
    assert text == source.read_text(encoding="utf-8")
    half = laminate(tmp_path, "[[[10, 0], [10, 9]]]")
    for moduli, told in (("E1: 2.5 GPa", True), ("E1: 2.5 GPa, poisson: 0.3", False)):
        half.write_text(
            half.read_text(encoding="utf-8").replace("film: {density", f"film: {{{moduli}, density")
        )
        result = call(half, tmp_path / "a.joints", "--force")
        assert ("moduli of layers of which not all are known: hinge" in result.stdout) == told
        half = laminate(tmp_path, "[[[10, 0], [10, 9]]]")
    assert "E1: 2500000000.0" in (tmp_path / "a.joints").read_text(encoding="utf-8")


def test_layers_are_refused_by_formats_of_one_sheet(tmp_path: Path) -> None:
    source = examples.find("flaps").path
    assert source is not None
    result = call(source, tmp_path / "a.fold")
    assert result.exit_code == 2
    assert "FOLD holds a sheet of creases, and 'flaps' has layers; SVG and DXF hold those" in result.stderr
    assert list(tmp_path.iterdir()) == []
    flaps = lamc.split(quiet(source))
    bare = Mechanism(flaps.bodies, flaps.joints, "bare")
    for suffix in (".fold", ".svg", ".dxf"):
        with pytest.raises(UnsupportedError, match=r"a sheet of one card; 'bare' has layers of several"):
            converted(bare, Path(f"a{suffix}"), Path("a.yaml"))


def test_a_fold_file_that_is_not_read_back_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = quiet(sheet(tmp_path, corpus.miura(2, 2)))
    monkeypatch.setattr(import_module("lamc.export.read_back"), "DEFAULT_LIMITS", Limits(values=10))
    (lost,) = [each for each in converted(drawn, Path("a.fold"), Path("a.yaml")).lost if "device" in each]
    assert lost.startswith("the device: lamc does not read the file: ")


def test_no_file_is_written_over_unless_forced(tmp_path: Path) -> None:
    source = examples.find("flaps").path
    assert source is not None
    target = tmp_path / "mine.yaml"
    target.write_text("precious", encoding="utf-8")
    result = call(source, target)
    assert result.exit_code == 2
    assert "is there; name another file, or replace it with --force" in result.stderr
    assert target.read_text(encoding="utf-8") == "precious"
    with pytest.raises(ExportError, match="force=True"):
        lamc.convert(source, target)
    assert call(source, target, "--force").exit_code == 0
    assert isinstance(quiet(target), Design)
    for words in ((target, target), (target, target, "--force")):
        assert "is the file that is read" in call(*words).stderr


@pytest.mark.parametrize("name", ["a", "a.txt", "a.cad", "yaml", ".zip"])
def test_a_suffix_that_means_nothing_is_refused_before_anything_is_read(tmp_path: Path, name: str) -> None:
    result = call(tmp_path / "missing.yaml", tmp_path / name)
    assert result.exit_code == 2
    assert "its suffix must be one of .mechanism.yaml" in result.stderr


def test_a_file_that_cannot_be_read_leaves_none(tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text("layers: 3\n", encoding="utf-8")
    assert call(tmp_path / "bad.yaml", tmp_path / "b.joints").exit_code == 2
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bad.yaml"]
    assert call(examples.find("flaps").path or "", tmp_path / "no" / "b.joints").exit_code == 2


def test_the_same_file_has_the_same_bytes(tmp_path: Path) -> None:
    native = sheet(tmp_path, corpus.miura(2, 2))
    for suffix in (".yaml", ".joints", ".fold", ".svg", ".dxf"):
        first = quiet_convert(native, tmp_path / f"a{suffix}").read_bytes()
        assert quiet_convert(native, tmp_path / f"a{suffix}", force=True).read_bytes() == first


def test_limits_and_angles_at_the_start_are_kept_or_told(tmp_path: Path) -> None:
    drawn = mechanism_in(sheet(tmp_path, corpus.folded_pair(0.7)))
    limited = Mechanism(
        drawn.bodies, (replace(drawn.joints[0], limits=(-0.5, 1.0)),), "pair", drawn.scene, story="A pair."
    )
    fold = converted(limited, Path("a.fold"), Path("a.yaml"))
    assert "limits of hinge 'E1'" in " ".join(fold.lost) or any("limits of hinge" in x for x in fold.lost)
    back = load_text(fold.content.decode(), "a.fold")
    assert isinstance(back, Mechanism)
    assert drawn.scene is not None
    assert back.scene is not None
    assert dict(back.scene.angles) == pytest.approx(dict(drawn.scene.angles))
    svg = converted(limited, Path("a.svg"), Path("a.yaml"))
    assert any("its scene" in each for each in svg.lost)
    assert any("limits of hinge" in each for each in svg.lost)
    assert math.isclose(next(iter(drawn.scene.angles.values())), 0.7, abs_tol=1e-9)


def flat_body(name: str, polygon: shapely.Polygon, *, fixed: bool = False) -> Body:
    slab = Slab(polygon, 0.0, 3e-4)
    return Body(name, *body_properties([(slab, 700.0)]), fixed, (slab,))


def test_windows_angles_and_held_bodies_are_told_where_they_are_lost() -> None:
    window = shapely.box(0.025, 0.005, 0.03, 0.01)
    bodies = (
        flat_body("a", shapely.box(0.0, 0.0, 0.02, 0.02), fixed=True),
        flat_body("b", shapely.box(0.02, 0.0, 0.04, 0.02).difference(window)),
        flat_body("c", shapely.box(0.04, 0.0, 0.06, 0.02), fixed=True),
    )
    joints = (
        Joint("h", "a", "b", (0.02, 0.0, 1.5e-4), (0.0, -1.0, 0.0), 0.0, 0.0, 1.0),
        Joint("k", "c", "b", (0.04, 0.0, 1.5e-4), (0.0, 1.0, 0.0), 1e-4),
    )
    made = Mechanism(bodies, joints, "x")
    fold = converted(made, Path("x.fold"), Path("x.yaml"))
    assert fold.lost == ("windows in facets (1), whose card is weighed",)
    svg = converted(made, Path("x.svg"), Path("x.yaml"))
    assert "rest angles of hinges (h)" in svg.lost
    assert "that the world holds c: --fixed holds one body" in svg.lost
    assert not svg.same
    assert svg.content.count(b'id="hole"') == 1
    wide = Mechanism(bodies, (joints[1], replace(joints[0], stiffness=1e-4, rest_angle=4.0)), "x")
    with pytest.raises(UnsupportedError, match="drawings hold up to 180"):
        converted(wide, Path("x.dxf"), Path("x.yaml"))

"""Parameters of drawings as such: each against what the file would give with that number in it."""

import json
import pickle
import re
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc import examples
from lamc.effects import Spring
from lamc.readers.joints_layers import layers_of
from lamc.readers.joints_writer import write_joints
from lamc.readers.load import load_text
from lamc.readers.mechanism_file import mechanism_text


@pytest.fixture(autouse=True)
def quiet() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lamc.DesignWarning)
        yield


def example(name: str) -> lamc.Design:
    made = lamc.load(examples.path(name))
    assert isinstance(made, lamc.Design)
    return made


def fold(path: Path, side: float) -> Path:
    """A square of two triangles with a valley between them, side in mm."""
    corners = [[0, 0], [side, 0], [side, side], [0, side]]
    edges = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]]
    data = {
        "vertices_coords": corners,
        "edges_vertices": edges,
        "edges_assignment": [*"BBBBV"],
        "frame_unit": "mm",
    }
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def test_designs_have_scale_thickness_width_and_material_constants(shared: Path) -> None:
    design = lamc.load(shared / "designs" / "popupcad" / "pendulum.cad")
    assert list(design.parameters) == [
        "scale",
        *(f"{layer}.thickness" for layer in ("rigid", "adhesive", "flexible", "adhesive_2", "rigid_2")),
        *(f"{material}.density" for material in ("rigid", "adhesive", "flexible")),
        "width",
    ]
    assert design.parameters["width"].default == 1e-5
    board = example("six_bar").parameters
    assert {"board.E1", "polyimide.poisson", "lower_tape.thickness", "arm_scoop.width"} <= set(board)


@pytest.mark.parametrize("name", ["six_bar", "flaps"])
def test_values_of_the_file_give_its_design_to_the_last_bit(name: str) -> None:
    design = example(name)
    same = {each: parameter.default for each, parameter in design.parameters.items()}
    assert design.with_parameters(same) == design
    assert design.with_parameters(scale=1.5).with_parameters(scale=1) == design


def test_a_scaled_design_is_the_file_with_its_lengths_written_larger() -> None:
    """Twice: powers of two round alike. Thicknesses stay."""
    text = Path(examples.path("six_bar")).read_text(encoding="utf-8")
    larger = load_text(_doubled(text), "six_bar.yaml")
    assert isinstance(larger, lamc.Design)
    assert lamc.split(example("six_bar").with_parameters(scale=2)) == lamc.split(larger)


def _doubled(text: str) -> str:
    """The numbers of outlines, lines, gaps and names of bodies, twice."""

    def twice(match: re.Match[str]) -> str:
        return re.sub(r"-?\d+", lambda number: str(2 * int(number[0])), match[0])

    text = re.sub(r"rect: \[[^]]*\]|line: \[\[.*\]\]|gap: \d+", twice, text)
    return re.sub(r"ground: \[-20, 15\]|arm: \[20, 7\]|at: \[.*\]", twice, text)


def test_constants_and_thickness_are_the_files_with_those_numbers() -> None:
    text = Path(examples.path("six_bar")).read_text(encoding="utf-8")
    text = text.replace(
        "name: lower_tape, material: foam_tape, thickness: 2.3",
        "name: lower_tape, material: foam_tape, thickness: 3.1",
    ).replace("density: 700 kg/m^3", "density: 650 kg/m^3")
    other = load_text(text, "six_bar.yaml")
    assert isinstance(other, lamc.Design)
    changed = example("six_bar").with_parameters({"lower_tape.thickness": "3.1 mm", "board.density": 650})
    assert changed.layers == other.layers
    assert lamc.split(changed) == lamc.split(other)


def test_the_stiffness_of_film_follows_its_thickness_where_the_file_asks_for_it() -> None:
    """k = E b t³ / (12 L) of a strip that is narrow against its width: eight times as stiff, twice as thick."""
    text = Path(examples.path("six_bar")).read_text(encoding="utf-8")
    text = text.replace("stiffness: 0.023 N*mm/rad", "stiffness: from-material")
    design = load_text(text, "six_bar.yaml")
    thicker = design.with_parameters({"lower_film.thickness": "50 um"})
    assert isinstance(design, lamc.Design)
    assert isinstance(thicker, lamc.Design)
    assert thicker.hinges[0].stiffness / design.hinges[0].stiffness == pytest.approx(
        8.0, rel=1e-12
    )  # round-off


def test_a_sheet_of_creases_is_the_larger_file_with_another_card(tmp_path: Path) -> None:
    sheet, larger = (lamc.load(fold(tmp_path / "s.fold", side)) for side in (64, 128))
    assert list(sheet.parameters) == ["scale", "thickness", "density", "crease"]
    assert sheet.with_parameters(scale=2) == larger
    given = lamc.load(fold(tmp_path / "s.fold", 64), card=lamc.Card("0.5 mm", 900), crease=2e-3)
    assert sheet.with_parameters(thickness="0.5 mm", density=900, crease=2e-3) == given
    assert pickle.loads(pickle.dumps(sheet)).with_parameters(scale=2) == larger


def test_a_joint_definition_and_a_mechanism_are_scaled(tmp_path: Path) -> None:
    mechanism = lamc.split(example("six_bar"))
    write_joints(mechanism, layers_of(mechanism), tmp_path / "f.joints")
    joints = lamc.load(tmp_path / "f.joints")
    assert isinstance(joints, lamc.Mechanism)
    assert joints.with_parameters(scale=1) == joints
    twice = joints.with_parameters(scale=2)
    assert isinstance(twice, lamc.Mechanism)
    for one, other in zip(joints.bodies, twice.bodies, strict=True):
        assert other.mass == pytest.approx(4.0 * one.mass, rel=1e-12)  # round-off of sums over corners
        assert other.com == pytest.approx(one.com * [2, 2, 1], rel=1e-12)
    read = load_text(mechanism_text(mechanism), "f.yaml")
    assert isinstance(read, lamc.Mechanism)
    half = read.with_parameters(scale=0.5, mass=3)
    assert isinstance(half, lamc.Mechanism)
    for one, other in zip(read.bodies, half.bodies, strict=True):
        assert other.mass == 3.0 * 0.125 * one.mass
        assert np.array_equal(other.com, 0.5 * one.com)


def test_scenes_go_along_and_lengths_that_may_be_of_anything_are_refused() -> None:
    scene = lamc.Scene(outputs=(lamc.OutputPoint("tip", "shelf", (0.06, 0.01, 0.004)),))
    scaled = replace(example("six_bar"), scene=scene).with_parameters(scale=2).scene
    assert scaled is not None
    assert scaled.outputs == (lamc.OutputPoint("tip", "shelf", (0.12, 0.02, 0.004)),)
    spring = Spring("ground", (0, 0, 0), "shelf", (0.06, 0, 0), stiffness=1.0, rest_length=0.05)
    sprung = replace(example("six_bar"), scene=lamc.Scene(added=(spring,)))
    with pytest.raises(lamc.DesignError, match=r"the scene has spring with .* a length"):
        sprung.with_parameters(scale=2)
    assert sprung.with_parameters({"lower_tape.thickness": 0.003}).scene == sprung.scene


def test_a_name_that_there_is_not_names_the_nearest() -> None:
    with pytest.raises(lamc.DesignError, match=r"'bord.density'; did you mean 'board.density'\?"):
        example("six_bar").with_parameters({"bord.density": 3})
    with pytest.raises(lamc.DesignError, match=r"parameter 'scale' is 0; it must be at least 0.001"):
        example("six_bar").with_parameters(scale=0)
    mechanism = lamc.split(example("six_bar"))
    assert not mechanism.parameters
    with pytest.raises(lamc.DesignError, match="no parameter is named 'scale'"):
        mechanism.with_parameters(scale=2)


# ---- families -----------------------------------------------------------------------------------------------------


@lamc.Family
def pendulum(
    length: float = "0.4 m",  # type: ignore[assignment]
    mass: float = lamc.DesignParameter("0.1 kg", minimum=0.01, meaning="of the rod"),  # type: ignore[assignment]
) -> lamc.Mechanism:
    """A rod on a hinge."""
    rod = lamc.Body("rod", mass, [0, -length / 2, 0], np.diag([1.0, 0.01, 1.0]) * mass * length**2 / 12)
    return lamc.Mechanism(
        (lamc.Body("world", fixed=True), rod), (lamc.Joint("h", "world", "rod"),), "pendulum"
    )


def test_a_function_of_dimensions_is_a_family() -> None:
    assert pendulum.parameters == {
        "length": lamc.DesignParameter(0.4, "m"),
        "mass": lamc.DesignParameter(0.1, "kg", 0.01, None, "of the rod"),
    }
    longer = pendulum(length="0.5 m")
    assert longer.bodies[1].com[1] == -0.25
    assert longer.parameters["length"].default == 0.5
    assert longer.with_parameters(mass=0.2) == pendulum.with_parameters(length=0.5, mass=0.2)
    assert pickle.loads(pickle.dumps(longer)).with_parameters(length=0.4) == pendulum()
    assert pendulum.__doc__ == "A rod on a hinge."


def test_a_family_refuses_what_makes_no_sense() -> None:
    with pytest.raises(lamc.DesignError, match="no parameter is named 'lenght'; did you mean 'length'"):
        pendulum(lenght=1)
    with pytest.raises(lamc.DesignError, match=r"'mass' is 0.001 kg; it must be at least 0.01 kg"):
        pendulum(mass="1 g")
    with pytest.raises(lamc.DesignError, match="takes no 'lenth'; did you mean 'length'"):
        lamc.Family(pendulum.function, {"lenth": "1 m"})
    with pytest.raises(lamc.DesignError, match=r"the argument 'x' of family .* has no default"):
        lamc.Family(lambda x: x)
    with pytest.raises(lamc.DesignError, match=r"returned 3.0; it must return a Mechanism"):
        lamc.Family(lambda x=3.0: x)()
    with pytest.raises(lamc.DesignError, match="give a function"):
        lamc.Family(3)  # type: ignore[arg-type]


# ---- what a design was read from ------------------------------------------------------------------------------------


def test_drawings_beside_a_design_are_read_once(tmp_path: Path) -> None:
    """Neither another evaluation nor one in another process needs the file again."""
    outline = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="20mm" viewBox="0 0 40 20" fill="none">'
    )
    (tmp_path / "top.svg").write_text(
        outline + '<rect width="40" height="20" stroke="black"/></svg>', encoding="utf-8"
    )
    (tmp_path / "d.yaml").write_text(
        "units: mm\nparameters: {at: 15 mm, t: 0.3 mm}\n"
        "materials: {card: {density: 700, rigid: true}, film: {density: 1390, flexible: true}}\n"
        "layers: [{name: f, material: film, thickness: 25 um}, {name: c, material: card, thickness: t}]\n"
        "shapes: [{shape: {file: top.svg}}]\n"
        "hinges: [{name: h, line: [[at, -20], [at, 0]], gap: 1}]\n"
        "fixed: [{rect: [0, -20, 5, 0]}]\n",
        encoding="utf-8",
    )
    design = lamc.load(tmp_path / "d.yaml")
    assert isinstance(design, lamc.Design)
    (tmp_path / "top.svg").unlink()
    moved = design.with_parameters(at="20 mm", t="0.5 mm")
    assert moved.layers[1].geometry == design.layers[1].geometry
    assert moved.mends == design.mends
    assert pickle.loads(pickle.dumps(design)).with_parameters(at="20 mm", t="0.5 mm") == moved


def test_a_table_beside_a_design_is_read_once(tmp_path: Path) -> None:
    (tmp_path / "law.csv").write_text("-1,-2e-3\n0,0\n1,3e-3\n", encoding="utf-8")
    text = Path(examples.path("flaps")).read_text(encoding="utf-8")
    text = text.split("\nscene")[0].replace("units: mm\n", "units: mm\nparameters: {tilt: 10 deg}\n")
    text += "\nscene: {with: {nonlinear_stiffness: {left: {file: law.csv}}}, angles: {right: tilt}}\n"
    (tmp_path / "d.yaml").write_text(text, encoding="utf-8")
    design = lamc.load(tmp_path / "d.yaml")
    assert isinstance(design, lamc.Design)
    (tmp_path / "law.csv").unlink()
    tilted = design.with_parameters(tilt=0.3).scene
    assert tilted is not None
    assert tilted.angles == {"right": 0.3}
    assert design.scene is not None
    assert tilted.added == design.scene.added

"""Named dimensions of native designs: what they make is what numbers in their place would, and every mistake has its
place."""

import pickle
from pathlib import Path

import pytest

import lamc
from lamc.basics.errors import DesignErrors
from lamc.readers.load import load_text

HEAD = """\
kind: design
units: mm
parameters:
  length: {default: 40 mm, min: 10, max: 90 mm, meaning: of the arm}
  tilt: 30 deg
  t: {default: 0.3 mm, min: 0.1 mm}
  w: length/4
  k: 2 N*mm/rad
  count: 2
"""
BODY = """\
materials: {card: {density: 700, rigid: true}, film: {density: 1420, E1: 2.5 GPa, poisson: 0.3, flexible: true}}
layers:
  - {name: board, material: card, thickness: 2*t}
  - {name: film, material: film, thickness: 25 um, angle: tilt/3}
shapes:
  - {rect: [-length, 0, length, w]}
  - {cut: {rect: [-0.5, 0, 0.5, w + 1]}, layers: board}
hinges:
  - {name: h1, line: [[0, 0], [0, w]], layer: film, gap: t + 1, stiffness: k*(t/0.3 mm)^3, limits: [-3*tilt, 2*tilt]}
fixed: [{rect: [-length, 0, 5 - length, w]}]
bodies: {arm: [length/count, w/2]}
scene:
  effects:
    - hinge_stiffness
    - torque: {h1: k*tilt}
    - gravity: [0, 0, -9.81]
  angles: {h1: tilt}
  duration: length/(20 mm/s)
  outputs: [{name: tip, body: arm, point: [length, w/2, 0]}]
"""
NUMBERS = BODY
for name, number in (
    ("[-length, 0, length, w]", "[-40, 0, 40, 10]"),
    ("w + 1", "11"),
    ("2*t}", "0.6}"),
    ("tilt/3", "0.17453292519943292"),
    ("[0, w]]", "[0, 10]]"),
    ("t + 1,", "1.3,"),
    ("k*(t/0.3 mm)^3", "0.002"),
    ("[-3*tilt, 2*tilt]", "[-1.5707963267948963, 1.0471975511965976]"),
    ("[-length, 0, 5 - length, w]", "[-40, 0, -35, 10]"),
    ("[length/count, w/2]", "[20, 5]"),
    ("k*tilt", str(2e-3 * 0.5235987755982988)),
    ("{h1: tilt}", "{h1: 30 deg}"),
    ("length/(20 mm/s)", "2"),
    ("[length, w/2, 0]", "[40, 5, 0]"),
):
    assert NUMBERS.count(name) >= 1
    NUMBERS = NUMBERS.replace(name, number)


def design(text: str = HEAD + BODY) -> lamc.Design:
    made = load_text(text, "d.yaml")
    assert isinstance(made, lamc.Design)
    return made


def numbered(text: str = NUMBERS) -> lamc.Design:
    """Moved down, so that hinge lines stand in the same lines of the file."""
    return design("\n" * (HEAD.count("\n") - 2) + "kind: design\nunits: mm\n" + text)


def problems(text: str) -> list[str]:
    with pytest.raises(lamc.DesignError) as caught:
        load_text(text, "d.yaml")
    error = caught.value
    return [str(each) for each in (error.problems if isinstance(error, DesignErrors) else [error])]


def test_parameters_at_their_defaults_are_the_numbers_written_in_to_the_last_bit() -> None:
    assert design() == numbered()
    assert lamc.split(design()) == lamc.split(numbered())


def test_what_follows_from_a_value_is_what_its_file_would_give() -> None:
    longer = HEAD.replace("default: 40 mm", "default: 56.7 mm").replace("30 deg", "35 deg")
    assert design().with_parameters(length="56.7 mm", tilt="35 deg") == design(longer + BODY)
    assert design().with_parameters(length=0.0567).with_parameters({"tilt": "35 deg"}) == design(
        longer + BODY
    )


def test_a_design_tells_its_parameters_with_their_present_values() -> None:
    made = design().parameters
    assert list(made) == ["length", "tilt", "t", "w", "k", "count"]
    assert made["length"] == lamc.DesignParameter(0.04, "m", 0.01, 0.09, "of the arm")
    assert (made["w"].default, made["k"].unit, made["count"].unit) == (0.01, "N·m/rad", "1")
    longer = design().with_parameters(length=0.06)
    assert longer.parameters["length"].default == 0.06
    assert longer.parameters["w"].default == 0.015
    assert longer.with_parameters(w=0.02).with_parameters(length=0.05).parameters["w"].default == 0.02


def test_designs_stay_what_they_are_and_compare_by_their_drawing() -> None:
    first = design()
    assert first.with_parameters(length=0.05) != first
    assert first == design()
    assert first.with_parameters(length=0.05).with_parameters(length=0.04) == first
    assert first.with_parameters() is first
    assert hash(first) == hash(design())


def test_a_design_with_parameters_goes_to_another_process() -> None:
    there = pickle.loads(pickle.dumps(design().with_parameters(tilt=0.4)))
    assert there == design().with_parameters(tilt=0.4)
    assert there.with_parameters(length=0.05) == design().with_parameters(tilt=0.4, length=0.05)


def test_a_file_is_loaded_with_other_values(tmp_path: Path) -> None:
    file = tmp_path / "d.yaml"
    file.write_text(HEAD + BODY, encoding="utf-8")
    loaded = lamc.load(file, set={"length": "50 mm", "count": 4})
    assert isinstance(loaded, lamc.Design)
    assert loaded.parameters["length"].default == 0.05
    assert loaded.body_names[0].point.x == 0.0125
    with pytest.raises(lamc.DesignError, match="no parameter is named 'lenght'; did you mean 'length'"):
        lamc.load(file, set={"lenght": 1})


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"length": 0.1}, "d.yaml:4:21: parameter 'length' is 0.1 m; it must be at most 0.09 m"),
        ({"t": "10 um"}, "d.yaml:6:16: parameter 't' is 1e-05 m; it must be at least 0.0001 m"),
        ({"lenght": 0.1}, "no parameter is named 'lenght'; did you mean 'length'?"),
        ({"length": "3 deg"}, "parameter 'length' is '3 deg'; 'deg' is not a unit of"),
        ({"length": float("nan")}, "parameter 'length' is nan; it must be finite"),
        ({"length": True}, "parameter 'length' is True; it must be a number"),
        ({"w": 0}, "d.yaml:15:5: shapes[0]: the rectangle encloses no area"),
    ],
)
def test_values_that_make_no_sense_are_refused_by_name(values: dict[str, float], said: str) -> None:
    with pytest.raises(lamc.DesignError) as caught:
        design().with_parameters(values)
    assert str(caught.value).startswith(said) or said in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "thickness: 2*t",
            "thickness: 2*tt",
            "12:46: layers[0].thickness: expression '2*tt', column 3: no parameter",
        ),
        ("2*t}", "2*t + tilt}", "column 7: a length (m) and an angle (rad) cannot be added or compared"),
        (
            "2*t}",
            "2*tilt}",
            "12:46: layers[0].thickness: '2*tilt' is an angle (rad); the length is expected in m",
        ),
        (
            "2*t}",
            "t/(count - 2)}",
            "12:46: layers[0].thickness: expression 't/(count - 2)', column 3: division by",
        ),
        (
            "2*t}",
            "t*exp(1000*count)}",
            "12:46: layers[0].thickness: expression 't*exp(1000*count)', column 3: exp(",
        ),
        ("2*t}", "t - 1}", "12:46: layers[0].thickness: the length is -0.0007 m; it must be above 0"),
        ("2*t}", "2 t}", "12:46: layers[0].thickness: expression '2 t', column 3: write 2*t"),
        (
            "2*t}",
            "t.x}",
            "12:46: layers[0].thickness: expression 't.x', column 2: '.' is not in the language",
        ),
        ("[length/count, w/2]", "[max(w, t), 0]", "quote an expression with a comma"),
        ("k*tilt", "k*w", "24:20: scene.effects[1].torque.h1: 'k*w' is kg·m³/rad/s²; the"),
        (
            "{h1: tilt}",
            "{h1: length}",
            "26:16: scene.angles.h1: 'length' is a length (m); the angle is expected in rad",
        ),
        (
            "  tilt: 30 deg",
            "  tilt: 30 deg\n  spare: 3",
            "6:3: parameters.spare: nothing of the design follows from",
        ),
        ("  tilt: 30 deg", "  tilt: 30 dgg", "5:9: parameters.tilt: 'dgg' is not a unit that lamc knows"),
        (
            "  tilt: 30 deg",
            "  tilt: k*2",
            "layers[1].angle: 'tilt/3' is a hinge stiffness (N·m/rad); the angle is",
        ),
        (
            "w: length/4",
            "w: lenght/4",
            "7:6: parameters.w: expression 'lenght/4', column 1: no parameter is named",
        ),
        (
            "w: length/4",
            "w: length/(count-2)",
            "7:6: parameters.w: expression 'length/(count-2)', column 8: division",
        ),
        (
            "w: length/4",
            "w: 2*v\n  v: w/2",
            "7:6: parameters.w: 'w', which needs 'v', which needs 'w': a parameter",
        ),
        (
            "w: length/4",
            "w: w",
            "7:6: parameters.w: 'w', which needs 'w': a parameter cannot follow from itself",
        ),
        ("w: length/4", "w: [1, 2]", "7:6: parameters.w: it is a list; write a number with its unit"),
        ("w: length/4", "w: true", "7:6: parameters.w: it is no number"),
        ("w: length/4", "w:", "7:3: parameters.w: it is no number"),
        (
            "w: length/4",
            "w: {default: length/4, mni: 3}",
            "7:26: parameters.w: a parameter has no 'mni'; did you mean",
        ),
        ("w: length/4", "w: {min: 3}", "7:6: parameters.w: a parameter needs its default"),
        (
            "w: length/4",
            "w: {default: length/4, max: 5}",
            "7:16: parameters.w: parameter 'w' is 0.01 m; it must be at",
        ),
        (
            "w: length/4",
            "w: {default: length/4, max: 5 deg}",
            "7:31: parameters.w.max: it is an angle (rad), and the",
        ),
        (
            "w: length/4",
            "w: {default: length/4, min: 5, max: 4}",
            "7:6: parameters.w: its min is 0.005 and its max",
        ),
        (
            "w: length/4",
            "w: length/4\n  mm: 3",
            "8:3: a parameter is named 'mm', which is a unit; choose another",
        ),
        ("w: length/4", "w: length/4\n  sin: 3", "8:3: a parameter is named 'sin', which is a function"),
        ("w: length/4", "w: length/4\n  2x: 3", "8:3: a parameter is named '2x'; a name is of letters"),
    ],
)
def test_every_mistake_is_told_at_its_place(old: str, new: str, said: str) -> None:
    text = HEAD + BODY
    assert old in text
    found = problems(text.replace(old, new, 1))
    assert any(said in each for each in found), found
    assert all(each.startswith("d.yaml:") for each in found)


def test_arithmetic_stands_for_numbers_without_parameters_too() -> None:
    plain = numbered(NUMBERS.replace("0.6}", "0.2*3}").replace("[20, 5]", "[sqrt(400), 10/2]"))
    assert plain == numbered()


def test_expressions_of_effects_take_values_of_parameters() -> None:
    """In them t is the time, as ever."""
    drive = HEAD + BODY.replace("k*tilt}", "count*k*sin(2*pi*t) - angle*1e-3}")
    scene = design(drive).scene
    assert scene is not None
    assert scene.effects is not None
    torque = scene.effects[1]
    assert isinstance(torque, lamc.Torque)
    assert dict(torque.torques) == {"h1": "2.0*0.002*sin(2*pi*t) - angle*1e-3"}


def test_replaced_parts_stay_or_are_refused() -> None:
    from dataclasses import replace

    scene = lamc.Scene(angles={"h1": 0.1})
    assert replace(design(), scene=scene).with_parameters(length=0.05).scene == scene
    with pytest.raises(lamc.DesignError, match=r"hinges of .* were replaced by hand"):
        replace(design(), hinges=()).with_parameters(length=0.05)

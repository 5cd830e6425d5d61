"""Several scenes per design: what each has, what it is like, where it is told to be wrong, and how it is chosen."""

import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import lamc
from lamc import examples
from lamc.basics.errors import DesignError, LamcError
from lamc.cli import main
from lamc.commands.inputs import SceneChanges, changed_scene
from lamc.effects.registry import choose
from lamc.readers.load_scene import scene_of_text
from lamc.readers.mechanism_file import write_mechanism
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.outputs import outputs_of

ARM = """\
kind: mechanism
bodies:
  - {name: wall, fixed: true}
  - {name: arm, mass: 2, com: [0.5, 0, 0], inertia: [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]}
joints:
  - {name: h, parent: wall, child: arm, point: [0, 0, 0], axis: [0, 1, 0], stiffness: 3, damping: 0.5}
"""

SCENES = """\
units: mm
scene: {like: calm}
scenes:
  calm: {without: hinge_damping, angles: {h: 0.1}, rates: {h: 30 deg/s}, duration: 3 s}
  shaken:
    like: calm
    with:
      torque: {h: 2*sin(t)}
      joint_limits: {stiffness: 4 N*m/rad}
    angles: {h: 0.2}
  damped: {like: shaken, with: {hinge_damping: }, without: [torque, gravity]}
  bare: {like: damped, effects: {gravity: [0, 0, -1.62]}}
  heavier: {like: bare, with: {gravity: [0, 0, -20], spring: {body_a: wall, point_a: [1, 2, 3], body_b: arm,
            point_b: [0.5 m, 0, 0], stiffness: 4}}, outputs: [h, arm.z]}
"""


def scene(name: str | None = None, text: str = SCENES) -> Scene:
    return scene_of_text(text, "s.yaml", name)


def arm(tmp_path: Path, scenes: str = "") -> Mechanism:
    file = tmp_path / "arm.yaml"
    file.write_text(ARM + scenes, encoding="utf-8")
    record = lamc.load(file)
    assert isinstance(record, Mechanism)
    return record


def names(mechanism: Mechanism, of: Scene) -> set[str]:
    return {choice.name for choice in choose(mechanism, of) if choice.effect is not None}


def acting(mechanism: lamc.Mechanism, of: lamc.Scene) -> dict[str, object]:
    return {choice.name: choice.effect for choice in choose(mechanism, of)}


def test_a_scene_has_what_it_is_like_and_says_otherwise(tmp_path: Path) -> None:
    mechanism = arm(tmp_path)
    calm, shaken = scene("calm"), scene("shaken")
    assert names(mechanism, calm) == {"gravity", "hinge_stiffness"}
    assert (calm.angles, calm.rates, calm.duration) == ({"h": 0.1}, {"h": math.pi / 6}, 3.0)
    assert shaken.added == (lamc.Torque({"h": "2*sin(t)"}), lamc.JointLimits(stiffness=4.0))
    assert (shaken.angles, shaken.rates, shaken.duration) == ({"h": 0.2}, {"h": math.pi / 6}, 3.0)
    assert names(mechanism, scene("damped")) == {"hinge_damping", "hinge_stiffness", "joint_limits"}


def test_effects_that_are_listed_are_all_there_are(tmp_path: Path) -> None:
    mechanism = arm(tmp_path)
    assert acting(mechanism, scene("bare"))["gravity"] == lamc.Gravity((0.0, 0.0, -1.62))
    assert names(mechanism, scene("bare")) == {"gravity"}
    heavier = scene("heavier")
    assert names(mechanism, heavier) == {"gravity", "spring"}
    assert acting(mechanism, heavier)["gravity"] == lamc.Gravity((0.0, 0.0, -20.0))
    assert heavier.outputs == ("h", "arm.z")


def test_bare_lengths_of_effects_count_in_the_unit_of_the_file() -> None:
    (_, spring) = scene("heavier").added
    # millimetres become metres by one division, which rounds once
    assert spring == lamc.Spring("wall", (1e-3, 2e-3, 3e-3), "arm", (0.5, 0.0, 0.0), 4.0)


def test_the_default_scene_may_be_like_a_named_one() -> None:
    assert scene() == scene("calm")


@pytest.mark.parametrize(
    ("text", "name", "same"),
    [
        ("angles: {h: 1}\n", None, Scene(angles={"h": 1.0})),
        ("kind: scene\nunits: mm\nclosure_tolerance: 2\n", None, Scene(closure_tolerance=2e-3)),
        ("scenes: {a: {duration: 1}}\n", None, Scene(duration=1.0)),
        ("scenes: {a: {duration: 1}, b: {duration: 2}}\n", "b", Scene(duration=2.0)),
        (ARM + "scenes: {a: {duration: 1}, b: {duration: 2}}\n", "a", Scene(duration=1.0)),
    ],
)
def test_files_of_scenes_have_several_forms(text: str, name: str | None, same: Scene) -> None:
    assert scene(name, text) == same


def test_a_scene_is_loaded_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(SCENES, encoding="utf-8")
    assert lamc.load_scene(tmp_path / "s.yaml", "shaken") == scene("shaken")
    assert lamc.load_scene(str(tmp_path / "s.yaml")) == scene("calm")


REFUSED = [
    (
        "scenes: {a: {like: b}, b: {duration: 1}, c: {like: bb}}",
        "1:52: scenes.c.like: no scene of this file is named 'bb'",
    ),
    (
        "scenes:\n  a: {like: b}\n  b: {like: c}\n  c: {like: a}",
        "4:13: scenes.c.like: 'a', which is like 'b', which is like 'c', which is like 'a'"
        ": a scene cannot be like itself",
    ),
    ("scenes:\n  a: {like: a}", "2:13: scenes.a.like: 'a', which is like 'a'"),
    (
        "scenes: {a: {duration: 1}}\nscene: a",
        "2:8: scene: a scene is a map, and it is 'a'; write {like: NAME}",
    ),
    ("scenes:\n  a: {}", "2:6: scenes.a: the scene says nothing; give effects, angles"),
    ("scenes:\n  a:", "2:3: scenes.a: a map of keys and values is expected here"),
    ("scene: {}", "1:8: scene: the scene says nothing"),
    ("scenes:\n  a b: {duration: 1}", "2:8: scenes.a b: 'a b' is no name of a scene"),
    ("scenes:\n  a: {duration: 1}\n  a: {duration: 2}", "3:3: the key 'a' stands twice"),
    (
        "scenes:\n  a: {angels: {h: 1}}",
        "2:7: scenes.a.angels: the key 'angels' is unknown; did you mean 'angles'?",
    ),
    ("scenes:\n  a: {duration: 0}", "2:17: scenes.a.duration: the duration is 0 s; it must be above 0"),
    ("scenes:\n  a: {duration: 3 m}", "2:17: scenes.a.duration: 'm' is not a unit of duration"),
    (
        "scenes:\n  a: {effects: {gravty: }}",
        "2:17: scenes.a.effects.gravty: no effect is named 'gravty'; did you mean 'gravity'?",
    ),
    (
        "scenes:\n  a: {with: {joint_limits: {stifness: 1}}}",
        "2:39: scenes.a.with.joint_limits.stifness: joint_limits has no field 'stifness'; did you mean 'stiffness'?",
    ),
    (
        "scenes:\n  a: {with: [gravity, {joint_limits: {stiffness: 1 N*mm}}]}",
        "2:50: scenes.a.with[1].joint_limits.stiffness: 'N*mm' names no angle",
    ),
    (
        "scenes:\n  a: {with: {torque: {h: 3 kg}}}",
        "2:26: scenes.a.with.torque.h: 'kg' is not a unit of torque of 'h'",
    ),
    (
        "scenes:\n  a: {with: {torque: {h: 3*x}}}",
        "2:26: scenes.a.with.torque.h: the torque of joint 'h': expression '3*x', column 3: 'x' is not known",
    ),
    (
        "scenes:\n  a: {with: {torque: {h: __import__('os')}}}",
        "2:26: scenes.a.with.torque.h: the torque of joint 'h': expression",
    ),
    (
        "scenes:\n  a: {without: [gravty]}",
        "2:17: scenes.a.without[0]: no effect is named 'gravty'; did you mean 'gravity'?",
    ),
    ("scenes:\n  a: {without: 3}", "2:16: scenes.a.without: without takes names of effects"),
    (
        "scenes:\n  a: {with: {gravity: }, without: gravity}",
        "2:14: scenes.a.with.gravity: the scene adds 'gravity' and is to be without it",
    ),
    ("scenes:\n  a: {effects: [gravity, gravity]}", "2:6: scenes.a: the scene calls for Gravity twice"),
    ("scenes:\n  a: {effects: gravity}", "2:16: scenes.a.effects: effects are a map from name to value"),
    ("scenes:\n  a: {outputs: []}", "2:6: scenes.a: outputs of a scene is empty"),
    ("scenes:\n  a: {outputs: [h, h]}", "2:6: scenes.a: outputs of a scene has 'h' twice"),
    ("scenes:\n  a: {branch: 0}", "2:6: scenes.a: branch of a scene is 0"),
    ("scenes: [1]", "1:9: scenes: a map of keys and values is expected here"),
    (
        "scenes: {" + ", ".join(f"s{k}: {{duration: 1}}" for k in range(1001)) + "}",
        "1:9: scenes: the file has 1001 scenes; at most 1000 are read",
    ),
    ("units: mm", "1:1: the file: the scene says nothing"),
    ("- 1", "holds a list"),
    ("layers: []", "key is missing"),
    ("kind: plate", "`lamc plate` solves it"),
]


@pytest.mark.parametrize(("text", "said"), REFUSED)
def test_wrong_scenes_are_refused_at_their_place(text: str, said: str) -> None:
    with pytest.raises(LamcError) as caught:
        scene(None, text)
    lines = str(caught.value).splitlines()
    assert all(line.startswith("s.yaml:") for line in lines)
    assert any(said in line for line in lines), lines


@pytest.mark.parametrize(("text", "said"), [(t, s) for t, s in REFUSED if t.startswith("scene")])
def test_designs_refuse_the_same_scenes(tmp_path: Path, text: str, said: str) -> None:
    """Behind six lines of a mechanism."""
    with pytest.raises(LamcError) as caught:
        arm(tmp_path, text)
    line, colon, rest = said.partition(":")
    reported = f":{int(line) + ARM.count(chr(10))}{colon}{rest}"
    assert any(reported in each for each in str(caught.value).splitlines()), str(caught.value)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        (None, "the file has the scenes a, b; say which, as in s.yaml:a"),
        ("c", "no scene of the file is named 'c'"),
    ],
)
def test_a_scene_that_is_not_told_or_not_there_is_refused(name: str | None, said: str) -> None:
    with pytest.raises(DesignError) as caught:
        scene(name, "scenes: {a: {duration: 1}, b: {duration: 2}}")
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("section", "said"),
    [
        ("angles: {hh: 1}", "8:20: scenes.a.angles.hh: no joint is named 'hh'; did you mean 'h'?"),
        ("rates: {x: 1}", "8:18: scenes.a.rates.x: no joint is named 'x'; known are h"),
    ],
)
def test_a_start_of_no_joint_is_refused_where_it_stands(tmp_path: Path, section: str, said: str) -> None:
    with pytest.raises(LamcError) as caught:
        arm(tmp_path, f"scenes:\n  a: {{{section}}}\n")
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("section", "at", "said"),
    [
        ("with: {joint_limits: }", "8:", "no joint has limits narrower than ±180°; give joints limits"),
        ("with: {torque: {arm: 1}}", "8:", "'arm'"),
        ("with: {free_base: }", "8:", "free_base"),
        ("with: {free_base: , base_motion: {angle: t}}", "8:", "both claim the motion of the base"),
        ("with: {torque: {h: 1/angle}}", "8:", "no value at the start"),
        (
            "outputs: [h, arm.w]",
            "8:20",
            "output 'arm.w' is no coordinate and no body's position; did you mean 'arm",
        ),
        ("outputs: [g]", "8:17", "output 'g' is no coordinate"),
        ("branch: 1", "8:15", "a mechanism without loops has none"),
    ],
)
def test_what_does_not_fit_the_mechanism_is_refused_with_its_place(
    tmp_path: Path, section: str, at: str, said: str
) -> None:
    mechanism = arm(tmp_path, f"scenes:\n  a: {{{section}}}\n")
    with pytest.raises(LamcError) as caught:
        lamc.compile(mechanism, mechanism.scenes["a"]).run(t_end=0.1)
    assert f"arm.yaml:{at}" in str(caught.value)
    assert said in str(caught.value)


def test_angles_of_a_design_are_refused_where_they_stand(tmp_path: Path) -> None:
    """Only after splitting is it known which joints a drawing has."""
    text = examples.find("flaps").text.partition("\nscenes:")[0] + "\nscenes: {a: {angles: {lift: 1}}}\n"
    (tmp_path / "flaps.yaml").write_text(text, encoding="utf-8")
    design = lamc.load(tmp_path / "flaps.yaml")
    with pytest.raises(
        LamcError, match=rf"flaps\.yaml:{text.count(chr(10))}:.*initial angle to joint 'lift'"
    ):
        lamc.compile(design, design.scenes["a"])


@pytest.mark.parametrize("default", ["", "scene: {like: calm}\n", "scene: {rates: {h: 2}}\n"])
def test_all_scenes_are_written_and_read_back(tmp_path: Path, default: str) -> None:
    sections = SCENES.replace("units: mm\n", "").replace("scene: {like: calm}\n", default)
    given = arm(tmp_path, sections.replace("[0.5 m, 0, 0]", "[0.5, 0, 0]"))
    assert list(given.scenes) == ["calm", "shaken", "damped", "bare", "heavier"]
    write_mechanism(given, tmp_path / "again.yaml")
    again = lamc.load(tmp_path / "again.yaml")
    assert isinstance(again, Mechanism)
    assert again.scenes == given.scenes
    assert again.scene == given.scene


def test_a_scene_that_says_nothing_can_be_written(tmp_path: Path) -> None:
    given = Mechanism(*(getattr(arm(tmp_path), part) for part in ("bodies", "joints")), scenes={"a": Scene()})
    write_mechanism(given, tmp_path / "again.yaml")
    assert lamc.load(tmp_path / "again.yaml").scenes == {"a": Scene()}


def test_scenes_go_from_the_drawing_to_the_mechanism() -> None:
    design = lamc.load(examples.path("pendulum"))
    mechanism = lamc.split(design)  # type: ignore[arg-type]
    assert dict(mechanism.scenes) == dict(design.scenes)
    assert set(mechanism.scenes) == {"swing", "driven"}
    with pytest.raises(TypeError):
        mechanism.scenes["more"] = Scene()  # type: ignore[index]


@pytest.mark.parametrize(
    ("scenes", "said"),
    [
        ([Scene()], "it must map names to Scenes"),
        ({"a": {}}, "the scene 'a' of mechanism 'm' is {}; it must be a Scene"),
        ({"a.b": Scene()}, "a scene of mechanism 'm' is named 'a.b'; a name is of letters"),
        ({"": Scene()}, "a name is a string that is not empty"),
    ],
)
def test_scenes_by_hand_are_checked(tmp_path: Path, scenes: object, said: str) -> None:
    given = arm(tmp_path)
    with pytest.raises(DesignError) as caught:
        Mechanism(given.bodies, given.joints, "m", scenes=scenes)  # type: ignore[arg-type]
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"added": lamc.Gravity()}, "write added=(Gravity(),)"),
        ({"without": "gravity"}, "without of a scene is 'gravity'; it must be a tuple of names"),
        ({"added": (lamc.Gravity(),), "without": ("gravity",)}, "the scene adds 'gravity' and leaves it out"),
        ({"duration": -1}, "duration of a scene is -1.0"),
        ({"outputs": "h"}, "outputs of a scene is 'h'; it must be a tuple of names"),
    ],
)
def test_fields_of_a_scene_by_hand_are_checked(fields: dict[str, object], said: str) -> None:
    with pytest.raises(DesignError) as caught:
        Scene(**fields)  # type: ignore[arg-type]
    assert said in str(caught.value)


def test_a_name_of_no_effect_cannot_be_left_out(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match="without 'drag', which is no effect"):
        choose(arm(tmp_path), Scene(without=("drag",)))


def test_options_change_the_scene_that_they_name(tmp_path: Path) -> None:
    mechanism = arm(tmp_path, SCENES.replace("units: mm\n", ""))
    changes = SceneChanges(
        ["gravity=[0, 0, -1]", "hinge_damping"], ["torque"], ["h=10 deg"], (), None, "shaken"
    )
    changed, account = changed_scene(mechanism, changes)
    reported = {choice.name: (choice.effect is not None, choice.reason) for choice in account}
    assert reported["gravity"] == (True, "added by --with")
    assert reported["hinge_damping"] == (True, "added by --with")
    assert reported["torque"] == (False, "left out by --without")
    assert reported["joint_limits"] == (True, "added by the scene")
    assert changed.angles["h"] == math.radians(10)
    assert changed.duration == 3.0
    assert {e.name for e in changed.effects or ()} == {n for n, (acts, _) in reported.items() if acts}


def test_outputs_of_a_run_are_angles_coordinates_and_positions(tmp_path: Path) -> None:
    """A free base adds coordinates; without gravity or springs all of it stays where it starts."""
    mechanism = arm(tmp_path)
    scene = Scene(effects=(lamc.FreeBase(),), angles={"h": 0.5}, outputs=("h", "base.qw", "arm.x", "wall.z"))
    wall = lamc.Body("wall", 1.0, inertia=np.eye(3), fixed=True)
    free = Mechanism((wall, mechanism.bodies[1]), mechanism.joints)
    found = outputs_of(lamc.compile(free, scene).run(t_end=1.0), scene)
    assert [(o.name, o.unit) for o in found] == [
        ("h", "rad"),
        ("base.qw", "1"),
        ("arm.x", "m"),
        ("wall.z", "m"),
    ]
    for output, value in zip(found, (0.5, 1.0, 0.5 * math.cos(0.5), 0.0), strict=True):
        np.testing.assert_allclose(
            output.values, value, rtol=0, atol=1e-15
        )  # nothing acts: round-off of the pose
    assert [o.name for o in outputs_of(lamc.compile(mechanism).run(t_end=0.1), Scene())] == ["h"]


def test_springs_add_to_those_of_the_scene(tmp_path: Path) -> None:
    mechanism = arm(tmp_path, SCENES.replace("units: mm\n", ""))
    spring = "spring={body_a: wall, point_a: [0, 0, 0], body_b: arm, point_b: [1, 0, 0], stiffness: 1}"
    changed, _ = changed_scene(mechanism, SceneChanges(with_effects=[spring, spring], scene="heavier"))
    assert [e.name for e in changed.effects or ()].count("spring") == 3


def call(*words: str) -> Result:
    return CliRunner().invoke(main, [*words])


def test_the_command_line_runs_a_scene_for_its_duration(tmp_path: Path) -> None:
    arm(tmp_path)
    (tmp_path / "s.yaml").write_text(SCENES, encoding="utf-8")
    words = ["run", str(tmp_path / "arm.yaml"), "--scene", f"{tmp_path / 's.yaml'}:heavier"]
    done = call(*words, "--out", str(tmp_path / "out"))
    assert done.exit_code == 0, done.stderr
    assert "the end was reached at t = 3 s" in done.stdout
    assert "scene   " in done.stdout
    assert "outputs at 3 s: h " in done.stdout


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("clam", "error: --scene: no scene is named 'clam'; did you mean 'calm'?"),
        ("no.yaml", "error: no.yaml: there is no such file"),
        ("s.yaml:clam", "no scene of the file is named 'clam'; did you mean 'calm'?"),
        ("s.yaml:not a name", "error: s.yaml:not a name: there is no such file"),
        ("file", "for the file of that name write --scene ./file"),
    ],
)
def test_a_scene_that_is_not_there_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, word: str, said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    arm(tmp_path, SCENES.replace("units: mm\n", ""))
    (tmp_path / "s.yaml").write_text(SCENES, encoding="utf-8")
    (tmp_path / "file").write_text(SCENES, encoding="utf-8")
    done = call("run", "arm.yaml", "--scene", word, "--quiet")
    assert done.exit_code == 2
    (line,) = done.stderr.splitlines()
    assert said in line


def test_a_file_of_scenes_is_no_design(tmp_path: Path) -> None:
    for text in (SCENES, "angles: {h: 1}\n", "kind: scene\nangles: {h: 1}\n"):
        (tmp_path / "s.yaml").write_text(text, encoding="utf-8")
        with pytest.raises(DesignError, match="lamc run DESIGN --scene FILE"):
            lamc.load(tmp_path / "s.yaml")

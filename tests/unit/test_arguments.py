"""Arguments of the wrong type, and values nature does not allow, are refused in one line that tells the way out."""

import copy
import pickle
from collections.abc import Callable
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import lamc
from lamc.basics.errors import BuildError, DesignError, LamcError, RequestError
from lamc.cli import main
from lamc.readers.mechanism_file import write_mechanism
from lamc.run.parameters import checked_parameters

HUGE = 10**5000  # more digits than Python prints, more than a float holds
INERTIA = np.diag([1e-6, 1e-6, 2e-6])


def world() -> lamc.Body:
    return lamc.Body("world", fixed=True)


def link(**changes: object) -> lamc.Body:
    return replace(lamc.Body("link", mass=0.01, inertia=INERTIA), **changes)  # type: ignore[arg-type]


def joint(**changes: object) -> lamc.Joint:
    return replace(lamc.Joint("h1", "world", "link", stiffness=0.1, damping=0.01), **changes)  # type: ignore[arg-type]


def mechanism(**changes: object) -> lamc.Mechanism:
    return replace(lamc.Mechanism((world(), link()), (joint(),)), **changes)  # type: ignore[arg-type]


CASES: list[tuple[Callable[[], object], str]] = [
    (lambda: joint(limits=None), "the limits of joint 'h1' are None; they must be two angles"),
    (lambda: joint(limits=5), "are 5; they must be two angles"),
    (lambda: joint(limits=(1,)), "are (1,); they must be two angles"),
    (lambda: joint(limits=(0, 1, 2)), "are (0, 1, 2); they must be two angles"),
    (lambda: joint(limits="12"), "are '12'; they must be two angles"),
    (lambda: joint(stiffness=HUGE), "the stiffness of joint 'h1' is <int>, which no float holds"),
    (lambda: joint(name=HUGE), "a joint has the name <int>"),
    (lambda: link(outline=None), "outline of body 'link' is None; it must be a tuple of Slab records"),
    (lambda: link(outline=(1, 2)), "outline of body 'link' holds 1; each must be a Slab"),
    (lambda: link(mass=10**400), "the mass of body 'link' is 1000"),
    (lambda: link(mass=HUGE), "the mass of body 'link' is <int>, which no float holds; it must be finite"),
    (
        lambda: link(com=(HUGE, 0, 0)),
        "the centre of mass of body 'link' is <tuple>; it must hold (3,) numbers",
    ),
    (lambda: link(fixed="no"), "fixed of body 'link' is 'no'; it must be True or False"),
    (lambda: link(fixed=1), "fixed of body 'link' is 1; it must be True or False"),
    (
        lambda: mechanism(bodies=None),
        "bodies of mechanism 'mechanism' is None; it must be a tuple of Body records",
    ),
    (lambda: mechanism(bodies=world()), "is a single Body; put it into a tuple: bodies=(body,)"),
    (lambda: mechanism(bodies={"world": world()}), "is a dict; it must be a tuple of Body records"),
    (lambda: mechanism(joints=joint()), "is a single Joint; put it into a tuple: joints=(joint,)"),
    (lambda: mechanism(joints=["h1"]), "joints of mechanism 'mechanism' holds 'h1'; each must be a Joint"),
    (lambda: mechanism(scene=5), "scene of mechanism 'mechanism' is 5; it must be a Scene, or None"),
    (lambda: lamc.Scene(effects=lamc.Gravity()), "write effects=(Gravity(),)"),  # type: ignore[arg-type]
    (lambda: lamc.Scene(effects=lamc.Gravity), "write effects=(Gravity(),)"),  # type: ignore[arg-type]
    (lambda: lamc.Scene(effects=5), "effects of a scene is 5; it must be None or a tuple"),  # type: ignore[arg-type]
    (lambda: lamc.Scene(effects="gravity"), "is 'gravity'; it must be None or a tuple"),  # type: ignore[arg-type]
    (lambda: lamc.Scene(effects=(5,)), "holds 5, which is no effect"),  # type: ignore[arg-type]
    (lambda: lamc.Scene(effects=(lamc.Gravity,)), "the class Gravity; make one: Gravity()"),  # type: ignore[arg-type]
    (lambda: lamc.Scene(effects=[None]), "holds None, which is no effect"),  # type: ignore[arg-type, list-item]
    (lambda: lamc.Scene(effects=("gravity",)), "make an instance of one"),  # type: ignore[arg-type]
    (lambda: lamc.Scene(angles=None), "angles of a scene is None; it must map joint names"),  # type: ignore[arg-type]
    (lambda: lamc.Scene(rates=[1.0]), "rates of a scene is [1.0]; it must map joint names"),  # type: ignore[arg-type]
    (lambda: lamc.compile("file.yaml"), "lamc.compile(lamc.load('file.yaml'))"),  # type: ignore[arg-type]
    (lambda: lamc.compile(None), "the design is None"),  # type: ignore[arg-type]
    (lambda: lamc.compile(mechanism(), 5), "the scene is 5; it must be a Scene"),  # type: ignore[arg-type]
    (lambda: lamc.compile(mechanism(), {}), "the scene is {}; it must be a Scene"),  # type: ignore[arg-type]
    (lambda: lamc.compile(mechanism(), None, 5), "options is 5; it must be CompileOptions"),  # type: ignore[arg-type]
    (lambda: lamc.split(mechanism()), "'mechanism' is a Mechanism already"),  # type: ignore[arg-type]
    (lambda: lamc.split("file"), "split takes the Design that lamc.load gives"),  # type: ignore[arg-type]
    (lambda: lamc.load(None), "the path is None"),  # type: ignore[arg-type]
    (lambda: lamc.load(5), "the path is 5; it must be a string or a pathlib.Path"),  # type: ignore[arg-type]
    (lambda: lamc.load(b"x"), "the path is b'x'"),  # type: ignore[arg-type]
    (lambda: lamc.load("x", materials=5), "materials is 5; it must map names"),  # type: ignore[arg-type]
    (lambda: lamc.CompileOptions(compiler=5), "compiler is 5; it must be a command"),  # type: ignore[arg-type]
    (lambda: lamc.CompileOptions(fast="x"), "fast is 'x'; it must be True or False"),  # type: ignore[arg-type]
]


@pytest.mark.parametrize(("slip", "words"), CASES, ids=[words[:40] for _, words in CASES])
def test_a_slip_is_reported_in_one_line(slip: Callable[[], object], words: str) -> None:
    with pytest.raises(LamcError) as caught:
        slip()
    assert isinstance(caught.value, DesignError | BuildError)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


def test_what_is_equivalent_is_taken() -> None:
    assert joint(limits=[-1, 1]).limits == joint(limits=np.array([-1.0, 1.0])).limits == (-1.0, 1.0)
    assert lamc.Body("world", fixed=np.bool_(True)).fixed is True  # type: ignore[arg-type]
    listed = mechanism(bodies=[world(), link()], joints=iter([joint()]))
    assert listed == mechanism()
    assert lamc.Scene(effects=[lamc.Gravity()]).effects == (lamc.Gravity(),)  # type: ignore[arg-type]
    assert lamc.Scene(effects=[]).effects == ()  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "value", "rule"),
    [
        ("link_1.mass", -1.0, "a mass must be above zero"),
        ("link_1.mass", 0.0, "a mass must be above zero"),
        ("a.b.stiffness", -1e-300, "a stiffness must be zero or more"),
        ("h1.damping", -0.1, "a damping must be zero or more"),
        ("link_1.inertia_xx", -1e-9, "a moment of inertia must be zero or more"),
        ("link_1.inertia_yy", -1e-9, "a moment of inertia must be zero or more"),
        ("link_1.inertia_zz", -1e-9, "a moment of inertia must be zero or more"),
        ("h1.motor.resistance", 0.0, "a resistance must be above zero"),
        ("h1.motor.2.torque_constant", -0.1, "the torque constant of a motor must be above zero"),
        ("h1.motor.no_load_speed", 0.0, "the no-load speed of a motor must be above zero"),
        ("wing.air.density", -1.2, "a density must be zero or more"),
        ("wing.air.drag_edge_on", -0.4, "a coefficient of drag must be zero or more"),
        ("h.cross_stiffness.slide_z", -1.0, "a stiffness must be zero or more"),
        ("b.modal_damping.12_12", -1.0, "a damping must be zero or more"),
        ("h.cross_damping.twist_x", -1.0, "a damping must be zero or more"),
    ],
)
def test_a_parameter_that_nature_forbids_is_refused(name: str, value: float, rule: str) -> None:
    with pytest.raises(RequestError) as caught:
        checked_parameters({name: value}, {name: "SI"})
    assert str(caught.value) == f"parameter {name!r} is {value:g} SI; {rule}"


def test_parameters_that_nature_allows_are_taken() -> None:
    wanted = {
        "h.stiffness": 0,
        "h.damping": 0.0,
        "b.inertia_xx": 0.0,
        "b.inertia_xy": -1.0,
        "gravity_z": -9.81,
        "lift": -1.0,
        "b.modal_damping.1_2": -1.0,
        "h.cross_stiffness.twist_y_slide_z": -1.0,
    }
    assert checked_parameters(wanted, dict.fromkeys(wanted, "SI")) == wanted


def test_true_is_no_value_of_a_parameter() -> None:
    for value in (True, np.bool_(False)):
        with pytest.raises(RequestError, match=r"parameter 'h\.angle' is .*; it must be a number in rad"):
            checked_parameters({"h.angle": value}, {"h.angle": "rad"})


def test_compiled_parameters_follow_the_rules() -> None:
    simulator = lamc.compile(mechanism())
    checked = {
        name for name in simulator.parameters if name.rpartition(".")[2] in ("mass", "stiffness", "damping")
    }
    assert {"h1.stiffness", "h1.damping"} <= checked
    for name in sorted(checked):
        with pytest.raises(RequestError, match=f"'{name}' is -1 "):
            simulator.run(t_end=0.1, parameters={name: -1.0})


def test_scenes_and_mechanisms_survive_copies_and_pickles() -> None:
    scene = lamc.Scene(effects=(lamc.Gravity(),), angles={"h1": 0.1}, rates={"h1": 2.0})
    for twin in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene)), replace(scene)):
        assert twin == scene
        with pytest.raises(TypeError):
            twin.angles["h1"] = 1.0
    data = asdict(lamc.Scene(effects=(lamc.Torque({"h1": 0.5}),), angles={"h1": 0.1}))
    assert (data["effects"], data["angles"], data["rates"]) == (({"torques": {"h1": 0.5}},), {"h1": 0.1}, {})
    whole = mechanism(scene=scene)
    assert pickle.loads(pickle.dumps(whole)) == copy.deepcopy(whole) == whole


@pytest.mark.parametrize("path", [None, 5, ["a.csv"]])
def test_a_path_that_is_none_is_refused(path: object) -> None:
    result = lamc.compile(mechanism()).run(t_end=0.0)
    for write in (result.to_csv, result.to_npz, partial(write_mechanism, mechanism())):
        with pytest.raises(RequestError, match=r"the path to write to is .*; it must be a text or a Path"):
            write(path)  # type: ignore[arg-type]


@pytest.mark.parametrize("points", ["100000000000", "50000000"])
def test_more_rows_than_memory_holds_are_refused(points: str, tmp_path: Path, shared: Path) -> None:
    design = shared / "designs" / "popupcad" / "pendulum.cad"
    answer = CliRunner().invoke(
        main, ["run", str(design), "--points", points, "--out", str(tmp_path / "out")]
    )
    assert answer.exit_code == 2
    assert f"--points is {points}; at most" in answer.output
    assert "Traceback" not in answer.output

"""Points of bodies as outputs: where they are by closed forms, how errors of them are measured, what is refused."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc import examples
from lamc.basics.errors import DesignError, LamcError
from lamc.codegen.options import CompileOptions
from lamc.commands.examples import mechanism_of_example
from lamc.ledger import Sweep, measure
from lamc.readers.load_scene import scene_of_text
from lamc.readers.mechanism_file import write_mechanism
from lamc.readers.schema import json_schema
from lamc.run.outputs import outputs_of
from tests.physics.test_flexible_links import SHEET, flag
from tests.physics.test_ledger import FREE, Quiet, rod, swing

TIP = lamc.OutputPoint("tip", "rod", (0.0, 0.02, -1.0))
ROUND_OFF = 4e-15  # m, of a few products of numbers near 1


def with_outputs(scene: lamc.Scene, *outputs: str | lamc.OutputPoint) -> lamc.Scene:
    return lamc.Scene(effects=scene.effects, angles=scene.angles, outputs=outputs)


def test_tip_of_a_rod_is_on_its_circle_where_jacobis_functions_say() -> None:
    """About +y by the right-hand rule, (0, y, -1) goes to (-sin θ, y, -cos θ)."""
    result = lamc.compile(rod(), with_outputs(FREE, TIP)).run(4.0, 1e-12, 1e-14, np.linspace(0.0, 4.0, 41))
    angle, tip = swing(result.t, 1.5), result.point("tip")
    assert tip.shape == (41, 3)
    exact = np.column_stack([-np.sin(angle), np.full(41, 0.02), -np.cos(angle)])
    np.testing.assert_allclose(tip, exact, rtol=0, atol=1e-9)  # rtol of each step, of some 300 of them
    theta = result.angle("h")
    here = np.column_stack([-np.sin(theta), np.full(41, 0.02), -np.cos(theta)])
    np.testing.assert_allclose(tip, here, rtol=0, atol=ROUND_OFF)


def test_a_point_far_from_its_body_is_told(recwarn: pytest.WarningsRecorder) -> None:
    lamc.compile(rod(), with_outputs(FREE, TIP))
    assert not recwarn.list
    lamc.compile(rod(), with_outputs(FREE, lamc.OutputPoint("tip", "rod", (0.0, 20.0, -1000.0))))
    told = [str(each.message) for each in recwarn.list]
    assert any("'tip' lies" in text and "are these mm?" in text for text in told), told


def floating_arm() -> lamc.Mechanism:
    base = lamc.Body("base", 2.0, (0.1, 0.0, 0.0), np.diag([0.1, 0.2, 0.3]), fixed=True)
    arm = lamc.Body("arm", 1.0, (0.6, 0.0, 0.0), np.diag([0.01, 0.1, 0.1]))
    hinge = lamc.Joint("h", "base", "arm", (0.3, 0.0, 0.0), (0.0, 1.0, 0.0))
    return lamc.Mechanism((base, arm), (hinge,), name="floating")


def test_points_of_what_falls_freely_fall_freely() -> None:
    """Everything at rest falls as one: p = R (drawn - com) + position - g t²/2, for the base and what hangs on it."""
    points = (
        lamc.OutputPoint("corner", "base", (0.1, 0.2, 0.05)),
        lamc.OutputPoint("tip", "arm", (1.0, 0.0, -0.1)),
    )
    base = lamc.FreeBase(position=(1.0, 2.0, 3.0), rotation=(0.0, 0.0, math.pi / 2))
    scene = lamc.Scene(effects=(base, lamc.Gravity()), outputs=points)
    result = lamc.compile(floating_arm(), scene).run(2.0, 1e-12, 1e-14)
    for each in points:
        x, y, z = np.array(each.point) - [0.1, 0.0, 0.0]  # from the base's centre of mass
        exact = np.array([1.0 - y, 2.0 + x, 3.0 + z]) + np.outer(-0.5 * 9.81 * result.t**2, [0.0, 0.0, 1.0])
        # round-off of 20 m, of some 10 steps
        np.testing.assert_allclose(result.point(each.name), exact, rtol=0, atol=1e-12)


def test_points_of_a_base_that_is_moved_go_where_it_is_moved() -> None:
    """Displaced by 0.1 sin(3 t) along x and turned by t about z, through the world's origin."""
    motion = lamc.BaseMotion(displacement=("0.1*sin(3*t)", "0", "0"), axis=(0.0, 0.0, 1.0), angle="t")
    corner = lamc.OutputPoint("corner", "base", (0.1, 0.2, 0.05))
    scene = lamc.Scene(effects=(motion,), outputs=(corner,))
    result = lamc.compile(floating_arm(), scene).run(2.0, t_eval=np.linspace(0.0, 2.0, 21))
    c, s = np.cos(result.t), np.sin(result.t)
    exact = np.column_stack([0.1 * c - 0.2 * s + 0.1 * np.sin(3 * result.t), 0.1 * s + 0.2 * c, 0.05 + 0 * c])
    np.testing.assert_allclose(result.point("corner"), exact, rtol=0, atol=ROUND_OFF)


def test_both_sides_of_a_hinge_that_closes_a_loop_are_one_point() -> None:
    mechanism = mechanism_of_example(examples.find("four_bar"))
    cut = mechanism.joint(lamc.compile(mechanism).cut_joints[0])
    at = tuple(float(v) for v in cut.point)
    sides = (lamc.OutputPoint("here", cut.parent, at), lamc.OutputPoint("there", cut.child, at))
    base = mechanism.scene or lamc.Scene()
    scene = lamc.Scene(base.effects, base.angles, base.rates, base.branch, added=base.added, outputs=sides)
    result = lamc.compile(mechanism, scene).run(1.0)
    assert np.ptp(result.point("here"), axis=0).max() > 1e-3 * mechanism.size  # it does move
    gap = np.abs(result.point("here") - result.point("there")).max()
    assert gap <= result.constraint_error.max() + 1e-15 * mechanism.size


# ---- errors ---------------------------------------------------------------------------------------------------


def test_errors_of_a_point_are_relative_to_its_largest_range() -> None:
    """Across the plane of the swing nothing moves: a range of its own would make round-off an error of its size."""
    simulator = lamc.compile(rod(), with_outputs(FREE, TIP))
    result = simulator.run(4.0, accuracy=1e-5)
    facts = result.accuracy
    assert facts is not None
    assert set(facts.by_output) == {"tip.x", "tip.y", "tip.z"}
    assert facts.reached
    assert facts.by_output["tip.y"] < 1e-12
    exact = -np.sin(swing(result.t, 1.5))
    true = np.abs(result.point("tip")[:, 0] - exact).max() / np.ptp(exact)
    assert true / 10.0 <= facts.by_output["tip.x"] <= 1e-5  # what an estimate is promised to be


def test_ledger_measures_errors_of_a_point() -> None:
    sweep = Sweep(t_end=2.0, integrators=("rk45",), tolerances=(1e-3, 1e-5), budget=20.0)
    scene = with_outputs(FREE, TIP, "h")
    ledger = measure(rod(), scene, CompileOptions(), sweep, Quiet(), with_account=False)
    assert [o.name for o in ledger.outputs] == ["tip.x", "tip.y", "tip.z", "h"]
    assert ledger.outputs[0].scale == ledger.outputs[1].scale == ledger.outputs[2].scale
    point = ledger.points[0]
    simulator, times = lamc.compile(rod(), scene), np.linspace(0.0, 2.0, sweep.rows)
    theta, angle = simulator.run(2.0, 1e-3, 1e-5, times, "rk45").angle("h"), swing(times, 1.5)
    off = [
        np.abs(np.sin(theta) - np.sin(angle)).max() / np.ptp(np.sin(angle)),
        np.abs(np.cos(theta) - np.cos(angle)).max() / np.ptp(np.sin(angle)),  # z, over the range of x
        np.abs(theta - angle).max() / np.ptp(angle),
    ]
    assert point.path == pytest.approx(max(off), rel=1e-4)  # errors above 1e-5, the reference's below 1e-12


def test_table_of_a_result_has_the_path_of_a_point(tmp_path: Path) -> None:
    result = lamc.compile(rod(), with_outputs(FREE, TIP)).run(1.0, t_eval=[0.0, 0.5, 1.0])
    with result.to_csv(tmp_path / "r.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    reported = np.array([[float(row[f"tip.{axis} (m)"]) for axis in "xyz"] for row in rows])
    np.testing.assert_array_equal(reported, result.point("tip"))
    assert [o.name for o in outputs_of(result, with_outputs(FREE, TIP))] == ["tip.x", "tip.y", "tip.z"]
    with pytest.raises(KeyError, match="no output point is named 'top'; there are tip"):
        result.point("top")


# ---- files ----------------------------------------------------------------------------------------------------

SCENE = """\
units: mm
outputs: [h, {name: tip, body: rod, point: [0, 2 cm, -1000]}]
"""


def test_a_file_holds_points_with_units_and_they_are_written_back(tmp_path: Path) -> None:
    scene = scene_of_text("kind: scene\n" + SCENE, "s.yaml")
    assert scene.outputs == ("h", TIP)
    mechanism = lamc.Mechanism(rod().bodies, rod().joints, name="rod", scene=scene)
    write_mechanism(mechanism, tmp_path / "rod.yaml")
    read = lamc.load(tmp_path / "rod.yaml")
    assert read.scene is not None
    assert read.scene.outputs == ("h", TIP)


@pytest.mark.parametrize(
    ("outputs", "at", "reported"),
    [
        ("[h, {name: tip, body: rod}]", "3:14", "outputs[1].point: this key is missing"),
        ("[{name: tip, body: rod, point: [0, 1]}]", "3:", "outputs[0].point"),
        ("[{name: tip, body: rod, point: [0, 1, .nan]}]", "3:", "outputs[0].point[2]"),
        ("[{name: tip, body: rod, point: [0, 1, 2 kg]}]", "3:", "outputs[0].point[2]"),
        ("[{name: tip, body: rod, at: [0, 0, 0]}]", "3:", "the key 'at' is unknown"),
        ("[3]", "3:11", "outputs[0]"),
        ("[h, {name: h, body: rod, point: [0, 0, 0]}]", "1:", "outputs of a scene has 'h' twice"),
    ],
)
def test_a_point_that_is_none_is_refused_at_its_line(outputs: str, at: str, reported: str) -> None:
    with pytest.raises(LamcError) as caught:
        scene_of_text(f"kind: scene\nunits: mm\noutputs: {outputs}\n", "s.yaml")
    assert reported in str(caught.value)
    assert f"s.yaml:{at}" in str(caught.value)
    assert len(str(caught.value).splitlines()) <= 2  # a problem, or a problem and its sum


def test_points_that_do_not_fit_the_mechanism_are_refused_at_their_line() -> None:
    for entry, reported in (
        (
            "{name: tip, body: rot, point: [0, 0, 0]}",
            "is of body 'rot', which is not there; did you mean 'rod'?",
        ),
        ("{name: rod, body: rod, point: [0, 0, 0]}", "has the name of something else"),
    ):
        scene = scene_of_text(f"kind: scene\noutputs: [h, {entry}]\n", "s.yaml")
        with pytest.raises(DesignError) as caught:
            lamc.compile(rod(), scene)
        assert reported in str(caught.value)
        assert "s.yaml:2:14" in str(caught.value)


def test_points_by_hand_are_checked() -> None:
    with pytest.raises(DesignError, match=r"the output point 'tip' is .*every number must be finite"):
        lamc.OutputPoint("tip", "rod", (0.0, math.inf, 0.0))
    with pytest.raises(DesignError, match="must have shape"):
        lamc.OutputPoint("tip", "rod", (0.0, 0.0))  # type: ignore[arg-type]
    with pytest.raises(DesignError, match="a name is a string"):
        lamc.OutputPoint("", "rod", (0.0, 0.0, 0.0))
    with pytest.raises(DesignError, match="an OutputPoint, no tuple"):
        lamc.Scene(outputs=TIP)  # type: ignore[arg-type]
    with pytest.raises(DesignError, match="has 'tip' twice"):
        lamc.Scene(outputs=(TIP, TIP))


def test_points_of_bodies_that_bend_are_refused_and_those_of_others_are_not() -> None:
    mechanism, effect = flag(), lamc.FlexibleLinks(modes=1, laminate=SHEET)
    name = next(body.name for body in mechanism.bodies if not body.fixed)
    rigid = next(body.name for body in mechanism.bodies if body.fixed)
    at = (0.0, 0.0, 0.0)
    lamc.compile(mechanism, lamc.Scene(effects=(effect,), outputs=(lamc.OutputPoint("p", rigid, at),)))
    with pytest.raises(DesignError, match="which bends, and only rigid bodies"):
        lamc.compile(mechanism, lamc.Scene(effects=(effect,), outputs=(lamc.OutputPoint("p", name, at),)))


def test_the_schema_has_names_and_points() -> None:
    definitions = json_schema()["$defs"]
    (entries,) = (
        each["items"]
        for each in definitions["SceneModel"]["properties"]["outputs"]["anyOf"]
        if "items" in each
    )
    assert entries["anyOf"][0] == {"type": "string"}
    assert set(definitions["OutputPointModel"]["required"]) == {"name", "body", "point"}

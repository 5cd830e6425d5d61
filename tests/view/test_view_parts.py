"""What a page is made of: packing, recordings, kinematics and scenes, in Python and in node."""

import json
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.export.pages import mechanism_show, result_show
from lamc.loops.geometry import LoopGeometry
from lamc.mechanism.plan import plan
from lamc.readers.scene_writer import scene_data
from lamc.view.pack import packed
from lamc.view.recording import curve_specs, knots, motion_of, quaternions, recording_data
from lamc.view.shape import shape_data
from tests.support.ctools import needs_cc
from tests.support.exported_folders import mechanism_of, needs
from tests.support.mechanisms import random_tree
from tests.support.pages import engine_script, in_node, run, simulator

HOSTILE = "</script><img src=x onerror=alert(1)>\"'&{{7*7}}\u2028é"


@needs("node")
def test_packed_data_are_the_same_on_the_other_side(tmp_path: Path) -> None:
    arrays = {
        "bytes": np.arange(7, dtype="u1"),
        "short": np.array([-3, 4], dtype="i2"),
        "word": np.array([65535], dtype="u2"),
        "long": np.array([1 << 31], dtype="u4"),
        "float": np.array([0.5, -2.0], dtype="f4"),
        "double": np.array([0.1, 1e300]),
        "none": np.zeros(0),
    }
    text = packed({**arrays, "names": [HOSTILE], "nan": float("nan"), "number": 0.1, "raw": b"\0\1"})
    assert set(text) <= set("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/=")
    found = in_node(
        "result = JSON.parse(JSON.stringify(await unpacked(text), (_, v) => (ArrayBuffer.isView(v) ? [...v] : v)));",
        tmp_path, text=text,
    )  # fmt: skip
    for name, array in arrays.items():
        assert found[name] == array.tolist()
    assert found["names"] == [HOSTILE]
    assert found["nan"] is None
    assert found["number"] == 0.1
    assert found["raw"] == [0, 1]


def test_straight_lines_between_knots_err_by_no_more_than_one() -> None:
    t = np.sort(np.random.default_rng(1).uniform(0.0, 3.0, 800))
    channels = np.column_stack([20.0 * np.sin(5.0 * t), 3.0 * t, 40.0 * np.abs(t - 1.0)])
    kept = knots(t, channels)
    back = np.column_stack([np.interp(t, t[kept], c[kept]) for c in channels.T])
    assert np.abs(back - channels).max() <= 1.0 + 1e-12  # round-off
    assert len(kept) < len(t) / 4


def test_quaternions_give_their_rotations_back_and_never_jump() -> None:
    angles = np.linspace(0.0, 12.0, 200)
    c, s, o, e = np.cos(angles), np.sin(angles), np.zeros(200), np.ones(200)
    about_x = np.stack([np.stack(r, axis=1) for r in ((e, o, o), (o, c, -s), (o, s, c))], axis=1)
    tilt = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    found = quaternions((about_x @ tilt)[:, None])[:, 0]
    assert np.abs(np.diff(found, axis=0)).max() < 0.04  # half the angle of a step
    w, v = found[:, :1], found[:, 1:]
    point = np.array([0.3, -0.2, 0.9])
    cross = np.cross(v, point)
    turned = point + 2.0 * (w * cross + np.cross(v, cross))
    np.testing.assert_allclose(turned, about_x @ tilt @ point, atol=1e-14)  # round-off of products of ones


@needs_cc
@pytest.mark.parametrize("name", ["pendulum", "crawler"])
def test_a_recording_errs_by_what_it_tells(name: str) -> None:
    result = run(name, 1.0)
    specs = curve_specs(result, result.mechanism, (), result.energies)
    size = float(shape_data(result.mechanism)["size"])
    motion = motion_of(result, specs, size)
    data = recording_data(motion, 1e-3, size)
    assert (
        data["error"]["length"] <= 1.6e-3 * size
    )  # the tolerance, and half a step of 16 bits of each of 7 numbers
    assert data["error"]["share"] <= 1.1e-3
    assert len(data["t"]) < len(motion.t)


@needs_cc
@needs("node")
def test_the_page_has_the_curves_that_were_recorded(tmp_path: Path) -> None:
    result = run("pendulum", 1.0)
    specs = curve_specs(result, result.mechanism, (), result.energies)
    motion = motion_of(result, specs, 1.0)
    data = recording_data(motion, 1e-3, 1.0)
    found = in_node(
        "const m = Motion.recorded(await unpacked(text));"
        "result = times_.map((t) => m.curves.map((_, c) => m.curve(c, t)));",
        tmp_path, text=packed(data), times_=result.t.tolist(),
    )  # fmt: skip
    names = [spec["name"] for spec in specs]
    angles = np.array(found)[:, [names.index(joint) for joint in result.joints]]
    spans = np.ptp(result.q, axis=0)
    assert (np.abs(angles - result.q) <= (data["error"]["share"] + 1e-12) * spans).all()


@needs("node")
@pytest.mark.parametrize("seed", range(3))
def test_poses_by_hand_are_those_of_the_loops_geometry(seed: int, tmp_path: Path) -> None:
    mechanism = random_tree(6, seed)
    tree = plan(mechanism)
    geometry = LoopGeometry(tree)
    angles = np.random.default_rng(seed).uniform(-2.0, 2.0, 6)
    poses = geometry.poses(angles)
    by_name = dict(zip(geometry.names, angles.tolist(), strict=True))
    found = in_node(
        "result = new Kinematics(await unpacked(text)).poses(angles);", tmp_path,
        text=packed(shape_data(mechanism)), angles=[by_name[j.name] for j in mechanism.joints],
    )  # fmt: skip
    bodies = [body.name for body in mechanism.bodies]
    for index, link in enumerate(tree.links):
        pose = np.array(found[bodies.index(link.body.name)]).reshape(3, 4)
        expected = np.column_stack([poses.rotation[index], poses.shift[index]])
        np.testing.assert_allclose(pose, expected, atol=1e-12)  # round-off of six products


@needs("node")
@pytest.mark.parametrize("name", ["four_bar", "sarrus", "vertex"])
def test_a_slider_turns_its_hinge_and_the_loops_stay_closed(name: str, tmp_path: Path) -> None:
    mechanism = mechanism_of(name)
    show = mechanism_show(mechanism)
    count = len(mechanism.joints)
    goal = 0.3
    found = in_node(
        "const data = await unpacked(text); const k = new Kinematics(data);"
        "const way = (j) => data.ways.find((w) => Math.abs(w[j]) > 1e-6) ?? null;"
        "result = data.hinges.map((_, j) => k.turnedTo(data.start, j, goal, way(j)));",
        tmp_path, text=packed(show.data), goal=goal,
    )  # fmt: skip
    geometry = LoopGeometry(plan(mechanism))
    order = [[j.name for j in mechanism.joints].index(n) for n in geometry.names]
    reached = 0
    for joint in range(count):
        angles = np.array(found[joint])
        # Drawings are closed to within their decimals, and the page closes to 1e-10.
        assert (
            geometry.gaps(angles[order]).max()
            < 1e-6 * geometry.size + 2.0 * geometry.gaps(np.zeros(count)).max()
        )
        reached += abs(angles[joint] - goal) < 1e-12
    assert reached >= count - 1  # a crank can have no way to go


@needs("node")
def test_slopes_are_those_of_the_gaps(tmp_path: Path) -> None:
    show = mechanism_show(mechanism_of("sarrus"))
    found = in_node(
        "const data = await unpacked(text); const k = new Kinematics(data); const h = 1e-6;"
        "const a = data.hinges.map((_, j) => 0.001 * (j - 2)); const s = k.slopes(k.poses(a));"
        "const d = a.map((_, j) => { const [p, m] = [h, -h].map((e) => k.gaps(a.map((x, i) => x + (i === j ? e : 0))));"
        "return p.map((x, r) => (x - m[r]) / (2 * h)); });"
        "result = [s.map((row) => [...row]), d];",
        tmp_path, text=packed(show.data),
    )  # fmt: skip
    slopes, differences = np.array(found[0]), np.array(found[1]).T
    # They are exact where loops are closed; here they are off by what is open, at most the sum of all angles.
    np.testing.assert_allclose(slopes, differences, atol=9e-3)


@needs_cc
@needs("node")
@pytest.mark.parametrize("name", ["pendulum", "four_bar", "limit_stop"])
@pytest.mark.quick("pendulum", others="campaign")
def test_a_run_in_the_page_is_that_of_python(name: str, tmp_path: Path) -> None:
    engine, wasm = engine_script(name)
    sim = simulator(name)
    changed = next(p for p in sim.parameters if p.endswith("mass"))
    value = 1.25 * sim.parameters[changed]
    found = in_node(
        f"{engine}\nconst model = simulatorOf(await WebAssembly.compile(Buffer.from(wasm, 'base64')));"
        "const e = new Engine(model); const rows = [];"
        "const field = model.parameters.find((p) => p.name === name).field;"
        "const order = { duration: 0.5, rows: 51, settings: { rtol: 1e-9, atol: 1e-11 }, inputs: {}, q: null, u: null,"
        " parameters: { [field]: value } };"
        "const problem = e.run(order, (n) => { for (let k = 0; k < n.length; k += e.width)"
        " rows.push([...n.subarray(k, k + 1 + model.coordinates.length)]); });"
        "result = [problem, rows];",
        tmp_path, wasm=wasm, name=changed, value=value,
    )  # fmt: skip
    problem, rows = found
    assert problem is None
    expected = sim.run(0.5, t_eval=np.linspace(0.0, 0.5, 51), parameters={changed: value})
    # The same method and steps; the page's sine and cosine are lamc's own, and differ in the last bit.
    np.testing.assert_allclose(np.array(rows)[:, 1:], expected.q, rtol=0.0, atol=1e-9)


@needs("node")
def test_a_copied_scene_is_read_back(tmp_path: Path) -> None:
    base = lamc.Scene(
        effects=(lamc.Gravity((0.0, 0.0, -1.62)), lamc.Torque({"h1": "load*sin(3*t)"})),
        inputs={"load": lamc.Input(0.1, unit="N*m", meaning="on: the \"first\" # hinge")},
        angles={"h1": 0.1, "on": 1e-17}, duration=2.0,
    )  # fmt: skip
    text = in_node(
        "result = sceneText(base, { angles: { h2: 0.30000000000000004 }, inputs: { load: 0.25 },"
        " parameters: { \"a'b\\n\": 2 } });",
        tmp_path, base=json.loads(json.dumps(scene_data(base))),
    )  # fmt: skip
    assert text.startswith("# with --set 'a'\\''b =2'\n")
    path = tmp_path / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    found = lamc.load_scene(path)
    assert dict(found.angles) == {"h1": 0.1, "on": 1e-17, "h2": 0.30000000000000004}
    assert found.inputs["load"].default == 0.25
    assert found.inputs["load"].meaning == base.inputs["load"].meaning
    assert found.effects == base.effects
    assert found.duration == 2.0


@needs_cc
def test_the_limit_of_steps_goes_with_the_model() -> None:
    result = simulator("pendulum").run(0.2, max_step=1e-3)
    assert result_show(result, live=True).data["live"]["settings"]["maxStep"] == 1e-3
    free = simulator("pendulum").run(0.2)
    assert "maxStep" not in result_show(free, live=True).data["live"]["settings"]


@needs_cc
def test_a_stabilised_run_has_no_model_that_would_run_otherwise() -> None:
    show = result_show(simulator("four_bar").run(0.2, baumgarte=50.0), live=True)
    assert show.engine == ""
    assert any("stabilised" in note for note in show.notes)

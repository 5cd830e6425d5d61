"""Pages in a browser without a network: they open from files, are silent, and compute what Python does."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import lamc
from lamc import plate
from lamc.export.pages import mechanism_show, result_show
from lamc.view.document import MOST_BYTES, page
from tests.support.browser import Page, browser, needs_browser
from tests.support.ctools import needs_cc
from tests.support.exported_folders import mechanism_of
from tests.support.pages import page_of, run, simulator
from tests.support.wasm import has_wasm_tools, needs_wasm

pytestmark = [needs_cc, needs_browser]
HOSTILE = "</script><img src=x onerror=\"document.title='broken'\">'&"


@pytest.fixture(scope="module")
def tab() -> Iterator[Page]:
    with browser() as page:
        yield page


@pytest.fixture(autouse=True)
def silent(tab: Page) -> Iterator[None]:
    tab.console.clear()
    yield
    assert tab.console == []


TURN = """(async () => {
  const show = lamcView.shows[0];
  const slider = [...show.sliders.angles, ...show.sliders.model].find((each) => each.name === NAME);
  slider.take(VALUE, true);
  for (let k = 0; !show.settled && k < 3000; k++) await new Promise((go) => setTimeout(go, 10));
  return {
    status: show.status.textContent, wrong: slider.wrong.textContent,
    t: [...show.motion.t].slice(0, show.motion.filled),
    angles: show.data.curves.flatMap((c, k) => (c.group === "angles" ? [[c.name, [...show.motion.curves[k]]]] : [])),
  };
})()"""


def turned(tab: Page, name: str, value: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """A slider is moved and let go: times and angles of the run that follows."""
    found = tab.value(TURN.replace("NAME", json.dumps(name)).replace("VALUE", repr(value)))
    assert found["status"] == found["wrong"] == ""
    return np.array(found["t"]), {joint: np.array(values) for joint, values in found["angles"]}


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("width", [1280, 380])
def test_a_page_opens_and_shows_bodies(dark: bool, width: int, tab: Page, tmp_path: Path) -> None:
    path = page_of("four_bar", 1.0, tmp_path, live=False)
    tab.open(path, width=width, dark=dark, fragment="#t=0.5")
    tab.wait("lamcView.shows[0].stage.frames.length > 0")
    assert tab.value("document.body.dataset.ready") == "yes"
    assert tab.value("lamcView.shows[0].stage.painter.constructor.name") == "Painter"
    pixels = np.asarray(Image.open(tab.picture(tmp_path / "page.png")).convert("RGB")).astype(int)
    blue = (pixels[..., 2] > pixels[..., 0] + 60) & (pixels[..., 2] > 90)
    assert blue.sum() > 300  # the first moving body's colour, in the picture and in curves
    assert tab.value("document.documentElement.scrollWidth <= window.innerWidth")


def test_time_passes_and_can_be_chosen(tab: Page, tmp_path: Path) -> None:
    tab.open(page_of("pendulum", 1.0, tmp_path, live=False), fragment="#t=0")
    tab.value("lamcView.player.play(true)")
    tab.wait("lamcView.player.time > 0.05")
    tab.value("lamcView.player.play(false)")
    tab.value("lamcView.player.seek(0.5)")
    result = run("pendulum", 1.0)
    shown = tab.value(
        "lamcView.shows[0].data.curves.map((c, k) => [c.name, lamcView.shows[0].motion.curve(k, 0.5)])"
    )
    for joint in result.joints:
        span = float(np.ptp(result.angle(joint)))
        assert dict(shown)[joint] == pytest.approx(
            float(np.interp(0.5, result.t, result.angle(joint))), abs=2e-3 * span
        )


@needs_wasm
def test_a_slider_gives_the_run_of_python(tab: Page, tmp_path: Path) -> None:
    tab.open(page_of("pendulum", 1.0, tmp_path), fragment="#t=0")
    name = next(each for each in simulator("pendulum").parameters if each.endswith(".stiffness"))
    value = 1.7 * simulator("pendulum").parameters[name] + 1e-3
    for _ in range(2):  # in a worker, and once it is known to be quick, at once
        t, angles = turned(tab, name, value)
        expected = simulator("pendulum").run(1.0, t_eval=t, parameters={name: value})
        for joint, found in angles.items():
            np.testing.assert_allclose(found, expected.angle(joint), rtol=0.0, atol=1e-9)  # lamc's own sine
    tab.value("lamcView.shows[0].reset()")
    assert tab.value("lamcView.shows[0].motion === lamcView.shows[0].recorded")


@needs_wasm
def test_a_run_of_the_page_marks_the_events_of_python(tab: Page, tmp_path: Path) -> None:
    tab.open(page_of("limit_stop", 1.0, tmp_path), fragment="#t=0")
    name = next(each for each in simulator("limit_stop").parameters if each.endswith(".mass"))
    value = 1.3 * simulator("limit_stop").parameters[name]
    for _ in range(2):  # in a worker, and once it is known to be quick, at once
        turned(tab, name, value)
        found = tab.value("lamcView.shows[0].events")
        expected = simulator("limit_stop").run(1.0, parameters={name: value}).events
        assert len(expected) >= 4
        assert [each[1] for each in found] == [event.name for event in expected]
        np.testing.assert_allclose([each[0] for each in found], [event.t for event in expected], atol=1e-9)
    assert tab.value("document.querySelectorAll('.ticks i').length") >= 4


@needs_wasm
@pytest.mark.parametrize(("name", "joint"), [("pendulum", "h2"), ("four_bar", None)])
def test_a_start_angle_gives_the_run_of_python(
    name: str, joint: str | None, tab: Page, tmp_path: Path
) -> None:
    tab.open(page_of(name, 1.0, tmp_path), fragment="#t=0")
    sim = simulator(name)
    joint = joint if joint in sim.joints else next(iter(sim.scene.angles), sim.joints[0])
    value = float(sim.start[sim.joints.index(joint)]) + 0.1
    t, angles = turned(tab, joint, value)
    # The others are what the page's closing found, near the start as it was.
    start = {each: float(found[0]) for each, found in angles.items()}
    assert start[joint] == pytest.approx(value, abs=1e-9)
    given = start if name == "pendulum" else {joint: start[joint]}
    scene = replace(sim.scene, angles={**sim.scene.angles, **given})
    again = lamc.compile(sim.mechanism, scene)
    expected = again.run(1.0, t_eval=t)
    for each, found in angles.items():
        np.testing.assert_allclose(
            found, expected.angle(each), rtol=0.0, atol=1e-8
        )  # starts are closed to 1e-10


@needs_wasm
def test_an_input_of_a_run_with_other_parameters_gives_the_run_of_python(tab: Page, tmp_path: Path) -> None:
    inputs = {"load": lamc.Input(0.2, unit="N*m")}
    scene = lamc.Scene(added=(lamc.Torque({"h1": "load*sin(3*t)"}),), inputs=inputs, duration=1.0)
    sim = lamc.compile(mechanism_of("pendulum"), scene)
    given = {name: 1.2 * value for name, value in sim.parameters.items() if name.endswith("mass")}
    path = sim.run(1.0, parameters=given).view(tmp_path / "run.html")
    tab.open(path, fragment="#t=0")
    t, angles = turned(tab, "load", -0.5)
    expected = sim.run(1.0, t_eval=t, parameters={**given, "load": -0.5})
    for joint, found in angles.items():
        np.testing.assert_allclose(found, expected.angle(joint), rtol=0.0, atol=1e-9)  # lamc's own sine
    text = tab.value("lamcView.shows[0].copy()")
    (tmp_path / "scene.yaml").write_text(text, encoding="utf-8")
    assert lamc.load_scene(tmp_path / "scene.yaml").inputs["load"].default == -0.5


@needs_wasm
@pytest.mark.parametrize("name", ["crawler", "limit_stop"])
def test_bodies_stand_where_python_has_them(name: str, tab: Page, tmp_path: Path) -> None:
    """Played and computed anew, whatever the order of bodies in the file and in the model."""
    end = 0.05
    result = run(name, end)
    tab.open(page_of(name, end, tmp_path), fragment=f"#t={end}")
    mechanism = result.mechanism
    size = tab.value("lamcView.shows[0].data.size")
    joint = result.joints[0]
    for live in (False, True):
        if live:
            turned(tab, joint, float(result.angle(joint)[0]))
            assert tab.value("lamcView.shows[0].motion !== lamcView.shows[0].recorded")
        poses = np.array(tab.value("[...lamcView.shows[0].stage.poses]")).reshape(-1, 3, 4)
        for body, pose in zip(mechanism.bodies, poses, strict=True):
            centre, rotation = (each[-1] for each in result.pose(body.name))
            # Recorded to a thousandth; computed to the tolerances, from a start that is the scene's.
            near = 1e-6 if live else 2e-3
            np.testing.assert_allclose(pose @ [*body.com, 1.0], centre, rtol=0.0, atol=near * size)
            np.testing.assert_allclose(pose[:, :3], rotation, rtol=0.0, atol=5.0 * near)


@needs_wasm
def test_a_page_of_ten_seconds_is_small(tmp_path: Path) -> None:
    for name in ("pendulum", "four_bar"):
        assert page_of(name, 10.0, tmp_path).stat().st_size <= MOST_BYTES


def test_names_stay_text(tab: Page, tmp_path: Path) -> None:
    mechanism = mechanism_of("pendulum")
    names = {body.name: f"{body.name}{HOSTILE}" for body in mechanism.bodies}
    joints = tuple(
        replace(j, name=f"{j.name}{HOSTILE}", parent=names[j.parent], child=names[j.child])
        for j in mechanism.joints
    )
    bodies = tuple(replace(body, name=names[body.name]) for body in mechanism.bodies)
    hostile = lamc.Mechanism(bodies, joints, name=f"device{HOSTILE}")
    result = lamc.compile(hostile).run(0.2)
    path = tmp_path / "hostile.html"
    path.write_text(
        page([result_show(result, live=has_wasm_tools()), mechanism_show(hostile, f"label{HOSTILE}")])
    )
    tab.open(path, fragment="#t=0")
    tab.value("lamcView.shows.forEach((show) => show.stage.name(true))")
    assert tab.value("document.querySelectorAll('img').length") == 0
    assert HOSTILE in tab.value("document.title")
    assert tab.value(f"document.body.textContent.includes({json.dumps(joints[0].name[:19])})")


def test_a_folded_vertex_stays_closed(tab: Page, tmp_path: Path) -> None:
    path = tmp_path / "fold.html"
    path.write_text(page([mechanism_show(mechanism_of("vertex"))]))
    tab.open(path)
    tab.value("lamcView.shows[0].sliders.angles[0].take(-1.0, true)")
    angles = tab.value("lamcView.shows[0].angles")
    assert angles[0] == -1.0
    assert max(tab.value("lamcView.shows[0].kinematics.gaps(lamcView.shows[0].angles).map(Math.abs)")) < 1e-7
    assert min(abs(a) for a in angles) > 0.1  # all creases of a vertex of four fold together


def test_a_notebook_frame_shows_it(tab: Page, tmp_path: Path) -> None:
    """In a sandbox without the page's origin."""
    path = tmp_path / "notebook.html"
    html = run("four_bar", 1.0)._repr_html_()
    path.write_text(f'<!doctype html><meta charset="utf-8"><body data-ready="yes">{html}</body>')
    tab.open(path, height=800)
    for _ in range(100):
        pixels = np.asarray(Image.open(tab.picture(tmp_path / "frame.png")).convert("RGB")).astype(int)
        if ((pixels[..., 2] > pixels[..., 0] + 60) & (pixels[..., 2] > 90)).sum() > 300:
            return
        tab.value("new Promise((go) => setTimeout(go, 100))")
    pytest.fail("the frame stays empty")


def test_keys_turn_the_view_and_fingers_come_nearer(tab: Page, tmp_path: Path) -> None:
    tab.open(page_of("pendulum", 1.0, tmp_path, live=False), fragment="#t=0")
    before = tab.value("[lamcView.shows[0].stage.camera.azimuth, lamcView.shows[0].stage.camera.zoom]")
    tab.value("lamcView.shows[0].stage.canvas.focus()")
    for key in ("ArrowLeft", "+"):
        tab.send("Input.dispatchKeyEvent", type="keyDown", key=key, text=key if len(key) == 1 else "")
        tab.send("Input.dispatchKeyEvent", type="keyUp", key=key)
    after = tab.value("[lamcView.shows[0].stage.camera.azimuth, lamcView.shows[0].stage.camera.zoom]")
    assert after[0] == before[0] - 5
    assert after[1] > before[1]


def test_without_webgl_it_still_draws(tab: Page, tmp_path: Path) -> None:
    path = page_of("four_bar", 1.0, tmp_path, live=False)
    text = path.read_text(encoding="utf-8").replace('canvas.getContext("webgl2"', 'canvas.getContext("none"')
    path.write_text(text, encoding="utf-8")
    tab.open(path, fragment="#t=0.5")
    tab.wait("lamcView.shows[0].stage.frames.length > 0")
    assert tab.value("lamcView.shows[0].stage.painter.constructor.name") == "FlatPainter"
    assert tab.console == ["no WebGL 2"]
    tab.console.clear()


def test_a_plate_bends_by_the_factor_that_is_told(tab: Page, tmp_path: Path) -> None:
    mesh = plate.grid(1.0, 0.5, 8, 4)
    steel = plate.Laminate(
        [plate.Ply(plate.Material.isotropic(E=200e9, nu=0.3, density=7800.0), thickness=0.01)]
    )
    problem = plate.Problem(mesh, steel, supports=[plate.Clamped("boundary")], loads=[plate.Pressure(-1e4)])
    solution = plate.solve(problem)
    path = solution.view(tmp_path / "plate.html")
    tab.open(path, fragment="#t=1.5")  # all of the load
    tab.wait("lamcView.shows[0].stage.frames.length > 0")
    lowest, factor, told = tab.value(
        "(() => { const s = lamcView.shows[0]; let z = 0;"
        "for (let k = 2; k < s.places.length; k += 3) z = Math.min(z, s.places[k]);"
        "return [z, s.factor, s.field.least]; })()"
    )
    w = float(solution.at_nodes("w").min())
    assert lowest == pytest.approx(factor * w, rel=1e-4)  # 16 bits
    assert told == w
    assert tab.value("lamcView.player.told.textContent") == "load 100 %"
    tab.value("lamcView.shows[0].colour(1)")
    assert problem._repr_html_().startswith("<iframe")


@needs_wasm
def test_a_copied_scene_has_what_the_run_was_given(tab: Page, tmp_path: Path) -> None:
    name = next(each for each in simulator("pendulum").parameters if each.endswith(".stiffness"))
    path = tmp_path / "given.html"
    path.write_text(page([result_show(run("pendulum", 0.2, **{name: 33.5}), live=True)]), encoding="utf-8")
    tab.open(path)
    assert f"--set '{name}=33.5'" in tab.value("lamcView.shows[0].copy()")


@needs_wasm
@pytest.mark.parametrize(
    ("name", "changes", "joint"),
    [
        ("four_bar", {"angles": {"arm": 0.3}}, "link"),  # not the hinge whose angle the scene gives
        ("four_bar", {"angles": {"arm": 0.3}, "rates": {"arm": 8.0}}, "arm"),
        ("vertex", {"angles": {"c1": 0.0}, "branch": 2}, "c1"),  # out of the position where branches part
    ],
)
def test_a_copied_scene_is_the_run_of_the_page(
    name: str, changes: dict[str, object], joint: str, tab: Page, tmp_path: Path
) -> None:
    mechanism = mechanism_of(name)
    scene = replace(mechanism.scene or lamc.Scene(), **changes)  # type: ignore[arg-type]
    tab.open(lamc.compile(mechanism, scene).run(0.3).view(tmp_path / "run.html"), fragment="#t=0")
    t, angles = turned(tab, joint, 0.5)
    copied = tmp_path / "scene.yaml"
    copied.write_text(tab.value("lamcView.shows[0].copy()"), encoding="utf-8")
    expected = lamc.compile(mechanism, lamc.load_scene(copied)).run(0.3, t_eval=t)
    for each, found in angles.items():
        # starts are closed to 1e-10, which a spring near its rest multiplies
        np.testing.assert_allclose(found, expected.angle(each), rtol=0.0, atol=1e-7)

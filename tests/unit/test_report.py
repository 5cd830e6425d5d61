"""Pictures and texts of a run: they exist, show what they should, and never stumble over a name."""

import re
from functools import partial
from pathlib import Path

import matplotlib.mathtext
import numpy as np
import pytest
from PIL import Image
from shapely.geometry import Point, Polygon, box

import lamc
from lamc.basics.numbers import duration
from lamc.records.mechanism import Body, Joint, Mechanism, Slab
from lamc.report.animation import FRAMES_PER_SECOND, draw_animation, frame_times
from lamc.report.equations_text import equations_tex, equations_txt, escaped, listing, symbol_tex
from lamc.report.film import by_ffmpeg
from lamc.report.folded import draw_folded, instants, round_length
from lamc.report.plots import draw_angles_energy
from lamc.report.raster import Camera, Canvas
from lamc.report.solid import solid_of
from lamc.report.stage import poses_at, stage_of
from lamc.report.style import body_colours
from lamc.run.result import Result
from lamc.run.simulator import Simulator

NASTY = "_h$1^{\\x}%&"


def plate(x0: float, x1: float, thickness: float = 0.1) -> tuple[Slab, ...]:
    """Two sheets on one another, 1 m wide, around z = 0."""
    half = thickness / 2
    return (Slab(box(x0, 0, x1, 1), -half, 0.0), Slab(box(x0, 0, x1, 1), 0.0, half))


def strip(count: int, names: tuple[str, ...] = ()) -> Mechanism:
    """`count` plates of 1 m hinged in a row to a fixed one, along y."""
    bodies = [Body("base", fixed=True, outline=plate(-1, 0))]
    joints = []
    for k in range(count):
        inertia = np.diag([1.0, 1.0, 2.0]) / 12
        body = Body(f"link{k}", 1.0, np.array([k + 0.5, 0.5, 0.0]), inertia, outline=plate(k, k + 1))
        name = names[k] if k < len(names) else f"h{k}"
        joints.append(
            Joint(name, bodies[-1].name, body.name, np.array([k, 0.5, 0.0]), np.array([0.0, 1.0, 0.0]))
        )
        bodies.append(body)
    return Mechanism(tuple(bodies), tuple(joints), name="strip")


@pytest.fixture(scope="module")
def simulator() -> Simulator:
    return lamc.compile(strip(2, ("h1", NASTY)))


@pytest.fixture(scope="module")
def result(simulator: Simulator) -> Result:
    return simulator.run(1.0, t_eval=np.linspace(0.0, 1.0, 101))


def colours_of(path: Path) -> set[tuple[int, int, int]]:
    with Image.open(path) as image:
        return set(map(tuple, np.asarray(image.convert("RGB")).reshape(-1, 3)[::7].tolist()))


# --- plots --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_angles_and_energy_are_drawn_at_a_readable_size(result: Result, tmp_path: Path) -> None:
    path = draw_angles_energy(result, tmp_path / "a.png")
    with Image.open(path) as image:
        assert image.size == (1440, 1024)  # 9 x 6.4 inches at 160 dots per inch
    assert {(0x00, 0x72, 0xB2), (0xE6, 0x9F, 0x00)} <= colours_of(path)  # the first two curves
    assert list(tmp_path.iterdir()) == [path]


def test_many_joints_and_no_rows_are_drawn_too(simulator: Simulator, tmp_path: Path) -> None:
    single = simulator.run(0.0)
    assert draw_angles_energy(single, tmp_path / "one.png").stat().st_size > 5000
    assert draw_folded(single, tmp_path / "one_folded.png").stat().st_size > 5000


def test_instants_hold_start_and_end_and_what_differs_most(result: Result) -> None:
    rows = instants(result)
    assert rows[0] == 0
    assert rows[-1] == len(result.t) - 1
    assert rows == sorted(set(rows))
    assert len(rows) == 4


@pytest.mark.parametrize(("longest", "expected"), [(0.99, 0.5), (1.0, 1.0), (0.0021, 0.002), (73.0, 50.0)])
def test_scale_bars_have_round_lengths(longest: float, expected: float) -> None:
    assert round_length(longest) == pytest.approx(expected, rel=1e-12)  # powers of ten are not exact


# --- solids and their picture ------------------------------------------------------------------------------------


def test_sheets_of_one_outline_are_one_block() -> None:
    solid = solid_of(strip(1))
    for body in (0, 1):
        faces = [face for face in solid.faces if face.body == body]
        assert len(faces) == 6
        # 1 m x 1 m x 0.1 m: two lids of 1 m², four sides of 0.1 m²
        assert sorted(round(face.area, 9) for face in faces) == [0.1, 0.1, 0.1, 0.1, 1.0, 1.0]


def test_normals_point_outwards_also_in_a_hole() -> None:
    ring = Polygon(box(-1, -1, 1, 1).exterior, [Point(0, 0).buffer(0.3).exterior])
    body = Body("ring", fixed=True, outline=(Slab(ring, 0.0, 0.1),))
    for face in solid_of(Mechanism((body,), ())).faces:
        middle = face.rings[0].mean(axis=0)
        outside = middle + 1e-3 * face.normal
        if abs(face.normal[2]) < 0.5:
            assert not ring.contains(Point(outside[:2]))


def test_a_hinge_line_spans_what_the_two_bodies_share() -> None:
    (segment,) = solid_of(strip(1)).hinges.segments
    assert sorted(segment[:, 1].tolist()) == pytest.approx([0.0, 1.0], abs=1e-9)  # the full width, 1 m
    assert segment[:, 0].tolist() == pytest.approx([0.0, 0.0], abs=1e-12)  # on the drawn line


def test_neighbours_have_different_colours() -> None:
    mechanism = strip(20)
    colours = body_colours(mechanism)
    assert all(colours[j.parent] != colours[j.child] for j in mechanism.joints)


def test_poses_turn_bodies_about_their_hinges(result: Result) -> None:
    poses = poses_at(result, result.t[[0, 50]])
    drawn = np.array([b.com for b in result.mechanism.bodies])
    hinge = np.array([[0.0, 0.5, 0.0]])
    for instant in (0, 1):
        # The first hinge joins the world and link0: as a point of either it stays where it is.
        moved = poses.place(instant, hinge, np.array([1]), drawn)
        assert moved == pytest.approx(hinge, abs=1e-12)  # round-off of one rotation, in metres


def test_the_nearer_face_hides_the_farther_one_whatever_the_order() -> None:
    square = np.array([[-20.0, -20, 0], [20, -20, 0], [20, 20, 0], [-20, 20, 0]])
    towards = np.array([0.0, 0.0, 1.0])
    red, blue = (200, 0, 0), (0, 0, 200)
    for order in ((red, 5.0), (blue, -5.0)), ((blue, -5.0), (red, 5.0)):
        canvas = Canvas(60, 60)
        for colour, depth in order:
            canvas.face([square + np.array([0, 0, depth])], towards, colour)
        picture = canvas.finish()
        assert tuple(picture[30, 30]) == red
        assert tuple(picture[2, 2]) == (255, 255, 255)


def test_crossing_faces_hide_each_other_by_halves() -> None:
    canvas = Canvas(60, 60)
    tilted = np.array([[-20.0, -20, -10], [20, -20, 10], [20, 20, 10], [-20, 20, -10]])
    level = np.array([[-20.0, -20, 0], [20, -20, 0], [20, 20, 0], [-20, 20, 0]])
    normal = np.array([-20.0, 0.0, 40.0]) / np.hypot(20, 40)
    canvas.face([tilted], normal, (200, 0, 0))
    canvas.face([level], np.array([0.0, 0.0, 1.0]), (0, 0, 200))
    picture = canvas.finish()
    assert tuple(picture[30, 20]) == (0, 0, 200)  # to the left the level face is nearer
    assert tuple(picture[30, 40]) == (200, 0, 0)


def test_one_metre_is_as_long_across_as_it_is_up(result: Result) -> None:
    camera = stage_of(result, result.t[[0]], 300).camera
    axes = np.stack([camera.right, camera.up, camera.towards])
    assert axes @ axes.T == pytest.approx(
        np.eye(3), abs=1e-12
    )  # orthonormal to round-off: nothing is stretched
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.slow
def test_the_folded_device_shows_every_body(result: Result, tmp_path: Path) -> None:
    path = draw_folded(result, tmp_path / "f.png")
    with Image.open(path) as image:
        picture = np.asarray(image.convert("RGB")).reshape(-1, 3).astype(int)
        assert image.size[0] > 1000
    blue = (picture[:, 2] > picture[:, 0] + 80).mean()
    orange = (picture[:, 0] > picture[:, 2] + 100).mean()
    assert blue > 0.01
    assert orange > 0.01


def test_bodies_without_outline_are_drawn_as_sticks(tmp_path: Path) -> None:
    bare = Mechanism(
        tuple(Body(b.name, b.mass, b.com, b.inertia, b.fixed) for b in strip(3).bodies), strip(3).joints
    )
    solid = solid_of(bare)
    assert not solid.faces
    assert len(solid.sticks.segments) == 6  # a post at the base, two for each inner link, one for the last
    canvas = Canvas(40, 40)
    camera = Camera(*np.eye(3)[[0, 2]], -np.eye(3)[1], np.array([1.5, 0.5, 0.0]), 8.0)
    canvas.lines(camera.project(solid.sticks.segments), np.full((6, 3), 7, dtype=np.uint8), 3.0, solid=True)
    assert (canvas.finish() == 7).any()


# --- film ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_film_is_a_gif_where_nothing_writes_mp4(result: Result, tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    path = draw_animation(result, tmp_path, lambda k, n: seen.append((k, n)), encoders=())
    assert path.name == "animation.gif"
    with Image.open(path) as film:
        assert film.n_frames == len(frame_times(result)[0])
        assert film.info["duration"] == 1000 // FRAMES_PER_SECOND
        first = np.asarray(film.convert("RGB")).astype(int)
        film.seek(film.n_frames - 1)
        assert (np.abs(np.asarray(film.convert("RGB")).astype(int) - first) > 50).any()
    assert seen[-1][0] == seen[-1][1]
    foot = first[-60:]  # the axes at the left, a scale at the right, on white paper
    third = foot.shape[1] // 3
    assert (foot[:, :third] < 100).any()
    assert (foot[:, -third:] < 100).any()
    assert (foot[:, third:-third] == 255).all()


@pytest.mark.slow
def test_an_ffmpeg_that_fails_gives_a_gif(result: Result, tmp_path: Path) -> None:
    broken = partial(by_ffmpeg, program="/bin/false")
    assert draw_animation(result, tmp_path, encoders=[broken]).name == "animation.gif"
    assert [p.name for p in tmp_path.iterdir()] == ["animation.gif"]


@pytest.mark.parametrize(("t_end", "plays"), [(0.01, 4.0), (3.0, 3.0), (60.0, 10.0)])
def test_short_runs_are_slowed_and_long_ones_sped_up(
    simulator: Simulator, t_end: float, plays: float
) -> None:
    times, speed = frame_times(simulator.run(t_end, rtol=1e-3, atol=1e-3, t_eval=[0.0, t_end]))
    assert len(times) == round(plays * FRAMES_PER_SECOND)
    assert speed == pytest.approx(t_end / plays)


# --- equations ----------------------------------------------------------------------------------------------------


def test_every_symbol_of_the_text_is_defined_before_it_is_used(simulator: Simulator) -> None:
    text = equations_txt(listing(simulator.equations, "strip"))
    chapter = text.split("Accelerations\n====")[1].split("Mass matrix and")[0]
    defined: set[str] = set()
    for line in chapter.splitlines():
        match = re.match(r"(z\d+|udot_.*?) = (.*)", line)
        if match:
            assert set(re.findall(r"\bz\d+\b", match.group(2))) <= defined
            defined.add(match.group(1))
    assert {"udot_h1", f"udot_{NASTY}"} <= defined


def test_latex_is_balanced_and_its_formulas_parse(simulator: Simulator) -> None:
    text = equations_tex(listing(simulator.equations, NASTY))
    for environment in ("document", "flalign*"):
        assert text.count(rf"\begin{{{environment}}}") == text.count(rf"\end{{{environment}}}") > 0
    bare = text.replace(r"\{", "").replace(r"\}", "")
    assert bare.count("{") == bare.count("}")
    assert text.isascii()
    parser = matplotlib.mathtext.MathTextParser("path")  # another reader of LaTeX's mathematics
    formulas = re.findall(r"^& (z_.*|\\dot.*) &(?: \\\\)?$", text, flags=re.MULTILINE)
    assert len(formulas) > 10
    for formula in formulas:
        parser.parse(f"${formula.replace(escaped(NASTY), 'name')}$")  # \\text takes more in LaTeX than here


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("q_h1", r"q_{\text{h1}}"),
        ("udot_a_b", r"\dot{u}_{\text{a\_b}}"),
        ("z12", "z_{12}"),
        ("M_3_1", "M_{3,1}"),
        ("h1.stiffness", r"\text{stiffness}_{\text{h1}}"),
        ("t", "t"),
    ],
)
def test_symbols_become_readable_latex(name: str, expected: str) -> None:
    assert symbol_tex(name) == expected


def test_no_name_can_start_a_latex_command() -> None:
    text = escaped("\\input{/etc/passwd}$%\n🦋")
    assert "\\input" not in text
    assert re.fullmatch(r"[ -~]*", text)


@pytest.mark.parametrize(
    ("seconds", "expected"),
    [(2.5, "2.5 s"), (0.0123, "12.3 ms"), (4.5e-6, "4.5 µs"), (7.41e-8, "74.1 ns"), (7200.0, "2 h")],
)
def test_durations_are_reported_in_the_unit_that_suits_them(seconds: float, expected: str) -> None:
    assert duration(seconds) == expected

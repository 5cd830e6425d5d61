"""The gallery: every example runs from its drawing, with the loops and freedoms that theory gives."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import lamc
from lamc import examples
from lamc.basics.errors import DesignError, LamcError
from lamc.cli import main
from lamc.commands.examples import mechanism_of_example
from lamc.examples.miura import ACUTE
from lamc.loops.rank import count_loops
from lamc.mechanism.plan import plan
from lamc.run.result import Result
from lamc.run.simulator import Simulator

# Loops, rank and freedoms by hand, six equations for each loop. Loops: hinges less moving bodies. Rank: three for a
# plane loop and for one whose axes meet (spherical), five for Bricard's and Sarrus' (one freedom of six hinges).
THEORY = {
    "bricard": (1, 5, 1),
    "crawler": (0, 0, 2),  # and six more that float
    "five_bar": (1, 3, 2),
    "flaps": (0, 0, 2),
    "flapping_wing": (0, 0, 2),
    "folding_box": (4, 12, 4),  # four spherical loops of five creases; a freedom for each wall
    "four_bar": (1, 3, 1),
    # Triangles: freedoms are creases less three for each inner vertex, all of six creases.
    "kresling": (4, 12, 9),
    "limit_stop": (0, 0, 2),
    "miura": (4, 11, 1),  # 12 creases, one freedom
    "miura:2x2": (1, 3, 1),
    "miura:2x5": (4, 12, 1),
    "miura:4x3": (6, 16, 1),
    "miura:4x5": (12, 30, 1),
    "miura:1x4": (0, 0, 3),  # a strip: each crease by itself
    "n_four_bar": (2, 6, 1),
    "n_four_bar:1": (1, 3, 1),
    "n_four_bar:7": (7, 21, 1),
    "pendulum": (0, 0, 3),
    "pendulum.cad": (0, 0, 3),
    "resch": (9, 27, 11),
    "resch:2x1": (3, 9, 7),
    "sarrus": (1, 5, 1),
    "shutter": (0, 0, 2),
    "six_bar": (2, 6, 1),  # Watt's
    "stiff_triple": (0, 0, 3),
    "two_loops": (2, 6, 2),  # two four-bars in series
    "vertex": (1, 3, 1),
    "waterbomb": (1, 3, 3),  # six creases at a point
    "waterbomb_sheet": (6, 18, 11),
    "yoshimura": (4, 12, 9),
    "yoshimura:2x3": (2, 6, 7),
}
SIZED = tuple(name for name in THEORY if ":" in name and name != "miura:4x5")
LARGEST = pytest.param("miura:4x5", marks=pytest.mark.slow)


def simulator(name: str) -> Simulator:
    return lamc.compile(mechanism_of_example(examples.find(name)))


def folded(name: str, t_end: float, rtol: float) -> Result:
    result = simulator(name).run(t_end=t_end, rtol=rtol, atol=1e-2 * rtol)
    assert result.success, result.message
    return result


def test_every_example_has_its_theory() -> None:
    assert set(examples.names()) <= set(THEORY)


@pytest.mark.parametrize("name", [*examples.names(), *SIZED, LARGEST])
@pytest.mark.quick(
    "bricard",
    "five_bar",
    "flaps",
    "four_bar",
    "limit_stop",
    "pendulum",
    "pendulum.cad",
    "stiff_triple",
    "vertex",
    "miura:2x2",
    "miura:1x4",
    "n_four_bar:1",
)
def test_every_example_runs_as_it_is(name: str) -> None:
    sim = simulator(name)
    loops, rank, freedoms = THEORY[name]
    assert (sim.loops.loops, sim.loops.equations) == (loops, 6 * loops)
    assert (sim.loops.rank, sim.loops.freedoms) == (rank, freedoms)
    result = sim.run(t_end=1.0, rtol=1e-6, atol=1e-8)
    assert result.success, result.message
    assert np.abs(result.q - result.q[0]).max() > 0.01  # rad: it moves
    assert result.constraint_error.max() <= 1e-9 * sim.mechanism.size  # what lamc promises for any run
    assert result.stats.rejected is not None
    # Beyond a third, redundant equations lock it up. Touches and the turning of friction cost refused steps of their
    # own, some 13 for each event of the crawler, measured; it has no loops.
    assert result.stats.rejected < result.stats.accepted / 3 + 20 * len(result.events)


@pytest.mark.parametrize("name", examples.names())
def test_every_example_tells_what_is_hard_and_where_to_look(name: str) -> None:
    example = examples.find(name)
    story = mechanism_of_example(example).story or example.story
    assert 300 < len(story) < 1200  # characters: one paragraph
    assert "Look at" in story
    assert 20 < len(example.summary) <= 110  # one line
    assert example.path is None or example.path.is_file()
    if example.file_name.endswith(".yaml"):
        assert example.text.startswith("# ")


@pytest.mark.parametrize("name", ["miura:2x2", "miura:3x3", "miura:2x5", "miura:4x3", LARGEST])
@pytest.mark.quick("miura:2x2", "miura:3x3")
def test_miura_creases_keep_the_published_relation(name: str) -> None:
    """Tachi 2009: zigzag creases alike, straight ones alike, tan(s/2) = cos(acute angle) tan(z/2)."""
    result = folded(name, 1.0, 1e-9)
    joints = [joint.name for joint in result.mechanism.joints]
    zigzag = np.array([np.abs(result.angle(j)) for j in joints if j.startswith("z")])
    straight = np.array([np.abs(result.angle(j)) for j in joints if j.startswith("s")])
    assert np.ptp(zigzag[0]) > 0.5  # rad: it folds and unfolds
    # Closure of 1e-12 of the size at each vertex, over facets of a fifth of it, and some of them in a row.
    close = 1e-9
    assert np.ptp(zigzag, axis=0).max() < close
    assert np.ptp(straight, axis=0).max() < close
    assert np.abs(np.tan(straight / 2) - math.cos(ACUTE) * np.tan(zigzag[0] / 2)).max() < close


@pytest.mark.parametrize(
    ("columns", "rows"),
    [(4, 4), pytest.param(5, 5, marks=pytest.mark.campaign), pytest.param(8, 8, marks=pytest.mark.campaign)],
    # 8 x 8: half a minute
)
def test_a_large_miura_has_one_freedom(columns: int, rows: int) -> None:
    """Round-off near a singular position among the places that are looked at must not count for rank."""
    mechanism = mechanism_of_example(examples.find(f"miura:{columns}x{rows}"))
    count = count_loops(plan(mechanism))
    creases = (columns - 1) * rows + columns * (rows - 1)
    assert (count.loops, count.rank, count.freedoms) == ((columns - 1) * (rows - 1), creases - 1, 1)


@pytest.mark.parametrize("name", ["miura:3x3", "bricard"])
def test_redundant_equations_do_not_lock(name: str) -> None:
    """The lock-up of redundant equations shows in 20 to 250 times the steps, nearly all of them rejected."""
    stats = folded(name, 10.0, 1e-6).stats
    assert stats.rejected is not None
    assert stats.rejected < stats.accepted / 3


def test_bricards_hinges_turn_alike_in_turn() -> None:
    """Its posture has threefold symmetry, and the motion keeps it; so do the published angles."""
    result = folded("bricard", 5.0, 1e-9)
    for first in ("j0", "j1"):
        for other in (f"j{int(first[1]) + 2}", f"j{int(first[1]) + 4}"):
            off = np.remainder(result.angle(other) - result.angle(first) + np.pi, 2 * np.pi) - np.pi
            assert np.abs(off).max() < 1e-8  # closure of 1e-9 of the size, times the lever


def test_the_top_of_sarrus_rises_straight() -> None:
    result = folded("sarrus", 2.0, 1e-9)
    centre, rotation = result.pose("top")
    drawn = result.mechanism.body("top").com
    assert np.ptp(centre[:, 2]) > 0.005  # m
    # Closure of 1e-9 of a size of some 0.05 m, times levers of order one.
    assert np.abs(centre[:, :2] - drawn[:2]).max() < 1e-9
    assert np.abs(rotation - np.eye(3)).max() < 1e-8


def test_the_n_four_bar_is_iftomms(shared: Path) -> None:
    """Its joint B0, at the top of v0, where the reference has it: upright, at 1 m/s, through flat positions."""
    text = (shared / "reference" / "dynamics.json").read_text(encoding="utf-8")
    (case,) = (c for c in json.loads(text)["cases"] if c["id"] == "iftomm_A02_N2")
    rows = case["expected"]
    sim = simulator("n_four_bar:2")
    result = sim.run(t_end=rows[-1]["t"], rtol=1e-10, atol=1e-12, t_eval=[row["t"] for row in rows])
    assert result.success, result.message
    for k, row in enumerate(rows):
        angle = result.angle("g0")[k]
        # The file's rule for passing singular positions; rods of the benchmark have no inertia about themselves.
        assert -math.sin(angle) == pytest.approx(row["x"], abs=1e-3)
        assert math.cos(angle) == pytest.approx(row["y"], abs=1e-3)
    for k in (1, 2):
        assert np.abs(result.angle(f"g{k}") - result.angle("g0")).max() < 1e-3


@pytest.mark.slow
def test_the_box_folds_its_corners_alike() -> None:
    """Walls that start alike stay alike: the box and its springs have fourfold symmetry, and gravity too."""
    result = folded("folding_box", 1.0, 1e-9)
    walls = np.array([result.angle(f"wall_{side}") for side in ("east", "north", "west", "south")])
    corners = np.array([np.abs(result.angle(f"diagonal_{k}")) for k in range(1, 5)])
    # Rounding differs from corner to corner; the motion is damped and does not blow it up.
    assert np.ptp(walls, axis=0).max() < 1e-7
    assert np.ptp(corners, axis=0).max() < 1e-7
    # Each corner is a pyramid of three edges at right angles when the walls stand: its gusset is folded flat then.
    assert corners.max() > 1.5


@pytest.mark.slow
def test_radau_comes_to_rest_in_few_steps() -> None:
    """At rest round-off of the slopes, large as the loops are nearly singular, is what is left to solve for."""
    loose, tight = (
        simulator("folding_box").run(10.0, rtol, 1e-2 * rtol, integrator="radau5") for rtol in (1e-7, 1e-9)
    )
    assert loose.success
    assert tight.success
    # Steps by an estimate of order 3 grow by 100^(1/4) = 3.2. Noise refuses some and may take four times as many; where
    # the iteration takes noise for a failure, they are 59 times as many.
    assert tight.stats.accepted < 4.0 * 100.0**0.25 * loose.stats.accepted
    other = simulator("folding_box").run(10.0, 1e-9, 1e-11, integrator="dop853")
    # Both are at rest by then, where the errors of single steps have died away.
    assert np.abs(tight.q[-1] - other.q[-1]).max() < 1e-8


def test_stiff_hinges_hardly_bend() -> None:
    """Largest static moment of the weight of what hangs below, 2 m g L, over the stiffness of 10^4 m g L."""
    result = folded("stiff_triple", 2.0, 1e-8)
    # The springs may overshoot to twice the static bend of 2e-4 rad, and centrifugal forces pull straight.
    assert np.abs(result.angle("knee")).max() < 4e-4
    drift = np.abs(result.energy - result.energy[0]).max()
    assert drift < 1e-6 * abs(result.energy[0])  # 100 rtol over 10^5 steps


def test_the_stop_catches_the_flap_and_holds_its_weight() -> None:
    result = folded("limit_stop", 5.0, 1e-8)
    beyond = result.angle("flap") - math.radians(10.0)
    assert beyond[0] == pytest.approx(-math.radians(70.0), abs=1e-12)
    # The stop takes up no more than all the energy that the fall sets free: k d^2 / 2.
    stiffness = result.provenance.parameters["joint_limits.stiffness"]
    free = result.energy[0] - result.energies["gravity"].min()
    assert 0.0 < beyond.max() < math.sqrt(2.0 * free / stiffness)
    assert 0.0 < beyond[-1] < math.radians(0.6)  # what the story says of the weight at rest
    assert result.angle("tongue").max() > math.radians(30.0)  # it comes to its own stop
    # Nothing drives it: friction in hinges and stops only takes, but for a part in 10^6 of the fall at this tolerance.
    fall = result.energy[0] - result.energy[-1]
    assert np.diff(result.energy).max() < 1e-6 * fall


def test_the_same_size_gives_the_same_text() -> None:
    assert examples.find("miura:3x3").text == examples.find("miura").text == examples.find("miura:03x3").text
    assert examples.find("miura:3x4").text != examples.find("miura:4x3").text


@pytest.mark.parametrize(
    ("name", "reported"),
    [
        ("brikard", "did you mean 'bricard'"),
        ("../../x", "there is no example"),
        ("miura:", "no size of the example 'miura'; write miura:COLUMNSxROWS"),
        ("miura:3", "write miura:COLUMNSxROWS"),
        ("miura:-1x2", "write miura:COLUMNSxROWS"),
        ("miura:0x3", "has 0 facets; it must have 2 to"),
        ("miura:1x1", "has 1 facets; it must have 2 to"),
        ("miura:9999x9999", "facets; it must have 2 to"),
        ("n_four_bar:two", "write n_four_bar:N"),
        ("sarrus:2", "only these are made to a size: kresling, miura, n_four_bar, resch"),
    ],
)
def test_a_name_that_is_no_example_is_told_the_way_out(name: str, reported: str) -> None:
    with pytest.raises(DesignError, match=reported.replace("(", r"\(")):
        examples.find(name)


def test_an_example_made_to_a_size_has_no_path() -> None:
    with pytest.raises(LamcError, match="lamc examples miura --copy DIR"):
        examples.path("miura")


def run(*words: str) -> tuple[int, str, str]:
    done = CliRunner().invoke(main, list(words), standalone_mode=False)
    code = done.return_value if isinstance(done.return_value, int) else done.exit_code
    return code, done.stdout, done.stderr


@pytest.mark.slow
def test_the_list_names_every_example_with_its_loops_and_freedoms() -> None:
    code, out, _ = run("examples", "--quiet", "--json")
    assert code == 0
    rows = {row["name"]: row for row in json.loads(out)["examples"]}
    assert set(rows) == set(examples.names())
    for name, row in rows.items():
        assert (row["loops"], row["rank"], row["freedoms"]) == THEORY[name]
    code, out, _ = run("examples")
    assert code == 0
    assert all(any(line.startswith(f"{name} ") for line in out.splitlines()) for name in rows)


def test_a_story_is_reported_and_the_file_copied_once(tmp_path: Path) -> None:
    code, out, _ = run("examples", "sarrus")
    assert code == 0
    assert str(examples.path("sarrus")) in out
    assert "Look at the pose of the top" in " ".join(out.split())
    for _ in range(2):
        code, out, err = run("examples", "miura:2x3", "--copy", str(tmp_path / "mine"))
        copied = tmp_path / "mine" / "miura_2x3.yaml"
        assert copied.read_text(encoding="utf-8") == examples.find("miura:2x3").text
    assert code == 2
    assert "is there already and is not replaced" in err
    assert [p.name for p in tmp_path.rglob("*.yaml")] == ["miura_2x3.yaml"]


def test_copy_without_a_name_is_refused(tmp_path: Path) -> None:
    code, _, err = run("examples", "--copy", str(tmp_path))
    assert code == 2
    assert "--copy needs the name of an example" in err


@pytest.mark.slow
def test_an_example_of_a_size_runs_and_splits_like_a_file(tmp_path: Path) -> None:
    words = ("--example", "miura:2x3", "--out", str(tmp_path), "--quiet")
    assert run("run", *words, "--t-end", "0.1")[0] == 0
    assert json.loads((tmp_path / "manifest.json").read_text())["source"] == "miura:2x3"
    assert run("split", *words)[0] == 0
    assert run("split", "--example", "n_four_bar:3", "--out", str(tmp_path), "--quiet")[0] == 0


@pytest.mark.slow
def test_the_picture_shows_every_example(tmp_path: Path) -> None:
    code, out, _ = run("examples", "--picture", str(tmp_path / "all.png"), "--quiet", "--json")
    assert code == 0
    assert set(json.loads(out)["examples"]) == set(examples.names()) - {"pendulum.cad"}
    with Image.open(tmp_path / "all.png") as picture:
        shades = np.asarray(picture.convert("L"))
    # Four panels in a row: each of the first row holds ink below its title.
    for panel in np.array_split(shades[shades.shape[0] // 20 : shades.shape[0] // 4], 4, axis=1):
        assert (panel < 200).mean() > 0.002
    code, _, err = run("examples", "sarrus", "--picture", str(tmp_path / "one.png"))
    assert code == 2
    assert "--picture draws all examples" in err

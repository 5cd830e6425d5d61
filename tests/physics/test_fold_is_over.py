"""Runs of sheets that end where the fold is over: folded flat, or with facets gone through one another."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import lamc
from lamc import examples
from lamc.cli import main
from lamc.commands.examples import mechanism_of_example
from lamc.records.mechanism import Mechanism
from lamc.run.folded import NEAR, THROUGH, fold_over
from lamc.run.length import length_of
from lamc.run.request import Status
from tests.support.ctools import needs_cc
from tests.support.fold_corpus import Data, hypar, miura, write

pytestmark = [needs_cc, pytest.mark.filterwarnings("ignore::lamc.DesignWarning")]


def resting_flat(data: Data) -> Data:
    """Creases that rest at ±180 degrees, as drawings of full opacity do."""
    full = {"M": -180.0, "V": 180.0}
    return data | {"edges_foldAngle": [full.get(kind) for kind in data["edges_assignment"]]}


def load(folder: Path, data: Data) -> Mechanism:
    sheet = lamc.load(write(folder / "sheet.fold", data))
    assert isinstance(sheet, Mechanism)
    return sheet


@pytest.mark.quick("scipy:DOP853", "radau5")
@pytest.mark.parametrize("integrator", ["auto", "radau5", "scipy:DOP853"])
def test_a_miura_sheet_ends_folded_flat(integrator: str, tmp_path: Path) -> None:
    simulator = lamc.compile(load(tmp_path, resting_flat(miura(4, 3))))
    ended = simulator.run(t_end=10.0, until_folded=True, integrator=integrator)
    assert ended.status == Status.FOLDED
    assert ended.success
    assert "folded flat" in ended.message
    angles = np.array([ended.angle(name)[-1] for name in ended.hinges])
    assert np.abs(angles).min() >= math.pi - NEAR
    before = np.array([ended.angle(name)[-2] for name in ended.hinges])
    assert np.abs(before).min() < math.pi - NEAR
    again = simulator.run(t_end=10.0, until_folded=True, integrator=integrator)
    assert again.stats.evaluations == ended.stats.evaluations
    assert np.array_equal(again.y, ended.y)
    # It is the motion that it would be, up to there.
    rows = np.linspace(0.0, float(ended.t[-1]), 11)
    spread = simulator.run(t_end=10.0, until_folded=True, integrator=integrator, t_eval=rows)
    assert (spread.status, len(spread.t)) == (Status.FOLDED, 11)
    assert np.array_equal(spread.y[:, -1], ended.y[:, -1])
    as_far = simulator.run(t_end=10.0, integrator=integrator, max_steps=ended.stats.steps)
    assert as_far.status == Status.STEP_LIMIT
    assert np.array_equal(as_far.y, ended.y)


@pytest.mark.slow
def test_a_fold_that_goes_through_itself_ends(tmp_path: Path) -> None:
    """The inner rings of a pleated square, which nothing stops."""
    simulator = lamc.compile(load(tmp_path, resting_flat(hypar(7))))
    ended = simulator.run(t_end=10.0, until_folded=True)
    assert ended.status == Status.FOLDED
    assert "gone through one another" in ended.message
    farthest = max(abs(ended.angle(name)[-1]) for name in ended.hinges)
    assert farthest > math.pi + THROUGH
    assert any("went through ±180°" in note for note in ended.notes)


def test_what_is_no_sheet_is_never_asked() -> None:
    """A planar four-bar passes positions in one line in the middle of its motion; a pendulum has no plates there."""
    for name in ("four_bar", "pendulum"):
        mechanism = mechanism_of_example(examples.find(name))
        names = [joint.name for joint in mechanism.joints]
        assert fold_over(mechanism, [names], names) is None
        assert fold_over(mechanism, [], names) is None


def test_the_question_that_is_asked_of_states() -> None:
    """Of a vertex of four creases, and the state of a run that goes from one to the next."""
    sheet = mechanism_of_example(examples.find("miura:2x2"))
    names = [joint.name for joint in sheet.joints]
    count = len(names)

    def asked(*rows: list[float]) -> str:
        over = fold_over(sheet, [names], names)
        assert over is not None
        return [over(np.append(row, np.full(count, 50.0))) for row in rows][-1]

    flat, half, folded = [0.0] * count, [1.5] * count, [math.pi - 0.9 * NEAR, *[-math.pi] * (count - 1)]
    assert asked(flat) == ""
    assert asked(flat, half) == ""
    assert "folded flat" in asked(flat, half, folded)
    assert "folded flat" in asked(half, [math.pi + 20.0 * NEAR, *folded[1:]])  # passed within a step
    assert asked(half, [math.pi - 1.1 * NEAR, *folded[1:]]) == ""
    assert asked(half, flat) == ""  # where no hinge of a vertex has folded, none is folded flat
    assert asked(folded, folded) == ""  # and what begins so has yet to move
    assert "folded flat" in asked(folded, half, folded)
    through = [-math.pi - 1.01 * THROUGH, 1.0, *half[2:]]
    assert repr(names[0]) in asked(half, through)
    assert asked(through, through) == ""


def with_flap(data: Data) -> Data:
    """A triangle more, on the first edge of the rim, on a crease of its own that rests at 180 degrees."""
    first = data["edges_assignment"].index("B")
    a, b = data["edges_vertices"][first]
    (xa, ya), (xb, yb) = (data["vertices_coords"][k][:2] for k in (a, b))
    tips = [[(xa + xb) / 2 - s * (yb - ya) / 2, (ya + yb) / 2 + s * (xb - xa) / 2] for s in (1.0, -1.0)]
    inner = np.mean(np.array(data["vertices_coords"])[:, :2], axis=0)
    tip = max(tips, key=lambda t: float(np.hypot(*(np.array(t) - inner))))
    number, angles = len(data["vertices_coords"]), list(data["edges_foldAngle"])
    angles[first] = 180.0
    kinds = [*data["edges_assignment"], "B", "B"]
    kinds[first] = "V"
    return data | {
        "vertices_coords": [*data["vertices_coords"], tip],
        "edges_vertices": [*data["edges_vertices"], [a, number], [number, b]],
        "edges_assignment": kinds,
        "edges_foldAngle": [*angles, None, None],
    }


def test_a_flap_that_swings_through_ends_no_run(tmp_path: Path) -> None:
    """It is light, swings far beyond ±180° and comes back, while the vertices have hardly begun."""
    simulator = lamc.compile(load(tmp_path, with_flap(resting_flat(miura(3, 3)))))
    ended = simulator.run(t_end=10.0, until_folded=True)
    assert ended.success
    inner = {name for ring in simulator._rings for name in ring}
    # The ways out are those of the sheet without its flap, which no form holds and which is no way by itself.
    plain = lamc.compile(load(tmp_path, resting_flat(miura(3, 3))))
    # What loads ask for comes after them, and they ask for another one where the flap pulls.
    known = len(plain.branches)
    assert [b.freedoms for b in simulator.branches[:known]] == [b.freedoms + 1 for b in plain.branches]
    for one, other in zip(simulator.branches[:known], plain.branches, strict=True):
        assert [one.rates[name] for name in sorted(inner)] == pytest.approx(
            [other.rates[name] for name in sorted(inner)], abs=1e-6
        )
    assert max(max(abs(ended.angle(name))) for name in inner) > 1.0  # it went on to fold
    beyond = [name for name in ended.hinges if max(abs(ended.angle(name))) > math.pi + THROUGH]
    assert beyond
    assert not inner & set(beyond)


def test_what_drives_or_stops_a_sheet_runs_to_its_length(tmp_path: Path) -> None:
    """A servo may yet move it, and stops keep facets apart; nobody says that the fold is its end."""
    mechanism = load(tmp_path, resting_flat(miura(3, 3)))
    name = mechanism.joints[0].name
    plain = length_of(None, None, lamc.compile(mechanism))
    assert plain.until_folded
    for added in (lamc.Torque({name: "1e-6 * t"}), lamc.JointLimits(flat_fold=True)):
        simulator = lamc.compile(mechanism, lamc.Scene(added=(added,)))
        assert not length_of(None, None, simulator).until_folded


def test_a_flag_is_asked_for(tmp_path: Path) -> None:
    simulator = lamc.compile(load(tmp_path, resting_flat(miura(3, 3))))
    with pytest.raises(lamc.LamcError, match="until_folded"):
        simulator.run(until_folded="no")  # type: ignore[arg-type]


def test_a_command_that_nobody_gives_a_length_ends_there_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    write(Path("sheet.fold"), resting_flat(miura(3, 3)))

    def run(*words: str) -> tuple[int, dict[str, object]]:
        done = CliRunner().invoke(main, ["run", "sheet.fold", "--no-pictures", "--out", "o", *words])
        return done.exit_code, json.loads(Path("o/manifest.json").read_text(encoding="utf-8"))

    code, manifest = run()
    assert code == 0
    assert manifest["status"] == "folded"
    assert manifest["rows"] == 2001  # over what there is of it
    (note,) = [note for note in manifest["notes"] if "nobody says" in note]  # type: ignore[attr-defined]
    assert "--t-end 10" in note
    assert "flat_fold" in note
    code, manifest = run("--t-end", "0.05")
    assert (code, manifest["status"]) == (0, "reached_end")
    made = CliRunner().invoke(main, ["export", "sheet.fold", "--to", "fold", "--out", "f"])
    assert made.exit_code == 0, made.output
    (file,) = Path("f").glob("*.fold")
    frames = json.loads(file.read_text(encoding="utf-8"))["file_frames"]
    assert len(frames) == 61
    folds = [max(abs(a) for a in f["edges_foldAngle"] if a is not None) for f in frames]
    assert folds[0] < 1.0
    # The last step may go some degrees beyond a half turn, which FOLD counts back from there: as the run does, it ends.
    ended = lamc.compile(load(Path(), resting_flat(miura(3, 3)))).run(t_end=10.0, until_folded=True)
    last = np.abs(np.degrees([ended.angle(name)[-1] for name in ended.hinges]))
    assert 179.0 <= last.min() <= last.max() < 190.0
    assert folds[40] < 170.0
    assert folds[-1] == pytest.approx(
        np.minimum(last, 360.0 - last).max(), abs=1e-6
    )  # degrees, of the same steps

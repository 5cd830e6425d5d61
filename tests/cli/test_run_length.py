"""`lamc run` where nobody says how long: 10 s, as far as counted work allows; what it left out is told."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from lamc.cli import main
from lamc.run import defaults, length
from lamc.run.defaults import MAX_STEPS, default_steps
from tests.support.ctools import needs_cc
from tests.support.fold_corpus import miura, write

pytestmark = needs_cc


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words: str) -> tuple[Result, dict[str, object]]:
    done = CliRunner().invoke(main, ["run", "--example", "pendulum", "--no-pictures", "--out", "o", *words])
    return done, json.loads(Path("o/manifest.json").read_text(encoding="utf-8"))


@pytest.fixture
def little_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(defaults, "_MOST_WORK", 40 * 12 * 3 * 25)  # 25 steps of three hinges of a tree


@pytest.mark.usefixtures("little_work")
def test_a_run_without_a_length_ends_after_so_much_work_and_says_so() -> None:
    done, manifest = run()
    assert done.exit_code == 0, done.output
    assert manifest["ok"] is True
    assert manifest["complete"] is False
    assert manifest["status"] == "step_limit"
    assert manifest["rows"] == 1 + manifest["stats"]["accepted"]  # type: ignore[index]
    assert manifest["stats"]["steps"] == 25  # type: ignore[index]
    (note,) = [note for note in manifest["notes"] if "nobody says" in note]  # type: ignore[attr-defined]
    assert "25 steps of 3 hinges with 3 freedoms" in note
    assert "--t-end 10, or a duration in its scene, runs to there" in note


@pytest.mark.usefixtures("little_work")
@pytest.mark.parametrize("words", [["--t-end", "0.5"], ["--scene", "driven"], ["--accuracy", "1e-3"]])
def test_a_length_that_is_given_is_run_whatever_the_work(words: list[str]) -> None:
    done, manifest = run(*words)
    assert done.exit_code == 0, done.output
    assert manifest["status"] == "reached_end"
    assert manifest["stats"]["steps"] > 25  # type: ignore[index]


def test_steps_that_are_given_are_the_users_own_limit() -> None:
    done, manifest = run("--max-steps", "20")
    assert done.exit_code == 3
    assert manifest["ok"] is False
    assert run("--max-steps", "0")[0].exit_code == 2


def test_small_mechanisms_run_for_as_many_steps_as_ever() -> None:
    assert default_steps(3, 3, has_loops=False) == MAX_STEPS == 1_000_000
    assert default_steps(40, 40, has_loops=False) > 100_000
    assert default_steps(12, 1, has_loops=True) > 50_000  # of a millisecond or more
    assert default_steps(736, 61, has_loops=True) < 200


def test_loops_that_close_only_within_a_tolerance_count_as_more_work() -> None:
    """A crane of 113 hinges that is drawn with three digits took 80 s for 5565 steps."""
    exact = default_steps(113, 3, has_loops=True)
    assert default_steps(113, 3, has_loops=True, has_misfit=True) < exact / 40
    assert default_steps(40, 3, has_loops=True, has_misfit=True) == default_steps(40, 3, has_loops=True)


@pytest.mark.usefixtures("little_work")
def test_frames_of_a_motion_end_there_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of an export that nobody gives a length."""
    monkeypatch.setattr(defaults, "_MOST_WORK", 1)
    monkeypatch.setattr(length, "_ROWS", 1)
    write(Path("sheet.fold"), miura(2, 2))
    made = CliRunner().invoke(main, ["export", "sheet.fold", "--to", "fold", "--out", "f"])
    assert made.exit_code == 0, made.output
    assert "nobody says how long" in made.output
    (file,) = Path("f").glob("*.fold")
    assert len(json.loads(file.read_text(encoding="utf-8"))["file_frames"]) == 2


@pytest.mark.slow
def test_a_run_that_short_steps_end_names_what_loops_fit_by_and_the_way_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A Miura sheet whose corners are off by up to 1e-5 of its size: rigid facets, which are taken where nobody says,
    close nearly, bent ones exactly."""
    monkeypatch.setattr(defaults, "_MOST_WORK", 20 * 12 * 24 * 151)
    monkeypatch.setattr(length, "_MANY", 1_000_000)
    monkeypatch.setattr(length, "_ROWS", 1)
    data = miura(4, 4)
    random = np.random.default_rng(3)
    corners = np.array(data["vertices_coords"])
    data["vertices_coords"] = (
        corners + 2e-5 * np.ptp(corners) * (random.random(corners.shape) - 0.5)
    ).tolist()
    write(Path("m.fold"), data)

    def note(*words: str) -> object:
        done = CliRunner().invoke(main, ["run", "m.fold", "--no-pictures", "--out", "o", *words])
        assert done.exit_code == 0, done.output
        notes = json.loads(Path("o/manifest.json").read_text(encoding="utf-8"))["notes"]
        return next(note for note in notes if "nobody says" in note)

    for words in ([], ["--facets", "rigid"]):
        rigid = str(note(*words))
        assert "its loops close only within" in rigid
        assert "--facets bend" in rigid
    assert "close only" not in str(note("--facets", "bend"))


def test_a_small_device_that_is_stuck_gives_up_after_five_times_the_counted_work(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It has failed: nobody would take what there is for its motion."""
    monkeypatch.setattr(defaults, "_MOST_WORK", 40 * 12 * 3 * 25)
    monkeypatch.setattr(length, "_MANY", 20)
    done, manifest = run()
    assert done.exit_code == 3
    assert manifest["ok"] is False
    assert manifest["stats"]["steps"] == 5 * 25  # type: ignore[index]

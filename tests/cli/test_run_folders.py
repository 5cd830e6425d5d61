"""Where `lamc run` writes, and what it writes only when asked."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from lamc.cli import main


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words: str) -> Result:
    done = CliRunner().invoke(main, ["run", *words, "--t-end", "0.05", "--no-pictures"])
    assert done.exit_code == 0, done.output
    return done


def source(folder: str) -> tuple[str, str | None]:
    manifest = json.loads((Path(folder) / "manifest.json").read_text(encoding="utf-8"))
    return Path(manifest["source"]).name, manifest["scene"]


def test_two_scenes_and_two_designs_have_their_own_folders() -> None:
    run("--example", "pendulum")
    run("--example", "pendulum", "--scene", "swing")
    again = run("--example", "pendulum.cad")  # of the same name
    assert source("out/pendulum/scene") == ("pendulum.yaml", None)
    assert source("out/pendulum/swing") == ("pendulum.yaml", "swing")
    assert source("out/pendulum/scene_2") == ("pendulum.cad", None)
    assert "out/pendulum/scene holds a run of" in again.stdout
    run("--example", "pendulum.cad")  # once more in its own
    assert not Path("out/pendulum/scene_3").exists()


def test_a_folder_that_is_named_is_taken_and_what_was_there_is_told() -> None:
    run("--example", "pendulum", "--out", "o")
    assert "takes the place" not in run("--example", "pendulum", "--out", "o").stdout
    assert (
        "takes the place of the design's own scene in o"
        in run("--example", "pendulum", "--scene", "swing", "--out", "o").stdout
    )
    assert "takes the place of a run of" in run("--example", "flaps", "--out", "o").stdout


def test_absent_effects_fold_into_one_line_unless_they_are_asked_for() -> None:
    short = run("--example", "flaps", "--without", "gravity").stdout
    assert "blade_element_drag" not in short
    assert "gravity" in short  # somebody left it out
    assert "more, which nothing calls for (--verbose names them)" in short
    assert "blade_element_drag" in run("--example", "flaps", "--verbose").stdout


def test_pictures_have_the_format_that_is_asked_for_and_films_are_asked_for() -> None:
    words = ["run", "--example", "flaps", "--t-end", "0.05", "--out", "o", "--quiet"]
    assert (
        CliRunner().invoke(main, [*words, "--format", "svg", "--camera", "top", "--size", "200"]).exit_code
        == 0
    )
    names = {path.name for path in Path("o").iterdir()}
    assert names == {"results.npz", "results.csv", "manifest.json", "angles_energy.svg", "folded.svg"}
    refused = CliRunner().invoke(main, [*words, "--camera", "above"])
    assert refused.exit_code == 2
    assert "camera is 'above'" in refused.output


def test_the_old_word_for_no_film_warns_once() -> None:
    done = run("--example", "flaps", "--no-animation")
    assert done.stderr.count("--no-film") == 1


def test_a_run_that_failed_is_filmed_up_to_there() -> None:
    words = ["run", "--example", "pendulum", "--max-steps", "20", "--film", "--size", "96", "--out", "o"]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 3
    assert [path.name for path in Path("o").glob("animation.*")] != []

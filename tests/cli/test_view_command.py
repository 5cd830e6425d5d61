"""`lamc view`: one file of HTML for designs, runs and plates, and errors of one line."""

import json
import re
from importlib import import_module
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import lamc
from lamc.basics.times import Times
from lamc.cli import main
from lamc.commands.finished import finished_run
from lamc.commands.inputs import Source
from lamc.commands.terminal import Silent
from lamc.export.wasm_module import INSTALL_HINT
from tests.support.ctools import needs_cc

pytestmark = [needs_cc, pytest.mark.usefixtures("unpainted")]
NETWORK = re.compile(r"""(?:src|href)\s*=\s*["']?(?!data:)(?:https?:)?//|fetch\(|XMLHttpRequest|@import""")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def call(*words: str) -> Result:
    return CliRunner().invoke(main, ["view", *words], catch_exceptions=False)


def page(*words: str) -> tuple[str, dict[str, object]]:
    result = call(*words, "--json")
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    text = Path(data["page"]).read_text(encoding="utf-8")
    assert data["bytes"] == len(text.encode())
    assert not NETWORK.search(text)
    return text, data


def test_a_page_is_one_file_without_links() -> None:
    _, data = page("--example", "pendulum", "--t-end", "0.5", "--no-live")
    assert data["page"] == str(Path("out") / "pendulum.html")
    assert data["live"] == [False]
    assert [p.name for p in Path("out").iterdir()] == ["pendulum.html"]


def test_several_stand_side_by_side() -> None:
    text, data = page(
        "--example", "pendulum", "--example", "four_bar", "--t-end", "0.2", "--no-live", "--out", "two.html"
    )
    assert data["live"] == [False, False]
    assert "<h1>pendulum · four_bar</h1>" in text


def test_a_finished_run_is_shown_from_its_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    words = ["run", "--example", "four_bar", "--t-end", "0.3", "--no-pictures", "--out", "run"]
    assert CliRunner().invoke(main, words).exit_code == 0
    text, _ = page("run", "--no-live")
    assert "0.3 s by" in text
    manifest = json.loads(Path("run/manifest.json").read_text())
    manifest["program_digest"] = "0" * 64
    Path("run/manifest.json").write_text(json.dumps(manifest))
    refused = call("run", "--no-live")
    assert refused.exit_code == 2
    assert "another model" in refused.stderr
    assert "view the design itself" in refused.stderr


def test_a_plate_is_shown_with_all_that_was_found() -> None:
    _, data = page("--example", "modes")
    assert data["page"] == str(Path("out") / "modes.html")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "name a FILE"),
        (("nowhere.yaml",), "there is no such file"),
        (("--example", "pendulun"), "did you mean"),
        (("--example", "pendulum", "--out", "."), "is a folder"),
        ((".",), "no folder of a finished"),
        (("--example", "pendulum", "--set", "mass=1"), "no parameter is named"),
    ],
)
def test_errors_are_one_line(words: tuple[str, ...], told: str) -> None:
    result = call(*words)
    assert result.exit_code == 2
    assert told in result.stderr
    assert result.stderr.splitlines()[-1].startswith("error: ")


def test_records_write_their_pages(tmp_path: Path) -> None:
    mechanism = lamc.split(lamc.load(lamc.__path__[0] + "/examples/flaps.yaml"))  # type: ignore[arg-type]
    written = mechanism.view(tmp_path / "flaps.html")
    assert "<title>flaps</title>" in written.read_text(encoding="utf-8")
    assert mechanism._repr_html_().startswith('<iframe sandbox="allow-scripts"')


def test_without_a_compiler_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent() -> None:
        raise lamc.BuildError(f"clang is missing; {INSTALL_HINT}")

    monkeypatch.setattr(import_module("lamc.export.live"), "find_wasm_tools", absent)
    text, data = page("--example", "pendulum", "--t-end", "0.2")
    assert data["live"] == [False]
    assert text.count("pip install lamc[cc]") == 1


def test_a_run_that_ends_early_is_shown_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = lamc.Simulator.run

    def short(self: lamc.Simulator, *given: object, **named: object) -> lamc.Result:
        return whole(self, *given, **{**named, "max_steps": 20})  # type: ignore[arg-type]

    monkeypatch.setattr(lamc.Simulator, "run", short)
    result = call("--example", "pendulum", "--no-live", "--out", "early.html")
    assert result.exit_code == 3
    told = result.stderr.splitlines()[-1]
    assert told.startswith("error: pendulum: ")
    assert told.endswith("what was computed until then is in early.html")
    assert "20 steps" in Path("early.html").read_text(encoding="utf-8")


def finished(*words: str) -> None:
    assert CliRunner().invoke(main, ["run", *words, "--no-pictures", "--out", "run"]).exit_code == 0


def test_options_that_change_nothing_are_refused_or_told() -> None:
    finished("--example", "pendulum", "--t-end", "0.2")
    for words, told in (
        (("run", "--t-end", "1"), "--t-end: run is a finished run, which this does not change"),
        (("run", "--set", "gravity.z=0", "--fold"), "--set, --fold: run is a finished run"),
        (("--example", "pendulum", "--fold", "--set", "gravity.z=0"), "no parameter is named 'gravity.z'"),
        (("--example", "pendulum", "--fold", "--rate", "h1=1"), "--rate with --fold"),
        (("run", "--fold"), "--fold: run is a finished run"),
        (("--example", "strip", "--angle", "h1=1"), "--angle: strip is a plate"),
        (("--example", "pendulum", "--fold", "--angle", "h1=0.5"), "folding begins as drawn"),
        (("--example", "pendulum", "--t-end", "0"), "must be above zero"),
    ):
        refused = call(*words)
        assert refused.exit_code == 2, words
        assert told in refused.stderr
    _, data = page("run", "--example", "pendulum", "--t-end", "0.1", "--no-live")
    notes = data["notes"]
    assert isinstance(notes, list)
    assert notes[0] == "run is a finished run: --t-end changed nothing in it."
    assert notes[1].startswith("run: Recorded")
    assert notes[2].startswith("pendulum: Recorded")


def test_a_finished_run_has_its_events_and_says_what_changed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert CliRunner().invoke(main, ["examples", "limit_stop", "--copy", "designs"]).exit_code == 0
    finished("designs/limit_stop.yaml", "--t-end", "0.2")
    _, data = page("run", "--no-live")
    read, notes = finished_run(Path("run"), Source("run"), Times(), Silent())
    assert read.events == lamc.compile(lamc.load("designs/limit_stop.yaml")).run(0.2).events != ()
    assert notes == ()
    design = Path("designs/limit_stop.yaml")
    design.write_text(design.read_text() + "# another line\n")
    _, data = page("run", "--no-live")
    assert any("was changed after this run" in note for note in data["notes"])  # type: ignore[attr-defined]
    monkeypatch.chdir("designs")
    refused = call("../run", "--no-live")
    assert refused.exit_code == 2
    assert "go to the folder where it was run" in refused.stderr


def test_a_finished_run_goes_on_along_its_branch(monkeypatch: pytest.MonkeyPatch) -> None:
    finished("--example", "vertex", "--angle", "c1=0", "--branch", "-2", "--t-end", "0.1")
    scenes = []

    def seen(mechanism: lamc.Mechanism, scene: lamc.Scene, *rest: object) -> lamc.Simulator:
        scenes.append(scene)
        return lamc.compile(mechanism, scene)

    monkeypatch.setattr(import_module("lamc.commands.finished"), "compile_design", seen)
    page("run", "--no-live")
    assert [scene.branch for scene in scenes] == [-2]


def test_runs_whose_folders_have_one_name_are_told_apart() -> None:
    for name in ("pendulum", "four_bar"):
        words = ["run", "--example", name, "--t-end", "0.1", "--no-pictures"]
        assert CliRunner().invoke(main, words).exit_code == 0
    _, data = page("out/pendulum/scene", "out/four_bar/scene", "--no-live")
    heads = [note.partition(": Recorded")[0] for note in data["notes"]]  # type: ignore[attr-defined]
    assert heads == ["out/pendulum/scene", "out/four_bar/scene"]

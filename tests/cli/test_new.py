"""`lamc new`: projects run as they are made, and nothing that was there is touched."""

import json
import shlex
import warnings
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import lamc
from lamc.cli import main
from lamc.commands.new import NEXT, project
from lamc.readers.load import load_text
from tests.support.ctools import needs_cc

pytestmark = pytest.mark.usefixtures("unpainted")
FILES = ["README.md", "design.yaml", "scene.yaml"]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def call(*words: str) -> Result:
    return CliRunner().invoke(main, list(words), catch_exceptions=False)


@needs_cc
@pytest.mark.parametrize("kind", sorted(NEXT))
def test_it_runs_as_made(kind: str) -> None:
    assert call("new", "mine", "--kind", kind, "--quiet").exit_code == 0
    assert sorted(p.name for p in Path("mine").iterdir()) == FILES
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = lamc.load("mine/design.yaml")
        result = lamc.compile(made).run()
    assert made.name == "mine"
    assert result.success
    hinges = [joint.name for joint in result.mechanism.joints]
    assert max(abs(result.angle(name)).max() for name in hinges) > 0.1  # rad: something is to be seen
    done = call("run", "mine/design.yaml", "--t-end", "0.05", "--no-pictures", "--json")
    assert done.exit_code == 0, done.stderr


@needs_cc
@pytest.mark.parametrize("kind", sorted(NEXT))
def test_its_scenes_run(kind: str) -> None:
    call("new", "mine", "--kind", kind, "--quiet")
    made = lamc.load("mine/design.yaml")
    text = Path("mine/scene.yaml").read_text(encoding="utf-8")
    names = [
        line.strip().rstrip(":") for line in text.splitlines() if line.startswith("  ") and line[2] != " "
    ]
    assert len([name for name in names if "#" not in name]) >= 2
    for name in names:
        scene = lamc.load_scene("mine/scene.yaml", name.partition(":")[0])
        assert lamc.compile(made, scene).run(t_end=0.05).success


@pytest.mark.parametrize("kind", sorted(NEXT))
def test_the_readme_has_the_next_three_commands_and_they_parse(kind: str) -> None:
    result = call("new", "a b", "--kind", kind)
    readme = Path("a b/README.md").read_text(encoding="utf-8")
    commands = [line.partition("  #")[0] for line in readme.split("```")[1].splitlines()[1:]]
    assert len(commands) == 3
    assert result.stdout.splitlines()[2] == "next      cd 'a b'"
    for command in commands:
        assert f"          {command}" in result.stdout.splitlines()
        verb, *words = shlex.split(command)[1:]
        known = {word for parameter in main.commands[verb].params for word in parameter.opts}  # type: ignore[attr-defined]
        assert {word for word in words if word.startswith("--")} <= known


@pytest.mark.parametrize("kind", ["laminate", "sheet"])
def test_its_cut_files_are_made(kind: str) -> None:
    call("new", "mine", "--kind", kind, "--quiet")
    words = shlex.split(NEXT[kind][2].partition("  #")[0])[2:]
    result = call(
        "export", *[word.replace("design.yaml", "mine/design.yaml") for word in words], "--out", "cut"
    )
    assert result.exit_code == 0, result.stderr
    assert any(path.suffix == ".dxf" for path in Path("cut").iterdir())


def test_a_folder_that_holds_anything_is_refused() -> None:
    Path("full").mkdir()
    Path("full/.hidden").write_text("mine", encoding="utf-8")
    result = call("new", "full")
    assert result.exit_code == 2
    assert "'full' is not empty; name one that is not there yet" in result.stderr
    assert [p.name for p in Path("full").iterdir()] == [".hidden"]
    Path("file").write_text("mine", encoding="utf-8")
    assert "is a file; name a folder" in call("new", "file").stderr
    assert call("new", "file/below").exit_code == 2
    assert sorted(p.name for p in Path().iterdir()) == ["file", "full"]


def test_an_empty_folder_and_the_present_one_are_filled(monkeypatch: pytest.MonkeyPatch) -> None:
    Path("empty").mkdir()
    assert call("new", "empty", "--quiet").exit_code == 0
    Path("other").mkdir()
    monkeypatch.chdir("other")
    data = json.loads(call("new", ".", "--json").stdout)
    assert data["next"][0] == "lamc run design.yaml --film"
    assert sorted(p.name for p in Path().iterdir()) == FILES
    assert lamc.load("design.yaml").name == "other"
    assert call("new", "deep/er/still", "--quiet").exit_code == 0


@pytest.mark.parametrize("name", ["no", "it's: {a}", "#1", "<b>*x*</b>", "1e5", "ünï"])
def test_any_folder_name_is_a_name(name: str) -> None:
    made = project(name, "sheet")
    assert load_text(made["design.yaml"], "design.yaml").name == name
    assert "<b>" not in made["README.md"]

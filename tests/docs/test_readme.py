"""Every command and every program that the README and the guide show does what it says."""

import math
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

import lamc
from lamc import examples, plate
from lamc.cli import main
from lamc.examples import plates
from lamc.readers.plates.problem_file import plate_of_text
from lamc.readers.plates.problem_make import problem_of
from tests.support.paths import ROOT

pytestmark = pytest.mark.usefixtures("unpainted")  # tests/cli look at pictures

PAGES = {
    str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
    for path in (ROOT / "README.md", *sorted((ROOT / "docs" / "guide").glob("*.md")))
}
WHOLE = "\n".join(PAGES.values())  # copies of examples that one page makes serve the others
LONG = ("docs/guide/linear.md", "docs/guide/optima.md")  # whose programs take seconds
LANGUAGES = {"sh", "python", "yaml", "c", ""}  # "": what a command prints
TESTED_BELOW = ("name: flap", "kind: plate")  # how files begin that have tests of their own, and no name


def blocks(language: str, text: str = WHOLE) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def commands() -> list[str]:
    """Shell lines of all blocks, once each, and the commands of the first table on a design of the reader's own."""
    lines = [line.split(" #")[0].strip() for block in blocks("sh") for line in block.splitlines()]
    return list(dict.fromkeys([line for line in lines if line] + re.findall(r"\| `(lamc [^`]*)` \|", WHOLE)))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the design and the files of the reader's own that the pages speak of."""
    shutil.copy(ROOT / "lamc" / "examples" / "pendulum.cad", tmp_path / "design.cad")
    for text in blocks("yaml"):
        named = re.match(r"# (\S+\.yaml)\n", text)
        if named:
            (tmp_path / named[1]).write_text(text, encoding="utf-8")
    drawn = re.findall(r"`(\w+\.(?:fold|svg|yaml))`:\n\n```\n(.*?)^```$", WHOLE, re.DOTALL | re.MULTILINE)
    for name, text in drawn:
        (tmp_path / name).write_text(text, encoding="utf-8")
    for linked in re.findall(r"\]\(\.\./(\w+\.(?:dxf|csv))\)", WHOLE):
        shutil.copy(ROOT / "docs" / linked, tmp_path)
    for name, copies in re.findall(r"lamc plate --example (\S+) --copy ([^\s`]+)", WHOLE):
        (tmp_path / copies).mkdir(exist_ok=True)
        for design in plates.designs(plates.find(name)):
            (tmp_path / copies / design.file_name).write_text(design.text, encoding="utf-8")
    return tmp_path


@pytest.fixture
def folder_with_copies(folder: Path) -> Path:
    """The folder after the commands that copy examples; NAME stands for any."""
    for name, copies in re.findall(r"lamc examples (\S+) --copy ([^\s`]+)", WHOLE):
        if name != "NAME":
            example = examples.find(name)
            (folder / copies).mkdir(exist_ok=True)
            (folder / copies / example.file_name).write_text(example.text, encoding="utf-8")
    return folder


def test_no_block_of_the_pages_is_passed_over() -> None:
    """Tests below find blocks by language and commands by first word: others would be shown and never run."""
    for page, text in PAGES.items():
        fences = re.findall(r"^```(.*)$", text, re.MULTILINE)
        assert len(fences) % 2 == 0, page
        assert set(fences[::2]) <= LANGUAGES, page
        assert set(fences[1::2]) <= {""}, page
        assert page == "docs/guide/export.md" or not blocks("c", text), (
            page
        )  # that one: test_embedding_docs.py
        for block in blocks("yaml", text):
            assert re.match(r"# \S+\.yaml\n", block) or block.startswith(TESTED_BELOW), f"{page}: {block}"
    assert {command.split()[0] for command in commands()} <= {"lamc", "make", "cc"}


@pytest.mark.parametrize("command", [c for c in commands() if c.startswith("lamc")])
@pytest.mark.quick(
    "lamc run --example pendulum*",
    "lamc export --*",
    "lamc export pair*",
    "lamc convert*",
    "lamc new*",
    "lamc examples ??*it_stop*",
    "lamc examples vertex*",
    "lamc plate --element*",
    "lamc plate --example?",
    "lamc plate --example folded*",
    "lamc split*",
    "lamc run design.cad",
    "lamc run design.cad --energy*",
    "lamc build*",
    "lamc run --example limit*",
    "lamc run --example bricard*",
    "lamc run --example flaps --scene commanded*",
    "lamc schema*",
    "lamc materials*",
    "lamc effects*",
    "lamc functions*",
    "lamc run --example flaps --angle*",
    "lamc run --example flaps --hinge-stiffness*",
)
@pytest.mark.ci(
    "lamc [!clv]*",
    "lamc check d*",
    "lamc ledger d*",
    "lamc view [!-]*",
    "lamc view --example pendulum*",
    "command*",
)
def test_each_lamc_command_of_the_pages_succeeds(
    command: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments = shlex.split(command)[1:]
    if "--copy" in arguments:
        shutil.rmtree(folder / arguments[-1], ignore_errors=True)  # what the command is to make
    if "--film" in arguments:
        arguments.append("--no-film")  # it has its own tests, and takes most of the time
    if arguments[0] == "ledger":
        arguments += ["--budget", "1s"]  # what it may spend, it does
    monkeypatch.chdir(folder)
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output


@pytest.mark.slow
def test_the_command_is_a_process_too(folder: Path) -> None:
    """The tests above call what this one starts, once: lamc and its libraries load for a second."""
    command = [sys.executable, "-m", "lamc", "split", "design.cad"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("command", [c for c in commands() if c.startswith("make")])
def test_each_make_target_of_the_pages_exists(command: str) -> None:
    done = subprocess.run([*command.split(), "-n"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_the_pages_have_commands_of_both_kinds() -> None:
    kinds = {command.split()[0] for command in commands()}
    assert {"lamc", "make"} <= kinds


@pytest.mark.parametrize(
    "program",
    [
        pytest.param(block, id=f"{page}-{k}", marks=[pytest.mark.slow] if page in LONG else [])
        for page in PAGES
        for k, block in enumerate(blocks("python", PAGES[page]))
    ],
)
def test_each_program_of_the_pages_runs(
    program: str, folder_with_copies: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder_with_copies)
    exec(compile(program, "program", "exec"), {"__name__": "__main__"})
    for written in re.findall(r'to_csv\("([^"]+)"\)', program):
        assert (folder_with_copies / written).is_file()


def test_the_design_of_the_guide_is_one_hinge_that_starts_open(tmp_path: Path) -> None:
    (text,) = [text for text in blocks("yaml") if text.startswith("name: flap")]
    file = tmp_path / "flap.yaml"
    file.write_text(text, encoding="utf-8")
    sim = lamc.compile(lamc.load(file))
    assert sim.joints == ("fold",)
    result = sim.run(t_end=0.1)
    assert result.success
    assert result.angle("fold")[0] == pytest.approx(0.5235987755982988, abs=1e-15)  # 30°, one rounding


def test_the_scenes_of_the_guide_are_what_it_says(folder: Path) -> None:
    design = lamc.load(folder / "design.cad")
    swing, driven, moon = (
        lamc.load_scene(folder / "swings.yaml", name) for name in ("swing", "driven", "moon")
    )
    acting = [
        {effect.name for effect in lamc.compile(design, scene).effects} for scene in (swing, driven, moon)
    ]
    assert acting == [
        {"gravity", "hinge_stiffness"},
        {"gravity", "hinge_stiffness", "hinge_damping", "torque"},
        {"gravity", "joint_limits"},
    ]
    assert (driven.angles, moon.duration) == ({"h1": -math.pi / 3}, 5.0)


def test_the_plate_of_the_guide_is_a_lid_with_a_hole(tmp_path: Path) -> None:
    (text,) = [text for text in blocks("yaml") if text.startswith("kind: plate")]
    lid = plate_of_text(text, "lid.yaml")
    assert lid.geometry.outline.area == pytest.approx(0.12 * 0.08 - math.pi * 0.015**2, rel=1e-12)
    assert list(lid.cases) == ["wind", "push"]
    solved = plate.solve(problem_of(lid, size=8e-3))
    (beside,) = lid.outputs
    assert solved["wind"].deflection(*beside.at) > 0.0 > solved["push"].deflection(*beside.at)


def test_pictures_of_the_pages_are_there() -> None:
    shown = [(page, name) for page, text in PAGES.items() for name in re.findall(r'<img src="([^"]*)"', text)]
    assert {page for page, _ in shown} >= {"README.md", "docs/guide/plates.md", "docs/guide/gallery.md"}
    for page, name in shown:
        assert ((ROOT / page).parent / name).stat().st_size > 10_000


def test_examples_that_the_pages_name_exist() -> None:
    for verb, name in re.findall(r"lamc (\w+) --example (\S+?)[\s`]", WHOLE):
        assert (plates if verb == "plate" else examples).find(name).text

"""`lamc export`: the same folder as from Python, errors of one line, and nothing of the user's touched."""

import json
import re
import subprocess
from dataclasses import fields
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import lamc
from lamc.cli import main
from lamc.commands.export_options import export
from lamc.export import PLATE_USES, TARGETS
from lamc.export.markdown import markdown
from lamc.export.options import FLAGS
from tests.support.ctools import needs_cc
from tests.support.exported_folders import mechanism_of

pytestmark = [needs_cc, pytest.mark.usefixtures("unpainted")]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def call(*words: str) -> Result:
    return CliRunner().invoke(main, ["export", *words], catch_exceptions=False)


def content(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir()}


def test_it_writes_the_folder_that_python_writes_and_tells_what_is_in_it(tmp_path: Path) -> None:
    result = call("--example", "flaps", "--json")
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    assert data["folder"] == str(Path("out") / "flaps_c")
    written = content(tmp_path / "out" / "flaps_c")
    assert set(data["files"]) == set(written)
    assert {name: len(written[name]) for name in data["bytes"]} == data["bytes"]
    assert content(lamc.export(mechanism_of("flaps"), out=tmp_path / "python")) == written


def test_options_reach_the_export(tmp_path: Path) -> None:
    words = (
        "--inputs",
        "right",
        "--real-time",
        "--single-header",
        "--prefix",
        "wings",
        "--without",
        "gravity",
        "--angle",
        "left=20 deg",
    )
    result = call("--example", "flaps", "--out", "here", *words)
    assert result.exit_code == 0, result.stderr
    assert {p.name for p in (tmp_path / "here").iterdir()} == {
        *("wings.h", "wings.pc.in", "CMakeLists.txt", "example_main.c", "README.md", "mechanism.png"),
        "lamc-export.json",
        "wings_params.h",
    }
    header = (tmp_path / "here" / "wings.h").read_text(encoding="utf-8")
    assert "wings_step_fixed(" in header
    assert "wings_step(" not in header
    assert "gravity" not in header
    assert "double right_torque;" in header
    assert "left_torque" not in header
    assert "0.349066" in (tmp_path / "here" / "README.md").read_text(encoding="utf-8")  # 20 degrees


@pytest.mark.slow
def test_it_replaces_its_own_files_only(tmp_path: Path) -> None:
    out = tmp_path / "c"
    assert call("--example", "flaps", "--out", "c").exit_code == 0
    (out / "notes.txt").write_text("mine")
    assert call("--example", "flaps", "--out", "c", "--integrator", "rk45").exit_code == 0
    assert (out / "notes.txt").read_text() == "mine"
    (out / "flaps.c").write_text("mine")
    refused = call("--example", "flaps", "--out", "c")
    assert refused.exit_code == 2
    assert "was edited since lamc wrote it" in refused.stderr
    assert (out / "flaps.c").read_text() == "mine"
    assert "holds c of 'flaps'" in call("--example", "shutter", "--out", "c").stderr
    assert call("--example", "flaps", "--out", "c", "--force").exit_code == 0
    assert (out / "flaps.c").read_text() != "mine"


@pytest.mark.parametrize(
    ("words", "reported"),
    [
        (("--example", "flaps", "--to", "nix"), "no target is named 'nix'"),
        (("--example", "flaps", "--prefix", "3d"), "--prefix (prefix) is '3d'"),
        (("--example", "flaps", "--integrator", "euler"), "--integrator (integrator) is 'euler'"),
        (("--example", "flaps", "--integrator", "scipy:LSODA"), "--integrator (integrator) is 'scipy:LSODA'"),
        (("--example", "flaps", "--out", "file"), "is a file"),
        (("--example", "flaps", "--inputs", "left,nix"), "--inputs (inputs) names the hinge 'nix'"),
        (("--example", "flaps", "--to", "mjcf", "--step", "-1"), "--step (step) is -1.0"),
        ((), "name a FILE"),
        (("none.yaml",), "there is no such file"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2_and_leaves_nothing(
    tmp_path: Path, words: tuple[str, ...], reported: str
) -> None:
    (tmp_path / "file").write_text("mine")
    result = call(*words, "--quiet")
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert line.startswith("error: ")
    assert reported in line
    assert content(tmp_path) == {"file": b"mine"}


# By target, options that mean nothing to its format: a model in XML has no C, and an FMU's master chooses the steps.
IDLE = {
    "c": ["--fmi", "--lossy", "--step", "--size"],
    "mjcf": [
        "--real-time",
        "--single-header",
        "--float",
        "--integrator",
        "--no-libm",
        "--inputs",
        "--fmi",
        "--size",
    ],
    "urdf": [
        "--real-time",
        "--single-header",
        "--float",
        "--integrator",
        "--no-libm",
        "--inputs",
        "--fmi",
        "--step",
        "--size",
    ],
    "fmu": ["--real-time", "--single-header", "--float", "--lossy", "--step", "--size"],
    "wasm": [
        "--real-time",
        "--single-header",
        "--float",
        "--no-libm",
        "--lossy",
        "--step",
        "--fmi",
        "--size",
    ],
    "wheel": ["--single-header", "--float", "--lossy", "--step", "--fmi", "--size"],
    "cut": ["--real-time", "--prefix", "--integrator", "--inputs", "--fmi", "--step", "--lossy"],
    "fold": ["--hinge-style", "--hinge-width", "--kerf", "--pins", "--sheet"],
    "a plate": ["--real-time", "--float", "--integrator", "--inputs", "--fmi", "--step", "--kerf"],
}
VALUES = {
    "--fmi": "2",
    "--step": "1e-3",
    "--size": "2 mm",
    "--integrator": "rk45",
    "--inputs": "none",
    "--prefix": "other",
    "--hinge-style": "perforated",
    "--hinge-width": "gap",
    "--kerf": "0.1 mm",
    "--pins": "3 mm",
    "--sheet": "300 mm x 200 mm",
}


@pytest.mark.parametrize(("target", "option"), [(t, o) for t, options in IDLE.items() for o in options])
def test_an_option_that_the_target_has_no_use_for_is_refused(
    tmp_path: Path, target: str, option: str
) -> None:
    """Also where its value is what a target that has it would take by default, as with `--fmi 2`."""
    what = ("strip", "c") if target == "a plate" else ("pendulum", target)
    value = [VALUES[option]] if option in VALUES else []
    result = call("--example", what[0], "--to", what[1], option, *value, "--quiet")
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert re.search(rf"{option} \(\w+\).*: {target} has no use for (it|them); leave", line)
    assert content(tmp_path) == {}


def test_every_option_has_somebody_who_reads_it_and_the_name_that_the_command_knows() -> None:
    read = {name for target in TARGETS.values() for name in target.uses} | set(PLATE_USES)
    assert read == {field.name for field in fields(lamc.ExportOptions)}
    known = {word for parameter in export.params for word in parameter.opts}
    assert set(FLAGS.values()) <= known
    assert set(FLAGS) == read - {"jacobian"}  # of Python alone


@pytest.mark.slow
def test_it_ends_with_what_acts_and_what_comes_next(tmp_path: Path) -> None:
    """The effects are those of the README, torques from outside among them; the line compiles and runs as it is."""
    result = call("--example", "pendulum", "--out", "my pendulum")
    *_, effects, step = result.stdout.splitlines()
    assert effects == "effects   external_torque, gravity, hinge_damping, hinge_stiffness"
    readme = (tmp_path / "my pendulum" / "README.md").read_text(encoding="utf-8")
    assert markdown(effects.removeprefix("effects   ")) in readme
    assert step.startswith("next      cd 'my pendulum' && cc ")
    line = step.removeprefix("next      ")
    done = subprocess.run(line, shell=True, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("t (s),")
    alone = call("--example", "pendulum", "--inputs", "none", "--out", "alone", "--json")
    assert json.loads(alone.stdout)["effects"] == ["gravity", "hinge_damping", "hinge_stiffness"]


@pytest.mark.parametrize(
    ("words", "reported"),
    [
        (("pendulum", "--to", "mjcf"), "python -m mujoco.viewer --mjcf=here/pendulum.xml"),
        (("pendulum", "--to", "urdf", "--lossy"), "colcon build --paths here"),
        (("pendulum", "--to", "fmu"), "fmpy simulate here/pendulum.fmu --show-plot"),
        (("pendulum", "--to", "wheel"), "pip install here/pendulum-"),
        (("flaps", "--to", "cut"), "open here/README.md"),
        (("strip", "--size", "5 mm"), "cd here && cc -O2 -std=c99 example_main.c strip.c -lm"),
    ],
)
@pytest.mark.quick("words0*", "words1*", "words3*", "words4*", others="campaign")
def test_each_target_tells_its_next_step(words: tuple[str, ...], reported: str) -> None:
    result = call("--example", *words, "--out", "here")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.splitlines()[-1].startswith(f"next      {reported}")


def test_help_begins_with_every_target() -> None:
    first = call("--help").stdout.split("\n\n")[1]
    for name in (*TARGETS, "plate"):
        assert re.search(rf"\b{name}\b", first), name


def test_targets_are_listed() -> None:
    result = call("--to", "list")
    assert result.exit_code == 0
    assert [line.split()[0] for line in result.stdout.splitlines()] == list(TARGETS)


def test_cut_files_are_told_with_their_areas_masses_and_notes(tmp_path: Path) -> None:
    result = call(
        *("--example", "flaps", "--to", "cut", "--out", "here", "--kerf", "0.1 mm"),
        *("--sheet", "300mm x 200mm", "--pins", "3 mm"),
    )
    assert result.exit_code == 0, result.stderr
    lines = result.stdout.splitlines()
    assert "layers    lower: 3 parts, 1310.4 mm2, 1.17936 g of plate" in lines
    assert any(line.startswith("bodies    3 bodies that the cuts leave are those") for line in lines)
    assert (
        "note      no supports are drawn: bridges that hold parts in their sheets are added in CAD" in lines
    )
    options = {"kerf": 1e-4, "stock": (0.3, 0.2), "pins": 3e-3}
    made = lamc.export(mechanism_of("flaps"), "cut", out=tmp_path / "python", **options)
    as_json = call("--example", "flaps", "--to", "cut", "--out", "there", "--json")
    (note,) = [line for line in json.loads(as_json.stdout)["told"] if line.startswith("note")]
    assert note == "note no supports are drawn: bridges that hold parts in their sheets are added in CAD"
    assert content(made) == content(tmp_path / "here")


def test_a_scene_has_no_part_in_cut_files() -> None:
    result = call("--example", "flaps", "--to", "cut", "--scene", "flexible")
    assert result.exit_code == 2
    assert "nothing moves in an export to 'cut'" in result.stderr

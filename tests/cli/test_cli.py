"""The command line as a user meets it: files, exit codes, one-line errors, JSON, Ctrl-C."""

import csv
import importlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import lamc
from lamc.cli import main
from lamc.commands import terminal
from lamc.commands.inputs import folder_name
from lamc.run.defaults import default_rows
from tests.support.ctools import needs_cc
from tests.support.paths import ROOT

VERBS = ("run", "build", "check", "split", "bench", "ledger", "plate", "schema", "doctor")
HOSTILE = '"; int main'

# One link of 1 m and 1 kg on a hinge along y: a pendulum whose small parts compile in a third of a second.
PENDULUM = """\
kind: mechanism
name: {name}
bodies:
  - {{name: ground, fixed: true}}
  - {{name: link, mass: 1, com: [0.5, 0, 0], inertia: [[0.01, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]}}
joints:
  - {{name: {joint}, parent: ground, child: link, point: [0, 0, 0], axis: [0, 1, 0]{extra}}}
"""


@pytest.fixture(autouse=True)
def _own_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    """Every test works in a folder of its own, and paints no pictures but where it asks for them."""
    monkeypatch.chdir(tmp_path)
    if "painted" not in request.fixturenames:
        request.getfixturevalue("unpainted")


def call(*words: str) -> Result:
    return CliRunner().invoke(main, [*words])


def pendulum(
    path: Path, *, name: str = "pendulum", joint: str = "h1", extra: str = ", stiffness: 0.1, damping: 0.01"
) -> Path:
    text = PENDULUM.format(name=quoted(name), joint=quoted(joint), extra=extra)
    path.write_text(text, encoding="utf-8")
    return path


def quoted(name: str) -> str:
    """A double-quoted scalar of YAML."""
    return json.dumps(name, ensure_ascii=False)


def run(*words: str) -> Result:
    return call("run", *words)


# --- help ---------------------------------------------------------------------------------------------------------


def test_help_names_every_verb_and_the_exit_codes() -> None:
    result = call("--help")
    assert result.exit_code == 0
    assert all(f"  {verb} " in result.stdout for verb in VERBS)
    assert "130 after" in result.stdout
    assert call().stdout == result.stdout


@pytest.mark.parametrize("verb", VERBS)
def test_help_of_each_verb_has_a_summary_of_one_line(verb: str) -> None:
    result = call(verb, "--help")
    assert result.exit_code == 0
    summary = result.stdout.splitlines()[2].strip()
    assert summary.endswith(".")


def test_help_does_not_load_sympy_or_matplotlib() -> None:
    code = "import sys; from lamc.cli import main; print(sorted({'sympy', 'matplotlib', 'scipy'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_version_is_reported() -> None:
    assert lamc.__version__ in call("--version").stdout


# --- run ----------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("painted")
def test_run_writes_results_pictures_and_manifest_and_ends_with_a_summary(tmp_path: Path) -> None:
    file = pendulum(tmp_path / "p.yaml")
    result = run(str(file), "--t-end", "0.5", "--points", "51")
    assert result.exit_code == 0, result.output
    out = tmp_path / "out" / "pendulum" / "scene"
    names = {"results.npz", "results.csv", "angles_energy.png", "folded.png", "manifest.json"}
    assert {p.name for p in out.iterdir()} == names
    for word in (
        "2 bodies (1 fixed)",
        "1 hinge",
        "gravity",
        "hinge_damping",
        "accepted",
        "× real time",
        "results.csv",
    ):
        assert word in result.stdout
    with np.load(out / "results.npz") as arrays, (out / "results.csv").open(encoding="utf-8") as table:
        rows = list(csv.reader(table))
        assert arrays["t"].shape == (51,)
        assert len(rows) == 52
        assert float(rows[-1][1]) == arrays["q"][-1, 0]


def test_run_swings_as_a_pendulum_does(tmp_path: Path) -> None:
    file = pendulum(tmp_path / "p.yaml", extra="")
    result = run(str(file), "--t-end", "3", "--angle", "h1=89 deg", "--points", "3001", "--out", "o")
    assert result.exit_code == 0, result.output
    with np.load("o/results.npz") as arrays:
        hanging = arrays["q"][:, 0] - np.pi / 2
        crossings = np.flatnonzero(np.diff(np.sign(hanging)))
        times = arrays["t"][crossings]
    # Small swings about the hanging position: T = 2 pi sqrt((I + m l^2) / (m g l)), half a period between crossings.
    half = np.pi * np.sqrt((0.1 + 1 * 0.5**2) / (1 * 9.81 * 0.5))
    assert np.diff(times).mean() == pytest.approx(half, abs=2e-3)  # rows are 1 ms apart, at either end
    assert "it changes by at most" in result.stdout  # nothing is damped, so the drift is reported


def test_json_is_all_that_run_puts_on_stdout(tmp_path: Path) -> None:
    file = pendulum(tmp_path / "p.yaml")
    result = run(str(file), "--t-end", "0.2", "--json", "--set", "h1.stiffness=0.25", "--without", "gravity")
    data = json.loads(result.stdout)
    assert data["ok"] is True
    assert data["parameters"]["h1.stiffness"] == 0.25
    assert {"name": "gravity", "in": False, "why": "left out by --without"} in data["effects"]
    assert not any(name.startswith("gravity") for name in data["parameters"])
    assert data["energy_drift"] is None  # it is damped
    manifest = json.loads((Path(data["folder"]) / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["parameters"] == data["parameters"]
    assert manifest["seconds"]["run"] > 0.0


def test_an_added_torque_drives_the_hinge(tmp_path: Path) -> None:
    file = pendulum(tmp_path / "p.yaml", extra="")
    words = (
        "--t-end",
        "1",
        "--points",
        "11",
        "--without",
        "gravity",
        "--with",
        "torque={h1: 0.35}",
        "--out",
        "o",
    )
    assert run(str(file), *words).exit_code == 0
    with np.load("o/results.npz") as arrays:
        # A constant 0.35 N·m on 0.1 + 1 * 0.5^2 = 0.35 kg·m² turns by t²/2 rad.
        assert arrays["q"][:, 0] == pytest.approx(arrays["t"] ** 2 / 2, abs=1e-8)  # rtol of the run is 1e-9


def test_quiet_says_nothing_and_progress_is_plain_lines_on_stderr(tmp_path: Path) -> None:
    file = pendulum(tmp_path / "p.yaml")
    quiet = run(str(file), "--t-end", "0.1", "--quiet")
    assert (quiet.exit_code, quiet.stdout, quiet.stderr) == (0, "", "")
    loud = run(str(file), "--t-end", "0.1")
    assert "run …" in loud.stderr.splitlines()


def test_a_stage_that_takes_long_says_that_it_goes_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(terminal, "_SILENT", 0.2)
    monkeypatch.setattr(terminal, "_LEAST", 0.01)
    said = ""
    with terminal.PlainProgress() as lines:
        lines.stage("compile")
        until = time.monotonic() + 20.0  # a hundred times as long as it takes
        while said.count("compile … 0 s") < 2 and time.monotonic() < until:
            time.sleep(0.05)
            said += capsys.readouterr().err
    assert said.startswith("compile …\ncompile … 0 s\n")
    before = threading.active_count()
    with terminal.PlainProgress() as lines:
        lines.stage("load")
    assert threading.active_count() == before


def test_drawn_limits_act_unless_the_scene_leaves_them_out(tmp_path: Path) -> None:
    file = pendulum(tmp_path / "p.yaml", extra=", limits: [-1, 1]")
    said = run(str(file), "--t-end", "0.1").stdout
    assert "1 joint has limits narrower than ±180°" in said
    left_out = " ".join(run(str(file), "--t-end", "0.1", "--without", "joint_limits").stdout.split())
    assert "does not call for joint_limits, so those of h1 are not simulated" in left_out


def test_a_failed_run_keeps_its_rows_and_ends_with_3(tmp_path: Path) -> None:
    file = pendulum(tmp_path / "p.yaml")
    one = "(sin(angle)**2 + cos(angle)**2)"  # so that nobody sees before the run where the logarithm ends
    torque = f"torque={{h1: log(0.5 - t*{one})}}"
    result = run(str(file), "--t-end", "2", "--points", "201", "--with", torque, "--json", "--out", "o")
    assert result.exit_code == 3
    assert json.loads(result.stdout)["ok"] is False
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("error:")]
    assert "t = 0.5 s" in line
    with np.load("o/results.npz") as arrays:
        assert len(arrays["t"]) == 51  # rows at 0, 0.01, … 0.49, and the last state: the torque ends at 0.5 s
        assert np.isfinite(arrays["q"]).all()


@pytest.mark.usefixtures("painted")
@pytest.mark.slow
def test_a_film_of_an_earlier_run_is_taken_away(tmp_path: Path) -> None:
    file = pendulum(tmp_path / "p.yaml")
    first = call("run", str(file), "--t-end", "0.1", "--out", "o", "--film", "--json")
    (film,) = [name for name in json.loads(first.stdout)["files"] if name.startswith("animation")]
    (tmp_path / "o" / "animation.txt").write_text("the user's own", encoding="utf-8")
    assert (tmp_path / "o" / film).stat().st_size > 1000
    assert run(str(file), "--t-end", "0.1", "--out", "o").exit_code == 0
    assert not (tmp_path / "o" / film).exists()
    assert (tmp_path / "o" / "animation.txt").exists()


@pytest.mark.slow
def test_ctrl_c_keeps_what_was_computed_within_a_short_time(tmp_path: Path) -> None:
    file = pendulum(tmp_path / "p.yaml", extra="")
    # Compiled beforehand, so that the second run begins at once.
    assert run(str(file), "--t-end", "0.1", "--out", "warm").exit_code == 0
    limits = ["--t-end", "1e6", "--max-steps", "1000000000000", "--points", "1000001"]
    words = [str(file), *limits, "--rate", "h1=1", "--out", "o"]
    process = subprocess.Popen(
        [sys.executable, "-m", "lamc.cli", "run", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert process.stderr is not None
    for line in process.stderr:
        if line.startswith("run"):
            break
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    started = time.monotonic()
    stdout, stderr = process.communicate(timeout=60)
    # Two pictures and the files take about a second; ten leave room for a busy machine.
    assert time.monotonic() - started < 10.0
    assert process.returncode == 130, stderr
    assert "what was computed is kept" in stderr
    assert "results.npz" in stdout
    with np.load(tmp_path / "o" / "results.npz") as arrays:
        assert 1 < len(arrays["t"]) < 1_000_001
    assert json.loads((tmp_path / "o" / "manifest.json").read_text(encoding="utf-8"))["status"] == "cancelled"


def test_default_rows_grow_with_the_run_up_to_a_limit() -> None:
    assert default_rows(1.0, 6) == 2001
    assert default_rows(20.0, 6) == 4001
    assert default_rows(1e9, 6) == 100_001
    assert default_rows(1e9, 2000) == 2001


# --- errors -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "reported"),
    [
        ((), "name a FILE"),
        (("--example", "pendulm"), "did you mean 'pendulum'"),
        (("none.yaml",), "there is no such file"),
        (("q.yaml",), "there is no such file; did you mean 'p.yaml'?"),
        (("none/p.yaml",), "nor the folder 'none'"),
        (("pendulum.cad",), "--example pendulum.cad"),
        (("shutter.yml",), "--example shutter"),
        (("p.yaml", "--example", "pendulum"), "not both"),
        (("p.yaml", "--set", "h1.stifness=1"), "did you mean 'h1.stiffness'"),
        (("p.yaml", "--set", "h1.stiffness"), "NAME=VALUE"),
        (("p.yaml", "--set", "h1.stiffness=soft"), "not a number"),
        (("p.yaml", "--angle", "h2=1"), "no joint is named 'h2'"),
        (("p.yaml", "--angle", "h1=3 kg"), "not a unit of angle"),
        (("p.yaml", "--without", "grvity"), "did you mean 'gravity'"),
        (("p.yaml", "--with", "torque"), "give a map"),
        (("p.yaml", "--with", "torque={h1: __import__('os')}"), "error: --with"),
        (("p.yaml", "--with", "gravity", "--without", "gravity"), "keep one of them"),
        (("p.yaml", "--t-end", "nan"), "t_end is nan"),
        (("p.yaml", "--t-end", "soon"), "'soon' is not a duration"),
        (("p.yaml", "--t-end", "5 m"), "not a unit of duration"),
        (("p.yaml", "--points", "1"), "--points is 1"),
        (("p.yaml", "--integrator", "euler"), "no integrator is named 'euler'"),
        (("p.yaml", "--out", "p.yaml"), "is a file"),
        (("p.yaml", "--out", "p.yaml/deep"), "cannot be made"),
        (
            (
                "p.yaml",
                "--nix",
            ),
            "No such option",
        ),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2_and_leaves_nothing(
    tmp_path: Path, words: tuple[str, ...], reported: str
) -> None:
    pendulum(tmp_path / "p.yaml")
    result = call("run", *words, "--quiet")
    assert result.exit_code == 2
    assert result.stdout == ""
    (line,) = result.stderr.splitlines()
    assert line.startswith("error: ")
    assert reported in line
    assert [p.name for p in tmp_path.iterdir()] == ["p.yaml"]


def test_several_problems_of_a_file_are_a_line_each_with_their_places(tmp_path: Path) -> None:
    text = pendulum(tmp_path / "p.yaml").read_text(encoding="utf-8")
    (tmp_path / "p.yaml").write_text(
        text.replace("mass: 1", "mass: -1").replace("damping: 0.01", "damping: x")
    )
    result = run("p.yaml", "--json")
    assert result.exit_code == 2
    lines = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert [line.split(":")[1:3] for line in lines] == [[" p.yaml", "5"], [" p.yaml", "7"]]
    errors = json.loads(result.stdout)["errors"]
    assert [(e["file"], e["line"]) for e in errors] == [("p.yaml", 5), ("p.yaml", 7)]


def test_debug_shows_the_traceback() -> None:
    assert "Traceback" in call("run", "none.yaml", "--debug").stderr
    assert "Traceback" not in call("run", "none.yaml").stderr


def test_no_compiler_is_exit_code_4(tmp_path: Path) -> None:
    pendulum(tmp_path / "p.yaml", name="another")
    for words in (("--cc", "no-such-compiler"), ("--cc", "false")):
        result = run("p.yaml", *words, "--quiet")
        assert result.exit_code == 4
        assert len(result.stderr.splitlines()) == 1
    assert [p.name for p in tmp_path.iterdir()] == ["p.yaml"]


def test_energy_balance_tell_who_stored_supplied_and_dissipated(tmp_path: Path) -> None:
    """A damped pendulum that falls: gravity gives back what it stored, the damper keeps what it took."""
    file = pendulum(tmp_path / "p.yaml")
    result = run(str(file), "--t-end", "0.5", "--books", "--out", "out")
    assert result.exit_code == 0
    assert "warning: --books is --energy-balance now" in result.stderr
    table = [line.split() for line in result.stdout.splitlines() if line.startswith(("balance", "        "))]
    assert ["balance", "stored", "supplied", "dissipated"] in table
    assert [row[0] for row in table if len(row) == 3 and row[2] == "J"] == [
        "kinetic",
        "hinge_damping",
        "hinge_stiffness",
        "gravity",
    ]
    energy_balance = json.loads(Path("out/manifest.json").read_text(encoding="utf-8"))["books"]
    entries = {entry["effect"]: entry for entry in energy_balance["effects"]}
    assert entries["hinge_damping"]["supplied"] < 0.0
    assert (
        abs(entries["gravity"]["supplied"]) < 1e-8 * energy_balance["scale"]
    )  # conservative, at a tolerance of 1e-9
    total = sum(entry["work"] for entry in entries.values())
    assert total == pytest.approx(energy_balance["kinetic"], abs=1e-8 * energy_balance["scale"])
    with Path("out/results.csv").open(encoding="utf-8") as lines:
        assert "hinge_damping work (J)" in next(csv.reader(lines))


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_read_only_folder_is_refused_before_the_run(tmp_path: Path) -> None:
    pendulum(tmp_path / "p.yaml")
    (tmp_path / "ro").mkdir(mode=0o500)
    result = run("p.yaml", "--out", "ro")
    assert result.exit_code == 2
    assert "cannot be written to" in result.stderr


@pytest.mark.parametrize("name", [HOSTILE, "../../x", "$(touch x)", "_$x^2$", "[red]a", "🦋" * 50])
def test_hostile_names_stay_names(tmp_path: Path, name: str) -> None:
    file = pendulum(tmp_path / "p.yaml", name=name, joint=name)
    result = run(str(file), "--t-end", "0.1", "--json")
    assert result.exit_code == 0, result.stderr
    folder = Path(json.loads(result.stdout)["folder"])
    assert folder.resolve().parent.parent == tmp_path / "out"
    assert {p.name for p in tmp_path.iterdir()} == {"p.yaml", "out"}
    assert json.loads(result.stdout)["joints"] == [name]


@pytest.mark.parametrize(
    "name", ["../../x", "/etc/passwd", "..", "", "a/b", "\x00", "x" * 500, "über", "-rf"]
)
def test_folder_names_are_one_plain_path_component(name: str) -> None:
    made = folder_name(name)
    assert made
    assert made == Path(made).name
    assert set(made) <= set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-")
    assert not made.startswith(".")
    assert len(made) <= 60


# --- the other verbs ----------------------------------------------------------------------------------------------


@pytest.mark.slow
@needs_cc
def test_build_leaves_a_folder_that_compiles_and_runs(tmp_path: Path) -> None:
    pendulum(tmp_path / "p.yaml")
    result = call("build", "p.yaml", "--out", "c", "--equations", "--json")
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    folder = tmp_path / "c"
    assert {p.name for p in folder.iterdir()} == set(data["files"])
    assert data["flops"] == data["additions"] + data["multiplications"] + data["divisions"]
    sources = sorted(str(p) for p in folder.glob("*.c"))
    flags = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
    subprocess.run(["cc", *flags, *sources, "-lm", "-o", str(tmp_path / "x")], check=True)
    table = subprocess.run([str(tmp_path / "x")], capture_output=True, text=True, check=True).stdout
    assert len(table.splitlines()) > 10


def test_build_overwrites_its_own_files_only(tmp_path: Path) -> None:
    pendulum(tmp_path / "p.yaml")
    pendulum(tmp_path / "other.yaml", name="other")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "main.c").write_text("int main(void) { return 7; }\n", encoding="utf-8")
    refused = call("build", "p.yaml", "--out", "full")
    assert refused.exit_code == 2
    assert (tmp_path / "full" / "main.c").read_text(encoding="utf-8") == "int main(void) { return 7; }\n"
    assert call("build", "p.yaml", "--out", "c").exit_code == 0
    (tmp_path / "c" / "notes.txt").write_text("mine", encoding="utf-8")
    assert call("build", "p.yaml", "--out", "c").exit_code == 0
    assert (tmp_path / "c" / "notes.txt").read_text(encoding="utf-8") == "mine"
    assert "holds build of " in call("build", "other.yaml", "--out", "c").stderr
    (tmp_path / "c" / "main.c").write_text("/* my own */ int main(void) { return 0; }\n", encoding="utf-8")
    assert call("build", "p.yaml", "--out", "c").exit_code == 2


def test_build_takes_away_equations_of_an_earlier_build(tmp_path: Path) -> None:
    pendulum(tmp_path / "p.yaml")
    assert call("build", "p.yaml", "--out", "c", "--equations").exit_code == 0
    (tmp_path / "c" / "equations.tex").write_text("my own notes on lamc", encoding="utf-8")
    assert call("build", "p.yaml", "--out", "c").exit_code == 0
    assert not (tmp_path / "c" / "equations.txt").exists()
    assert (tmp_path / "c" / "equations.tex").exists()


def test_check_prints_a_table_and_passes(tmp_path: Path) -> None:
    pendulum(tmp_path / "p.yaml")
    result = call("check", "p.yaml", "--states", "3", "--t-end", "0.2")
    assert result.exit_code == 0, result.stderr
    assert "C / interpreter" in result.stdout
    assert "C / Newton-Euler" in result.stdout


def test_check_ends_with_3_where_the_cross_checks_differ(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pendulum(tmp_path / "p.yaml")
    # The package shows the function of the same name in place of its module.
    monkeypatch.setattr(importlib.import_module("lamc.reference.check"), "INDEPENDENT", -1.0)
    result = call("check", "p.yaml", "--states", "2", "--t-end", "0.1", "--json", "--quiet")
    assert result.exit_code == 3
    assert json.loads(result.stdout)["ok"] is False
    assert "beyond their limits" in result.stderr


def test_split_writes_files_that_read_back_to_the_same_mechanism(tmp_path: Path) -> None:
    result = call("split", "--example", "flaps", "--out", "parts", "--json")
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    assert set(data["files"]) == {"flaps.joints", "flaps.mechanism.yaml", "split.png"}
    again = lamc.load(tmp_path / "parts" / "flaps.mechanism.yaml")
    assert isinstance(again, lamc.Mechanism)
    assert [b.mass for b in again.bodies] == [b["mass"] for b in data["bodies"]]
    text = call("split", str(tmp_path / "parts" / "flaps.mechanism.yaml"), "--out", "again")
    assert text.exit_code == 0
    assert "left" in text.stdout


@pytest.mark.usefixtures("painted")
def test_split_writes_the_newer_form_of_an_older_joint_definition(shared: Path, tmp_path: Path) -> None:
    old = shared / "designs" / "flaps_old.joints"
    assert call("split", str(old), "--out", "a").exit_code == 0
    assert call("split", "a/flaps_old.mechanism.yaml", "--out", "b").exit_code == 0
    given = lamc.load(old)
    assert isinstance(given, lamc.Mechanism)
    for folder in ("a", "b"):  # from the file's own layers, and from those that its plates tell
        assert (tmp_path / folder / "bodies.png").stat().st_size > 5000
        again = lamc.load(tmp_path / folder / "flaps_old.joints")
        assert isinstance(again, lamc.Mechanism)
        for x, y in zip(given.bodies, again.bodies, strict=True):
            assert (x.name, x.fixed) == (y.name, y.fixed)
            # Sums of the same few products: round-off is some 1e-16, and 1e-12 leaves room.
            assert y.mass == pytest.approx(x.mass, rel=1e-12)
            assert y.com == pytest.approx(x.com, abs=1e-12 * 0.05)
            assert y.inertia == pytest.approx(x.inertia, abs=1e-12 * float(np.abs(x.inertia).max()))
        for a, b in zip(given.joints, again.joints, strict=True):
            assert (a.name, a.parent, a.child, a.stiffness) == (b.name, b.parent, b.child, b.stiffness)
            assert b.point == pytest.approx(a.point, abs=1e-12 * 0.05)
            assert b.axis == pytest.approx(a.axis, abs=1e-12)
            assert (*b.limits, b.rest_angle) == pytest.approx((*a.limits, a.rest_angle), abs=1e-12)


def test_split_of_a_mechanism_without_plates_says_why_there_is_no_picture(tmp_path: Path) -> None:
    pendulum(tmp_path / "p.yaml")
    result = call("split", "p.yaml", "--out", "s")
    assert result.exit_code == 0
    assert "no joint definition and no picture" in result.stdout


@pytest.mark.usefixtures("painted")
@pytest.mark.slow
def test_bench_shows_four_ways_that_agree(tmp_path: Path) -> None:
    pendulum(tmp_path / "p.yaml")
    result = call("bench", "p.yaml", "--out", "o")
    assert result.exit_code == 0, result.stderr
    rows = json.loads((tmp_path / "o" / "bench.json").read_text(encoding="utf-8"))["rows"]
    assert [row["name"] for row in rows] == [
        "sympy subs + evalf",
        "lambdified numpy",
        "interpreter",
        "generated C",
    ]
    assert all(row["evaluation"] > 10 * rows[-1]["evaluation"] for row in rows[:-1])
    assert (tmp_path / "o" / "bench.png").stat().st_size > 5000
    assert "extrapolated" in result.stdout


def test_schema_is_json() -> None:
    assert json.loads(call("schema").stdout)["$schema"].startswith("https://json-schema.org/")


def test_doctor_finds_a_compiler_that_works_and_one_that_does_not(cache_of_the_session: Path) -> None:
    well = call("doctor", "--json")
    assert well.exit_code == 0, well.stdout
    findings = {f["matter"]: f for f in json.loads(well.stdout)["findings"]}
    assert findings["C compiler"]["state"] == "ok"
    assert str(cache_of_the_session) in findings["cache"]["text"]
    ill = call("doctor", "--cc", "false")
    assert ill.exit_code == 4
    assert "broken" in ill.stdout


@pytest.mark.slow
def test_a_reader_that_goes_away_is_no_error() -> None:
    command = f"{sys.executable} -m lamc.cli schema | head -1"
    done = subprocess.run(
        ["bash", "-c", f"set -o pipefail; {command}"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.stdout.strip() == "{"
    assert done.stderr == ""


_INTERRUPTED_IMPORT = """
import sys
class Interrupts:
    def find_spec(self, name, path=None, target=None):
        if name == "numpy":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Interrupts())
sys.argv = ["lamc", "examples"]
from importlib.metadata import EntryPoint
import tomllib
with open(sys.orig_argv[-1], "rb") as project:
    named = tomllib.load(project)["project"]["scripts"]["lamc"]
EntryPoint("lamc", named, "console_scripts").load()()
"""


def test_ctrl_c_while_lamc_is_imported_is_one_line_and_no_traceback() -> None:
    command = [sys.executable, "-c", _INTERRUPTED_IMPORT, str(ROOT / "pyproject.toml")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "error: interrupted; nothing was written\n"


def test_names_of_other_letters_have_folders_of_their_own() -> None:
    crane, ship = folder_name("鶴"), folder_name("船")
    assert crane != ship
    assert crane == folder_name("鶴")
    assert {crane[:7], ship[:7]} == {"design_"}

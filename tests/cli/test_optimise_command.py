"""`lamc optimise` as a user meets it: files, summary, exit codes, study files, one-line errors."""

import json
import math
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from lamc.cli import main
from tests.cli.test_sweep_command import ROD
from tests.support.ctools import needs_cc

pytestmark = [pytest.mark.usefixtures("unpainted"), needs_cc]

INERTIA = 0.1 + 1.0 * 0.5**2  # of the rod about its hinge
STILL = ("--without", "gravity", "--angle", "h1=20 deg", "--t-end", "2")
GOAL = ("--minimise", "time_of(h1 < 0)")
HELD = ("--subject-to", "max(abs(h1.rate)) < 1.5 rad/s")
STUDY = """\
kind: study
design: rod.yaml
scene: still.yaml
set: {link.mass: 1 kg}
vary:
  h1.stiffness: log:0.2:20:7
measure:
  quarter: time_of(h1 < 0)
minimise: time_of(h1 < 0)
subject_to:
  - max(abs(h1.rate)) < 1.5 rad/s
start: {h1.stiffness: 3}
starts: 1
run: {t_end: 2 s}
"""
STIFFNESS = INERTIA * (1.5 / math.radians(20.0)) ** 2


@pytest.fixture(autouse=True)
def _design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # undamped, as the closed form is
    (tmp_path / "rod.yaml").write_text(ROD.replace("damping: 1e-6", "damping: 0"), encoding="utf-8")
    (tmp_path / "still.yaml").write_text(
        "kind: scene\nwithout: gravity\nangles: {h1: 20 deg}\n", encoding="utf-8"
    )
    (tmp_path / "study.yaml").write_text(STUDY, encoding="utf-8")


def call(*words: str) -> Result:
    return CliRunner().invoke(main, ["optimise", *words])


@pytest.mark.slow
def test_an_optimum_is_told_written_and_drawn() -> None:
    words = (
        "rod.yaml",
        "--vary",
        "h1.stiffness=log:0.2:20",
        *GOAL,
        *HELD,
        *STILL,
        "--starts",
        "1",
        "--out",
        "out",
    )
    found = call(*words, "--json")
    assert found.exit_code == 0, found.output
    told = json.loads(found.stdout)
    assert told["converged"]
    assert told["files"] == ["study.json", "rows.jsonl", "history.csv", "optimum.png"]
    assert told["parameters"][0]["value"] == pytest.approx(STIFFNESS, rel=1e-6)
    assert [each["what"] for each in told["active"]] == [HELD[1]]
    lines = Path("out/history.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 1 + told["runs"]
    assert lines[0].startswith(
        "run,h1.stiffness (N·m/rad),time_of(h1 < 0) (s),max(abs(h1.rate)) < 1.5 rad/s (rad/s),"
    )
    again = call(*words)
    assert again.exit_code == 2
    assert "holds a study already; go on with it by --resume" in again.output
    resumed = call(*words, "--resume", "--no-pictures")
    assert resumed.exit_code == 0
    assert "converged: slopes vanish" in resumed.output
    assert Path("out/history.csv").read_text(encoding="utf-8").splitlines() == lines


def test_a_study_file_says_what_options_say() -> None:
    assert call("study.yaml", "--out", "a", "--no-pictures", "--quiet").exit_code == 0
    told = json.loads(call("study.yaml", "--out", "b", "--no-pictures", "--json").stdout)
    assert told["parameters"][0]["value"] == pytest.approx(STIFFNESS, rel=1e-6)
    swept = CliRunner().invoke(
        main, ["sweep", "study.yaml", "--quiet", "--no-pictures", "--workers", "1", "--out", "c"]
    )
    assert swept.exit_code == 0, swept.output  # the same file serves both


def test_what_did_not_converge_is_written_and_is_no_success() -> None:
    found = call("study.yaml", "--max-runs", "8", "--out", "a", "--no-pictures")
    assert found.exit_code == 3
    assert "not converged: it was ended after 8 runs" in found.output
    assert len(Path("a/history.csv").read_text(encoding="utf-8").splitlines()) == 9


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "minimise: time_of(h1",
            "minimise: time_of(h2",
            "study.yaml:9:11: measure 'time_of(h2 < 0)', column 9",
        ),
        ("max(abs(h1.rate)) <", "max(abs(h1.rte)) <", "study.yaml:11:5: constraint"),
        ("0.2:20:7", "20:0.2:7", "study.yaml:6:17: vary 'h1.stiffness': the range"),
        ("h1.stiffness: 3", "h1.stiffness: 30", "is outside of its range, 0.2 to 20 N·m/rad"),
        ("starts: 1", "starts: 0", "study.yaml:13:9: starts"),
        ("starts: 1", "method: slsq", "study.yaml:13:9: no method is named 'slsq'"),
        ("subject_to", "subjct_to", "did you mean 'subject_to'?"),
    ],
)
def test_what_is_wrong_is_told_at_its_line(old: str, new: str, told: str) -> None:
    assert old in STUDY
    Path("study.yaml").write_text(STUDY.replace(old, new), encoding="utf-8")
    found = call("study.yaml", "--out", "a", "--quiet")
    assert found.exit_code == 2
    assert told in found.output
    assert len(found.output.splitlines()) == 1


def test_a_front_is_drawn() -> None:
    pytest.importorskip("pymoo")
    found = call(
        "rod.yaml", "--vary", "h1.stiffness=0.2:20", *GOAL, "--minimise", "max(abs(h1.rate))", *STILL,
        "--max-runs", "150", "--out", "out", "--json",
    )  # fmt: skip
    told = json.loads(found.stdout)
    goals = [[each["value"] for each in told["goals"]], *(each["goals"] for each in told["front"])]
    for quarter, rate in goals:  # θ π/2 = T/4 ω θ: all that there is lies on the front
        assert quarter * rate == pytest.approx(math.radians(20.0) * math.pi / 2.0, rel=1e-6)
    assert Path("out/optimum.png").stat().st_size > 0


def test_help_names_what_it_can_do() -> None:
    found = call("--help")
    for word in ("--vary", "--minimise", "--subject-to", "least-squares", "cma-es", "3..8"):
        assert word in found.output

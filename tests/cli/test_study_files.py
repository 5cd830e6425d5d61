"""Study files: what they say is what options say, and what is wrong with them is told at its line."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from lamc.cli import main
from tests.cli.test_sweep_command import ROD

STUDY = """\
kind: study
design: designs/rod.yaml
scene: scenes.yaml
set: {link.mass: 2 kg}
vary:
  h1.stiffness: 1:3:3
  angles.h1: [10 deg, 0.2]
measure:
  end: last(h1)
run: {t_end: 100 ms, rtol: 1e-6}
"""


@pytest.fixture(autouse=True)
def _study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "work/designs").mkdir(parents=True)
    (tmp_path / "work/designs/rod.yaml").write_text(ROD, encoding="utf-8")
    (tmp_path / "work/scenes.yaml").write_text("kind: scene\nwithout: gravity\n", encoding="utf-8")
    (tmp_path / "work/study.yaml").write_text(STUDY, encoding="utf-8")


def call(*words: str) -> Result:
    return CliRunner().invoke(main, ["sweep", *words, "--workers", "1", "--no-pictures", "--quiet"])


def test_a_file_says_what_options_say() -> None:
    assert call("work/study.yaml", "--out", "a").exit_code == 0
    options = ("--scene", "work/scenes.yaml", "--set", "link.mass=2 kg", "--vary", "h1.stiffness=1:3:3")
    options += (
        "--vary",
        "angles.h1=10 deg,0.2",
        "--measure",
        "end=last(h1)",
        "--t-end",
        "0.1",
        "--rtol",
        "1e-6",
    )
    found = call("work/designs/rod.yaml", *options, "--out", "b")
    assert found.exit_code == 0, found.output
    assert Path("a/table.csv").read_bytes() == Path("b/table.csv").read_bytes()
    assert len(Path("a/table.csv").read_bytes().splitlines()) == 7


def test_options_go_over_the_file() -> None:
    words = ("--vary", "h1.stiffness=5", "--measure", "fast=max(h1.rate)", "--t-end", "0.2", "--out", "a")
    found = call("work/study.yaml", *words)
    assert found.exit_code == 0, found.output
    head, *lines = Path("a/table.csv").read_text(encoding="utf-8").splitlines()
    assert (
        head == "point,h1.stiffness (N·m/rad),angles.h1 (rad),end (rad),fast (rad/s),structure,status,reason"
    )
    assert len(lines) == 2
    assert '"t_end": 0.2' in Path("a/study.json").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("last(h1)", "last(h11)", "9:8: measure 'last(h11)', column 6: no output of a run is named 'h11'"),
        ("1:3:3", "3:1:3", "6:17: vary 'h1.stiffness': the range '3:1:3' runs backwards"),
        ("h1.stiffness", "h1.stifness", "did you mean 'h1.stiffness'?"),
        ("rtol", "rtoll", "10:22: run.rtoll: the key 'rtoll' is unknown; did you mean 'rtol'?"),
        ("100 ms", "100 mm", "run.t_end"),
        ("design: designs/rod.yaml\n", "", "exactly one of design: FILE and example: NAME"),
        (
            "designs/rod.yaml",
            "designs/rood.yaml",
            "there is no such file; did you mean 'work/designs/rod.yaml'?",
        ),
        ("link.mass: 2 kg", "link.mas: 2 kg", "link.mas"),
        ("link.mass: 2 kg", "link.mass: 2 mm", "link.mass"),
        ("set:", "points: p.csv\nset:", "exactly one of vary: {…} and points: FILE"),
        ("scenes.yaml", "slow", "no scene is named 'slow'"),
    ],
)
def test_what_is_wrong_is_told_at_its_line(old: str, new: str, told: str) -> None:
    assert old in STUDY
    Path("work/study.yaml").write_text(STUDY.replace(old, new), encoding="utf-8")
    found = call("work/study.yaml", "--out", "a")
    assert found.exit_code == 2
    assert told in found.output
    assert "work/" in found.output
    assert len(found.output.splitlines()) == 1


def test_other_verbs_name_the_one_for_studies() -> None:
    found = CliRunner().invoke(main, ["run", "work/study.yaml", "--quiet"])
    assert found.exit_code == 2
    assert "`lamc sweep` runs it" in found.output

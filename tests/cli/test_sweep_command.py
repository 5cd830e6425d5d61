"""`lamc sweep` as a user meets it: files, tables, pictures, one-line errors."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from lamc.cli import main

pytestmark = pytest.mark.usefixtures("unpainted")

ROD = """\
kind: mechanism
name: rod
bodies:
  - {name: ground, fixed: true}
  - {name: link, mass: 1, com: [0.5, 0, 0], inertia: [[0.01, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]}
joints:
  - {name: h1, parent: ground, child: link, point: [0, 0, 0], axis: [0, 1, 0], stiffness: 2, damping: 1e-6}
"""
RUN = ("rod.yaml", "--t-end", "0.1", "--rtol", "1e-6", "--workers", "1")


@pytest.fixture(autouse=True)
def _design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rod.yaml").write_text(ROD, encoding="utf-8")


def call(*words: str) -> Result:
    return CliRunner().invoke(main, ["sweep", *RUN, *words])


@pytest.mark.parametrize(
    "vary",
    [
        ("--vary", "h1.stiffness=1:3:5"),
        ("--vary", "h1.stiffness=log:1:3:3", "--vary", "angles.h1=10 deg,20deg"),
        ("--vary", "h1.stiffness=1,2", "--vary", "angles.h1=0,0.1", "--vary", "link.mass=1 kg:2 kg:2"),
        ("--vary", "h1.stiffness=normal(2, 0.1)", "--sample", "lhs:6"),
        ("--vary", "h1.stiffness=1:2", "--vary", "link.mass=1:2", "--sample", "saltelli:4"),
        ("--vary", "h1.stiffness=2"),
    ],
)
def test_each_plan_has_its_table_and_its_picture(vary: tuple[str, ...]) -> None:
    found = call(
        *vary, "--measure", "end=last(h1)", "--measure", "time_of(h1 > 1 deg)", "--json", "--out", "out"
    )
    assert found.exit_code == 0, found.output
    told = json.loads(found.stdout)
    assert told["files"] == ["study.json", "rows.jsonl", "table.csv", "study.png"]
    lines = Path("out/table.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 1 + told["points"]
    assert lines[0].startswith("point,h1.stiffness (N·m/rad),")
    assert lines[0].endswith("end (rad),time_of(h1 > 1 deg) (s),structure,status,reason")
    assert (Path("out") / "study.png").stat().st_size > 0


def test_what_is_there_is_not_run_again() -> None:
    words = ("--vary", "h1.stiffness=1:3:5", "--measure", "last(h1)", "--out", "out", "--no-pictures")
    assert call(*words).exit_code == 0
    again = call(*words)
    assert again.exit_code == 2
    assert "holds a study already; go on with it by --resume" in again.output
    table = Path("out/table.csv").read_bytes()
    rows = Path("out/rows.jsonl")
    rows.write_text("".join(rows.read_text().splitlines(keepends=True)[:2]))
    resumed = call(*words, "--resume")
    assert resumed.exit_code == 0, resumed.output
    assert Path("out/table.csv").read_bytes() == table
    other = call("--vary", "h1.stiffness=1:3:6", *words[2:], "--resume")
    assert other.exit_code == 2
    assert "holds a study of another plan" in other.output


def test_points_come_from_a_file_and_settings_hold_for_all() -> None:
    Path("points.csv").write_text("angles.h1 (deg),link.mass\n10,1\n20,2 kg\n", encoding="utf-8")
    found = call(
        "--points", "points.csv", "--measure", "first(h1)", "--set", "h1.stiffness=3 N*mm/rad", "--out", "out"
    )
    assert found.exit_code == 0, found.output
    lines = Path("out/table.csv").read_text(encoding="utf-8").splitlines()
    values = [float(line.split(",")[3]) for line in lines[1:]]
    assert values == pytest.approx(np.radians([10.0, 20.0]), rel=1e-15)


def test_options_change_the_scene_of_every_point() -> None:
    words = ("--vary", "link.mass=1,2", "--measure", "last(h1)", "--no-pictures", "--without", "gravity")
    found = call(*words, "--angle", "h1=0.2", "--out", "out")
    assert found.exit_code == 0, found.output
    ends = [float(line.split(",")[2]) for line in Path("out/table.csv").read_text().splitlines()[1:]]
    assert all(0.19 < end < 0.2 for end in ends)  # the spring pulls it back, and no weight turns it on


def test_a_study_of_which_no_point_goes_well_says_so() -> None:
    found = call(
        "--vary", "h1.stiffness=1,2", "--measure", "time_of(h1 > 100)", "--out", "out", "--no-pictures"
    )
    assert found.exit_code == 3
    assert "no point went well" in found.output
    assert "'time_of(h1 > 100)' is nan" in found.output


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--measure", "last(h1)"), "nothing is varied"),
        (("--vary", "h1.stiffness=1:2:3"), "nothing is measured"),
        (("--vary", "h1.stifness=1:2:3", "--measure", "last(h1)"), "did you mean 'h1.stiffness'?"),
        (("--vary", "h1.stiffness=2:1:3", "--measure", "last(h1)"), "runs backwards; write 1:2:3"),
        (("--vary", "h1.stiffness=1mm:2mm:3", "--measure", "last(h1)"), "h1.stiffness"),
        (("--vary", "h1.stiffness=1:2:3", "--measure", "last(h1.rat)"), "did you mean 'h1.rate'?"),
        (("--vary", "h1.stiffness=1:2:3", "--measure", "a=h1"), "a value at every time"),
        (
            ("--vary", "h1.stiffness=1:2:3", "--measure", "last(h1)", "--sample", "lsh:20"),
            "did you mean 'lhs'?",
        ),
        (("--vary", "h1.stiffness=1:2:3", "--measure", "last(h1)", "--sample", "sobol:20"), "power of 2, 32"),
        (
            ("--vary", "h1.stiffness=1:2:1000000000", "--measure", "last(h1)"),
            "1000000000 points, which take about",
        ),
        (("--vary", "h1.stiffness=1:2:3", "--measure", "last(h1)", "--workers", "0"), "from 1 to 1024"),
        (("--points", "none.csv", "--measure", "last(h1)"), "there is no such file"),
    ],
)
def test_bad_words_are_one_line(words: tuple[str, ...], told: str) -> None:
    found = call(*words, "--out", "out", "--quiet")
    assert found.exit_code == 2
    assert told in found.output
    assert len(found.output.splitlines()) == 1
    assert not Path("out").exists()

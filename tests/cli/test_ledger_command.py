"""`lamc ledger` as a user meets it: files, tables, one-line errors."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from lamc.cli import main
from lamc.ledger.schema import read_ledger
from tests.support.quick import QUICKLY

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


@pytest.fixture
def design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rod.yaml").write_text(ROD, encoding="utf-8")
    return "rod.yaml"


def call(*words: str) -> Result:
    return CliRunner().invoke(main, ["ledger", *words])


@pytest.mark.slow
def test_ledger_writes_what_it_prints(design: str) -> None:
    found = call(
        design,
        "--t-end",
        "1",
        "--budget",
        "20 s",
        "--tightest",
        "1e-6",
        "--integrator",
        "rk45",
        "--integrator",
        "dop853",
    )
    assert found.exit_code == 0, found.output
    assert "verdict 1 % of the range" in found.output
    assert "hinge_damping" in found.output
    head = next(line for line in found.output.splitlines() if line.startswith("time to reach"))
    for column in ("closure", "drift"):  # what is reported below a table is about a column of it
        assert (f"{column} over" in found.output) == (column in head)
    ledger = read_ledger((Path("out") / "rod" / "ledger.json").read_text(encoding="utf-8"))
    assert ledger.verdict.idle == ("hinge_damping",)
    assert {p.integrator for p in ledger.points} == {"rk45", "dop853"}
    assert (Path("out") / "rod" / "ledger.png").is_file()


def test_json_is_the_record(design: str) -> None:
    found = call(
        design, "--t-end", "0.5", "--budget", "0.2 min", "--integrator", "rk45", "--no-effects", "--tightest", "1e-5",
        "--json",
    )  # fmt: skip
    data = json.loads(found.stdout)
    assert data["ok"]
    assert [p["setting"] for p in data["points"]] == [1e-3, 1e-4, 1e-5]
    assert data["account"] is None


@pytest.mark.parametrize(
    ("words", "reported"),
    [
        (("--t-end", "0"), "--t-end is 0 s"),
        (("--accuracy", "200 %"), "--accuracy is '200 %'"),
        (("--accuracy", "much"), "is no number"),
        (("--budget", "-3s"), "--budget is '-3s'"),
        (("--budget", "nan"), "is not finite"),
        (("--tightest", "1e-20"), "round-off"),
        (("--integrator", "rk44"), "did you mean 'rk45'"),
    ],
)
def test_words_that_make_no_sweep_are_refused_in_one_line(
    design: str, words: tuple[str, str], reported: str
) -> None:
    found = call(design, *words)
    assert found.exit_code == 2
    assert reported in found.stderr
    assert len(found.stderr.strip().splitlines()) == 1


@pytest.mark.slow
def test_run_that_cannot_be_referenced_is_an_error_with_the_way_out(design: str) -> None:
    found = call(design, "--t-end", "1e9", "--budget", "200 ms")
    assert found.exit_code == 3
    assert "--t-end" in found.stderr


def test_schema_describes_the_record() -> None:
    found = call("--schema")
    assert found.exit_code == 0
    assert {"points", "account", "verdict"} <= set(json.loads(found.stdout)["properties"])


def interrupted_after(reported: str, *words: str) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a process that gets SIGINT once its progress has a line with `reported`."""
    program = QUICKLY + "from lamc.cli import main\nmain()"
    command = [sys.executable, "-c", program, "ledger", "rod.yaml", *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        lines = []
        for line in process.stderr:
            lines.append(line)
            if reported in line:
                break
        process.send_signal(signal.SIGINT)
        out, rest = process.communicate(timeout=60)
        return process.returncode, out, "".join(lines) + rest


@pytest.mark.campaign  # within Python: test_interrupted_ledger_has_what_was_measured
def test_ctrl_c_keeps_what_is_measured(design: str) -> None:
    """The first line with a share of the work comes after 2 s: settings are measured by then, and minutes are left."""
    words = ("--t-end", "500", "--budget", "10 min")
    code, out, err = interrupted_after("work and precision … ", *words)
    assert code == 130
    assert "error: interrupted in 'work and precision'; what was measured until then is in" in err
    assert "INCOMPLETE" in out
    folder = Path("out") / "rod"
    ledger = read_ledger((folder / "ledger.json").read_text(encoding="utf-8"))
    assert ledger.interrupted == "work and precision"
    assert any(p.succeeded for p in ledger.points)
    assert any("interrupted" in p.note for p in ledger.points)
    assert (folder / "ledger.png").is_file()


@pytest.mark.slow
def test_ctrl_c_before_anything_is_measured_writes_nothing(design: str) -> None:
    code, out, err = interrupted_after("reference …", "--t-end", "1e5", "--budget", "10 min")
    assert code == 130
    assert "interrupted; nothing more was written" in err
    assert not out
    assert not (Path("out") / "rod" / "ledger.json").exists()

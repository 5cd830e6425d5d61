"""`lamc ledger` as a user meets it: files, tables, one-line errors."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from lamc.cli import main
from lamc.ledger.schema import read_ledger

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


def test_ledger_writes_what_it_prints(design: str) -> None:
    found = call(design, "--t-end", "1", "--budget", "20 s", "--integrator", "rk45", "--integrator", "dop853")
    assert found.exit_code == 0, found.output
    assert "verdict 1 % of the range" in found.output
    assert "hinge_damping" in found.output
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
    ("words", "told"),
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
    design: str, words: tuple[str, str], told: str
) -> None:
    found = call(design, *words)
    assert found.exit_code == 2
    assert told in found.stderr
    assert len(found.stderr.strip().splitlines()) == 1


def test_run_that_cannot_be_referenced_is_an_error_with_the_way_out(design: str) -> None:
    found = call(design, "--t-end", "1e6", "--budget", "200 ms")
    assert found.exit_code == 3
    assert "--t-end" in found.stderr


def test_schema_describes_the_record() -> None:
    found = call("--schema")
    assert found.exit_code == 0
    assert {"points", "account", "verdict"} <= set(json.loads(found.stdout)["properties"])

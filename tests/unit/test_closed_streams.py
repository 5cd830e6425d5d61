"""Commands do their work where streams are closed, as those of daemons are, or nobody reads them any more."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from lamc.cli import main
from tests.support.paths import ROOT
from tests.support.quick import QUICKLY, with_runtime

Commands = dict[str, str]
COMMANDS: Commands = {
    "run": "run --example flaps --t-end 0.05 --out o",
    "split": "split --example flaps --out o",
    "check": "check --example pendulum --states 2 --t-end 0.01",
    "build": "build --example pendulum --out o",
    "export": "export --example pendulum --out o",
    "schema": "schema",
}
SLOW: Commands = {
    "plate": "plate --example strip --out o",
    "ledger": "ledger --example pendulum --budget 1s --out o",
    "examples": "examples",
    "doctor": "doctor",
}
posix_only = pytest.mark.skipif(os.name != "posix", reason="the shell closes the streams")


def shell(line: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    """A command of lamc's with redirections, run by a shell in `folder`."""
    whole = f"exec '{sys.executable}' -m lamc {line}"
    return subprocess.run(["sh", "-c", whole], cwd=folder, capture_output=True, text=True, timeout=600)


# argv: commands by name, as JSON. Each has a folder of its own; what it prints follows its name. codes.json: exit codes
_ALL = """
import json, os, sys
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from lamc.cli import main
ConstrainedLayoutEngine.execute = lambda engine, figure: None
Figure.savefig = lambda figure, stream, **settings: stream.write(b"\\x89PNG")  # painted below
COMMANDS = json.loads(sys.argv[1])
codes, here = {}, os.getcwd()
for name, line in COMMANDS.items():
    os.makedirs(name)
    os.chdir(name)
    print("=====", name, flush=True)
    try:
        main(line.split())
    except SystemExit as ended:
        codes[name] = ended.code
    os.chdir(here)
with open("codes.json", "w") as file:
    json.dump(codes, file)
"""


@posix_only
@pytest.mark.slow
@pytest.mark.parametrize("commands", [COMMANDS, SLOW])
@pytest.mark.ci("commands0")
def test_every_command_works_with_stderr_closed(
    commands: Commands, tmp_path: Path, cache_of_the_session: Path
) -> None:
    """One process for all of them: the stream is closed before it starts."""
    (tmp_path / "all.py").write_text(QUICKLY + _ALL)
    cache = with_runtime(tmp_path / "cache", cache_of_the_session)
    ended = subprocess.run(
        ["sh", "-c", f"exec '{sys.executable}' all.py '{json.dumps(commands)}' 2>&-"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT), "LAMC_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert ended.returncode == 0, ended.stdout
    assert json.loads((tmp_path / "codes.json").read_text()) == dict.fromkeys(commands, 0), ended.stdout
    _, *printed = ended.stdout.split("===== ")
    assert [text.partition("\n")[0] for text in printed] == list(commands)
    assert all(text.partition("\n")[2] for text in printed)


@posix_only
@pytest.mark.parametrize("closed", [">&- 2>&-", "<&- >&- 2>&-", ">&-"])
@pytest.mark.quick("<&-*", others="campaign")
def test_results_hold_nothing_else_where_all_streams_are_closed(closed: str, tmp_path: Path) -> None:
    ended = shell(f"{COMMANDS['run']} {closed}", tmp_path)
    assert ended.returncode == 0, ended.stderr
    lines = (tmp_path / "o" / "results.csv").read_text().splitlines()
    assert lines[0].startswith("t (s),")
    assert len({line.count(",") for line in lines}) == 1


@posix_only
@pytest.mark.slow
def test_an_error_keeps_its_exit_code_where_nobody_can_be_told(tmp_path: Path) -> None:
    for closed in ("2>&-", ">&- 2>&-"):
        assert shell(f"run missing.yaml --out o {closed}", tmp_path).returncode == 2


@posix_only
@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_work_goes_on_where_stderr_cannot_be_written(tmp_path: Path) -> None:
    """It ended the run with an exit code of 0 and no results where a pipe had lost its reader."""
    ended = shell(f"{COMMANDS['run']} --no-pictures 2>/dev/full", tmp_path)
    assert ended.returncode == 0, ended.stdout
    assert (tmp_path / "o" / "manifest.json").exists()
    reader, writer = os.pipe()
    os.close(reader)
    lost = subprocess.run(
        [sys.executable, "-m", "lamc", *COMMANDS["run"].split(), "--no-pictures"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=writer,
    )
    os.close(writer)
    assert lost.returncode == 0
    assert b"files" in lost.stdout


def test_a_python_without_streams_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """As pythonw is: numbers of files may be there, streams are not."""
    for name in ("stdin", "stdout", "stderr"):
        monkeypatch.setattr(sys, name, None)
    with pytest.raises(SystemExit) as ended:
        main(["split", "--example", "flaps", "--out", str(tmp_path / "o")])
    assert ended.value.code == 0
    assert (tmp_path / "o" / "split.png").exists()


def test_streams_that_are_there_are_left_alone() -> None:
    assert "lamc" in CliRunner().invoke(main, ["--version"]).output

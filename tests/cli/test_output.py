"""Where results for people and programs cannot be printed, and what options say twice: told in one line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from lamc.cli import main

FULL = Path("/dev/full")  # takes nothing, as a disk without room


@pytest.mark.skipif(not FULL.exists(), reason="no device that is always full")
@pytest.mark.parametrize("arguments", [["schema"], ["--help"], ["examples", "pendulum", "--json"]])
@pytest.mark.quick("arguments0", others="campaign")
def test_a_full_disk_under_stdout_is_no_bug_of_lamc(arguments: list[str]) -> None:
    with FULL.open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "lamc", *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            stdin=subprocess.DEVNULL,
            text=True,
            check=False,
        )
    reported = [line for line in done.stderr.splitlines() if not line.endswith("…")]
    reason = os.strerror(28)  # ENOSPC
    assert reported == [f"error: standard output cannot be written: {reason}; send it elsewhere"]
    assert done.returncode == 2


@pytest.mark.parametrize(
    ("options", "reported"),
    [
        (
            ["--set", "left.stiffness=1", "--set", "left.stiffness=2"],
            "--set gives 'left.stiffness' twice, '1' and '2'",
        ),
        (["--angle", "left=0.1", "--angle", "left=20 deg"], "--angle gives 'left' twice, '0.1' and '20 deg'"),
        (["--rate", "left=1", "--rate", "left=1"], "--rate gives 'left' twice, '1' and '1'"),
    ],
)
def test_an_option_that_says_two_things_of_one_name_is_refused(
    options: list[str], reported: str, tmp_path: Path
) -> None:
    arguments = ["run", "--example", "flaps", "--t-end", "0", "--quiet"]
    result = CliRunner().invoke(main, [*arguments, "--out", str(tmp_path / "o"), *options])
    assert result.exit_code == 2
    assert reported in result.output
    assert "keep one of them" in result.output

"""`lamc modes`: a table, files and a picture; errors of one line."""

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image

from lamc.cli import main
from tests.support.ctools import needs_cc

pytestmark = needs_cc


@pytest.fixture(autouse=True)
def here(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if "painted" not in request.fixturenames:
        request.getfixturevalue("unpainted")
    monkeypatch.chdir(tmp_path)


def call(*words: str) -> Result:
    return CliRunner().invoke(main, ["modes", *words], catch_exceptions=False)


def test_it_prints_the_equilibrium_and_writes_what_it_says() -> None:
    result = call("--example", "four_bar")
    assert result.exit_code == 0, result.stderr
    assert "equilibrium  stable: all directions are held (projected Hessian)" in result.stdout
    assert "arm 96.09 deg" in result.stdout
    folder = Path("out/four_bar_modes")
    assert sorted(path.name for path in folder.iterdir()) == ["modes.csv", "modes.json", "modes.png"]
    data = json.loads((folder / "modes.json").read_text(encoding="utf-8"))
    assert data["equilibrium"]["stable"] is True
    (mode,) = data["modes"]
    assert mode["angular_frequency"] == pytest.approx(2.0 * math.pi * mode["frequency"], rel=1e-14)
    assert f"{mode['frequency']:.5g}" in result.stdout
    head, row = csv.reader((folder / "modes.csv").read_text(encoding="utf-8").splitlines())
    assert float(row[head.index("frequency (Hz)")]) == mode["frequency"]


@pytest.mark.slow
@pytest.mark.usefixtures("painted")
def test_the_picture_shows_every_mode_at_both_ends() -> None:
    result = call("--example", "waterbomb", "--size", "120", "--amplitude", "15 deg")
    assert result.exit_code == 0, result.stderr
    with Image.open("out/waterbomb_modes/modes.png") as picture:
        pixels = np.asarray(picture.convert("RGB"))
    assert all((half < 255).any() for half in np.array_split(pixels, 2))  # two lines of modes
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 50  # bodies, and the faint ones behind them


@pytest.mark.usefixtures("painted")
def test_no_word_leaves_a_narrow_picture() -> None:
    assert call("--example", "four_bar", "--size", "120").exit_code == 0
    with Image.open("out/four_bar_modes/modes.png") as picture:
        sheet = np.asarray(picture.convert("L"))
    assert (sheet[:, :3] == 255).all()
    assert (sheet[:, -3:] == 255).all()


def test_start_parameters_and_choices_come_through() -> None:
    words = ("--example", "vertex", "--angle", "c1=-60 deg", "--set", "c2.stiffness=0.2 N*mm/rad")
    result = call(
        *words, "--undamped", "--stable", "--count", "1", "--no-pictures", "--out", "here", "--json"
    )
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    assert data["files"] == ["modes.json", "modes.csv"]
    assert data["damped"] is False
    assert data["parameters"]["c2.stiffness"] == pytest.approx(2e-4, rel=1e-15)
    assert data["equilibrium"]["way"] == "descended"
    assert data["modes"][0]["damping"] == 0.0


def test_loads_that_change_with_time_are_held_at_an_instant() -> None:
    refused = call("--example", "shutter")
    assert refused.exit_code != 0
    assert "depend on time" in refused.stderr
    assert "--at" in refused.stderr
    held = call("--example", "shutter", "--at", "10ms", "--no-pictures")
    assert held.exit_code == 0, held.stderr
    assert "loads are those at t = 0.01 s" in held.stdout


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--count", "0"), "--count is 0"),
        (("--set", "arm.stifness=1"), "arm.stiffness"),
        (("--amplitude", "20 mm"), "--amplitude"),
    ],
)
def test_bad_words_are_refused_in_one_line(words: tuple[str, ...], said: str) -> None:
    result = call("--example", "four_bar", *words)
    assert result.exit_code == 2
    assert said in result.stderr
    assert not Path("out").exists() or not any(Path("out").glob("*/modes.json"))

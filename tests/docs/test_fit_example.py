"""The recordings of the guide: three commands from a CSV file to a scene that runs, and what they should find."""

import json
import re
import runpy
import shlex
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from lamc.cli import main
from tests.support.ctools import needs_cc
from tests.support.paths import ROOT

pytestmark = [pytest.mark.usefixtures("unpainted"), needs_cc]


@pytest.mark.slow
def test_from_film_to_scene_as_a_reader_would(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("flap1.csv", "flap2.csv"):
        shutil.copy(ROOT / "docs" / name, tmp_path)
    page = (ROOT / "docs/guide/fit.md").read_text(encoding="utf-8")
    command = re.search(r"^lamc (fit --example .*)$", page, re.MULTILINE)
    scene = re.search(r"`lamc (run --example flaps --scene \S+)`", page)
    assert command is not None
    assert scene is not None
    looked = CliRunner().invoke(
        main, ["split", "--example", "flaps", "--out", "looked", "--quiet"]
    )  # names of bodies
    assert looked.exit_code == 0, looked.output
    found = CliRunner().invoke(main, [*shlex.split(command[1]), "--json"])
    assert found.exit_code == 0, found.output
    hidden = runpy.run_path(str(ROOT / "docs/make_fit_data.py"))
    data = json.loads(found.stdout)
    numbers = {each["name"]: each for each in data["numbers"]}
    true = {**hidden["HIDDEN"], "flap1.delay": hidden["DELAY"], "camera.scale": hidden["SCALE"]}
    for name, value in true.items():
        low, high = numbers[name]["low"], numbers[name]["high"]
        margin = 0.5 * (high - low)  # 4 standard errors in all: one in 15 000 is beyond
        assert low - margin < value < high + margin, name
        assert high - low < 0.5 * value
    held = next(each for each in data["recordings"] if each["held_back"])
    assert held["rms"]["tip.y"] < 1.5 * hidden["NOISE"]  # noise, and what a start that is found anew leaves
    ran = CliRunner().invoke(main, [*shlex.split(scene[1]), "--json", "--no-pictures"])
    assert ran.exit_code == 0, ran.output
    assert json.loads(ran.stdout)["parameters"]["right.stiffness"] == numbers["right.stiffness"]["value"]


def test_the_recordings_are_those_of_their_script(tmp_path: Path) -> None:
    made = runpy.run_path(str(ROOT / "docs/make_fit_data.py"))
    made["main"].__globals__["FOLDER"] = tmp_path
    made["main"]()
    for name in ("flap1.csv", "flap2.csv"):
        kept = (ROOT / "docs" / name).read_text(encoding="utf-8").splitlines()
        again = (tmp_path / name).read_text(encoding="utf-8").splitlines()
        assert kept[0].startswith("# Made by docs/make_fit_data.py from a simulated camera")
        assert kept[:2] == again[:2]
        for one, other in zip(kept[2:], again[2:], strict=True):
            cells = list(zip(one.split(","), other.split(","), strict=True))
            assert all(a == b or abs(float(a) - float(b)) <= 0.011 for a, b in cells)  # the last digit

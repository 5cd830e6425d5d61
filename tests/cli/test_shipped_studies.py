"""The studies that ship: they run, and say what their stories say."""

import csv
import math
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from lamc.cli import main
from lamc.examples.study_files import names

pytestmark = pytest.mark.usefixtures("unpainted")


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def call(*words: str) -> Result:
    return CliRunner().invoke(main, ["sweep", "--workers", "1", "--quiet", "--out", "out", *words])


def rows() -> list[dict[str, str]]:
    with Path("out/table.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_leg_steps_farther_by_its_lengths() -> None:
    assert call("--study", "leg", "--vary", "arm=40mm,50mm", "--vary", "link=36mm,60mm").exit_code == 0
    found = {(row["arm (m)"], row["link (m)"]): row for row in rows()}
    assert found["0.05", "0.036"]["status"] == "refused"
    assert "no position closes the loops" in found["0.05", "0.036"]["reason"]
    assert float(found["0.05", "0.06"]["stride (m)"]) > float(found["0.04", "0.06"]["stride (m)"]) > 0.005


def test_many_geometries_leave_one_module_and_no_notes_in_the_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = tmp_path / "cache"  # its own: the tests that run beside this one add to the shared one
    monkeypatch.setenv("LAMC_CACHE_DIR", str(cache))
    words = ("--study", "leg", "--vary", "link=48mm,50mm")
    assert call(*words, "--vary", "arm=40mm,41mm").exit_code == 0
    before = sorted(path.name for path in cache.iterdir())
    found = CliRunner().invoke(
        main, ["sweep", "--quiet", *words, "--vary", "arm=42mm:44mm:4", "--out", "more"]
    )
    assert found.exit_code == 0, found.output
    assert sorted(path.name for path in cache.iterdir()) == before


@pytest.mark.slow
def test_a_spring_stores_what_its_angle_says_and_a_jump_is_lower_than_that() -> None:
    assert (
        call("--study", "jump", "--vary", "spring=5,10 N*mm/rad", "--vary", "leg=20 mm").exit_code == 2
    )  # 5 N*m/rad
    assert call("--study", "jump", "--vary", "spring=0.005,0.01", "--vary", "leg=20 mm").exit_code == 0
    mass = 0.08 * 0.03 * (2 * 0.5e-3 * 700 + 25e-6 * 1420)  # kg, but for the two gaps
    for row in rows():
        stored = 2 * 0.5 * float(row["spring (N·m/rad)"]) * math.radians(60.0) ** 2
        assert float(row["stored (J)"]) == pytest.approx(stored, rel=1e-12)
        assert 0.0 < float(row["height (m)"]) < stored / (mass * 9.81)
    assert float(rows()[1]["height (m)"]) > 1.5 * float(rows()[0]["height (m)"])


def test_the_pitch_of_a_wing_follows_from_one_of_its_flexures() -> None:
    words = (
        "--study",
        "wing",
        "--sample",
        "saltelli:4",
        "--t-end",
        "20 ms",
        "--measure",
        "turned=last(pitch)",
    )
    found = CliRunner().invoke(main, ["sweep", "--workers", "1", "--out", "out", *words])
    assert found.exit_code == 0, found.output
    assert "Sobol' indices" in found.stdout
    assert len(rows()) == 4 * 5


@pytest.mark.slow
@pytest.mark.parametrize("name", names())
def test_each_runs_as_it_is(name: str) -> None:
    assert call("--study", name, "--resume").exit_code == 0
    assert sum(row["status"] == "ok" for row in rows()) > 0.9 * len(rows())
    assert Path("out/study.png").stat().st_size > 0


def test_each_can_be_copied_and_runs_there() -> None:
    assert names() == ("jump", "leg", "wing")
    assert call("--study", "leg", "--copy", "mine").exit_code == 0
    assert sorted(path.name for path in Path("mine").iterdir()) == ["leg.yaml", "leg_study.yaml"]
    assert call("mine/leg_study.yaml", "--vary", "arm=40 mm", "--vary", "link=48 mm").exit_code == 0
    again = call("--study", "leg", "--copy", "mine")
    assert again.exit_code == 2
    assert "is there already" in again.output


def test_words_that_name_two_studies_are_refused() -> None:
    for words, told in (
        (("--study", "legg"), "did you mean 'leg'?"),
        (("--study", "leg", "--example", "flaps"), "leave out --example flaps"),
        (("--copy", "mine"), "--copy needs --study NAME: jump, leg, wing"),
    ):
        found = call(*words)
        assert found.exit_code == 2
        assert told in found.output

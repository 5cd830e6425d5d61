"""`lamc fit` as a user meets it: from CSV to a scene that runs, held-back recordings, one-line errors."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import lamc
from lamc.cli import main
from tests.cli.test_sweep_command import ROD
from tests.support.ctools import needs_cc

pytestmark = [pytest.mark.usefixtures("unpainted"), needs_cc]

STIFFNESS, DAMPING, DELAY = 3.0, 0.05, 0.007


@pytest.fixture(autouse=True)
def _recordings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two recordings of the rod at 60 frames a second: angles in degrees, and a marker in pixels, some frames lost."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rod.yaml").write_text(ROD, encoding="utf-8")
    design = lamc.load(tmp_path / "rod.yaml")
    t = np.arange(121) / 60.0
    for k, angle in enumerate((0.5, -0.8)):
        point = lamc.OutputPoint("m", "link", (0.9, 0.0, 0.0))
        sim = lamc.compile(design, lamc.Scene(angles={"h1": angle}, outputs=(point,)))  # type: ignore[arg-type]
        run = sim.run(t_end=2.0, t_eval=t, parameters={"h1.stiffness": STIFFNESS, "h1.damping": DAMPING})
        rng = np.random.default_rng(k)
        seen = np.degrees(run.angle("h1")) + 0.2 * rng.normal(size=121)
        p = run.point("m")
        u, v = (300.0 * c + o + 0.3 * rng.normal(size=121) for c, o in ((p[:, 0], 320.0), (-p[:, 2], 240.0)))
        lines = ["t [s],angle [deg],spot.x [px],spot.y [px],light"]
        for i in range(121):
            dropped = i % 10 == 4
            cells = [
                f"{t[i] + DELAY:.6f}",
                *(["", "", ""] if dropped else [f"{x[i]:.4f}" for x in (seen, u, v)]),
                "1",
            ]
            lines.append(",".join(cells))
        (tmp_path / f"run{k + 1}.csv").write_text("\n".join(lines), encoding="utf-8")


def call(*words: str) -> Result:
    return CliRunner().invoke(main, list(words), catch_exceptions=False)


FIT = (
    "fit",
    "rod.yaml",
    "--map",
    "angle=h1",
    "--free",
    "h1.stiffness",
    "--free",
    "h1.damping",
    "--free",
    "delay=0:20ms",
)


@pytest.mark.slow
def test_from_csv_to_a_scene_that_runs() -> None:
    film = ("--film", "--size", "96", "--camera", "front")
    said = call(*FIT, "--data", "run1.csv", "--angle", "h1=0.5", "--out", "found", "--json", *film)
    assert said.exit_code == 0, said.output
    data = json.loads(said.stdout)
    numbers = {each["name"]: each for each in data["numbers"]}
    for name, true in (("h1.stiffness", STIFFNESS), ("h1.damping", DAMPING), ("run1.delay", DELAY)):
        each = numbers[name]
        assert (
            each["low"] - 0.5 * (each["high"] - each["low"])
            < true
            < each["high"] + 0.5 * (each["high"] - each["low"])
        )
    *files, film_file = data["files"]
    assert sorted(files) == ["fit.html", "fit.json", "overlay.png", "residuals.png", "scene.yaml"]
    assert film_file in ("overlay.mp4", "overlay.gif")  # as this machine has it
    assert all((Path("found") / name).stat().st_size for name in data["files"])
    ran = call(
        "run",
        "rod.yaml",
        "--scene",
        "found/scene.yaml",
        "--t-end",
        "1",
        "--no-pictures",
        "--out",
        "ran",
        "--json",
    )
    assert ran.exit_code == 0, ran.output
    assert json.loads(ran.stdout)["parameters"]["h1.stiffness"] == numbers["h1.stiffness"]["value"]
    assert json.loads(ran.stdout)["angles"] == {"h1": 0.5}


def test_a_camera_of_unknown_place_and_a_recording_held_back() -> None:
    words = (
        "--data",
        "run1.csv",
        "--data",
        "run2.csv",
        "--hold-out",
        "run2.csv",
        "--map",
        "spot=link@(0.9, 0, 0)",
    )
    said = call(*FIT, *words, "--frame", "x,-z", "--free", "angles.h1=-1.5:1.5", "--json", "--no-pictures")
    assert said.exit_code == 0, said.output
    data = json.loads(said.stdout)
    values = {each["name"]: each["value"] for each in data["numbers"]}
    assert values["camera.scale"] == pytest.approx(300.0, rel=0.01)  # 0.3 of 300 pixels, 100 rows
    assert values["camera.origin_x"] == pytest.approx(320.0, abs=1.0)
    assert values["run1.angles.h1"] == pytest.approx(0.5, abs=0.01)
    held = next(each for each in data["recordings"] if each["name"] == "run2")
    assert held["held_back"]
    assert held["of_variance"]["h1"] < 0.001


@pytest.mark.parametrize(
    ("text", "words", "message"),
    [
        ("t [s],h1 [mm]\n0,1\n0.1,2\n", (), "bad.csv.*'h1'.*is in 'mm', which is not an angle: rad, deg"),
        ("t [s],a [px]\n0,1\n0.1,2\n", ("--map", "a=h1"), "'a', as 'h1' of the model, is in 'px'"),
        ("t [s],m.x [deg]\n0,1\n0.1,2\n", ("--map", "m=link@(1,0,0)"), "is in 'deg', which is not a length"),
        ("t,h1\n0,20\n0.1,22\n", (), "'h1' reaches 22, and its heading says no unit; are these degrees"),
        ("t [s],h1\n0,\n0.1,nan\n", (), "bad holds no numbers to compare: h1 is empty in all of its rows"),
        ("t [s],h1\n0,1\n0.1,1\n", ("--frame", "x,-z"), "--frame is of markers, and no --map"),
        (
            "t [s],h1\n0,1\n0.1,1\n",
            ("--map", "m=link@(1,0,0)"),
            "no such column or marker; its columns are h1",
        ),
        ("t [s],m.x\n0,1\n0.1,1\n", ("--map", "m=lynk@(1,0,0)"), "on 'lynk', and there is no such body"),
        ("t [s],m.x\n0,640\n0.1,641\n", ("--map", "m=link@(1,0,0)"), "640.5 m and the like.*mm or pixels"),
        ("t [s],h1\n0,0.5\n", (), "there are 1 rows"),
        ("t [s],h1\n0,1\n0.1,1\n", ("--free", "delay=0:2s"), "its delay may be up to 2 s: narrow it"),
        ("t [s],h1\n-2,1\n-1,1\n", (), "before the run starts at 0 s of its clock; shift its times"),
    ],
)
def test_files_that_do_not_fit_are_told_in_a_line(text: str, words: tuple[str, ...], message: str) -> None:
    Path("bad.csv").write_text(text, encoding="utf-8")
    said = call("fit", "rod.yaml", "--quiet", "--data", "bad.csv", "--free", "h1.stiffness", *words)
    assert said.exit_code == 2, said.output
    assert len(said.stderr.strip().splitlines()) == 1
    assert re.search(message, said.stderr), said.stderr


@pytest.mark.parametrize("words", [("--film", "--camera", "sidee"), ("--camera", "sidee"), ("--size", "3")])
def test_a_view_that_is_none_is_told_before_anything_is_read(words: tuple[str, ...]) -> None:
    said = call("fit", "rod.yaml", "--data", "nowhere.csv", "--free", "h1.stiffness", *words)
    assert said.exit_code == 2
    assert "nowhere.csv" not in said.output
    assert f"{words[-2][2:]} is" in said.stderr
    assert "bug" not in said.stderr
    assert len(said.stderr.strip().splitlines()) == 1


def test_an_empty_column_is_left_out_with_a_word(recwarn: pytest.WarningsRecorder) -> None:
    lines = Path("run1.csv").read_text(encoding="utf-8").splitlines()
    text = "\n".join(f"{line},{'h1.rate' if k == 0 else 'nan'}" for k, line in enumerate(lines))
    Path("more.csv").write_text(text, encoding="utf-8")
    said = call(*FIT, "--data", "more.csv", "--angle", "h1=0.5", "--no-pictures", "--json")
    assert said.exit_code == 0, said.output
    data = json.loads(said.stdout)
    assert "more: h1.rate is empty in all rows, and left out" in data["notes"]
    assert list(data["recordings"][0]["rms"]) == ["h1"]
    assert not [w for w in recwarn if issubclass(w.category, RuntimeWarning)]


def test_the_scene_starts_as_its_one_recording_does() -> None:
    """The start that was found had been left out, and what the summary says to run moved otherwise."""
    start = ("--free", "angles.h1=-2:2", "--no-pictures", "--out")
    said = call(*FIT, *start, "one", "--data", "run1.csv", "--json")
    assert said.exit_code == 0, said.output
    found = {each["name"]: each["value"] for each in json.loads(said.stdout)["numbers"]}["run1.angles.h1"]
    assert found == pytest.approx(0.5, abs=0.01)  # noise of 0.2 degrees
    assert (
        call("run", "rod.yaml", "--scene", "one/scene.yaml", "--out", "run", "--no-pictures").exit_code == 0
    )
    assert np.load("run/results.npz")["angles"][0, 0] == pytest.approx(found, rel=1e-12)
    both = call(*FIT, *start, "two", "--data", "run1.csv", "--data", "run2.csv")
    assert both.exit_code == 0, both.output
    remarks = Path("two/scene.yaml").read_text(encoding="utf-8")
    starts = dict(re.findall(r"^# (run\d) starts at angles\.h1 = (\S+) rad$", remarks, re.MULTILINE))
    assert float(starts["run1"]) == pytest.approx(0.5, abs=0.01)
    assert float(starts["run2"]) == pytest.approx(-0.8, abs=0.01)
    assert "angles:" not in remarks


def test_the_summary_names_what_was_found() -> None:
    said = call(*FIT, "--data", "run1.csv", "--angle", "h1=0.5", "--no-pictures")
    assert "95 % interval" in said.stdout
    assert "not read   light, spot.x, spot.y" in said.stdout
    assert "--scene out/rod_fit/scene.yaml" in said.stdout


def test_what_would_tell_more_is_said() -> None:
    said = call(
        *FIT, "--data", "run1.csv", "--angle", "h1=0.5", "--no-pictures", "--design", "link.z", "--json"
    )
    assert said.exit_code == 0, said.output
    (each,) = json.loads(said.stdout)["candidates"]
    assert (each["name"], each["unit"]) == ("link.z", "m")
    assert each["shrinks"] > 1.0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--free", "h1.stiffness"), "name recordings with --data"),
        (("--data", "run1.csv", "--map", "angle=h1"), "nothing is free"),
        (("--data", "nowhere.csv", "--free", "h1.stiffness"), "nowhere.csv"),
        (("--data", "run1.csv", "--free", "h1.stiffness"), "no column that the model knows"),
        (("--data", "run1.csv", "--free", "h1.stiffness", "--map", "angel=h1"), "did you mean 'angle'"),
        (
            ("--data", "run1.csv", "--free", "h1.stiffness", "--map", "spot=link@(1,0,0)"),
            "in pixels.*--frame x,-z",
        ),
        (
            ("--data", "run1.csv", "--free", "h1.stiffness", "--map", "angle=h1", "--free", "delay"),
            "needs a range",
        ),
        (("--data", "run1.csv", "--data", "run1.csv", "--free", "h1.stiffness"), "twice"),
        (
            ("--data", "run1.csv", "--hold-out", "run1.csv", "--free", "h1.stiffness", "--map", "angle=h1"),
            "held back",
        ),
        (("--data", "run1.csv", "--free", "h1.stiffness=3:2", "--map", "angle=h1"), "runs backwards"),
    ],
)
def test_errors_are_one_line(words: tuple[str, ...], message: str) -> None:
    said = call("fit", "rod.yaml", "--quiet", *words)
    assert said.exit_code == 2, said.output
    assert len(said.stderr.strip().splitlines()) == 1
    assert re.search(message, said.stderr), said.stderr

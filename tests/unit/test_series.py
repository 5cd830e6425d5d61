"""Series: what they refuse, how they are read from CSV files and scenes, and what is told of mistakes."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

import lamc
from lamc import Input, Scene, Series
from lamc.basics.errors import DesignError, LamcError
from lamc.cli import main
from lamc.effects import Torque
from lamc.readers.load_scene import scene_of_text
from lamc.readers.scene_writer import scene_data
from lamc.readers.schema import json_schema
from lamc.readers.series_file import read_columns
from tests.support.ctools import needs_cc
from tests.support.quick import tries

T, V = [0.0, 0.5, 2.0], [1.0, -1.0, 3.0]


@pytest.mark.parametrize(
    ("t", "values", "more", "said"),
    [
        (
            [0, 1, 1],
            [1, 2, 3],
            {},
            r"t\[2\] = 1 s of a series repeats t\[1\] = 1 s; two values at one time are a jump",
        ),
        ([0, 2, 1], [1, 2, 3], {}, r"t\[2\] = 1 s of a series is before t\[1\] = 2 s; time must ascend"),
        (
            [0, 1, 2],
            [1, float("nan"), 3],
            {},
            r"values of a series holds nan at 1 \(1 of 3\); leave gaps out",
        ),
        ([0, float("inf")], [1, 2], {}, "t of a series holds inf at 1"),
        ([0, 1], [1], {}, "a series has 2 times and 1 values"),
        ([0], [1], {}, "a series has 1 rows; give 2 at least"),
        ([], [], {"beyond": "hold"}, "a series has 0 rows; give 1 at least"),
        ([[0, 1]], [1, 2], {}, r"t of a series has shape \(1, 2\); it must be a row"),
        ("soon", [1, 2], {}, "t of a series is 'soon'; it must be a row of numbers"),
        ([0, 1], [1, 2], {"hold": "lineal"}, "hold of a series is 'lineal'; did you mean 'linear'?"),
        ([0, 1], [1, 2], {"hold": 3}, "hold of a series is 3; there are previous, linear, cubic"),
        ([0, 1], [1, 2], {"beyond": "extrapolate"}, "beyond of a series is 'extrapolate'"),
    ],
)
def test_what_is_no_series_is_refused(t: object, values: object, more: dict[str, object], said: str) -> None:
    with pytest.raises(DesignError, match=said):
        Series(t, values, **more)  # type: ignore[arg-type]


def test_a_series_is_equal_by_what_it_holds_and_cannot_change() -> None:
    a, b = Series(T, V), Series(np.array(T), tuple(V))
    assert a == b
    assert hash(a) == hash(b)
    assert a != Series(T, V, "cubic")
    assert pickle.loads(pickle.dumps(a)) == a
    with pytest.raises(ValueError, match="read-only"):
        a.values[0] = 2.0
    with pytest.raises(ValueError, match="read-only"):
        pickle.loads(pickle.dumps(a)).values[0] = 2.0
    assert repr(a) == "<Series of 3 rows, 0 … 2 s, linear>"


def test_values_between_and_beyond_are_those_of_numpy_and_scipy() -> None:
    rng = np.random.default_rng(1)
    t = np.cumsum(rng.exponential(size=40) + 0.01)
    values = rng.standard_normal(40)
    within = rng.uniform(t[0], t[-1], 200)
    assert Series(t, values).at(within) == pytest.approx(np.interp(within, t, values), rel=1e-12)
    spline = make_interp_spline(t, values, k=3)  # not-a-knot by default, from another basis
    for order in range(4):
        # bases differ in round-off, which a derivative magnifies by 1 / 0.01 each time
        found = Series(t, values, "cubic").at(within, order)
        assert found == pytest.approx(spline.derivative(order)(within) if order else spline(within), rel=1e-6)
    assert np.isnan(Series(t, values).at([t[0] - 1.0, t[-1] + 1.0])).all()
    held = Series(t, values, "cubic", "hold")
    assert held.at([t[0] - 1.0, t[-1] + 1.0]).tolist() == [values[0], values[-1]]
    assert held.at([t[0], t[-1]], 1) == pytest.approx([0.0, 0.0], abs=1e-9)  # clamped: a sum of a few terms


def csv(tmp_path: Path, text: str | bytes) -> Path:
    path = tmp_path / "bench.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    "text",
    [
        "t,cmd\n0,1\n0.5,-1\n2,3\n",
        "0,1\n0.5,-1\n2,3",
        "\ufefft;cmd\r\n0;1\r\n0,5;-1,0\r\n2;3,0\r\n",  # as European spreadsheets write it
        "# bench 3\nt\tcmd\n\n0\t1\n0.5\t-1 # odd\n2\t3\n",
        '"time [s]","cmd [1]"\n"0","1"\n"0.5","-1"\n"2","3"\n',
        "cmd  time\n1 0\n-1 0.5\n3 2e0\n",
        "t,cmd\n0,1\n0.5,-1\n2,3\n".encode("utf-16"),
    ],
)
def test_what_spreadsheets_write_is_read(tmp_path: Path, text: str | bytes) -> None:
    found = read_columns(csv(tmp_path, text), None, None)
    assert found.t.tolist() == T
    assert found.values.tolist() == V


@pytest.mark.parametrize(
    ("text", "column", "said"),
    [
        (
            "t,a,b\n0,1,2\n1,2,3\n",
            None,
            "2 columns beside the time's; say by column which is meant: there are t, a, b",
        ),
        ("t,angel,b\n0,1,2\n1,2,3\n", "angle", "no column is called 'angle'; did you mean 'angel'?"),
        ("t,a,b\n0,1,2\n1,2,3\n", 7, "column is 7; the file has columns 1 to 3"),
        ("t,a,a\n0,1,2\n1,2,3\n", "a", "2 columns are called 'a'"),
        ("0,1,2\n1,2,3\n", "a", "the file has no heading"),
        ("t,a\n0,1\n1,2\n0.5,3\n", None, r":4: the time 0.5 runs backwards: it is before 1 of line 3"),
        ("t,a\n0,1\n1,2\n\n1,3\n", None, r":5: the time 1 repeats 1 of line 3"),
        ("t,a\n0,1\n1,nan\n2,3\n3,\n", None, r":3: a row has no number here, and 1 more; say gaps: bridge"),
        ("t,a\n0,1\n1,2,3\n", None, r":3: a line of 3 columns, where the first has 2; decimal commas need"),
        ("t,a\n0,0,5\n1,0,7\n", None, r":2: a line of 3 columns"),
        ("t,a\n0,1\n1,__import__('os')\n", None, r":3: \"__import__\('os'\)\" is no number"),
        ("t,a\n0,1\n1,0x10\n", None, r":3: '0x10' is no number"),
        ("t;a\n0;1,5\n1;1.234,5\n", None, r":3: '1.234,5' has a point and a comma"),
        ("t,a\n0,1\n1,1e999\n", None, "a number is larger than a double holds"),
        ("", None, "the file is empty"),
        ("t,a\n", None, "the file has no rows of numbers"),
        (b"\xff\xff\x00", None, "not UTF-8"),
    ],
)
def test_mistakes_in_a_file_are_told_with_their_line(
    tmp_path: Path, text: str | bytes, column: str | int | None, said: str
) -> None:
    path = csv(tmp_path, text)
    with pytest.raises(DesignError, match=said) as caught:
        read_columns(path, column, None)
    assert str(caught.value).startswith(str(path))


def test_gaps_are_bridged_if_asked(tmp_path: Path) -> None:
    found = read_columns(csv(tmp_path, "t,a\n0,1\n1,NaN\n2,3\n,4\n5,\n"), None, None, gaps="bridge")
    assert found.t.tolist() == [0.0, 2.0]


def test_a_file_beyond_the_limit_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lamc.readers.series_file.MAX_BYTES", 10)
    with pytest.raises(DesignError, match="larger than the limit 'bytes' of 10"):
        read_columns(csv(tmp_path, "t,a\n0,1\n1,2\n"), None, None)
    monkeypatch.undo()
    monkeypatch.setattr("lamc.readers.series_file.MAX_ROWS", 10)
    with pytest.raises(DesignError, match="at most 10 are read"):
        read_columns(csv(tmp_path, "".join(f"{k},{k}\n" for k in range(200))), None, None)


def test_a_file_that_changes_is_read_again(tmp_path: Path) -> None:
    path = csv(tmp_path, "t,a\n0,1\n1,2\n")
    assert read_columns(path, None, None).values.tolist() == [1.0, 2.0]
    path.write_text("t,a\n0,1\n1,25\n")
    assert read_columns(path, None, None).values.tolist() == [1.0, 25.0]


@given(
    text=st.one_of(
        st.binary(max_size=200), st.text(alphabet='0123456789.,;eE+-tna \t\n"#[]()ms', max_size=200)
    )
)
@example(text="t,a\n0,1\n1,2\n")
@example(text='"')
@example(text="0E;")
@example(text="0\n1\n")
@example(text="t,a\n0,1e5\n1,1_0\n")
@settings(max_examples=tries(200), deadline=None)
def test_no_file_does_more_than_be_read_or_refused(
    text: str | bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = csv(tmp_path_factory.mktemp("fuzz"), text)
    try:
        found = read_columns(path, None, None)
    except LamcError:
        return
    assert (np.diff(found.t) > 0.0).all()
    assert np.isfinite(found.values).all()


@given(
    rows=st.lists(
        st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)), min_size=1, unique_by=lambda row: row[0]
    )
)
@settings(max_examples=tries(50), deadline=None)
def test_numbers_are_read_to_the_last_bit(
    rows: list[tuple[float, float]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    rows = sorted(rows)
    text = "".join(f"{t!r},{v!r}\n" for t, v in rows)
    found = read_columns(csv(tmp_path_factory.mktemp("bits"), text), None, None)
    assert list(zip(found.t.tolist(), found.values.tolist(), strict=True)) == rows


SCENE = "effects: {{torque: {{h: command}}}}\ninputs:\n  command: {}\n"


def scene_of(tmp_path: Path, said: str) -> Scene:
    (tmp_path / "scene.yaml").write_text(SCENE.format(said))
    return lamc.load_scene(tmp_path / "scene.yaml")


def test_a_scene_names_a_file_with_its_units(tmp_path: Path) -> None:
    csv(tmp_path, "t [ms];cmd [N*mm]\n0;1\n500;-1\n2000;3\n")
    series = (
        scene_of(tmp_path, "{csv: bench.csv, column: cmd, hold: cubic, beyond: hold}")
        .inputs["command"]
        .series
    )
    assert series is not None
    assert series.t.tolist() == T
    assert series.values == pytest.approx([1e-3, -1e-3, 3e-3], rel=1e-15)
    assert (series.hold, series.beyond, series.source) == ("cubic", "hold", "bench.csv")
    assert scene_of(tmp_path, "{csv: bench.csv}").inputs["command"].unit == "N·m"
    csv(tmp_path, "a,b\n0,90\n1,180\n")
    turned = scene_of(tmp_path, "{csv: bench.csv, column: 2, unit: deg, time_unit: min}").inputs["command"]
    assert turned.series is not None
    assert turned.unit == "rad"
    assert turned.series.values == pytest.approx([np.pi / 2, np.pi], rel=1e-15)
    assert turned.series.t.tolist() == [0.0, 60.0]


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ("{csv: bench.csv, columm: cmd}", r"scene.yaml:3:3\d: .*no field 'columm'; did you mean 'column'"),
        ("{csv: bench.csv, hold: cubical}", r"scene.yaml:3:3\d: .*hold is 'cubical'; did you mean 'cubic'"),
        (
            "{csv: bench.csv, column: cmb}",
            r"scene.yaml:3:\d+: .*no column is called 'cmb'; did you mean 'cmd'",
        ),
        (
            "{csv: bench.csv, unit: mm}",
            r"scene.yaml:3:\d+: .*unit is 'mm', and the heading of the file says 'deg'",
        ),
        ("{csv: bench.csv, unit: florins}", r"scene.yaml:3:\d+: .*unit: .*florins"),
        (
            "{csv: bench.csv, time_unit: mm}",
            r"scene.yaml:3:\d+: .*the unit of time is 'mm', which is no time",
        ),
        ("{csv: bunch.csv}", r"there is no such file; did you mean '.*bench.csv'"),
        ("{csv: bench.csv, default: 3}", r"no field 'default'"),
        ("{csv: bench.csv, t: [0, 1]}", r"t stands beside csv"),
        ("{t: [0, 1]}", r"a series has no values"),
        ("{t: [0, 1, 1], values: [0, 1, 2]}", r"scene.yaml:3:\d+: .*repeats"),
        ("{t: [0, one], values: [0, 1]}", r"scene.yaml:3:\d+: .*must be a list of numbers"),
        ("{t: [0, 1], values: [0, 1], column: 3}", r"column is about a csv file"),
        ("{csv: [1]}", r"csv is \[1\]; it must be the path"),
        ("{csv: bench.csv, column: true}", r"column is True; give the name"),
    ],
)
def test_mistakes_in_a_scene_are_told_with_their_place(tmp_path: Path, said: str, message: str) -> None:
    csv(tmp_path, "t,cmd [deg]\n0,1\n1,2\n")
    with pytest.raises(DesignError, match=message):
        scene_of(tmp_path, said)


def test_a_base_that_follows_kinks_is_refused_at_its_line(tmp_path: Path) -> None:
    csv(tmp_path, "t,z [mm]\n0,1\n1,2\n")
    text = "effects:\n  base_motion: {displacement: [0, 0, path]}\ninputs:\n  path: {csv: bench.csv, hold: linear}\n"
    (tmp_path / "scene.yaml").write_text(text)
    with pytest.raises(DesignError, match=r"scene.yaml:4:\d+: .*'path' holds 'linear' .*take hold: cubic"):
        lamc.load_scene(tmp_path / "scene.yaml")


def test_a_scene_is_written_as_it_is_read() -> None:
    scene = Scene(
        effects=(Torque({"h": "command + bias"}),),
        inputs={
            "command": Input(unit="N*m", meaning="of the bench", series=Series(T, V, "cubic", "hold")),
            "bias": Input(0.1, "N*m"),
        },
    )
    assert scene_of_text(json.dumps(scene_data(scene)), "scene.yaml") == scene
    long = Series(np.arange(20_000.0), np.zeros(20_000))
    with pytest.raises(DesignError, match="keep it in a CSV file"):
        scene_data(Scene(effects=(Torque({"h": "c"}),), inputs={"c": Input(series=long)}))


def test_the_schema_describes_series() -> None:
    text = json.dumps(json_schema())
    assert "time_unit" in text
    assert "previous" in text


def test_an_input_has_a_series_or_a_default() -> None:
    with pytest.raises(DesignError, match="an input has a series and the default 1"):
        Input(1.0, series=Series(T, V))
    with pytest.raises(DesignError, match=r"make one with lamc.Series\(t, values\)"):
        Input(series=[1, 2])  # type: ignore[arg-type]
    with pytest.raises(DesignError, match=r"an input is named .knee\.torque."):
        Scene(effects=(Torque({"h": "1"}),), inputs={"knee.torque": Input()})


@needs_cc
def test_a_command_runs_on_a_recording_and_knows_it_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    csv(tmp_path, "t [ms];cmd [N*m]\n0;0\n500;5,5\n1000;0\n")
    text = "scene:\n  with: {torque: {h1: command}}\n  inputs: {command: {csv: bench.csv}}\n  duration: 1 s\n"
    (tmp_path / "scene.yaml").write_text(text)
    runner = CliRunner()
    asked = ["run", "--example", "pendulum", "--scene", "scene.yaml", "--out", "out", "--no-pictures"]
    done = runner.invoke(main, asked)
    assert done.exit_code == 0, done.output
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert set(manifest["series"]) == {"command"}
    built = runner.invoke(main, ["build", "--example", "pendulum", "--scene", "scene.yaml", "--out", "built"])
    assert built.exit_code == 0, built.output
    assert "series_0_rows" in (tmp_path / "built" / "pendulum.c").read_text()
    csv(tmp_path, "t [ms];cmd [N*m]\n0;0\n500;5,6\n1000;0\n")
    again = runner.invoke(main, ["view", "out"])
    assert again.exit_code != 0
    assert "follows another series than when this was run" in again.output

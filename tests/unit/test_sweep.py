"""Sweeps: what a point gives, whoever computes it and however often it is stopped; and what is refused beforehand."""

import json
import math
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.basics.errors import DesignError, LamcError, RequestError
from lamc.studies.axes import Listed, Span, axis_of
from lamc.studies.bench import RunOptions
from lamc.studies.making import study_of
from lamc.studies.plans import Grid, given_points, sampled
from lamc.studies.storage import ROWS, opened
from lamc.studies.study import Study
from lamc.studies.sweep import sweep
from tests.support import studied
from tests.support.paths import ROOT

FAST = RunOptions(t_end=0.1, rtol=1e-6, rows=101)
MEASURES = {"end": "last(hip)", "fast": "max(abs(hip.rate))"}


def study(vary, measure=MEASURES, run=FAST, design=studied.rod, **more) -> Study:
    return study_of(design, vary, measure, run=run, **more)


def csv(table, path: Path) -> bytes:
    return table.write_csv(path).read_bytes()


def test_a_grid_is_what_single_runs_give():
    vary = {"length": [0.2, 0.25, 0.4], "hip.stiffness": "log:1e-3:1e-1:3", "angles.hip": ["10 deg", 0.3]}
    found = sweep(studied.rod, vary, MEASURES, t_end=0.1, rtol=1e-6, rows=101, workers=1)
    assert found["end"].dims == ("length", "hip.stiffness", "angles.hip")
    assert found["end"].attrs["units"] == "rad"
    assert found["hip.stiffness"].attrs["units"] == "N·m/rad"
    assert (found["status"].sel(length=0.4) == "refused").all()
    assert "does not fit" in str(found["reason"].sel(length=0.4).values[0, 0])
    assert (found["status"].sel(length=[0.2, 0.25]) == "ok").all()
    mechanism = studied.rod(length=0.25)
    simulator = lamc.compile(
        mechanism,
        lamc.Scene(effects=mechanism.scene.effects, angles={"hip": 0.3}, inputs=mechanism.scene.inputs),
    )
    result = simulator.run(0.1, 1e-6, t_eval=np.linspace(0.0, 0.1, 101), parameters={"hip.stiffness": 0.1})
    point = found.sel({"length": 0.25, "angles.hip": 0.3}).isel({"hip.stiffness": 2})
    assert float(point["end"]) == result.angle("hip")[-1]


@pytest.mark.slow
def test_the_table_does_not_depend_on_processes(tmp_path):
    whole = study({"length": "0.1:0.4:7", "hip.stiffness": "1e-3:1e-1:3", "drive": [0.0, "1 N*mm"]})
    one, *others = (
        csv(whole.run(None, n, alone=alone), tmp_path / "table.csv")
        for n, alone in ((1, 0.0), (3, 0.0), (2, 1e-9))
    )
    assert others == [one, one]
    assert one.count(b"refused") == 2 * 6  # 0.35 m and 0.4 m
    assert b",nan,nan,-1,refused" in one


@pytest.mark.slow
def test_a_process_that_dies_costs_one_point():
    table = study({"hip.stiffness": [1.0, 2.0, 3.0, 4.0]}, {"end": studied.deadly}).run(None, 2, alone=0.0)
    assert [table.status(k) for k in range(4)] == ["ok", "died", "ok", "ok"]
    assert table.reasons == {1: "the process that worked on it died, twice"}


def test_what_went_wrong_is_a_row_with_its_reason():
    found = study({"hip.stiffness": [1e-3, 1e-2]}, {"no": studied.broken}).run(None, 1)
    assert found.tally() == {"error": 2}
    assert found.reasons[0] == "ZeroDivisionError: of the user's"
    found = study({"t_end": [0.01, 0.1]}, {"down": "time_of(hip < 0.49)"}).run(None, 1)
    assert found.tally() == {"ok": 1, "undefined": 1}
    assert found.reasons == {0: "'down' is nan"}
    found = study({"t_end": [0.01, 0.1]}, {"late": "at(hip, 0.05 s)"}).run(None, 1)
    assert found.reasons == {0: "'late' is nan: the run ends at 0.01 s"}
    slow = RunOptions(t_end=1.0, max_steps=3)
    found = study({"hip.stiffness": [1e-3]}, run=slow).run(None, 1)
    assert found.tally() == {"failed": 1}
    assert "3 steps were tried" in found.reasons[0]
    assert np.isnan(found.values["end"]).all()


def test_rows_lie_where_measures_look():
    exact = study({"hip.stiffness": [1e-3]}, {"at": "at(hip, 33.37 ms)"}).run(None, 1)
    simulator = lamc.compile(studied.rod())
    result = simulator.run(0.1, 1e-6, t_eval=[0.03337])
    # The same steps: rows between them are the integrator's own, not interpolated from other rows.
    assert exact.values["at"][0] == pytest.approx(result.angle("hip")[0], rel=1e-14)


def test_samples_follow_from_their_seed():
    axes = {"a": axis_of("a", "1:3", "m"), "b": axis_of("b", "normal(0.3 mm, 0.02 mm)", "m")}
    for method, count in (("lhs", 50), ("sobol", 64), ("halton", 50), ("random", 50)):
        one, other = (sampled(axes, method, count, 7) for _ in range(2))
        assert one.count == count
        assert np.array_equal(one.values, other.values)
        assert not np.array_equal(one.values, sampled(axes, method, count, 8).values)
        assert ((one.values[:, 0] > 1.0) & (one.values[:, 0] < 3.0)).all()
    # 50 strata of a Latin hypercube hold one sample each, so quantiles are met within a stratum.
    lhs = sampled(axes, "lhs", 50, 0).values
    assert sorted(np.floor((lhs[:, 0] - 1.0) * 25).astype(int).tolist()) == list(range(50))
    assert np.median(lhs[:, 1]) == pytest.approx(3e-4, abs=2e-5 * 0.05)
    saltelli = sampled(axes, "saltelli", 8, 0).values
    assert saltelli.shape == (32, 2)
    assert np.array_equal(saltelli[16:24, 1], saltelli[:8, 1])
    assert np.array_equal(saltelli[16:24, 0], saltelli[8:16, 0])


def test_distributions_have_their_quantiles():
    half = np.array([0.5])
    assert axis_of("x", "normal(0.3 mm, 0.02 mm)", "m").quantiles(half)[0] == pytest.approx(3e-4, rel=1e-15)
    assert axis_of("x", "lognormal(2, 0.1)", "1").quantiles(half)[0] == pytest.approx(2.0, rel=1e-12)
    assert axis_of("x", "uniform(1, 4)", "1").quantiles(half)[0] == 2.5
    assert axis_of("x", "triangular(0, 1, 2)", "1").quantiles(half)[0] == pytest.approx(1.0, rel=1e-12)
    truncated = axis_of("x", "truncated(0, 1, -1, 1)", "1")
    assert truncated.quantiles(np.array([1e-9]))[0] == pytest.approx(-1.0, abs=1e-6)
    assert truncated.extremes == (-1.0, 1.0)
    log = axis_of("x", "log:1e-4:1e-2", "1")
    assert log.quantiles(half)[0] == pytest.approx(1e-3, rel=1e-12)


def test_a_grid_is_never_written_out():
    huge = Grid({"a": Span(0.0, 1.0, 10**9), "b": Span(0.0, 1.0, 10**6)})
    assert huge.count == 10**15
    assert huge.point(10**15 - 1) == (1.0, 1.0)
    order = huge.order(["a"])
    assert [next(order) for _ in range(3)] == [0, 1, 2]
    slow_last = huge.order(["b"])
    assert [next(slow_last) for _ in range(3)] == [0, 10**6, 2 * 10**6]
    small = Grid({"a": Listed((1.0, 2.0)), "b": Listed((5.0, 6.0, 7.0))})
    assert [small.point(k) for k in (0, 1, 3)] == [(1.0, 5.0), (1.0, 6.0), (2.0, 5.0)]
    assert sorted(small.order(["b"])) == list(range(6))


def test_very_many_points_are_asked_about_with_their_time():
    with pytest.raises(RequestError, match=r"1000000000 points, which take about .* 2 processes; .* --yes"):
        sweep(studied.rod, {"hip.stiffness": "1e-3:1:1000000000"}, MEASURES, t_end=0.01, workers=2)


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ({"lenght": [1.0]}, "did you mean 'length'?"),
        ({"length": "3:1:5"}, "runs backwards; write 1:3:5"),
        ({"length": "1:1:5"}, "is empty"),
        ({"length": "1:2:1"}, "2 or more"),
        ({"length": "1:2:x"}, "2 or more"),
        ({"length": "1:2"}, "a range without a count makes no grid"),
        ({"length": "normal(1, 2)"}, "a distribution makes no grid"),
        ({"length": "narmal(1, 2)"}, "did you mean 'normal'?"),
        ({"length": []}, "no values"),
        ({"length": ""}, "missing"),
        ({"length": "1,,2"}, "missing"),
        ({"length": [1.0, 1.0]}, "twice"),
        ({"length": float("nan")}, "not finite"),
        ({"length": True}, "no value"),
        ({"hip.stiffness": "1mm:2mm:3"}, "is not"),
        ({"hip.stiffness": "-1:1:3"}, "out of bounds; the least is 0"),
        ({"hip.stiffness": "log:0:1:3"}, "above zero"),
        ({"t_end": [-1.0]}, "out of bounds"),
        ({}, "nothing is varied"),
        (["length"], "must map names"),
    ],
)
def test_what_makes_no_plan_is_one_line(vary, words):
    with pytest.raises((RequestError, DesignError)) as caught:
        study(vary)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_measures_are_refused_before_anything_runs():
    with pytest.raises(LamcError, match=r"no output of a run is named 'hipp'; did you mean 'hip'\?"):
        study({"length": [0.1]}, {"a": "max(hipp)"})
    with pytest.raises(RequestError, match="as another column"):
        study({"length": [0.1]}, {"length": "max(hip)"})
    with pytest.raises(RequestError, match="nothing is measured"):
        sweep(studied.rod, {"length": [0.1]})
    with pytest.raises(RequestError, match="set it no value"):
        study({"drive": [0.0]}, run=RunOptions(parameters={"drive": 1.0}))
    with pytest.raises(RequestError, match="no scene of the design is named 'slow'"):
        study({"length": [0.1]}, scene="slow")
    with pytest.raises(RequestError, match="module of their own, or take workers=1"):
        study({"length": [0.1]}, {"a": lambda result: 1.0}).workers(2)
    assert study({"length": [0.1]}, {"a": lambda result: 1.0}).workers(None) == 1


def test_points_come_from_a_file(tmp_path):
    units = {"length": "m", "hip.stiffness": "N·m/rad"}
    path = tmp_path / "points.csv"
    path.write_text("length (mm),hip.stiffness\n100,1 N*mm/rad\n2e2,0.002\n300 mm,3e-3\n")
    found = given_points(path, units)
    assert found.names == ("length", "hip.stiffness")
    assert found.values == pytest.approx(np.array([[0.1, 1e-3], [0.2, 2e-3], [0.3, 3e-3]]), rel=1e-15)
    for text in (
        "length [mm];hip.stiffness\n100;1 N*mm/rad\n2e2;0,002\n",
        "length [mm]\thip.stiffness [N*m/rad]\n100\t1e-3\n200\t2e-3\n",
        "length[mm],hip.stiffness(N*m/rad)\n100,1e-3\n200,2e-3\n",
    ):
        path.write_text(text)
        assert given_points(path, units).values == pytest.approx(found.values[:2], rel=1e-15)
    path.write_text("angles.hinge(left) [deg],angles.hinge\n90,0.1\n")  # a name that ends in a bracket
    turned = given_points(path, {"angles.hinge(left)": "rad", "angles.hinge": "rad"})
    assert turned.values == pytest.approx(np.array([[math.pi / 2, 0.1]]), rel=1e-15)
    path.write_text("angles.hinge(left),angles.hinge\n1,0.1\n")
    turned = given_points(path, {"angles.hinge(left)": "rad", "angles.hinge": "rad"})
    assert turned.names == ("angles.hinge(left)", "angles.hinge")
    for text, words in (
        ("length\n", "a line for each point"),
        ("lengh\n1\n", "points.csv:1: nothing that can be varied is named 'lengh'; did you mean 'length'?"),
        ("length\n1\n2,3\n", "points.csv:3: 2 values stand under 1 names"),
        ("length\n1\nx\n", "points.csv:3:1:"),
        ("length (mm);hip.stiffness\n1.000,5;1\n", "points.csv:2:1:"),  # a thousand and a half, or one
        ("length (mm)\thip.stiffness\n1,000\t1\n", "points.csv:2:1:"),  # a thousand, or one
        (
            'length\n"0.1,0.2"\n',
            "points.csv:2:1: 'length': '0.1,0.2' is not one number; decimals have a point",
        ),
        (
            "length\n0.1:0.2:3\n",
            "points.csv:2:1: 'length': '0.1:0.2:3' is not one number; decimals have a point",
        ),
        ("length (mm)\n1:1\n", "points.csv:2:1: 'length': '1:1 mm' is not one number"),
        ('length\n"5,5"\n', "points.csv:2:1: 'length': '5,5' is not one number"),
        ("length,length\n1,2\n", "stands twice"),
    ):
        path.write_text(text)
        with pytest.raises(DesignError) as caught:
            given_points(path, units)
        assert words in str(caught.value)
    given = given_points({"length": [0.1, "5 mm"]}, units)
    assert given.values.tolist() == [[0.1], [0.005]]
    with pytest.raises(RequestError, match="lengths"):
        given_points({"length": [0.1], "hip.stiffness": [1.0, 2.0]}, units)


def test_a_study_goes_on_where_it_was_stopped(tmp_path):
    whole = study({"length": "0.1:0.4:7", "hip.stiffness": "1e-3:1e-1:3"})
    undisturbed = csv(whole.run(tmp_path / "a", 1), tmp_path / "a.csv")
    with pytest.raises(RequestError, match="holds a study already"):
        whole.run(tmp_path / "a", 1)
    rows = (tmp_path / "a" / ROWS).read_bytes()
    for cut in (0, 1, len(rows) // 3, len(rows) - 1):  # in the middle of lines too
        (tmp_path / "a" / ROWS).write_bytes(rows[:cut])
        assert csv(whole.run(tmp_path / "a", 1, resume=True), tmp_path / "b.csv") == undisturbed
        lines = (tmp_path / "a" / ROWS).read_text().splitlines()
        assert sorted(json.loads(line)[0] for line in lines) == list(range(21))


def test_a_folder_of_another_study_is_refused_with_what_differs(tmp_path):
    vary = {"hip.stiffness": [1e-3, 1e-2]}
    study(vary).run(tmp_path, 1)
    others = (
        (study({"hip.stiffness": [1e-3]}), "another plan"),
        (study(vary, {"end": "first(hip)", "fast": "max(abs(hip.rate))"}), "another measures (measures: "),
        (study(vary, run=RunOptions(t_end=0.2)), "another run"),
        (study(vary, design=studied.rod(length=0.2)), "another drawing"),
        (study(vary, scene=lamc.Scene(angles={"hip": 0.1})), "another scene"),
    )
    for other, words in others:
        with pytest.raises(RequestError, match="holds a study of another") as caught:
            other.run(tmp_path, 1, resume=True)
        assert words in str(caught.value)


def test_one_process_works_on_a_folder(tmp_path):
    whole = study({"hip.stiffness": [1e-3, 1e-2]})
    with (
        opened(tmp_path, whole.manifest(), resume=True),
        pytest.raises(RequestError, match="another process works"),
    ):
        whole.run(tmp_path, 1, resume=True)
    assert whole.run(tmp_path, 1, resume=True).tally() == {"ok": 2}


def test_shares_of_the_variance_come_with_the_dataset():
    vary = {"hip.stiffness": "1e-3:1e-1", "drive": "0:1e-6"}
    found = sweep(
        studied.rod, vary, {"end": "last(hip)"}, sample="saltelli:8", t_end=0.1, rtol=1e-6, rows=101
    )
    assert found["end"].dims == ("point",)
    assert found["end.total"].sel(varied="hip.stiffness") > 0.9 > 0.1 > found["end.total"].sel(varied="drive")


def test_ctrl_c_keeps_what_is_there(tmp_path):
    def stop(done: float, total: float) -> None:
        if done == 3:
            raise KeyboardInterrupt

    whole = study({"hip.stiffness": "1e-3:1e-1:9"})
    assert whole.run(tmp_path, 1, progress=stop).tally() == {"ok": 3, "missing": 6}
    assert whole.run(tmp_path, 1, resume=True).tally() == {"ok": 9}


KILLED = """
import sys
from pathlib import Path
from lamc.studies.making import study_of
from lamc.studies.bench import RunOptions
from tests.support import studied
vary = {"length": "0.1:0.36316:%d", "hip.stiffness": "1e-3:1e-1:%d"}
study = study_of(studied.rod, vary, {"end": "last(hip)"}, run=RunOptions(t_end=0.1, rtol=1e-6, rows=101))
print("begun", flush=True)
study.run(Path(sys.argv[1]), 2, resume=True, alone=float(sys.argv[3])).write_csv(Path(sys.argv[2]))
print("done", flush=True)
"""


@pytest.mark.parametrize(
    ("lengths", "others", "kills"),
    [
        pytest.param(20, 10, 2, id="small", marks=pytest.mark.slow),
        pytest.param(20, 100, 20, id="whole", marks=pytest.mark.campaign),
    ],
)
def test_a_study_that_is_killed_again_and_again_gives_the_same_bytes(tmp_path, lengths, others, kills):
    """One length of 20 does not fit: 5 % of the points. It is killed after random times, whatever it is at."""
    program = KILLED % (lengths, others)
    vary = {"length": f"0.1:0.36316:{lengths}", "hip.stiffness": f"1e-3:1e-1:{others}"}
    table = study(vary, {"end": "last(hip)"}).run(None, 1)
    begun = time.perf_counter()
    study(vary, {"end": "last(hip)"}).run(None, 1)  # compiled by now
    # Two workers take half as long: so many pauses, half of the longest on average, leave them half of the points.
    longest = (time.perf_counter() - begun) / (2 * kills)
    assert table.tally() == {"ok": 19 * others, "refused": others}
    undisturbed = csv(table, tmp_path / "undisturbed.csv")
    rng = np.random.default_rng(1)
    killed = 0
    for _ in range(40 * kills):
        process = subprocess.Popen(
            [
                sys.executable,
                "-c",
                program,
                str(tmp_path / "study"),
                str(tmp_path / "resumed.csv"),
                rng.choice(["0", "1e-9", "10"]),
            ],
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )
        assert process.stdout.readline() == "begun\n"
        if killed < kills:
            before = _size(tmp_path / "study" / ROWS)
            while process.poll() is None and _size(tmp_path / "study" / ROWS) == before:
                time.sleep(0.001)
            time.sleep(float(rng.uniform(0.0, longest)))
            process.send_signal(signal.SIGKILL)
        out = process.communicate()[0]
        if out == "done\n":
            break
        assert process.returncode == -signal.SIGKILL
        killed += 1
    assert killed == kills
    assert (tmp_path / "resumed.csv").read_bytes() == undisturbed


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


def test_netcdf_is_the_same_bytes_and_reads_back(tmp_path):
    xarray = pytest.importorskip("xarray")
    whole = study(
        {"length": [0.1, 0.4], "hip.stiffness": [1e-3, 1e-2]}, {"a/b": "last(hip)", "end": "last(hip)"}
    )
    paths = [whole.run(None, 1).write_netcdf(tmp_path / f"{k}.nc") for k in range(2)]
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with xarray.open_dataset(paths[0], engine="scipy") as found:
        assert found["end"].attrs["units"] == "rad"
        assert found["a÷b"].attrs["long_name"] == "a/b"
        assert found["status"].values.tolist() == [["ok", "ok"], ["refused", "refused"]]
        assert found["length"].values.tolist() == [0.1, 0.4]


def test_dimensions_have_units_and_bounds():
    found = study({"length": "100 mm:200 mm:3"}, design=studied.bounded).run(None, 1)
    assert found.tally() == {"ok": 3}
    assert found.units["length"] == "m"
    with pytest.raises(RequestError, match=r"vary 'length': 0.5 m is out of bounds; the most is 0.34 m"):
        study({"length": "0.1:0.5:3"}, design=studied.bounded)
    assert study({"length": [0.1]}, design=studied.bounded).subject.targets[0].maximum == 0.34


def test_importing_lamc_does_not_import_studies():
    code = "import sys, lamc; print([n for n in sys.modules if n.split('.')[0] in ('xarray', 'pandas', 'distributed')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"

"""Recordings in files: CSV, Tracker's tables, Motive's exports; what is wrong is told at its line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import lamc
from lamc.readers.recordings import Table, read_recording

TRACKER = "#multi:\n\ttip\t\tmid A\t\t\nt\tx\ty\tx\ty\t\n0.0\t1.0E-1\t2.0\t3.0\t4.0\t\n3.2E-2\t1.1E-1\t2.1\t\t4.1\t\n"
ONE_TRACK = (
    "cm_A\nt\tx\ty\n0.0E0\t1.245986911E1\t-1.328191643E1\n3.200000000E-2\t1.164289057E1\t-1.262051106E1\n"
)
MOTIVE = """Format Version,1.23,Take Name,swing,Capture Frame Rate,120.000000,Length Units,Millimeters

,Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker
,Name,Flap,Flap,Flap,Flap,Flap,Flap,Flap,Flap,Tip:1,Tip:1,Tip:1
,ID,9F,9F,9F,9F,9F,9F,9F,9F,B7,B7,B7
,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error,Position,Position,Position
Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z
0,0.000000,0,0,0,1,496.063,516.091,2854.694,0.1,1.0,2.0,3.0
1,0.008333,0,0,0,1,496.231,516.068,2854.556,0.1,,,
"""


def read(folder: Path, text: str, **options: str) -> Table:
    path = folder / "run.csv"
    path.write_text(text, encoding="utf-8")
    return read_recording(path, **options)


def test_units_of_the_heading_and_gaps(tmp_path: Path) -> None:
    table = read(
        tmp_path, "t [ms]; h1 (deg); tip.x [mm]; h1.rate [deg/s]\n0; 90; 3; 180 # here\n5; ; nan; -\n"
    )
    assert table.t.tolist() == [0.0, 0.005]
    assert table.columns["h1"][0] == pytest.approx(np.pi / 2.0)
    assert table.columns["tip.x"][0] == 0.003
    assert table.columns["h1.rate"][0] == pytest.approx(np.pi)
    assert all(np.isnan(column[1]) for column in table.columns.values())


def test_tracker_of_one_track_and_of_several(tmp_path: Path) -> None:
    one = read(tmp_path, ONE_TRACK)
    assert (one.kind, list(one.columns), one.t[1]) == ("tracker", ["cm_A.x", "cm_A.y"], 0.032)
    assert one.columns["cm_A.x"][1] == 11.64289057
    both = read(tmp_path, TRACKER, length_unit="cm")
    assert list(both.columns) == ["tip.x", "tip.y", "mid A.x", "mid A.y"]
    assert both.columns["tip.y"][1] == pytest.approx(0.021)
    assert np.isnan(both.columns["mid A.x"][1])


def test_motive_takes_positions_in_their_unit(tmp_path: Path) -> None:
    table = read(tmp_path, MOTIVE)
    assert (table.kind, list(table.columns)) == (
        "motive",
        [f"{n}.{a}" for n in ("Flap", "Tip:1") for a in "xyz"],
    )
    assert table.columns["Flap.x"].tolist() == pytest.approx([0.496063, 0.496231])
    assert table.t[1] == 0.008333
    assert np.isnan(table.columns["Tip:1.z"][1])


def test_an_empty_last_cell_is_a_gap(tmp_path: Path) -> None:
    table = read(
        tmp_path, "t,h1,h2,\n0,1,2\n0.25,3,\n0.5,,5,\n"
    )  # a mark behind the last column is no column
    assert table.columns["h1"].tolist()[:2] == [1.0, 3.0]
    assert np.isnan(table.columns["h2"]).tolist() == [False, True, False]


def test_tracker_and_motive_may_leave_the_last_marks_away(tmp_path: Path) -> None:
    both = read(tmp_path, TRACKER.replace("\t\t4.1\t", ""))
    assert np.isnan(both.columns["mid A.y"]).tolist() == [False, True]
    motive = read(tmp_path, MOTIVE.replace("0.1,,,", "0.1"))
    assert np.isnan(motive.columns["Tip:1.z"]).tolist() == [False, True]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,h1\n0,1\n0.2,1\n0.1,1\n", "run.csv:4.*time runs backwards: 0.1 s after 0.2 s"),
        ("t,h1\n0,1\n0,1\n", "run.csv:3.*time stands still"),
        ("t,h1\n0,1\n,1\n", "run.csv:3.*a row without a time"),
        ("t,h1\n0,1\n1,two\n", "run.csv:3.*'two' is no number"),
        ("t;h1\n0;1,5\n0,1;2.5\n", "run.csv:3.*'1,5' with a decimal comma, and '2.5' with a point"),
        (
            't,tip.x [mm]\n0,998\n1,"1,002"\n',
            "run.csv:3.*'1,002' may have a comma between thousands .*write 1002",
        ),
        ("t;tip.x [mm]\n0;998\n1;1,002\n2;1,004\n", "run.csv:3.*'1,002' may have a comma between thousands"),
        ("t\ttip.x [mm]\n0\t998\n1\t1,002,004\n", "run.csv:3.*'1,002,004'"),
        ("t;h1\n0.1;1\n0.2;2,5\n", "run.csv:3.*'2,5' with a decimal comma, and '0.1' with a point"),
        ("t,h1\n0,0,1,5\n0,1,1,6\n", "run.csv:2.*a line of 4 columns .* decimal commas need .* semicolons"),
        ("t,h1\n0,1\n20,1\n40,1\n", "run.csv:1.*rows are 20 apart in 't'.*milliseconds"),
        ("t,h1\n0,inf\n0.1,1\n", "run.csv:2.*'inf' is no number"),
        ("t,time,h1\n0,0,1\n0.1,1,1\n", "run.csv:1.*two columns are named 't'"),
        ("# swing\n0,1\n0.1,2\n", "run.csv:2.*must name the columns"),
        ("\n \n,,\n", "no rows"),
        ("t,h1\n0,1\n0,1,5\n", "run.csv:3.*a line of 3 columns below a heading of 2"),
        ("t,h1,h2\n0,1,2\n0.25,3\n", "run.csv:3.*a line of 2 columns below a heading of 3.*behind its comma"),
        (
            "t;h1;h2\n0;1;2\n0,25\n",
            "run.csv:3.*a line of 1 columns below a heading of 3.*behind its semicolon",
        ),
        ("0,1\n1,2\n", "run.csv:1.*must name the columns"),
        ("zeit,h1\n0,1\n1,2\n", "run.csv:1.*no column is named 't'.*--map COLUMN=t"),
        ("t,h1,h1\n0,1,1\n1,2,1\n", "run.csv:1.*two columns are named 'h1'"),
        ("t,h1 [kg]\n0,1\n1,2\n", "run.csv:1.*'h1' is in 'kg'"),
        ("t [m],h1\n0,1\n1,2\n", "run.csv:1.*'t', of times, is in 'm', which is not a time: s, ms"),
        ("t,h1\n0,1\n", "run.csv:1.*there are 1 rows"),
        ("t,h1\n0,1e999\n1,1\n", "run.csv:2.*more than a number can be"),
        ("", "no rows"),
        ("t\n0\n1\n", "times and nothing else"),
        (MOTIVE.replace("Millimeters", "Furlongs"), "run.csv:1.*length unit is 'Furlongs'"),
        ("\n".join(MOTIVE.split("\n")[:2]), "no line 'Frame, Time"),
    ],
)
def test_what_is_wrong_is_told_at_its_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(lamc.DesignError, match=message) as error:
        read(tmp_path, text)
    assert "\n" not in str(error.value)


GERMAN = "t [s];h1 [deg]\n0,0;1,5\n0,1;-2,5e-1\n"


@pytest.mark.parametrize(
    "data",
    [
        GERMAN.encode(),
        GERMAN.replace("\n", "\r\n").encode("utf-8-sig"),
        GERMAN.replace(";", "\t").encode("utf-16"),
        b'"t [s]","h1 [deg]"\n"0,0","1,5"\n"0,1","-2,5e-1"\n',
        b"# t [s], h1 [deg]\n0.0, 1.5\n0.1, -2.5e-1\n",  # numpy.savetxt
        b"t [s],h1 [deg]\r0,1.5\r.1,-.25\r",
    ],
)
def test_what_spreadsheets_and_numpy_write_is_read(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(data)
    table = read_recording(path)
    assert table.t.tolist() == [0.0, 0.1]
    assert np.degrees(table.columns["h1"]).tolist() == pytest.approx([1.5, -0.25])


@pytest.mark.parametrize("data", ["t [s],h1 [°]\n0,1\n1,2\n".encode("latin-1"), bytes(range(256)) * 10])
def test_what_is_no_text_is_refused(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(data)
    with pytest.raises(lamc.DesignError, match="not UTF-8 text: save it as CSV in UTF-8"):
        read_recording(path)


def test_a_unit_of_lengths_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(lamc.DesignError, match="the unit of lengths is in 'stone', which is not a length"):
        read(tmp_path, "t,a.x\n0,1\n0.1,2\n", length_unit="stone")


CELLS = ("t", "h1", "#multi:", "Frame", "Format Version", "Position", "x", "1", "nan", "1e5", '"', "")
TABLES = st.lists(st.tuples(st.sampled_from(CELLS), st.sampled_from("\t,;\n\n")), max_size=40)


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.one_of(st.text(max_size=200), TABLES.map(lambda cells: "".join(map("".join, cells)))))
@example("#multi:\rt\t")
def test_any_text_is_a_table_or_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    table, said = None, ""
    try:
        table = read_recording(path)
    except lamc.LamcError as error:
        said = str(error)
    if table is None:
        assert len(said.splitlines()) == 1
    else:
        assert np.all(np.diff(table.t) > 0.0)
        assert all(column.shape == table.t.shape for column in table.columns.values())


def test_decimal_commas_of_three_digits_are_read(tmp_path: Path) -> None:
    table = read(tmp_path, "t [s];tip.x [mm]\n0;0,998\n1;1,002\n2;1,5\n3;2\n")
    assert table.columns["tip.x"] == pytest.approx([0.998e-3, 1.002e-3, 1.5e-3, 2e-3])

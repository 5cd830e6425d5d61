"""What a result draws of itself, and all that the scene asks for in its tables."""

import csv
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import lamc
from lamc.examples import path as example
from lamc.report.angle_table import AngleTable
from lamc.report.curves import coinciding
from lamc.report.film import by_ffmpeg, by_pyav, write_mp4
from lamc.report.folded import draw_folded, instants
from lamc.report.look import CAMERAS, Look, camera_of
from lamc.run.result import Result
from tests.unit.test_report import strip


@pytest.fixture(scope="module")
def result() -> Result:
    tip = lamc.OutputPoint("tip", "link1", (2.0, 0.5, 0.0))
    scene = lamc.Scene(effects=(lamc.Gravity(),), outputs=(tip, "link0.x", "h1"), duration=0.5)
    return lamc.compile(strip(2), scene).run()


@pytest.fixture(scope="module")
def four_bar() -> Result:
    return lamc.compile(lamc.load(example("four_bar"))).run(0.5, t_eval=np.linspace(0.0, 0.5, 11))


def test_a_run_without_an_end_lasts_as_long_as_its_scene(result: Result) -> None:
    assert result.t[-1] == 0.5


def test_every_output_of_the_scene_is_in_every_table(result: Result, tmp_path: Path) -> None:
    with result.to_csv(tmp_path / "r.csv").open(encoding="utf-8") as file:
        titles = next(csv.reader(file))
    assert {"tip.x (m)", "tip.z (m)", "link0.x (m)", "h1 angle (rad)"} <= set(titles)
    assert "link0.x (m)" in result.to_pandas().columns
    frame = result.to_xarray()
    assert frame["output"].sel(output_name="link0.x").values == pytest.approx(result.pose("link0")[0][:, 0])
    with np.load(result.to_npz(tmp_path / "r.npz")) as arrays:
        assert list(arrays["output_names"]) == ["tip.x", "tip.y", "tip.z", "link0.x"]
        assert np.array_equal(arrays["outputs"][:, 2], result.point("tip")[:, 2])


def test_hinges_that_close_loops_are_in_every_table(four_bar: Result, tmp_path: Path) -> None:
    hinges = [joint.name for joint in four_bar.mechanism.joints]
    assert list(four_bar.hinges) == hinges  # in the design's order, the cut one too
    frame = four_bar.to_xarray()
    assert list(frame["joint"].values) == hinges
    with np.load(four_bar.to_npz(tmp_path / "r.npz")) as arrays:
        assert list(arrays["hinges"]) == hinges
        for k, name in enumerate(hinges):
            assert np.array_equal(arrays["angles"][:, k], four_bar.angle(name))
            assert np.array_equal(frame["rate"].values[:, k], four_bar.rate(name))


def test_hinges_that_yield_and_close_a_loop_have_angle_and_rate_in_tables() -> None:
    mechanism = lamc.split(lamc.load(example("four_bar")))
    yielding = lamc.TwistCompliance(
        (mechanism.joints[3].name,), width=0.02, length=1e-3, thickness=1e-4, E=3e9, nu=0.3
    )
    scene = lamc.Scene(effects=(lamc.Gravity(), yielding))
    run = lamc.compile(mechanism, scene).run(0.01)
    assert set(run.hinges) == {joint.name for joint in mechanism.joints}
    titles = set(run.to_pandas().columns)
    assert {f"{joint.name} rate (rad/s)" for joint in mechanism.joints} <= titles


def test_quantities_have_units_and_unknown_ones_are_named(result: Result) -> None:
    assert result.quantity("h0.rate").unit == "rad/s"
    assert result.quantity("tip.z").values == pytest.approx(result.point("tip")[:, 2])
    assert result.quantity("gravity").values == pytest.approx(result.energies["gravity"])
    assert result.quantity("energy.gravity").values == pytest.approx(result.energies["gravity"])
    assert result.quantity("energy.gravity").unit == "J"
    with pytest.raises(KeyError, match=r"did you mean 'tip\.z'"):
        result.quantity("tip.zz")


def test_plots_take_and_give_axes(result: Result) -> None:
    axis = Figure().subplots()
    assert result.plot("tip.z", "tip.x", axes=axis) == (axis,)
    lengths = [len(line.get_xdata()) for line in axis.lines]
    assert lengths == [len(result.t)] * 2
    with pytest.raises(lamc.RequestError, match="2 units"):
        result.plot("tip.z", "energy", axes=axis)


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_plots_are_written_by_their_suffix_and_open_no_window(
    result: Result, tmp_path: Path, suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    angles, energies = result.plot(path=tmp_path / f"p{suffix}")
    assert (tmp_path / f"p{suffix}").stat().st_size > 2000
    assert angles.get_legend().get_texts()[0].get_text().startswith("h0")
    assert energies.lines


def test_another_suffix_is_refused(result: Result, tmp_path: Path) -> None:
    with pytest.raises(lamc.LamcError, match=r"\.png, \.svg, \.pdf"):
        result.plot(path=tmp_path / "p.bmp")
    with pytest.raises(lamc.LamcError, match=r"\.mp4 or \.gif"):
        result.animate(tmp_path / "p.avi")


def test_curves_that_coincide_are_grouped() -> None:
    t = np.linspace(0.0, 1.0, 50)
    assert coinciding([t, 2 * t, t + 1e-4, -t, 2 * t]) == [[0, 2], [1, 4], [3]]


def test_a_whole_turn_looks_like_none(result: Result) -> None:
    spun = lamc.Scene(effects=(lamc.HingeDamping(),), rates={"h0": 2.0 * np.pi})
    turned = lamc.compile(strip(1), spun).run(1.0, t_eval=np.linspace(0.0, 1.0, 9))
    rows = instants(turned)
    angles = np.degrees(turned.q[rows, 0]) % 360.0
    assert any(170.0 < angle < 190.0 for angle in angles)  # half a turn differs most from start and end


def test_many_hinges_are_numbered_and_tabled(tmp_path: Path) -> None:
    run = lamc.compile(strip(6), lamc.Scene(effects=(lamc.Gravity(),))).run(0.2, rtol=1e-4, atol=1e-4)
    svg = draw_folded(run, tmp_path / "f.svg", Look(size=300)).read_text(encoding="utf-8")
    assert "<!-- 1  h0" in svg  # Matplotlib tells each text in a comment


def test_a_body_without_hinge_or_outline_has_a_picture(tmp_path: Path) -> None:
    """All that it spans, of which the view is chosen, is a point."""
    body = lamc.Body(name="stone", mass=1e-3, inertia=np.diag([1e-7, 1e-7, 1e-7]), fixed=True)
    scene = lamc.Scene(effects=(lamc.Gravity(), lamc.FreeBase()))
    stone = lamc.Mechanism(name="stone", bodies=(body,), joints=())
    fallen = lamc.compile(stone, scene).run(0.1)
    assert draw_folded(fallen, tmp_path / "stone.png", Look(size=300)).is_file()
    assert draw_folded(lamc.compile(stone, scene).run(0.0), tmp_path / "still.png", Look(size=300)).is_file()


@pytest.mark.parametrize("given", [*CAMERAS, "30,20", (30, 20), None])
def test_cameras_have_names_or_angles(given: object) -> None:
    found = camera_of(given)  # type: ignore[arg-type]
    assert found is None or len(found) == 2


@pytest.mark.parametrize("given", ["topp", "1,2,3", "a,b", (1,), "0,91", (float("nan"), 0)])
def test_other_cameras_are_refused(given: object) -> None:
    with pytest.raises(lamc.RequestError, match="camera is"):
        camera_of(given)  # type: ignore[arg-type]


def test_a_film_is_an_mp4_where_pyav_is(result: Result, tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    path = result.animate(tmp_path / "a.mp4", camera="front", size=96)
    with av.open(str(path)) as film:
        assert film.streams.video[0].width == 96
        assert film.streams.video[0].frames == 100  # half a second, slowed to four, at 25 a second


def test_a_film_that_cannot_be_written_leaves_the_old_one(tmp_path: Path) -> None:
    class Still:
        width = height = 2

        def __iter__(self) -> Iterator[Image.Image]:
            return iter([Image.new("RGB", (2, 2))])

    path = tmp_path / "old.mp4"
    path.write_bytes(b"a film of yesterday")
    broken = partial(by_ffmpeg, program="/bin/false")
    assert not write_mp4(Still(), path, 25, [lambda *_: False, broken])
    assert path.read_bytes() == b"a film of yesterday"
    assert [p.name for p in tmp_path.iterdir()] == ["old.mp4"]


def test_a_codec_that_only_reads_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class OnlyReads:
        codecs_available: ClassVar[set[str]] = {"h264"}  # of decoders, too

        @staticmethod
        def Codec(name: str, mode: str) -> None:  # noqa: N802
            raise ValueError(f"no {name} to {mode}")

    monkeypatch.setitem(sys.modules, "av", OnlyReads)  # type: ignore[arg-type]
    assert not by_pyav(None, tmp_path / "a.mp4", 25)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("times", "heads"),
    [
        ((0.0,), ["hinge  (at t, s)", "0"]),
        ((0.0, 3.23), ["hinge  (at t, s)", "0", "3.23"]),
        ((0.0, 4.73e-3), ["hinge  (at t, ms)", "0", "4.73"]),
        ((0.0, 1.422e-6), ["hinge  (at t, µs)", "0", "1.42"]),  # in seconds one ran into the other
    ],
)
def test_the_times_of_a_table_are_in_a_unit_that_suits_them(
    times: tuple[float, ...], heads: list[str]
) -> None:
    table = AngleTable(("h",), times, (tuple(0.0 for _ in times),), 0)
    axis = Figure().add_subplot()
    table.write(axis, 1200.0)
    assert [text.get_text() for text in axis.texts[::2]] == heads

"""The film of a fit: what was recorded stands where the device was, and gaps are not bridged."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import lamc
from lamc.fitting.overlaid import overlaid
from lamc.report.fit_film import _even, _on_rows, draw_fit_film
from tests.support.ctools import needs_cc

pytestmark = needs_cc

T = np.linspace(0.0, 0.5, 51)
TIP = (0.3, 0.1, 0.0)
TURN, SCALE, ORIGIN, DELAY = 0.3, 250.0, (320.0, 240.0), 0.01
GAP = 20


def rod() -> lamc.Mechanism:
    link = lamc.Body(name="link", mass=0.1, com=(0.2, 0.0, 0.0), inertia=np.diag([1e-5, 1e-3, 1e-3]))
    hinge = lamc.Joint(name="h", parent="ground", child="link", axis=(0.0, 1.0, 0.0), stiffness=0.5)
    return lamc.Mechanism(name="rod", bodies=(lamc.Body(name="ground", fixed=True), link), joints=(hinge,))


@pytest.fixture(scope="module")
def run() -> lamc.Result:
    scene = lamc.Scene(angles={"h": 0.4}, outputs=(lamc.OutputPoint("tip", "link", TIP),))
    return lamc.compile(rod(), scene).run(t_end=0.5, t_eval=T)


@pytest.fixture(scope="module")
def fit(run: lamc.Result) -> lamc.Fit:
    """A marker in a picture that is turned, scaled, shifted and late, and the hinge with a bias; no noise."""
    point = run.point("tip")
    c, s = np.cos(TURN), np.sin(TURN)
    u, v = point[:, 0], -point[:, 2]
    marker = {"m.x": SCALE * (c * u - s * v) + ORIGIN[0], "m.y": SCALE * (s * u + c * v) + ORIGIN[1]}
    marker["m.x"][GAP] = np.nan
    recording = lamc.Recording(
        T + DELAY,
        {**marker, "h": 1.1 * run.angle("h") + 0.2, "h.rate": run.rate("h")},
        markers={"m": lamc.Marker("link", TIP)},
        camera=lamc.Camera(("x", "-z"), SCALE, TURN, ORIGIN),
        delay=DELAY,
        gain={"h": 1.1},
        bias={"h": 0.2},
        sigma={"m.x": 1.0, "m.y": 1.0, "h": 0.01, "h.rate": 0.01},
    )
    return lamc.fit(rod(), recording, {"h.stiffness": (0.1, 1.0)}, lamc.Scene(angles={"h": 0.4}))


def test_recorded_points_stand_where_the_device_was(run: lamc.Result, fit: lamc.Fit) -> None:
    seen = overlaid(fit, 0)
    (point,), (hinge,) = seen.points, seen.hinges
    good = np.arange(len(T)) != GAP
    assert np.allclose(seen.times, T, atol=1e-12)
    assert np.allclose(
        point.recorded[good], run.point("tip")[good], atol=1e-7
    )  # what runs of 1e-10 a step leave
    assert np.allclose(point.modelled, run.point("tip"), atol=1e-7)
    assert np.isnan(point.recorded[GAP]).all()
    assert np.allclose(hinge.apart, 0.0, atol=1e-6)
    assert seen.others == ("h.rate",)


def test_an_angle_that_is_off_is_told_as_it_is(run: lamc.Result, fit: lamc.Fit) -> None:
    angle = run.angle("h") + np.where(np.arange(len(T)) == GAP, 0.3, 0.0)
    recording = lamc.Recording(T, {"h": angle}, sigma=0.01)
    other = lamc.fit(
        rod(), recording, {"h.stiffness": (0.1, 1.0)}, lamc.Scene(angles={"h": 0.4}), loss="cauchy"
    )
    apart = overlaid(other, 0).hinges[0].apart
    assert apart[GAP] == pytest.approx(0.3, abs=0.01)  # the noise that was said
    assert np.abs(np.delete(apart, GAP)).max() < 0.01


@pytest.mark.slow
def test_a_film_has_its_frames_and_a_legend(fit: lamc.Fit, tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    path = fit.animate(tmp_path / "film.gif", progress=lambda k, n: seen.append((k, n)), size=200)
    assert seen[-1][0] == seen[-1][1] == len(T)  # each row is a frame
    with Image.open(path) as film:
        assert film.n_frames == len(T)
        film.seek(30)
        frame = np.asarray(film.convert("RGB")).astype(int)
    assert film.size[0] % 2 == film.size[1] % 2 == 0  # encoders of MP4 need it
    yellow = (frame[..., 0] > 200) & (frame[..., 1] > 190) & (frame[..., 2] < 120)
    foot = frame.shape[0] - 4 * 22  # four lines
    assert yellow[:foot].any()  # the model's dot
    assert yellow[foot:].any()  # and its place in the legend
    assert draw_fit_film(fit, 0, tmp_path, "overlay", encoders=()).name == "overlay.gif"


@pytest.mark.parametrize(("rows", "frames"), [(5, 50), (51, 51), (1001, 250)])
def test_frames_fall_on_rows_and_gaps_show_nothing(rows: int, frames: int) -> None:
    recorded = np.linspace(0.0, 20.0, rows)
    times, shown = _on_rows(_even(0.0, recorded)[0], recorded)
    assert len(times) == frames  # two seconds at least, ten at most, no more than there are rows
    assert np.array_equal(times, recorded[shown])
    lost = np.abs(recorded - 10.0) < 1.0
    times, shown = _on_rows(times, recorded[~lost])
    nothing = np.abs(times - 10.0) < 0.9
    assert (shown[nothing] == -1).all()
    assert np.array_equal(times[shown >= 0], recorded[~lost][shown[shown >= 0]])


def test_films_of_nothing_are_refused(fit: lamc.Fit, tmp_path: Path) -> None:
    with pytest.raises(lamc.LamcError, match=r"must end in .mp4 or .gif"):
        fit.animate(tmp_path / "film.avi")
    with pytest.raises(lamc.RequestError, match="no recording is named 'run7'; there are run1"):
        fit.animate(tmp_path / "film.gif", "run7")

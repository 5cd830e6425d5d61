"""Derivatives by dimensions that stand at declared bounds, or near them: no drawing beyond a bound is asked for."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.fitting.flights import stencil_within
from lamc.run.start_slopes import beside
from tests.support.ctools import needs_cc

pytestmark = needs_cc

TEXT = (Path(lamc.__file__).parent / "examples/four_bar.yaml").read_text(encoding="utf-8")
T = np.linspace(0.0, 0.3, 31)
DECLARED, WIDE = "min: 20 mm, max: 50 mm", "min: 20 mm, max: 60 mm"
MOST = 0.05  # m


def four_bar(folder: Path, bounds: str = DECLARED) -> lamc.Design:
    """The example, with such bounds of the arm's length."""
    assert DECLARED in TEXT
    text = TEXT.replace(DECLARED, bounds)
    path = folder / "four_bar.yaml"
    path.write_text(text, encoding="utf-8")
    design = lamc.load(path)
    assert isinstance(design, lamc.Design)
    return design


@pytest.mark.parametrize(
    ("length", "bounds"),
    [
        (MOST, DECLARED),
        (MOST - 1e-5, DECLARED),
        (0.04, "min: 40 mm, max: 50 mm"),
        (0.04, "min: 39999um, max: 40002um"),
    ],
)
@pytest.mark.quick("0.04-min: 40 mm, max: 50 mm")
def test_sensitivities_and_gradients_at_a_bound(tmp_path: Path, length: float, bounds: str) -> None:
    """Against those of the same length amid wider bounds, by central differences."""
    asked = {"t_end": 0.3, "t_eval": T, "rtol": 1e-11, "atol": 1e-13}
    found = []
    for each in (bounds, WIDE):
        sim = lamc.compile(four_bar(tmp_path, each).with_parameters({"arm_length": length}))
        along = sim.run(**asked, sensitivities=["arm_length"])
        back = sim.run(**asked, taped=True).gradient("last(shelf.x)", ["arm_length"])
        columns = [along.sensitivity(name, "arm_length") for name in ("arm", "link.rate", "shelf.x")]
        assert back["arm_length"] == pytest.approx(columns[-1][-1], rel=1e-7)
        found.append(columns)
    for one, central in zip(*found, strict=True):
        # Closing loops knows a start to 1e-12, which one-sided differences over 1e-3 make 1e-8 of the largest.
        assert np.abs(one - central).max() <= 1e-7 * np.abs(central).max()


@pytest.mark.slow
def test_a_fit_finds_a_length_at_its_bound(tmp_path: Path) -> None:
    run = lamc.compile(four_bar(tmp_path).with_parameters({"arm_length": MOST})).run(t_end=0.3, t_eval=T)
    noise = 1e-3 * np.random.default_rng(3).normal(size=(2, len(T)))
    data = lamc.Recording(T, {name: run.angle(name) + noise[k] for k, name in enumerate(("arm", "link"))})
    fit = lamc.fit(four_bar(tmp_path), data, ["arm_length"])
    assert fit.converged
    wide = lamc.fit(four_bar(tmp_path, WIDE), data, ["arm_length"])
    low, high = wide.intervals["arm_length"]
    assert low < MOST < high
    # Noise puts the best length on either side of the bound; beyond it, the bound is the best there is.
    assert fit.values["arm_length"] == pytest.approx(
        min(wide.values["arm_length"], MOST), abs=0.01 * (high - low)
    )


@pytest.mark.slow
def test_logarithms_do_not_pass_a_bound(tmp_path: Path) -> None:
    """exp(log(0.05)) is more than 0.05, by a unit in the last place."""
    assert np.exp(np.log(MOST)) > MOST
    run = lamc.compile(four_bar(tmp_path, WIDE).with_parameters({"arm_length": 1.02 * MOST}))
    data = lamc.Recording(T, {"arm": run.run(t_end=0.3, t_eval=T).angle("arm")}, sigma=1e-3)
    fit = lamc.fit(four_bar(tmp_path), data, {"arm_length": "log:20mm:50mm"})
    assert fit.values["arm_length"] == MOST
    assert any("arm_length stands at its bound" in note for note in fit.notes)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("1:2", r"'arm_length': the range 1 m … 2 m lies outside of its declared bounds, 0\.02 m … 0\.05 m"),
        ((0.001, 0.02), r"the range 0\.001 m … 0\.02 m lies outside of its declared bounds"),
        ("60 mm ± 1 mm", r"'arm_length': the start 0\.06 m lies outside of its declared bounds"),
    ],
)
def test_ranges_outside_of_declared_bounds_are_told(tmp_path: Path, given: object, message: str) -> None:
    data = lamc.Recording(T, {"arm": 0.1 * T})
    with pytest.raises(lamc.RequestError, match=message):
        lamc.fit(four_bar(tmp_path), data, {"arm_length": given})


def test_places_stay_within_bounds_and_know_polynomials() -> None:
    """Differences of order 4 are exact of polynomials of degree 4, those of order 2 of degree 2."""
    for low, high in ((-np.inf, np.inf), (1.0, 3.0), (0.5, 1.0), (1.0 - 1e-5, 1.0 + 2e-6), (0.9999, 1.0)):
        at = beside(1.0, low, high)
        found = [(np.array(at.weights) / at.step, at.step * np.array(at.places), 4)]
        for fine, degree in ((True, 4), (False, 2)):
            found.append((*stencil_within(1.0, 1.0, low, high, fine=fine), degree))
        for weights, offsets, degree in found:
            assert np.all((low <= 1.0 + offsets) & (1.0 + offsets <= high))
            size = np.abs(offsets).max()
            for power in range(degree + 1):
                slope = weights @ (offsets / size) ** power * size
                assert slope == pytest.approx(float(power == 1), abs=1e-12)

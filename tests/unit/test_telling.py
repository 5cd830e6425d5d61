"""What lamc says of itself: short reprs, logging, progress."""

import logging

import pytest

import lamc
from lamc import plate
from lamc.examples import path as example


@pytest.fixture(scope="module")
def design() -> lamc.Design:
    return lamc.load(example("four_bar"))


def test_reprs_are_a_line(design: lamc.Design) -> None:
    simulator = lamc.compile(design)
    result = simulator.run(0.01)
    mechanism = simulator.mechanism
    sheet = plate.Laminate([plate.Ply(plate.Material.isotropic(210e9, 0.3, 7800), 1e-3)] * 5)
    held = [plate.Clamped("boundary")]
    problem = plate.Problem(plate.grid(0.1, 0.05, 8, 4), sheet, supports=held, loads=[plate.Pressure(1e3)])
    things = [design, mechanism, *mechanism.bodies, *mechanism.joints, *design.layers, *design.hinges]
    things += [simulator, simulator.scene, result, result.provenance]
    things += [sheet, problem, problem.mesh, plate.solve(problem), plate.modes(problem, count=2)]
    for thing in things:
        assert len(repr(thing)) < 140, repr(thing)
        assert "\n" not in repr(thing)
    assert repr(design) == "<Design 'four_bar': 5 layers, 4 hinge lines>"
    assert (
        repr(lamc.Scene(effects=(lamc.Gravity(),), duration=2.0))
        == "Scene(effects=['gravity'], duration=2.0)"
    )


def test_stages_and_runs_are_logged_under_lamc(design: lamc.Design, caplog: pytest.LogCaptureFixture) -> None:
    assert any(isinstance(handler, logging.NullHandler) for handler in logging.getLogger("lamc").handlers)
    with caplog.at_level(logging.DEBUG, logger="lamc"):
        lamc.compile(design).run(0.01)
    told = [(record.levelname, record.getMessage()) for record in caplog.records]
    assert any(level == "DEBUG" and text.startswith("split: ") for level, text in told)
    assert any(level == "INFO" and "is compiled" in text for level, text in told)
    assert any(level == "INFO" and "run of" in text for level, text in told)


def test_compiling_tells_its_stages(design: lamc.Design) -> None:
    seen: list[str] = []
    times = lamc.Times(observer=(own := []).append)
    lamc.compile(design, times=times, progress=seen.append)
    assert seen[0] == "split"
    assert own == seen
    times.observer("later")  # type: ignore[misc]
    assert seen[-1] != "later"


@pytest.mark.parametrize("missing", [False, True])
def test_bars_are_drawn_on_request(
    design: lamc.Design, missing: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if missing:
        monkeypatch.setitem(__import__("sys").modules, "tqdm.auto", None)
    result = lamc.compile(design, progress=True).run(0.05, progress=True)
    assert result.success
    assert capsys.readouterr().out == ""
    assert lamc.compile(design).run(0.05, progress=False).success

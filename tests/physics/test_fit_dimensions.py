"""Dimensions of a drawing are fitted by exact derivatives, through loops, points of bodies and pieces."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.fitting.exact import Exact
from lamc.fitting.objective import Objective
from lamc.fitting.predictions import Predictor
from lamc.fitting.setting import setting_of
from lamc.fitting.simulators import Simulators
from tests.support.ctools import needs_cc

pytestmark = needs_cc

EXAMPLES = Path(lamc.__file__).parent / "examples"
T = np.linspace(0.0, 0.3, 31)
SIZES = {"arm_length": 0.041, "link_length": 0.0475}


def four_bar() -> lamc.Design:
    design = lamc.load(EXAMPLES / "four_bar.yaml")
    assert isinstance(design, lamc.Design)
    return design


def seen(sizes: dict[str, float], body: str, point: tuple[float, float, float]) -> dict[str, np.ndarray]:
    """What a run of the drawing tells, made as a user makes it."""
    scene = lamc.Scene(outputs=(lamc.OutputPoint("m", body, point),))
    run = lamc.compile(four_bar().with_parameters(sizes), scene).run(
        t_end=float(T[-1]), t_eval=T, rtol=1e-11, atol=1e-13
    )
    at = run.point("m")
    return {"arm": run.angle("arm"), "link.rate": run.rate("link"), "m.x": at[:, 0], "m.z": at[:, 2]}


def moving_body() -> str:
    return next(body.name for body in lamc.split(four_bar()).bodies if not body.fixed)


@pytest.mark.slow
def test_derivatives_by_dimensions_are_those_of_runs_beside() -> None:
    """Of angles, rates and a marker, in a loop, by differences of order 4 of whole runs of other drawings."""
    body, point = moving_body(), (0.01, 0.002, 0.003)
    columns = seen(SIZES, body, point)
    recording = lamc.Recording(T, columns, markers={"m": lamc.Marker(body, point)}, sigma=1e-3)
    simulators = Simulators(four_bar(), lamc.Scene())
    runs = Exact()
    free = {name: lamc.Free(0.5 * size, 2.0 * size, start=size) for name, size in SIZES.items()}
    predictor = Predictor(setting_of(simulators, [recording], free, {}), runs)
    found = predictor.prediction(0, np.array(list(SIZES.values())), sloped=True, fine=True)
    assert not runs.notes
    for k, name in enumerate(SIZES):
        step = 1e-3 * SIZES[name]
        beside = [seen({**SIZES, name: SIZES[name] + way * step}, body, point) for way in (-2, -1, 1, 2)]
        for j, column in enumerate(columns):
            low, near_low, near_high, high = (each[column] for each in beside)
            by = (low - 8.0 * near_low + 8.0 * near_high - high) / (12.0 * step)
            # What four points leave, some (1e-3)^4 of a motion that a tenth of its size makes another, and runs' errors
            # of 1e-11 over the step.
            assert np.allclose(found.slopes[:, j, k], by, rtol=0.0, atol=1e-6 * np.abs(by).max()), (
                name,
                column,
            )


@pytest.mark.slow
def test_several_dimensions_are_found_by_few_runs() -> None:
    rng = np.random.default_rng(0)
    run = lamc.compile(four_bar().with_parameters(SIZES)).run(t_end=0.3, t_eval=T)
    data = lamc.Recording(T, {n: run.angle(n) + 1e-3 * rng.normal(size=len(T)) for n in run.joints})
    fit = lamc.fit(four_bar(), data, dict.fromkeys(SIZES, (0.03, 0.06)))
    assert fit.converged
    assert fit.derivatives == "those of the variational equations"
    assert fit.runs <= 30  # 2 dimensions by differences would take four a step
    for name, true in SIZES.items():
        low, high = fit.intervals[name]
        margin = 0.5 * (high - low)  # 4 standard errors in all: one in 15 000 is beyond
        assert low - margin < true < high + margin
        assert high - low < 0.01 * true


def test_pieces_know_dimensions_too() -> None:
    def flap(length: float = 0.02) -> lamc.Mechanism:
        """A thin strip on a hinge."""
        m = 0.1 * length
        inertia = np.diag([m * length**2 / 12.0] * 2 + [1e-9])
        body = lamc.Body(name="flap", mass=m, com=(0.0, 0.0, -0.5 * length), inertia=inertia)
        hinge = lamc.Joint(name="h", parent="ground", child="flap", axis=(0.0, 1.0, 0.0), stiffness=1e-3)
        ground = lamc.Body(name="ground", fixed=True)
        return lamc.Mechanism(name="flap", bodies=(ground, body), joints=(hinge,))

    scene = lamc.Scene(angles={"h": 0.3})
    run = lamc.compile(flap(0.023), scene).run(t_end=0.3, t_eval=T)
    noise = 1e-3 * np.random.default_rng(1).normal(size=len(T))
    data = lamc.Recording(T, {"h": run.angle("h") + noise, "flap.x": run.pose("flap")[0][:, 0]}, sigma=1e-3)
    free = {"length": (0.015, 0.03), "h.stiffness": None}
    one, pieces = (lamc.fit(flap, data, free, scene, segments=n) for n in (1, 4))
    assert pieces.converged
    for name in free:
        assert pieces.values[name] == pytest.approx(
            one.values[name], abs=0.02 * one.errors[name] * one.values[name]
        )
        assert pieces.errors[name] == pytest.approx(one.errors[name], rel=1e-2)  # what solvers leave


def test_a_drawing_of_another_structure_beside_is_told() -> None:
    """At an offset of zero the equations are others than beside it: differences of runs, and a word."""

    def bent(offset: float = 0.0) -> lamc.Mechanism:
        bodies = (
            lamc.Body(name="ground", fixed=True),
            lamc.Body(name="a", mass=1e-3, com=(0.0, 0.0, -0.01), inertia=1e-7 * np.eye(3)),
            lamc.Body(name="b", mass=1e-3, com=(0.0, 0.0, -0.03), inertia=1e-7 * np.eye(3)),
        )
        y = (0.0, 1.0, 0.0)
        joints = (
            lamc.Joint(name="p", parent="ground", child="a", axis=y, stiffness=1e-3),
            lamc.Joint(name="q", parent="a", child="b", point=(offset, 0.0, -0.02), axis=y, stiffness=1e-3),
        )
        return lamc.Mechanism(name="bent", bodies=bodies, joints=joints)

    scene = lamc.Scene(angles={"p": 0.3})
    run = lamc.compile(bent(0.0), scene).run(t_end=0.3, t_eval=T)
    data = lamc.Recording(T, {n: run.angle(n) for n in "pq"}, sigma=1e-3)
    fit = lamc.fit(bent, data, {"offset": lamc.Free(-0.01, 0.01)}, scene)
    assert fit.values["offset"] == pytest.approx(0.0, abs=1e-6)
    assert any(
        "differences of runs: beside its value 'offset' makes a device of another structure" in n
        for n in fit.notes
    )
    assert fit.derivatives == "differences of runs, where noted"


PARTS = """
units: mm
parameters: {width: 20 mm}
materials: {card: {density: 700, rigid: true}, film: {density: 1390, E1: 2.5 GPa, poisson: 0.34, flexible: true}}
layers:
  - {name: top, material: card, thickness: 1}
  - {name: film, material: film, thickness: 0.05}
  - {name: low, material: card, thickness: 1}
shapes: [{rect: [-20, 0, 50, width]}, {cut: {circle: {center: [30, width/2], radius: 5}}}]
hinges: [{name: knee, line: [[0, 0], [0, width]], gap: 1, stiffness: 1e-3, damping: 1e-6}]
fixed: [{rect: [-20, 0, -10, width]}]
"""


def test_a_drawing_that_was_tried_and_falls_apart_is_told_from_the_users(tmp_path: Path) -> None:
    """A hole wider than its link parts it: no fault of the drawing that is fitted."""
    path = tmp_path / "parts.yaml"
    path.write_text(PARTS, encoding="utf-8")
    simulators = Simulators(lamc.load(path), None)
    data = [lamc.Recording(T, {"knee": 0.1 * np.cos(T)})]
    setting = setting_of(simulators, data, {"width": (0.005, 0.04)}, {})
    objective = Objective(Predictor(setting, Exact()), [np.ones(1)])
    assert objective.tried(np.array([0.02]), sloped=False) is not None
    assert objective.tried(np.array([0.009]), sloped=False) is None
    (said,) = objective.failures
    assert said.startswith("a drawing that was tried, at or next to width = 0.009 m (bound it by LOW:HIGH): ")
    assert "no path to the world" in said

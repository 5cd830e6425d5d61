"""A double pendulum that forgets its start: fitted in pieces that meet."""

import numpy as np
import pytest

import lamc
from lamc.fitting.fit import FORGETS

TRUE = {"p.damping": 0.03, "q.damping": 0.02, "b.mass": 1.3, "b.com_y": 0.6}
SCENE = lamc.Scene(angles={"p": 2.9, "q": 2.5})
T = np.linspace(0.0, 5.0, 251)
NOISE = 0.01  # rad


def double_pendulum() -> lamc.Mechanism:
    """Two links of 1 kg and 1 m, one below the other, about y."""
    inertia = np.diag([0.01, 0.01, 0.001])
    bodies = (
        lamc.Body(name="ground", fixed=True),
        lamc.Body(name="a", mass=1.0, com=(0.0, 0.0, -0.5), inertia=inertia),
        lamc.Body(name="b", mass=1.0, com=(0.0, 0.0, -1.5), inertia=inertia),
    )
    y = (0.0, 1.0, 0.0)
    joints = (
        lamc.Joint(name="p", parent="ground", child="a", axis=y, damping=0.01),
        lamc.Joint(name="q", parent="a", child="b", point=(0.0, 0.0, -1.0), axis=y, damping=0.01),
    )
    return lamc.Mechanism(name="double", bodies=bodies, joints=joints)


@pytest.fixture(scope="module")
def recording() -> lamc.Recording:
    sim = lamc.compile(double_pendulum(), SCENE)
    run = sim.run(t_end=5.0, t_eval=T, parameters=TRUE, sensitivities=["angles.p"])
    assert np.abs(run.sensitivity("q", "angles.p")).max() > 100.0 * FORGETS  # it is chaotic
    rng = np.random.default_rng(0)
    return lamc.Recording(
        T, {n: run.angle(n) + NOISE * rng.normal(size=len(T)) for n in "pq"}, start="estimated"
    )


def check(fit: lamc.Fit) -> None:
    assert fit.converged
    for name, true in TRUE.items():
        low, high = fit.intervals[name]
        margin = 0.5 * (high - low)  # 4 standard errors to either side in all: one in 15 000 is beyond
        assert low - margin < true < high + margin, name
        assert high - low < 0.4 * true  # and they say something
    assert fit.compared[0].rms["q"] == pytest.approx(NOISE, rel=0.15)  # 251 numbers: three times 4.5 %
    assert not fit.unidentifiable


def test_pieces_that_meet_recover_a_chaotic_pendulum(recording: lamc.Recording) -> None:
    fit = lamc.fit(double_pendulum(), recording, list(TRUE), SCENE, segments=20)
    check(fit)
    assert any("multiple shooting, in 20 pieces" in note for note in fit.notes)


def test_a_run_that_forgets_its_start_is_fitted_without_a_word(recording: lamc.Recording) -> None:
    check(lamc.fit(double_pendulum(), recording, list(TRUE), SCENE))


def test_pieces_and_one_run_agree_where_both_can() -> None:
    """A short recording: the same optimum and the same errors."""
    t = np.linspace(0.0, 1.0, 101)
    run = lamc.compile(double_pendulum(), SCENE).run(t_end=1.0, t_eval=t, parameters=TRUE)
    rng = np.random.default_rng(1)
    data = lamc.Recording(t, {n: run.angle(n) + NOISE * rng.normal(size=len(t)) for n in "pq"})
    one, pieces = (lamc.fit(double_pendulum(), data, list(TRUE), SCENE, segments=n) for n in (1, 6))
    for name in TRUE:
        assert pieces.values[name] == pytest.approx(
            one.values[name], abs=0.02 * one.errors[name]
        )  # what solvers leave
        assert pieces.errors[name] == pytest.approx(one.errors[name], rel=1e-2)


def test_loops_are_fitted_by_one_run_only() -> None:
    from lamc import examples

    design = lamc.load(examples.find("four_bar").path)
    sim = lamc.compile(design)  # type: ignore[arg-type]
    name = next(n for n in sim.parameters if n.endswith(".damping"))
    t = np.linspace(0.0, 0.2, 21)
    run = sim.run(t_end=0.2, t_eval=t)
    data = lamc.Recording(t, {n: run.angle(n) for n in run.joints})
    with pytest.raises(lamc.RequestError, match="this model has loops"):
        lamc.fit(design, data, [name], segments=4)  # type: ignore[arg-type]

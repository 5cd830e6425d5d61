"""Motion that forgets its start, of a tree and of a loop: fitted in pieces that meet."""

import numpy as np
import pytest

import lamc
from lamc import examples
from lamc.fitting.charts import Chart
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


@pytest.mark.slow
def test_pieces_that_meet_recover_a_chaotic_pendulum(recording: lamc.Recording) -> None:
    fit = lamc.fit(double_pendulum(), recording, list(TRUE), SCENE, segments=20)
    check(fit)
    assert any("multiple shooting, in 20 pieces" in note for note in fit.notes)


@pytest.mark.slow
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


def test_derivatives_that_no_memory_should_hold_are_refused() -> None:
    t = np.linspace(0.0, 1.0, 200_001)
    data = lamc.Recording(t, {"p": 2.9 - t})
    with pytest.raises(lamc.RequestError, match=r"200001 rows in 396 numbers of pieces.*leave rows out"):
        lamc.fit(double_pendulum(), data, list(TRUE), SCENE, segments=100)


# ---- loops -----------------------------------------------------------------------------------------------------------

LOOP_TRUE = {"a.damping": 0.05, "bob.mass": 1.4, "p.damping": 0.03}
LOOP_SCENE = lamc.Scene(angles={"a": 0.3, "p": 1.5}, rates={"a": 6.0})
LOOP_T = np.linspace(0.0, 5.0, 501)


def rod(name: str, a: np.ndarray, b: np.ndarray) -> lamc.Body:
    """A rod of 1 kg from a to b, m."""
    length = float(np.linalg.norm(b - a))
    along = (b - a) / length
    inertia = length**2 / 12.0 * (np.eye(3) - np.outer(along, along)) + 1e-3 * np.eye(3)
    return lamc.Body(name=name, mass=1.0, com=(a + b) / 2.0, inertia=inertia)


def swing() -> lamc.Mechanism:
    """A four-bar whose crank, of 1 m, turns round and round, and from whose coupler a pendulum hangs: two freedoms."""
    crank_pin, rocker_foot = np.array([0.0, 0.0, 1.0]), np.array([2.2, 0.0, 0.0])
    across = rocker_foot - crank_pin
    span = float(np.linalg.norm(across))
    part = (2.5**2 - 2.0**2 + span**2) / (2.0 * span)  # of a coupler of 2.5 m and a rocker of 2 m
    up = np.array([-across[2], 0.0, across[0]]) / span
    tip = crank_pin + part * across / span + np.sqrt(2.5**2 - part**2) * up
    hung = (crank_pin + tip) / 2.0
    bodies = (
        lamc.Body(name="ground", fixed=True),
        rod("crank", np.zeros(3), crank_pin),
        rod("coupler", crank_pin, tip),
        rod("rocker", rocker_foot, tip),
        rod("bob", hung, hung - np.array([0.0, 0.0, 1.0])),
    )
    hinges = (
        ("a", "ground", "crank", np.zeros(3)),
        ("b", "crank", "coupler", crank_pin),
        ("d", "ground", "rocker", rocker_foot),
        ("c", "coupler", "rocker", tip),
        ("p", "coupler", "bob", hung),
    )
    y = np.array([0.0, 1.0, 0.0])
    joints = tuple(
        lamc.Joint(name=n, parent=p, child=c, point=at, axis=y, damping=0.02) for n, p, c, at in hinges
    )
    return lamc.Mechanism(name="swing", bodies=bodies, joints=joints)


@pytest.mark.slow
def test_pieces_of_a_loop_that_forgets_its_start_meet() -> None:
    """Two of five angles are recorded; the others of each piece follow by closure, through several turns."""
    sim = lamc.compile(swing(), LOOP_SCENE)
    run = sim.run(t_end=5.0, t_eval=LOOP_T, parameters=LOOP_TRUE, sensitivities=["angles.p"])
    assert np.ptp(run.angle("a")) > 2.0 * np.pi
    assert np.abs(run.sensitivity("p", "angles.p")).max() > 100.0 * FORGETS
    rng = np.random.default_rng(0)
    data = lamc.Recording(LOOP_T, {n: run.angle(n) + NOISE * rng.normal(size=len(LOOP_T)) for n in "ap"})
    fit = lamc.fit(swing(), data, list(LOOP_TRUE), LOOP_SCENE, segments=30)
    assert fit.converged
    for name, true in LOOP_TRUE.items():
        low, high = fit.intervals[name]
        margin = 0.5 * (high - low)  # 4 standard errors to either side in all: one in 15 000 is beyond
        assert low - margin < true < high + margin, name
        assert high - low < 0.4 * true
    for name in "ap":
        assert fit.compared[0].rms[name] == pytest.approx(NOISE, rel=0.1)  # 501 numbers: three times 3.2 %


def test_pieces_and_one_run_agree_through_a_loop() -> None:
    design = lamc.load(examples.find("four_bar").path)
    sim = lamc.compile(design)  # type: ignore[arg-type]
    free = [n for n in sim.parameters if n.startswith("arm.") and n.endswith((".damping", ".stiffness"))]
    t = np.linspace(0.0, 0.5, 51)
    run = sim.run(t_end=0.5, t_eval=t)
    rng = np.random.default_rng(2)
    data = lamc.Recording(
        t, {n: run.angle(n) + 1e-3 * rng.normal(size=len(t)) for n in ("link", "arm_shelf")}
    )
    one, pieces = (lamc.fit(design, data, free, segments=n) for n in (1, 5))  # type: ignore[arg-type]
    assert pieces.converged
    for name in free:
        assert pieces.values[name] == pytest.approx(
            one.values[name], abs=0.02 * one.errors[name] * one.values[name]
        )  # what solvers leave
        assert pieces.errors[name] == pytest.approx(one.errors[name], rel=1e-2)


@pytest.mark.parametrize("name", ["vertex", "bricard", "two_loops"])
def test_independent_coordinates_give_a_closed_state(name: str) -> None:
    """Spherical, spatial and coupled loops, in motion: closed, with the numbers asked for; slopes as differences."""
    sim = lamc.compile(lamc.load(examples.find(name).path))  # type: ignore[arg-type]
    motion, nu = sim.model.motion({}), len(sim.coordinates)
    run = sim.run(t_end=0.02, t_eval=[0.01, 0.02])
    y = run.y[:, 0]
    chart = Chart.around(motion, y)
    x = y[chart.places] + 0.05
    state = chart.state(motion, x)
    assert np.array_equal(state[chart.places], x)
    found = motion.closures(state[None, :])[0]
    count = sim.model.closure_count
    assert np.abs(found[:count]).max() < 1e-11 * max(1.0, sim.mechanism.size)  # as runs close
    rates = found[count:].reshape(count, nu) @ state[nu:]
    assert np.abs(rates).max() < 1e-11 * max(1.0, np.abs(state[nu:]).max())
    slopes = chart.slopes(motion, state)
    for k, step in enumerate(1e-4 * np.eye(len(x))):
        low, near_low, near_high, high = (chart.state(motion, x + way * step) for way in (-2, -1, 1, 2))
        by = (low - 8.0 * near_low + 8.0 * near_high - high) / 12e-4
        # Differences of four points leave 1e-16 of a fifth derivative, closure of 1e-12 over the step 1e-8.
        assert np.allclose(slopes[:, k], by, rtol=0.0, atol=1e-7 * max(1.0, np.abs(by).max()))

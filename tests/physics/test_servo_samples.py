"""Servos that sample, against the exact discrete-time solution of the link between samples; what is held; refusals."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import lamc
from lamc.basics.errors import DesignError, RequestError, UnsupportedError
from lamc.effects import HingeDamping, HingeStiffness, JointLimits
from lamc.mechanics.loads import Loads
from lamc.records.scene import Scene
from lamc.reference.check import check
from tests.physics.test_effects import ABOUT_HINGE, pendulum, simulator
from tests.physics.test_servo import BAND, FINE, GOAL, SPEED, STALL, C, K, c_text, servo
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain

pytestmark = needs_cc

PERIOD = 0.02  # s


def sampled(asked, count: int, hinge: tuple[float, float] = (0.0, 0.0), start=(0.0, 0.0)) -> np.ndarray:  # type: ignore[no-untyped-def]
    """Angle and rate (count + 1, 2) at the samples: x₊ = e^{A P} x + ∫ e^{A s} ds b T, T = asked(k, x)."""
    a = np.zeros((3, 3))
    a[0, 1] = 1.0
    a[1] = np.array([-hinge[0], -hinge[1], 1.0]) / ABOUT_HINGE
    step = expm(a * PERIOD)
    x = [np.array(start)]
    for k in range(count):
        x.append((step @ [*x[-1], asked(k, x[-1])])[:2])
    return np.array(x)


@pytest.mark.parametrize("integrator", ["dop853", "rk45", "radau5", "rodas5p", "auto"])
def test_between_samples_the_torque_is_held(integrator: str) -> None:
    """A link on a damped spring under a zero-order hold, at its samples."""
    stiffness, damping = 0.7, 0.02
    link = pendulum(stiffness=stiffness, damping=damping)
    sim = simulator(link, servo(period=PERIOD), HingeStiffness(), HingeDamping())
    t = PERIOD * np.arange(51)
    result = sim.run(t_end=1.0, t_eval=t, integrator=integrator, energy_balance=True, rtol=1e-10, atol=1e-13)
    exact = sampled(lambda _, x: K * (GOAL - x[0]) - C * x[1], 50, (stiffness, damping))
    # rtol times some hundred steps
    assert result.angle("hip") == pytest.approx(exact[:, 0], abs=1e-8)
    assert result.rate("hip") == pytest.approx(exact[:, 1], abs=1e-7)
    assert [event.t for event in result.events] == pytest.approx(t[1:-1], abs=1e-14)
    assert result.energy_balance.balance < 1e-8


def test_without_a_spring_it_is_exact_to_round_off() -> None:
    sim = simulator(pendulum(), servo("0.6*sin(7*t)", period=PERIOD, dead_band=BAND))
    t = PERIOD * np.arange(101)
    result = sim.run(t_end=2.0, t_eval=t, **FINE)

    def asked(k: int, x: np.ndarray) -> float:
        error = 0.6 * math.sin(7 * k * PERIOD) - x[0]
        return K * (max(error - BAND, 0.0) + min(error + BAND, 0.0)) - C * x[1]

    exact = sampled(asked, 100)
    assert result.angle("hip") == pytest.approx(exact[:, 0], abs=1e-12)  # round-off of a hundred samples
    assert result.rate("hip") == pytest.approx(exact[:, 1], abs=1e-12)


def test_long_periods_make_a_loop_unstable_that_holds_without() -> None:
    """The eigenvalues of the sampled loop say which: past some period they leave the unit circle."""
    sim = simulator(pendulum(), servo(period=PERIOD))
    for period in (0.05, 0.2, 0.4):
        plant = expm(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0 / ABOUT_HINGE], [0.0, 0.0, 0.0]]) * period)
        loop = plant[:2, :2] - np.outer(plant[:2, 2], [K, C])
        radius = np.abs(np.linalg.eigvals(loop)).max()
        result = sim.run(
            t_end=40 * period, t_eval=[40 * period], parameters={"hip.servo.period": period}, rtol=1e-10
        )
        exact = np.linalg.matrix_power(loop, 40) @ [-GOAL, 0.0] + [GOAL, 0.0]
        assert result.angle("hip")[-1] == pytest.approx(
            exact[0], rel=1e-7, abs=1e-8
        )  # rtol times some hundred steps
        assert (abs(result.angle("hip")[-1] - GOAL) > GOAL) == (radius > 1.0)


def test_a_sampled_loop_has_no_linear_model() -> None:
    """What is held has no stiffness; modes would be those of the hinge alone."""
    sim = simulator(pendulum(), servo(period=0.4))
    for asked in (sim.equilibrium, sim.equilibria, sim.modes):
        with pytest.raises(
            UnsupportedError, match=r"servo of hip samples.*no linear model.*leave its period out"
        ):
            asked()
    assert simulator(pendulum(), servo()).equilibrium().angles["hip"] == pytest.approx(GOAL, abs=1e-9)


def test_the_limit_follows_the_rate_between_samples() -> None:
    """Held beyond the limit, the link spins up exponentially: I u̇ = T₀ (1 - u/ω₀)."""
    sim = simulator(pendulum(), servo(100.0, stall_torque=STALL, no_load_speed=SPEED, period=0.1))
    tau = ABOUT_HINGE * SPEED / STALL
    t = np.linspace(0.0, tau, 11)
    result = sim.run(t_end=tau, t_eval=t, **FINE)
    assert result.rate("hip") == pytest.approx(SPEED * (1 - np.exp(-t / tau)), abs=1e-10)


def test_a_sample_takes_it_off_its_limit_and_on_to_it() -> None:
    """From interval to interval: the torque held, clipped at the stall torque, at every sample."""
    sim = simulator(pendulum(), servo("0.8*sin(5*t)", stall_torque=STALL, period=PERIOD))
    t = PERIOD * np.arange(101)
    result = sim.run(t_end=2.0, t_eval=t, energy_balance=True, **FINE)
    exact = sampled(
        lambda k, x: float(np.clip(K * (0.8 * math.sin(5 * k * PERIOD) - x[0]) - C * x[1], -STALL, STALL)),
        100,
    )
    assert result.angle("hip") == pytest.approx(exact[:, 0], abs=1e-11)  # rtol times some hundred steps
    assert result.energy_balance.balance < 1e-11
    jumps = np.clip(
        [K * (0.8 * math.sin(5 * s) - x[0]) - C * x[1] for s, x in zip(t, exact, strict=True)], -1e9, 1e9
    )
    assert (np.abs(jumps) > STALL).any()
    assert (np.abs(jumps) < STALL).any()


def test_two_clocks_tick_by_themselves() -> None:
    servos = (servo(0.3, "h0", period=0.03), servo(-0.2, "h2", period=0.05))
    sim = lamc.compile(chain(3), Scene(effects=servos))
    found = sim.run(t_end=0.16, rtol=1e-9).events
    names = [f"servo of {joint} samples" for joint in ("h0", "h2")]
    first = [event.t for event in found if event.name == names[0]]
    second = [event.t for event in found if event.name == names[1]]
    assert first == pytest.approx([0.03, 0.06, 0.09, 0.12, 0.15], abs=1e-15)
    assert second == pytest.approx([0.05, 0.10, 0.15], abs=1e-15)
    assert len(found) == 8  # both at 0.15 s


@pytest.mark.parametrize("period", [None, PERIOD, 0.03])
@pytest.mark.parametrize("hold", ["previous", "linear"])
@pytest.mark.quick("linear-None", "previous-0.0*", "linear-0.0*", others="campaign")
def test_its_command_follows_a_series(hold: str, period: float | None) -> None:
    """Steps and kinks of a table at some of the samples: those of a step have its new value."""
    t, values = 0.06 * np.arange(8), np.array([0.1, -0.4, 0.5, 0.2, 0.9, -0.3, 0.0, 0.4])
    series = lamc.Series(t, values, hold=hold)
    scene = Scene(
        effects=(servo("goal", stall_torque=STALL, period=period),),
        inputs={"goal": lamc.Input(unit="rad", series=series)},
    )
    result = lamc.compile(pendulum(), scene).run(t_end=0.42, t_eval=[0.42], energy_balance=True, **FINE)

    def command(at: float) -> float:
        if hold == "linear":
            return float(np.interp(at, t, values))
        return float(values[np.searchsorted(t, at + 1e-9, side="right") - 1])

    def torque(at: float, x: np.ndarray) -> float:
        return float(np.clip(K * (command(at) - x[0]) - C * x[1], -STALL, STALL))

    step, x = 1e-5, np.zeros(2)  # s; divides all times
    for k in range(42000):
        at = k * step
        if period is None or k % round(period / step) == 0:
            held = torque(at, x)
        if period is None:  # the middle of the step
            held = torque(at + 0.5 * step, x + 0.5 * step * np.array([x[1], torque(at, x) / ABOUT_HINGE]))
        x = x + step * np.array([x[1] + 0.5 * step * held / ABOUT_HINGE, held / ABOUT_HINGE])
    # second order in 1e-5 s, and of kinks between steps the first: some 1e-5 of slopes of 10 rad/s over 1e-5 s
    assert result.q[-1, 0] == pytest.approx(x[0], abs=1e-7)
    assert result.u[-1, 0] == pytest.approx(x[1], abs=1e-5)
    assert result.energy_balance.balance < 1e-10


def test_impacts_leave_what_is_held() -> None:
    """Elastic limits between samples: the held torque goes on, as in runs begun after the impact would not."""
    link = pendulum(limits=(-0.2, 0.2))
    sim = simulator(link, servo(1.0, damping=0.0, period=0.5), JointLimits(restitution=1.0))
    result = sim.run(t_end=0.49, energy_balance=True, **FINE)
    push = K * 1.0 / ABOUT_HINGE
    struck = math.sqrt(2 * 0.2 / push)
    assert result.events[0].t == pytest.approx(struck, abs=1e-12)
    # thrown back at the speed of the impact against the same torque: up again after twice the time
    assert result.events[1].t == pytest.approx(3 * struck, abs=1e-11)
    assert result.energy_balance.balance < 1e-11


def test_slices_and_repeats_give_the_same_bits() -> None:
    sim = simulator(pendulum(), servo("0.8*sin(5*t)", stall_torque=STALL, no_load_speed=SPEED, period=PERIOD))
    whole = sim.run(t_end=1.0)
    sliced = sim.run(t_end=1.0, progress=lambda *_: None)
    assert np.array_equal(whole.q, sliced.q)
    assert np.array_equal(whole.t, sliced.t)
    assert whole.events == sliced.events
    many = sim.ensemble(
        t_end=1.0, parameters={"hip.servo.period": np.array([PERIOD, 0.03])}, t_eval=[0.5, 1.0]
    )
    for k, period in enumerate((PERIOD, 0.03)):
        alone = sim.run(t_end=1.0, t_eval=[0.5, 1.0], parameters={"hip.servo.period": period})
        assert np.array_equal(many.q[k], alone.q)


def test_single_states_are_as_if_sampled_there_and_it_says_so() -> None:
    sim = simulator(pendulum(), servo(period=PERIOD, backlash=0.1, gear_inertia=0.01, gear_stiffness=50.0))
    plain = simulator(pendulum(), servo(backlash=0.1, gear_inertia=0.01, gear_stiffness=50.0))
    state = (np.array([0.1, 0.3]), np.array([0.5, -1.0]))
    assert np.array_equal(sim.acceleration(*state, 0.7), plain.acceleration(*state, 0.7))
    assert any("as if sampled there" in note for note in sim.notes)
    assert not any("sampled" in note for note in plain.notes)
    report = check(sim, states=10, t_end=0.2)
    assert report.passed, report
    whole = check(simulator(pendulum(), servo(period=PERIOD)), states=10, t_end=0.2)
    assert whole.passed, whole
    assert any("know no clocks" in note for note in whole.notes)


def test_no_period_leaves_no_trace() -> None:
    bare, with_it = c_text(servo()), c_text(servo(period=PERIOD))
    traces = ["_samples(", "clock_guards[]", "servo.period", "held[]"]
    assert all(trace in with_it for trace in traces)
    assert not [trace for trace in traces if trace in bare]


def test_what_knows_no_samples_refuses_them(tmp_path: Path) -> None:
    sim = simulator(pendulum(), servo(period=PERIOD))
    with pytest.raises(RequestError, match=r"does not end its steps where a controller samples"):
        sim.run(t_end=0.1, integrator="scipy:DOP853")
    scene = Scene(effects=(servo(period=PERIOD),))
    with pytest.raises(UnsupportedError, match=r"held between samples is not exported"):
        lamc.export(pendulum(), "c", out=tmp_path / "out", scene=scene)
    for value in (0.0, -1.0):
        with pytest.raises(DesignError, match=r"period is .* above 0"):
            servo(period=value)
        with pytest.raises(RequestError, match=r"'hip\.servo\.period' is .* above zero"):
            sim.run(t_end=0.1, parameters={"hip.servo.period": value})


def test_guards_that_hold_modes_are_refused() -> None:
    """Where a run starts all modes are set at once; such a guard would see those of the run before."""

    class Nested(lamc.Effect):
        name, summary = "nested", "A switch behind a switch"

        def contribute(self, loads: Loads) -> None:
            first = loads.switch("first", loads.hinge("hip").angle)
            loads.hinge_torque("hip", loads.switch("second", first * loads.hinge("hip").angle - 0.1))

    with pytest.raises(DesignError, match=r"guard 'second' depends on what another switch gives"):
        simulator(pendulum(), Nested())

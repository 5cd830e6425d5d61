"""Servos against closed forms and scipy: step response, torque line, dead band, gear, impacts; and what is refused."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lamc
from lamc import examples
from lamc.basics.errors import DesignError, ExpressionError, RequestError
from lamc.effects import JointLimits, Servo
from lamc.pipeline import effects_of, equations_of, sources_of
from lamc.readers.load_scene import load_scene
from lamc.records.scene import Scene
from lamc.reference.check import check
from tests.physics.test_effects import ABOUT_HINGE, pendulum, simulator
from tests.support.ctools import needs_cc
from tests.support.every_effect import mechanism
from tests.support.mechanisms import chain

pytestmark = needs_cc

K, C, GOAL = 2.0, 0.08, 0.6  # N·m/rad, N·m·s/rad, rad
STALL, SPEED, BAND = 0.3, 2.5, 0.05  # N·m, rad/s, rad
FINE = {"rtol": 1e-11, "atol": 1e-13}


def servo(command: float | str = GOAL, joint: str = "hip", **more: Any) -> Servo:
    return Servo(joint, command, **{"stiffness": K, "damping": C, **more})


def by_scipy(
    torque: Callable[[float, float, float], float], t: np.ndarray, start: tuple[float, float] = (0.0, 0.0)
) -> np.ndarray:
    """Angle and rate (2, m) of a link under a torque(t, angle, rate), in steps so short that kinks do not show."""
    solved = solve_ivp(
        lambda at, y: [y[1], torque(at, *y) / ABOUT_HINGE],
        (0.0, t[-1]),
        start,
        t_eval=t,
        method="DOP853",
        rtol=1e-12,
        atol=1e-13,
        max_step=1e-3,
    )
    return np.asarray(solved.y)


# ---- gains ---


@pytest.mark.parametrize("command", [GOAL, "0.6 + 0*t"])
def test_the_step_response_is_that_of_a_second_order_system(command: float | str) -> None:
    sim = simulator(pendulum(), servo(command))
    decay, natural = C / (2 * ABOUT_HINGE), math.sqrt(K / ABOUT_HINGE)
    omega = math.sqrt(natural**2 - decay**2)
    t = np.linspace(0.0, 3.0, 31)
    result = sim.run(t_end=3.0, t_eval=t, **FINE)
    step = 1 - np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    assert result.angle("hip") == pytest.approx(GOAL * step, abs=1e-10)  # rtol times some hundred steps
    assert not result.events
    assert not sim.program.guards


def test_it_follows_an_input_and_an_expression() -> None:
    inputs = {"goal": lamc.Input("20 deg", unit="rad", meaning="where to go")}
    scene = Scene(effects=(servo("goal + 0.1*t"),), inputs=inputs)
    sim = lamc.compile(pendulum(), scene)
    assert sim.acceleration([0.1], [0.5], 2.0)[0] == pytest.approx(
        (K * (math.radians(20.0) + 0.2 - 0.1) - C * 0.5) / ABOUT_HINGE, rel=1e-13
    )
    moved = sim.acceleration([0.1], [0.5], 2.0, {"goal": 1.0})[0]
    assert moved == pytest.approx((K * (1.0 + 0.2 - 0.1) - C * 0.5) / ABOUT_HINGE, rel=1e-13)


# ---- the line of torque over rate ---


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_at_its_limit_it_spins_up_exponentially(side: float) -> None:
    """I u̇ = T₀ (1 - u/ω₀) while the command is far away: u = ω₀ (1 - exp(-t/τ)), τ = I ω₀ / T₀."""
    sim = simulator(pendulum(), servo(side * 100.0, stall_torque=STALL, no_load_speed=SPEED))
    tau = ABOUT_HINGE * SPEED / STALL
    t = np.linspace(0.0, 3 * tau, 13)
    result = sim.run(t_end=3 * tau, t_eval=t, **FINE)
    assert result.rate("hip") == pytest.approx(side * SPEED * (1 - np.exp(-t / tau)), abs=1e-10)
    assert not result.events


@pytest.mark.parametrize(
    ("rate", "command", "torque"),
    [
        (0.0, 9.0, STALL),
        (0.0, -9.0, -STALL),
        (SPEED, 9.0, 0.0),
        (2 * SPEED, 9.0, -STALL),  # beyond the no-load speed it brakes
        (-SPEED, 9.0, 2 * STALL),  # driven backwards, it holds more than at rest
        (SPEED, -9.0, -2 * STALL),
        (-2 * SPEED, -9.0, STALL),
    ],
)
def test_the_line_goes_on_in_all_quadrants(rate: float, command: float, torque: float) -> None:
    sim = simulator(pendulum(), servo(command, stall_torque=STALL, no_load_speed=SPEED))
    assert sim.acceleration([0.0], [rate])[0] * ABOUT_HINGE == pytest.approx(torque, abs=1e-14)


def test_a_stall_torque_alone_limits_at_any_rate() -> None:
    sim = simulator(pendulum(), servo(9.0, stall_torque=STALL))
    for rate in (-10.0, 0.0, 10.0):
        assert sim.acceleration([0.0], [rate])[0] * ABOUT_HINGE == pytest.approx(STALL, rel=1e-14)


@pytest.mark.slow
def test_a_servo_with_all_of_it_moves_as_scipy_says_and_keeps_its_books() -> None:
    """Corners are met within 1e-3 s in scipy's steps, each with an error of its square times the kink, some 1e-9."""
    data = {"stall_torque": STALL, "no_load_speed": SPEED, "dead_band": BAND}
    sim = simulator(pendulum(), servo("0.6*sin(3*t)", **data), angle=0.4, rate=-1.0)

    def torque(t: float, angle: float, rate: float) -> float:
        error = 0.6 * math.sin(3 * t) - angle
        error = max(error - BAND, 0.0) + min(error + BAND, 0.0)
        share = K * error - C * rate
        lost = STALL * rate / SPEED
        return min(max(share, -STALL - lost), STALL - lost)

    t = np.linspace(0.0, 4.0, 41)
    result = sim.run(t_end=4.0, t_eval=t, energy_balance=True, **FINE)
    angle, rate = by_scipy(torque, t, (0.4, -1.0))
    assert result.angle("hip") == pytest.approx(angle, abs=1e-9)
    assert result.rate("hip") == pytest.approx(rate, abs=1e-8)
    assert result.energy_balance.balance < 1e-10
    kinds = {event.name for event in result.events}
    assert len(kinds) == 4  # both limits, and both edges
    assert check(sim, states=10, t_end=0.5).passed


def test_events_are_where_the_torque_leaves_its_limit() -> None:
    """From rest at T₀ alone: K (goal - ½ a t²) - C a t = T₀, a = T₀ / I."""
    sim = simulator(pendulum(), servo(GOAL, stall_torque=STALL))
    a = STALL / ABOUT_HINGE
    at = (-C * a + math.sqrt((C * a) ** 2 + 2 * K * a * (K * GOAL - STALL))) / (K * a)
    result = sim.run(t_end=1.5 * at, **FINE)
    assert result.events[0].t == pytest.approx(at, abs=1e-11)  # what integration leaves
    assert "upper limit" in result.events[0].name


@pytest.mark.parametrize("method", ["rk45", "dop853", "rodas5p", "radau5"])
def test_all_integrators_meet_the_same_corners(method: str) -> None:
    data = {"stall_torque": STALL, "no_load_speed": SPEED, "dead_band": BAND}
    sim = simulator(pendulum(), servo(1.5, **data))
    exact = sim.run(t_end=2.0, rtol=1e-12, atol=1e-13, integrator="dop853")
    result = sim.run(t_end=2.0, rtol=1e-9, atol=1e-11, integrator=method)
    assert [e.name for e in result.events] == [e.name for e in exact.events]
    # rtol times some hundred steps
    assert [e.t for e in result.events] == pytest.approx([e.t for e in exact.events], abs=1e-6)
    assert result.q[-1] == pytest.approx(exact.q[-1], abs=1e-6)


def test_slices_give_the_same_bits() -> None:
    data = {"stall_torque": STALL, "no_load_speed": SPEED, "dead_band": BAND}
    sim = simulator(pendulum(), servo(1.5, **data))
    whole = sim.run(t_end=2.0)
    sliced = sim.run(t_end=2.0, progress=lambda *_: None)
    assert np.array_equal(whole.q, sliced.q)
    assert whole.events == sliced.events


# ---- after an impact ---


def test_an_impact_takes_the_servo_off_its_limit_and_on_to_it() -> None:
    """Rates jump, and with them the torque that is left: the run goes on as one that begins with the rate after."""
    limited = pendulum(limits=(-0.3, 0.3))
    effects = (
        servo(0.9, stall_torque=1.0, no_load_speed=SPEED, damping=0.5),
        JointLimits(restitution=0.8),
    )
    sim = simulator(limited, *effects, angle=-0.2, rate=4.0)
    result = sim.run(t_end=0.25, **FINE)
    struck = [event for event in result.events if "limit of hip" in event.name and "servo" not in event.name]
    assert len(struck) == 1
    at = struck[0].t
    rows = np.flatnonzero(result.t >= at)
    rate = float(result.rate("hip")[rows][result.t[rows] == at][-1])
    assert rate < 0.0
    again = simulator(limited, *effects, angle=float(0.3 - 1e-13), rate=rate)
    rest = again.run(t_end=0.25 - at, **FINE)
    assert result.q[-1] == pytest.approx(rest.q[-1], abs=1e-10)  # rtol times some hundred steps


# ---- gear ---


def test_the_gears_inertia_adds_to_the_joints() -> None:
    gear = 0.7 * ABOUT_HINGE
    sim = simulator(pendulum(), servo(damping=0.0, gear_inertia=gear))
    omega = math.sqrt(K / (ABOUT_HINGE + gear))
    t = np.linspace(0.0, 3.0, 31)
    result = sim.run(t_end=3.0, t_eval=t, energy_balance=True, **FINE)
    assert result.angle("hip") == pytest.approx(GOAL * (1 - np.cos(omega * t)), abs=1e-10)
    rate = GOAL * omega * np.sin(omega * t)
    assert result.energies["servo"] == pytest.approx(0.5 * gear * rate**2, abs=1e-10)
    assert result.energy_balance.balance < 1e-11


@pytest.mark.slow
def test_gears_act_between_moving_bodies_and_in_loops_cross_checked() -> None:
    servos = (
        servo(0.2, "h0", gear_inertia=1e-3, stall_torque=0.5),
        servo("0.3*sin(t)", "h2", gear_inertia=2e-3, damping=0.0),
    )
    sim = lamc.compile(chain(3, "space", seed=5), Scene(effects=(*servos, lamc.Gravity())))
    report = check(sim, states=15, t_end=0.3)
    assert report.passed, report
    four_bar = lamc.load(examples.path("four_bar"))
    bare = lamc.compile(four_bar)
    small = {"gear_inertia": 1e-7, "stiffness": 1e-3, "damping": 0.0}
    servos = tuple(servo(0.3, name, **small) for name in bare.joints if name not in bare.cut_joints)
    loop = lamc.compile(four_bar, Scene(added=servos))
    result = loop.run(t_end=0.05, energy_balance=True, rtol=1e-10, atol=1e-12)
    assert result.energy_balance.balance < 1e-8
    report = check(loop, states=10, t_end=0.02)
    assert report.passed, report
    floating = lamc.compile(
        mechanism(),
        Scene(effects=(servo(0.3, "h1", gear_inertia=0.01), lamc.FreeBase(), lamc.HingeStiffness())),
    )
    result = floating.run(t_end=0.5, energy_balance=True, rtol=1e-10, atol=1e-12)
    assert result.energy_balance.balance < 1e-9
    report = check(floating, states=10, t_end=0.1)
    assert report.passed, report


# ---- absence ---


def c_text(effect: Servo) -> str:
    whole = pendulum()
    _, tree = sources_of(equations_of(whole, effects_of(whole, Scene(effects=(effect,)))))
    return tree.files[f"{tree.prefix}.c"]


@pytest.mark.parametrize(
    ("feature", "traces"),
    [
        ({"damping": C}, ["servo_damping", "servo.damping"]),
        ({"stall_torque": STALL}, ["stall_torque", "limit", "guards("]),
        ({"stall_torque": STALL, "no_load_speed": SPEED}, ["no_load_speed", "guard_changes("]),
        ({"dead_band": BAND}, ["dead_band", "dead band", "guards("]),
        ({"gear_inertia": 1e-3}, ["gear_inertia", "_system("]),
    ],
)
def test_what_is_not_given_leaves_no_trace(feature: dict[str, float], traces: list[str]) -> None:
    bare, with_it = c_text(servo(damping=0.0)), c_text(servo(**{"damping": 0.0, **feature}))
    present = [trace for trace in traces if trace in with_it]
    assert present
    assert not [trace for trace in present if trace in bare]


# ---- refusals ---

BAD = [
    ("joint: knee, command: 1, stiffness: 1", "no joint is named 'knee'"),
    ("joint: hip, command: goal, stiffness: 1", "'goal' is not known.*declared in the scene's inputs"),
    ("joint: hip, command: angle, stiffness: 1", "'angle' is not known"),
    ("joint: hip, command: 1 m, stiffness: 1", "command"),
    ("joint: hip, command: 1, stiffness: -1", "stiffness.* at least 0"),
    ("joint: hip, command: 1, stiffness: 1, damping: -2", "damping.* at least 0"),
    ("joint: hip, command: 1, stiffness: 1, stall_torque: 0", "stall torque.* above 0"),
    ("joint: hip, command: 1, stiffness: 1, stall_torque: 1, no_load_speed: 0", "no load speed.* above 0"),
    ("joint: hip, command: 1, stiffness: 1, no_load_speed: 3", "no stall_torque; the line of its torque"),
    ("joint: hip, command: 1, stiffness: 1, dead_band: -1 deg", "dead band.* at least 0"),
    ("joint: hip, command: 1, stiffness: 1, gear_inertia: -1", "gear inertia.* at least 0"),
    ("joint: hip, command: log(-1), stiffness: 1", "no finite value"),
    ("joint: hip, command: 1", "needs stiffness"),
]


@pytest.mark.parametrize(("text", "reported"), BAD)
def test_bad_servos_are_refused_at_their_line(tmp_path: Path, text: str, reported: str) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(f"kind: scene\neffects:\n  - gravity\n  - servo: {{{text}}}\n")
    with pytest.raises((DesignError, ExpressionError), match=reported) as caught:
        lamc.compile(pendulum(), load_scene(path))
    assert "scene.yaml:4" in str(caught.value)


def test_a_gear_on_a_joint_that_closes_a_loop_is_refused() -> None:
    four_bar = lamc.load(examples.path("four_bar"))
    (cut,) = lamc.compile(four_bar).cut_joints
    with pytest.raises(DesignError, match="closes a loop, and its rate follows from the others'"):
        lamc.compile(four_bar, Scene(added=(servo(0.3, cut, gear_inertia=1e-7),)))


@pytest.mark.parametrize(
    ("field", "value"), [("stall_torque", 0.0), ("dead_band", -0.1), ("stiffness", -1.0)]
)
def test_sweeps_refuse_what_no_servo_has(field: str, value: float) -> None:
    sim = simulator(pendulum(), servo(stall_torque=STALL, dead_band=BAND))
    with pytest.raises(RequestError, match=rf"'hip\.servo\.{field}' is "):
        sim.run(t_end=0.1, parameters={f"hip.servo.{field}": value})


def test_two_servos_on_a_joint_are_refused() -> None:
    with pytest.raises(DesignError, match=r"both claim the servo of joint 'hip'"):
        simulator(pendulum(), servo(), servo(0.1))

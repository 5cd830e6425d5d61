"""The motor against its closed forms: spin-up, stall, no load; where its power goes; and what is refused."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import DesignError, ExpressionError
from lamc.effects import Gravity, LinearMotor
from lamc.records.scene import Scene
from lamc.reference.check import check
from tests.physics.test_effects import ABOUT_HINGE, pendulum, simulator
from tests.support.ctools import needs_cc
from tests.support.every_effect import SAMPLES, mechanism
from tests.support.mechanisms import chain
from tests.support.quick import tries

pytestmark = needs_cc

STALL, SPEED, NOMINAL = 0.4, 30.0, 6.0  # N·m, rad/s, V
LINE = {"stall_torque": STALL, "no_load_speed": SPEED, "nominal_voltage": NOMINAL}
K = NOMINAL / SPEED  # N·m/A
R = K * NOMINAL / STALL  # Ω


def motor(voltage: float | str = NOMINAL, **data: Any) -> LinearMotor:
    return LinearMotor("hip", voltage, **(data or LINE))


@pytest.mark.parametrize("voltage", [NOMINAL, -3.0, "6 + 0*t"])
@pytest.mark.parametrize("ratio", [1.0, -2.5])
def test_a_motor_without_load_spins_up_exponentially(voltage: float | str, ratio: float) -> None:
    """I u̇ = n (T₀ v - (T₀/ω₀) n u), v = V/V₀: u = (v ω₀ / n) (1 - exp(-t/τ)), τ = I ω₀ / (n² T₀)."""
    sim = simulator(pendulum(), motor(voltage, **LINE, gear_ratio=ratio))
    v = (NOMINAL if isinstance(voltage, str) else voltage) / NOMINAL
    tau = ABOUT_HINGE * SPEED / (ratio**2 * STALL)
    t = np.linspace(0.0, 4 * tau, 17)
    result = sim.run(t_end=4 * tau, t_eval=t, rtol=1e-11, atol=1e-12)
    final = v * SPEED / ratio
    # rtol times some hundred steps, of rates up to 30 rad/s and angles up to 90 rad
    assert result.rate("hip") == pytest.approx(final * (1 - np.exp(-t / tau)), abs=1e-7)
    assert result.angle("hip") == pytest.approx(final * (t - tau * (1 - np.exp(-t / tau))), abs=1e-6)


@pytest.mark.parametrize("ratio", [1.0, -20.0])
def test_the_rotor_turns_with_the_joint_times_the_gear_ratio_squared(ratio: float) -> None:
    """(I + n² J) u̇ = n (T₀ - (T₀/ω₀) n u): spin-up with a longer time, and ½ n² J u² in the energy balance."""
    rotor = 3e-4
    sim = simulator(pendulum(), motor(NOMINAL, **LINE, gear_ratio=ratio, rotor_inertia=rotor))
    tau = (ABOUT_HINGE + ratio**2 * rotor) * SPEED / (ratio**2 * STALL)
    t = np.linspace(0.0, 3 * tau, 13)
    result = sim.run(t_end=3 * tau, t_eval=t, rtol=1e-11, atol=1e-12)
    rate = SPEED / ratio * (1 - np.exp(-t / tau))
    assert result.rate("hip") == pytest.approx(rate, abs=1e-7)  # rtol times some hundred steps
    assert result.energies["linear_motor"] == pytest.approx(0.5 * ratio**2 * rotor * rate**2, abs=1e-6)
    lighter = sim.acceleration([0.0], [0.0], 0.0, {"hip.motor.rotor_inertia": 0.0})[0]
    assert lighter == pytest.approx(ratio * STALL / ABOUT_HINGE, rel=1e-13)


def test_a_rotor_between_moving_bodies_is_refused() -> None:
    scene = Scene(effects=(LinearMotor("h1", 1.0, **LINE, rotor_inertia=1e-6),))
    with pytest.raises(
        DesignError, match=r"rotor_inertia of the motor on joint 'h1' .* both move.*set it to 0"
    ):
        lamc.compile(chain(2), scene)
    floating = Scene(effects=(LinearMotor("h1", 1.0, **LINE, rotor_inertia=1e-6), SAMPLES["free_base"]))
    with pytest.raises(DesignError, match=r"stay where they are, and the scene moves them"):
        lamc.compile(mechanism(), floating)


def test_the_line_ends_at_stall_torque_and_no_load_speed() -> None:
    sim = simulator(pendulum(), motor())
    assert sim.acceleration([0.0], [0.0])[0] == pytest.approx(STALL / ABOUT_HINGE, rel=1e-14)
    assert sim.acceleration([0.0], [SPEED])[0] == pytest.approx(0.0, abs=1e-14)
    half = sim.acceleration([0.0], [0.0], 0.0, {"hip.motor.voltage": NOMINAL / 2})[0]
    assert half == pytest.approx(0.5 * STALL / ABOUT_HINGE, rel=1e-14)


def test_line_and_winding_are_two_ways_to_say_the_same() -> None:
    line = simulator(pendulum(), motor(4.0))
    wound = simulator(pendulum(), motor(4.0, torque_constant=K, resistance=R))
    for rate in (-20.0, 0.0, 13.0):
        a, b = (s.acceleration([0.1], [rate])[0] for s in (line, wound))
        assert a == pytest.approx(b, rel=1e-13)
    assert line.parameters["hip.motor.stall_torque"] == STALL
    assert wound.parameter_units["hip.motor.resistance"] == "Ω"


def test_electrical_power_is_mechanical_power_and_heat() -> None:
    """The work of the motor is the change of kinetic energy, and of the supply's work the rest heats the winding."""
    the_motor = motor("6*sin(20*t) - 0.1*rate", torque_constant=K, resistance=R, gear_ratio=3.0)
    sim = simulator(pendulum(), Gravity((0.0, 0.0, -9.81)), the_motor)
    t = np.linspace(0.0, 1.0, 4001)
    result = sim.run(t_end=1.0, t_eval=t, rtol=1e-10, atol=1e-12)
    energy_balance = the_motor.energy_balance(result)
    assert energy_balance.electrical == pytest.approx(
        energy_balance.mechanical + energy_balance.heat, abs=1e-12
    )  # round-off of some W
    assert (energy_balance.heat >= 0.0).all()
    step = t[1] - t[0]
    simpson = np.ones(len(t))
    simpson[1:-1:2], simpson[2:-1:2] = 4.0, 2.0
    work = step / 3.0 * float(simpson @ energy_balance.mechanical)
    # Simpson's rule at 0.25 ms for motions of 20 rad/s and faster: h⁴ f'''' / 180 is some 1e-11
    assert work == pytest.approx(result.energy[-1] - result.energy[0], abs=1e-8)


def test_the_energy_balance_use_the_parameters_of_the_run() -> None:
    the_motor = motor()
    sim = simulator(pendulum(), the_motor)
    result = sim.run(t_end=0.1, parameters={"hip.motor.voltage": -2.0, "hip.motor.gear_ratio": 4.0})
    energy_balance = the_motor.energy_balance(result)
    assert energy_balance.voltage == pytest.approx(np.full(len(result.t), -2.0))
    assert energy_balance.current[0] == pytest.approx(-2.0 / R)
    assert energy_balance.torque[0] == pytest.approx(4.0 * K * -2.0 / R)


@given(
    rate=st.floats(-1e3, 1e3),
    ratio=st.floats(-50, 50).filter(lambda n: abs(n) > 1e-3),
    seed=st.integers(0, 2**32 - 1),
)
@settings(deadline=None, max_examples=tries(50))
def test_a_shorted_motor_brakes(rate: float, ratio: float, seed: int) -> None:
    sim = simulator(pendulum(), motor(0.0))
    angle = float(np.random.default_rng(seed).uniform(-3, 3))
    torque = sim.acceleration([angle], [rate], 0.0, {"hip.motor.gear_ratio": ratio})[0] * ABOUT_HINGE
    assert torque * rate <= 0.0
    assert torque == pytest.approx(-(ratio**2) * STALL / SPEED * rate, rel=1e-12)


def test_several_motors_act_and_agree_with_the_independent_cross_checks() -> None:
    effects = (
        LinearMotor("h0", "5*cos(9*t) + angle", torque_constant=0.3, resistance=2.0, gear_ratio=4.0),
        LinearMotor("h2", -2.0, **LINE),
        LinearMotor("h2", "tanh(rate)", **LINE),
        Gravity(),
    )
    sim = lamc.compile(chain(3, "space", seed=8), Scene(effects=effects))
    assert {"h2.motor.voltage", "h2.motor.2.stall_torque"} <= set(sim.parameters)
    report = check(sim, states=20, t_end=0.5)
    assert report.passed, report


def test_scene_files_give_motors_with_units() -> None:
    data = {
        "joint": "hip",
        "voltage": "6 V",
        "stall_torque": "400 mN*m",
        "no_load_speed": "30 rad/s",
        "nominal_voltage": 6,
    }
    assert LinearMotor.from_data(data, "x") == motor()
    rpm = LinearMotor.from_data({**data, "no_load_speed": "3000 rpm"}, "x").no_load_speed
    assert rpm == pytest.approx(100 * math.pi, rel=1e-14)
    assert LinearMotor.from_data({**data, "voltage": "6*t"}, "x").voltage == "6*t"
    with pytest.raises(DesignError, match=r"no field 'stall_torqe'; did you mean 'stall_torque'"):
        LinearMotor.from_data({"joint": "hip", "voltage": 1, "stall_torqe": 1}, "x")


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (
            {},
            r"data of the motor on joint 'hip' are missing; give stall_torque, no_load_speed and nominal_voltage, or",
        ),
        ({"stall_torque": 1.0, "resistance": 2.0}, "are stall_torque, resistance; give"),
        ({**LINE, "resistance": 2.0}, "give"),
        ({**LINE, "stall_torque": 0.0}, "the stall torque is 0 N.m; it must be above 0"),
        ({**LINE, "no_load_speed": -1.0}, "no_load_speed.*above 0"),
        ({**LINE, "nominal_voltage": math.nan}, "nominal_voltage.*finite"),
        ({**LINE, "rotor_inertia": -1e-6}, "the rotor inertia is .*at least 0"),
        ({**LINE, "gear_ratio": 0.0}, "gear_ratio of the motor on joint 'hip' is 0"),
        ({"torque_constant": "much", "resistance": 1.0}, "'much' is not a torque constant"),
    ],
)
def test_motors_that_cannot_be_are_refused(data: dict[str, Any], words: str) -> None:
    with pytest.raises(DesignError, match=words) as caught:
        LinearMotor("hip", 6.0, **data)
    assert "\n" not in str(caught.value)


def test_a_voltage_outside_the_language_is_refused() -> None:
    with pytest.raises(
        ExpressionError, match=r"the voltage of the motor on joint 'hip': .*'speed' is not known"
    ):
        Scene(effects=(motor("6*speed"),))
    with pytest.raises(DesignError, match="no joint is named 'hip'"):
        lamc.compile(chain(1), Scene(effects=(motor(),)))

"""Which effects keep the energy of a run: what they say of themselves is what runs show."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc.records.effect import Effect, conserves
from lamc.records.scene import Scene
from lamc.run.energy_balance import IMPACTS
from tests.support.ctools import needs_cc
from tests.support.every_effect import SAMPLES, mechanism
from tests.support.quick import tries

pytestmark = needs_cc

CASES: dict[str, Effect] = dict(SAMPLES) | {
    "elastic stops": lamc.JointLimits(stiffness=30.0),
    "elastic impacts": lamc.JointLimits(restitution=1.0),
    "dull impacts": lamc.JointLimits(restitution=0.5),
    "stops of a scene that says nothing": lamc.JointLimits(),
    "undamped spring": lamc.Spring("ground", (0.0, 0.0, 0.5), "b", (2.0, 0.0, 0.0), 4.0, 0.3),
    "bender under a constant voltage": lamc.PiezoBender(
        "a",
        (0.1, 0.0, 0.0),
        "b",
        (1.2, 0.0, 0.0),
        (0, 0, 1),
        1.0,
        SAMPLES["piezo_bender"].laminate,
        (1, -1),
        9.0,  # type: ignore[attr-defined]
    ),
}


FROM_OUTSIDE = {"external_torque": {"h2.torque": 0.5}}  # N·m; nothing comes from outside by itself


FEW = (  # that make test runs: one of a kind
    *("gravity", "dull impacts", "free_base", "joint_limits"),
    *("piezo_bender", "twist_compliance", "ground_contact"),
)


@pytest.mark.parametrize("case", sorted(CASES))
@pytest.mark.quick(*FEW, "flexible_links")
def test_effects_that_say_so_keep_the_energy_and_the_balance_closes_under_each(case: str) -> None:
    """Kinetic energy is the sum of all work, and what keeps the energy neither supplies nor dissipates any."""
    effect = CASES[case]
    scene = Scene(effects=(effect,), angles={"h1": 0.9, "h2": -0.8}, rates={"h1": 2.0, "h2": -1.5})
    parameters = FROM_OUTSIDE.get(case, {})
    result = lamc.compile(mechanism(), scene).run(
        t_end=1.5, rtol=1e-10, atol=1e-12, energy_balance=True, parameters=parameters
    )
    change = float(np.abs(result.energy - result.energy[0]).max() / result.energies["kinetic"].max())
    kept = conserves(effect, result.energies)
    if kept:
        assert change < 1e-7  # rtol times some hundred steps, of the energy that there is
    else:
        assert change > 1e-5  # a hundred times what integration leaves
    energy_balance = result.energy_balance
    assert energy_balance.balance < 1e-8
    for name, supplied in energy_balance.supplied.items():
        if name not in (effect.name, IMPACTS) or kept:
            assert np.abs(supplied).max() < 1e-8 * energy_balance.scale, name


DISSIPATE = {
    "hinge_damping": SAMPLES["hinge_damping"],
    "damped spring": SAMPLES["spring"],
    "damped stops": SAMPLES["joint_limits"],
    "ground_contact": SAMPLES["ground_contact"],
    "shorted motor": lamc.LinearMotor("h2", 0.0, torque_constant=0.2, resistance=1.5, gear_ratio=3.0),
}


@pytest.mark.parametrize("case", sorted(DISSIPATE))
@pytest.mark.quick("damped spring", "damped stops", "ground_contact")
def test_dissipation_takes_energy_at_every_instant_from_any_start(case: str) -> None:
    @given(state=st.tuples(st.floats(-0.9, 0.2), st.floats(-0.5, 0.5), *[st.floats(-4.0, 4.0)] * 2))
    @settings(deadline=None, max_examples=tries(25))
    def every(state: tuple[float, ...]) -> None:
        angles, rates = (dict(zip(("h1", "h2"), part, strict=True)) for part in (state[:2], state[2:]))
        scene = Scene(effects=(DISSIPATE[case], lamc.Gravity()), angles=angles, rates=rates)
        energy_balance = (
            lamc.compile(mechanism(), scene)
            .run(t_end=0.5, rtol=1e-9, atol=1e-11, energy_balance=True)
            .energy_balance
        )
        taken = energy_balance.supplied[DISSIPATE[case].name]
        assert (np.diff(taken) <= 1e-9 * energy_balance.scale).all()  # what integration leaves

    every()


def test_the_motors_own_energy_balance_is_that_of_the_run() -> None:
    motor = lamc.LinearMotor("h1", "4*sin(3*t)", torque_constant=0.3, resistance=2.0, gear_ratio=2.0)
    result = lamc.compile(mechanism(), Scene(effects=(motor,))).run(t_end=1.0, rtol=1e-9)
    power = motor.energy_balance(result).mechanical
    assert np.abs(power).max() > 0.1
    assert result.powers["linear_motor"] == pytest.approx(power, abs=1e-12)  # round-off of some W


def test_a_rotor_keeps_what_it_is_given() -> None:
    """Shaft power into joint and rotor: the supply's work less its heat is what the energy balance says was
    supplied."""
    motor = lamc.LinearMotor(
        "h1", "4*sin(3*t)", torque_constant=0.3, resistance=2.0, gear_ratio=2.0, rotor_inertia=0.01
    )
    t = np.linspace(0.0, 1.0, 2001)
    result = lamc.compile(mechanism(), Scene(effects=(motor,))).run(
        t_end=1.0, t_eval=t, rtol=1e-10, atol=1e-12, energy_balance=True
    )
    assert result.energy_balance.balance < 1e-8
    simpson = np.ones(len(t))
    simpson[1:-1:2], simpson[2:-1:2] = 4.0, 2.0
    shaft = (t[1] - t[0]) / 3.0 * float(simpson @ motor.energy_balance(result).mechanical)
    # Simpson's rule at 0.5 ms for motions of some rad/s, and rtol times the steps
    assert result.energy_balance.supplied["linear_motor"][-1] == pytest.approx(shaft, abs=1e-8)

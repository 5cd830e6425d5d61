"""Servos with play in their gears, against the piecewise solution of two masses and a flank; and what is refused."""

import math

import numpy as np
import pytest

import lamc
from lamc import examples
from lamc.basics.errors import DesignError
from lamc.effects import Servo
from lamc.records.scene import Scene
from lamc.reference.check import check
from tests.physics.test_effects import ABOUT_HINGE, pendulum, simulator
from tests.physics.test_servo import FINE, c_text, servo
from tests.support.ctools import needs_cc
from tests.support.every_effect import mechanism
from tests.support.mechanisms import chain

pytestmark = needs_cc

PLAY, GEAR, FLANK, PULL = 0.08, 0.02, 300.0, 0.5  # rad, kg·m², N·m/rad, N·m


def loose(joint: str = "hip", **more: float | str) -> Servo:
    return servo(joint=joint, **{"backlash": PLAY, "gear_inertia": GEAR, "gear_stiffness": FLANK, **more})


def test_a_gear_that_is_pulled_strikes_pushes_and_leaves_the_joint_as_two_masses_do() -> None:
    """A constant torque T on the gear: δ̈ = T/J until t₁ = √(play J/T); then with x = δ - play/2 and v = T t₁/J
    x = A (1 - cos ωτ) + v/ω sin ωτ, ω² = k (1/J + 1/I), A = T/(J ω²), until tan ωτ/2 = -v/(ω A); they part at the speed
    at which they met, and meet again after 2 v J/T."""
    sim = simulator(pendulum(), loose(command=1e4, damping=0.0, stall_torque=PULL), angle=0.3)
    t1 = math.sqrt(PLAY * GEAR / PULL)
    v = PULL * t1 / GEAR
    omega = math.sqrt(FLANK * (1 / GEAR + 1 / ABOUT_HINGE))
    shift = PULL / (GEAR * omega**2)
    t2 = t1 + 2 / omega * (math.pi - math.atan(v / (omega * shift)))
    t3 = t2 + 2 * v * GEAR / PULL
    t_end = t2 + 0.9 * (t3 - t2)
    t = np.unique(np.concatenate([np.linspace(0, t1, 5), np.linspace(t1, t2, 9), np.linspace(t2, t_end, 5)]))
    result = sim.run(t_end=1.05 * t3, t_eval=t, energy_balance=True, **FINE)
    assert [e.t for e in result.events[:3]] == pytest.approx(
        [t1, t2, t3], abs=1e-10
    )  # what integration leaves
    assert {e.name for e in result.events} == {"gear of hip pushes forwards"}

    tau = np.clip(t - t1, 0.0, t2 - t1)
    x = shift * (1 - np.cos(omega * tau)) + v / omega * np.sin(omega * tau)
    # I θ̈ = k x, integrated twice; from t₂ on the joint goes on at its rate
    rate = (
        FLANK
        / ABOUT_HINGE
        * (shift * (tau - np.sin(omega * tau) / omega) + v / omega**2 * (1 - np.cos(omega * tau)))
    )
    angle = (
        FLANK
        / ABOUT_HINGE
        * (
            shift * (tau**2 / 2 - (1 - np.cos(omega * tau)) / omega**2)
            + v / omega**2 * (tau - np.sin(omega * tau) / omega)
        )
    )
    angle += np.clip(t - t2, 0.0, None) * rate
    assert result.angle("hip") == pytest.approx(0.3 + angle, abs=1e-10)  # rtol times some hundred steps
    assert result.rate("hip") == pytest.approx(rate, abs=1e-9)
    # momentum of both is T t
    turning = (PULL * t - ABOUT_HINGE * rate) / GEAR
    spring = 0.5 * FLANK * np.where((t > t1) & (t < t2), x, 0.0) ** 2
    assert result.energies["servo"] == pytest.approx(spring + 0.5 * GEAR * turning**2, abs=1e-9)
    assert result.energy_balance.balance < 1e-10


def test_within_its_play_the_joint_swings_freely() -> None:
    """The gear stays with a joint that rests in the middle; one that moves by less than half the play is free."""
    sim = simulator(pendulum(), loose(command=0.0), lamc.Gravity((0.0, 0.0, -9.81)), rate=0.01)
    free = simulator(pendulum(), lamc.Gravity((0.0, 0.0, -9.81)), rate=0.01)
    t = np.linspace(0.0, 2.0, 11)
    loosened = Scene(
        effects=(loose(command=0.0), lamc.Gravity((0.0, 0.0, -9.81))), angles={"hip": 0.0}, rates={"hip": 0.0}
    )
    still = lamc.compile(pendulum(), loosened).run(t_end=2.0, **FINE)
    assert np.abs(still.q).max() < 1e-12
    moved = sim.run(t_end=2.0, t_eval=t, **FINE)
    assert not moved.events  # 0.01 rad/s swing less than 2 mrad, and the gear starts at the joint's rate
    assert moved.angle("hip") == pytest.approx(free.run(t_end=2.0, t_eval=t, **FINE).angle("hip"), abs=1e-11)


def test_the_gear_starts_where_the_joint_does() -> None:
    scene = Scene(effects=(loose("h2"), loose("h0")), angles={"h0": 0.1, "h2": 0.3}, rates={"h2": -0.7})
    sim = lamc.compile(chain(3), scene)
    assert [c.name for c in sim.coordinates] == ["h0", "h1", "h2", "h0.gear", "h2.gear"]
    assert sim.start == pytest.approx([0.1, 0, 0.3, 0.1, 0.3, 0, 0, -0.7, 0, -0.7], abs=0)


@pytest.mark.parametrize("where", ["chain", "loop", "afloat"])
@pytest.mark.quick("loop", others="campaign")
def test_play_agrees_with_the_independent_cross_checks_and_keeps_the_books(where: str) -> None:
    small = {
        "gear_inertia": 1e-7,
        "gear_stiffness": 0.1,
        "gear_damping": 1e-6,
        "stiffness": 1e-3,
        "damping": 1e-6,
    }
    match where:
        case "chain":
            effects = (loose("h0", gear_damping=0.1), loose("h2", command="0.3*sin(9*t)", stall_torque=0.3))
            sim = lamc.compile(chain(3, "space", seed=4), Scene(effects=(*effects, lamc.Gravity())))
        case "loop":  # on joints that close loops too
            four_bar = lamc.load(examples.path("four_bar"))
            joints = lamc.compile(four_bar).joints
            servos = tuple(servo(0.3, name, backlash=0.05, **small) for name in joints)
            sim = lamc.compile(four_bar, Scene(added=servos))
        case _:
            effects = (
                loose("h2", gear_damping=0.1),
                lamc.FreeBase(spin=(0.1, 0.2, 0.3)),
                lamc.HingeStiffness(),
            )
            sim = lamc.compile(mechanism(), Scene(effects=effects))
    result = sim.run(t_end=0.3, rtol=1e-10, atol=1e-13, energy_balance=True)
    assert result.success
    assert result.events
    assert result.energy_balance.balance < 1e-8  # rtol times some hundred steps
    report = check(sim, states=10, t_end=0.05)
    assert report.passed, report


def test_no_backlash_leaves_no_trace() -> None:
    bare = c_text(servo(gear_inertia=GEAR))
    assert "hip.gear" in c_text(loose())
    assert not [trace for trace in ("hip.gear", "backlash", "mode_", "gear_stiffness") if trace in bare]


@pytest.mark.parametrize(
    ("data", "reported"),
    [
        (
            {"gear_inertia": 0.0},
            r"backlash, and its gear no gear_inertia; .* give both, or leave backlash out",
        ),
        ({"gear_stiffness": None}, r"backlash, and its gear no gear_stiffness"),
        ({"backlash": 0.0}, r"has a gear_stiffness and no backlash"),
        ({"backlash": -0.1}, r"backlash is -0\.1 rad; it must be at least 0"),
        ({"gear_stiffness": 0.0}, r"gear stiffness is 0 .* above 0"),
        ({"gear_damping": -1.0}, r"gear damping is -1 .* at least 0"),
    ],
)
def test_bad_gears_are_refused(data: dict[str, float], reported: str) -> None:
    with pytest.raises(DesignError, match=reported):
        loose(**data)

"""The law of contact on a lever, whose one point moves as a mass on a line does: force, restitution, energy."""

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import lamc
from lamc import Body, DesignError, Gravity, GroundContact, Joint, Mechanism, RequestError, Scene
from lamc.reference.check import check
from lamc.run.simulator import Simulator
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain
from tests.support.quick import tries

pytestmark = needs_cc

ARM, INERTIA = 0.2, 8e-4  # m, kg·m²: the point at the lever's end moves as 20 g do
MASS = INERTIA / ARM**2  # kg, as the ground feels it
WALL = Body("wall", fixed=True)


def lever() -> Mechanism:
    """One body about its own centre, so that only the ground moves it; a positive angle lowers its end at x = ARM."""
    body = Body("lever", 0.01, (0.0, 0.0, 0.0), np.diag([INERTIA] * 3))
    return Mechanism((WALL, body), (Joint("h", "wall", "lever", axis=(0.0, 1.0, 0.0)),))


def contact(**fields: Any) -> GroundContact:
    defaults = {"points": {"lever": [(ARM, 0.0, 0.0)]}, "stiffness": 1e6, "damping": 0.3, "friction": 0.0}
    return GroundContact(**{**defaults, **fields})


@cache
def on_ground(effect: GroundContact, rate: float = 0.0) -> Simulator:
    return lamc.compile(lever(), Scene((effect,), rates={"h": rate}))


def push(sim: Simulator, depth: float, speed: float, **parameters: float) -> float:
    """Force of the ground, N, on the point at this depth, m, which goes deeper at this speed, m/s."""
    q = math.asin(depth / ARM)
    u = speed / (ARM * math.cos(q))
    named = {f"ground_contact.{name}": value for name, value in parameters.items()}
    return float(-sim.acceleration([q], [u], parameters=named)[0] * INERTIA / (ARM * math.cos(q)))


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@settings(max_examples=tries(40), deadline=None)
@given(
    depth=st.floats(1e-6, 1e-2),
    speed=st.floats(-0.5, 3.0),
    stiffness=st.floats(1.0, 1e8),
    damping=st.floats(0.0, 1.0),
)
def test_the_ground_pushes_by_the_law_of_hunt_and_crossley(
    exponent: float, depth: float, speed: float, stiffness: float, damping: float
) -> None:
    force = push(on_ground(contact(exponent=exponent)), depth, speed, stiffness=stiffness, damping=damping)
    # 3/2 c v is above -3/4 here, where the clamp against pulling changes the force by 0.05 exp(-(1/4) / 0.05) at most
    factor = 1.0 + 1.5 * damping * speed
    law = stiffness * depth**exponent
    assert force == pytest.approx(law * factor, rel=1e-12, abs=law * (1e-8 + 0.05 * math.exp(-factor / 0.05)))


@settings(max_examples=tries(40), deadline=None)
@given(depth=st.floats(-1e-2, 1e-2), speed=st.floats(-1e3, 1e3))
def test_the_ground_never_pulls_and_does_nothing_from_afar(depth: float, speed: float) -> None:
    force = push(on_ground(contact()), depth, speed, damping=5.0)
    assert force == 0.0 if depth <= 0.0 else force >= 0.0


def test_the_damping_factor_stays_true_until_the_ground_would_pull() -> None:
    """At 3/2 c v = -1 the law turns to a pull; the clamp leaves 3.5 % of the spring's force there: 0.05 log 2."""
    sim = on_ground(contact())
    spring = push(sim, 1e-3, 0.0, damping=0.0)
    at_the_turn = push(sim, 1e-3, -1.0, damping=1.0 / 1.5)
    assert at_the_turn / spring == pytest.approx(
        0.05 * math.log(2.0), rel=1e-6
    )  # the clamp's value at 1 is 1 + 1e-10
    beyond = push(sim, 1e-3, -2.0, damping=1.0 / 1.5)
    assert 0.0 < beyond / spring < 1e-9  # exp(-1 / 0.05)


def restitution(speed: float, **fields: float) -> float:
    """Speed of the point after its blow over that before."""
    sim = on_ground(contact(**fields), speed / ARM)
    result = sim.run(t_end=0.05, rtol=1e-10, atol=1e-13)
    assert result.success
    assert [event.name for event in result.events] == ["contact 1 of lever"] * 2  # touched, and left
    return float(-result.u[-1, 0] * ARM / speed)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize("loss", [0.01, 0.1, 0.5, 2.0])  # c v
def test_restitution_is_that_of_marhefka_and_orin(loss: float, exponent: float) -> None:
    """m v dv/dd = -k dⁿ (1 + a v), a = 3/2 c, integrates to a v (1 + e) = log((1 + a v) / (1 - a v e)), whatever k
    and n (Marhefka & Orin, A compliant contact model with nonlinear damping, 1999)."""
    speed = 0.5
    a = 1.5 * loss

    def balance(e: float) -> float:
        return a * (1 + e) - math.log((1 + a) / (1 - a * e))

    expected = float(brentq(balance, 1e-6, min(1.0, 1.0 / a) - 1e-9, xtol=1e-14))
    found = restitution(speed, damping=loss / speed, exponent=exponent)
    # the lever's end turns by less than 2e-3 while in contact: cos = 1 - 2e-6; the clamp acts where 1 - a v e is small
    clamp = 0.05 * math.exp(-(1.0 - a * expected) / 0.05)
    assert found == pytest.approx(expected, abs=2e-5 + clamp)


def test_a_slow_blow_loses_c_v() -> None:
    """Hunt and Crossley's e = 1 - c v, to second order."""
    for loss in (0.01, 0.02):
        assert restitution(0.5, damping=loss / 0.5) == pytest.approx(1.0 - loss, abs=2.0 * loss**2)


@pytest.mark.parametrize("integrator", ["rk45", "dop853", "rodas5p", "radau5"])
def test_a_blow_without_damping_keeps_energy(integrator: str) -> None:
    sim = on_ground(contact(damping=0.0), 2.5)
    result = sim.run(t_end=0.05, rtol=1e-9, atol=1e-12, integrator=integrator)
    assert len(result.events) == 2
    assert result.energies["ground_contact"].max() > 0.9 * result.energy[0]  # all of it was in the ground
    drift = np.abs(result.energy - result.energy[0]).max() / result.energy[0]
    assert drift < 1e-6  # some hundred steps at a tolerance of 1e-9


def test_depth_at_rest_and_energy_are_those_of_the_spring() -> None:
    """At a moment of 0.1 N·m the point sinks to k dⁿ = 0.5 N and stores ∫ k xⁿ dx."""
    force = 0.1 / ARM
    for exponent in (1.0, 1.5):
        effect = contact(exponent=exponent, stiffness=1e4, damping=5.0)
        sim = lamc.compile(lever(), Scene((effect, lamc.Torque({"h": 0.1}))))
        result = sim.run(t_end=20.0, rtol=1e-8)
        depth = (force / 1e4) ** (1.0 / exponent)
        assert math.sin(result.q[-1, 0]) * ARM == pytest.approx(
            depth, rel=2e-4
        )  # lever turned by 1e-2: cos 1 - 1e-4
        stored = 1e4 * depth ** (exponent + 1.0) / (exponent + 1.0)
        assert result.energies["ground_contact"][-1] == pytest.approx(stored, rel=1e-3)


def test_friction_drags_by_the_coefficient_and_grows_smoothly_with_the_sliding_speed() -> None:
    """The ground is a wall here, x = const: the lever's end slides along it, and its turning is braked by μ F."""
    effect = contact(
        normal=(-1.0, 0.0, 0.0), height=-(ARM - 1e-3), friction=0.4, slip_speed=1e-3, damping=0.0
    )
    sim = on_ground(effect)
    pressed = 1e6 * 1e-3**1.5
    for speed in (-2.0, -1e-3, 1e-4, 1e-3, 5e-2, 2.0):
        braked = sim.acceleration([0.0], [speed / ARM])[0] * INERTIA / ARM
        expected = -0.4 * pressed * speed / math.hypot(speed, 1e-3)
        assert braked == pytest.approx(expected, rel=1e-12)


def test_static_friction_is_the_most_that_holds() -> None:
    effect = contact(
        normal=(-1.0, 0.0, 0.0),
        height=-(ARM - 1e-3),
        friction=0.4,
        static_friction=0.7,
        slip_speed=1e-3,
        damping=0.0,
    )
    sim = on_ground(effect)
    pressed = 1e6 * 1e-3**1.5
    speeds = np.geomspace(1e-5, 10.0, 400)
    coefficients = [-sim.acceleration([0.0], [v / ARM])[0] * INERTIA / ARM / pressed for v in speeds]
    assert max(coefficients) == pytest.approx(0.7, abs=0.02 * 0.4)
    assert speeds[int(np.argmax(coefficients))] == pytest.approx(5e-3, rel=0.1)
    assert coefficients[-1] == pytest.approx(0.4, rel=1e-6)  # at ten thousand slip speeds it slides
    assert min(coefficients) > 0.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("friction", -0.1),
        ("stiffness", -1.0),
        ("damping", -1.0),
        ("slip_speed", 0.0),
        ("static_friction", -1.0),
    ],
)
def test_a_swept_parameter_that_would_feed_energy_is_refused(name: str, value: float) -> None:
    sim = on_ground(contact(friction=0.1, static_friction=0.2))
    with pytest.raises(RequestError, match=f"ground_contact.{name}"):
        sim.run(t_end=0.1, parameters={f"ground_contact.{name}": value})


def test_a_swept_static_friction_below_that_of_sliding_is_refused() -> None:
    sim = on_ground(contact(friction=0.1, static_friction=0.2))
    for swept in ({"static_friction": 0.05}, {"friction": 0.3}):
        with pytest.raises(DesignError, match=r"ground_contact\.static_friction' is .*, below"):
            sim.run(t_end=0.1, parameters={f"ground_contact.{field}": v for field, v in swept.items()})
    assert sim.run(t_end=0.01, parameters={"ground_contact.friction": 0.2}).success


def test_ground_above_all_measure_is_refused_as_any_that_flings() -> None:
    sim = on_ground(contact())
    with pytest.raises(DesignError, match="deep in the ground"):
        sim.run(t_end=0.1, parameters={"ground_contact.height": 1e300})


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"exponent": 2.0}, "exponent of ground contact is 2; it must be 1.5"),
        ({"friction": -0.1}, "the friction is -0.1"),
        ({"static_friction": 0.2, "friction": 0.5}, "static_friction of ground contact is 0.2, below"),
        ({"stiffness": 0.0}, "the stiffness is 0; it must be above 0"),
        ({"slip_speed": 0.0}, "the slip speed is 0 m/s; it must be above 0"),
        ({"normal": (0.0, 0.0, 0.0)}, "it must have a direction"),
        ({"height": math.nan}, "the height is nan"),
        ({"corners": 2}, "corners: it is 2; it must be at least 3"),
        ({"corners": True}, "corners is True; it must be a whole number"),
        ({"bodies": "lever"}, "bodies are 'lever'; give a list of names"),
        ({"points": [(0.0, 0.0, 0.0)]}, "give a map from names to lists, or 'drawn'"),
        ({"points": {"lever": (0.0, 0.0, 0.0)}}, "point of 'lever' is 0.0; give a list of 3 numbers"),
        ({"points": {"lever": []}}, "give a list of points"),
    ],
)
def test_fields_that_make_no_contact_are_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(DesignError, match=message):
        GroundContact(**fields)


def test_gravity_alone_brings_the_default_ground_to_a_small_depth() -> None:
    """With nothing said of the ground, the weight of all that moves sinks one point in by a thousandth of the size."""
    rod = Body("rod", 0.05, (0.1, 0.0, 0.0), np.diag([1e-9, 1e-4, 1e-4]))
    mechanism = Mechanism((WALL, rod), (Joint("h", "wall", "rod", axis=(0.0, 1.0, 0.0)),))
    ground = GroundContact(points={"rod": [(0.1, 0.0, 0.0)]})
    result = lamc.compile(mechanism, Scene((Gravity(), ground))).run(t_end=10.0, rtol=1e-7)
    assert result.success
    assert result.q[-1, 0] * 0.1 == pytest.approx(1e-3 * mechanism.size, rel=1e-3)


@pytest.mark.slow
def test_four_cross_checks_agree_on_a_chain_that_lies_on_slanting_ground() -> None:
    """Points of every body of a chain in space, some in the ground and sliding: C, its interpretation, Newton and Euler
    in numbers, and maximal coordinates."""
    mechanism = chain(3, "space", seed=2)
    points = {f"body{i}": [(float(i), 0.2, -0.1), (i + 0.8, -0.3, 0.2)] for i in range(3)}
    ground = GroundContact(
        friction=0.4, static_friction=0.6, slip_speed=0.5, height=0.3, normal=(0.2, -0.1, 1.0), points=points
    )
    sim = lamc.compile(mechanism, Scene((Gravity(), replace(ground, stiffness=40.0))))
    report = check(sim, states=8, t_end=0.3)
    assert report.passed, [c for c in report.comparisons if not c.passed]
    assert not [note for note in report.notes if "do not know" in note]

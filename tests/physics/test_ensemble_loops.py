"""Ensembles of mechanisms with loops: each instance is the run by itself, beside singular positions and at impacts."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import lamc
from lamc.commands.examples import mechanism_of_example
from lamc.examples import find
from lamc.run.request import Status
from lamc.run.simulator import Simulator
from tests.physics.test_closed_mechanisms import AS_DRAWN, effects_of
from tests.physics.test_simultaneous_impacts import DROPPED, five_bar
from tests.support.closed_mechanisms import ClosedMechanism, closed_mechanisms
from tests.support.ensembles import assert_alike, assert_beside, spread
from tests.support.mechanisms import ALL_PASSIVE
from tests.support.quick import tries

SMALL = (
    "bricard",
    "five_bar",
    "four_bar",
    "n_four_bar",
    "sarrus",
    "six_bar",
    "two_loops",
    "vertex",
    "waterbomb",
)
LARGE = ("folding_box", "miura")
T = np.linspace(0.0, 1.0, 8)  # s


def example(name: str) -> Simulator:
    mechanism = mechanism_of_example(find(name))
    return lamc.compile(mechanism, mechanism.scene or lamc.Scene())


@pytest.mark.quick("dop853-two_loops", "auto-four_bar", others="campaign")
@pytest.mark.parametrize("name", SMALL)
@pytest.mark.parametrize("integrator", ["rk45", "dop853", "auto"])
def test_instances_of_an_example_are_runs_by_themselves(name: str, integrator: str) -> None:
    sim = example(name)
    parameters = spread(sim, 11, 3)
    how = {"t_end": 1.0, "rtol": 1e-7, "integrator": integrator}
    many = sim.ensemble(t_eval=T, parameters=parameters, **how)
    assert_beside(many)
    assert_alike(sim, many, parameters, **how)


@settings(max_examples=tries(12), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    name=st.sampled_from(SMALL),
    seed=st.integers(0, 2**16),
    integrator=st.sampled_from(("rk45", "dop853")),
    count=st.integers(1, 19),
    exponent=st.integers(-11, -3),
)
def test_instances_with_random_values_are_runs_by_themselves(
    name: str, seed: int, integrator: str, count: int, exponent: int
) -> None:
    """Coarse steps end far from closure and take several rounds back; fine ones none."""
    sim = example(name)
    parameters = spread(sim, count, seed)
    how = {"t_end": 0.5, "rtol": 10.0**exponent, "integrator": integrator}
    many = sim.ensemble(t_eval=[0.0, 0.2, 0.21, 0.5], parameters=parameters, **how)
    assert_alike(sim, many, parameters, **how)


@settings(
    max_examples=tries(10), deadline=None, suppress_health_check=[HealthCheck.too_slow], phases=AS_DRAWN
)
@given(
    closed=closed_mechanisms(),
    seed=st.integers(0, 2**16),
    integrator=st.sampled_from(("rk45", "dop853", "auto")),
    exponent=st.integers(-10, -4),
)
@pytest.mark.slow
def test_instances_of_random_loops_are_runs_by_themselves(
    closed: ClosedMechanism, seed: int, integrator: str, exponent: int
) -> None:
    """Redundant equations, rows of any length, starts at rest in singular positions, runs that end early."""
    try:
        sim = lamc.compile(closed.mechanism, lamc.Scene(effects=effects_of(closed, damped=True)))
    except lamc.DesignError:
        assume(False)
    assume(len(sim.rates) <= 10)
    parameters = spread(sim, 11, seed)
    how = {"t_end": 0.6, "rtol": 10.0**exponent, "integrator": integrator, "max_steps": 3000}
    many = sim.ensemble(t_eval=[0.0, 0.17, 0.18, 0.6], parameters=parameters, **how)
    assert_beside(many)
    assert_alike(sim, many, parameters, **how)


def test_each_instance_is_closed_around_its_own_angle() -> None:
    """One that cannot be is an instance without rows."""
    mechanism = mechanism_of_example(find("four_bar"))
    scene = mechanism.scene or lamc.Scene()
    sim = lamc.compile(mechanism, scene)
    joint = sim.joints[0]
    angles = sim.start[0] + np.array([0.0, 0.02, -0.03])
    many = sim.ensemble(0.1, 1e-7, angles={joint: np.append(angles, -1.0)})
    assert_beside(many)
    for k, angle in enumerate(angles):
        own = replace(scene, angles={**scene.angles, joint: float(angle)})
        one = lamc.compile(mechanism, own).run(0.1, 1e-7, t_eval=[0.0, 0.1])
        assert many.q[k].tobytes() == one.q.tobytes()
        assert many.u[k].tobytes() == one.u.tobytes()
    assert many.status.tolist() == [0, 0, 0, int(Status.FAILED)]
    assert joint in many.message(3)


@pytest.mark.parametrize(
    "effect",
    [lamc.JointLimits(restitution=0.7), lamc.JointLimits(stiffness=1.0, damping=1e-3)],
    ids=["impacts", "stops"],
)
@pytest.mark.parametrize("integrator", ["rk45", "dop853"])
def test_loops_meet_their_own_events(effect: Any, integrator: str) -> None:
    sim = lamc.compile(five_bar(), lamc.Scene(effects=(DROPPED, effect), rates={"j0": -4.0, "j4": -3.0}))
    parameters = {"l0.mass": np.linspace(0.001, 0.004, 13)}
    how = {"t_end": 0.2, "rtol": 1e-8, "integrator": integrator}
    many = sim.ensemble(t_eval=np.linspace(0.0, 0.2, 11), parameters=parameters, **how)
    assert_beside(many)
    assert many.stats.events.min() > 0
    assert len(set(many.stats.events.tolist())) > 1
    assert_alike(sim, many, parameters, **how)


@pytest.mark.slow
def test_loops_on_a_base_that_floats_are_runs_by_themselves() -> None:
    """Four hinges and six rates of the base, whose coordinates are not rates: as many as are solved side by side."""
    drawn = mechanism_of_example(find("four_bar"))
    scene = drawn.scene or lamc.Scene()
    heavy = tuple(
        replace(body, mass=2e-3, inertia=1e-6 * np.eye(3)) if body.fixed else body for body in drawn.bodies
    )
    mechanism = replace(drawn, bodies=heavy)
    sim = lamc.compile(mechanism, replace(scene, effects=(*ALL_PASSIVE, lamc.FreeBase())))
    assert (len(sim.coordinates), len(sim.rates)) == (11, 10)
    parameters = spread(sim, 9, 1)
    how = {"t_end": 0.3, "rtol": 1e-7, "integrator": "dop853"}
    many = sim.ensemble(t_eval=[0.0, 0.1, 0.3], parameters=parameters, **how)
    assert_beside(many)
    assert_alike(sim, many, parameters, **how)


@pytest.mark.quick("impacts-cubic", "free-cubic", others="campaign")
@pytest.mark.parametrize("hold", ["previous", "cubic"])
@pytest.mark.parametrize("effects", [(), (lamc.JointLimits(restitution=0.7),)], ids=["free", "impacts"])
def test_loops_that_a_series_drives_are_runs_by_themselves(hold: str, effects: tuple[Any, ...]) -> None:
    """Steps end where the series jumps, each instance's at lengths of its own; rows lie there and between."""
    series = lamc.Series(np.linspace(0.0, 0.25, 6), 1e-3 * np.array([0.0, 1.0, -2.0, 1.5, 0.5, 0.0]), hold)
    scene = lamc.Scene(
        effects=(DROPPED, lamc.Torque({"j0": "command"}), *effects),
        inputs={"command": lamc.Input(unit="N*m", series=series)},
        rates={"j0": -4.0, "j4": -3.0},
    )
    sim = lamc.compile(five_bar(), scene)
    parameters = {"l0.mass": np.linspace(0.001, 0.004, 11)}
    how = {"t_end": 0.2, "rtol": 1e-7, "integrator": "dop853"}
    many = sim.ensemble(t_eval=np.linspace(0.0, 0.2, 17), parameters=parameters, **how)
    assert_beside(many)
    assert bool(many.stats.events.min() > 0) is bool(effects)
    assert_alike(sim, many, parameters, **how)


@pytest.mark.parametrize("name", LARGE)
def test_large_loops_run_one_after_the_other_and_say_so(name: str) -> None:
    sim = example(name)
    parameters = spread(sim, 3, 3)
    how = {"t_end": 0.05, "rtol": 1e-6, "integrator": "dop853"}
    many = sim.ensemble(t_eval=[0.0, 0.05], parameters=parameters, **how)
    assert many.stats.lanes == 1
    assert "loops of more than 10 hinges" in many.stats.why_alone
    assert_alike(sim, many, parameters, **how)

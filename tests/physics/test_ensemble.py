"""Ensembles: each instance is the run by itself, to the last bit, whoever is beside it; and what one is told of it."""

import pickle
import threading
import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import lamc
from lamc.run.request import Status
from tests.support.ensembles import assert_alike, spread
from tests.support.every_effect import SAMPLES
from tests.support.every_effect import mechanism as two_links
from tests.support.mechanisms import ALL_PASSIVE, chain, random_tree
from tests.support.quick import tries

T = np.linspace(0.0, 0.5, 6)  # s


@pytest.mark.slow
@settings(max_examples=tries(20), deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    n=st.integers(1, 6),
    seed=st.integers(0, 2**16),
    kind=st.sampled_from(("space", "parallel", "mixed")),
    integrator=st.sampled_from(("rk45", "dop853", "auto")),
    count=st.integers(1, 19),
    exponent=st.integers(-11, -3),
)
def test_instances_of_a_tree_are_runs_by_themselves(
    n: int, seed: int, kind: str, integrator: str, count: int, exponent: int
) -> None:
    mechanism = random_tree(n, seed, kind)
    sim = lamc.compile(mechanism, lamc.Scene(effects=ALL_PASSIVE, angles={mechanism.joints[0].name: 0.8}))
    parameters = spread(sim, count, seed)
    how = {"t_end": 0.5, "rtol": 10.0**exponent, "integrator": integrator}
    many = sim.ensemble(t_eval=T, parameters=parameters, **how)
    assert many.stats.lanes in (2, 4, 8)
    assert_alike(sim, many, parameters, **how)


@pytest.mark.quick("blade_element_drag", "free_base", "ground_contact", "nonlinear_stiffness")
@pytest.mark.parametrize("name", sorted(SAMPLES))
@pytest.mark.ci(
    "blade_element_drag",
    "free_base",
    "ground_contact",
    "nonlinear_stiffness",
    "base_motion",
    "flexible_links",
    "servo",
    "joint_limits",
    "twist_compliance",
)
def test_instances_with_any_effect_are_runs_by_themselves(name: str) -> None:
    effects = (SAMPLES[name],) if name == "gravity" else (SAMPLES["gravity"], SAMPLES[name])
    sim = lamc.compile(two_links(), lamc.Scene(effects=effects, angles={"h2": 0.4}, rates={"h1": 1.0}))
    parameters = spread(sim, 11, 3)
    how = {"t_end": 0.4, "rtol": 1e-7, "integrator": "dop853", "max_steps": 4000}
    many = sim.ensemble(t_eval=[0.0, 0.1, 0.4], parameters=parameters, **how)
    assert_alike(sim, many, parameters, **how)


@pytest.mark.parametrize(
    "effect", [lamc.JointLimits(restitution=0.6), lamc.JointLimits(stiffness=300.0, damping=0.5)]
)
@pytest.mark.parametrize("integrator", ["rk45", "dop853"])
def test_instances_meet_their_own_events(effect: Any, integrator: str) -> None:
    """Impacts, and limits that give way: every instance at its own times."""
    gravity = lamc.Gravity((0.0, 0.0, -9.81))
    sim = lamc.compile(two_links(), lamc.Scene(effects=(gravity, effect), rates={"h1": 2.0}))
    parameters = {"a.mass": np.linspace(0.5, 2.0, 13), "b.mass": np.linspace(1.0, 0.3, 13)}
    how = {"t_end": 1.0, "rtol": 1e-8, "integrator": integrator}
    many = sim.ensemble(t_eval=np.linspace(0.0, 1.0, 21), parameters=parameters, **how)
    assert many.stats.events.min() > 0
    assert len(set(many.stats.events.tolist())) > 1
    assert_alike(sim, many, parameters, **how)
    assert len(many.result(4).events) == many.stats.events[4]


def test_angles_and_rates_are_those_of_a_scene() -> None:
    mechanism = chain(3)
    first, second, _ = (joint.name for joint in mechanism.joints)
    scene = lamc.Scene(effects=ALL_PASSIVE, angles={second: 0.3})
    angles, rates = np.linspace(-2.0, 2.0, 9), np.linspace(1.0, -1.0, 9)
    many = lamc.compile(mechanism, scene).ensemble(1.0, angles={first: angles}, rates={second: rates})
    for k in (0, 4, 8):
        own = replace(scene, angles={first: angles[k], second: 0.3}, rates={second: rates[k]})
        one = lamc.compile(mechanism, own).run(1.0, t_eval=[0.0, 1.0])
        assert many.q[k].tobytes() == one.q.tobytes()
        assert many.u[k].tobytes() == one.u.tobytes()


def test_stiff_instances_leave_the_lanes() -> None:
    """The integrator "auto" turns to an implicit one where that pays; others go on side by side."""
    sim = lamc.compile(chain(2, "parallel"), lamc.Scene(effects=ALL_PASSIVE))
    (joint,) = sim.joints[:1]
    parameters = {f"{joint}.damping": np.geomspace(0.1, 1e5, 10)}
    how = {"t_end": 2.0, "rtol": 1e-5}
    many = sim.ensemble(t_eval=[0.0, 2.0], parameters=parameters, **how)
    assert {"rk45"} < set(many.stats.integrators)
    assert "implicit" in many.stats.why_alone
    assert_alike(sim, many, parameters, **how)


@pytest.mark.parametrize("integrator", ["rodas5p", "radau5"])
def test_implicit_methods_run_one_after_the_other_and_say_so(integrator: str) -> None:
    sim = lamc.compile(chain(2, "parallel"), lamc.Scene(effects=ALL_PASSIVE))
    parameters = spread(sim, 5, 1)
    how = {"t_end": 0.5, "rtol": 1e-6, "integrator": integrator}
    many = sim.ensemble(t_eval=T, parameters=parameters, **how)
    assert many.stats.lanes == 1
    assert "implicit" in many.stats.why_alone
    assert_alike(sim, many, parameters, **how)


def test_an_instance_that_fails_leaves_the_others_alone() -> None:
    """One that oscillates too fast for its steps stops; its rows from there on are NaN, and it says where."""
    sim = lamc.compile(chain(2, "parallel"), lamc.Scene(effects=ALL_PASSIVE))
    (joint,) = sim.joints[:1]
    stiffness = np.array([1.0, 1e12, 2.0, 3.0])
    how = {"t_end": 1.0, "rtol": 1e-9, "integrator": "dop853", "max_steps": 500}
    many = sim.ensemble(
        t_eval=[0.0, 1.0], parameters={f"{joint}.stiffness": stiffness}, angles={joint: 0.1}, **how
    )
    assert many.status.tolist() == [0, int(Status.STEP_LIMIT), 0, 0]
    assert many.success.tolist() == [True, False, True, True]
    assert np.isfinite(many.q[1, 0]).all()
    assert np.isnan(many.q[1, 1]).all()
    assert 0.0 < many.t_reached[1] < 1.0
    assert "500 steps" in many.message(1)
    assert "the end was reached" in many.message(0)
    assert "1 ended early" in repr(many)


def test_threads_change_no_bit() -> None:
    sim = lamc.compile(chain(3), lamc.Scene(effects=ALL_PASSIVE))
    parameters = spread(sim, 40, 5)
    whole, *others = (
        sim.ensemble(0.5, 1e-6, parameters=parameters, threads=threads, side_by_side=beside)
        for threads, beside in ((1, True), (3, True), (2, False))
    )
    assert [each.stats.threads for each in others] == [3, 2]
    for each in others:
        assert each.q.tobytes() == whole.q.tobytes()
        assert each.stats.evaluations.tolist() == whole.stats.evaluations.tolist()
    assert others[1].stats.lanes == 1
    assert others[1].stats.why_alone == "side_by_side is off"


def test_an_interrupt_keeps_what_there_is(monkeypatch: pytest.MonkeyPatch) -> None:
    sim = lamc.compile(chain(3), lamc.Scene(effects=ALL_PASSIVE))
    sim.ensemble(0.0)

    def interrupted(begun: float, instances: float) -> None:
        if begun > 100:
            raise KeyboardInterrupt

    parameters = spread(sim, 200_000, 5)
    started = time.perf_counter()
    many = sim.ensemble(3.0, parameters=parameters, progress=interrupted, threads=2)
    taken = time.perf_counter() - started
    statuses = set(many.status.tolist())
    assert statuses == {int(Status.REACHED_END), int(Status.CANCELLED)}
    assert "cancelled" in many.message(len(many) - 1)
    assert threading.active_count() < 10
    assert taken < 60.0  # the whole takes minutes: chains of three at 1e-9 over 3 s


def test_rows_default_to_start_and_end() -> None:
    sim = lamc.compile(chain(2), lamc.Scene(effects=ALL_PASSIVE))
    many = sim.ensemble(0.25, parameters={f"{sim.joints[0]}.damping": [0.1, 0.2, 0.3]})
    assert many.t.tolist() == [0.0, 0.25]
    assert many.q.shape == many.u.shape == (3, 2, 2)
    assert (many.status.shape, many.t_reached.shape, len(many)) == ((3,), (3,), 3)
    assert sim.ensemble(0.0).t.tolist() == [0.0]


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ({"parameters": {"h1.stifness": [1.0, 2.0]}}, "did you mean 'h1.stiffness'"),
        ({"parameters": {"h1.stiffness": [1.0, 2.0], "h2.damping": [1.0]}}, "has 2 values"),
        ({"parameters": {"h1.stiffness": [1.0, float("nan")]}}, "is nan in instance 1"),
        ({"parameters": {"h1.stiffness": [1.0, -2.0]}}, "instance 1: .*a stiffness must be zero or more"),
        ({"parameters": {"h1.stiffness": [[1.0, 2.0]]}}, "one-dimensional"),
        ({"parameters": {"h1.stiffness": "3 kg"}}, "h1.stiffness"),
        ({"parameters": {"h1.stiffness": [True, False]}}, "truth"),
        ({"parameters": [1.0]}, "must map names"),
        ({"angles": {"h3": [1.0]}}, "no joint is named 'h3'"),
        ({"rates": {"h1": ["x"]}}, "must be a number or an array in rad/s"),
        ({"integrator": "scipy:LSODA"}, "ensembles have no integrator"),
        ({"threads": 0}, "threads is 0"),
        ({"t_eval": [0.2, 0.1]}, "ascend"),
        (
            {"t_eval": np.linspace(0.0, 1.0, 10**6), "angles": {"h1": np.zeros(10**6)}},
            "more than there is memory",
        ),
    ],
)
def test_arguments_that_make_no_ensemble_are_refused(how: dict[str, Any], says: str) -> None:
    sim = lamc.compile(two_links(), lamc.Scene(effects=(lamc.HingeStiffness(), lamc.HingeDamping())))
    with pytest.raises(lamc.RequestError, match=says):
        sim.ensemble(1.0, **how)


def test_an_ensemble_can_be_pickled() -> None:
    sim = lamc.compile(chain(2), lamc.Scene(effects=ALL_PASSIVE))
    many = sim.ensemble(0.2, parameters={f"{sim.joints[0]}.damping": [0.1, 0.2]})
    again = pickle.loads(pickle.dumps(many))
    assert again.q.tobytes() == many.q.tobytes()
    assert again.result(1).q.tobytes() == many.q[1].tobytes()


def test_text_with_a_unit_serves_all_instances() -> None:
    sim = lamc.compile(two_links(), lamc.Scene(effects=(lamc.HingeStiffness(), lamc.HingeDamping())))
    said = sim.ensemble(0.2, parameters={"h1.stiffness": "800 N*mm/rad", "h2.damping": [0.1, 0.2]})
    given_ = sim.ensemble(0.2, parameters={"h1.stiffness": 0.8, "h2.damping": [0.1, 0.2]})
    assert said.q.tobytes() == given_.q.tobytes()


def test_a_start_that_an_effect_refuses_is_one_instance_without_rows() -> None:
    sim = lamc.compile(two_links(), lamc.Scene(effects=(lamc.JointLimits(restitution=0.5),)))
    many = sim.ensemble(0.2, angles={"h1": [0.0, 2.0, 0.1]})
    assert many.status.tolist() == [0, int(Status.FAILED), 0]
    assert np.isnan(many.q[1]).all()
    assert "did not start" in many.message(1)
    with pytest.raises(lamc.RequestError, match="instance 1 did not start"):
        many.result(1)


def test_another_design_of_the_topology_has_ensembles_of_its_own() -> None:
    """Numbers of the drawing go with the instances: lanes are compiled once, and each design has its runs' bits."""
    mechanism = chain(3)
    moved = replace(
        mechanism, bodies=tuple(replace(body, com=1.1 * np.asarray(body.com)) for body in mechanism.bodies)
    )
    scene = lamc.Scene(effects=ALL_PASSIVE)
    sims = [lamc.compile(each, scene) for each in (mechanism, moved)]
    first = sims[0].joints[0]
    ends = []
    for sim in sims:
        parameters = {f"{first}.damping": np.linspace(0.1, 0.3, 9)}
        how = {"t_end": 0.5, "rtol": 1e-7, "integrator": "dop853"}
        many = sim.ensemble(t_eval=T, angles={first: sim.start[0]}, parameters=parameters, **how)
        assert_alike(sim, many, parameters, **how)
        ends.append(many.q[:, -1])
    assert np.abs(ends[0] - ends[1]).min(axis=1).max() > 0.0

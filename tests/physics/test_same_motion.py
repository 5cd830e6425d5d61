"""One device told otherwise: mirror images, other names and orders, joints from their child, other cut hinges."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

import lamc
from lamc import Body, Joint, Mechanism, Scene
from lamc.effects import Gravity, HingeStiffness, RestAngle
from lamc.mechanism import spanning
from lamc.reference import NewtonEuler
from lamc.reference.closing import random_states
from tests.support.closed_mechanisms import ClosedMechanism, closed_mechanisms
from tests.support.ctools import needs_cc
from tests.support.quick import tries

pytestmark = needs_cc

PULL = np.array([0.3, -0.7, -9.81])  # m/s²
MIRROR = np.diag([-1.0, 1.0, 1.0])
T_END = 0.2  # s: random spatial linkages draw apart by some hundred times the error of a step within it


def mirrored(mechanism: Mechanism) -> Mechanism:
    """The image by x -> -x; a right-handed turn becomes a left-handed one, about the axis the other way."""
    bodies = tuple(
        body if body.fixed else replace(body, com=MIRROR @ body.com, inertia=MIRROR @ body.inertia @ MIRROR)
        for body in mechanism.bodies
    )
    joints = tuple(replace(j, point=MIRROR @ j.point, axis=-MIRROR @ j.axis) for j in mechanism.joints)
    return replace(mechanism, bodies=bodies, joints=joints)


def renamed(mechanism: Mechanism, seed: int) -> Mechanism:
    """Other names for bodies, and all in another order. Joints keep theirs, by which angles are compared."""
    random = np.random.default_rng(seed)
    names = {
        body.name: f"part{k}"
        for k, body in enumerate(random.permutation(np.array(mechanism.bodies, dtype=object)))
    }
    bodies: list[Body] = [replace(body, name=names[body.name]) for body in mechanism.bodies]
    joints: list[Joint] = [replace(j, parent=names[j.parent], child=names[j.child]) for j in mechanism.joints]
    random.shuffle(bodies)
    random.shuffle(joints)
    return replace(mechanism, bodies=tuple(bodies), joints=tuple(joints))


def turned_round(mechanism: Mechanism) -> Mechanism:
    """Every other joint told from its child: the same angle about the axis the other way."""
    joints = tuple(
        replace(j, parent=j.child, child=j.parent, axis=-j.axis) if k % 2 else j
        for k, j in enumerate(mechanism.joints)
    )
    return replace(mechanism, joints=joints)


def run_of(mechanism: Mechanism, pull: np.ndarray, angles: dict[str, float], rates: dict[str, float]) -> Any:
    effects = (Gravity(tuple(pull.tolist())), HingeStiffness(), RestAngle())
    sim = lamc.compile(mechanism, Scene(effects=effects, angles=angles, rates=rates))
    return sim, sim.run(t_end=T_END, rtol=1e-12, atol=1e-14, t_eval=np.linspace(0.0, T_END, 21))


Changed = Callable[[Mechanism], Mechanism]


@pytest.mark.slow
@settings(
    max_examples=tries(10),
    phases=(Phase.explicit, Phase.reuse, Phase.generate),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(closed=closed_mechanisms(), seed=st.integers(0, 2**31), data=st.data())
def test_a_device_moves_the_same_however_it_is_told(
    closed: ClosedMechanism, seed: int, data: st.DataObject
) -> None:
    mechanism = closed.mechanism
    names = [joint.name for joint in mechanism.joints]
    newton = NewtonEuler(mechanism, (), names)
    states = random_states(newton, np.zeros(len(names)), 1, 1.0, seed)
    assume(bool(states))
    _, q, u = states[0]
    angles, rates = (dict(zip(names, values.tolist(), strict=True)) for values in (q, u))
    _, plain = run_of(mechanism, PULL, angles, rates)
    assume(plain.success and plain.stats.singular_steps == 0)
    how = data.draw(st.sampled_from(["mirrored", "renamed", "turned round", "cut elsewhere"]))
    with pytest.MonkeyPatch.context() as patch:
        if how == "cut elsewhere":
            shuffled = np.random.default_rng(seed).permutation(len(names))
            order = {name: int(place) for name, place in zip(names, shuffled, strict=True)}
            patch.setattr(spanning, "geometric_key", lambda joint, _: order[joint.name])
        changed: dict[str, Changed] = {
            "mirrored": mirrored,
            "renamed": lambda m: renamed(m, seed),
            "turned round": turned_round,
            "cut elsewhere": lambda m: replace(m, name=f"{m.name}_cut{seed}"),
        }
        pull = MIRROR @ PULL if how == "mirrored" else PULL
        _, other = run_of(changed[how](mechanism), pull, angles, rates)
    assert other.success
    limit = 1e-9 * max(1.0, float(np.abs(plain.q).max()))
    for name in names:
        np.testing.assert_allclose(other.angle(name), plain.angle(name), rtol=0.0, atol=limit)

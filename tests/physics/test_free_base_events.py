"""Impacts and stops where the base floats or is moved: impulses act along all coordinates, the base's among them."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc.effects import Gravity, HingeStiffness, JointLimits
from lamc.effects.base_motion import BaseMotion
from lamc.effects.free_base import FreeBase
from lamc.mechanics.loads import Loads
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.reference.moving_base import MovingNewtonEuler
from tests.support.ctools import needs_cc
from tests.support.floating import lone_body, momenta, with_base
from tests.support.general_motion import General
from tests.support.mechanisms import ALL_PASSIVE, chain, random_state, trees
from tests.support.quick import tries

Array = npt.NDArray[np.float64]


def limited(mechanism: Mechanism, angle: float) -> Mechanism:
    joints = tuple(replace(j, limits=(-angle, angle), stiffness=0.0) for j in mechanism.joints)
    return replace(mechanism, joints=joints)


@needs_cc
def test_impacts_within_a_floating_chain_change_neither_momentum_nor_energy() -> None:
    mechanism = limited(with_base(chain(2, "space", seed=3)), 0.4)
    spinning = FreeBase(velocity=(0.3, -0.2, 0.5), spin=(0.4, -0.6, 0.2))
    scene = Scene(effects=(JointLimits(restitution=1.0), spinning), rates={"h0": 2.0, "h1": -1.5})
    result = lamc.compile(mechanism, scene).run(2.0, rtol=1e-11, atol=1e-13, t_eval=np.linspace(0, 2, 41))
    assert len(result.events) >= 5
    first = np.array(momenta(mechanism, result.joints, result.q[0], result.u[0]))
    for q, u in zip(result.q, result.u, strict=True):
        now = np.array(momenta(mechanism, result.joints, q, u))
        assert np.abs(now - first).max() <= 1e-9 * np.abs(first).max()  # a run at rtol 1e-11
    assert np.abs(result.energy / result.energy[0] - 1.0).max() <= 1e-9


@dataclass(frozen=True)
class Floor:
    """A floor that the middle of a body bounces on."""

    restitution: float

    name: ClassVar[str] = "floor"
    summary: ClassVar[str] = "Floor at z = 0"

    def contribute(self, loads: Loads) -> None:
        loads.impact("floor", -loads.position("ground", (0.0, 0.0, 0.0))[2], self.restitution)


@needs_cc
def test_ball_that_falls_on_a_floor_bounces_as_high_as_newton_says() -> None:
    g, height, restitution = 9.81, 1.2, 0.8
    fallen = np.sqrt(2.0 * height / g)
    effects = (
        Gravity((0.0, 0.0, -g)),
        Floor(restitution),
        FreeBase(position=(0.3, 0.1, height), spin=(1, 2, 3)),
    )
    sim = lamc.compile(lone_body(0.5, 0.01 * np.eye(3)), Scene(effects=effects))
    t = fallen * (1.0 + restitution)  # the top of the first bounce
    result = sim.run(t, rtol=1e-10, atol=1e-12, t_eval=[0.0, t])
    assert [event.name for event in result.events] == ["floor"]
    assert result.events[0].t == pytest.approx(fallen, rel=1e-10)
    # the speck of dust weighs 1e-12 of the ball
    assert result.coordinate("base.z")[-1] == pytest.approx(height * restitution**2, rel=1e-9)
    assert result.coordinate("base.x")[-1] == pytest.approx(0.3, abs=1e-10)


@needs_cc
def test_elastic_stop_on_a_turning_base_keeps_jacobis_integral() -> None:
    mechanism = limited(chain(1, "space", seed=3), 0.3)
    moved = BaseMotion(angle="1.5*t", axis=(0.3, 1.0, 0.2))
    scene = Scene(effects=(JointLimits(restitution=1.0), moved), rates={"h0": 3.0})
    result = lamc.compile(mechanism, scene).run(1.0, rtol=1e-10, atol=1e-12, t_eval=np.linspace(0, 1, 21))
    assert len(result.events) >= 2
    # Jacobi's integral: on a base that turns steadily T₂ - T₀ stays, through elastic impacts too. T₂ is quadratic in
    # the hinge's rate, T₀ what is left without it.
    general = General(mechanism, (moved,))
    kept = []
    for t, q, u in zip(result.t, result.q, result.u, strict=True):
        mass = general.system(t, q, u)[0]
        kept.append(0.5 * mass[0, 0] * u[0] ** 2 - general.energy(t, q, np.zeros(1)))
    assert np.ptp(kept) <= 1e-8 * max(np.abs(kept))


@settings(max_examples=tries(25), deadline=None)
@given(mechanism=trees(5), seed=st.integers(0, 2**32 - 1))
def test_any_floating_tree_accelerates_as_newton_and_euler_say(mechanism: Mechanism, seed: int) -> None:
    mechanism = with_base(mechanism)
    effects = (*ALL_PASSIVE, FreeBase())
    general = General(mechanism, effects)
    joints = general.equations.joints
    rng = np.random.default_rng(seed)
    angles, rates = random_state(len(joints), seed)
    q, u = general.start(angles.tolist(), rates.tolist())
    q[-7:], u[-6:] = rng.normal(size=7), rng.normal(size=6)
    found, expected = (
        general.acceleration(0.0, q, u),
        MovingNewtonEuler(mechanism, effects, joints).acceleration(q, u),
    )
    condition = np.linalg.cond(general.system(0.0, q, u)[0])
    # round-off of some hundred operations, as the mass matrix magnifies it
    assert np.abs(found - expected).max() <= 1e-13 * condition * np.abs(expected).max() + 1e-12


def test_stiff_springs_between_base_and_links_are_inner_forces() -> None:
    mechanism = with_base(chain(2, "space", seed=9))
    general = General(mechanism, (HingeStiffness(), FreeBase()))
    q, u = general.start([1.0, -0.5], [0.0, 0.0])
    mass, force, _, _ = general.system(0.0, q, u)
    assert np.abs(force[2:]).max() <= 1e-14 * np.abs(force[:2]).max()  # none on the whole at rest
    assert np.linalg.eigvalsh(mass).min() > 0.0

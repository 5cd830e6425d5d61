"""Random mechanisms with loops: freedoms as theory has them, three cross-checks that agree, loops that stay closed,
energy that stays, or a run that ends with a status that is true."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

import lamc
from lamc import Scene
from lamc.effects import Gravity, HingeDamping, HingeStiffness, RestAngle, Torque
from lamc.loops.rank import count_loops
from lamc.mechanism.plan import plan
from lamc.reference import Interpreter, MaximalCoordinates, NewtonEuler, check
from lamc.reference.closing import State, random_states
from lamc.run.request import Status
from lamc.run.result import Result
from lamc.run.simulator import Simulator
from tests.support.closed_mechanisms import FAMILIES, ClosedMechanism, closed_mechanism, closed_mechanisms
from tests.support.ctools import needs_cc
from tests.support.quick import tries

pytestmark = needs_cc

CONSERVATIVE = (Gravity((0.3, -0.7, -9.81)), HingeStiffness(), RestAngle())
RTOL = 1e-8
AS_DRAWN = (Phase.explicit, Phase.reuse, Phase.generate)  # a smaller seed is no simpler mechanism
NEAR_SINGULAR = 30.0  # largest over least singular value of the closure's Jacobian


def effects_of(closed: ClosedMechanism, *, damped: bool) -> tuple[Any, ...]:
    """What stores energy; and for damped mechanisms what takes it, and a torque in t, angle and rate on every third
    hinge, which may be one that closes a loop."""
    if not damped:
        return CONSERVATIVE
    names = sorted(joint.name for joint in closed.mechanism.joints)[::3]
    return (
        *CONSERVATIVE,
        HingeDamping(),
        Torque(dict.fromkeys(names, "0.3*sin(2*pi*t) - 0.2*rate + cos(angle)")),
    )


def states_of(closed: ClosedMechanism, joints: Sequence[str], seed: int) -> list[State]:
    """Closed states that no part of the road to the C had a hand in; none where a loop is so near to singular all
    around its drawn position that states there tell of round-off."""
    cross_check = NewtonEuler(closed.mechanism, CONSERVATIVE, joints)
    states = random_states(cross_check, np.zeros(len(joints)), 3, 1.0, seed)
    for _, q, _ in states:
        assert len(joints) - cross_check.condition(q)[0] == closed.freedoms
    return states


def assert_cross_checks_agree(sim: Simulator, states: Sequence[State]) -> None:
    newton = NewtonEuler(sim.mechanism, sim.effects, sim.joints)
    maximal = MaximalCoordinates(sim.mechanism, sim.effects, sim.joints)
    interpreter = Interpreter(sim.program)
    constants = interpreter.constants()
    for t, q, u in states:
        found = sim.acceleration(q, u, t)
        # Round-off of positions, some 1e-14, times the condition of J for directions, and once more for what holds
        # them; ten for the masses.
        limit = 1e-13 * newton.condition(q)[1] ** 2 * np.abs(found).max()
        assert np.abs(found - interpreter.acceleration(t, q, u, constants)).max() <= limit
        assert np.abs(found - newton.acceleration(q, u, t)).max() <= limit
        assert np.abs(found - maximal.acceleration(q, u, t)).max() <= limit


def started(sim: Simulator, state: State) -> Simulator:
    """The same mechanism with its start at a state."""
    _, q, u = state
    angles, rates = (dict(zip(sim.joints, values.tolist(), strict=True)) for values in (q, u))
    return lamc.compile(sim.mechanism, Scene(effects=sim.effects, angles=angles, rates=rates))


def assert_reported_truly(sim: Simulator, result: Result) -> None:
    """A run that ends early has rows that close, and ends where the closure is about to lose rank."""
    assert result.status in (Status.CLOSURE_LOST, Status.STEP_UNDERFLOW, Status.STEP_LIMIT), result.message
    assert "stopped at t =" in result.message
    newton = NewtonEuler(sim.mechanism, sim.effects, sim.joints)
    rank, condition = newton.condition(result.q[-1])
    assert condition > NEAR_SINGULAR or rank < sim.loops.rank, result.message


def assert_energy_is_kept(result: Result, *, damped: bool) -> None:
    """A step errs by RTOL in angles and rates, root mean square, so by about as much of the energies in play; errors
    add up over the steps at worst. Undamped energy stays within that."""
    if damped:
        return  # a torque works
    in_play = sum(float(np.abs(energy).max()) for energy in result.energies.values())
    allowed = RTOL * result.stats.accepted * in_play
    assert np.abs(result.energy - result.energy[0]).max() <= allowed


def examine(closed: ClosedMechanism, seed: int, *, damped: bool) -> bool:
    """Whether there was a state to examine it at."""
    sim = lamc.compile(closed.mechanism, Scene(effects=effects_of(closed, damped=damped)))
    assert sim.loops.freedoms == closed.freedoms
    states = states_of(closed, sim.joints, seed)
    if not states:
        return False
    assert_cross_checks_agree(sim, states)
    result = started(sim, states[-1]).run(t_end=0.5, rtol=RTOL, atol=1e-2 * RTOL)
    # 1e-9 of the size: the project's bound for every row of every run
    assert result.constraint_error.max() <= 1e-9 * sim.mechanism.size
    assert_energy_is_kept(result, damped=damped)
    if not result.success:
        assert_reported_truly(sim, result)
    return True


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.quick("planar", "spherical", "bennett")
def test_every_family_closes_as_drawn_and_moves(family: str) -> None:
    assert examine(closed_mechanism(family, seed=5), seed=1, damped=False)


@pytest.mark.parametrize("seed", [138, 160, 264, 385, 418])
def test_a_joint_that_can_turn_little_does_not_lock_the_count(seed: int) -> None:
    """One joint of these loops turns back within some tenths of a radian; the loops move on all the same."""
    closed = closed_mechanism("bricard", seed)
    assert count_loops(plan(closed.mechanism)).freedoms == closed.freedoms


@pytest.mark.slow
@settings(
    max_examples=tries(15),
    phases=AS_DRAWN,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
@given(closed=closed_mechanisms(), seed=st.integers(0, 2**31), damped=st.booleans())
def test_random_closed_mechanisms(closed: ClosedMechanism, seed: int, damped: bool) -> None:
    assume(examine(closed, seed, damped=damped))


@pytest.mark.campaign
@settings(max_examples=250, phases=AS_DRAWN, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(closed=closed_mechanisms(), seed=st.integers(0, 2**31), damped=st.booleans())
def test_many_random_closed_mechanisms(closed: ClosedMechanism, seed: int, damped: bool) -> None:
    assume(examine(closed, seed, damped=damped))


@pytest.mark.parametrize("family", [pytest.param("bennett"), pytest.param("several", marks=pytest.mark.slow)])
def test_check_of_a_random_closed_mechanism_passes(family: str) -> None:
    closed = closed_mechanism(family, seed=8)
    sim = lamc.compile(closed.mechanism, Scene(effects=effects_of(closed, damped=True)))
    report = check(started(sim, states_of(closed, sim.joints, 2)[-1]), states=4, t_end=0.05)
    assert report.passed, report.table()

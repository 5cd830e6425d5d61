"""Impacts at one instant are solved together: no order of guards decides, symmetric machines stay symmetric."""

from itertools import chain as joined
from itertools import combinations

import numpy as np
import numpy.typing as npt
import pytest

import lamc
from lamc import Body, Joint, JointLimits, Mechanism, Scene

Array = npt.NDArray[np.float64]
DROPPED = lamc.Gravity((0.0, -9.81, 0.0))


def five_bar() -> Mechanism:
    """A plane five-bar that is its own mirror image, with limits at both ground hinges."""
    points = 0.05 * np.array([(0, 0, 0), (-0.4, 1, 0), (0.5, 1.9, 0), (1.4, 1, 0), (1, 0, 0)])
    links = [
        Body(f"l{i}", mass=0.002, com=(points[i] + points[i + 1]) / 2, inertia=np.diag([1e-7, 1e-6, 1e-6]))
        for i in range(4)
    ]
    ends = ["ground", "l0", "l1", "l2", "l3", "ground"]
    joints = []
    for i in range(5):
        parent, child = (ends[i], ends[i + 1]) if i < 3 else (ends[i + 1], ends[i])
        axis = (0, 0, 1) if i < 3 else (0, 0, -1)
        limits = (-0.6, 0.5) if i in (0, 4) else (-np.pi, np.pi)
        joints.append(Joint(f"j{i}", parent, child, point=points[i], axis=axis, limits=limits))
    return Mechanism((Body("ground", fixed=True), *links), tuple(joints))


@pytest.mark.parametrize("rtol", [1e-8, 1e-11])
@pytest.mark.parametrize("integrator", ["auto", "radau5"])
def test_a_symmetric_machine_stays_symmetric(rtol: float, integrator: str) -> None:
    sim = lamc.compile(
        five_bar(), Scene(effects=(DROPPED, JointLimits(restitution=1.0)), rates={"j0": -4.0, "j4": -4.0})
    )
    t = np.linspace(0.0, 0.4, 401)
    result = sim.run(t_end=0.4, rtol=rtol, atol=rtol / 100, t_eval=t, integrator=integrator)
    assert result.success
    # The loop is closed from one body on, and stages of a step are closed to its error only: what is symmetric differs
    # by a part of that, and not by what impacts taken one by one would make of it, which is 1 rad.
    assert np.abs(result.angle("j0") - result.angle("j4")).max() < max(1e-11, 0.1 * rtol)
    assert [e.name for e in result.events[:2]] == ["lower limit of j0", "lower limit of j4"]
    assert result.events[0].t == result.events[1].t
    scale = result.energies["kinetic"].max()
    assert np.abs(result.energy - result.energy[0]).max() < 300.0 * rtol * scale


def test_all_stops_of_one_instant_are_reported() -> None:
    scene = Scene(effects=(DROPPED, JointLimits(stiffness=1.0)), rates={"j0": -4.0, "j4": -4.0})
    result = lamc.compile(five_bar(), scene).run(t_end=0.4, rtol=1e-9, atol=1e-11)
    assert sorted(e.name for e in result.events) == ["lower limit of j0"] * 2 + ["lower limit of j4"] * 2


# ---- Against all choices of who acts -------------------------------------------------------------------------------


def plane_chain(count: int, seed: int) -> Mechanism:
    """Links in the plane, drawn at their upper limits."""
    rng = np.random.default_rng(seed)
    at, bodies, joints = np.zeros(3), [Body("ground", fixed=True)], []
    for i in range(count):
        arm = np.array([*rng.uniform(-1.0, 1.0, 2), 0.0])
        com = at + 0.5 * arm + [*rng.uniform(-0.1, 0.1, 2), 0.0]
        spin = rng.uniform(0.01, 0.3)
        bodies.append(Body(f"b{i}", rng.uniform(0.2, 2.0), com, np.diag([spin, spin, spin])))
        limits = (-1.0, 0.0)
        joints.append(Joint(f"h{i}", bodies[-2].name, f"b{i}", at.copy(), (0, 0, 1), limits=limits))
        at = at + arm
    return Mechanism(tuple(bodies), tuple(joints))


def mass_matrix(mechanism: Mechanism) -> Array:
    """M at the drawn position, by velocities of the centres."""
    count = len(mechanism.joints)
    mass = np.zeros((count, count))
    for i, body in enumerate(b for b in mechanism.bodies if not b.fixed):
        rotations = np.array([1.0 if j <= i else 0.0 for j in range(count)])
        arms = np.array([body.com - joint.point for joint in mechanism.joints])
        moves = np.array([-arms[:, 1], arms[:, 0]]) * rotations
        mass += body.mass * moves.T @ moves + body.inertia[2, 2] * np.outer(rotations, rotations)
    return mass


def rates_after(mass: Array, rates: Array, restitution: float) -> Array:
    """Newton's law for each guard by trying every choice of those that act."""
    count = len(rates)
    yielding, goal = np.linalg.inv(mass), (1.0 + restitution) * rates
    found = []
    for acting in joined.from_iterable(combinations(range(count), k) for k in range(1, count + 1)):
        index = list(acting)
        impulse = np.zeros(count)
        impulse[index] = np.linalg.solve(yielding[np.ix_(index, index)], goal[index])
        after = rates - yielding @ impulse
        if (impulse >= 0.0).all() and (after + restitution * rates <= 1e-9 * np.abs(rates).max()).all():
            found.append(after)
    assert found
    assert all(np.abs(after - found[0]).max() < 1e-6 for after in found)
    return found[0]


@pytest.mark.parametrize("count", [2, 3, 4])
@pytest.mark.parametrize("restitution", [1.0, 0.4])
@pytest.mark.quick("1.0-3")
def test_rates_after_impacts_are_those_that_newtons_law_allows(count: int, restitution: float) -> None:
    several = 0
    for seed in range(6):
        mechanism = plane_chain(count, seed)
        rates = np.random.default_rng(100 + seed).uniform(0.05, 5.0, count)
        scene = Scene(
            effects=(JointLimits(restitution=restitution),),
            rates={f"h{i}": float(rates[i]) for i in range(count)},
        )
        sim = lamc.compile(mechanism, scene)
        result = sim.run(t_end=1e-10, t_eval=[1e-10])
        assert result.success
        got = np.array([result.rate(f"h{i}")[-1] for i in range(count)])
        mass = mass_matrix(mechanism)
        expected = rates_after(mass, rates, restitution)
        several += int(np.sum(np.abs(expected + restitution * rates) < 1e-9) < count)
        # accelerations of some 1e2 rad/s^2 within 1e-10 s
        np.testing.assert_allclose(got, expected, rtol=0, atol=1e-6)
        before, after = rates @ mass @ rates, got @ mass @ got
        assert after <= before * (1.0 + 1e-7)
        if restitution == 1.0:
            np.testing.assert_allclose(after, before, rtol=1e-6)  # as above
    assert several > 0 or count != 3  # some guards are driven apart by the others alone


def test_guards_that_say_the_same_share_one_impulse() -> None:
    """A four-bar has one freedom: two limits at one instant ask for the same impulse."""
    points = 0.1 * np.array([(0, 0, 0), (0.1, 0.6, 0), (1.1, 0.8, 0), (1.2, 0, 0)])
    links = [
        Body(f"l{i}", mass=0.01, com=(points[i] + points[i + 1]) / 2, inertia=np.diag([1e-6, 1e-6, 1.5e-6]))
        for i in range(3)
    ]
    ends = ["ground", "l0", "l1", "l2"]
    joints = tuple(
        Joint(
            f"j{i}",
            ends[i],
            ends[(i + 1) % 4],
            point=points[i],
            axis=(0, 0, 1 if i < 3 else -1),
            limits=(-1.0, 0.0) if i in (0, 3) else (-np.pi, np.pi),
        )
        for i in range(4)
    )
    mechanism = Mechanism((Body("ground", fixed=True), *links), joints)
    sim = lamc.compile(mechanism, Scene(effects=(JointLimits(restitution=0.5),), rates={"j0": 2.0}))
    start = sim.run(t_end=0.0)
    result = sim.run(t_end=1e-10, t_eval=[1e-10])
    before, after = (np.array([r.rate(f"j{i}")[-1] for i in range(4)]) for r in (start, result))
    if before[3] > 0.0:
        np.testing.assert_allclose(after, -0.5 * before, rtol=0, atol=1e-6)  # as above
    else:
        pytest.fail(f"the limits are not struck together: {before}")

"""The reference cross-checks on loops: against published answers, each other, closed forms; and `check` on loops."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lamc
from lamc import Body, Joint, Mechanism, Scene, Spring
from lamc.basics.errors import UnsupportedError
from lamc.effects import Gravity, HingeDamping, HingeStiffness, RestAngle, Torque
from lamc.effects.limits import JointLimits
from lamc.loops.rings import rotation_vectors
from lamc.reference import MaximalCoordinates, NewtonEuler, check, simulate
from lamc.reference.closing import nudged, on_closure, random_states, settled
from lamc.reference.constrained import constrained
from lamc.reference.sympy_kane import kane
from lamc.run.simulator import Simulator
from tests.support.mechanisms import from_reference

LOOPS = ("fourbar_crank", "fivebar", "vertex4_flatfoldable", "waterbomb6", "miura33", "bricard", "sarrus")


@pytest.fixture(scope="module")
def cases(shared: Path) -> dict[str, Any]:
    text = (shared / "reference" / "dynamics.json").read_text(encoding="utf-8")
    return {case["id"]: case for case in json.loads(text)["cases"]}


def compiled(case: dict[str, Any]) -> Simulator:
    mechanism, scene = from_reference(case["spec"])
    return lamc.compile(mechanism, scene)


def relative(found: Any, expected: Any) -> float:
    return float(np.abs(np.asarray(found) - expected).max() / np.abs(expected).max())


@pytest.mark.parametrize("name", ["sarrus", "vertex4_flatfoldable", "bricard"])
def test_the_numeric_cross_check_moves_as_computed_independently(cases: dict[str, Any], name: str) -> None:
    """Without the C: the cross-check's own motion, from the published start to the first published row after it."""
    mechanism, scene = from_reference(cases[name]["spec"])
    joints = lamc.compile(mechanism, scene).joints
    cross_check = NewtonEuler(mechanism, scene.effects or (), joints)
    start = np.array([scene.angles.get(j, 0.0) for j in joints] + [scene.rates.get(j, 0.0) for j in joints])
    q, u, gap = settled(cross_check, start[: len(joints)], start[len(joints) :])
    assert gap < 1e-13 * mechanism.size  # round-off of positions
    assert np.abs(q - start[: len(joints)]).max() < 1e-6  # the file gives all angles of a closed start
    k = next(k for k, row in enumerate(cases[name]["expected"]) if row["t"] > 0.0)
    row, tol = cases[name]["expected"][k], cases[name]["tol"][k]
    times = np.array([row["t"]])
    motion = on_closure(cross_check, cross_check.acceleration, cross_check.condition(q)[0])
    run = simulate(motion, np.concatenate([q, u]), joints, times, 1e-9, 1e-11, "DOP853")
    found = dict(zip(joints, run.q[0], strict=True))
    for joint, angle in row["theta"].items():
        difference = math.remainder(found[joint] - angle, 2 * math.pi)
        assert abs(difference) < max(tol, 1e-6), joint  # the file's own rule for what it accepts


@pytest.mark.parametrize("name", LOOPS)
def test_three_formulations_agree_on_closed_states(cases: dict[str, Any], name: str) -> None:
    sim = compiled(cases[name])
    newton = NewtonEuler(sim.mechanism, sim.effects, sim.joints)
    maximal = MaximalCoordinates(sim.mechanism, sim.effects, sim.joints)
    states = random_states(newton, sim.start[: len(sim.joints)], 4, 1.0, seed=3)
    assert len(states) >= 3
    for t, q, u in states:
        expected = newton.acceleration(q, u, t)
        # 1e-10: round-off, 1e-16, times the square of the closure's condition, at most 1e2 in `random_states`
        assert relative(maximal.acceleration(q, u, t), expected) < 1e-10
        assert relative(sim.acceleration(q, u, t), expected) < 1e-10


def test_accelerations_of_cut_hinges_are_the_change_of_their_rates(cases: dict[str, Any]) -> None:
    """u + h u̇ keeps the loops closed at q + h u + h² u̇ / 2 but for what a third derivative does to J u."""
    sim = compiled(cases["vertex4_flatfoldable"])
    newton = NewtonEuler(sim.mechanism, sim.effects, sim.joints)
    maximal = MaximalCoordinates(sim.mechanism, sim.effects, sim.joints)
    for _, q, u in random_states(newton, sim.start[: len(sim.joints)], 3, 1.0, seed=1):
        found = maximal.acceleration(q, u)
        h = (
            1e-5 / np.abs(u).max()
        )  # s; central differences err by h² times a third derivative, some 1e-10 of it
        ahead, behind = (
            newton.gaps(q + s * h * u + 0.5 * h * h * found)[1] @ (u + s * h * found) for s in (1, -1)
        )
        scale = newton.size * np.abs(found).max()
        assert np.abs((ahead - behind) / (2 * h)).max() < 1e-6 * scale


def test_redundant_equations_have_one_acceleration() -> None:
    """Two unit masses on a line tied together: 3 N on the first moves both at 1.5, however often it is said."""
    mass, force = np.eye(2), np.array([3.0, 0.0])
    tie = np.array([[1.0, -1.0]])
    for copies in (1, 2, 7):
        rows = np.tile(tie, (copies, 1))
        found = constrained(mass, force, rows, np.zeros(copies))
        assert found == pytest.approx([1.5, 1.5], rel=1e-14)  # a few roundings
    apart = constrained(mass, force, tie, np.array([1.0]))  # the tie shortens: a1 - a2 + 1 = 0
    assert apart == pytest.approx([1.0, 2.0], rel=1e-14)


def parallelogram() -> tuple[Mechanism, float]:
    """Two cranks of length a = 0.3 m on the ground 0.5 m apart, both of mass m, moment I about the pin, and a coupler
    of mass M that they carry in parallel: it never turns. One pin, at the coupler, closes the loop."""
    a, b, m, M, moment = 0.3, 0.5, 0.7, 1.1, 0.013
    rotation = np.diag([moment, moment, moment])
    bodies = (
        Body("ground", fixed=True),
        Body("left", m, (0.0, -0.5 * a, 0.0), rotation),
        Body("right", m, (b, -0.5 * a, 0.0), rotation),
        Body("coupler", M, (0.2, -a, 0.1), np.diag([0.03, 0.02, 0.04])),
    )
    z = (0.0, 0.0, 1.0)
    joints = (
        Joint("l", "ground", "left", (0.0, 0.0, 0.0), z),
        Joint("r", "right", "ground", (b, 0.0, 0.0), z),
        Joint("lc", "left", "coupler", (0.0, -a, 0.0), z),
        Joint("rc", "coupler", "right", (b, -a, 0.0), z),
    )
    # per crank I + m (a/2)², and the coupler moves on a circle of radius a
    return Mechanism(bodies, joints, name="parallelogram"), 2 * (moment + m * a * a / 4) + M * a * a


@pytest.mark.parametrize("joint", ["l", "r", "lc", "rc"])
def test_torques_on_every_hinge_of_a_loop_do_their_work(joint: str) -> None:
    """The parallelogram has one angle θ = l: l and rc open with it, and r and lc against it, drawn as they are; so each
    torque τ gives I θ'' = ±τ, whichever hinge closes the loop, for every cross-check and for the C."""
    mechanism, inertia = parallelogram()
    torque = 0.6
    signs = {"l": 1.0, "r": -1.0, "lc": -1.0, "rc": 1.0}
    scene = Scene(effects=(Torque({joint: torque}),), angles={"l": 0.4})
    sim = lamc.compile(mechanism, scene)
    state = sim.start
    assert sim.cut_joints
    cross_checks = [v(mechanism, sim.effects, sim.joints) for v in (NewtonEuler, MaximalCoordinates)]
    for acceleration in (sim.acceleration, *(v.acceleration for v in cross_checks)):
        found = acceleration(state[:4], state[4:])[sim.joints.index("l")]
        assert found == pytest.approx(signs[joint] * torque / inertia, rel=1e-12)  # one small solve


def test_springs_and_dampers_of_all_hinges_act_on_the_parallelogram() -> None:
    """I θ'' = -Σ k (θ - θ₀) - Σ c θ' over the four hinges, with rest angles along each hinge's own sense."""
    mechanism, inertia = parallelogram()
    signs = {"l": 1.0, "r": -1.0, "lc": -1.0, "rc": 1.0}
    values = {"l": (1.0, 0.1, 0.2), "r": (2.0, 0.2, -0.3), "lc": (3.0, 0.3, 0.5), "rc": (4.0, 0.4, 0.1)}
    joints = tuple(
        Joint(j.name, j.parent, j.child, j.point, j.axis, *values[j.name]) for j in mechanism.joints
    )
    theta, rate = 0.4, 1.3
    expected = sum(
        s * (-k * (s * theta - rest) - c * s * rate)
        for s, (k, c, rest) in ((signs[n], values[n]) for n in values)
    )
    effects = (HingeStiffness(), HingeDamping(), RestAngle())
    sprung = Mechanism(mechanism.bodies, joints)
    sim = lamc.compile(sprung, Scene(effects=effects, angles={"l": theta}, rates={"l": rate}))
    q, u = sim.start[:4], sim.start[4:]
    stored = sum(0.5 * k * (signs[n] * theta - rest) ** 2 for n, (k, _, rest) in values.items())
    kinetic = 0.5 * inertia * rate**2
    newton = NewtonEuler(sprung, effects, sim.joints)
    assert sum(newton.energy(q, u).values()) == pytest.approx(
        stored + kinetic, rel=1e-12
    )  # sums of ten terms
    for acceleration in (sim.acceleration, newton.acceleration):
        found = acceleration(q, u)[sim.joints.index("l")]
        assert found == pytest.approx(expected / inertia, rel=1e-12)  # one small solve


def test_a_spring_between_points_pulls_in_every_cross_check() -> None:
    """A bar of moment 4e-3 kg·m² about its pin; k (l - l0) + c l' along the line to the wall, by hand."""
    bar = Body("bar", 0.1, (0.1, 0.0, 0.0), np.diag([1e-4, 3e-3, 3e-3]))
    mechanism = Mechanism((Body("wall", fixed=True), bar), (Joint("pin", "wall", "bar"),))
    k, rest, c, angle, rate = 7.0, 0.25, 0.3, -0.4, 1.7
    effects = (
        Spring("wall", (0.5, 0.1, 0), "bar", (0.2, 0, 0), k, rest, c),
        Spring("bar", (0.2, 0, 0), "wall", (0, 1, 0), 2.0),
    )
    tip = 0.2 * np.array([math.cos(angle), math.sin(angle)])
    velocity = 0.2 * rate * np.array([-math.sin(angle), math.cos(angle)])
    line = tip - np.array([0.5, 0.1])
    length = float(np.linalg.norm(line))
    force = -(k * (length - rest) + c * float(line @ velocity) / length) * line / length
    force = force - 2.0 * (tip - np.array([0.0, 1.0]))
    expected = (tip[0] * force[1] - tip[1] * force[0]) / 4e-3
    q, u = np.array([angle]), np.array([rate])
    for cross_check in (NewtonEuler, MaximalCoordinates):
        found = cross_check(mechanism, effects).acceleration(q, u)[0]
        assert found == pytest.approx(expected, rel=1e-12)  # a few roundings and a small solve
    stored = 0.5 * k * (length - rest) ** 2 + float((tip - [0.0, 1.0]) @ (tip - [0.0, 1.0]))
    assert NewtonEuler(mechanism, effects).energy(q, u)["spring"] == pytest.approx(stored, rel=1e-13)


def test_states_beside_closed_ones_settle_and_nudges_stay_closed(cases: dict[str, Any]) -> None:
    sim = compiled(cases["bricard"])
    cross_check = NewtonEuler(sim.mechanism, sim.effects, sim.joints)
    n = len(sim.joints)
    moved = nudged(cross_check, sim.start, 1e-3)
    assert np.abs(moved - sim.start).max() > 1e-4
    assert np.abs(cross_check.gaps(moved[:n])[0]).max() < 1e-13 * sim.mechanism.size  # round-off of positions
    off = sim.start[:n] + 1e-6
    # Redundant equations count as independent ones off closure; settled first, the acceleration is that beside.
    rank = cross_check.condition(sim.start[:n])[0]
    beside = on_closure(cross_check, cross_check.acceleration, rank)(off, sim.start[n:], 0.0)
    assert (
        relative(beside, cross_check.acceleration(sim.start[:n], sim.start[n:])) < 1e-4
    )  # 1e-6 times some curvature


def test_a_place_where_axes_run_against_each_other_is_not_closed() -> None:
    """A crank, a coupler and a hinge back to the ground at one line: turned over, all equations hold but one."""
    mechanism, _ = parallelogram()
    flipped = Mechanism(
        (*mechanism.bodies[:2],),
        (
            Joint("along", "ground", "left", (0, 0, 0), (1, 0, 0)),
            Joint("across", "ground", "left", (0, 0, 0), (0, 0, 1)),
        ),
    )
    cross_check = NewtonEuler(flipped, ())
    assert settled(cross_check, np.zeros(2), np.zeros(2))[2] < 1e-13
    around = np.array([math.pi, math.pi])
    residual, _ = cross_check.gaps(around)
    assert np.abs(residual).max() < 1e-12  # of sizes of 0.3 m: the equations do not tell
    assert settled(cross_check, around, np.zeros(2))[2] == math.inf


@pytest.mark.parametrize("name", ["vertex4_flatfoldable", "sarrus", "nfourbar2"])
@pytest.mark.quick("nfourbar2", others="campaign")
def test_check_of_loops_compares_all_cross_checks(cases: dict[str, Any], name: str) -> None:
    report = check(compiled(cases[name]), states=4, t_end=0.05)
    assert report.passed, report.table()
    compared = {(c.quantity, c.cross_checks[1]) for c in report.comparisons if c.compared}
    for quantity in (
        "accelerations, random states",
        "closure, residuals",
        "angles of the run",
    ):
        assert {(quantity, "interpreter"), (quantity, "Newton-Euler")} <= compared
    assert {("closure, Jacobian", "interpreter"), ("closure, free motions", "Newton-Euler")} <= compared
    assert ("closure of the run", "Newton-Euler") in compared
    assert ("accelerations, states of the run", "maximal") in compared


class Faulty:
    """A simulator with one thing wrong."""

    def __init__(self, sim: Simulator, acceleration: float = 1.0, jacobian: float = 1.0) -> None:
        self.sim, self.factors = sim, (acceleration, jacobian)
        self.mechanism, self.program, self.effects = sim.mechanism, sim.program, sim.effects
        self.scene = sim.scene

    def acceleration(self, q: Any, u: Any, t: float = 0.0) -> Any:
        return self.factors[0] * self.sim.acceleration(q, u, t)

    def closure(self, q: Any) -> Any:
        residual, jacobian = self.sim.closure(q)
        return residual, self.factors[1] * jacobian

    def run(self, t_end: float, **arguments: Any) -> Any:
        return self.sim.run(t_end, **arguments)


@pytest.mark.slow
def test_check_catches_what_is_wrong_in_loops(cases: dict[str, Any]) -> None:
    sim = compiled(cases["sarrus"])

    def failed(subject: Any) -> set[str]:
        return {c.quantity for c in check(subject, states=2, t_end=0.01).comparisons if c.failed}

    assert failed(Faulty(sim)) == set()
    assert failed(Faulty(sim, acceleration=1 + 1e-8)) == {
        "accelerations, random states",
        "accelerations, states of the run",
    }
    assert failed(Faulty(sim, jacobian=1 + 1e-8)) == {"closure, Jacobian"}


def test_sympys_own_kane_refuses_loops_and_springs_by_name() -> None:
    mechanism, _ = parallelogram()
    with pytest.raises(UnsupportedError, match=r"'rc' closes a loop; KanesMethod takes independent"):
        kane(mechanism, (Gravity(),), ("l", "r", "lc"))
    spring = Spring("ground", (0, 0, 0), "left", (0, 1, 0), 1.0)
    open_chain = Mechanism(mechanism.bodies[:2], mechanism.joints[:1])
    with pytest.raises(UnsupportedError, match="does not know the effect 'spring'"):
        kane(open_chain, (spring,))


@pytest.mark.parametrize("angle", [0.0, 1e-12, 0.3, 2.9, math.pi - 1e-12, math.pi])
def test_half_a_turn_is_not_taken_for_none(angle: float) -> None:
    """A cut hinge whose axes run against each other is half a turn from closed; scipy's rotations are the reference."""
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    matrix = Rotation.from_rotvec(angle * axis).as_matrix()
    rotated = Rotation.from_rotvec(rotation_vectors(matrix[None])[0]).as_matrix()
    # near a half turn the angle is told to the square root of round-off
    assert np.abs(rotated - matrix).max() < (1e-7 if angle > 3.0 else 1e-14)
    assert np.linalg.norm(rotation_vectors(matrix[None])[0]) == pytest.approx(angle, rel=1e-7, abs=1e-15)


@pytest.mark.parametrize("effect", [JointLimits(), JointLimits(restitution=0.5)], ids=["stops", "impacts"])
@pytest.mark.quick("impacts")
def test_check_of_limits_knows_stops_and_what_impacts_are_between(effect: JointLimits) -> None:
    bar = Body("bar", 0.1, (0.1, 0, 0), np.diag([1e-4, 3e-3, 3e-3]))
    pin = Joint("pin", "wall", "bar", axis=(0, 1, 0), limits=(-0.3, 0.5))
    mechanism = Mechanism((Body("wall", fixed=True), bar), (pin,))
    report = check(lamc.compile(mechanism, Scene(effects=(Gravity(), effect))), states=5, t_end=0.3)
    assert report.passed, report.table()
    assert any("know no impacts" in note for note in report.notes) is (effect.restitution is not None)
    assert ("accelerations, random states", ("C", "Newton-Euler")) in {
        (c.quantity, c.cross_checks) for c in report.comparisons
    }

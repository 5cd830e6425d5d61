"""The reference cross-checks against each other, against KanesMethod, closed forms and published answers."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lamc.basics.errors import DesignError, ExpressionError, TopologyError, UnsupportedError
from lamc.effects import Gravity, Torque
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from lamc.reference.expression import parse
from lamc.reference.integrate import fixed_steps, initial_state, simulate
from lamc.reference.maximal import MaximalCoordinates
from lamc.reference.newton_euler import NewtonEuler
from lamc.reference.sympy_kane import kane
from tests.support.mechanisms import (
    ALL_PASSIVE,
    chain,
    from_reference,
    random_state,
    random_tree,
    trees,
    unit_plate_pendulum,
)
from tests.support.quick import tries

FORMULA = Torque({"h0": "0.3*sin(2*pi*t) - 0.2*rate + angle**2", "h1": 0.7})


def relative(found: Any, expected: Any) -> float:
    """Largest difference, relative to the largest expected value."""
    return float(np.abs(np.asarray(found) - expected).max() / np.abs(expected).max())


@settings(max_examples=tries(25), deadline=None)
@given(mechanism=trees(12), seed=st.integers(0, 2**31))
def test_newton_euler_agrees_with_maximal_coordinates_on_random_trees(
    mechanism: Mechanism, seed: int
) -> None:
    q, u = random_state(len(mechanism.joints), seed)
    recursion = NewtonEuler(mechanism, ALL_PASSIVE).acceleration(q, u)
    maximal = MaximalCoordinates(mechanism, ALL_PASSIVE).acceleration(q, u)
    # 1e-11: round-off of two dense solves, 1e-16 times condition numbers up to some 1e4.
    assert relative(recursion, maximal) < 1e-11


@pytest.mark.parametrize(("kind", "n"), [("mixed", 3), ("space", 1)])
@pytest.mark.quick("space-1", others="campaign")
def test_newton_euler_agrees_with_kanes_method(kind: str, n: int) -> None:
    mechanism = random_tree(n, seed=n, kind=kind)
    effects = (*ALL_PASSIVE, FORMULA) if n > 1 else ALL_PASSIVE
    cross_check = NewtonEuler(mechanism, effects)
    oracle = kane(mechanism, effects).lambdified()
    for seed in range(3):
        q, u = random_state(n, seed)
        # 1e-12: the limit; round-off of expressions with some 1e4 operations is 1e-14 to 1e-13.
        assert relative(cross_check.acceleration(q, u, 0.3), oracle(q, u, 0.3)) < 1e-12


def test_order_of_joints_is_the_callers() -> None:
    mechanism = random_tree(5, seed=3)
    names = [j.name for j in mechanism.joints]
    q, u = random_state(5, seed=1)
    plain = NewtonEuler(mechanism, ALL_PASSIVE).acceleration(q, u)
    backwards = NewtonEuler(mechanism, ALL_PASSIVE, names[::-1]).acceleration(q[::-1], u[::-1])
    assert relative(backwards[::-1], plain) < 1e-13  # the same sums in another order


def test_a_joint_drawn_towards_the_world_is_the_same_joint() -> None:
    """Child relative to parent about the axis: swapping the ends and turning the axis changes nothing."""
    drawn = random_tree(6, seed=4, kind="space")
    swapped = Mechanism(
        drawn.bodies,
        tuple(
            Joint(j.name, j.child, j.parent, j.point, -j.axis, j.stiffness, j.damping, j.rest_angle)
            for j in drawn.joints
        ),
    )
    q, u = random_state(6, seed=2)
    a = NewtonEuler(drawn, ALL_PASSIVE).acceleration(q, u)
    b = NewtonEuler(swapped, ALL_PASSIVE).acceleration(q, u)
    assert relative(a, b) < 1e-13  # the same numbers but for signs of zero and order of sums


def test_one_body_is_the_compound_pendulum() -> None:
    """d²q/dt² = -m g L sin(q) / (I + m L²), axis along y, hanging along -z."""
    body = Body("b", 2.0, np.array([0.0, 0.0, -0.3]), np.diag([0.02, 0.05, 0.03]))
    mechanism = Mechanism(
        (Body("ground", fixed=True), body), (Joint("h", "ground", "b", axis=np.array([0.0, 1.0, 0.0])),)
    )
    found = NewtonEuler(mechanism, (Gravity((0.0, 0.0, -9.81)),)).acceleration(
        np.array([0.8]), np.array([5.0])
    )
    expected = -2.0 * 9.81 * 0.3 * math.sin(0.8) / (0.05 + 2.0 * 0.09)
    assert abs(found[0] - expected) < 1e-13 * abs(expected)  # a handful of roundings


def test_spinning_rod_on_a_spinning_arm_feels_the_centrifugal_torque() -> None:
    """A rod hinged across a turning arm: I q'' = w² m a sin(q) cos(q)-like terms, from d'Alembert by hand.

    The arm turns about z at rate w and is so heavy that it keeps it; the point mass m sits at r cos(q) + R
    from the axis. Its equation is m r² q'' = -m w² (R + r cos q) r sin q.
    """
    R, r, w, q = 0.7, 0.4, 3.0, 0.9
    arm = Body("arm", 1.0, np.zeros(3), np.diag([0.5e12, 0.5e12, 1e12]))
    point = Body("mass", 0.5, np.array([R + r, 0.0, 0.0]), np.zeros((3, 3)))
    mechanism = Mechanism(
        (Body("ground", fixed=True), arm, point),
        (
            Joint("spin", "ground", "arm", axis=np.array([0.0, 0.0, 1.0])),
            Joint("lift", "arm", "mass", point=np.array([R, 0.0, 0.0]), axis=np.array([0.0, -1.0, 0.0])),
        ),
    )
    found = NewtonEuler(mechanism, ()).acceleration(np.array([0.3, q]), np.array([w, 0.0]))
    expected = -(w**2) * (R + r * math.cos(q)) * math.sin(q) / r
    assert abs(found[1] - expected) < 1e-9 * abs(expected)  # the arm is 1e12 times heavier, not infinitely


def test_power_of_the_forces_is_the_change_of_energy() -> None:
    """dE/dt = -Σ c u² along the motion, by central differences of the energy."""
    mechanism = random_tree(5, seed=7, kind="space")
    cross_check = NewtonEuler(mechanism, ALL_PASSIVE)
    q, u = random_state(5, seed=5)
    du = cross_check.acceleration(q, u)
    h = 1e-5  # s; the error of the difference is h² of the third derivative, some 1e-7 relative

    def total(s: float) -> float:
        return sum(cross_check.energy(q + s * u + 0.5 * s * s * du, u + s * du).values())

    damping = np.array([j.damping for j in mechanism.joints])
    lost = -float(damping @ u**2)
    assert abs((total(h) - total(-h)) / (2 * h) - lost) < 1e-5 * abs(lost)


def test_unit_plates_of_the_paper_fold_as_published() -> None:
    mechanism, scene = unit_plate_pendulum()
    joints = tuple(j.name for j in mechanism.joints)
    cross_check = NewtonEuler(mechanism, scene.effects or (), joints)
    run = simulate(
        cross_check.acceleration,
        initial_state(scene, joints),
        joints,
        np.array([0.5]),
        1e-11,
        1e-13,
        "DOP853",
    )
    # 1e-10: DOP853 at 1e-11 holds this; the published digits end at 1e-16.
    assert np.abs(run.q[0] - [0.3479767274690896, 0.1416890662362707, 0.03314863340808915]).max() < 1e-10


@pytest.mark.parametrize("cross_check", [NewtonEuler, MaximalCoordinates])
@pytest.mark.parametrize(
    ("case", "last"), [("double_pendulum", 3.0), ("mass_ratio", 2.0), ("triple_stiff_e2", 0.1)]
)
@pytest.mark.quick(
    "double_pendulum-*-MaximalCoordinates",
    "mass_ratio-*-MaximalCoordinates",
    "triple_stiff_e2-*-NewtonEuler",
    others="campaign",
)
def test_reference_cases(shared: Path, case: str, last: float, cross_check: Any) -> None:
    cases = {c["id"]: c for c in json.loads((shared / "reference" / "dynamics.json").read_text())["cases"]}
    mechanism, scene = from_reference(cases[case]["spec"])
    joints = tuple(j.name for j in mechanism.joints)
    rows = [
        (e, tol) for e, tol in zip(cases[case]["expected"], cases[case]["tol"], strict=True) if e["t"] <= last
    ]
    if cross_check is MaximalCoordinates:
        rows = rows[:1]  # slow; the agreement of the two cross-checks at every state is tested above
    equations = cross_check(mechanism, scene.effects or (), joints)
    times = np.array([float(e["t"]) for e, _ in rows])
    run = simulate(
        equations.acceleration, initial_state(scene, joints), joints, times, 1e-12, 1e-14, "DOP853"
    )
    for k, (expected, tol) in enumerate(rows):
        for joint in joints:
            difference = run.angle(joint)[k] - expected["theta"][joint]
            # `tol` is the file's own; the rest is what a solver at 1e-12 adds over a chaotic second or two.
            assert abs(math.remainder(difference, 2 * math.pi)) < 2 * tol


def test_fixed_dormand_prince_steps_have_order_five() -> None:
    mechanism, scene = unit_plate_pendulum()
    scene = Scene(effects=(Gravity(),), angles={"h0": 0.5}, rates={"h2": 1.0})
    joints = tuple(j.name for j in mechanism.joints)
    cross_check = NewtonEuler(mechanism, scene.effects or (), joints)
    reference = simulate(
        cross_check.acceleration,
        initial_state(scene, joints),
        joints,
        np.array([0.5]),
        1e-13,
        1e-15,
        "DOP853",
    )
    exact = np.concatenate([reference.q[0], reference.u[0]])
    errors = [
        np.abs(fixed_steps(cross_check.acceleration, initial_state(scene, joints), 0.5, k) - exact).max()
        for k in (40, 80)
    ]
    order = math.log2(errors[0] / errors[1])
    assert 4.7 < order < 5.6  # asymptotic at these steps: every rate times the step is below 0.1


def test_joints_left_out_lost_bodies_and_unknown_effects_are_refused_by_name() -> None:
    tree = chain(3)
    loop = Mechanism(tree.bodies, (*tree.joints, Joint("extra", "ground", "body2")))
    assert NewtonEuler(loop, ()).cuts == ("extra",)
    with pytest.raises(DesignError, match="'extra' has no coordinate"):
        NewtonEuler(loop, (), [joint.name for joint in tree.joints])
    lost = Mechanism((*tree.bodies, Body("stray", 1.0, np.zeros(3), np.eye(3))), tree.joints)
    with pytest.raises(TopologyError, match="'stray' has no path to the world"):
        NewtonEuler(lost, ())

    class Wind:
        name = "wind"

    with pytest.raises(UnsupportedError, match="cannot check the effect 'wind'"):
        NewtonEuler(tree, (Wind(),))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0.01*sin(2*pi*50*t) - 1e-4*rate", 0.01 * math.sin(2 * math.pi * 50 * 0.3) - 1e-4 * -2.0),
        ("-angle^2", -0.49),
        ("2**-1 + max(t, angle) / min(1, 4)", 1.2),
        ("atan2(-1, -1)", -0.75 * math.pi),
        ("sign(rate) * abs(rate)", -2.0),
    ],
)
def test_formulas_have_the_value_that_a_reader_expects(text: str, expected: float) -> None:
    # 1e-15: a few roundings of numbers near 1
    assert parse(text)({"t": 0.3, "angle": 0.7, "rate": -2.0}) == pytest.approx(
        expected, rel=1e-15, abs=1e-15
    )


@pytest.mark.parametrize(
    "text",
    [
        "t.real",
        "().__class__",
        "__import__('os').system('true')",
        "open('x')",
        "[t for t in (1, 2)]",
        "lambda: 1",
        "t if t else 1",
        "t < 1",
        "True",
        "'a'",
        "sin(t, t)",
        "sin(x=t)",
        "sin",
        "1j",
        "t[0]",
        "(t := 1)",
        "1 +",
        "(" * 500,
        "-" * 1500 + "t",
        "t" * 3000,
    ],
)
def test_formulas_outside_the_language_are_refused(text: str) -> None:
    with pytest.raises(ExpressionError):
        parse(text)

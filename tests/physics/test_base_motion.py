"""Bases moved as prescribed: textbook pendulums shaken and turned, equivalence, and the power of what moves them."""

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import lamc
from lamc.basics.errors import DesignError, ExpressionError
from lamc.effects import Gravity, HingeDamping, HingeStiffness, Spring
from lamc.effects.base_motion import BaseMotion
from lamc.effects.free_base import FreeBase
from lamc.pipeline import equations_of
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from lamc.reference.check import check
from lamc.reference.moving_base import MovingNewtonEuler
from lamc.reference.newton_euler import NewtonEuler
from tests.support.closed_mechanisms import closed_mechanism
from tests.support.ctools import needs_cc
from tests.support.general_motion import General
from tests.support.mechanisms import chain, random_state, random_tree

Array = npt.NDArray[np.float64]

M, L, G, R = 0.4, 0.25, 9.81, 0.6  # kg, m, m/s², m
IX, IY, IZ = 0.004, 0.006, 0.003  # kg·m²
GRAVITY = Gravity((0.0, 0.0, -G))


def pendulum(axis: tuple[float, float, float], reach: float = 0.0) -> Mechanism:
    """A pendulum that hangs at a distance from the z axis."""
    bob = Body("bob", M, [reach, 0.0, -L], np.diag([IX, IY, IZ]))
    joint = Joint("h", "ground", "bob", point=[reach, 0.0, 0.0], axis=list(axis))
    return Mechanism((Body("ground", fixed=True), bob), (joint,))


def textbook(right: object, start: tuple[float, float], times: Array) -> Array:
    """Angles of θ̈ = right(t, θ, θ̇)."""
    done = solve_ivp(
        lambda t, y: [y[1], right(t, y[0], y[1])],  # type: ignore[operator]
        (0.0, times[-1]),
        start,
        method="DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-14,
    )
    return np.asarray(done.y[0])


@pytest.mark.parametrize(("start", "stays_up"), [(0.3, False), (np.pi - 0.2, True)])
@pytest.mark.quick("2.94*")
def test_pendulum_on_a_shaken_pivot(start: float, stays_up: bool) -> None:
    # (I + m l²) θ̈ = -m l (g + z̈) sin θ; upright is stable for a² Ω² > 2 g (l + I / (m l)) (Kapitza 1951)
    amplitude, omega = 0.02, 200.0
    shaken = BaseMotion(displacement=(0.0, 0.0, f"{amplitude}*cos({omega}*t)"))
    general = General(pendulum((0.0, 1.0, 0.0)), (GRAVITY, shaken))
    times = np.linspace(0.0, 2.0, 101)
    run = general.run(*general.start([start], [0.0]), times)
    pull = M * L / (IY + M * L * L)
    expected = textbook(
        lambda t, th, w: -pull * (G - amplitude * omega**2 * np.cos(omega * t)) * np.sin(th),
        (start, 0.0),
        times,
    )
    assert np.abs(run.q[:, 0] - expected).max() <= 1e-7  # 64 periods of shaking, each run at 1e-11 and 1e-12
    assert (np.abs(run.q[:, 0] - np.pi).max() < 0.5) == stays_up


@pytest.mark.parametrize("axis", ["tangent", "radial"])
def test_pendulum_on_a_turntable(axis: str) -> None:
    # Lagrange's equations by hand; the radial hinge feels the table's angular acceleration as well
    table = BaseMotion(angle="2*t + 0.5*sin(3*t)")
    times = np.linspace(0.0, 4.0, 81)

    def rate(t: float) -> float:
        return 2.0 + 1.5 * np.cos(3.0 * t)

    def tangent(t: float, th: float, w: float) -> float:
        x = R - L * np.sin(th)
        turning = rate(t) ** 2 * (-M * x * L * np.cos(th) + (IX - IZ) * np.sin(th) * np.cos(th))
        return float((turning - M * G * L * np.sin(th)) / (IY + M * L * L))

    def radial(t: float, th: float, w: float) -> float:
        turning = rate(t) ** 2 * np.sin(th) * np.cos(th) * (M * L * L + IY - IZ)
        euler = M * R * L * np.cos(th) * (-4.5 * np.sin(3.0 * t))
        return float((turning - euler - M * G * L * np.sin(th)) / (IX + M * L * L))

    hinge, right = ((0.0, 1.0, 0.0), tangent) if axis == "tangent" else ((1.0, 0.0, 0.0), radial)
    general = General(pendulum(hinge, R), (GRAVITY, table))
    run = general.run(*general.start([0.2], [0.1]), times)
    # two runs at 1e-11 and 1e-12 over some ten swings
    assert np.abs(run.q[:, 0] - textbook(right, (0.2, 0.1), times)).max() <= 1e-8


def test_base_that_accelerates_evenly_is_gravity() -> None:
    mechanism = random_tree(4, seed=7)
    effects = (HingeStiffness(), HingeDamping())
    even = BaseMotion(displacement=("0.5*3*t^2", "-0.5*t^2 + 2*t", "0.7*t"))
    general = General(mechanism, (*effects, even))
    pulled = NewtonEuler(mechanism, (*effects, Gravity((-3.0, 1.0, 0.0))), general.equations.joints)
    for seed in range(3):
        q, u = random_state(4, seed)
        found, expected = general.acceleration(1.7, q, u), pulled.acceleration(q, u)
        assert np.abs(found - expected).max() <= 1e-11 * np.abs(expected).max()  # round-off of two roads


@pytest.mark.parametrize(
    "mechanism", [random_tree(4, seed=7), chain(3, "laminate", seed=2)], ids=lambda m: m.name
)
def test_power_of_the_base_is_what_energy_gains(mechanism: Mechanism) -> None:
    # Forces that store their energy, a base that turns and shakes: dE/dt is the base's power alone.
    moved = BaseMotion(
        displacement=("0.1*sin(3*t)", "0.2*t^2", "0.05*cos(5*t)"),
        angle="0.4*sin(2*t)",
        axis=(1.0, 2.0, -0.5),
        point=(0.3, -0.1, 0.2),
    )
    spring = Spring("ground", (0.0, 0.4, 0.1), "body2", (1.0, 0.2, 0.0), 5.0, rest_length=0.2)
    general = General(mechanism, (GRAVITY, HingeStiffness(), spring, moved))
    n = len(mechanism.joints)
    q, u = random_state(n, 3)
    run = general.run(q, u, np.linspace(0.0, 1.0, 201), rtol=1e-12)
    power = np.array([general.power("base_motion", *row) for row in zip(run.t, run.q, run.u, strict=True)])
    h = run.t[1]
    work = h / 3.0 * (power[0] + power[-1] + 4.0 * power[1:-1:2].sum() + 2.0 * power[2:-1:2].sum())
    gained = general.energy(1.0, run.q[-1], run.u[-1]) - general.energy(0.0, run.q[0], run.u[0])
    # Simpson's rule: (h ω)⁴ / 180 of the power's size at ω ≈ 15 per s
    assert abs(work - gained) <= 1e-5 * np.abs(power).max()


def test_bodies_ride_on_the_base() -> None:
    axis, point = np.array([1.0, 2.0, -0.5]), np.array([0.3, -0.1, 0.2])
    moved = BaseMotion(("0.1*sin(3*t)", 0.2, "0.05*cos(5*t)"), "0.4*t", (1.0, 2.0, -0.5), (0.3, -0.1, 0.2))
    mechanism = random_tree(3, seed=7)
    general = General(mechanism, (moved,))
    still = NewtonEuler(mechanism, (), general.equations.joints)
    q, _ = random_state(3, 1)
    t = 1.3
    poses = general.poses(t, q)
    turn = Rotation.from_rotvec(0.4 * t * axis / np.linalg.norm(axis)).as_matrix()
    shift = np.array([0.1 * np.sin(3 * t), 0.2, 0.05 * np.cos(5 * t)])
    centres, rotations = still.poses(q)
    for name, centre, rotation in zip(still.bodies, centres, rotations, strict=True):
        assert np.abs(poses[name][0] - (point + turn @ (centre - point) + shift)).max() <= 1e-14
        assert np.abs(poses[name][1] - turn @ rotation).max() <= 1e-14
    assert np.abs(poses["ground"][1] - turn).max() <= 1e-15


def test_loop_on_a_turning_base_has_the_closure_of_a_still_one() -> None:
    mechanism = closed_mechanism("planar", 0).mechanism
    still = equations_of(mechanism, (HingeStiffness(),))
    rotated = General(mechanism, (HingeStiffness(), BaseMotion(angle="3*t")))
    assert rotated.equations.closure is not None
    assert still.closure is not None
    assert rotated.equations.loops.rank == still.loops.rank
    assert len(rotated.equations.closure.residual) == len(still.closure.residual)
    n = len(still.joints)
    values = [rotated.system(t, np.zeros(n), np.zeros(n))[2] for t in (0.0, 0.9)]
    assert np.array_equal(*values)


def test_second_cross_check_knows_moved_bases() -> None:
    moved = BaseMotion(
        ("0.1*sin(3*t)/(1 + t^2)", "exp(-t)*cos(5*t)", "sqrt(1 + t) - tanh(2*t)"), "0.4*atan(3*t) + t^3",
        (1.0, 2.0, -0.5), (0.3, -0.1, 0.2)
    )  # fmt: skip
    spring = Spring("ground", (0.0, 0.4, 0.1), "body2", (1.0, 0.2, 0.0), 5.0, rest_length=0.2, damping=0.3)
    for mechanism in (random_tree(4, seed=7), closed_mechanism("spatial", 1).mechanism):
        effects = (GRAVITY, HingeStiffness(), HingeDamping(), spring, moved)
        general = General(mechanism, effects)
        joints = general.equations.joints
        cross_check = MovingNewtonEuler(mechanism, effects, joints)
        for seed in range(3):
            q, u = random_state(len(joints), seed)
            if cross_check.cuts:
                q, u = np.zeros((2, len(joints)))
            t = 0.3 + seed
            found, expected = general.acceleration(t, q, u), cross_check.acceleration(q, u, t)
            assert (
                np.abs(found - expected).max() <= 1e-10 * np.abs(expected).max()
            )  # two roads, condition of M
            for name, value in cross_check.energy(q, u, t).items():
                assert general.energies(t, q, u)[name] == pytest.approx(value, rel=1e-12, abs=1e-12)


@needs_cc
@pytest.mark.slow
def test_check_compares_the_cross_checks_where_the_base_is_moved() -> None:
    moved = BaseMotion(("0.1*sin(3*t)", 0, "0.2*t^2"), "0.4*sin(2*t)", (1.0, 2.0, -0.5), (0.3, -0.1, 0.2))
    scene = Scene(effects=(GRAVITY, HingeStiffness(), moved))
    report = check(lamc.compile(chain(3), scene), states=5, t_end=0.5)
    assert report.passed, report.table()


@needs_cc
@pytest.mark.parametrize("integrator", ["rk45", "dop853", "rodas5p", "radau5"])
def test_compiled_runs_follow_the_equations(integrator: str) -> None:
    moved = BaseMotion(("0.1*sin(3*t)", 0, "0.2*t^2"), "0.4*sin(2*t)", (0.0, 0.0, 1.0), (0.3, -0.1, 0.2))
    mechanism, effects = random_tree(3, seed=7), (GRAVITY, HingeStiffness(), moved)
    result = lamc.compile(mechanism, Scene(effects=effects)).run(
        1.0, rtol=1e-9, atol=1e-11, integrator=integrator, t_eval=[0.0, 0.5, 1.0]
    )
    general = General(mechanism, effects)
    run = general.run(*general.start([0.0] * 3, [0.0] * 3), np.array([0.0, 0.5, 1.0]))
    # a run at rtol 1e-9, a hundred steps or so, beside one at 1e-11
    assert np.abs(result.q - run.q).max() <= 1e-7
    turn = Rotation.from_rotvec([0.0, 0.0, 0.4 * np.sin(2.0)]).as_matrix()
    centre, rotation = result.pose("ground")
    point = np.array([0.3, -0.1, 0.2])
    shift = np.array([0.1 * np.sin(3.0), 0.0, 0.2])
    assert np.abs(rotation[-1] - turn).max() <= 1e-14
    assert np.abs(centre[-1] - (point + turn @ (mechanism.body("ground").com - point) + shift)).max() <= 1e-14


def test_base_motions_that_make_no_sense_are_refused() -> None:
    with pytest.raises(DesignError, match="moves nothing"):
        BaseMotion(displacement=(0.1, 0.0, 0.0))
    with pytest.raises(ExpressionError, match="z displacement of base_motion"):
        BaseMotion(displacement=(0, 0, "0.1*rate"))
    with pytest.raises(
        ExpressionError,
        match=r"the z displacement of base_motion: .*'omega' is not known.*the scene's inputs",
    ):
        Scene(effects=(BaseMotion(displacement=(0, 0, "0.1*sin(omega*t)")),))
    with pytest.raises(DesignError, match="must have a direction"):
        BaseMotion(angle="t", axis=(0.0, 0.0, 0.0))
    with pytest.raises(DesignError, match="both move the fixed bodies"):
        equations_of(
            Mechanism(
                (Body("ground", 1.0, np.zeros(3), np.eye(3), fixed=True), *chain(1).bodies[1:]),
                chain(1).joints,
            ),
            (FreeBase(), BaseMotion(angle="t")),
        )

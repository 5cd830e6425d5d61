"""Floating bases: closed forms of rigid bodies, conservation, textbook derivations and MuJoCo."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
import sympy as sp
import sympy.physics.mechanics as me
from scipy.spatial.transform import Rotation

import lamc
from lamc.basics.errors import DesignError
from lamc.effects import Gravity, HingeDamping, HingeStiffness, Spring
from lamc.effects.free_base import FreeBase
from lamc.pipeline import equations_of
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from lamc.reference.check import check
from lamc.reference.moving_base import MovingNewtonEuler
from lamc.reference.newton_euler import NewtonEuler
from lamc.report.equations_text import equations_tex, equations_txt, listing
from tests.support.closed_mechanisms import closed_mechanism
from tests.support.ctools import needs_cc
from tests.support.floating import BASE_INERTIA, lone_body, momenta, quaternion_matrix, with_base
from tests.support.general_motion import General
from tests.support.mechanisms import ALL_PASSIVE, chain, random_state, random_tree

Array = npt.NDArray[np.float64]


def random_start(general: General, joints: int, seed: int) -> tuple[Array, Array]:
    """A random pose and random rates of everything; the quaternion's norm is not one."""
    rng = np.random.default_rng(seed)
    q, u = random_state(joints, seed)
    q, u = general.start(q.tolist(), u.tolist())
    q[-7:] = rng.normal(size=7)
    u[-6:] = rng.normal(size=6)
    return q, u


def test_symmetric_top_turns_as_euler_says() -> None:
    # L = I ω keeps its place; R(t) = Rot(L, |L| t / I₁) R(0) Rot(axis, (1 - I₃/I₁) ω₃ t) (Landau & Lifshitz, § 35)
    i1, i3 = 0.3, 0.5
    spin = np.array([0.9, -0.4, 2.0])
    turn = np.array([2.8, 0.7, -0.3])
    general = General(
        lone_body(1.0, np.diag([i1, i1, i3])), (FreeBase(rotation=tuple(turn), spin=tuple(spin)),)
    )
    q, u = general.start([0.0], [0.0])
    times = np.linspace(0.0, 60.0, 241)
    run = general.run(q, u, times)
    first = Rotation.from_rotvec(turn).as_matrix()
    momentum = first @ (np.array([i1, i1, i3]) * spin)
    nutation = (1.0 - i3 / i1) * spin[2]
    for t, row in zip(run.t, run.q, strict=True):
        expected = (
            Rotation.from_rotvec(momentum * t / i1).as_matrix()
            @ first
            @ Rotation.from_rotvec([0, 0, nutation * t]).as_matrix()
        )
        # 30 turns at rtol 1e-11, and the speck's share of 1e-12
        assert np.abs(quaternion_matrix(row[-4:]) - expected).max() <= 1e-8
    assert np.abs(np.linalg.norm(run.u[:, -3:-1], axis=1) - np.hypot(*spin[:2])).max() <= 1e-9


def test_top_that_tumbles_through_all_attitudes_has_no_singular_one() -> None:
    # The intermediate axis: the body turns over again and again. Energy and momentum are Euler's two integrals.
    inertia = np.diag([0.2, 0.35, 0.5])
    general = General(lone_body(1.0, inertia), (FreeBase(spin=(0.2, 3.0, 0.2)),))
    q, u = general.start([0.0], [0.0])
    run = general.run(q, u, np.linspace(0.0, 40.0, 401))
    rotations = [quaternion_matrix(row[-4:]) for row in run.q]
    momentum = np.array([R @ inertia @ w for R, w in zip(rotations, run.u[:, -3:], strict=True)])
    assert np.abs(momentum - momentum[0]).max() <= 1e-9 * np.linalg.norm(momentum[0])
    flips = (np.diff(np.sign(run.u[:, -2])) != 0).sum()
    assert flips >= 5  # it does turn over: angles of any kind would pass their singular value
    energy = 0.5 * np.einsum("ti,ij,tj->t", run.u[:, -3:], inertia, run.u[:, -3:])
    assert np.abs(energy / energy[0] - 1.0).max() <= 1e-9


def test_thrown_body_follows_a_parabola() -> None:
    general = General(
        lone_body(0.7, BASE_INERTIA),
        (
            Gravity((0.0, 0.0, -9.81)),
            FreeBase(position=(1.0, 2.0, 3.0), velocity=(4.0, -1.0, 6.0), spin=(1, 2, 3)),
        ),
    )
    q, u = general.start([0.0], [0.0])
    run = general.run(q, u, np.linspace(0.0, 2.0, 9))
    expected = [np.array([1 + 4 * t, 2 - t, 3 + 6 * t - 0.5 * 9.81 * t * t]) for t in run.t]
    assert np.abs(run.q[:, 1:4] - expected).max() <= 1e-10  # round-off of a few m at rtol 1e-11
    centre, rotation = general.poses(0.0, run.q[-1])["ground"]
    assert np.abs(centre - expected[-1]).max() <= 1e-10
    assert np.abs(rotation - quaternion_matrix(run.q[-1, -4:])).max() <= 1e-14


@pytest.mark.slow
@pytest.mark.parametrize("mechanism", [chain(3, "space", seed=3), random_tree(4, seed=8, kind="laminate")])
def test_floating_chain_keeps_momentum_and_energy(mechanism: Mechanism) -> None:
    mechanism = with_base(mechanism)
    spring = Spring("ground", (0.0, 0.3, 0.0), "body1", (1.0, 0.0, 0.2), 3.0, rest_length=0.1)
    general = General(mechanism, (HingeStiffness(), spring, FreeBase()))
    joints = general.equations.joints
    q, u = random_start(general, len(joints), seed=4)
    run = general.run(q, u, np.linspace(0.0, 4.0, 9))
    linear, angular = momenta(mechanism, joints, run.q[0], run.u[0])
    energy = general.energy(0.0, run.q[0], run.u[0])
    for row, rates in zip(run.q, run.u, strict=True):
        p, l0 = momenta(mechanism, joints, row, rates)
        # errors of a run at rtol 1e-11, some hundred steps
        assert np.abs(p - linear).max() <= 1e-9 * np.abs(linear).max()
        assert np.abs(l0 - angular).max() <= 1e-9 * np.abs(angular).max()
        assert abs(general.energy(0.0, row, rates) - energy) <= 1e-9 * abs(energy)


def test_forces_of_the_world_change_momentum_by_their_sum() -> None:
    mechanism = with_base(chain(2, "space", seed=5))
    general = General(mechanism, (Gravity((1.0, 2.0, -9.81)), HingeDamping(), FreeBase()))
    q, u = random_start(general, 2, seed=1)
    run = general.run(q, u, np.linspace(0.0, 1.5, 4))
    mass = sum(body.mass for body in mechanism.bodies)
    first, _ = momenta(mechanism, general.equations.joints, run.q[0], run.u[0])
    for t, row, rates in zip(run.t, run.q, run.u, strict=True):
        linear, _ = momenta(mechanism, general.equations.joints, row, rates)
        assert np.abs(linear - first - mass * t * np.array([1.0, 2.0, -9.81])).max() <= 1e-8


def test_heavy_base_is_a_fixed_one() -> None:
    mechanism = chain(3, "space", seed=6)
    heavy = with_base(mechanism, mass=1e9, inertia=1e9 * np.eye(3))
    effects = (HingeStiffness(), HingeDamping())
    general = General(heavy, (*effects, FreeBase()))
    fixed = NewtonEuler(mechanism, effects, general.equations.joints)
    for seed in range(3):
        angles, rates = random_state(3, seed)
        q, u = general.start(angles.tolist(), rates.tolist())
        found, expected = general.acceleration(0.0, q, u), fixed.acceleration(angles, rates)
        # the base gives way by the masses' ratio, 1e-9, a few times over
        assert np.abs(found[:3] - expected).max() <= 1e-7 * np.abs(expected).max()
        assert np.abs(found[3:]).max() <= 1e-7 * np.abs(expected).max()


def test_planar_floating_pair_against_sympy_kane() -> None:
    """Two bodies in the plane by sympy's KanesMethod, textbook way; a free base kept in that plane by its start."""
    m1, i1, m2, i2, a, b, k, g = 1.3, 0.21, 0.7, 0.05, 0.4, 0.3, 2.0, 9.81
    x, y, th, ph = me.dynamicsymbols("x y theta phi")
    speeds = me.dynamicsymbols("vx vy wt wp")
    world, origin = me.ReferenceFrame("N"), me.Point("O")
    first = world.orientnew("A", "Axis", (th, world.z))
    second = first.orientnew("B", "Axis", (ph, first.z))
    origin.set_vel(world, 0)
    centre1 = origin.locatenew("G1", x * world.x + y * world.y)
    hinge = centre1.locatenew("H", a * first.x)
    centre2 = hinge.locatenew("G2", b * second.x)
    first.set_ang_vel(world, speeds[2] * world.z)
    second.set_ang_vel(first, speeds[3] * world.z)
    centre1.set_vel(world, speeds[0] * world.x + speeds[1] * world.y)
    hinge.v2pt_theory(centre1, world, first)
    centre2.v2pt_theory(hinge, world, second)
    bodies = [
        me.RigidBody("P", centre1, first, m1, (me.inertia(first, 0, 0, i1), centre1)),
        me.RigidBody("Q", centre2, second, m2, (me.inertia(second, 0, 0, i2), centre2)),
    ]
    loads = [
        (centre1, -m1 * g * world.y),
        (centre2, -m2 * g * world.y),
        (second, -k * ph * world.z),
        (first, k * ph * world.z),
    ]
    q_ = [x, y, th, ph]
    kane = me.KanesMethod(world, q_, speeds, [v - s.diff() for v, s in zip(speeds, q_, strict=True)])
    kane.kanes_equations(bodies, loads)
    textbook = sp.lambdify([*q_, *speeds], [kane.mass_matrix, kane.forcing])

    ground = Body("base", m1, [0.0, 0.0, 0.0], np.diag([0.1, 0.15, i1]), fixed=True)
    arm = Body("arm", m2, [a + b, 0.0, 0.0], np.diag([0.02, 0.04, i2]))
    joint = Joint("h", "base", "arm", point=[a, 0, 0], axis=[0, 0, 1], stiffness=k)
    general = General(
        Mechanism((ground, arm), (joint,)), (Gravity((0.0, -g, 0.0)), HingeStiffness(), FreeBase())
    )
    rng = np.random.default_rng(3)
    for _ in range(5):
        px, py, angle, fold, *rates = rng.normal(size=8)
        matrix, force = textbook(px, py, angle, fold, *rates)
        vx, vy, wt, wp = np.linalg.solve(matrix, force).ravel()
        q, u = general.start([fold], [rates[3]])
        q[1:] = px, py, 0.0, np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)
        u[1:] = rates[0], rates[1], 0.0, 0.0, 0.0, rates[2]
        found = general.acceleration(0.0, q, u)
        expected = np.array([wp, vx, vy, 0.0, 0.0, 0.0, wt])
        assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()  # two roads to 4 equations


@pytest.mark.parametrize("family", ["planar", "spatial"])
def test_floating_loop_keeps_its_momentum(family: str) -> None:
    mechanism = with_base(closed_mechanism(family, 0, sprung=False).mechanism)
    general = General(mechanism, (FreeBase(),))
    joints = general.equations.joints
    closure = general.equations.closure
    assert closure is not None
    assert len(general.rates) == len(joints) + 6
    assert all(j < len(joints) for row in closure.jacobian for j, _ in row)  # the base has no say in it
    q, u = general.start([0.0] * len(joints), [0.0] * len(joints))
    _, _, jacobian, _ = general.system(0.0, q, u)
    free = np.linalg.svd(jacobian)[2][np.linalg.matrix_rank(jacobian) :]
    u = free.T @ (free @ np.random.default_rng(2).normal(size=len(u)))
    run = general.run(q, u, np.linspace(0.0, 2.0, 5), rtol=1e-10)
    first = momenta(mechanism, joints, run.q[0], run.u[0])
    energy = general.energy(0.0, run.q[0], run.u[0])
    assert energy > 0.0
    for row, rates in zip(run.q, run.u, strict=True):
        now = momenta(mechanism, joints, row, rates)
        # nothing projects this run on closure: the gap grows as the run's own error, some 1e-8
        assert np.abs(now[0] - first[0]).max() <= 1e-7
        assert np.abs(now[1] - first[1]).max() <= 1e-7
        assert abs(general.energy(0.0, row, rates) - energy) <= 1e-7 * energy


def test_floating_trees_accelerate_as_mujoco_says() -> None:
    """Accelerations at random states against MuJoCo's free joint; needs the package mujoco (extra "bench")."""
    mujoco = pytest.importorskip("mujoco", reason="mujoco is an extra: pip install 'lamc[bench]'")
    mechanism = with_base(random_tree(4, seed=21, kind="space"))
    general = General(mechanism, (Gravity((0.5, -0.3, -9.81)), HingeStiffness(), HingeDamping(), FreeBase()))
    model = mujoco.MjModel.from_xml_string(_mjcf(mechanism, (0.5, -0.3, -9.81)))
    arm = next(body.com for body in mechanism.bodies if body.fixed)  # MuJoCo's origin is the drawn one
    for seed in range(4):
        q, u = random_start(general, len(general.equations.joints), seed)
        found = general.acceleration(0.0, q, u)
        data = mujoco.MjData(model)
        rotation = quaternion_matrix(q[-4:])
        data.qpos[:7] = [*(q[-7:-4] - rotation @ arm), *(q[-4:] / np.linalg.norm(q[-4:]))]
        data.qvel[:6] = [*(u[-6:-3] - rotation @ np.cross(u[-3:], arm)), *u[-3:]]
        for k, joint in enumerate(general.equations.joints):
            at = model.joint(joint)
            data.qpos[at.qposadr[0]], data.qvel[at.dofadr[0]] = q[k], u[k]
        mujoco.mj_forward(model, data)
        hinges = [data.qacc[model.joint(joint).dofadr[0]] for joint in general.equations.joints]
        turning = data.qacc[3:6]
        moved = np.cross(turning, arm) + np.cross(u[-3:], np.cross(u[-3:], arm))
        expected = np.array([*hinges, *(data.qacc[:3] + rotation @ moved), *turning])
        # two engines in double precision; MuJoCo keeps inertia in principal axes, to some 1e-10
        assert np.abs(found - expected).max() <= 1e-8 * np.abs(expected).max()


def _mjcf(mechanism: Mechanism, gravity: tuple[float, float, float]) -> str:
    """The mechanism as MJCF: all frames are the drawn world's, moved to the hinges' points."""
    tree = equations_of(mechanism, ()).tree
    base = next(body for body in mechanism.bodies if body.fixed)

    def inertial(body: Body, at: Array) -> str:
        i = body.inertia
        full = " ".join(repr(float(v)) for v in (i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]))
        place = " ".join(repr(float(v)) for v in body.com - at)
        return f'<inertial pos="{place}" mass="{body.mass!r}" fullinertia="{full}"/>'

    def element(i: int, above: Array) -> str:
        link = tree.links[i]
        joint, at = link.joint, link.joint.point
        axis = " ".join(
            repr(float(v)) for v in (joint.axis if joint.child == link.body.name else -joint.axis)
        )
        inner = "".join(element(c, at) for c in tree.children(i))
        place = " ".join(repr(float(v)) for v in at - above)
        return (
            f'<body name="{link.body.name}" pos="{place}"><joint name="{joint.name}" type="hinge" axis="{axis}" '
            f'stiffness="{joint.stiffness!r}" damping="{joint.damping!r}"/>{inertial(link.body, at)}{inner}</body>'
        )

    inner = "".join(element(i, np.zeros(3)) for i, link in enumerate(tree.links) if link.parent < 0)
    pull = " ".join(map(repr, gravity))
    return (
        f'<mujoco><compiler angle="radian" autolimits="true" boundmass="0"/><option gravity="{pull}"/><worldbody>'
        f'<body name="base"><freejoint/>{inertial(base, np.zeros(3))}{inner}</body></worldbody></mujoco>'
    )


def test_equations_are_written_with_all_their_coordinates() -> None:
    found = listing(equations_of(with_base(chain(1)), (Gravity(), FreeBase())), "chain")
    text, tex = equations_txt(found), equations_tex(found)
    for name in ("base.x (m)", "base.qw (1)", "base.wz (rad/s)"):
        assert name in text
        assert name in tex
    for line in ("qdot_base.qw = ", "M_6_6 = ", "f_6 = ", "energy_kinetic = "):
        assert line in text
    assert "Accelerations" not in text  # the runtime solves


def test_fixed_bodies_float_as_one() -> None:
    mechanism = with_base(chain(1, seed=2))
    other = Body("other", 0.5, np.array([1.0, 0.0, 0.0]), 0.1 * np.eye(3), fixed=True)
    both = replace(mechanism, bodies=(*mechanism.bodies, other))
    arrangement = General(both, (FreeBase(),)).arrangement
    base = arrangement.base
    assert base is not None
    assert base.bodies == ("ground", "other")
    assert "ground+other.mass" in [p.name for p in General(both, (FreeBase(),)).equations.parameters]
    assert base.mass == pytest.approx(2.5)  # type: ignore[union-attr]
    assert general_bodies(both) == ("body0", "ground", "other")


def general_bodies(mechanism: Mechanism) -> tuple[str, ...]:
    return General(mechanism, (FreeBase(),)).equations.bodies


def test_bases_that_cannot_float_are_refused_by_name() -> None:
    with pytest.raises(DesignError, match=r"fixed body .ground. has no mass.*leave free_base out"):
        equations_of(chain(1), (FreeBase(),))
    flat = with_base(chain(1), inertia=np.diag([0.0, 0.1, 0.1]))
    with pytest.raises(DesignError, match="principal moment of inertia of 0 kg·m²"):
        equations_of(flat, (FreeBase(),))
    named = replace(with_base(chain(1)), joints=(replace(chain(1).joints[0], name="base.x"),))
    with pytest.raises(
        DesignError, match=r"a joint is named 'base\.x', as a coordinate is that an effect adds"
    ):
        equations_of(named, (FreeBase(),))
    with pytest.raises(DesignError, match=r"free_base\.spin: spin is"):
        FreeBase(spin=(1.0, 2.0))  # type: ignore[arg-type]


def test_second_cross_check_knows_floating_bases() -> None:
    """Newton and Euler by Jacobians of all bodies, beside MuJoCo and Kane above."""
    spring = Spring("ground", (0.0, 0.3, 0.0), "body1", (1.0, 0.0, 0.2), 3.0, rest_length=0.1, damping=0.2)
    for mechanism in (with_base(random_tree(5, seed=3)), with_base(closed_mechanism("spatial", 1).mechanism)):
        effects = (*ALL_PASSIVE, spring, FreeBase())
        general = General(mechanism, effects)
        joints = general.equations.joints
        cross_check = MovingNewtonEuler(mechanism, effects, joints)
        for seed in range(3):
            q, u = random_start(general, len(joints), seed)
            if cross_check.cuts:
                q[: len(joints)], u[: len(joints)] = 0.0, 0.0
            found, expected = general.acceleration(0.0, q, u), cross_check.acceleration(q, u)
            assert (
                np.abs(found - expected).max() <= 1e-10 * np.abs(expected).max()
            )  # two roads, condition of M
            ours, theirs = general.energies(0.0, q, u), cross_check.energy(q, u)
            for name, value in theirs.items():
                assert ours.get(name, 0.0) == pytest.approx(value, rel=1e-12, abs=1e-12)


@needs_cc
@pytest.mark.parametrize("family", ["tree", "planar"])
@pytest.mark.quick("tree", others="campaign")
def test_check_compares_the_cross_checks_where_the_base_floats(family: str) -> None:
    mechanism = chain(3) if family == "tree" else closed_mechanism(family, 0).mechanism
    effects = (Gravity(), HingeStiffness(), FreeBase(spin=(1.0, 0.5, -0.3)))
    report = check(lamc.compile(with_base(mechanism), Scene(effects=effects)), states=5, t_end=0.5)
    assert report.passed, report.table()
    assert sum(c.cross_checks == ("C", "Newton-Euler") for c in report.comparisons) >= 4


@needs_cc
@pytest.mark.parametrize("integrator", ["rk45", "dop853", "rodas5p", "radau5"])
def test_compiled_runs_follow_the_equations(integrator: str) -> None:
    mechanism = with_base(chain(2, "space", seed=3))
    effects = (Gravity(), HingeStiffness(), FreeBase(rotation=(0.3, 0.2, 0.1), spin=(0.5, 0.6, 0.7)))
    sim = lamc.compile(mechanism, Scene(effects=effects, rates={"h0": 1.0}))
    result = sim.run(1.0, rtol=1e-9, atol=1e-11, integrator=integrator, t_eval=[0.0, 0.5, 1.0])
    general = General(mechanism, effects)
    run = general.run(*general.start([0.0, 0.0], [1.0, 0.0]), np.array([0.0, 0.5, 1.0]))
    assert [c.name for c in sim.coordinates] == general.coordinates
    assert sim.freedoms == 8
    # a run at rtol 1e-9, a hundred steps or so, beside one at 1e-11
    assert np.abs(result.q - run.q).max() <= 1e-7
    assert np.abs(result.u - run.u).max() <= 1e-6


def test_passive_loads_take_energy_from_a_floating_tree_at_the_rate_of_the_dampers() -> None:
    mechanism = with_base(random_tree(4, seed=13))
    general = General(mechanism, (*ALL_PASSIVE, FreeBase()))
    joints = general.equations.joints
    damping = np.array([mechanism.joint(name).damping for name in joints])
    q, u = random_start(general, 4, seed=9)
    run = general.run(q, u, np.linspace(0.0, 1.0, 401), rtol=1e-12)
    lost = np.array([damping @ rates[:4] ** 2 for rates in run.u])
    h = run.t[1]
    supplied = -h / 3.0 * (lost[0] + lost[-1] + 4.0 * lost[1:-1:2].sum() + 2.0 * lost[2:-1:2].sum())
    change = general.energy(0.0, run.q[-1], run.u[-1]) - general.energy(0.0, run.q[0], run.u[0])
    # Simpson's rule on 200 pairs of intervals: relative error some (h ω)⁴ / 180 with ω ≈ 10 per s
    assert abs(change - supplied) <= 1e-5 * abs(change)

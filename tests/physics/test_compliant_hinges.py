"""Hinges that yield across their axes: small vibrations, large motions, and loops that bushings close."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import pytest
from scipy.linalg import eig
from scipy.optimize import linear_sum_assignment

import lamc
from lamc.basics.errors import DesignError
from lamc.effects import Gravity, HingeStiffness
from lamc.effects.base_motion import BaseMotion
from lamc.effects.free_base import FreeBase
from lamc.mechanics.arrangement import CROSS_FREEDOMS, CompliantHinge
from lamc.mechanics.arranging import Arranging
from lamc.mechanism.plan import plan
from lamc.pipeline import equations_of
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from lamc.reference.check import check
from tests.support.ctools import needs_cc
from tests.support.floating import with_base
from tests.support.general_motion import General
from tests.support.mechanisms import chain, random_tree
from tests.support.particles import Cloud, Place, about

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Compliance:
    """What an effect does that makes hinges yield."""

    hinges: tuple[CompliantHinge, ...]

    name: ClassVar[str] = "compliance"
    summary: ClassVar[str] = "Hinges that yield"

    def arrange(self, arranging: Arranging) -> None:
        for hinge in self.hinges:
            arranging.compliant_hinge(hinge)

    def contribute(self, loads: object) -> None:
        """The matrices say it all."""


def spd(rng: np.random.Generator, size: float) -> Array:
    """A full symmetric positive definite (6, 6) matrix."""
    root = rng.normal(size=(6, 6))
    return size * (root @ root.T + 3.0 * np.eye(6))


def compliant(
    joint: Joint, seed: int, size: float = 40.0, freedoms: tuple[str, ...] = CROSS_FREEDOMS
) -> CompliantHinge:
    """Full matrices, axes across the hinge at any angle, at a point away from the joint's own."""
    rng = np.random.default_rng(seed)
    x = np.cross(joint.axis, rng.normal(size=3))
    x /= np.linalg.norm(x)
    z = joint.axis
    return CompliantHinge(
        joint.name,
        joint.point + rng.uniform(-0.3, 0.3) * joint.axis,
        np.column_stack([x, np.cross(z, x), z]),
        spd(rng, size),
        spd(rng, 0.01 * size),
        freedoms,
    )


def all_compliant(mechanism: Mechanism, size: float = 40.0) -> Compliance:
    return Compliance(tuple(compliant(j, k, size) for k, j in enumerate(mechanism.joints)))


def linearised(general: General) -> tuple[Array, Array, Array]:
    """M, damping and stiffness matrix at rest as drawn, by central differences of f."""
    q, u = general.start([0.0] * len(general.equations.joints), [0.0] * len(general.equations.joints))
    n, h = len(u), 1e-5
    mass = general.system(0.0, q, u)[0]
    stiffness = [
        (general.system(0.0, q - h * e, u)[1] - general.system(0.0, q + h * e, u)[1])
        for e in np.eye(n, len(q))  # the angle of a bushing, which comes last, tells no more than turns
    ]
    damping = [
        (general.system(0.0, q, u - h * e)[1] - general.system(0.0, q, u + h * e)[1]) for e in np.eye(n)
    ]
    return mass, np.array(damping).T / (2 * h), np.array(stiffness).T / (2 * h)


def assembled(mechanism: Mechanism, hinges: Sequence[CompliantHinge]) -> tuple[Array, Array, Array]:
    """M, C and K by small displacements of the bodies' centres and small rotations: six per body, springs between."""
    moving = [b for b in mechanism.bodies if not b.fixed]
    place = {b.name: 6 * i for i, b in enumerate(moving)}
    size = 6 * len(moving)
    mass = np.zeros((size, size))
    for body in moving:
        k = place[body.name]
        mass[k : k + 3, k : k + 3] = body.mass * np.eye(3)
        mass[k + 3 : k + 6, k + 3 : k + 6] = body.inertia
    stiffness, damping = np.zeros((2, size, size))
    for hinge in hinges:
        joint = mechanism.joint(hinge.joint)
        relative = np.zeros((6, size))  # twists, then slides, world axes
        for name, sign in ((joint.child, 1.0), (joint.parent, -1.0)):
            if name in place:
                k, r = place[name], hinge.point - mechanism.body(name).com
                skew = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
                relative[:3, k + 3 : k + 6] = sign * np.eye(3)
                relative[3:, k : k + 3] = sign * np.eye(3)
                relative[3:, k + 3 : k + 6] = -sign * skew
        p = np.kron(np.eye(2), hinge.axes.T) @ relative
        stiffness += p.T @ hinge.stiffness @ p
        damping += p.T @ hinge.damping @ p
    return mass, damping, stiffness


def modes(mass: Array, damping: Array, stiffness: Array) -> Array:
    """Eigenvalues of M ẍ + C ẋ + K x = 0."""
    n = len(mass)
    left = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]])
    right = np.block([[np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), mass]])
    return np.asarray(eig(left, right, right=False))


def ring() -> Mechanism:
    """Two bodies and three hinges in a ring with the world, hinges in any direction: rigidly it is locked."""
    rng = np.random.default_rng(5)
    base = chain(2, "space", seed=11)
    last = base.bodies[-1]
    closing = Joint(
        "h9", last.name, "ground", point=last.com + np.array([0.3, 0.1, -0.2]), axis=rng.normal(size=3)
    )
    return replace(base, joints=(*base.joints, closing), name="ring")


@pytest.mark.parametrize(
    "mechanism", [chain(2, "space", seed=1), random_tree(3, seed=4), ring()], ids=lambda m: m.name
)
def test_small_vibrations_are_those_of_bodies_on_springs(mechanism: Mechanism) -> None:
    effect = all_compliant(mechanism)
    general = General(mechanism, (effect,))
    assert general.equations.closure is None  # a ring is held by its bushing
    expected = modes(*assembled(mechanism, effect.hinges))
    apart = np.abs(np.subtract.outer(modes(*linearised(general)), expected))
    # each has its partner; the differences above leave 1e-9 of the largest entries
    assert apart[linear_sum_assignment(apart)].max() <= 1e-6 * np.abs(expected).max()


def forces(general: General, effect: Compliance, q: Array, u: Array) -> Array:
    """-K p - C ṗ of the tree's hinges, by rate."""
    index = {name: i for i, name in enumerate(general.coordinates)}
    result = np.zeros(len(u))
    for hinge in effect.hinges:
        rows = [
            index.get(hinge.joint if f == "angle" else f"{hinge.joint}.{f}")
            for f in ("twist_x", "twist_y", "angle", "slide_x", "slide_y", "slide_z")
        ]
        known = [(a, i) for a, i in enumerate(rows) if i is not None]
        at, places = [a for a, _ in known], [i for _, i in known]
        pick = np.ix_(at, at)
        result[places] -= hinge.stiffness[pick] @ q[places] + hinge.damping[pick] @ u[places]
    return result


@pytest.mark.parametrize("base", ["still", "floating", "moved"])
@pytest.mark.parametrize(
    "mechanism",
    [chain(2, "space", seed=1), random_tree(3, seed=4), chain(2, "parallel", seed=2)],
    ids=lambda m: m.name,
)
def test_large_motions_are_those_of_particles(mechanism: Mechanism, base: str) -> None:
    mechanism = with_base(mechanism)
    few = ("twist_y", "slide_x", "slide_z")
    hinges = [
        compliant(j, k, freedoms=few if k == 1 else CROSS_FREEDOMS) for k, j in enumerate(mechanism.joints)
    ]
    effect = Compliance(tuple(hinges))
    moved = BaseMotion(("0.3*sin(2*t)", 0, "0.1*t^3"), "0.7*sin(3*t)", (0.0, 0.6, 0.8), (0.2, 0.1, 0.0))
    extra = {"still": (), "floating": (FreeBase(),), "moved": (moved,)}[base]
    general = General(mechanism, (Gravity((0.4, -0.2, -9.81)), effect, *extra))
    particles = Cloud(general.arrangement)
    rng = np.random.default_rng(7)
    joints = len(mechanism.joints)
    t = 0.4

    def told(s: complex) -> Place:
        x = t + s
        rotation, shift = about(np.array([0, 0.6, 0.8]), np.array([0.2, 0.1, 0]), 0.7 * np.sin(3 * x))
        return rotation, shift + np.array([0.3 * np.sin(2 * x), 0, 0.1 * x**3])

    for _ in range(3):
        q, u = general.start(rng.uniform(-2, 2, joints).tolist(), rng.normal(size=joints).tolist())
        q[joints:] += rng.uniform(-0.4, 0.4, len(q) - joints)
        u[joints:] += rng.normal(size=len(u) - joints)
        found = general.acceleration(t, q, u)
        expected = particles.acceleration(
            q, u, forces(general, effect, q, u), (0.4, -0.2, -9.81), told if base == "moved" else None
        )
        # differences of velocities at steps of 2 ms leave some 1e-11; the mass matrix has a condition of some 1e3
        assert np.abs(found - expected).max() <= 1e-8 * np.abs(expected).max()


@pytest.mark.parametrize("floats", [False, True])
@pytest.mark.slow
@pytest.mark.ci("True")
def test_misaligned_ring_moves_on_its_bushing_and_keeps_its_energy(floats: bool) -> None:
    mechanism = with_base(ring())
    undamped = tuple(replace(h, damping=np.zeros((6, 6))) for h in all_compliant(mechanism, 200.0).hinges)
    general = General(mechanism, (Compliance(undamped), HingeStiffness(), *((FreeBase(),) if floats else ())))
    joints = len(general.equations.joints)
    q, u = general.start([0.1] * joints, [0.3] * joints)
    run = general.run(q, u, np.linspace(0.0, 1.0, 11))
    energies = [general.energies(0.0, row, rates) for row, rates in zip(run.q, run.u, strict=True)]
    total = [sum(e.values()) for e in energies]
    assert max(e["compliance"] for e in energies) > 0.1 * total[0]  # much of it goes through the springs
    assert np.abs(np.array(total) / total[0] - 1.0).max() <= 1e-9  # a run at rtol 1e-11


@pytest.mark.slow
@needs_cc
def test_ring_on_its_bushing_compiles_and_runs_as_its_equations_say() -> None:
    mechanism = with_base(ring())
    effects = (all_compliant(mechanism, 200.0), FreeBase(velocity=(0.1, 0.0, 0.0)))
    joints = plan(mechanism).joint_names
    sim = lamc.compile(mechanism, Scene(effects=effects, rates={joints[0]: 0.5}))
    result = sim.run(0.5, rtol=1e-9, atol=1e-11, t_eval=[0.0, 0.25, 0.5])
    general = General(mechanism, effects)
    run = general.run(*general.start([0.0] * len(joints), [0.5, 0.0]), np.array([0.0, 0.25, 0.5]))
    assert sim.cut_joints == ()
    assert np.abs(result.q - run.q).max() <= 1e-8  # runs at rtol 1e-9 and 1e-11


@needs_cc
def test_check_names_the_effect_that_it_cannot_judge() -> None:
    """It may push at bodies beside what it says in numbers; where the bodies are is known all the same."""
    report = check(lamc.compile(chain(1), Scene(effects=(all_compliant(chain(1)),))), states=3, t_end=0.02)
    assert report.passed
    assert "do not know the effect 'compliance'" in " ".join(report.notes)
    compared = {c.quantity for c in report.comparisons if c.cross_checks == ("C", "Lagrange")}
    assert compared == {"centres of mass", "rotations"}


def test_very_stiff_hinge_is_a_plain_one() -> None:
    # quasi-static: with K → ∞ the slow motion's stiffness about the hinge is what HingeStiffness says
    mechanism = chain(1, "space", seed=3)
    stiff = replace(compliant(mechanism.joints[0], 0), stiffness=1e9 * np.diag([1, 1, 0, 1, 1, 1.0]))
    general = General(mechanism, (HingeStiffness(), Compliance((stiff,))))
    plain = equations_of(mechanism, (HingeStiffness(),))
    mass, _, stiffness = linearised(general)
    values = np.sort(np.abs(eig(stiffness, mass, right=False)))
    body, joint = mechanism.bodies[1], mechanism.joints[0]
    arm = np.cross(joint.axis, body.com - joint.point)
    inertia = joint.axis @ body.inertia @ joint.axis + body.mass * arm @ arm
    assert plain.is_plain
    # flexibility 1e-9 of the hinge's own; differences of f beside entries of 1e9 leave 1e-6
    assert values[0] == pytest.approx(joint.stiffness / inertia, rel=1e-4)


def test_compliance_that_cannot_be_is_refused_by_name() -> None:
    mechanism = ring()
    plain, cut = all_compliant(mechanism).hinges, plan(mechanism).cuts[0].joint.name
    closing = next(h for h in plain if h.joint == cut)
    with pytest.raises(
        DesignError, match=f"joint '{cut}' closes a loop and is compliant, but rigid in twist_x"
    ):
        equations_of(mechanism, (Compliance((replace(closing, freedoms=CROSS_FREEDOMS[1:]),)),))
    loose = closing.stiffness.copy()
    loose[3], loose[:, 3] = 0.0, 0.0
    with pytest.raises(DesignError, match="slide_x has no stiffness"):
        equations_of(mechanism, (Compliance((replace(closing, stiffness=loose),)),))
    with pytest.raises(DesignError, match="no joint is named 'h5'"):
        equations_of(mechanism, (Compliance((replace(closing, joint="h5"),)),))
    with pytest.raises(DesignError, match=f"two effects make joint '{cut}' compliant"):
        equations_of(mechanism, (Compliance((closing, closing)),))
    with pytest.raises(DesignError, match=r"stiffness of .* is not positive semi-definite"):
        replace(closing, stiffness=closing.stiffness - 1e3 * np.eye(6))
    with pytest.raises(DesignError, match="not symmetric"):
        replace(closing, stiffness=np.triu(closing.stiffness))
    with pytest.raises(DesignError, match="is not the joint's axis"):
        equations_of(mechanism, (Compliance((replace(closing, axes=np.eye(3)),)),))
    assert Body("x", 1.0)  # records above are as they were

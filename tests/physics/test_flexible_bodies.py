"""Bodies that bend: textbook rotating beams, clouds of particles, loads that work on modes, energy."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import pytest
import sympy as sp
from scipy.linalg import eigh

import lamc
from lamc.basics.errors import DesignError
from lamc.effects import Gravity, HingeDamping, HingeStiffness, Spring
from lamc.effects.base_motion import BaseMotion
from lamc.effects.free_base import FreeBase
from lamc.mechanics.arranging import Arranging
from lamc.mechanics.flexible import FlexibleBody
from lamc.pipeline import equations_of
from lamc.records.mechanism import Body, Joint, Mechanism
from lamc.records.scene import Scene
from tests.support.ctools import needs_cc
from tests.support.floating import with_base
from tests.support.general_motion import General
from tests.support.particles import Cloud, plate_of

Array = npt.NDArray[np.float64]
GRAVITY = Gravity((0.4, -0.2, -9.81))


@dataclass(frozen=True, eq=False)
class Bending:
    """What an effect does that makes bodies bend."""

    bodies: tuple[FlexibleBody, ...]

    name: ClassVar[str] = "bending"
    summary: ClassVar[str] = "Bodies that bend"

    def arrange(self, arranging: Arranging) -> None:
        for body in self.bodies:
            arranging.flexible_body(body)

    def contribute(self, loads: object) -> None:
        """The modes say it all."""


@dataclass(frozen=True, eq=False)
class Strip:
    """A strip of particles on a grid from the line of its inboard hinge, with polynomials for shapes."""

    body: Body
    flexible: FlexibleBody
    masses: Array
    places: Array


def strip(
    name: str,
    origin: Sequence[float],
    along: Array,
    across: Array,
    seed: int,
    count: int = 2,
    damped: float = 0.0,
) -> Strip:
    """Of length 1 m along and 0.4 m across, 1.2 kg unevenly; φ are x², x³ and x² y in its own plane."""
    rng = np.random.default_rng(seed)
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(0.05, 1.0, 6), np.linspace(-0.2, 0.2, 4)))
    masses = rng.uniform(0.5, 1.5, len(x))
    masses *= 1.2 / masses.sum()
    start = np.array(origin)
    places = start + np.outer(x, along) + np.outer(y, across)
    com = masses @ places / masses.sum()
    arms = places - com
    inertia = np.einsum("p,pi,pj->ij", masses, arms, arms)
    inertia = np.trace(inertia) * np.eye(3) - inertia

    def shape_at(point: Array) -> tuple[Array, Array]:
        a, b = (point - start) @ along, (point - start) @ across
        phi = np.array([a * a, a**3, a * a * b])[:count]
        slopes = np.array([2 * a * along, 3 * a * a * along, 2 * a * b * along + a * a * across])[:count]
        return phi, slopes

    phi = np.array([shape_at(p)[0] for p in places])
    root = rng.normal(size=(count, count))
    flexible = FlexibleBody(
        body=name,
        normal=np.cross(along, across),
        moment=masses @ phi,
        first_moment=np.einsum("p,pk,pi->ki", masses, phi, arms),
        mass=np.einsum("p,pk,pl->kl", masses, phi, phi),
        stiffness=60.0 * (root @ root.T + 2.0 * np.eye(count)),
        damping_ratios=np.full(count, damped),
        shape_at=shape_at,
    )
    return Strip(Body(name, float(masses.sum()), com, 0.5 * (inertia + inertia.T)), flexible, masses, places)


def skewed() -> tuple[Mechanism, tuple[Strip, Strip]]:
    """Two strips in a row in space, the second hinged to the tip of the first, and a rigid body at its tip."""
    rng = np.random.default_rng(1)
    frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    along, across = frame[:, 0], frame[:, 1]
    first = strip("first", (0.1, 0.2, -0.1), along, across, 2, count=3)
    tip = np.array([0.1, 0.2, -0.1]) + 1.0 * along + 0.1 * across
    other = 0.6 * along + 0.8 * across
    second = strip("second", tip, other, np.cross(np.cross(along, across), other), 3)
    end = tip + 1.0 * other
    last = Body("last", 0.5, end + rng.normal(size=3) * 0.2, np.diag([0.02, 0.03, 0.025]))
    joints = (
        Joint("h0", "ground", "first", point=[0.1, 0.2, -0.1], axis=across, stiffness=3.0, damping=0.1),
        Joint("h1", "second", "first", point=tip, axis=np.cross(first.flexible.normal, other), stiffness=2.0),
        Joint("h2", "second", "last", point=end, axis=rng.normal(size=3), damping=0.2),
    )
    ground = Body("ground", fixed=True)
    return Mechanism((ground, first.body, second.body, last), joints, name="skewed"), (first, second)


def hub_beam() -> tuple[Strip, Mechanism]:
    """One strip on a hinge along y, bending along z, with one mode."""
    beam = strip("beam", (0.0, 0.0, 0.0), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), 4, count=1)
    joint = Joint("h", "ground", "beam", axis=[0.0, 1.0, 0.0], stiffness=5.0)
    return beam, Mechanism((Body("ground", fixed=True), beam.body), (joint,))


@pytest.mark.slow
def test_rotating_beam_of_one_mode_moves_as_lagrange_says() -> None:
    # Points (x, z = φ η) in a frame turned by θ about y: T = ½ ∫ρ ((x θ̇ - φ η̇)² + φ² η² θ̇²), by sympy
    beam, mechanism = hub_beam()
    general = General(mechanism, (GRAVITY, HingeStiffness(), Bending((beam.flexible,))))
    t = sp.Symbol("t")
    th, eta = (sp.Function(n)(t) for n in ("theta", "eta"))
    phi = [beam.flexible.shape_at(p)[0][0] for p in beam.places]
    kinetic, potential = sp.Integer(0), sp.Rational(5, 2) * th**2
    potential += sp.Rational(1, 2) * float(beam.flexible.stiffness[0, 0]) * eta**2
    for m, (px, _, _), shape in zip(beam.masses, beam.places, phi, strict=True):
        x = px * sp.cos(th) + shape * eta * sp.sin(th)
        z = -px * sp.sin(th) + shape * eta * sp.cos(th)
        kinetic += m * (x.diff(t) ** 2 + z.diff(t) ** 2) / 2
        potential -= m * (0.4 * x - 9.81 * z)
    lagrangian = kinetic - potential
    q = [th, eta]
    equations = [lagrangian.diff(c.diff(t)).diff(t) - lagrangian.diff(c) for c in q]
    second = [c.diff(t, 2) for c in q]
    mass = sp.Matrix(2, 2, lambda i, j: sp.expand(equations[i]).coeff(second[j]))
    rest = [e.subs(dict.fromkeys(second, 0)) for e in equations]
    plain = sp.symbols("a b da db")
    names = {
        **{c.diff(t): s for c, s in zip(q, plain[2:], strict=True)},
        **dict(zip(q, plain[:2], strict=True)),
    }
    numbers = sp.lambdify(plain, [mass.subs(names), sp.Matrix(rest).subs(names)])
    rng = np.random.default_rng(0)
    for _ in range(4):
        state = rng.normal(size=4) * [1.0, 0.3, 2.0, 1.0]
        matrix, right = numbers(*state)
        expected = -np.linalg.solve(matrix, right).ravel()
        found = general.acceleration(0.0, state[:2], state[2:])
        assert np.abs(found - expected).max() <= 1e-11 * np.abs(expected).max()  # sums of 24 terms


def test_beam_that_spins_steadily_stretches_its_frequency_downwards() -> None:
    # With the rate held (a turntable), η̈ = -(K / G - Ω²) η for bending in the plane of rotation: no stiffening by
    # the centrifugal force is in a linear reduction, and this says so (Kane, Ryan & Banerjee 1987)
    beam, mechanism = hub_beam()
    held = replace(mechanism, joints=(replace(mechanism.joints[0], stiffness=0.0),))
    spin = 2.0
    general = General(held, (Bending((beam.flexible,)), BaseMotion(angle=f"{spin}*t", axis=(0.0, 1.0, 0.0))))
    q, u = np.array([0.0, 0.01]), np.zeros(2)
    mass, force, _, _ = general.system(0.0, q, u)
    k, g = beam.flexible.stiffness[0, 0], beam.flexible.mass[0, 0]
    assert mass[1, 1] == pytest.approx(g, rel=1e-14)
    assert force[1] == pytest.approx(-(k - g * spin**2) * 0.01, rel=1e-12)


@pytest.mark.parametrize("base", ["still", "floating"])
def test_chain_of_bending_bodies_moves_as_particles_do(base: str) -> None:
    mechanism, strips = skewed()
    mechanism = with_base(mechanism)
    effect = Bending(tuple(s.flexible for s in strips))
    extra = (FreeBase(),) if base == "floating" else ()
    general = General(mechanism, (GRAVITY, HingeStiffness(), HingeDamping(), effect, *extra))
    plates = {s.body.name: plate_of(s.flexible, s.masses, s.places) for s in strips}
    cloud = Cloud(general.arrangement, plates)
    assert [name for name in general.coordinates if "mode" in name] == [
        "first.mode_1", "first.mode_2", "first.mode_3", "second.mode_1", "second.mode_2"
    ]  # fmt: skip
    joints = general.equations.joints
    rng = np.random.default_rng(5)
    for _ in range(3):
        q, u = general.start(rng.uniform(-2, 2, 3).tolist(), rng.normal(size=3).tolist())
        q[3:8], u[3:8] = rng.uniform(-0.3, 0.3, 5), rng.normal(size=5)
        if base == "floating":
            q[8:], u[8:] = rng.normal(size=7), rng.normal(size=6)
        forces = np.zeros(len(u))
        for k, name in enumerate(joints):
            joint = mechanism.joint(name)
            forces[k] = -joint.stiffness * q[k] - joint.damping * u[k]
        forces[3:6] = -strips[0].flexible.stiffness @ q[3:6]
        forces[6:8] = -strips[1].flexible.stiffness @ q[6:8]
        found = general.acceleration(0.0, q, u)
        expected = cloud.acceleration(q, u, forces, GRAVITY.acceleration)
        # differences of velocities at steps of 2 ms; light bodies behind flexible ones: a condition of some 1e3
        assert np.abs(found - expected).max() <= 1e-8 * np.abs(expected).max()


@pytest.mark.slow
def test_loads_at_points_and_hinges_store_and_release_all_their_energy() -> None:
    mechanism, strips = skewed()
    tip = strips[1].places[-1]
    spring = Spring("ground", (0.0, 0.5, 0.5), "second", tuple(tip), 30.0, rest_length=0.3)  # type: ignore[arg-type]
    other = Spring("first", tuple(strips[0].places[10]), "last", (1.0, 1.0, 0.0), 10.0)  # type: ignore[arg-type]
    effect = Bending(tuple(s.flexible for s in strips))
    for extra in ((), (FreeBase(spin=(0.5, 0.2, 0.1)),)):
        general = General(with_base(mechanism), (GRAVITY, HingeStiffness(), spring, other, effect, *extra))
        q, u = general.start([0.3, -0.2, 0.5], [0.5, 0.2, -1.0])
        run = general.run(q, u, np.linspace(0.0, 0.1, 4))
        totals = [general.energy(0.0, row, rates) for row, rates in zip(run.q, run.u, strict=True)]
        size = max(general.energies(0.0, run.q[-1], run.u[-1]).values())
        assert np.abs(np.diff(totals)).max() <= 1e-9 * size  # a run at rtol 1e-11
        assert np.abs(run.q[:, 3:8]).max() > 1e-3  # it bends


def test_damped_modes_fade_at_their_ratios() -> None:
    # one free vibration with the hinge held by a stiff spring: eigenvalues -ζω ± iω√(1 - ζ²) of each mode
    clamped = strip(
        "beam", (0.0, 0.0, 0.0), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), 4, count=3, damped=0.05
    )
    body = clamped.flexible
    squares = eigh(body.stiffness, body.mass, eigvals_only=True)
    n = body.count
    system = np.block(
        [
            [np.zeros((n, n)), np.eye(n)],
            [-np.linalg.solve(body.mass, body.stiffness), -np.linalg.solve(body.mass, body.damping)],
        ]
    )
    values = np.linalg.eigvals(system)
    omega = np.sqrt(squares)
    expected = np.sort(-0.05 * omega)
    assert np.sort(values.real)[::2] == pytest.approx(expected, rel=1e-9)
    assert np.sort(np.abs(values))[::2] == pytest.approx(omega, rel=1e-9)


def test_tip_force_on_a_still_beam_deflects_it_as_statics_says() -> None:
    # K η = φ(tip) F along the normal, hinge held by its own torque
    beam, mechanism = hub_beam()
    stiff = replace(mechanism, joints=(replace(mechanism.joints[0], stiffness=1e12),))
    tip, pull = (1.0, 0.0, 0.0), (0.0, 0.0, 0.7)

    @dataclass(frozen=True)
    class Pull:
        name: ClassVar[str] = "pull"
        summary: ClassVar[str] = "Force on the tip"

        def contribute(self, loads: object) -> None:
            loads.force("beam", tip, pull)  # type: ignore[attr-defined]
            loads.moment("beam", (0.0, 0.2, 0.0))  # type: ignore[attr-defined]

    general = General(stiff, (HingeStiffness(), Bending((beam.flexible,)), Pull()))
    at_tip, _ = beam.flexible.shape_at(np.array(tip))
    _, slope = beam.flexible.shape_at(beam.body.com)
    expected = at_tip[0] * 0.7 - slope[0, 0] * 0.2  # a moment about y turns x down: against w_x
    _, force, _, _ = general.system(0.0, np.zeros(2), np.zeros(2))
    assert force[1] == pytest.approx(expected, rel=1e-13)


@needs_cc
@pytest.mark.slow
def test_bending_bodies_compile_and_run_as_their_equations_say() -> None:
    mechanism, strips = skewed()
    effects = (GRAVITY, HingeStiffness(), HingeDamping(), Bending(tuple(s.flexible for s in strips)))
    sim = lamc.compile(mechanism, Scene(effects=effects, rates={"h0": 1.0}))
    result = sim.run(0.5, rtol=1e-9, atol=1e-11, t_eval=[0.0, 0.5])
    general = General(mechanism, effects)
    run = general.run(*general.start([0.0] * 3, [1.0, 0.0, 0.0]), np.array([0.0, 0.5]))
    assert np.abs(result.q - run.q).max() <= 1e-8  # runs at rtol 1e-9 and 1e-11


def closed() -> tuple[Mechanism, Strip]:
    """A planar four-bar with hinges along y; its coupler bends out of the line, in the plane of motion."""
    y = [0.0, 1.0, 0.0]
    coupler = strip("coupler", (0.0, 0.0, 0.5), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), 6, count=2)
    crank = Body("crank", 0.4, [0.0, 0.0, 0.25], 0.01 * np.eye(3))
    rocker = Body("rocker", 0.5, [1.05, 0.0, 0.2], 0.02 * np.eye(3))
    joints = (
        Joint("h0", "ground", "crank", axis=y),
        Joint("h1", "crank", "coupler", point=[0.0, 0.0, 0.5], axis=y),
        Joint("h2", "coupler", "rocker", point=[1.0, 0.0, 0.5], axis=y, stiffness=1.0),
        Joint("h3", "rocker", "ground", point=[1.1, 0.0, -0.1], axis=y),
    )
    return Mechanism(
        (Body("ground", fixed=True), crank, coupler.body, rocker), joints, name="closed"
    ), coupler


@pytest.mark.slow
def test_loop_with_a_bending_coupler_stays_closed_and_keeps_its_energy() -> None:
    mechanism, coupler = closed()
    general = General(mechanism, (GRAVITY, HingeStiffness(), Bending((coupler.flexible,))))
    closure = general.equations.closure
    assert closure is not None
    n = len(general.rates)
    q, u = general.start([0.0] * 4, [0.0] * 4)
    run = general.run(q, u, np.linspace(0.0, 0.4, 5), rtol=1e-11)
    totals = np.array([general.energy(0.0, row, rates) for row, rates in zip(run.q, run.u, strict=True)])
    kinetic = max(general.energies(0.0, row, v)["kinetic"] for row, v in zip(run.q, run.u, strict=True))
    assert kinetic > 0.05
    # nothing projects this run on closure: the gap grows as the run's own error
    assert np.abs(totals - totals[0]).max() <= 1e-8 * max(kinetic, 1.0)
    assert n == 6
    assert general.equations.loops.rank <= len(closure.residual)


def test_flexible_bodies_that_cannot_be_are_refused_by_name() -> None:
    beam, mechanism = hub_beam()
    body = beam.flexible
    with pytest.raises(DesignError, match="no moving body is named 'ground'"):
        equations_of(mechanism, (Bending((replace(body, body="ground"),)),))
    with pytest.raises(DesignError, match="two effects make body 'beam' flexible"):
        equations_of(mechanism, (Bending((body, body)),))
    with pytest.raises(DesignError, match="must be a unit vector"):
        replace(body, normal=np.array([0.0, 0.0, 2.0]))
    with pytest.raises(DesignError, match=r"modal mass .* not positive definite"):
        replace(body, mass=np.zeros((1, 1)))
    with pytest.raises(DesignError, match=r"damping_ratios .* none may be negative"):
        replace(body, damping_ratios=np.array([-0.1]))


def test_a_spring_between_points_of_one_flexible_body_bends_it() -> None:
    # From a point 0.5 m above the root to the tip, which bends by η: V = ½ k (1 + (0.5 - η)²)
    beam, mechanism = hub_beam()
    spring = Spring("beam", (0.0, 0.0, 0.5), "beam", (1.0, 0.0, 0.0), 5.0)
    _, force, _, _ = General(mechanism, (Bending((beam.flexible,)), spring)).system(
        0.0, np.zeros(2), np.zeros(2)
    )
    assert force == pytest.approx([0.0, 5.0 * 0.5], abs=1e-13)  # a few roundings of numbers near one

"""A fluid's mass that moves with a body: rigid bodies as a special case, and Kirchhoff's integrals of motion."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import pytest

from lamc.basics.errors import DesignError
from lamc.effects import Gravity, HingeStiffness
from lamc.effects.base_motion import BaseMotion
from lamc.effects.free_base import FreeBase
from lamc.mechanics.arranging import Arranging
from lamc.mechanics.loads import Loads
from lamc.pipeline import equations_of
from lamc.records.mechanism import Body, Mechanism
from tests.support.floating import lone_body, quaternion_matrix, with_base
from tests.support.general_motion import General
from tests.support.mechanisms import chain, random_state

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Fluid:
    """What an effect does that adds a fluid's mass to a body."""

    body: str
    point: tuple[float, float, float]
    matrix: Array

    name: ClassVar[str] = "fluid"
    summary: ClassVar[str] = "Fluid that moves with a body"

    def arrange(self, arranging: Arranging) -> None:
        arranging.inverse_dynamics()

    def contribute(self, loads: Loads) -> None:
        loads.added_inertia(self.body, self.point, self.matrix.tolist())


def rigid(mass: float, arm: Array, inertia: Array) -> Array:
    """The matrix of a rigid body whose centre is at `arm` from the point: of (velocity, angular velocity)."""
    skew = np.array([[0, -arm[2], arm[1]], [arm[2], 0, -arm[0]], [-arm[1], arm[0], 0]])
    return np.block([[mass * np.eye(3), -mass * skew], [mass * skew, inertia - mass * skew @ skew]])


def heavier(mechanism: Mechanism, name: str, mass: float, com: Array, inertia: Array) -> Mechanism:
    """`mechanism` with a rigid body welded to one of its own."""
    body = mechanism.body(name)
    total = body.mass + mass
    middle = (body.mass * body.com + mass * com) / total
    summed = body.inertia + inertia
    for m, r in ((body.mass, body.com - middle), (mass, com - middle)):
        summed = summed + m * (r @ r * np.eye(3) - np.outer(r, r))
    new = Body(name, total, middle, summed, fixed=body.fixed)
    return replace(mechanism, bodies=tuple(new if b.name == name else b for b in mechanism.bodies))


@pytest.mark.parametrize("name", ["body0", "body1", "ground"])
@pytest.mark.parametrize("base", ["still", "floating", "moved"])
def test_matrix_of_a_rigid_body_acts_as_that_body_without_its_weight(name: str, base: str) -> None:
    if name == "ground" and base != "floating":
        pytest.skip("a fixed body has no say in the motion")
    mass, inertia = 0.8, np.diag([0.03, 0.05, 0.04])
    point, com = np.array([0.3, -0.1, 0.4]), np.array([0.5, 0.2, 0.1])
    mechanism = with_base(chain(2, "space", seed=3))
    extra = {
        "still": (),
        "floating": (FreeBase(),),
        "moved": (BaseMotion(("0.2*sin(3*t)", 0, "t^2"), "0.5*t^2", (1.0, 1.0, 0.0)),),
    }[base]
    fluid = Fluid(name, tuple(point), rigid(mass, com - point, inertia))  # type: ignore[arg-type]
    wet = General(mechanism, (HingeStiffness(), fluid, *extra))
    welded = heavier(mechanism, name, mass, com, inertia)
    dry = General(welded, (HingeStiffness(), *(extra or (BaseMotion(angle="0*t"),))))
    rng = np.random.default_rng(1)
    for seed in range(3):
        angles, rates = random_state(2, seed)
        q, u = wet.start(angles.tolist(), rates.tolist())
        other, fast = dry.start(angles.tolist(), rates.tolist())
        if base == "floating":
            q[-7:], u[-6:] = rng.normal(size=7), rng.normal(size=6)
            other[-7:], fast[-6:] = q[-7:], u[-6:]
            rotation = quaternion_matrix(q[-4:])
            arm = welded.body("ground").com - mechanism.body("ground").com
            other[-7:-4] += rotation @ arm
            fast[-6:-3] += rotation @ np.cross(u[-3:], arm)
        found, expected = wet.acceleration(0.4, q, u), dry.acceleration(0.4, other, fast)
        if base == "floating":
            turning = np.cross(expected[-3:], arm) + np.cross(u[-3:], np.cross(u[-3:], arm))
            expected = expected.copy()
            expected[-6:-3] -= rotation @ turning
        assert np.abs(found - expected).max() <= 1e-11 * np.abs(expected).max()  # round-off of two roads
        energies = wet.energies(0.4, q, u)
        assert energies["fluid"] > 0.0
        # kinetic energy is a sum of squares; both have ten digits and more in common
        assert energies["kinetic"] + energies["fluid"] == pytest.approx(
            dry.energies(0.4, other, fast)["kinetic"], rel=1e-12
        )


def test_body_in_a_fluid_keeps_kirchhoffs_impulse() -> None:
    # A body as broad as a plate: its added mass differs by direction, and it broaches (Munk's moment). Without other
    # forces the impulse P = R (m v + p), its moment about the origin and the energy stay.
    mass, inertia = 1.3, np.diag([0.05, 0.08, 0.04])
    added = np.diag([0.2, 0.4, 3.0, 0.02, 0.05, 0.01])
    added[1, 3] = added[3, 1] = 0.03
    fluid = Fluid("ground", (0.0, 0.0, 0.0), added)
    general = General(
        lone_body(mass, inertia), (fluid, FreeBase(velocity=(2.0, 0.3, 0.1), spin=(0.1, 0.2, 0.3)))
    )
    q, u = general.start([0.0], [0.0])
    run = general.run(q, u, np.linspace(0.0, 5.0, 21))

    def integrals(row: Array, rates: Array) -> Array:
        rotation, spin = quaternion_matrix(row[-4:]), rates[-3:]
        v = rotation.T @ rates[-6:-3]
        momentum = added @ np.array([*v, *spin])
        impulse = rotation @ (mass * v + momentum[:3])
        moment = rotation @ (inertia @ spin + momentum[3:]) + np.cross(row[-7:-4], impulse)
        return np.array([*impulse, *moment])

    first, energy = integrals(run.q[0], run.u[0]), general.energy(0.0, run.q[0], run.u[0])
    broached = 0.0
    for row, rates in zip(run.q, run.u, strict=True):
        # a run at rtol 1e-11; the speck of dust weighs 1e-12
        assert np.abs(integrals(row, rates) - first).max() <= 1e-9 * np.abs(first).max()
        assert abs(general.energy(0.0, row, rates) - energy) <= 1e-9 * energy
        broached = max(broached, float(np.abs(rates[-3:]).max()))
    assert broached > 1.0  # rad/s: three times the first spin


def test_fluid_has_no_weight() -> None:
    # A ball in a fluid without lift: a = m g / (m + m'), m' that of half the displaced volume (Lamb 1932, art. 92)
    mass, half = 0.5, 0.2
    fluid = Fluid("ground", (0.0, 0.0, 0.0), np.diag([half, half, half, 0, 0, 0]))
    general = General(lone_body(mass, 0.01 * np.eye(3)), (fluid, Gravity((0.0, 0.0, -9.81)), FreeBase()))
    q, u = general.start([0.0], [0.0])
    assert general.acceleration(0.0, q, u)[3] == pytest.approx(-9.81 * mass / (mass + half), rel=1e-11)


def test_added_inertia_without_the_general_form_is_refused() -> None:
    @dataclass(frozen=True, eq=False)
    class Hasty:
        name: ClassVar[str] = "hasty"
        summary: ClassVar[str] = "Adds inertia unasked"

        def contribute(self, loads: Loads) -> None:
            loads.added_inertia("body0", (0.0, 0.0, 0.0), np.eye(6).tolist())

    with pytest.raises(DesignError, match=r"arrange\(arranging\) does not call arranging.inverse_dynamics"):
        equations_of(chain(1), (Hasty(),))
    with pytest.raises(DesignError, match="not 6 by 6"):
        equations_of(chain(1), (Fluid("body0", (0.0, 0.0, 0.0), np.eye(3)),))

"""Bodies that bend keep their edges straight at hinges: what that changes is measured, and told where it is much."""

import numpy as np
import pytest
from shapely.geometry import LineString, box

import lamc
from lamc import Body, FlexibleLinks, Joint, Mechanism, Scene, Slab, plate
from lamc.effects import HingeStiffness
from lamc.mechanism.plan import plan
from lamc.plates.answers.reduction import reduce_plate
from lamc.plates.answers.straight_edges import straight_modes
from tests.support.ctools import needs_cc

pytestmark = needs_cc

T, RHO = 0.5e-3, 2700.0
SHEET = plate.Laminate([plate.Ply(plate.Material.isotropic(70e9, 0.3, RHO), T)])


def flag(a: float, b: float, stiffness: float) -> Mechanism:
    """One plate, a long and b wide, on a hinge along y."""
    mass = RHO * T * a * b
    inertia = mass / 12 * np.diag([b**2, a**2, a**2 + b**2])
    outline = Slab(box(0, -b / 2, a, b / 2), -T / 2, T / 2)
    bodies = (
        Body("ground", fixed=True),
        Body("flag", mass, (a / 2, 0.0, 0.0), inertia, outline=(outline,)),
    )
    hinge = Joint("h", "ground", "flag", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), stiffness=stiffness)
    return Mechanism(bodies, (hinge,))


def told(mechanism: Mechanism) -> tuple[str, ...]:
    return FlexibleLinks(modes=3, laminate=SHEET).notes(plan(mechanism))


def test_a_wide_body_on_a_soft_hinge_is_reported_with_the_measure() -> None:
    (note,) = told(flag(0.05, 0.05, 0.01))
    assert "the edge of body 'flag' stays straight at hinge 'h'" in note
    assert "% too high" in note


@pytest.mark.parametrize(("width", "stiffness"), [(0.005, 0.01), (0.05, 1e5)])
def test_a_narrow_body_and_one_on_a_stiff_hinge_are_not_told(width: float, stiffness: float) -> None:
    assert told(flag(0.05, width, stiffness)) == ()


def test_the_measure_is_that_of_one_plate_on_either_hinge() -> None:
    """The twisting mode of a square plate of 50 mm: against the elements themselves, hinged freely, and with one angle
    for the whole edge, which is what a clamped edge on a frame comes to where nothing but twist is asked: clamped."""
    a = 0.05
    edge = LineString([(0, -a / 2), (0, a / 2)])
    mesh = plate.grid(a, a, 12, 12, origin=(0.0, -a / 2))
    held = plate.Problem(mesh, SHEET, supports=[plate.Clamped(edge)])
    found = straight_modes(reduce_plate(held, 3), edge, 0.0)
    free = plate.modes(plate.Problem(mesh, SHEET, supports=[plate.Hinged(edge)]), 3).omega
    # The swing has no stiffness at all; the next is the twist, odd in y, in which the frame does not turn.
    assert found[0].omega == pytest.approx(0.0, abs=1e-3 * free[1])
    assert found[1].free == pytest.approx(free[1], rel=1e-9)  # the same mode of the same mesh
    twist = plate.modes(held, 2).omega[1]
    assert found[1].omega == pytest.approx(
        twist, rel=1e-6
    )  # a natural mode of the reduction is kept as it is
    assert found[1].excess == pytest.approx(twist / free[1] - 1.0, rel=1e-5)
    assert found[1].excess > 0.16


def test_simulators_tell_it() -> None:
    effects = (HingeStiffness(), FlexibleLinks(modes=2, laminate=SHEET))
    sim = lamc.compile(flag(0.05, 0.05, 0.01), Scene(effects=effects))
    assert len(sim.notes) == 1
    assert lamc.compile(flag(0.05, 0.05, 0.01), Scene(effects=(HingeStiffness(),))).notes == ()

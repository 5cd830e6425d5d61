"""What people see of a motion, staged: energies and poses.

Goes in: placement, masses, loads. Comes out: energies by effect, in the world's frame, and poses of all bodies that
move, the base's among them. Nothing here takes part in the motion.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from lamc.mechanics.arrangement import Arrangement
from lamc.mechanics.inverse_dynamics import Masses
from lamc.mechanics.kinematics import Kinematics, LinkVelocity
from lamc.mechanics.loads import Loads
from lamc.mechanics.moving_base import StagedFloat
from lamc.mechanics.placement import Placement, potential_of_field, rotate
from lamc.mechanics.powers import point_motion
from lamc.symbolic.algebra import Vector3, cross, dot
from lamc.symbolic.scalars import Scalar


def energies_of(placement: Placement, masses: Masses, u: Sequence[Scalar], loads: Loads) -> dict[str, Scalar]:
    """Kinetic energy first, then what effects store, J; all in the world's frame."""
    kinematics, base = placement.kinematics, placement.base
    store = kinematics.store
    energies: dict[str, Scalar] = {"kinetic": 0}
    motions = kinematics.motions(u)
    with store.section("Kinetic energy", source="½ m v² + v·(ω × h) + ½ ω·I ω"):
        for i, motion in enumerate(motions):
            store.link = i
            energies["kinetic"] = energies["kinetic"] + _kinetic(kinematics, masses, i, motion, u)
        if isinstance(base, StagedFloat):
            rows, w, v = base.inertia.rows(), base.velocity.angular, base.velocity.linear
            spin = dot(w, [dot(row, w) for row in rows])
            energies["kinetic"] = energies["kinetic"] + 0.5 * (base.mass * dot(v, v)) + 0.5 * spin
    for name, energy in loads.energies.items():
        energies[name] = energies.get(name, 0) + energy
    for effect, acceleration in loads.field_effects:
        with store.section("Potential energy", effect=effect, source="-Σ m a·r"):
            potential = _potential(placement, masses, acceleration)
            energies[effect] = energies.get(effect, 0) + potential
    for added in loads.added:
        with store.section("Kinetic energy of added inertia", effect=added.effect, source="½ wᵀ A w"):
            energies[added.effect] = energies.get(added.effect, 0) + added.energy(
                *point_motion(placement, added, motions)
            )
    for i, reflected in sorted(loads.reflected.items()):
        for effect, inertia in reflected:
            with store.section("Kinetic energy of gears", effect=effect, source="½ J u²"):
                energies[effect] = energies.get(effect, 0) + 0.5 * (inertia * (u[i] * u[i]))
    return energies


def poses_of(placement: Placement, coms: Sequence[Vector3], arrangement: Arrangement) -> Iterator[Scalar]:
    """Per body of `Arrangement.moving_bodies`: centre of mass (3), m, and rotation (9, by rows); of a flexible body: of
    its frame, and of the point that is its centre of mass undeformed."""
    store = placement.kinematics.store
    what = "links" if arrangement.is_plain else "bodies"
    with store.section(f"Positions and rotations of the {what}", source="eq. 1-4"):
        for i, com in enumerate(coms):
            store.link = i
            yield from placement.point(i, com)
            for row in placement.body_rotation(i):
                yield from row
        if arrangement.base is not None and placement.base is not None:
            for name in arrangement.base.bodies:
                yield from placement.base.point(
                    arrangement.tree.mechanism.body(name).com, ("base body", name)
                )
                for row in placement.base.rotation:
                    yield from row


def _kinetic(
    kinematics: Kinematics, masses: Masses, i: int, motion: LinkVelocity, u: Sequence[Scalar]
) -> Scalar:
    inertia, modal, w, v = masses.inertias[i], masses.modal.get(i), motion.omega, motion.velocity
    if modal is not None:
        inertia = modal.of(inertia)
    second = kinematics.symmetric_in_carrier(i, inertia.second)
    spin = dot(w, [dot(row, w) for row in replace(inertia, second=second).rotational().rows()])
    first = kinematics.in_carrier(i, inertia.first)
    rigid = 0.5 * (inertia.mass * dot(v, v)) + dot(v, cross(w, first)) + 0.5 * spin
    return rigid + modal.kinetic(motion, modal.modes.rates(u)) if modal is not None else rigid


def _potential(placement: Placement, masses: Masses, acceleration: Vector3) -> Scalar:
    """-Σ m a·r, J; zero at the world's origin."""
    weights = [inertia.mass for inertia in masses.inertias]
    result = potential_of_field(placement, weights, masses.coms, acceleration)
    for i, modal in sorted(masses.modal.items()):
        result = result - dot(acceleration, rotate(placement.carrier(i), modal.rise()))
    base = placement.base
    if isinstance(base, StagedFloat):
        result = result - base.mass * dot(acceleration, base.position)
    return result

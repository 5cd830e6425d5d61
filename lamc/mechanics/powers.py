"""The power of effects, staged: what all loads of each effect do on the motion, W.

Goes in: loads as they were booked, by effect, and the motion of what they act on. Comes out: one scalar for each
effect that applies any load, in terms of t, q, u and u̇. It is made when it is asked for; nothing here takes part in
the motion.

Together with the power of what moves a base as prescribed, these are the rate of the kinetic energy: the closure of
loops does no work, and neither do the hinges.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from lamc.mechanics.added_inertia import AddedInertia
from lamc.mechanics.placement import Placement, rotate, rotate_back
from lamc.mechanism.tree import WORLD
from lamc.symbolic.algebra import ZERO, Vector3, add, cross, dot, scale
from lamc.symbolic.derivative import derivatives
from lamc.symbolic.scalars import Scalar, Value

if TYPE_CHECKING:
    from lamc.mechanics.kinematics import LinkVelocity
    from lamc.mechanics.loads import Loads


@dataclass
class Account:
    """The loads of one effect, summed up where they act.

    torques      by link, N·m, about its hinge
    generalised  by coordinate, work per unit of it
    wrenches     by link: force, N, and moment about its origin, N·m, carrier components; of the base: about its
                 reference, drawn axes
    """

    torques: dict[int, Scalar] = field(default_factory=dict)
    generalised: dict[int, Scalar] = field(default_factory=dict)
    wrenches: dict[int, tuple[Vector3, Vector3]] = field(default_factory=dict)

    def add_torque(self, index: int, torque: Scalar) -> None:
        self.torques[index] = self.torques.get(index, 0) + torque

    def add_generalised(self, coordinate: int, force: Scalar) -> None:
        self.generalised[coordinate] = self.generalised.get(coordinate, 0) + force

    def add_wrench(self, index: int, force: Vector3, moment: Vector3) -> None:
        before = self.wrenches.get(index, (ZERO, ZERO))
        self.wrenches[index] = (add(before[0], force), add(before[1], moment))


@dataclass(frozen=True)
class Mass:
    """What a uniform field pulls at in one link: m, kg; Σ m r about its origin, kg·m, and what changes of that
    within the link, kg·m/s; carrier components."""

    mass: Scalar
    first: Vector3
    change: Vector3 = ZERO


@dataclass(frozen=True)
class Moving:
    """The motion that loads do work on.

    placement  where the links and the base are
    masses     of the links, in order
    base_mass  of a base that floats, kg, at its reference; 0: none
    u          rates (nu,)
    speeds     d/dt of q, of u (symbols of u̇) and of t
    """

    placement: Placement
    masses: Sequence[Mass]
    base_mass: Scalar
    u: Sequence[Scalar]
    speeds: Mapping[Value, Scalar]


def powers_of(loads: "Loads", moving: Moving) -> dict[str, Scalar]:
    """Power by effect, W, in the order in which the effects contributed."""
    store = moving.placement.kinematics.store
    motions = moving.placement.kinematics.motions(moving.u)
    result: dict[str, Scalar] = {}
    for effect, account in loads.accounts.items():
        with store.section("Power", effect=effect, source="Σ torque · rate + wrench · twist"):
            result[effect] = _of_account(account, moving, motions)
    for effect, acceleration in loads.field_effects:
        with store.section("Power of the field", effect=effect, source="Σ m a·v"):
            result[effect] = result.get(effect, 0) + _of_field(acceleration, moving, motions)
    for added in loads.added:
        with store.section("Power of the fluid", effect=added.effect, source="-wᵀ A dw/dt"):
            result[added.effect] = result.get(added.effect, 0) - _of_added(added, moving, motions)
    for index, reflected in sorted(loads.reflected.items()):
        for effect, inertia in reflected:
            with store.section("Power of gears", effect=effect, source="-J u du/dt"):
                u = moving.u[index]
                work = inertia * (u * moving.speeds[u]) if isinstance(u, Value) else 0
                result[effect] = result.get(effect, 0) - work
    return result


def _of_account(account: Account, moving: Moving, motions: "Sequence[LinkVelocity]") -> Scalar:
    store = moving.placement.kinematics.store
    power: Scalar = 0
    for forces in (account.torques, account.generalised):
        for index, load in sorted(forces.items()):
            store.link = index
            power = power + load * moving.u[index]
    for index, (force, moment) in sorted(account.wrenches.items()):
        store.link = index
        velocity, omega = _twist(index, moving, motions)
        power = power + (dot(force, velocity) + dot(moment, omega))
    return power


def _twist(index: int, moving: Moving, motions: "Sequence[LinkVelocity]") -> tuple[Vector3, Vector3]:
    """Velocity of the origin and angular velocity of a link, carrier components, or of the base."""
    if index != WORLD:
        return motions[index].velocity, motions[index].omega
    base = moving.placement.base
    assert base is not None
    return base.velocity.linear, base.velocity.angular


def _of_field(acceleration: Vector3, moving: Moving, motions: "Sequence[LinkVelocity]") -> Scalar:
    placement = moving.placement
    power: Scalar = 0
    for index, (mass, motion) in enumerate(zip(moving.masses, motions, strict=True)):
        placement.kinematics.store.link = index
        pull = rotate_back(placement.carrier(index), acceleration)  # N/kg, in the axes of the momentum
        momentum = add(scale(mass.mass, motion.velocity), add(cross(motion.omega, mass.first), mass.change))
        power = power + dot(pull, momentum)
    if placement.base is not None:
        at_base = rotate_back(placement.base.rotation, acceleration)
        power = power + moving.base_mass * dot(at_base, placement.base.velocity.linear)
    return power


def _of_added(added: AddedInertia, moving: Moving, motions: "Sequence[LinkVelocity]") -> Scalar:
    """wᵀ A dw/dt, components in axes of the body: the terms with ω × (p, l) do no work."""
    velocity, omega = point_motion(moving.placement, added, motions)
    w = (*velocity, *omega)
    changes = derivatives(w, moving.speeds)
    return dot(w, [dot(row, changes) for row in added.matrix])


def point_motion(
    placement: Placement, added: AddedInertia, motions: "Sequence[LinkVelocity]"
) -> tuple[Vector3, Vector3]:
    """Velocity of the point of added inertia and angular velocity of its body, which is rigid; its drawn axes."""
    base = placement.base
    if added.link == WORLD:
        assert base is not None
        twist = base.velocity
        return add(twist.linear, cross(twist.angular, added.arm)), twist.angular
    motion = motions[added.link]
    velocity = add(motion.velocity, cross(motion.omega, added.arm))
    axes = placement.kinematics.drawn_frame(added.link)
    return rotate(axes, velocity), rotate(axes, motion.omega)

"""Kinematics of a tree of hinges, staged: turns, positions, angular velocities, bias accelerations.

Goes in: a Tree, and q and u as scalars. Comes out: components, per link, in the link's carrier frame. It knows no
mass and no force.

Carrier frames. A run of parallel hinges shares one carrier that does not take part in their turning; a link of a
run is turned about the carrier's z axis by the sum of the angles so far. Vectors then need no rotation between
the links of a run, which brings a planar chain down from some 300 operations per link to under 70. A link
outside any run is its own carrier.
"""

from collections.abc import Collection, MutableMapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from lamc.basics.checks import Array
from lamc.mechanics.drawn import of_link
from lamc.mechanism.tree import WORLD, Link, Tree
from lamc.symbolic.algebra import (
    ZERO,
    AxisRotation,
    Matrix3,
    Symmetric,
    Vector3,
    add,
    cross,
    dot,
    inward,
    inward_matrix,
    inward_symmetric,
    outward,
)
from lamc.symbolic.scalars import Scalar, cos, sin
from lamc.symbolic.staging import Store

if TYPE_CHECKING:
    from lamc.mechanics.arrangement import Arrangement


@dataclass(frozen=True)
class LinkVelocity:
    """Velocity state of one link, carrier components.

    omega     angular velocity, rad/s
    velocity  of the origin, m/s; None where it was not asked for
    """

    omega: Vector3
    velocity: Vector3


@dataclass(frozen=True)
class Bias:
    """Acceleration state of one link for zero hinge accelerations, carrier components.

    acceleration  of the origin, m/s², the negative of a uniform field included
    gradient      [α]× + [ω]×[ω]×, 1/s²: the point at r accelerates by acceleration + gradient r
    """

    acceleration: Vector3
    gradient: Matrix3


class Kinematics:
    """Turns and offsets of all links for one set of joint angles.

    arrangement  None here: there are no coordinates but the angles of the hinges
    flexible     indices of the links that bend: none here
    """

    arrangement: "Arrangement | None" = None
    flexible: Collection[int] = ()

    def __init__(self, store: Store, tree: Tree, q: Sequence[Scalar]) -> None:
        self.store = store
        self.tree = tree
        self.in_run = [
            link.parallel or any(tree.links[c].parallel for c in tree.children(i))
            for i, link in enumerate(tree.links)
        ]
        self.spin: list[AxisRotation | None] = []  # own turn of a link of a run within its carrier
        self.rotations: list[tuple[AxisRotation, ...]] = []  # from the parent's carrier to the link's
        self.offset: list[Vector3] = []  # of the origin from the parent's, in the parent's carrier
        heading: list[Scalar] = []
        with store.section("Rotation about the hinges", source="eq. 1-4"):
            for i, link in enumerate(tree.links):
                store.link = i
                (offset,) = of_link(store, "angle offset", i, link)
                angle = link.angle_sign * q[i] + offset
                if link.parallel:
                    angle = heading[link.parent] + angle
                heading.append(angle)
                self._place(i, link, self.in_run[i], AxisRotation("z", cos(angle), sin(angle)))

    def _place(self, index: int, link: Link, in_run: bool, own: AxisRotation) -> None:
        parent_spin = None if link.parent == WORLD else self.spin[link.parent]
        self.spin.append(own if in_run else None)
        rotations: list[AxisRotation] = []
        if not link.parallel:
            twist = (
                _join(parent_spin, self._constant_rotation("twist", index))
                if link.twist != (1.0, 0.0)
                else parent_spin
            )
            if twist is not None:
                rotations.append(twist)
            if link.fold != (1.0, 0.0):
                rotations.append(self._constant_rotation("fold", index))
            if not in_run:
                rotations.append(own)
        self.rotations.append(tuple(rotations))
        x, y, z = of_link(self.store, "offset", index, link)
        offset: Vector3 = (x, y, z)
        self.offset.append(inward(parent_spin, offset) if parent_spin else offset)

    def _constant_rotation(self, kind: str, index: int) -> AxisRotation:
        """The link's "twist", about z, or "fold", about x."""
        c, s = of_link(self.store, kind, index, self.tree.links[index])
        return AxisRotation("z" if kind == "twist" else "x", c, s)

    def drawn_frame(self, index: int) -> Matrix3:
        """World from the link's frame as drawn."""
        xx, xy, xz, yx, yy, yz, zx, zy, zz = of_link(self.store, "frame", index, self.tree.links[index])
        return ((xx, xy, xz), (yx, yy, yz), (zx, zy, zz))

    def drawn_origin(self, index: int) -> Vector3:
        """Where the link's origin is drawn, m, world."""
        x, y, z = of_link(self.store, "origin", index, self.tree.links[index])
        return (x, y, z)

    def to_child(self, index: int, v: Vector3) -> Vector3:
        """Components in the link's carrier of a vector given in its parent's."""
        for rotation in self.rotations[index]:
            v = outward(rotation, v)
        return v

    def to_parent(self, index: int, v: Vector3) -> Vector3:
        """Components in the parent's carrier of a vector given in the link's."""
        for rotation in reversed(self.rotations[index]):
            v = inward(rotation, v)
        return v

    def symmetric_to_parent(self, index: int, a: Symmetric) -> Symmetric:
        for rotation in reversed(self.rotations[index]):
            a = inward_symmetric(rotation, a)
        return a

    def matrix_to_parent(self, index: int, m: Matrix3) -> Matrix3:
        for rotation in reversed(self.rotations[index]):
            m = inward_matrix(rotation, m)
        return m

    def in_carrier(self, index: int, v: Vector3) -> Vector3:
        """Components in the carrier of a vector fixed in the link's own frame."""
        spin = self.spin[index]
        return inward(spin, v) if spin else v

    def attached(self, index: int, local: Vector3, place: Array) -> Vector3:
        """Components in the carrier of a point of the link; `place` is `local` as numbers. A rigid link has no more."""
        return self.in_carrier(index, local)

    def directed(self, index: int, direction: Vector3, place: Array) -> Vector3:
        """Components in the carrier of a direction fixed to the link at a place."""
        return self.in_carrier(index, direction)

    def own_velocity(self, index: int, place: Array, u: Sequence[Scalar]) -> Vector3:
        """Velocity, m/s, of a point of the link within its frame; a rigid link has none."""
        return ZERO

    def wrench_at_origin(
        self, index: int, force: Vector3, moment: Vector3, local: Vector3, work: MutableMapping[int, Scalar]
    ) -> tuple[Vector3, Vector3]:
        """A wrench at a point of the link, given by numbers, about the link's origin; all in carrier components.

        `work` gains what it does on the coordinates within the link; a rigid link has none.
        """
        return force, add(moment, cross(self.in_carrier(index, local), force))

    def symmetric_in_carrier(self, index: int, a: Symmetric) -> Symmetric:
        spin = self.spin[index]
        return inward_symmetric(spin, a) if spin else a

    def motions(self, u: Sequence[Scalar]) -> list[LinkVelocity]:
        """Angular velocities and velocities of the origins."""
        motions: list[LinkVelocity] = []
        with self.store.section("Velocities", source="eq. 13-14"):
            for i, link in enumerate(self.tree.links):
                self.store.link = i
                omega, velocity = ZERO, ZERO
                if link.parent != WORLD:
                    parent = motions[link.parent]
                    velocity = add(parent.velocity, cross(parent.omega, self.offset[i]))
                    omega = self.to_child(i, parent.omega)
                    velocity = self.to_child(i, velocity)
                omega = (omega[0], omega[1], omega[2] + link.angle_sign * u[i])
                motions.append(LinkVelocity(omega, velocity))
        return motions

    def biases(
        self, u: Sequence[Scalar], base: Sequence[Vector3], accelerations: Sequence[Scalar] | None = None
    ) -> list[Bias]:
        """Accelerations with the hinge accelerations given, rad/s^2, or all zero.

        base[i], used for links on the world, is the acceleration of the world in the link's drawn frame: the
        negative of a uniform field, so that the field acts on every mass without a term of its own.
        """
        biases: list[Bias] = []
        omegas: list[Vector3] = []
        alphas: list[Vector3] = []
        with self.store.section("Velocities and bias accelerations", source="eq. 13-14"):
            for i, link in enumerate(self.tree.links):
                self.store.link = i
                omega, alpha, acceleration = ZERO, ZERO, base[i]
                if link.parent != WORLD:
                    parent = biases[link.parent]
                    g, r = parent.gradient, self.offset[i]
                    acceleration = add(parent.acceleration, (dot(g[0], r), dot(g[1], r), dot(g[2], r)))
                    omega, alpha = omegas[link.parent], alphas[link.parent]
                omega, alpha = self.to_child(i, omega), self.to_child(i, alpha)
                rate = link.angle_sign * u[i]
                own = link.angle_sign * accelerations[i] if accelerations else 0
                alpha = (alpha[0] + omega[1] * rate, alpha[1] - omega[0] * rate, alpha[2] + own)
                omega = (omega[0], omega[1], omega[2] + rate)
                omegas.append(omega)
                alphas.append(alpha)
                biases.append(Bias(self.to_child(i, acceleration), acceleration_gradient(omega, alpha)))
        return biases


def acceleration_gradient(w: Vector3, alpha: Vector3) -> Matrix3:
    """[α]× + [ω]×[ω]×, 1/s²."""
    x, y, z = w
    xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
    return (
        (-(yy + zz), xy - alpha[2], xz + alpha[1]),
        (xy + alpha[2], -(xx + zz), yz - alpha[0]),
        (xz - alpha[1], yz + alpha[0], -(xx + yy)),
    )


def _join(first: AxisRotation | None, second: AxisRotation) -> AxisRotation:
    """Two turns about z in a row as one."""
    if first is None:
        return second
    return AxisRotation(
        "z",
        first.cos * second.cos - first.sin * second.sin,
        first.sin * second.cos + first.cos * second.sin,
    )

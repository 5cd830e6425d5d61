"""Kinematics in the general form: hinges that also yield, ride on bent plates, and stand on a base that moves.

Goes in: an `Arrangement`, q as scalars, and the base's motion. Comes out: what `Kinematics` gives, link by link, and
forces on their way back. A link's frame is its own; runs of parallel hinges share none here.
"""

import math
from collections.abc import Iterator, MutableMapping, Sequence
from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.mechanics import chains
from lamc.mechanics.arrangement import Arrangement, CompliantHinge
from lamc.mechanics.chains import LinkState, Rotation, Shift, Step, Wrench
from lamc.mechanics.drawn import of_link
from lamc.mechanics.flexible import FlexibleBody
from lamc.mechanics.kinematics import Kinematics, LinkVelocity
from lamc.mechanics.moving_base import STILL, MovingBase, Twist
from lamc.mechanics.placement import rotate, rotate_back
from lamc.mechanism.rotations import snap
from lamc.mechanism.tree import WORLD, Link
from lamc.symbolic.algebra import (
    ZERO,
    AxisRotation,
    Vector3,
    add,
    cross,
    dot,
    inward,
    outward,
    scale,
)
from lamc.symbolic.scalars import Scalar, cos, sin
from lamc.symbolic.staging import Store

UNITS: tuple[Vector3, Vector3, Vector3] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


@dataclass(frozen=True)
class Modes:
    """The modes of a flexible link: η_k is q[first + k]; normal in the link's frame."""

    body: FlexibleBody
    first: int
    normal: Vector3
    deflection: tuple[Scalar, ...]  # η

    def rates(self, u: Sequence[Scalar]) -> Sequence[Scalar]:
        """What u, or u̇, has for the modes."""
        return u[self.first : self.first + self.body.count]


class ChainKinematics(Kinematics):
    """Turns and offsets of all links. The interface is that of `Kinematics`."""

    arrangement: Arrangement

    def __init__(
        self, store: Store, arrangement: Arrangement, q: Sequence[Scalar], base: MovingBase | None
    ) -> None:
        self.store, self.tree, self.arrangement, self.base = store, arrangement.tree, arrangement, base
        self._q = q
        self.index = {c.name: i for i, c in enumerate(arrangement.coordinates)}
        self.in_run = [False] * len(self.tree.links)
        self.spin = [None] * len(self.tree.links)
        self.modes = self._modes()
        self.flexible = frozenset(self.modes)
        compliant = {hinge.joint: hinge for hinge in arrangement.compliant}
        self.chains: list[tuple[Step, ...]] = []
        with store.section("From link to link", source="eq. 1-4"):
            for i, link in enumerate(self.tree.links):
                store.link = i
                self.chains.append(tuple(self._chain(i, link, compliant.get(link.joint.name))))
            self.rotations = [chains.rotations(chain) for chain in self.chains]
            self.offset = [chains.offset(chain) for chain in self.chains]

    def on_still_base(self) -> "ChainKinematics":
        """The same links, seen from the base."""
        return ChainKinematics(self.store, self.arrangement, self._q, None) if self.base else self

    def _modes(self) -> dict[int, Modes]:
        place = {link.body.name: i for i, link in enumerate(self.tree.links)}
        result: dict[int, Modes] = {}
        for body in self.arrangement.flexible:
            if body.count:
                index, first = place[body.body], self.index[f"{body.body}.mode_1"]
                normal = self._constants(snap(self.tree.links[index].frame.T @ body.normal, 1.0))
                result[index] = Modes(body, first, normal, tuple(self._q[first : first + body.count]))
        return result

    def _chain(self, i: int, link: Link, hinge: CompliantHinge | None) -> Iterator[Step]:
        """From the parent's frame to the link's; from the link's drawn frame on the base, for those on the world."""
        if link.parent != WORLD:
            yield from self._ride(i, link)
            if link.twist != (1.0, 0.0):
                yield Rotation(self._constant_rotation("twist", i), {})
            if link.fold != (1.0, 0.0):
                yield Rotation(self._constant_rotation("fold", i), {})
        (offset,) = of_link(self.store, "angle offset", i, link)
        angle = link.angle_sign * self._q[i] + offset
        opened = Rotation(AxisRotation("z", cos(angle), sin(angle)), {i: link.angle_sign})
        if hinge is None:
            yield opened
        elif link.joint.child == link.body.name:
            yield from self._yield(link, hinge)
            yield opened
        else:  # the same way back: what yields rides on the joint's parent, whichever side the tree comes from
            yield opened
            yield from self._yield(link, hinge)

    def _ride(self, index: int, link: Link) -> Iterator[Step]:
        """From the parent's frame to the hinge's origin, which rides on the parent's deflection and its slopes."""
        if link.parent not in self.modes:
            x, y, z = of_link(self.store, "offset", index, link)
            yield Shift((x, y, z), {})
            return
        # The slopes are those at the joint's own point: the tree's origin on its line may lie off the plate.
        parent, size = self.tree.links[link.parent], self.tree.mechanism.size
        place = snap(parent.frame.T @ (link.joint.point - parent.origin), size)
        yield from self._to_surface(link.parent, self._constants(place), place)
        along = snap(parent.frame.T @ (link.origin - link.joint.point), size)
        yield Shift(self._constants(along), {})

    def _to_surface(self, index: int, local: Vector3, place: Array) -> Iterator[Step]:
        """From a flexible link's frame to one on its plate at `place`, (3,), m, link's frame, undeformed."""
        modes, link = self.modes[index], self.tree.links[index]
        constant = self.store.constant
        phi, slopes = modes.body.shapes(link.origin + link.frame @ place)
        rise = {
            modes.first + k: scale(constant(float(p)), modes.normal) for k, p in enumerate(phi) if p != 0.0
        }
        lifted = chains.total_vector([scale(self._q[k], v) for k, v in rise.items()])
        yield Shift(add(local, lifted), rise)
        frame = _plane_frame(modes.body.normal)
        yield from chains.constant_rotation(self.store, link.frame.T @ frame)
        # The surface turns by ∇w × n: about the first direction in the plane by the slope along the second, and back.
        for axis, slope in (("x", slopes @ frame[:, 1]), ("y", -slopes @ frame[:, 0])):
            partials = {modes.first + k: constant(float(v)) for k, v in enumerate(slope) if v != 0.0}
            if partials:
                yield from chains.elementary(axis, partials, self._q)
        yield from chains.constant_rotation(self.store, (link.frame.T @ frame).T)

    def _yield(self, link: Link, hinge: CompliantHinge) -> Iterator[Step]:
        """Slides, then twists, of a compliant hinge, on the side of the joint's parent; backwards where the tree comes
        from its child."""
        forth = link.joint.child == link.body.name
        c, s = math.cos(link.angle_offset), math.sin(link.angle_offset)
        unturned = np.array(
            [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]
        )  # the link's frame without the offset's turn
        drawn = link.frame @ unturned if forth else link.frame
        axes = drawn.T @ hinge.axes
        height = snap(drawn.T @ (hinge.point - link.origin), self.tree.mechanism.size) * [0.0, 0.0, 1.0]
        own = {f: self.index[f"{hinge.joint}.{f}"] for f in hinge.freedoms}
        sense = 1 if forth else -1
        slides = {
            own[f"slide_{name}"]: scale(sense, unit)
            for name, unit in zip("xyz", UNITS, strict=True)
            if f"slide_{name}" in own
        }
        moved = chains.total_vector([scale(self._q[k], v) for k, v in slides.items()])
        parts: list[list[Step]] = [[Shift(moved, slides)] if slides else []]
        for axis in "xy":
            twist = f"twist_{axis}"
            parts.append(list(chains.elementary(axis, {own[twist]: sense}, self._q)) if twist in own else [])
        yield Shift(self._constants(height), {})
        yield from chains.constant_rotation(self.store, axes)
        for part in parts if forth else reversed(parts):
            yield from part
        yield from chains.constant_rotation(self.store, axes.T)
        yield Shift(self._constants(-height), {})

    def _constants(self, values: Array) -> Vector3:
        x, y, z = (self.store.constant(float(v)) for v in values)
        return (x, y, z)

    def on_base(self, index: int, wrench: Wrench) -> Wrench:
        """A wrench about the drawn origin of a link on the base, in its drawn frame, about the base's reference."""
        assert self.base is not None
        frame = self.drawn_frame(index)
        force, moment = rotate(frame, wrench[0]), rotate(frame, wrench[1])
        return force, add(moment, cross(self.base.arm(self.tree.links[index].origin, ("arm", index)), force))

    def motions(self, u: Sequence[Scalar]) -> list[LinkVelocity]:
        """Angular velocities and velocities of the origins, in the world."""
        with self.store.section("Velocities", source="eq. 13-14"):
            return [LinkVelocity(g.omega, g.velocity) for g in self._outwards(u, None, STILL)]

    def link_states(
        self, u: Sequence[Scalar], udot: Sequence[Scalar] | None, field: Vector3
    ) -> list[LinkState]:
        """Velocities and accelerations; a uniform field, m/s², world axes, is an acceleration the other way."""
        with self.store.section("Velocities and accelerations", source="eq. 13-14"):
            return self._outwards(u, udot, self.base_acceleration(udot, field))

    def base_acceleration(self, udot: Sequence[Scalar] | None, field: Vector3) -> Twist:
        """Of the base's reference less the field, axes of the base."""
        base = self.base
        prescribed = base.acceleration(udot) if base is not None else STILL
        pull = rotate_back(base.rotation, field) if base is not None else field
        return Twist(prescribed.angular, add(prescribed.linear, (-pull[0], -pull[1], -pull[2])))

    def _outwards(self, u: Sequence[Scalar], udot: Sequence[Scalar] | None, base: Twist) -> list[LinkState]:
        result: list[LinkState] = []
        velocity = self.base.velocity if self.base is not None else STILL
        for i, link in enumerate(self.tree.links):
            self.store.link = i
            if link.parent == WORLD:
                link_state = LinkState(velocity.angular, velocity.linear, base.angular, base.linear)
                if self.base is not None:
                    arm = self.base.arm(link.origin, ("arm", i))
                    link_state = chains.through(link_state, Shift(arm, {}), u, udot)
                frame = self.drawn_frame(i)
                parts = (link_state.omega, link_state.velocity, link_state.alpha, link_state.acceleration)
                link_state = LinkState(*(rotate_back(frame, part) for part in parts))
            else:
                link_state = result[link.parent]
            for step in self.chains[i]:
                link_state = chains.through(link_state, step, u, udot)
            result.append(link_state)
        return result

    def inwards(self, wrenches: Sequence[Wrench]) -> tuple[dict[int, Scalar], Wrench]:
        """Work on the coordinates of wrenches about the links' origins, by coordinate; and what reaches the base, about
        its reference, axes of the base."""
        work: dict[int, Scalar] = {}
        carried = list(wrenches)
        at_base: Wrench = (ZERO, ZERO)
        with self.store.section("Forces on the way to the world", source="eq. 18"):
            for i in reversed(range(len(self.tree.links))):
                self.store.link = i
                link, wrench = self.tree.links[i], carried[i]
                for step in reversed(self.chains[i]):
                    wrench = chains.back(wrench, step, work)
                if link.parent != WORLD:
                    carried[link.parent] = chains.together(carried[link.parent], wrench)
                elif self.base is not None:
                    at_base = chains.together(at_base, self.on_base(i, wrench))
        return work, at_base

    def attached(self, index: int, local: Vector3, place: Array) -> Vector3:
        """A point of the link with its deflection, m, link's frame; local and place: the same point undeformed."""
        modes = self.modes.get(index)
        if modes is None:
            return local
        return add(local, scale(dot(self._shape(index, place), modes.deflection), modes.normal))

    def directed(self, index: int, direction: Vector3, place: Array) -> Vector3:
        """A direction fixed to the plate at a place of the link, as the slopes there turn it."""
        if index in self.modes:
            for turn in reversed(chains.rotations(self._to_surface(index, ZERO, place))):
                direction = inward(turn, direction)
        return direction

    def own_velocity(self, index: int, place: Array, u: Sequence[Scalar]) -> Vector3:
        """Velocity, m/s, of a point of the link within its frame."""
        modes = self.modes.get(index)
        if modes is None:
            return ZERO
        return scale(dot(self._shape(index, place), modes.rates(u)), modes.normal)

    def wrench_at_origin(
        self, index: int, force: Vector3, moment: Vector3, local: Vector3, work: MutableMapping[int, Scalar]
    ) -> Wrench:
        """A wrench at a point of the link, given by numbers, about the link's origin; all in the link's axes."""
        steps: list[Step] = [Shift(local, {})]
        if index in self.modes:
            steps = list(self._to_surface(index, local, np.array(local, dtype=np.float64)))
        for turn in chains.rotations(steps):
            force, moment = outward(turn, force), outward(turn, moment)
        wrench: Wrench = (force, moment)
        for step in reversed(steps):
            wrench = chains.back(wrench, step, work)
        return wrench

    def _shape(self, index: int, place: Array) -> list[Scalar]:
        link = self.tree.links[index]
        phi, _ = self.modes[index].body.shapes(link.origin + link.frame @ place)
        return [self.store.constant(float(p)) for p in phi]


def _plane_frame(normal: Array) -> Array:
    """Two directions in the plane and its normal, as columns."""
    helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(helper, normal)
    first = first / np.linalg.norm(first)
    return np.column_stack([first, np.cross(normal, first), normal])

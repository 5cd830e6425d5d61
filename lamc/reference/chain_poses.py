"""Where all bodies are along a motion, hinges that yield and bodies that bend among them: numbers in, poses out.

A walk from the world outwards; each hinge is one product of 4 by 4 matrices more. Conventions are those of the records:
slides and twists ride on the inner body, twist_x before twist_y before the angle. The surface of a body that bends
turns by its slopes about two directions in its plane, one after the other: for plates along x and y about -y by the
slope along x, and then about x by that along y.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from lamc.mechanics.compliant_hinge import CompliantHinge
from lamc.mechanics.flexible import FlexibleBody
from lamc.records.mechanism import Body
from lamc.reference.base_pose import base_pose
from lamc.reference.curves import Amount, Curve, about, rotation_curve, slide
from lamc.reference.kinematics import Array, Link


@dataclass(frozen=True)
class Chain:
    """What the poses of a mechanism follow from.

    links      of the walk
    fixed      bodies of the base
    mover      the effect that moves these, or None
    yielding   by joint of the walk
    bending    by body
    rates      names of u; those of q are the same before the base's
    """

    links: Sequence[Link]
    fixed: Sequence[Body]
    mover: Any
    yielding: Mapping[str, CompliantHinge]
    bending: Mapping[str, FlexibleBody]
    rates: Sequence[str]

    @cached_property
    def index(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.rates)}

    def modes(self, body: str) -> list[int]:
        """Their places in u; none of a rigid body."""
        count = self.bending[body].count if body in self.bending else 0
        return [self.index[f"{body}.mode_{k + 1}"] for k in range(count)]

    def at(self, q: Array, u: Array, t: float) -> "Placed":
        """All bodies at a state and a time."""
        return Placed(self, np.asarray(q, dtype=np.float64), np.asarray(u, dtype=np.float64), t)


class Placed:
    """A `Place` at one state, with poses and particles as curves."""

    def __init__(self, chain: Chain, q: Array, u: Array, t: float) -> None:
        self.chain, self._q, self._u = chain, q, u
        base = base_pose(chain.mover, chain.fixed, q, u, t)
        self.poses = {body.name: base for body in chain.fixed}
        for link in chain.links:
            inner = base
            if link.inner >= 0:
                inner = self.surface(chain.links[link.inner].body.name, link.joint.point)
            self.poses[link.body.name] = inner @ self._through(link)

    def point(self, body: str, drawn: Array) -> tuple[Array, Array]:
        moved = self.particle(body, drawn)
        return moved.value, moved.first

    def direction(self, body: str, drawn: Array) -> Array:
        return np.asarray(self.poses[body].value[:3, :3] @ drawn)

    def particle(self, body: str, drawn: Array) -> Curve:
        """A point of the body given as drawn, m: (3,) and (n, 3)."""
        pose = self.poses[body]
        if body in self.chain.bending:
            phi, _ = self.chain.bending[body].shapes(drawn)
            return (pose @ self.bent(body, np.append(drawn, 1.0)[:, None], phi[:, None])).block(0, 1).flat()
        return pose.times(np.append(drawn, 1.0)[:, None]).block(0, 1).flat()

    def bent(self, body: str, still_part: Array, shapes: Array) -> Curve:
        """Columns (4, c) as drawn, with n Σ φ_k η_k of shapes (k, c) added."""
        normal, modes = np.append(self.chain.bending[body].normal, 0.0), self.chain.modes(body)
        partials = np.zeros((len(self._u), 4, shapes.shape[1]))
        partials[modes] = normal[None, :, None] * shapes[:, None, :]
        value = still_part + np.tensordot(self._q[modes], partials[modes], axes=1)
        first = np.tensordot(self._u[modes], partials[modes], axes=1)
        return Curve(value, first, np.zeros_like(value), partials)

    def surface(self, body: str, drawn: Array) -> Curve:
        """The pose of what is attached at a point of the body; of a rigid body that of the body."""
        if body not in self.chain.bending:
            return self.poses[body]
        chain, count = self.chain, len(self._u)
        record, modes = chain.bending[body], chain.modes(body)
        phi, slopes = record.shapes(drawn)
        risen = self.bent(body, np.zeros((4, 1)), phi[:, None])
        steps = [_shifted(risen)]
        first = np.cross(np.eye(3)[np.argmin(np.abs(record.normal))], record.normal)
        first /= np.linalg.norm(first)
        second = np.cross(record.normal, first)
        for axis, along in ((first, slopes @ second), (second, -slopes @ first)):
            steps.append(_rotated(axis, along, self._q[modes], self._u[modes], modes, count))
        return self.poses[body] @ about(drawn, count, *steps)

    def _through(self, link: Link) -> Curve:
        """From the outer body's drawn coordinates to those of the inner one's surface, drawn."""
        chain, joint, count = self.chain, link.joint, len(self._u)

        def amount(name: str) -> Amount:
            i = chain.index[name]
            return Amount(link.sign * self._q[i], link.sign * self._u[i], i, link.sign)

        opened = rotation_curve(joint.axis, amount(joint.name), count)
        hinge = chain.yielding.get(joint.name)
        if hinge is None:
            return about(joint.point, count, opened)
        steps = []
        for kind, make in (("slide", slide), ("twist", rotation_curve)):
            for k, letter in enumerate("xyz"):
                if f"{kind}_{letter}" in hinge.freedoms:
                    steps.append(make(hinge.axes[:, k], amount(f"{joint.name}.{kind}_{letter}"), count))
        way = [*steps, opened] if link.sign > 0 else [opened, *reversed(steps)]
        return about(hinge.point, count, *way)


def _shifted(rise: Curve) -> Curve:
    """The displacement by a column (4, 1)."""
    parts = []
    for part, whole in (
        (rise.value, np.eye(4)),
        (rise.first, None),
        (rise.second, None),
        (rise.partials, None),
    ):
        matrix = np.zeros((*part.shape[:-2], 4, 4)) if whole is None else whole
        matrix[..., :, 3] += part[..., :, 0]
        parts.append(matrix)
    return Curve(*parts)


def _rotated(axis: Array, shares: Array, q: Array, u: Array, modes: Sequence[int], count: int) -> Curve:
    """Rotation by the sum of shares of several coordinates."""
    whole = rotation_curve(axis, Amount(float(shares @ q), float(shares @ u), 0), count)
    partials = np.zeros_like(whole.partials)
    partials[list(modes)] = shares[:, None, None] * whole.partials[0]
    return Curve(whole.value, whole.first, whole.second, partials)

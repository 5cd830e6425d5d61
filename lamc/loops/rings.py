"""Closure of loops along short cycles, in numbers: what is left open around each, and how that changes.

In: the cycles of a tree, its hinge lines as drawn, angles of all hinges. Out: residuals, their sparse Jacobian, the
bias of their accelerations. Never: goes from a body to the world, so that errors do not grow with a mechanism's size.

Going around a cycle, the rotations about its lines as drawn multiply to the identity where it closes (product of
exponentials; R. Brockett, 1984). Six numbers are left of each otherwise, whatever the lines have in common: lines that
meet but for a drawing's rounding are told from lines that meet. Displacements are measured where the lines meet.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from lamc.loops.cycles import Cycle
from lamc.records.mechanism import Array

if TYPE_CHECKING:
    from scipy import sparse

NARROW = 1e-2  # of the size: hinges nearer to a cycle's centre do not measure its displacements


@dataclass(frozen=True, eq=False)
class Ring:
    """Cycles of k hinges, c of them.

    rows    (c,): which cycles
    joints  (c, k): the hinges in the order of the way; signs (c, k): +1 from parent to child
    axes    (c, k, 3): directions as drawn; arms (c, k, 3): points, from the cycle's centre, in its unit
    unit    (c,), m: the distance of the cycle's farthest hinge from its centre; the mechanism's size where all are near
    """

    rows: npt.NDArray[np.int64]
    joints: npt.NDArray[np.int64]
    signs: Array
    axes: Array
    arms: Array
    unit: Array


class Rings:
    """All short cycles of one tree. Angles and rates are rows (n,) of all hinges."""

    def __init__(self, cycles: Sequence[Cycle], points: Array, axes: Array, size: float) -> None:
        """points (n, 3), m, and axes (n, 3) of the hinges as drawn; size: m, of the mechanism."""
        self.count, self.width = len(cycles), len(points)
        self.rings = tuple(
            _ring([(row, c) for row, c in enumerate(cycles) if len(c.joints) == length], points, axes, size)
            for length in sorted({len(c.joints) for c in cycles})
        )
        columns = [np.repeat(ring.joints[:, None, :], 6, axis=1).ravel() for ring in self.rings]
        rows = [
            np.repeat((6 * ring.rows[:, None] + np.arange(6)).ravel(), ring.joints.shape[1])
            for ring in self.rings
        ]
        self._place = (np.concatenate([*rows, []]).astype(int), np.concatenate([*columns, []]).astype(int))

    def residual(self, angles: Array) -> "tuple[Array, sparse.csr_array]":
        """What is left open (6 cycles,), rad and parts of each cycle's unit, and its Jacobian (6 cycles, n), exact
        where the cycles close."""
        from scipy import sparse  # a quarter of a second, which reading a design does not need

        left = np.zeros((self.count, 6))
        entries = []
        for ring in self.rings:
            screws, rotation, shift = _around(ring, angles)
            left[ring.rows, :3], left[ring.rows, 3:] = rotation_vectors(rotation), shift
            entries.append(screws.transpose(0, 2, 1).ravel())
        shape = (6 * self.count, self.width)
        return left.ravel(), sparse.csr_array((np.concatenate([*entries, []]), self._place), shape=shape)

    def bias(self, angles: Array, rates: Array) -> Array:
        """(6 cycles, d, d): the bias of the cycles' accelerations as a symmetric bilinear form of rates (n, d), at
        closed angles: the Lie brackets of the screws passed before with each."""
        size = rates.shape[1]
        found = np.zeros((self.count, 6, size, size))
        for ring in self.rings:
            found[ring.rows] = _bias(_around(ring, angles)[0], rates[ring.joints])
        return found.reshape(6 * self.count, size, size)

    def local_bias(self, angles: Array) -> list[Array]:
        """The same of each ring by its own joints only, (c, 6, k, k)."""
        return [
            _bias(_around(ring, angles)[0], np.tile(np.eye(ring.joints.shape[1]), (len(ring.rows), 1, 1)))
            for ring in self.rings
        ]


def _ring(numbered: Sequence[tuple[int, Cycle]], points: Array, axes: Array, size: float) -> Ring:
    joints = np.array([cycle.joints for _, cycle in numbered])
    arms = points[joints] - np.array([cycle.centre for _, cycle in numbered])[:, None, :]
    reach = np.linalg.norm(arms, axis=2).max(axis=1)
    unit = np.where(reach > NARROW * size, reach, size)
    return Ring(
        np.array([row for row, _ in numbered]),
        joints,
        np.array([cycle.signs for _, cycle in numbered], dtype=np.float64),
        axes[joints],
        arms / unit[:, None, None],
        unit,
    )


def _bias(screws: Array, rates: Array) -> Array:
    """(c, 6, d, d), symmetric, of screws (c, k, 6) and rates (c, k, d)."""
    count, length, size = rates.shape
    found = np.zeros((count, 6, size, size))
    carried = np.zeros((count, size, 6))
    for i in range(length):
        screw, rate = screws[:, i], rates[:, i]  # (c, 6), (c, d)
        turning = np.cross(carried[:, :, :3], screw[:, None, :3])
        moving = np.cross(carried[:, :, :3], screw[:, None, 3:])
        moving += np.cross(carried[:, :, 3:], screw[:, None, :3])
        brackets = np.concatenate([turning, moving], axis=2)  # (c, d, 6)
        found += brackets.transpose(0, 2, 1)[..., None] * rate[:, None, None, :]
        carried += rate[:, :, None] * screw[:, None, :]
    return np.asarray(0.5 * (found + found.transpose(0, 1, 3, 2)))


def _around(ring: Ring, angles: Array) -> tuple[Array, Array, Array]:
    """Of each cycle of a ring: screws (c, k, 6) of its hinges where they are, by rates of their angles; and the
    rotation (c, 3, 3) and the shift (c, 3) that are left behind."""
    count, length = ring.joints.shape
    rotation, shift = np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3))
    screws = np.zeros((count, length, 6))
    turned = ring.signs * angles[ring.joints]
    for i in range(length):
        axis = np.einsum("cab,cb->ca", rotation, ring.axes[:, i])
        point = np.einsum("cab,cb->ca", rotation, ring.arms[:, i]) + shift
        screws[:, i, :3], screws[:, i, 3:] = axis, np.cross(point, axis)
        screws[:, i] *= ring.signs[:, i, None]
        turn = rotations(ring.axes[:, i], turned[:, i])
        rest = ring.arms[:, i] - np.einsum("cab,cb->ca", turn, ring.arms[:, i])
        shift = shift + np.einsum("cab,cb->ca", rotation, rest)
        rotation = rotation @ turn
    return screws, rotation, shift


def rotations(axes: Array, angles: Array) -> Array:
    """(c, 3, 3): about unit vectors (c, 3) by angles (c,), rad (Rodrigues)."""
    x, y, z = axes.T
    zero = np.zeros_like(x)
    cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    sine, versine = np.sin(angles), 2.0 * np.sin(0.5 * angles) ** 2
    return np.asarray(np.eye(3) + sine[:, None, None] * cross + versine[:, None, None] * (cross @ cross))


def rotation_vectors(rotation: Array) -> Array:
    """Axis times angle (c, 3), rad, of rotations (c, 3, 3); exact to round-off near the identity, and to its square
    root near a half turn, where the antisymmetric part vanishes as it does for none."""
    r = rotation
    twice_sine = np.stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=1)
    length = np.linalg.norm(twice_sine, axis=1)
    angle = np.arctan2(length, np.trace(r, axis1=1, axis2=2) - 1.0)
    small = length < 1e-9
    found = twice_sine * np.where(small, 0.5, angle / np.where(small, 1.0, length))[:, None]
    for k in np.flatnonzero(small & (angle > 1.0)):
        twice_dyad = r[k] + np.eye(3)
        axis = twice_dyad[:, int(np.argmax(np.diag(twice_dyad)))]
        found[k] = angle[k] * axis / np.linalg.norm(axis)
    return np.asarray(found)

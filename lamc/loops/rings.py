"""Closure of loops along short cycles, in numbers: what is left open around each, and how that changes.

In: the cycles of a tree, its hinge lines as drawn, angles of all hinges. Out: residuals, their Jacobian, the bias
of their accelerations. Never: goes from a body to the world, so that errors do not grow with a mechanism's size.

Going around a cycle, the rotations about its lines as drawn multiply to the identity where it closes (product of
exponentials; R. Brockett, 1984). Six numbers are left of each otherwise, whatever the lines have in common: lines that
meet but for a drawing's rounding are told from lines that meet. Displacements are measured where the lines meet.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from lamc.loops.cycles import Cycle
from lamc.records.mechanism import Array

if TYPE_CHECKING:
    from scipy import sparse

Places = npt.NDArray[np.int64]

NARROW = 1e-2  # of the size: hinges nearer to a cycle's centre do not measure its displacements
# Where direction (3) and moment (3) of a line are among the 16 entries of its Plücker matrix L = P A^T - A P^T, with
# a point P = (p, 1) on the line and A = (a, 0): displaced by T, in homogeneous coordinates, it is T L T^T.
_LINE = np.array([12, 13, 14, 6, 8, 1])
_SAME = np.eye(4)

_PARTS = np.zeros((9, 4))  # of a rotation: twice its sine times its axis, and its trace
_PARTS[[7, 2, 3], [0, 1, 2]], _PARTS[[5, 6, 1], [0, 1, 2]], _PARTS[[0, 4, 8], 3] = 1.0, -1.0, 1.0
TINY = 1e-300  # keeps a quotient finite where there is no angle


def _brackets() -> Array:
    """(6, 36): y times it is the matrix (6, 6) that the Lie bracket of screws x and y is x times."""
    found = np.zeros((6, 6, 6))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        for a, b in ((0, 0), (0, 3), (3, 0)):  # ω × ω', ω × v', v × ω'
            found[j + b, i + a, k + a + b], found[i + b, j + a, k + a + b] = 1.0, -1.0
    return found.reshape(6, 36)


_BRACKETS = _brackets()


@dataclass(frozen=True, eq=False)
class Ring:
    """Cycles of k hinges, c of them.

    rows    (c,): which cycles
    joints  (c, k): the hinges in the order of the way; signs (c, k): +1 from parent to child
    lines   (c, k, 4, 4): Plücker matrices as drawn, from the cycle's centre, in its unit; times the signs
    turns   (c, k, 3, 16): of a displacement about a line, in homogeneous coordinates, what is there for each angle,
            and what goes with its sine and its versine (Rodrigues)
    entries (c, k, 6): where screws are in the Jacobian, row by row
    """

    rows: Places
    joints: Places
    signs: Array
    lines: Array
    turns: Array
    entries: Places


class Rings:
    """All short cycles of one tree. Angles and rates are rows (n,) of all hinges."""

    def __init__(self, cycles: Sequence[Cycle], points: Array, axes: Array, size: float) -> None:
        """points (n, 3), m, and axes (n, 3) of the hinges as drawn; size: m, of the mechanism."""
        self.count, self.width = len(cycles), len(points)
        self.rings = tuple(
            _ring([(row, c) for row, c in enumerate(cycles) if len(c.joints) == length], points, axes, size)
            for length in sorted({len(c.joints) for c in cycles})
        )

    def residual(self, angles: Array) -> tuple[Array, list[Array]]:
        """What is left open (..., 6 cycles), rad and parts of each cycle's unit, at rows of angles (..., n); and of
        each ring the screws (..., c, k, 6), for `dense` or `sparse`."""
        left = np.empty((*angles.shape[:-1], self.count, 6))
        screws = []
        for ring in self.rings:
            found, last = _around(ring, angles)
            rows = ring.rows if len(self.rings) > 1 else slice(None)
            left[..., rows, :3], left[..., rows, 3:] = rotation_vectors(last[..., :3, :3]), last[..., :3, 3]
            screws.append(found)
        return left.reshape(*angles.shape[:-1], 6 * self.count), screws

    def dense(self, screws: Sequence[Array]) -> Array:
        """The Jacobian of the residual (..., 6 cycles, n), exact where the cycles close."""
        before = screws[0].shape[:-3]
        found = np.zeros((*before, 6 * self.count * self.width))
        for ring, each in zip(self.rings, screws, strict=True):
            found[..., ring.entries] = each
        return found.reshape(*before, 6 * self.count, self.width)

    def sparse(self, screws: Sequence[Array]) -> "sparse.csr_array":
        """The same of one row of angles, by what is not nil."""
        from scipy import sparse  # a quarter of a second, which reading a design does not need

        order, columns, starts = self._pattern
        data = np.concatenate([each.ravel() for each in screws])[order]
        return sparse.csr_array((data, columns, starts), shape=(6 * self.count, self.width))

    @cached_property
    def _pattern(self) -> tuple[Places, Places, Places]:
        """The order in which entries of screws are in the sparse Jacobian, their columns, and where rows start."""
        entries = np.concatenate([ring.entries.ravel() for ring in self.rings])
        order = np.argsort(entries)
        rows, columns = np.divmod(entries[order], self.width)
        return order, columns, np.searchsorted(rows, np.arange(6 * self.count + 1))

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
    rows, joints = np.array([row for row, _ in numbered]), np.array([cycle.joints for _, cycle in numbered])
    signs = np.array([cycle.signs for _, cycle in numbered], dtype=np.float64)
    arms = points[joints] - np.array([cycle.centre for _, cycle in numbered])[:, None, :]
    reach = np.linalg.norm(arms, axis=2).max(axis=1)
    # m: the distance of the cycle's farthest hinge from its centre; the mechanism's size where all are near
    arms = arms / np.where(reach > NARROW * size, reach, size)[:, None, None]
    at, along = np.zeros((2, *joints.shape, 4))
    at[..., :3], at[..., 3], along[..., :3] = arms, 1.0, axes[joints]
    dyads = at[..., :, None] * along[..., None, :]
    lines = dyads - dyads.swapaxes(-1, -2)
    places = (6 * rows[:, None, None] + np.arange(6)) * len(points) + joints[:, :, None]
    return Ring(rows, joints, signs, signs[..., None, None] * lines, _turns(axes[joints], arms), places)


def _turns(axes: Array, arms: Array) -> Array:
    """(c, k, 3, 16): about lines along unit vectors (c, k, 3) through points (c, k, 3)."""
    cross = cross_matrices(axes)
    found = np.zeros((*axes.shape[:-1], 3, 4, 4))
    found[..., 0, :, :] = _SAME
    for part, linear in ((1, cross), (2, cross @ cross)):
        found[..., part, :3, :3] = linear
        found[..., part, :3, 3] = -(linear @ arms[..., None])[..., 0]
    return found.reshape(*axes.shape[:-1], 3, 16)


def _bias(screws: Array, rates: Array) -> Array:
    """(c, 6, d, d), symmetric, of screws (c, k, 6) and rates (c, k, d)."""
    passed = np.zeros((*rates.shape, 6))  # by the rates, before each hinge
    np.cumsum(rates[:, :-1, :, None] * screws[:, :-1, None, :], axis=1, out=passed[:, 1:])
    brackets = passed @ (screws @ _BRACKETS).reshape(*screws.shape, 6)  # (c, k, d, 6)
    found = brackets.transpose(0, 3, 2, 1) @ rates[:, None]
    return np.asarray(0.5 * (found + found.transpose(0, 1, 3, 2)))


def _around(ring: Ring, angles: Array) -> tuple[Array, Array]:
    """Of each cycle of a ring, at rows of angles (..., n): screws (..., c, k, 6) of its hinges where they are, by rates
    of their angles; and the displacement (..., c, 4, 4) that is left behind."""
    turned = ring.signs * angles.take(ring.joints, axis=-1)
    shape = turned.shape
    half = np.sin(0.5 * turned)
    parts = np.empty((*shape, 1, 3))
    parts[..., 0] = 1.0
    np.sin(turned, out=parts[..., 0, 1])
    np.multiply(2.0 * half, half, out=parts[..., 0, 2])
    turns = (parts @ ring.turns).reshape(*shape, 4, 4)
    passed = np.empty((*shape, 4, 4))
    passed[..., 0, :, :], last = _SAME, turns[..., 0, :, :]
    for i in range(1, shape[-1]):
        passed[..., i, :, :] = last
        last = last @ turns[..., i, :, :]
    lines = passed @ ring.lines @ passed.swapaxes(-1, -2)
    return lines.reshape(*shape, 16).take(_LINE, axis=-1), last


def cross_matrices(vectors: Array) -> Array:
    """(..., 3, 3): matrices that multiply by vectors (..., 3) crosswise."""
    found = np.zeros((*vectors.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        found[..., k, j], found[..., j, k] = vectors[..., i], -vectors[..., i]
    return found


def rotations(axes: Array, angles: Array) -> Array:
    """(c, 3, 3): about unit vectors (c, 3) by angles (c,), rad (Rodrigues)."""
    cross = cross_matrices(axes)
    sine, versine = np.sin(angles), 2.0 * np.sin(0.5 * angles) ** 2
    return np.asarray(np.eye(3) + sine[:, None, None] * cross + versine[:, None, None] * (cross @ cross))


def rotation_vectors(rotation: Array) -> Array:
    """Axis times angle (..., 3), rad, of rotations (..., 3, 3); exact to round-off near the identity, and to its square
    root near a half turn, where the antisymmetric part vanishes as it does for none."""
    parts = rotation.reshape(*rotation.shape[:-2], 9) @ _PARTS
    twice_sine = parts[..., :3]
    length = np.sqrt(np.add.reduce(twice_sine * twice_sine, axis=-1))
    angle = np.arctan2(length, parts[..., 3] - 1.0)
    found = twice_sine * (angle / np.maximum(length, TINY))[..., None]
    turned = angle > 1.0
    half = np.nonzero(turned & (length < 1e-9)) if np.count_nonzero(turned) else ()
    for k in zip(*half, strict=True):
        twice_dyad = rotation[k] + np.eye(3)
        axis = twice_dyad[:, int(np.argmax(np.diag(twice_dyad)))]
        found[k] = angle[k] * axis / np.linalg.norm(axis)
    return np.asarray(found)

"""Where the links are in the world: rotations and positions, staged on demand; with a base that moves, the base too.

Only what is asked for is made: a scene without forces at points and without gravity energy needs none of it.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lamc.mechanics.kinematics import Kinematics
from lamc.mechanism.tree import WORLD, Link
from lamc.records.mechanism import Array
from lamc.symbolic.algebra import ZERO, AxisRotation, Matrix3, Vector3, add, dot
from lamc.symbolic.scalars import Scalar

if TYPE_CHECKING:
    from lamc.mechanics.moving_base import MovingBase


class Placement:
    """World components of link frames. Rotation matrices are world from carrier or from the drawn body."""

    def __init__(self, kinematics: Kinematics, base: "MovingBase | None" = None) -> None:
        self.kinematics = kinematics
        self.base = base
        self.links = kinematics.tree.links
        self._carriers: dict[int, Matrix3] = {}
        self._origins: dict[int, Vector3] = {}

    def carrier(self, index: int) -> Matrix3:
        """World from the link's carrier frame."""
        for i in self._path(index):
            if i not in self._carriers:
                link = self.links[i]
                matrix = self._on_base(i) if link.parent == WORLD else self._carriers[link.parent]
                for turn in self.kinematics.rotations[i]:
                    matrix = _rotated(matrix, turn)
                self._carriers[i] = matrix
        return self._carriers[index]

    def origin(self, index: int) -> Vector3:
        """World position of the link's origin, m."""
        for i in self._path(index):
            if i not in self._origins:
                link = self.links[i]
                if link.parent == WORLD:
                    self._origins[i] = (
                        self.base.point(link.origin, ("arm", i))
                        if self.base
                        else self.kinematics.drawn_origin(i)
                    )
                    step = self.kinematics.offset[i]
                    if step != ZERO:
                        self._origins[i] = add(self._origins[i], rotate(self._on_base(i), step))
                else:
                    step = rotate(self.carrier(link.parent), self.kinematics.offset[i])
                    self._origins[i] = add(self._origins[link.parent], step)
        return self._origins[index]

    def point(self, index: int, local: Vector3) -> Vector3:
        """World position, m, of a point given in the link's own frame."""
        return add(self.origin(index), rotate(self.carrier(index), self.kinematics.in_carrier(index, local)))

    def attached(self, index: int, local: Vector3) -> Vector3:
        """World position, m, of a material point of the link, given by numbers as drawn in its own frame."""
        place = np.array(local, dtype=np.float64)
        arm = self.kinematics.attached(index, local, place)
        return add(self.origin(index), rotate(self.carrier(index), arm))

    def body_rotation(self, index: int) -> Matrix3:
        """World from body axes; body axes are world axes in the drawn configuration."""
        matrix = self.carrier(index)
        spin = self.kinematics.spin[index]
        if spin is not None:
            matrix = _rotated(matrix, spin)
        axes = self.kinematics.drawn_frame(index)
        rows: list[Vector3] = []
        for row in matrix:
            x, y, z = (dot(row, axes[j]) for j in range(3))
            rows.append((x, y, z))
        return (rows[0], rows[1], rows[2])

    def _on_base(self, index: int) -> Matrix3:
        """World from the frame, as drawn, of a link on the base."""
        drawn = self.kinematics.drawn_frame(index)
        return product(self.base.rotation, drawn) if self.base else drawn

    def _path(self, index: int) -> list[int]:
        path = []
        while index != WORLD:
            path.append(index)
            index = self.links[index].parent
        return path[::-1]


def _rotated(matrix: Matrix3, turn: AxisRotation) -> Matrix3:
    """matrix · R(turn)."""
    c, s = turn.cos, turn.sin

    def row(v: Vector3) -> Vector3:
        if turn.axis == "z":
            return (c * v[0] + s * v[1], c * v[1] - s * v[0], v[2])
        return (v[0], c * v[1] + s * v[2], c * v[2] - s * v[1])

    return (row(matrix[0]), row(matrix[1]), row(matrix[2]))


def product(a: Matrix3, b: Matrix3) -> Matrix3:
    """a b."""
    columns = list(zip(*b, strict=True))
    x, y, z = ((dot(row, columns[0]), dot(row, columns[1]), dot(row, columns[2])) for row in a)
    return (x, y, z)


def rotate(matrix: Matrix3, v: Vector3) -> Vector3:
    """matrix v."""
    return (dot(matrix[0], v), dot(matrix[1], v), dot(matrix[2], v))


def rotate_back(matrix: Matrix3, v: Vector3) -> Vector3:
    """matrixᵀ v."""
    columns = zip(*matrix, strict=True)
    x, y, z = (dot(column, v) for column in columns)
    return (x, y, z)


def local_point(link: Link, point: Array) -> tuple[float, float, float]:
    """A point of the body, given in the drawn configuration (m, world), in the link's own frame."""
    x, y, z = (float(v) for v in link.frame.T @ (point - link.origin))
    return (x, y, z)


def potential_of_field(
    placement: Placement, masses: Sequence[Scalar], coms: Sequence[Vector3], acceleration: Vector3
) -> Scalar:
    """-Σ m a·(centre of mass), J; zero at the world's origin."""
    result: Scalar = 0
    for index, (mass, com) in enumerate(zip(masses, coms, strict=True)):
        placement.kinematics.store.link = index
        result = result - mass * dot(acceleration, placement.point(index, com))
    return result

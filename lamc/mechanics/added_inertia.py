"""A fluid's mass that moves with a body, staged: its kinetic energy and the wrench that follows from it.

Goes in: a symmetric 6×6 matrix A, velocities and accelerations of the body. Comes out: T = ½ wᵀ A w and Kirchhoff's
equations (Lamb 1932, art. 124) with momentum p and moment of momentum l, (p, l) = A w, w = (v, ω) at one point:
force = dp/dt + ω × p, moment = dl/dt + ω × l + v × p, components in axes of the body.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from lamc.symbolic.algebra import Vector3, add, cross, dot
from lamc.symbolic.scalars import Scalar

Six = tuple[Scalar, ...]


@dataclass(frozen=True)
class AddedInertia:
    """matrix (6, 6) at a point of a body, in drawn axes of it: of (velocity of the point, angular velocity).

    arm  m, from the link's origin, in its frame; of the base from its reference, drawn axes
    """

    effect: str
    link: int  # WORLD for the base
    arm: Vector3
    matrix: tuple[Six, ...]

    def energy(self, velocity: Vector3, omega: Vector3) -> Scalar:
        """½ wᵀ A w, J; velocity of the point."""
        w = (*velocity, *omega)
        return 0.5 * dot(w, self._times(w))

    def wrench(
        self, velocity: Vector3, omega: Vector3, acceleration: Vector3, alpha: Vector3
    ) -> tuple[Vector3, Vector3]:
        """Force, N, and moment about the point, N·m, that the motion asks for; acceleration of the point in space."""
        momentum, spin = _halves(self._times((*velocity, *omega)))
        turning = cross(omega, velocity)  # components change by the acceleration less this
        within = (acceleration[0] - turning[0], acceleration[1] - turning[1], acceleration[2] - turning[2])
        force, moment = _halves(self._times((*within, *alpha)))
        return add(force, cross(omega, momentum)), add(
            add(moment, cross(omega, spin)), cross(velocity, momentum)
        )

    def projected(self, columns: Sequence[Sequence[Scalar]]) -> dict[tuple[int, int], Scalar]:
        """JᵀAJ, lower triangle, for w = J u, J given by columns."""
        moved = [self._times(column) for column in columns]
        return {(i, j): dot(columns[j], moved[i]) for i in range(len(columns)) for j in range(i + 1)}

    def _times(self, w: Sequence[Scalar]) -> Six:
        return tuple(dot(row, w) for row in self.matrix)


def _halves(values: Sequence[Scalar]) -> tuple[Vector3, Vector3]:
    a, b, c, d, e, f = values
    return (a, b, c), (d, e, f)

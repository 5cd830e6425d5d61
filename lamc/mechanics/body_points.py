"""Where points of bodies are and how they move, staged: what effects ask about.

Goes in: a placement, rates, and points by body as drawn. Comes out: world components. It records nothing.
"""

from collections.abc import Sequence

import numpy as np

from lamc.basics.checks import Array, checked_array
from lamc.basics.errors import DesignError
from lamc.mechanics.placement import Placement, local_point, rotate
from lamc.mechanism.tree import WORLD
from lamc.records.mechanism import Mechanism
from lamc.symbolic.algebra import ZERO, Matrix3, Vector3, add, cross
from lamc.symbolic.scalars import Scalar


class BodyPoints:
    """Points of bodies, given by name and in the drawn configuration, m, world axes."""

    def __init__(self, placement: Placement, u: Sequence[Scalar]) -> None:
        self.placement = placement
        self.kinematics = placement.kinematics
        self.tree = self.kinematics.tree
        self._u = list(u)
        self._bodies = {link.body.name: i for i, link in enumerate(self.tree.links)}

    @property
    def mechanism(self) -> Mechanism:
        return self.tree.mechanism

    @property
    def moving_bodies(self) -> tuple[str, ...]:
        """Names of the bodies that move: those that are not fixed, and the fixed ones where the base moves."""
        base_moves = self.placement.base is not None
        return tuple(body.name for body in self.mechanism.bodies if base_moves or not body.fixed)

    def position(self, body: str, point: Sequence[float]) -> Vector3:
        """World position, m, of a point of the body that is at `point` in the drawn configuration."""
        index, drawn = self.link_of(body), drawn_point(point)
        if index == WORLD:
            x, y, z = (float(v) for v in drawn)
            return self.placement.base.point(drawn) if self.placement.base else (x, y, z)
        local = local_point(self.tree.links[index], drawn)
        with self.kinematics.store.drawing():
            return self.placement.attached(index, local)

    def velocity(self, body: str, point: Sequence[float]) -> Vector3:
        """World velocity, m/s, of a point of the body that is at `point` in the drawn configuration."""
        index, drawn = self.link_of(body), drawn_point(point)
        base = self.placement.base
        if index == WORLD:
            if base is None:
                return ZERO
            turning = cross(base.velocity.angular, base.arm(drawn))
            return rotate(base.rotation, add(base.velocity.linear, turning))
        motion = self.kinematics.motions(self._u)[index]
        local = local_point(self.tree.links[index], drawn)
        place = np.array(local)
        with self.kinematics.store.drawing():
            arm = self.kinematics.attached(index, local, place)
            velocity = add(motion.velocity, cross(motion.omega, arm))
        if index in self.kinematics.flexible:
            velocity = add(velocity, self.kinematics.own_velocity(index, place, self._u))
        return rotate(self.placement.carrier(index), velocity)

    def rotation(self, body: str) -> Matrix3:
        """World from drawn axes of the body, by rows; of a flexible body: of its frame at the inboard hinge."""
        index = self.link_of(body)
        if index != WORLD:
            return self.placement.body_rotation(index)
        base = self.placement.base
        return base.rotation if base is not None else ((1, 0, 0), (0, 1, 0), (0, 0, 1))

    def angular_velocity(self, body: str) -> Vector3:
        """Angular velocity of the body, rad/s, world axes; of a flexible body: of its frame at the inboard hinge."""
        index, base = self.link_of(body), self.placement.base
        if index != WORLD:
            return rotate(self.placement.carrier(index), self.kinematics.motions(self._u)[index].omega)
        return rotate(base.rotation, base.velocity.angular) if base is not None else ZERO

    def check_apart(self, what: str, body_a: str, body_b: str) -> None:
        """Raises DesignError where forces between the two cancel, as `what` would act on nothing: they are one rigid
        body, or fixed, which all together are one. A flexible body may be both."""
        a, b = self.link_of(body_a), self.link_of(body_b)
        if a == b and a not in self.kinematics.flexible:
            where = f"is within body {body_a!r}" if body_a == body_b else f"joins {body_a!r} and {body_b!r}"
            why = "which is rigid" if a != WORLD or body_a == body_b else "which are both fixed"
            raise DesignError(
                f"{what} {where}, {why}, so that it acts on nothing; let it join bodies that move against each other, "
                "or leave it out"
            )

    def link_of(self, body: str) -> int:
        """Index of its link, WORLD for a fixed body. Raises DesignError with the names there are."""
        if body in self._bodies:
            return self._bodies[body]
        known = {b.name for b in self.mechanism.bodies}
        if body not in known:
            raise DesignError(f"no body is named {body!r}; the bodies are {', '.join(sorted(known))}")
        return WORLD


def drawn_point(point: Sequence[float]) -> Array:
    """Three numbers of a user as an array, or DesignError."""
    return checked_array(point, (3,), "a point that an effect names")

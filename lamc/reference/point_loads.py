"""What acts on points of bodies: springs, contacts, benders and air give pushes; here is what a push is.

In: where the points of bodies are and how fast they move. Out: forces, N, and moments, N·m, world axes. How bodies move
is the business of each cross-check, which hands in a `BodyState`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Mechanism
from lamc.reference.kinematics import Link, TreeState, cross

Array = npt.NDArray[np.float64]


class BodyState(Protocol):
    """Bodies at a state, by name."""

    def point(self, body: str, drawn: Array) -> tuple[Array, Array]:
        """World position, m, and velocity, m/s, of a point of the body that is given as drawn, (3,), m."""

    def direction(self, body: str, drawn: Array) -> Array:
        """A direction of the body's frame, (3,), in the world."""


@dataclass(frozen=True)
class Push:
    """A force (3,), N, on a point of a body, given as drawn, m, and a moment (3,), N·m, on the body's frame."""

    body: str
    point: Array
    force: Array
    moment: Array | None = None


class PointLoad(Protocol):
    """`effect` names the energy that it stores; empty: none."""

    @property
    def effect(self) -> str: ...
    def pushes(self, t: float, place: BodyState) -> list[Push]: ...
    def stored(self, t: float, place: BodyState) -> float: ...


@dataclass(frozen=True)
class PointSpring:
    """A spring between two points, each on a body (by name) and given as drawn, m."""

    bodies: tuple[str, str]
    points: tuple[Array, Array]
    stiffness: float  # N/m
    rest_length: float  # m
    damping: float  # N·s/m

    effect = "spring"

    def pushes(self, t: float, place: BodyState) -> list[Push]:
        (point_a, velocity_a), (point_b, velocity_b) = map(place.point, self.bodies, self.points)
        line = point_b - point_a
        length = float(np.linalg.norm(line))
        # A spring of no length has no direction; with a rest length that is no number, as in the C.
        direction = line / length if length > 0.0 or self.rest_length else line
        stretch_rate = float((velocity_b - velocity_a) @ direction)
        pull = self.stiffness * (length - self.rest_length) + self.damping * stretch_rate
        ends = zip(self.bodies, self.points, (1.0, -1.0), strict=True)
        return [Push(body, point, sign * pull * direction) for body, point, sign in ends]

    def stored(self, t: float, place: BodyState) -> float:
        (point_a, _), (point_b, _) = map(place.point, self.bodies, self.points)
        stretch = float(np.linalg.norm(point_b - point_a)) - self.rest_length
        return 0.5 * self.stiffness * stretch**2


def spring(mechanism: Mechanism, effect: Any) -> PointSpring:
    """Raises DesignError for a body that the mechanism does not have."""
    known = {body.name for body in mechanism.bodies}
    for name in (effect.body_a, effect.body_b):
        if name not in known:
            raise DesignError(f"the scene puts a spring on body {name!r}, which the mechanism does not have")
    return PointSpring(
        (effect.body_a, effect.body_b),
        (np.array(effect.point_a, dtype=np.float64), np.array(effect.point_b, dtype=np.float64)),
        float(effect.stiffness),
        float(effect.rest_length),
        float(effect.damping),
    )


class RigidBodyState:
    """A `BodyState` of the rigid bodies of a walk; other bodies rest."""

    def __init__(self, links: Sequence[Link], state: TreeState) -> None:
        self.index = {link.body.name: i for i, link in enumerate(links)}
        self._links, self._state = links, state

    def point(self, body: str, drawn: Array) -> tuple[Array, Array]:
        i, state = self.index.get(body), self._state
        if i is None:
            return drawn, np.zeros(3)
        arm = state.rotation[i] @ (drawn - self._links[i].body.com)
        return state.centre[i] + arm, state.velocity[i] + cross(state.spin[i], arm)

    def direction(self, body: str, drawn: Array) -> Array:
        i = self.index.get(body)
        return drawn if i is None else np.asarray(self._state.rotation[i] @ drawn)


def wrenches(
    loads: Sequence[PointLoad], t: float, links: Sequence[Link], state: TreeState
) -> tuple[Array, Array]:
    """Forces, N, and moments about the centres of mass, N·m, on the bodies of the walk; both (n, 3), world."""
    forces, moments = np.zeros((2, len(links), 3))
    place = RigidBodyState(links, state)
    for load in loads:
        for push in load.pushes(t, place):
            i = place.index.get(push.body)
            if i is not None:
                forces[i] += push.force
                moments[i] += cross(place.point(push.body, push.point)[0] - state.centre[i], push.force)
                if push.moment is not None:
                    moments[i] += push.moment
    return forces, moments

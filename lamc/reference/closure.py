"""Hinges that close loops, as numbers: the motion of the bodies in, gaps, their derivatives and the hinges' angles out.

A joint that the walk from the world does not use holds two bodies together all the same. Its two sides meet where
three components of distance and two of direction vanish; here in world axes, by the bodies' own points and spins.
Nothing is shared with the compiler's closure, which works in the frame of the loop's last common body.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.records.mechanism import Joint, Mechanism
from lamc.reference.kinematics import Array, Link, TreeState, cross, skew

ROWS = 5  # equations of one hinge


@dataclass(frozen=True)
class CutHinge:
    """A joint outside the tree: `parent` and `child` are places in the walk, -1 for the world; `across` (2, 3) are
    two directions across the axis, as drawn, so that (first, second, axis) is right-handed."""

    joint: Joint
    parent: int
    child: int
    across: Array


@dataclass(frozen=True)
class _Side:
    """One side of a hinge in the world: its point (3,), m, and directions (3, 3), rows first, second, axis, with
    their rates and the accelerations that they have without joint accelerations; spin (3,), rad/s."""

    point: Array
    point_acceleration: Array
    directions: Array
    direction_rates: Array
    direction_accelerations: Array
    spin: Array


class Closure:
    """All hinges of `mechanism` that `links` do not use, c of them. `at` gives their state."""

    def __init__(self, mechanism: Mechanism, links: Sequence[Link]) -> None:
        self.links, self.size = links, mechanism.size
        used = {link.joint.name for link in links}
        place = {link.body.name: i for i, link in enumerate(links)}
        self.hinges = tuple(
            CutHinge(j, place.get(j.parent, -1), place.get(j.child, -1), perpendicular(j.axis))
            for j in mechanism.joints
            if j.name not in used
        )
        self.names = tuple(hinge.joint.name for hinge in self.hinges)
        self.ways = [self._way(i) for i in range(len(links))]

    def at(self, state: TreeState) -> "ClosureState":
        """The hinges at the motion of the bodies."""
        sides = [(self._side(h, h.parent, state), self._side(h, h.child, state)) for h in self.hinges]
        return ClosureState(self, state, sides)

    def _way(self, index: int) -> tuple[int, ...]:
        """Places in the walk from `index`, itself first, to the world."""
        way = []
        while index >= 0:
            way.append(index)
            index = self.links[index].inner
        return tuple(way)

    def _side(self, hinge: CutHinge, place: int, state: TreeState) -> _Side:
        drawn = np.vstack([hinge.across, hinge.joint.axis])
        if place < 0:
            still, none = np.zeros(3), np.zeros((3, 3))
            return _Side(hinge.joint.point, still, drawn, none, none, still)
        rotation, spin = state.rotation[place], state.spin[place]
        turn, rotation_rate = skew(spin), skew(state.spin_rate[place])
        bend = rotation_rate + turn @ turn  # of every vector of the body, without joint accelerations
        arm = rotation @ (hinge.joint.point - self.links[place].body.com)
        directions = drawn @ rotation.T
        return _Side(
            point=state.centre[place] + arm,
            point_acceleration=state.acceleration[place] + bend @ arm,
            directions=directions,
            direction_rates=directions @ turn.T,
            direction_accelerations=directions @ bend.T,
            spin=spin,
        )


@dataclass(frozen=True)
class ClosureState:
    """The hinges of a `Closure` at one state.

    Residuals, five per hinge, m: the distance from the parent's point to the child's, and the mechanism's size times
    the sines of the child's axis against two directions across the parent's. Columns follow the order of q.
    """

    closure: Closure
    state: TreeState
    sides: Sequence[tuple[_Side, _Side]]  # parent, child

    def residual(self) -> Array:
        """φ, shape (5 c,), m."""
        rows = np.zeros((len(self.sides), ROWS))
        for row, (parent, child) in zip(rows, self.sides, strict=True):
            row[:3] = child.point - parent.point
            row[3:] = self.closure.size * (parent.directions[:2] @ child.directions[2])
        return rows.reshape(-1)

    def jacobian(self) -> Array:
        """J = dφ/dq, shape (5 c, n), m/rad: each joint on the way from the world turns what comes after it."""
        state, links = self.state, self.closure.links
        matrix = np.zeros((len(self.sides), ROWS, len(links)))
        for rows, hinge, (parent, child) in zip(matrix, self.closure.hinges, self.sides, strict=True):
            turn = self.closure.size * (parent.directions[:2] @ skew(child.directions[2]))  # x × z, by rows
            for place, side, sign in ((hinge.parent, parent, -1.0), (hinge.child, child, 1.0)):
                way = list(self.closure.ways[place]) if place >= 0 else []
                columns = [links[i].coordinate for i in way]
                axes = state.axis[way]
                rows[:3, columns] += sign * cross(axes, side.point - state.point[way]).T
                rows[3:, columns] -= sign * (
                    turn @ axes.T
                )  # d(x·z) = axis·(x × z) where x turns, else minus that
        return matrix.reshape(-1, len(links))

    def bias(self) -> Array:
        """γ of J du/dt + γ = d²φ/dt², shape (5 c,), m/s²."""
        rows = np.zeros((len(self.sides), ROWS))
        for row, (parent, child) in zip(rows, self.sides, strict=True):
            row[:3] = child.point_acceleration - parent.point_acceleration
            row[3:] = parent.direction_accelerations[:2] @ child.directions[2]
            row[3:] += 2.0 * parent.direction_rates[:2] @ child.direction_rates[2]
            row[3:] += parent.directions[:2] @ child.direction_accelerations[2]
            row[3:] *= self.closure.size
        return rows.reshape(-1)

    def angles(self) -> Array:
        """Angles of the hinges, shape (c,), rad, within ±π; child relative to parent."""
        first = [parent.directions[:2] @ child.directions[0] for parent, child in self.sides]
        return np.array([math.atan2(sine, cosine) for cosine, sine in first])

    def rates(self) -> Array:
        """Rates of the hinges, shape (c,), rad/s."""
        return np.array([c.directions[2] @ c.spin - p.directions[2] @ p.spin for p, c in self.sides])

    def moments(self, torques: Array) -> Array:
        """Moments on the bodies of the walk, shape (n, 3), N·m, world, of hinge torques (c,), N·m."""
        moments = np.zeros((len(self.closure.links), 3))
        for hinge, (parent, child), torque in zip(self.closure.hinges, self.sides, torques, strict=True):
            for place, side, sign in ((hinge.parent, parent, -1.0), (hinge.child, child, 1.0)):
                if place >= 0:
                    moments[place] += sign * torque * side.directions[2]
        return moments


def perpendicular(axis: Array) -> Array:
    """Two unit vectors across `axis` and each other, shape (2, 3); with the axis they are right-handed."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = cross(axis, helper)
    first = first / np.linalg.norm(first)
    return np.array([first, cross(axis, first)])

"""Hinges that close loops, as numbers: the motion of the bodies and the hinges' angles in, gaps and derivatives out.

A joint that the walk from the world does not use holds two bodies together all the same. Its two sides meet where
three components of distance and two of direction vanish, turned by its own coordinate; here in world axes, by the
bodies' own points and spins. Nothing is shared with the compiler's closure, which knows other cycles and no bodies.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Joint, Mechanism
from lamc.reference.kinematics import Array, Link, TreeState, cross, skew

ROWS = 6  # equations of one hinge


@dataclass(frozen=True)
class CutHinge:
    """A joint outside the tree: `coordinate` its place in q; `parent` and `child` are places in the walk, -1 for the
    world; `across` (2, 3) are two directions across the axis, as drawn, so that (first, second, axis) is right-handed.
    """

    joint: Joint
    coordinate: int
    parent: int
    child: int
    across: Array


@dataclass(frozen=True)
class _Side:
    """One side of a hinge in the world: its point (3,), m, and directions (3, 3), rows first, second, axis, with
    their rates and the accelerations that they have without joint accelerations; so has spin_rate (3,), rad/s²."""

    point: Array
    point_acceleration: Array
    directions: Array
    direction_rates: Array
    direction_accelerations: Array
    spin_rate: Array


class Closure:
    """All hinges of `mechanism` that `links` do not use, c of them. `at` gives their state.

    joints: of the mechanism, all of them, in the order of q. Raises DesignError where one is left out.
    """

    def __init__(self, mechanism: Mechanism, links: Sequence[Link], joints: Sequence[str]) -> None:
        self.links, self.size, self.count = links, mechanism.size, len(joints)
        used, slots = {link.joint.name for link in links}, {name: k for k, name in enumerate(joints)}
        place = {link.body.name: i for i, link in enumerate(links)}
        left_out = [joint.name for joint in mechanism.joints if joint.name not in slots]
        if left_out:
            raise DesignError(
                f"joint {left_out[0]!r} has no coordinate: name it in `joints`, in the order of q"
            )
        self.hinges = tuple(
            CutHinge(j, slots[j.name], place.get(j.parent, -1), place.get(j.child, -1), perpendicular(j.axis))
            for j in mechanism.joints
            if j.name not in used
        )
        self.names = tuple(hinge.joint.name for hinge in self.hinges)
        self.ways = [self._way(i) for i in range(len(links))]

    def at(self, state: TreeState, q: Array) -> "ClosureState":
        """The hinges at the motion of the bodies and angles q (n,), rad."""
        sides = [(self._side(h, h.parent, state), self._side(h, h.child, state)) for h in self.hinges]
        return ClosureState(self, state, q[[h.coordinate for h in self.hinges]], sides)

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
            spin_rate=state.spin_rate[place],
        )


@dataclass(frozen=True)
class ClosureState:
    """The hinges of a `Closure` at one state, with their coordinates `angles` (c,), rad, which count turns.

    Residuals, six per hinge, m: the distance from the parent's point to the child's; the mechanism's size times the
    sines of the child's axis against two directions across the parent's, and times the angle between the two sides
    beyond that of the coordinate, but for whole turns. Columns follow the order of q.
    """

    closure: Closure
    state: TreeState
    angles: Array
    sides: Sequence[tuple[_Side, _Side]]  # parent, child

    def residual(self) -> Array:
        """φ, shape (6 c,), m."""
        rows, size = np.zeros((len(self.sides), ROWS)), self.closure.size
        for row, (parent, child), angle in zip(rows, self.sides, self.angles, strict=True):
            row[:3] = child.point - parent.point
            row[3:5] = size * (parent.directions[:2] @ child.directions[2])
            cosine, sine = parent.directions[:2] @ child.directions[0]
            row[5] = size * math.remainder(math.atan2(sine, cosine) - angle, 2.0 * math.pi)
        return rows.reshape(-1)

    def jacobian(self) -> Array:
        """J, shape (6 c, n), m/rad, with dφ/dt = J u: each joint on the way from the world turns what comes after it.
        Of the angle where the hinge is closed, as its bias."""
        state, links, size = self.state, self.closure.links, self.closure.size
        matrix = np.zeros((len(self.sides), ROWS, self.closure.count))
        for rows, hinge, (parent, child) in zip(matrix, self.closure.hinges, self.sides, strict=True):
            turn = size * (parent.directions[:2] @ skew(child.directions[2]))  # x × z, by rows
            for place, side, sign in ((hinge.parent, parent, -1.0), (hinge.child, child, 1.0)):
                way = list(self.closure.ways[place]) if place >= 0 else []
                columns = [links[i].coordinate for i in way]
                axes = state.axis[way]
                rows[:3, columns] += sign * cross(axes, side.point - state.point[way]).T
                rows[3:5, columns] -= sign * (
                    turn @ axes.T
                )  # d(x·z) = axis·(x × z) where x turns, else minus that
                rows[5, columns] += sign * size * (axes @ child.directions[2])
            rows[5, hinge.coordinate] = -size
        return matrix.reshape(-1, self.closure.count)

    def bias(self) -> Array:
        """γ of J du/dt + γ = d²φ/dt², shape (6 c,), m/s². Of the angle: the rest of the two spins is along the axis,
        which turns with either."""
        rows = np.zeros((len(self.sides), ROWS))
        for row, (parent, child) in zip(rows, self.sides, strict=True):
            row[:3] = child.point_acceleration - parent.point_acceleration
            row[3:5] = parent.direction_accelerations[:2] @ child.directions[2]
            row[3:5] += 2.0 * parent.direction_rates[:2] @ child.direction_rates[2]
            row[3:5] += parent.directions[:2] @ child.direction_accelerations[2]
            row[5] = child.directions[2] @ (child.spin_rate - parent.spin_rate)
            row[3:] *= self.closure.size
        return rows.reshape(-1)


def perpendicular(axis: Array) -> Array:
    """Two unit vectors across `axis` and each other, shape (2, 3); with the axis they are right-handed."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = cross(axis, helper)
    first = first / np.linalg.norm(first)
    return np.array([first, cross(axis, first)])

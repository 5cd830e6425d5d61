"""Kinematics of a mechanism with loops in numbers: poses, closure along short cycles, gaps.

In: a `Tree` and angles of all its joints, those of the tree first, then the cut ones. Out: arrays in world axes. Never:
uses the frames of the tree, sympy, or compiled code, so that it stands beside the derivation and not on it.
"""

import threading
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TypeVar

import numpy as np

from lamc.basics.once import kept_with
from lamc.loops.cycles import Cycle, short_cycles
from lamc.loops.linear import DENSE, Linear
from lamc.loops.rings import Rings, rotations
from lamc.mechanism.tree import Tree
from lamc.records.mechanism import Array, Joint

RECENT = 64  # closures that are kept: a search comes back to where its last step ended
LATELY, MOST_FOUND = 4, 256  # loops of which it is known what was found lately, and how much of each
_T = TypeVar("_T")
_lately: dict[Hashable, dict[Hashable, object]] = {}
_guard = threading.Lock()  # of what is forgotten
_UNKNOWN = object()


@dataclass(frozen=True)
class Poses:
    """Where all bodies are: a point X as drawn is at rotation[i] X + shift[i]. Index WORLD (-1) is the world.

    rotation (k + 1, 3, 3); shift (k + 1, 3), m; k moving bodies, in the order of the tree's links.
    """

    rotation: Array
    shift: Array


class LoopGeometry:
    """The loops of one tree. Angles are rows Q (n,): tree joints in the order of `tree.links`, then the cut ones.

    names    of all n joints, in the order of Q
    tree_count, loops   how many joints are in the tree, and how many are cut
    size     m, of the mechanism
    """

    def __init__(self, tree: Tree) -> None:
        joints = tree.hinges
        self.tree = tree
        self._recent: dict[bytes, tuple[Array, Linear]] = {}
        self.names = tuple(joint.name for joint in joints)
        self.tree_count, self.loops = len(tree.links), len(tree.cuts)
        self.size = tree.mechanism.size
        self.point = _rows([joint.point for joint in joints])
        outward = [_outward(link.joint, link.body.name) for link in tree.links] + [1.0] * self.loops
        self.axis = _rows([s * joint.axis for s, joint in zip(outward, joints, strict=True)])
        # The body on which a joint's axis is carried: the inner one of a link, the parent's side of a cut.
        self.near = np.array(
            [link.parent for link in tree.links] + [cut.parent.link for cut in tree.cuts], dtype=int
        )

        # A large matrix is taken apart in seconds, and asked for in one place after another.
        self._linear = lru_cache(maxsize=4)(lambda packed: self.closure(np.frombuffer(packed))[1])

    @cached_property
    def drawing(self) -> Hashable:
        """All that closure depends on: loops of equal ones have equal answers, whatever their bodies weigh."""
        ends = tuple((joint.name, joint.parent, joint.child) for joint in self.tree.hinges)
        numbers = b"".join(each.tobytes() for each in (self.point, self.axis, self.near))
        order = tuple(joint.name for joint in self.tree.mechanism.joints)  # branches are numbered by it
        return self.size, ends, order, numbers

    def lately(self, question: Hashable, answer: Callable[[], _T]) -> _T:
        """What `answer` gives, which depends on the closure alone and is not changed afterwards. Of loops drawn alike
        it is known from the last time: whether a sheet folds is asked as it is read, what its loops come to as it is
        compiled, and where they lead as it starts."""
        found = _lately.get(self.drawing, {}).get(question, _UNKNOWN)
        if found is not _UNKNOWN:
            return found  # type: ignore[return-value]
        made = answer()
        with _guard:
            while len(_lately) >= LATELY and self.drawing not in _lately:
                _lately.pop(next(iter(_lately)))
            known = _lately.setdefault(self.drawing, {})
            while len(known) >= MOST_FOUND:
                known.pop(next(iter(known)))
            known[question] = made
        return made

    @cached_property
    def order(self) -> list[int]:
        """Where the mechanism's joints, in its own order, are in Q."""
        place = {name: index for index, name in enumerate(self.names)}
        return [place[joint.name] for joint in self.tree.mechanism.joints]

    @cached_property
    def cycles(self) -> tuple[Cycle, ...]:
        """The short cycles along which the loops close."""
        return short_cycles(self.tree)

    @cached_property
    def rings(self) -> Rings:
        """Their closure in numbers."""
        axes = _rows([joint.axis for joint in self.tree.hinges])
        return Rings(self.cycles, self.point, axes, self.size)

    def closure(self, angles: Array) -> tuple[Array, Linear]:
        """What is left open (6 cycles,), rad and parts of lengths, and its Jacobian by the angles."""
        key = angles.tobytes()
        found = self._recent.get(key)
        if found is None:
            residual, screws = self.rings.residual(angles)
            if len(self.names) > DENSE:
                return residual, Linear(self.rings.sparse(screws))
            if len(self._recent) >= RECENT:
                self._recent.clear()
            found = self._recent[key] = residual, Linear(self.rings.dense(screws))
        return found

    def closures(self, angles: Array) -> tuple[Array, Array]:
        """The same for rows of angles (s, n) of few joints at once: (s, 6 cycles) and (s, 6 cycles, n)."""
        residual, screws = self.rings.residual(angles)
        return residual, self.rings.dense(screws)

    def linear(self, angles: Array) -> Linear:
        """The Jacobian of the closure: it leaves free the rates with which all loops stay closed."""
        return self._linear(np.ascontiguousarray(angles).tobytes())

    def poses(self, angles: Array) -> Poses:
        """Poses of all bodies by the tree joints of `angles` (n,)."""
        rotations, shifts = self._turns(angles)
        count = self.tree_count
        rotation = np.concatenate([np.zeros((count, 3, 3)), np.eye(3)[None]])
        shift = np.zeros((count + 1, 3))
        for index in range(count):
            inner = self.near[index]
            rotation[index] = rotation[inner] @ rotations[index]
            shift[index] = rotation[inner] @ shifts[index] + shift[inner]
        return Poses(rotation, shift)

    def inertia(self, angles: Array, rates: Array) -> Array:
        """Inertia (s, s), kg·m², of all bodies for motions with given rates, rows (s, n) that hold the loops: twice the
        kinetic energy of the rates x @ rates is x·inertia·x. What effects add to bodies is left out."""
        poses = self.poses(angles)
        count, near = self.tree_count, self.near[: self.tree_count]
        axis = np.einsum("jab,jb->ja", poses.rotation[near], self.axis[:count])
        point = np.einsum("jab,jb->ja", poses.rotation[near], self.point[:count]) + poses.shift[near]
        screws = np.concatenate([axis, np.cross(point, axis)], axis=1)  # velocity of what is at the origin
        twists = np.zeros((count + 1, 6, len(rates)))
        for index in range(count):
            twists[index] = twists[near[index]] + np.outer(screws[index], rates[:, index])
        total = np.zeros((len(rates), len(rates)))
        for index, link in enumerate(self.tree.links):
            rotation, (angular, linear) = poses.rotation[index], np.split(twists[index], 2)
            com = rotation @ link.body.com + poses.shift[index]
            velocity = linear + np.cross(angular, com, axisa=0, axisc=0)
            about = rotation @ link.body.inertia @ rotation.T
            total += link.body.mass * velocity.T @ velocity + angular.T @ about @ angular
        return total

    def gaps(self, angles: Array) -> Array:
        """Gap of each cut hinge, (loops,), m: the distance between its two sides' points, or the size times the
        angle between their axes, whichever is larger."""
        poses = self.poses(angles)
        gaps = np.zeros(self.loops)
        for row, cut in enumerate(self.tree.cuts):
            sides = [cut.parent.link, cut.child.link]
            points = poses.rotation[sides] @ cut.joint.point + poses.shift[sides]
            axes = poses.rotation[sides] @ cut.joint.axis
            angle = np.arctan2(np.linalg.norm(np.cross(axes[0], axes[1])), axes[0] @ axes[1])
            gaps[row] = max(float(np.linalg.norm(points[1] - points[0])), self.size * float(angle))
        return gaps

    def _turns(self, angles: Array) -> tuple[Array, Array]:
        """Rotation (n, 3, 3) about each joint's line as drawn, and its shift (n, 3), m."""
        turned = rotations(self.axis, angles)
        return turned, self.point - np.einsum("jab,jb->ja", turned, self.point)


def geometry_of(tree: Tree) -> LoopGeometry:
    """One for each tree: what was evaluated to count its loops is there for its start."""
    return kept_with(tree, "_loop_geometry", LoopGeometry)


def _outward(joint: Joint, body: str) -> float:
    """+1 where the body farther from the world is the joint's child, -1 where it is the parent."""
    return 1.0 if joint.child == body else -1.0


def _rows(vectors: list[Array]) -> Array:
    return np.array(vectors, dtype=np.float64).reshape(len(vectors), 3)

"""Kinematics of a mechanism with loops in numbers: poses, joint screws, closure equations.

In: a `Tree` and angles of all its joints, those of the tree first, then the cut ones. Out: arrays in world axes.
Never: uses the frames of the tree, sympy, or compiled code, so that it stands beside the derivation and not on it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lamc.mechanism.tree import WORLD, Tree
from lamc.records.mechanism import Array, Joint


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
    origin   (3,), m, world: where the displacement of a body is measured
    unit     m: the length that counts as much as a radian
    """

    def __init__(self, tree: Tree, origin: Array | None = None, unit: float | None = None) -> None:
        """origin: by default the middle of the hinges. unit: by default the mechanism's size."""
        joints = [link.joint for link in tree.links] + [cut.joint for cut in tree.cuts]
        self.tree = tree
        self.names = tuple(joint.name for joint in joints)
        self.tree_count, self.loops = len(tree.links), len(tree.cuts)
        self.size = tree.mechanism.size
        self.point = _rows([joint.point for joint in joints])
        self.origin = self.point.mean(axis=0) if origin is None else np.asarray(origin, dtype=np.float64)
        self.unit = self.size if unit is None else unit
        outward = [_outward(link.joint, link.body.name) for link in tree.links] + [1.0] * self.loops
        self.axis = _rows([s * joint.axis for s, joint in zip(outward, joints, strict=True)])
        # The body on which a joint's axis is carried: the inner one of a link, the parent's side of a cut.
        self.near = np.array(
            [link.parent for link in tree.links] + [cut.parent.link for cut in tree.cuts], dtype=int
        )

    @cached_property
    def signs(self) -> Array:
        """(loops, n): +1 for joints on the way to a cut's child, -1 to its parent, 0 for both or neither; -1 for the
        cut itself. The relative twist of the child's side in the parent's is the sum of sign × rate × screw."""
        signs = np.zeros((self.loops, len(self.names)))
        for row, cut in enumerate(self.tree.cuts):
            for side, sign in ((cut.child, 1.0), (cut.parent, -1.0)):
                index = side.link
                while index != WORLD:
                    signs[row, index] += sign
                    index = self.tree.links[index].parent
            signs[row, self.tree_count + row] = -1.0
        return signs

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

    def lines(self, poses: Poses) -> tuple[Array, Array]:
        """Axes (n, 3) and points (n, 3), m, of all joints in world axes; a link turns about its axis by its angle."""
        rotation = poses.rotation[self.near]
        axes = np.einsum("jab,jb->ja", rotation, self.axis)
        points = np.einsum("jab,jb->ja", rotation, self.point) + poses.shift[self.near]
        return axes, points

    def screws(self, poses: Poses) -> Array:
        """Unit twists of all joints, (n, 6): axis, then velocity of what is at `origin`, in units per radian."""
        axes, points = self.lines(poses)
        return np.hstack([axes, np.cross(points - self.origin, axes) / self.unit])

    def jacobian(self, angles: Array) -> Array:
        """Closure matrix, (6 loops, n): its null space are the rates with which all loops stay closed."""
        return self._jacobian(self.poses(angles))

    def closure(self, angles: Array) -> tuple[Array, Array]:
        """Residual (6 loops,) and its Jacobian (6 loops, n), exact where the loops close.

        Six numbers per cut: the turn (rad) and the displacement at `origin` (units) by which the child's body is away
        from where the cut joint at its angle holds it.
        """
        poses = self.poses(angles)
        rotations, shifts = self._turns(angles)
        residual = np.zeros((self.loops, 6))
        for row, cut in enumerate(self.tree.cuts):
            index = self.tree_count + row
            held = poses.rotation[cut.parent.link] @ rotations[index]
            held_shift = poses.rotation[cut.parent.link] @ shifts[index] + poses.shift[cut.parent.link]
            error = poses.rotation[cut.child.link] @ held.T
            moved = error @ (self.origin - held_shift) + poses.shift[cut.child.link] - self.origin
            residual[row, :3] = rotation_vector(error)
            residual[row, 3:] = moved / self.unit
        return residual.ravel(), self._jacobian(poses)

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

    def _jacobian(self, poses: Poses) -> Array:
        rows = self.signs[:, None, :] * self.screws(poses).T[None, :, :]
        return rows.reshape(6 * self.loops, len(self.names))

    def _turns(self, angles: Array) -> tuple[Array, Array]:
        """Rotation (n, 3, 3) about each joint's line as drawn (Rodrigues), and its shift (n, 3), m."""
        x, y, z = self.axis.T
        zero = np.zeros_like(x)
        cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
        sine, versine = np.sin(angles), 2.0 * np.sin(0.5 * angles) ** 2
        rotations = np.eye(3) + sine[:, None, None] * cross + versine[:, None, None] * (cross @ cross)
        return rotations, self.point - np.einsum("jab,jb->ja", rotations, self.point)


def rotation_vector(rotation: Array) -> Array:
    """Axis times angle, (3,), rad, of a rotation (3, 3); exact to round-off near the identity, and to its square root
    near a half turn, where the antisymmetric part vanishes as it does for none."""
    twice_sine = np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    length = float(np.linalg.norm(twice_sine))
    angle = float(np.arctan2(length, np.trace(rotation) - 1.0))
    if length < 1e-9 and angle > 1.0:
        twice_dyad = rotation + np.eye(3)
        axis = twice_dyad[:, int(np.argmax(np.diag(twice_dyad)))]
        return np.asarray(angle * axis / np.linalg.norm(axis))
    return 0.5 * twice_sine if length < 1e-9 else twice_sine * (angle / length)


def _outward(joint: Joint, body: str) -> float:
    """+1 where the body farther from the world is the joint's child, -1 where it is the parent."""
    return 1.0 if joint.child == body else -1.0


def _rows(vectors: list[Array]) -> Array:
    return np.array(vectors, dtype=np.float64).reshape(len(vectors), 3)

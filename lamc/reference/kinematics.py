"""Where the bodies of a mechanism are and how fast they move: joint angles and rates in, world vectors out.

Plain numpy on the `Mechanism` record, with its own walk from the world outwards and rotations by Rodrigues'
formula. Joints that close loops move nothing here. Nothing is symbolic, nor shared with the compiler's planning.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from lamc.basics.errors import TopologyError
from lamc.records.mechanism import Body, Joint, Mechanism

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Link:
    """One moving body and the joint through which the walk from the world enters it.

    body        the body
    joint       the joint
    coordinate  index of the joint's angle in q
    sign        +1 where the body is the joint's child, -1 where it is the parent
    inner       index in the walk of the body on the world's side, -1 for the world
    """

    body: Body
    joint: Joint
    coordinate: int
    sign: float
    inner: int


@dataclass(frozen=True)
class TreeState:
    """Kinematics at one state; row i belongs to link i of the walk; m, rad/s, world axes.

    rotation (n, 3, 3): drawn axes to world; centre, point (hinge), spin (angular velocity), velocity (of the
    centre), spin_rate and acceleration (both with zero joint accelerations): (n, 3)
    axis (n, 3): sign times the joint's axis. The link turns by +q about it relative to the inner body, and
    the hinge torque acts on the link by +torque about it, whichever of the two is the joint's child.
    """

    rotation: Array
    centre: Array
    point: Array
    axis: Array
    spin: Array
    velocity: Array
    spin_rate: Array
    acceleration: Array


def walk(mechanism: Mechanism, joints: Sequence[str], first: Iterable[str] = ()) -> tuple[Link, ...]:
    """Moving bodies from the world outwards, least depth first, along a spanning tree. The others of `joints` close
    loops, and no body is entered through them.

    joints  order of q
    first   names of joints that come before others into the tree; else these are taken as the mechanism lists them

    Raises TopologyError for a body with no path to the world.
    """
    slots, first = {name: k for k, name in enumerate(joints)}, set(first)
    own = sorted((j for j in mechanism.joints if j.name in slots), key=lambda j: j.name not in first)
    reached = {body.name: -1 for body in mechanism.bodies if body.fixed}
    links: list[Link] = []
    waiting = _spanning(mechanism, own)
    while waiting:
        known = dict(
            reached
        )  # bodies reached in earlier rounds: one round is one step further from the world
        later = []
        for joint in waiting:
            if joint.parent not in known and joint.child not in known:
                later.append(joint)
                continue
            outward = joint.parent in known
            inner, outer = (joint.parent, joint.child) if outward else (joint.child, joint.parent)
            reached[outer] = len(links)
            sign = 1.0 if outward else -1.0
            links.append(Link(mechanism.body(outer), joint, slots[joint.name], sign, known[inner]))
        if len(later) == len(waiting):
            names = ", ".join(repr(joint.name) for joint in later)
            raise TopologyError(f"joints {names} have no path to the world; join or fix one of their bodies")
        waiting = later
    lost = [body.name for body in mechanism.bodies if body.name not in reached]
    if lost:
        raise TopologyError(f"body {lost[0]!r} has no path to the world; join it or fix it")
    return tuple(links)


def _spanning(mechanism: Mechanism, joints: Sequence[Joint]) -> list[Joint]:
    """Those that join two parts which none before them joins; fixed bodies are one part."""
    part = {body.name: -1 if body.fixed else i for i, body in enumerate(mechanism.bodies)}
    found = []
    for joint in joints:
        one, other = part[joint.parent], part[joint.child]
        if one != other:
            found.append(joint)
            part = {body: one if each == other else each for body, each in part.items()}
    return found


def motion(links: Sequence[Link], q: Array, u: Array) -> TreeState:
    """Positions, velocities and bias accelerations at angles q and rates u of all joints, both shape (n,)."""
    n = len(links)
    rotation = np.zeros((n, 3, 3))
    centre, point, axis, spin, velocity, spin_rate, acceleration = np.zeros((7, n, 3))
    for i, link in enumerate(links):
        p = link.inner
        drawn_axis = link.sign * link.joint.axis
        turn = rodrigues(drawn_axis, float(q[link.coordinate]))
        if p < 0:
            base = np.eye(3)
            point[i] = link.joint.point
            point_velocity = point_acceleration = w = dw = np.zeros(3)
        else:
            base = rotation[p]
            arm = base @ (link.joint.point - links[p].body.com)
            w, dw = spin[p], spin_rate[p]
            point[i] = centre[p] + arm
            turning = cross(w, arm)
            point_velocity = velocity[p] + turning
            point_acceleration = acceleration[p] + cross(dw, arm) + cross(w, turning)
        rotation[i] = base @ turn
        axis[i] = base @ drawn_axis
        relative = axis[i] * u[link.coordinate]
        spin[i] = w + relative
        spin_rate[i] = dw + cross(w, relative)
        arm = rotation[i] @ (link.body.com - link.joint.point)
        turning = cross(spin[i], arm)
        centre[i] = point[i] + arm
        velocity[i] = point_velocity + turning
        acceleration[i] = point_acceleration + cross(spin_rate[i], arm) + cross(spin[i], turning)
    return TreeState(rotation, centre, point, axis, spin, velocity, spin_rate, acceleration)


def rodrigues(axis: Array, angle: float) -> Array:
    """Rotation by `angle` (rad) about the unit vector `axis`, shape (3, 3): R = 1 + sin K + (1 - cos) K²."""
    K = skew(axis)
    half = np.sin(0.5 * angle)
    turn: Array = np.eye(3) + np.sin(angle) * K + 2.0 * half * half * (K @ K)  # 1 - cos without cancellation
    return turn


def skew(v: Array) -> Array:
    """The matrix K with K w = v x w."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def cross(a: Array, b: Array) -> Array:
    """a x b along the last axis. numpy's own takes ten times as long for one pair, three times for a few."""
    if a.ndim == b.ndim == 1:
        a0, a1, a2 = a.tolist()
        b0, b1, b2 = b.tolist()
        return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=-1)

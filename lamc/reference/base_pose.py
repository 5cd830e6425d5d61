"""The pose of fixed bodies that move, freely or as prescribed, as a matrix along a motion. Numbers only.

In: the effect's own numbers, a state and a time. Out: a `Curve` from drawn to world coordinates.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lamc.records.mechanism import Body
from lamc.reference.curves import Curve, still
from lamc.reference.jets import jet
from lamc.reference.kinematics import Array, rodrigues, skew


def base_pose(effect: Any, fixed: Sequence[Body], q: Array, u: Array, t: float) -> Curve:
    """`effect`: None where the base rests. Of a floating base q ends in position and quaternion, u in velocity, world
    axes, and angular velocity, axes of the base; the position is that of all fixed bodies' centre of mass."""
    count = len(u)
    if effect is None:
        return still(np.eye(4), count)
    if effect.name == "free_base":
        centre = np.average([body.com for body in fixed], axis=0, weights=[body.mass for body in fixed])
        return _floating(q, u) @ still(_placed(np.eye(3), -centre), count)
    axis, point = np.array(effect.axis) / np.linalg.norm(effect.axis), np.array(effect.point)
    shift, angle = [jet(x, t) for x in effect.displacement], jet(effect.angle, t)
    spin, rotated = skew(axis), rodrigues(axis, angle.value)
    first = angle.first * spin @ rotated
    second = angle.second * spin @ rotated + angle.first * spin @ first
    moved = Curve(
        _placed(rotated, point + [x.value for x in shift], 1.0),
        _placed(first, np.array([x.first for x in shift]), 0.0),
        _placed(second, np.array([x.second for x in shift]), 0.0),
        np.zeros((count, 4, 4)),
    )
    return moved @ still(_placed(np.eye(3), -point), count)


def _floating(q: Array, u: Array) -> Curve:
    """Rotation of a unit quaternion (w, x, y, z) by the product q v q*."""
    w, x, y, z = q[-4:] / np.linalg.norm(q[-4:])
    left = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])
    right = np.array([[w, x, y, z], [-x, w, -z, y], [-y, z, w, -x], [-z, -y, x, w]])
    rotation = (left @ right)[1:, 1:]
    spin, none = skew(u[-3:]), np.zeros(3)
    partials = np.zeros((len(u), 4, 4))
    for k, unit in enumerate(np.eye(3)):
        partials[len(u) - 6 + k, :3, 3] = unit
        partials[len(u) - 3 + k, :3, :3] = rotation @ skew(unit)
    return Curve(
        _placed(rotation, q[-7:-4]),
        _placed(rotation @ spin, u[-6:-3], 0.0),
        _placed(rotation @ spin @ spin, none, 0.0),
        partials,
    )


def _placed(rotation: Array, position: Array, last: float = 1.0) -> Array:
    matrix = np.zeros((4, 4))
    matrix[:3, :3], matrix[:3, 3], matrix[3, 3] = rotation, position, last
    return matrix

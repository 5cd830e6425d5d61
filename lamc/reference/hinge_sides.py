"""The two sides of a hinge against each other: poses in, slides, twists and angle out, with their derivatives.

Written for hinges that close loops, rigid ones and those that only stiffness holds. The child's frame is seen from the
parent's: slides along the parent's axes, and turns about x, then y, then z.
"""

import math
from dataclasses import dataclass

import numpy as np

from lamc.reference.curves import Curve
from lamc.reference.kinematics import Array


@dataclass(frozen=True)
class Sides:
    """amounts (6,): twist_x, twist_y, angle, rad, and slide_x, slide_y, slide_z, m; their rates; partials (n, 6) of the
    rates; gap: position and direction that a rigid hinge keeps at nought, as a `Curve` of (5,) with directions times
    the size, m; of the angle of such a hinge the second derivative for unchanging rates, rad/s²."""

    amounts: Array
    rates: Array
    partials: Array
    gap: Curve
    angle_second: float


def apart(parent: Curve, child: Curve, axes: Array, point: Array, size: float) -> Sides:
    """parent, child: poses; axes (3, 3): columns x, y, z of the hinge, and a point of it, m, both as drawn."""
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = axes, point
    a, b = parent.times(frame), child.times(frame)
    rotated = a.block(0, 3).transposed() @ b.block(0, 3)
    moved = a.block(0, 3).transposed() @ (b - a).block(3, 4)
    R = rotated.value
    twist_x = math.atan2(-R[1, 2], R[2, 2])
    twist_y = math.atan2(R[0, 2], math.hypot(R[1, 2], R[2, 2]))
    angle = math.atan2(-R[0, 1], R[0, 0])
    # Angular velocity in the parent's axes is the sum of three turns about axes that the ones before have moved.
    about = np.column_stack([[1.0, 0.0, 0.0], [0.0, math.cos(twist_x), math.sin(twist_x)], R[:, 2]])
    rotations = np.linalg.solve(
        about, np.array([_spin(rotated.first @ R.T), *(_spin(p @ R.T) for p in rotated.partials)]).T
    )
    slides = moved.value[:, 0]
    partials = np.concatenate([rotations[:, 1:].T, moved.partials[:, :, 0]], axis=1)
    amounts = np.array([twist_x, twist_y, angle, *slides])
    rates = np.concatenate([rotations[:, 0], moved.first[:, 0]])
    gap = Curve(
        *(
            np.concatenate([shift[..., :, 0], size * tilt[..., :2, 2]], axis=-1)
            for shift, tilt in (
                (moved.value, rotated.value),
                (moved.first, rotated.first),
                (moved.second, rotated.second),
                (moved.partials, rotated.partials),
            )
        )
    )
    # Ṙ Ṙᵀ is symmetric; the rest of the turning is about z, which stands still in the parent.
    turning = rotated.second @ R.T
    return Sides(amounts, rates, partials, gap, 0.5 * float(turning[1, 0] - turning[0, 1]))


def _spin(W: Array) -> list[float]:
    """The vector of a skew matrix."""
    return [W[2, 1], W[0, 2], W[1, 0]]

"""Angles of hinges that yield and close a loop, from where their two sides are.

In: a simulator, a state. Out: coordinates (nq,). Such an angle has no rate of its own: a run integrates it, to count
turns; at a position that was not run to, it follows from the poses.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from lamc.run.model import Motion
from lamc.run.request import Array

if TYPE_CHECKING:
    from lamc.run.simulator import Simulator


def true_angles(simulator: "Simulator", motion: Motion, row: Array) -> Array:
    """Coordinates (nq,) of a state (1, nq + nu), with these angles as the poses have them, within half a turn."""
    model = motion.model
    q = row[0, : len(model.coordinates)].copy()
    names = [c.name for c in model.coordinates]
    held = [b for b in simulator._arrangement.bushings if b.cut.joint.name in names[len(model.joints) :]]
    if not held:
        return q
    poses = motion.poses(np.zeros(1), row)[0]
    turned = {name: pose[3:].reshape(3, 3) for name, pose in zip(model.bodies, poses, strict=True)}
    for bushing in held:
        joint, axes = bushing.cut.joint, bushing.hinge.axes
        parent, child = (turned.get(body, np.eye(3)) for body in (joint.parent, joint.child))
        r = (parent @ axes).T @ child @ axes
        k = names.index(joint.name)
        q[k] += math.remainder(math.atan2(-r[0, 1], r[0, 0]) - q[k], 2.0 * math.pi)
    return q

"""Frames of hinges, in the drawn configuration: an axis, a point of it and a normal for each.

The z axis of a link's frame lies along its own hinge. Hinge lines of one plate are coplanar, so with x along the plate
normal every fold is a constant turn about x followed by the hinge's own turn about z, and the origin, slid along the
hinge to where the two lines meet, leaves one offset component. A hinge that is not coplanar with its parent's takes one
more constant turn about z.
"""

import numpy as np

from lamc.mechanism.rotations import ROUND_OFF
from lamc.mechanism.spanning import Step
from lamc.mechanism.tree import WORLD
from lamc.records.mechanism import Array, Mechanism

# An origin is slid along its hinge at most this many mechanism sizes: nearly parallel lines meet far away, and a
# long lever would cost digits (errors grow with the square of the offset).
MAX_SLIDE = 3.0


def hinge_axes(mechanism: Mechanism, steps: list[Step]) -> tuple[list[Array], list[int]]:
    """Internal hinge axes and signs: link i turns about axes[i] by signs[i]·q.

    The joint angle is child relative to parent; a hinge entered from its child's side turns the other way. Where
    two parallel hinges are drawn in opposite directions the internal axis follows the parent's, at no cost: signs
    are free in the store.
    """
    axes: list[Array] = []
    signs: list[int] = []
    for step in steps:
        outward = step.joint.child == step.body
        axis, sign = (step.joint.axis if outward else -step.joint.axis), 1
        if step.parent != WORLD:
            reference = axes[step.parent]
            if np.linalg.norm(cross(reference, axis)) < 10 * ROUND_OFF:
                sign = 1 if reference @ axis > 0 else -1
                axis = reference
        axes.append(axis)
        signs.append(sign)
    return axes, signs


def hinge_origins(mechanism: Mechanism, steps: list[Step], axes: list[Array]) -> list[Array]:
    """A point on each hinge line, slid to where it leaves the fewest offset components."""
    reach = MAX_SLIDE * mechanism.size
    origins: list[Array] = []
    for index, step in enumerate(steps):
        point, z = step.joint.point, axes[index]
        if step.parent == WORLD:
            origins.append(point)
            continue
        base, zp = origins[step.parent], axes[step.parent]
        across = cross(zp, z)
        sine2 = float(across @ across)
        between = point - base
        nearest = -float(between @ z)  # for parallel lines: perpendicular to both
        foot = float(cross(between, zp) @ across) / sine2 if sine2 > ROUND_OFF else nearest
        slide = foot if abs(foot) <= reach else nearest  # the foot of the common perpendicular, if it is near
        origins.append(point + slide * z)
    return origins


def hinge_normals(
    mechanism: Mechanism,
    steps: list[Step],
    children: list[list[int]],
    axes: list[Array],
    origins: list[Array],
) -> list[Array]:
    """The x axis of each link's frame: normal to the plane of its own and its first child's hinge."""
    normals: list[Array] = []
    for index, step in enumerate(steps):
        z = axes[index]
        across = np.zeros(3)
        if children[index]:
            child = children[index][0]
            across = cross(z, axes[child])
            if np.linalg.norm(across) < 1e-6:  # parallel: normal to the plane of the two lines
                across = cross(z, origins[child] - origins[index]) / mechanism.size
        else:
            across = cross(z, mechanism.body(step.body).com - origins[index]) / mechanism.size
        previous = normals[step.parent] if step.parent != WORLD else None
        if np.linalg.norm(across) < 1e-9:
            across = perpendicular(z, previous)
        across = across - (across @ z) * z
        across = across / np.linalg.norm(across)
        if _points_back(across, previous):
            across = -across
        normals.append(across)
    return normals


def cross(a: Array, b: Array) -> Array:
    """a × b of two vectors, to the bit as np.cross has it, which takes ten times as long for the sake of stacks."""
    a0, a1, a2 = a.tolist()
    b0, b1, b2 = b.tolist()
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])


def _points_back(normal: Array, previous: Array | None) -> bool:
    """The one of two opposite normals that is wanted: near the parent's, else near the first axis it leans to."""
    if previous is not None and abs(normal @ previous) > 1e-6:
        return bool(normal @ previous < 0)
    leaning = [abs(round(each * 1e9)) for each in normal.tolist()]
    return bool(normal[leaning.index(max(leaning))] < 0)


def perpendicular(z: Array, previous: Array | None) -> Array:
    """Some direction perpendicular to z: the parent's normal if that serves, else a world axis."""
    candidates = [previous] if previous is not None else []
    candidates += [np.array(e) for e in ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))]
    for candidate in candidates:
        rest = candidate - (candidate @ z) * z
        if np.linalg.norm(rest) > 1e-3:
            return rest
    raise AssertionError("two perpendicular axes cannot both be parallel to z")

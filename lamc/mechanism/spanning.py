"""The spanning tree of least depth, by geometry alone: the order and the names of what is given do not matter.

In: a mechanism. Out: `Step`s, one tree edge each, parents before children. Never: looks at effects or frames.
"""

from dataclasses import dataclass

from lamc.mechanism.tree import WORLD
from lamc.records.mechanism import Joint, Mechanism


@dataclass(frozen=True)
class Step:
    """One tree edge before frames are chosen."""

    joint: Joint
    body: str
    parent: int


def geometric_key(joint: Joint, size: float) -> tuple[tuple[int, ...], str]:
    """Sort key by place and direction to nine digits, so that the order of the input does not matter; the name breaks
    ties. Python's numbers: numpy's take five times as long for so few."""
    place = tuple(round(each / size * 1e9) for each in joint.point.tolist())
    return (*place, *(round(each * 1e9) for each in joint.axis.tolist())), joint.name


def least_depth(mechanism: Mechanism) -> dict[str, Joint]:
    """Breadth-first from the world: body name → the joint that carries it."""
    size = mechanism.size
    joints = sorted(mechanism.joints, key=lambda j: geometric_key(j, size))
    fixed = {b.name for b in mechanism.bodies if b.fixed}
    at: dict[str, list[Joint]] = {b.name: [] for b in mechanism.bodies}
    for joint in joints:
        at[joint.parent].append(joint)
        at[joint.child].append(joint)
    carrier: dict[str, Joint] = {}
    level = sorted(fixed)
    while level:
        following: list[str] = []
        reachable = sorted(
            {j.name: j for body in level for j in at[body]}.values(),
            key=lambda j: geometric_key(j, size),
        )
        for joint in reachable:
            for near, far in ((joint.parent, joint.child), (joint.child, joint.parent)):
                if near in level and far not in fixed and far not in carrier:
                    carrier[far] = joint
                    following.append(far)
        level = following
    return carrier


def depth_first(mechanism: Mechanism, carrier: dict[str, Joint]) -> list[Step]:
    """Limb after limb: parents before children, siblings by geometry."""
    size = mechanism.size
    outward: dict[str, list[tuple[Joint, str]]] = {}
    for body, joint in carrier.items():
        near = joint.parent if joint.child == body else joint.child
        outward.setdefault(near, []).append((joint, body))
    for limbs in outward.values():
        limbs.sort(key=lambda limb: geometric_key(limb[0], size), reverse=True)
    roots = [limb for b in mechanism.bodies if b.fixed for limb in outward.get(b.name, [])]
    roots.sort(key=lambda limb: geometric_key(limb[0], size), reverse=True)
    steps: list[Step] = []
    stack = [(joint, body, WORLD) for joint, body in roots]
    while stack:
        joint, body, parent = stack.pop()
        index = len(steps)
        steps.append(Step(joint, body, parent))
        stack.extend((j, b, index) for j, b in outward.get(body, []))
    return steps

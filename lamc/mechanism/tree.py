"""`plan`: the spanning tree of least depth, and a frame for every hinge (section 4.2 of the paper, eq. 5–6).

Goes in: a Mechanism. Comes out: a Tree: links in an order in which parents precede children, each with the
frame of its hinge in the drawn configuration and the constant rotation from the parent's frame. It never looks
at effects, and it holds numbers only.

Frames. The z axis of a link's frame lies along its own hinge. Hinge lines of one plate are coplanar, so with x
along the plate normal every fold is a constant turn about x followed by the hinge's own turn about z, and the
origin, slid along the hinge to where the two lines meet, leaves one offset component. A hinge that is not
coplanar with its parent's takes one more constant turn about z.
"""

from dataclasses import dataclass

import numpy as np

from lamc.mechanism.turns import ROUND_OFF, constant_turns, snap
from lamc.records.mechanism import FREE_LIMITS, Array, Body, Joint, Mechanism
from lamc.records.network import loose_ends

# An origin is slid along its hinge at most this many mechanism sizes: nearly parallel lines meet far away, and a
# long lever would cost digits (errors grow with the square of the offset).
MAX_SLIDE = 3.0
WORLD = -1


@dataclass(frozen=True, eq=False)
class Link:
    """A moving body with the hinge that carries it.

    The hinge's own turn is about z by angle_sign·q + angle_offset, after the constant turns `twist` (about z) and
    `fold` (about x), each as (cosine, sine), from the parent's frame. A `parallel` link has neither.
    """

    body: Body
    joint: Joint
    parent: int  # index of the parent link, WORLD for a hinge on a fixed body
    angle_sign: int
    angle_offset: float  # rad
    twist: tuple[float, float]
    fold: tuple[float, float]
    parallel: bool
    origin: Array  # (3,), m, world, drawn configuration: a point on the hinge line
    frame: Array  # (3, 3), world from link frame, drawn configuration; columns are the axes
    offset: Array  # (3,), m, origin from the parent's origin, in the parent's frame
    com: Array  # (3,), m, from the origin, in the link's frame
    inertia: Array  # (3, 3), kg·m², about the centre of mass, in the link's frame


@dataclass(frozen=True, eq=False)
class Side:
    """One side of a cut hinge: a point on its line and its directions, in the frame of the link that holds it."""

    link: int  # index of the link, WORLD for a fixed body; then the frame is the world's
    point: Array  # (3,), m
    axes: Array  # (3, 3): columns x, y across the hinge and z along it, equal on both sides as drawn


@dataclass(frozen=True, eq=False)
class Cut:
    """A hinge that closes a loop: it is no edge of the tree, and its two sides are held together by equations."""

    joint: Joint
    parent: Side
    child: Side


@dataclass(frozen=True, eq=False)
class Tree:
    """Links, parents before children; q[i] is the angle of links[i].joint. `cuts` close its loops."""

    mechanism: Mechanism
    links: tuple[Link, ...]
    cuts: tuple[Cut, ...] = ()

    @property
    def joint_names(self) -> tuple[str, ...]:
        return tuple(link.joint.name for link in self.links)

    @property
    def depth(self) -> int:
        """Number of hinges on the longest way to the world."""
        depths: list[int] = []
        for link in self.links:
            depths.append(1 if link.parent == WORLD else depths[link.parent] + 1)
        return max(depths, default=0)

    def children(self, index: int) -> list[int]:
        return [i for i, link in enumerate(self.links) if link.parent == index]


@dataclass(frozen=True)
class _Step:
    """One tree edge before frames are chosen."""

    joint: Joint
    body: str
    parent: int


def plan(mechanism: Mechanism) -> Tree:
    """The tree of `mechanism`.

    Raises TopologyError if a body has no path to the world or a hinge joins two fixed bodies.
    """
    fault = next(loose_ends(mechanism.bodies, mechanism.joints), None)
    if fault is not None:
        raise fault.error
    carrier = _least_depth(mechanism)
    steps = _depth_first(mechanism, carrier)
    children: list[list[int]] = [[] for _ in steps]
    for index, step in enumerate(steps):
        if step.parent != WORLD:
            children[step.parent].append(index)
    axes, signs = _axes(mechanism, steps)
    origins = _origins(mechanism, steps, axes)
    normals = _normals(mechanism, steps, children, axes, origins)
    links: list[Link] = []
    for index, step in enumerate(steps):
        links.append(_link(mechanism, step, links, axes[index], normals[index], origins[index], signs[index]))
    return Tree(mechanism, tuple(links), _cuts(mechanism, carrier, links))


def _cuts(mechanism: Mechanism, carrier: dict[str, Joint], links: list[Link]) -> tuple[Cut, ...]:
    """The joints that are not in the tree, by geometry."""
    used = {joint.name for joint in carrier.values()}
    place = {link.body.name: index for index, link in enumerate(links)}
    size = mechanism.size
    closing = sorted(
        (j for j in mechanism.joints if j.name not in used), key=lambda j: geometric_key(j, size)
    )
    cuts: list[Cut] = []
    for joint in closing:
        x = _perpendicular(joint.axis, None)
        x = x / np.linalg.norm(x)
        axes = np.column_stack([x, _cross(joint.axis, x), joint.axis])
        sides = [
            _side(place.get(name, WORLD), joint.point, axes, links, size)
            for name in (joint.parent, joint.child)
        ]
        cuts.append(Cut(joint, sides[0], sides[1]))
    return tuple(cuts)


def _side(index: int, point: Array, axes: Array, links: list[Link], size: float) -> Side:
    if index == WORLD:
        return Side(WORLD, point, axes)
    link = links[index]
    return Side(index, snap(link.frame.T @ (point - link.origin), size), snap(link.frame.T @ axes, 1.0))


def geometric_key(joint: Joint, size: float) -> tuple[tuple[float, ...], str]:
    """Sort key by place and direction, so that the order of the input does not matter; the name breaks ties."""
    place = np.round(joint.point / size, 9) + 0.0
    direction = np.round(joint.axis, 9) + 0.0
    return (tuple(map(float, (*place, *direction))), joint.name)


def _least_depth(mechanism: Mechanism) -> dict[str, Joint]:
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
            key=lambda j: (not _reads_its_angle(j), geometric_key(j, size)),
        )
        for joint in reachable:
            for near, far in ((joint.parent, joint.child), (joint.child, joint.parent)):
                if near in level and far not in fixed and far not in carrier:
                    carrier[far] = joint
                    following.append(far)
        level = following
    return carrier


def _reads_its_angle(joint: Joint) -> bool:
    """True for a spring or limits. Such a joint had better be no cut: a coordinate counts turns, the angle of a cut
    joint jumps at ±180°. Of joints that lead to a body at the same depth, one of these carries it."""
    lower, upper = joint.limits
    free_lower, free_upper = FREE_LIMITS
    return bool(joint.stiffness or joint.rest_angle or lower > free_lower or upper < free_upper)


def _depth_first(mechanism: Mechanism, carrier: dict[str, Joint]) -> list[_Step]:
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
    steps: list[_Step] = []
    stack = [(joint, body, WORLD) for joint, body in roots]
    while stack:
        joint, body, parent = stack.pop()
        index = len(steps)
        steps.append(_Step(joint, body, parent))
        stack.extend((j, b, index) for j, b in outward.get(body, []))
    return steps


def _axes(mechanism: Mechanism, steps: list[_Step]) -> tuple[list[Array], list[int]]:
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
            if np.linalg.norm(_cross(reference, axis)) < 10 * ROUND_OFF:
                sign = 1 if reference @ axis > 0 else -1
                axis = reference
        axes.append(axis)
        signs.append(sign)
    return axes, signs


def _origins(mechanism: Mechanism, steps: list[_Step], axes: list[Array]) -> list[Array]:
    """A point on each hinge line, slid to where it leaves the fewest offset components."""
    reach = MAX_SLIDE * mechanism.size
    origins: list[Array] = []
    for index, step in enumerate(steps):
        point, z = step.joint.point, axes[index]
        if step.parent == WORLD:
            origins.append(point)
            continue
        base, zp = origins[step.parent], axes[step.parent]
        across = _cross(zp, z)
        sine2 = float(across @ across)
        between = point - base
        nearest = -float(between @ z)  # for parallel lines: perpendicular to both
        foot = float(_cross(between, zp) @ across) / sine2 if sine2 > ROUND_OFF else nearest
        slide = foot if abs(foot) <= reach else nearest  # the foot of the common perpendicular, if it is near
        origins.append(point + slide * z)
    return origins


def _normals(
    mechanism: Mechanism,
    steps: list[_Step],
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
            across = _cross(z, axes[child])
            if np.linalg.norm(across) < 1e-6:  # parallel: normal to the plane of the two lines
                across = _cross(z, origins[child] - origins[index]) / mechanism.size
        else:
            across = _cross(z, mechanism.body(step.body).com - origins[index]) / mechanism.size
        previous = normals[step.parent] if step.parent != WORLD else None
        if np.linalg.norm(across) < 1e-9:
            across = _perpendicular(z, previous)
        across = across - (across @ z) * z
        across = across / np.linalg.norm(across)
        if _points_back(across, previous):
            across = -across
        normals.append(across)
    return normals


def _cross(a: Array, b: Array) -> Array:
    """a × b of two vectors, to the bit as np.cross has it, which takes ten times as long for the sake of stacks."""
    a0, a1, a2 = a.tolist()
    b0, b1, b2 = b.tolist()
    return np.array([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0])


def _points_back(normal: Array, previous: Array | None) -> bool:
    """The one of two opposite normals that is wanted: near the parent's, else near the first axis it leans to."""
    if previous is not None and abs(normal @ previous) > 1e-6:
        return bool(normal @ previous < 0)
    lean = int(np.argmax(np.abs(np.round(normal, 9))))
    return bool(normal[lean] < 0)


def _perpendicular(z: Array, previous: Array | None) -> Array:
    """Some direction perpendicular to z: the parent's normal if that serves, else a world axis."""
    candidates = [previous] if previous is not None else []
    candidates += [np.array(e) for e in ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))]
    for candidate in candidates:
        rest = candidate - (candidate @ z) * z
        if np.linalg.norm(rest) > 1e-3:
            return rest
    raise AssertionError("two perpendicular axes cannot both be parallel to z")


def _link(
    mechanism: Mechanism, step: _Step, links: list[Link], z: Array, x: Array, origin: Array, sign: int
) -> Link:
    frame = np.column_stack([x, _cross(z, x), z])
    size = mechanism.size
    twist, fold, angle, parallel, offset = (1.0, 0.0), (1.0, 0.0), 0.0, False, np.zeros(3)
    if step.parent != WORLD:
        parent = links[step.parent]
        offset = snap(parent.frame.T @ (origin - parent.origin), size)
        twist, fold, angle, parallel = constant_turns(parent.frame.T @ frame)
    body = mechanism.body(step.body)
    return Link(
        body=body,
        joint=step.joint,
        parent=step.parent,
        angle_sign=sign,
        angle_offset=angle,
        twist=twist,
        fold=fold,
        parallel=parallel,
        origin=origin,
        frame=frame,
        offset=offset,
        com=snap(frame.T @ (body.com - origin), size),
        inertia=snap(frame.T @ body.inertia @ frame, float(np.abs(body.inertia).max())),
    )

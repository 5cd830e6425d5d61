"""`plan`: the spanning tree of least depth, and a frame for every hinge (section 4.2 of the paper, eq. 5–6).

Goes in: a Mechanism. Comes out: a Tree. It never looks at effects.
"""

import numpy as np

from lamc.mechanism.hinge_frames import cross, hinge_axes, hinge_normals, hinge_origins, perpendicular
from lamc.mechanism.rotations import constant_rotations, snap
from lamc.mechanism.spanning import Step, depth_first, geometric_key, least_depth
from lamc.mechanism.tree import WORLD, Cut, Link, Side, Tree
from lamc.records.mechanism import Array, Joint, Mechanism
from lamc.records.network import loose_ends

_latest: list[Tree] = []  # the last one: five stages of one compile ask for the same


def plan(mechanism: Mechanism) -> Tree:
    """The tree of `mechanism`.

    Raises TopologyError if a body has no path to the world or a hinge joins two fixed bodies.
    """
    for tree in _latest:
        if tree.mechanism is mechanism:
            return tree
    tree = _planned(mechanism)
    _latest[:] = [tree]
    return tree


def _planned(mechanism: Mechanism) -> Tree:
    fault = next(loose_ends(mechanism.bodies, mechanism.joints), None)
    if fault is not None:
        raise fault.error
    carrier = least_depth(mechanism)
    steps = depth_first(mechanism, carrier)
    children: list[list[int]] = [[] for _ in steps]
    for index, step in enumerate(steps):
        if step.parent != WORLD:
            children[step.parent].append(index)
    axes, signs = hinge_axes(mechanism, steps)
    origins = hinge_origins(mechanism, steps, axes)
    normals = hinge_normals(mechanism, steps, children, axes, origins)
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
        x = perpendicular(joint.axis, None)
        x = x / np.linalg.norm(x)
        axes = np.column_stack([x, cross(joint.axis, x), joint.axis])
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


def _link(
    mechanism: Mechanism, step: Step, links: list[Link], z: Array, x: Array, origin: Array, sign: int
) -> Link:
    frame = np.column_stack([x, cross(z, x), z])
    size = mechanism.size
    twist, fold, angle, parallel, offset = (1.0, 0.0), (1.0, 0.0), 0.0, False, np.zeros(3)
    if step.parent != WORLD:
        parent = links[step.parent]
        offset = snap(parent.frame.T @ (origin - parent.origin), size)
        twist, fold, angle, parallel = constant_rotations(parent.frame.T @ frame)
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

"""The joint screws of loops as textbooks have them: six rows for each cut hinge, by all hinges on the way around."""

import numpy as np

from lamc.loops.geometry import LoopGeometry
from lamc.mechanism.tree import WORLD, Tree
from lamc.records.mechanism import Array


def joint_screws(tree: Tree, angles: Array, origin: Array, unit: float) -> Array:
    """The matrix (6 cuts, n) of [axis; (point - origin) × axis / unit] at angles (n,); unit and origin in m."""
    poses, joints = LoopGeometry(tree).poses(angles), tree.hinges
    carriers = [*(link.parent for link in tree.links), *(cut.parent.link for cut in tree.cuts)]
    rotation, shift = poses.rotation[carriers], poses.shift[carriers]
    axes = np.einsum("jab,jb->ja", rotation, [joint.axis for joint in joints])
    points = np.einsum("jab,jb->ja", rotation, [joint.point for joint in joints]) + shift
    screws = np.hstack([axes, np.cross(points - origin, axes) / unit])
    rows = []
    for k, cut in enumerate(tree.cuts):
        signs = np.zeros(len(joints))
        for side, sign in ((cut.child, 1.0), (cut.parent, -1.0)):
            index = side.link
            while index != WORLD:
                link = tree.links[index]
                signs[index] += sign * (1.0 if link.joint.child == link.body.name else -1.0)
                index = link.parent
        signs[len(tree.links) + k] = -1.0
        rows.append((signs[:, None] * screws).T)
    return np.vstack(rows)

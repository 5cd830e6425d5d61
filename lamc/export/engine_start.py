"""The start of a scene for engines: angles and rates of all joints, those that close loops too.

In: a tree and a scene. Out: angles, rad, and rates, rad/s, by joint. Never: compiles or integrates.
"""

import math
from collections.abc import Mapping

import numpy as np

from lamc.loops.geometry import LoopGeometry
from lamc.loops.starts import Starter, loops_of
from lamc.mechanism.tree import Tree
from lamc.records.mechanism import Array
from lamc.records.scene import Scene
from lamc.run.arguments import check_names
from lamc.run.start_checks import refuse_branch


def joint_start(tree: Tree, scene: Scene) -> tuple[Mapping[str, float], Mapping[str, float]]:
    """Angles and rates by joint: the scene's; those left out follow from closure, or are zero.

    Raises RequestError for a joint that is not there, DesignError where no position or motion is as asked for.
    """
    geometry = LoopGeometry(tree)
    check_names(scene, geometry.names)
    if not tree.cuts:
        refuse_branch(scene)
        angles = {name: scene.angles.get(name, 0.0) for name in geometry.names}
        return angles, {name: scene.rates.get(name, 0.0) for name in geometry.names}
    state = Starter(geometry, loops_of(tree, scene)).state(scene)
    count = geometry.tree_count
    q = np.concatenate([state[:count], _cut_angles(geometry, state[:count])])
    jacobian = geometry.jacobian(q)
    cut_rates = np.linalg.lstsq(jacobian[:, count:], -jacobian[:, :count] @ state[count:], rcond=None)[0]
    u = np.concatenate([state[count:], cut_rates])
    return (
        dict(zip(geometry.names, q.tolist(), strict=True)),
        dict(zip(geometry.names, u.tolist(), strict=True)),
    )


def _cut_angles(geometry: LoopGeometry, tree_angles: Array) -> Array:
    """Turns of the cut joints, (loops,), rad, within ±π: child relative to parent about the joint's axis."""
    poses = geometry.poses(np.concatenate([tree_angles, np.zeros(geometry.loops)]))
    angles = []
    for cut in geometry.tree.cuts:
        turn = poses.rotation[cut.parent.link].T @ poses.rotation[cut.child.link]
        x, y, z = cut.joint.axis
        sine = 0.5 * (
            x * (turn[2, 1] - turn[1, 2]) + y * (turn[0, 2] - turn[2, 0]) + z * (turn[1, 0] - turn[0, 1])
        )
        angles.append(math.atan2(sine, 0.5 * (float(np.trace(turn)) - 1.0)))
    return np.array(angles)

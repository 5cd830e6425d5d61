"""The start of a scene for engines: angles and rates of all joints.

In: a tree and a scene. Out: angles, rad, and rates, rad/s, by joint. Never: compiles or integrates.
"""

from collections.abc import Mapping

from lamc.basics.errors import DesignError
from lamc.loops.at_start import loops_of
from lamc.loops.geometry import LoopGeometry
from lamc.loops.starts import Starter
from lamc.loops.texts import listed
from lamc.mechanism.tree import Tree
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
    starter = Starter(geometry, loops_of(tree, scene))
    if starter.is_undecided(scene):
        raise DesignError(
            "the start is singular and at rest, and another engine does not choose a branch by what loads do: it has "
            f"{listed(starter.branches(scene))}; choose one with branch=1 (-1 for the other way) in the scene"
        )
    state = starter.state(scene).tolist()
    count = len(geometry.names)
    return (
        dict(zip(geometry.names, state[:count], strict=True)),
        dict(zip(geometry.names, state[count:], strict=True)),
    )

"""Starts of loops that hinges hold by their stiffness: as near to closed as rigid hinges could be.

In: the tree with all its cuts, and a scene. Out: angles and rates of the tree's joints, angles of all. A loop that does
not fit is left open by its misfit, which the flexures take up; without this, angles given for some joints would tear
it. Never: looks for equilibrium; a start is where the scene puts it.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from lamc.basics.errors import DesignError
from lamc.loops.geometry import geometry_of
from lamc.loops.misfit import rounded_up
from lamc.loops.rank import count_loops
from lamc.loops.starts import Starter
from lamc.mechanism.tree import Tree
from lamc.records.mechanism import Array
from lamc.records.scene import Scene


def yielding_start(tree: Tree, scene: Scene) -> tuple[Array, Mapping[str, float]]:
    """State (2 k,) of the k tree joints, rad and rad/s: what the scene gives, and the others as rigid loops had them;
    and the angles of all joints of these.

    Where rigid loops could not have what is given, the others are zero, and the flexures take up all of it.
    """
    count = len(tree.links)
    if not any(scene.angles.values()) and not any(scene.rates.values()):
        return np.zeros(2 * count), {}
    starter = _rigid(tree, scene)
    try:
        angles = starter.position(scene.angles)
    except DesignError:
        given = starter.given(scene.angles)[:count], starter.given(scene.rates)[:count]
        return np.concatenate(given), scene.angles
    try:
        rates = starter.rates(angles, scene.rates)
    except DesignError:
        rates = starter.given(scene.rates)
    named = dict(zip(starter.geometry.names, angles.tolist(), strict=True))
    return np.concatenate([angles[:count], rates[:count]]), named


def rigid_scene(tree: Tree, held: Tree, scene: Scene) -> Scene:
    """`scene` by the joints of `held`, which is `tree` without the cuts that bushings hold: where it gives angles or
    rates of these, the others are such that rigid loops have them too.

    Raises DesignError where rigid loops have no such position or motion.
    """
    names = {joint.name for joint in held.hinges}
    if names >= {*scene.angles, *scene.rates}:
        return scene
    starter = _rigid(tree, scene)
    angles = starter.position(scene.angles)
    rates = starter.rates(angles, scene.rates)

    def kept(values: Array) -> Mapping[str, float]:
        return {n: float(v) for n, v in zip(starter.geometry.names, values, strict=True) if n in names}

    return replace(scene, angles=kept(angles), rates=kept(rates) if any(scene.rates.values()) else {})


def _rigid(tree: Tree, scene: Scene) -> Starter:
    """Starts of the loops if nothing yielded; a misfit, which flexures take up, is accepted."""
    found = count_loops(tree, scene.closure_tolerance)
    if found.misfit is not None and not found.accepted_gap:
        found = count_loops(tree, rounded_up(found.misfit.gap))
    return Starter(geometry_of(tree), found)

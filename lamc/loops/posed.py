"""Where the bodies of a mechanism are at given angles of its hinges; those left out follow from closure, or are zero.

In: a `Mechanism`, angles by name. Out: poses in world axes. Never: rates, loads, compiled code.
"""

from collections.abc import Mapping

import numpy as np

from lamc.basics.checks import did_you_mean
from lamc.basics.errors import DesignError
from lamc.basics.threads import on_one_thread
from lamc.loops.at_start import loops_of
from lamc.loops.geometry import geometry_of
from lamc.loops.starts import Starter
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Array, Mechanism
from lamc.records.scene import Scene


@on_one_thread
def posed(mechanism: Mechanism, angles: Mapping[str, float]) -> tuple[Array, Array]:
    """Centres of mass (bodies, 3), m, and rotations (bodies, 3, 3) of all bodies, in the mechanism's order.

    angles  rad, by joint; numbers with units where a `Scene` takes them. Raises DesignError for names that are not
    there, and where loops do not close at these angles.
    """
    scene = Scene(angles=angles)
    tree = plan(mechanism)
    geometry = geometry_of(tree)
    unknown = next((name for name in scene.angles if name not in geometry.names), None)
    if unknown is not None:
        raise DesignError(f"no joint is named {unknown[:40]!r}; {did_you_mean(unknown, geometry.names)}")
    if tree.cuts:
        q = Starter(geometry, loops_of(tree, scene)).position(scene.angles)
    else:
        q = np.array([scene.angles.get(name, 0.0) for name in geometry.names])
    links = {link.body.name: k for k, link in enumerate(tree.links)}
    places = [links.get(body.name, -1) for body in mechanism.bodies]
    found = geometry.poses(q)
    rotation, shift = found.rotation[places], found.shift[places]
    coms = np.array([body.com for body in mechanism.bodies])
    return np.einsum("nij,nj->ni", rotation, coms) + shift, rotation

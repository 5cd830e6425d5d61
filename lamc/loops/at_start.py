"""What loops come to where a run is: at the start of a scene, on the branch that it takes.

In: a `Tree` and a `Scene`. Out: a `LoopCount`. Never: looks at loads, which choose a branch where the scene does not;
the count then has the rank of each.
"""

from dataclasses import replace

import numpy as np

from lamc.basics.errors import DesignError
from lamc.basics.threads import on_one_thread
from lamc.loops.branches import Branch, find_branches
from lamc.loops.geometry import LoopGeometry, geometry_of
from lamc.loops.misfit import Misfit
from lamc.loops.rank import Found, LoopCount, accepted_by_default, check_freedom, count_at
from lamc.loops.starts import Starter
from lamc.loops.tangents import NEARLY
from lamc.mechanism.tree import Tree
from lamc.records.mechanism import Array
from lamc.records.scene import Scene

CLOSED = LoopCount(0, 0, 0, 0)  # what is taken as read before loops are counted


def _nearly_closed(gap: float) -> LoopCount:
    """The same of loops that fit badly, up to a gap, m."""
    return LoopCount(0, 0, 0, 0, misfit=Misfit(0, 0.0, ""), tolerance=gap, cutoff=NEARLY.weak / 4)


@on_one_thread
def loops_of(tree: Tree, scene: Scene) -> LoopCount:
    """What the loops of `tree` come to where `scene` starts. Raises DesignError where nothing can move."""
    if not tree.cuts:
        return LoopCount(0, 0, 0, len(tree.links))
    if not any(scene.angles.values()) and not any(scene.rates.values()) and scene.branch is None:
        count = _as_drawn(tree, scene.closure_tolerance)
        check_freedom(count)
        return count
    geometry = geometry_of(tree)
    drawn = np.zeros(len(geometry.names))
    angles: Array | None = drawn
    exact: Array | None = None
    if any(scene.angles.values()):
        allowed = scene.closure_tolerance
        allowed = accepted_by_default(geometry.size) if allowed is None else allowed
        exact = _position(geometry, scene, CLOSED)
        angles = exact if exact is not None else _position(geometry, scene, _nearly_closed(allowed))
    count = count_at(geometry, drawn if angles is None else angles, scene.closure_tolerance)
    if angles is None and count.accepted_gap > 0.0:
        angles = _position(geometry, scene, count)
        if angles is not None:
            count = count_at(geometry, angles, scene.closure_tolerance)
    check_freedom(count)
    if exact is not None and not count.accepted_gap:
        count = replace(
            count, start=Found(tuple(sorted(scene.angles.items())), geometry.names, tuple(exact.tolist()))
        )
    if scene.branch is not None:
        return count.on_branch(scene.branch)
    if len(set(count.branch_ranks)) > 1 and angles is not None and any(scene.rates.values()):
        return _along(geometry, angles, scene, count)
    return count


def _as_drawn(tree: Tree, tolerance: float | None) -> LoopCount:
    geometry = geometry_of(tree)
    drawn = np.zeros(len(geometry.names))
    return geometry.lately(("count", tolerance), lambda: count_at(geometry, drawn, tolerance))


@on_one_thread
def drawn_loops(tree: Tree, tolerance: float | None = None) -> tuple[LoopCount, tuple[Branch, ...]]:
    """What the loops of `tree` come to, and the branches that part at the drawn position, if it is singular."""
    if not tree.cuts:
        return LoopCount(0, 0, 0, len(tree.links)), ()
    geometry = geometry_of(tree)
    drawn = np.zeros(len(geometry.names))
    count = count_at(geometry, drawn, tolerance)
    return count, find_branches(geometry, drawn, count.fit) if count.branch_ranks else ()


def _position(geometry: LoopGeometry, scene: Scene, count: LoopCount) -> Array | None:
    """The closed position (n,) of the scene's angles; None where there is none."""
    try:
        return Starter(geometry, count).position(scene.angles)
    except DesignError:
        return None


def _along(geometry: LoopGeometry, angles: Array, scene: Scene, count: LoopCount) -> LoopCount:
    """The count along the rates of a scene; that of all branches where they are on none."""
    try:
        rates = Starter(geometry, count).state(scene)[len(angles) :]
    except DesignError:
        return count
    found = count_at(geometry, angles, scene.closure_tolerance, rates)
    return replace(found, start=count.start) if found.freedoms else count

"""What the loops of a mechanism come to in a scene: how many of their equations are independent where a run starts.

In: a mechanism, its arrangement, a scene. Out: a `LoopCount`, from the cache where it was counted before. Starts of one
rank have one count, that of the design's own, so that other angles compile nothing anew.
"""

from dataclasses import replace

from lamc.basics.errors import DesignError
from lamc.codegen.cache import Cache
from lamc.loops.at_start import loops_of
from lamc.loops.kept import kept_loops
from lamc.loops.rank import LoopCount, count_loops
from lamc.loops.surveys import LARGE
from lamc.loops.yielding import rigid_scene
from lamc.mechanics.arrangement import Arrangement
from lamc.mechanism.plan import plan
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.arguments import check_names
from lamc.run.input_digest import loops_digest


def loops_of_scene(
    mechanism: Mechanism,
    arrangement: Arrangement,
    effects: tuple[Effect, ...],
    scene: Scene,
    cache: Cache,
    common: bytes | None,
) -> LoopCount:
    """What the loops come to that no bushing holds. Where hinges or bodies yield, rigid loops may leave no freedom."""
    known = (*arrangement.tree.joint_names, *(joint.name for joint in mechanism.joints))
    check_names(scene, tuple(dict.fromkeys(known)))

    def count() -> LoopCount:
        if arrangement.compliant or arrangement.flexible:
            return count_loops(arrangement.tree, scene.closure_tolerance)
        full, held = plan(mechanism), arrangement.tree
        found = loops_of(held, rigid_scene(full, held, scene))
        # Equations are written alike for all starts of one rank, as for the design's own, so that other angles compile
        # nothing anew. Not with a misfit: what equations that are not taken leave open is least where they are chosen.
        own = replace(scene, angles=mechanism.scene.angles if mechanism.scene else {}, rates={}, branch=None)
        if scene.angles == own.angles or found.accepted_gap or len(mechanism.joints) > LARGE:
            return found
        alias = None if common is None else loops_digest(mechanism, effects, own, common=common)
        try:
            usual = kept_loops(alias, cache, lambda: loops_of(held, rigid_scene(full, held, own)))
        except DesignError:
            return found
        return replace(found, position=usual.position) if usual.rank == found.rank else found

    alias = None if common is None else loops_digest(mechanism, effects, scene, common=common)
    return kept_loops(alias, cache, count)

"""Where a simulator starts: what its loops come to, the ways out of a singular position, the state at t = 0.

In: a mechanism, a scene, the compiled model. Out: counts of loops, branches, states. Never: integrates.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lamc.basics.once import lazy
from lamc.basics.places import located_at
from lamc.loops.at_start import loops_of
from lamc.loops.branches import Branch
from lamc.loops.geometry import geometry_of
from lamc.loops.rank import LoopCount
from lamc.loops.starts import Starter
from lamc.loops.yielding import rigid_scene, yielding_start
from lamc.mechanics.arrangement import Arrangement
from lamc.mechanics.arranging import arrange
from lamc.mechanism.plan import plan
from lamc.records.effect import Effect, overrides
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.arguments import drawn_start
from lamc.run.ending import gap_text
from lamc.run.evaluations import Evaluations
from lamc.run.model import Model
from lamc.run.pushes import lead_of, push_of
from lamc.run.request import Array
from lamc.run.start_checks import check_start, refuse_branch


class Starting(Evaluations):
    """The part of a `Simulator` that finds where it starts.

    mechanism, scene  what it was made from
    effects           the effects that act, in order
    """

    def __init__(
        self,
        model: Model,
        mechanism: Mechanism,
        scene: Scene,
        effects: Sequence[Effect],
        loops: LoopCount | None,
    ) -> None:
        super().__init__(model)
        self.mechanism = mechanism
        self.scene = scene
        self.effects = tuple(effects)
        self._loops = loops

    @lazy
    def loops(self) -> LoopCount:
        """Loops, equations, rank, redundancy, degrees of freedom and misfit."""
        return self._loops or loops_of(self._arrangement.tree, self._rigid_scene)

    @lazy
    def branches(self) -> tuple[Branch, ...]:
        """The ways out of a singular start, such as a flat one, as `Scene.branch` numbers them; empty where the start
        is regular. Raises DesignError where no position has the scene's angles."""
        return self._starter.branches(self._rigid_scene) if self._model.cuts else ()

    @lazy
    def pushed_branch(self) -> int | None:
        """The number of the branch that a singular start at rest takes, as loads do most work on it; None where the
        start is regular, or the scene says its way."""
        return self._pushed(self._rigid_scene) if self._model.cuts else None

    def loops_taken(self) -> tuple[LoopCount, int | None]:
        """What the loops come to on the branch that the start takes, and its number; None where none part."""
        known = len(self.loops.branch_ranks)
        number = (self.scene.branch or self.pushed_branch) if self._model.cuts and known else None
        if number is None or not known < abs(number) <= len(self.branches):
            return self.loops.on_branch(number or 0), number
        return self.loops.of_rank(self._starter.rank_on(self._rigid_scene, number)), number

    @lazy
    def start(self) -> Array:
        """Initial state (nq + nu,): the scene's angles and rates; those left out follow from closure, or are zero.
        What effects add to the coordinates starts as they say. Out of a singular position at rest, such as a flat one,
        it is a thousandth of a radian along the scene's branch, or `pushed_branch`; of more than 60 joints, up to 0.05
        rad, until no equation of the loops is round-off.

        Raises DesignError where they cannot be had.
        """
        start = self.start_of(self.scene)
        start.flags.writeable = False
        with located_at(self.scene.places):
            check_start(self.effects, self.mechanism, self._default_motion, start)
        return start

    def start_of(self, scene: Scene) -> Array:
        """As `start`, of a scene that differs from this one in angles and rates; no effect is shown it."""
        near = scene.angles
        if self._model.cuts:
            own = scene is self.scene
            rigid = self._rigid_scene if own else self._rigid(scene)
            branch = rigid.branch or (self.pushed_branch if own else self._pushed(rigid))
            start = self._starter.state(replace(rigid, branch=branch))
        else:
            with located_at(scene.places):
                refuse_branch(scene)
            if len(self.joints) < len(self.mechanism.joints):
                start, near = yielding_start(plan(self.mechanism), scene)
            else:
                start = drawn_start(scene, self.joints)
        if len(self.coordinates) > len(self.joints):
            q, u = np.split(start, 2)
            start = np.concatenate(self._arrangement.start(q.tolist(), u.tolist(), near))
        return start

    def _pushed(self, rigid: Scene) -> int | None:
        """As `pushed_branch`, of a scene by the joints that no bushing holds."""
        if self._loops is not None and self._loops.pushed is not None:
            # Equations of this branch's rank say nothing of the others; where the start has that rank it is regular.
            return self._loops.pushed if self._starter.is_undecided(rigid) else None
        return self._starter.pushed_branch(rigid, push_of(self._default_motion, self._arrangement))

    def _is_elsewhere(self) -> bool:
        """Whether the start is none that the mechanism moves to from the drawing."""
        return bool(self._model.cuts) and self._starter.is_elsewhere(self._rigid_scene)

    def _gap_at(self, angles: Array) -> str:
        """How far loops are open at angles (n,), rad, of the joints, in words."""
        geometry, known = geometry_of(self._arrangement.tree), dict(zip(self.joints, angles, strict=True))
        return gap_text(geometry, self.loops, np.array([known.get(name, 0.0) for name in geometry.names]))

    @lazy
    def _rigid_scene(self) -> Scene:
        """The scene by the joints that no bushing holds: where it gives angles or rates of others, theirs are such that
        those are had."""
        return self._rigid(self.scene)

    def _rigid(self, scene: Scene) -> Scene:
        return rigid_scene(plan(self.mechanism), self._arrangement.tree, scene)

    @lazy
    def _starter(self) -> Starter:
        lead = lead_of(self._default_motion, self._arrangement)
        return Starter(geometry_of(self._arrangement.tree), self.loops, lead)

    @property
    def _rings(self) -> list[list[str]]:
        """Names of the joints around each short cycle of the loops."""
        geometry = geometry_of(self._arrangement.tree)
        return [[geometry.names[joint] for joint in cycle.joints] for cycle in geometry.cycles]

    def _bending(self) -> tuple[str, ...]:
        """Names of the bodies that bend."""
        if not any(overrides(effect, "arrange") for effect in self.effects):
            return ()
        return tuple(each.body for each in self._arrangement.flexible)

    @lazy
    def _arrangement(self) -> Arrangement:
        return arrange(plan(self.mechanism), self.effects)

"""A mechanism in its scene on its way to a simulator: what each stage makes of it, made when it is asked for, once.

In: mechanism, scene, options. Out: effects, loops, survey, equations, program and C. Never: compiles.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lamc.basics.once import lazy
from lamc.basics.times import Times
from lamc.codegen.cache import Cache
from lamc.codegen.options import CompileOptions
from lamc.codegen.toolchain import Compiler, find_compiler
from lamc.loops.rank import LoopCount
from lamc.mechanics.arrangement import Arrangement
from lamc.mechanics.arranging import arrange
from lamc.mechanics.survey import Survey, can_survey, survey_design
from lamc.mechanism.plan import plan
from lamc.pipeline.stages import branch_sources, effects_of, equations_of, sources_of
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.run.extended import PLAIN, Extras
from lamc.run.input_digest import common_digest
from lamc.run.scene_loops import loops_of_scene

if TYPE_CHECKING:
    from lamc.codegen.emit import SourceTree
    from lamc.mechanics.equations import Equations
    from lamc.symbolic.program import Program


@dataclass(frozen=True, eq=False)
class Job:
    """What is compiled, and how.

    times   of the stages, as they are made
    branch  what the loops come to on the branch that the start takes; None: what they come to at the start
    before  the same job before its branch was known, whose equations serve
    """

    mechanism: Mechanism
    scene: Scene
    options: CompileOptions
    times: Times
    cache: Cache
    branch: LoopCount | None = None
    before: "Job | None" = None

    def on_branch(self, loops: LoopCount) -> "Job":
        """The same job where loops have the rank of a branch. Where loops yield, equations count them: new ones."""
        before = None if self.arrangement.yields else self
        return Job(self.mechanism, self.scene, self.options, self.times, self.cache, loops, before)

    @lazy
    def effects(self) -> tuple[Effect, ...]:
        return effects_of(self.mechanism, self.scene)

    @lazy
    def arrangement(self) -> Arrangement:
        return arrange(plan(self.mechanism), self.effects)

    @lazy
    def common(self) -> bytes | None:
        """Digest of what all that the cache keeps of this design follows from; None where it keeps nothing of one."""
        return None if self.cache.passing else common_digest(self.mechanism, self.effects)

    @lazy
    def loops(self) -> LoopCount | None:
        """What the mechanism's loops come to; None: it has none."""
        mechanism = self.mechanism
        if self.branch is not None or len(mechanism.joints) <= sum(not b.fixed for b in mechanism.bodies):
            return self.branch
        with self.times.stage("plan"):
            return loops_of_scene(
                mechanism, self.arrangement, self.effects, self.scene, self.cache, self.common
            )

    @lazy
    def compiler(self) -> Compiler:
        compiler, flags = self.options.compiler, self.options.flags
        return self.cache.once(("compiler", compiler, flags), lambda: find_compiler(compiler, flags=flags))

    @lazy
    def equations(self) -> "Equations":
        if self.before is not None and self.loops is not None:
            return self.before.equations.on_branch(self.loops)
        return equations_of(self.mechanism, self.effects, self.times, self.loops, self.scene.inputs)

    @lazy
    def survey(self) -> Survey | None:
        """The numbers of the design apart from its structure; None where they cannot be told from it."""
        arrangement, loops = self.arrangement, self.loops
        with self.times.stage("numbers"):
            if not can_survey(arrangement):
                return None
            return survey_design(arrangement, self.effects, loops, self.scene.inputs)

    def sources(self, extras: Extras) -> "tuple[Program, SourceTree]":
        """The program, and its C without what `extras` puts beside it."""
        return self._plain if extras == PLAIN else self._lowered(extras)

    @lazy
    def _plain(self) -> "tuple[Program, SourceTree]":
        if self.before is None:
            return self._lowered(PLAIN)
        known = self.before.sources(PLAIN)
        return branch_sources(known, self.equations, self.times, precision=self.options.precision)

    def _lowered(self, extras: Extras) -> "tuple[Program, SourceTree]":
        return sources_of(
            self.equations,
            self.times,
            energy_balance=extras.energy_balance,
            columns=extras.columns,
            pullbacks=extras.pullbacks,
            precision=self.options.precision,
        )

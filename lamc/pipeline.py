"""The compiler on one page: each stage takes the previous stage's record.

load → split → plan → survey → derive → lower → emit → build. The survey tells a design's numbers from its structure:
where the cache has the structure, they go to its code, and nothing after it is done. Between two calls nothing is
remembered but the cache, which keeps at hand what the designs of one study have in common, the code that is loaded from
it, and the last mechanism's tree, which follows from it alone.
"""

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from lamc.basics.checks import shown
from lamc.basics.errors import BuildError, DesignError
from lamc.basics.once import remembered
from lamc.basics.places import located_at
from lamc.basics.times import Observer, Times
from lamc.codegen.cache import Cache, cache_root
from lamc.codegen.module import Module
from lamc.codegen.options import CompileOptions
from lamc.codegen.toolchain import find_compiler, find_machine_compiler
from lamc.design.split import split
from lamc.effects.registry import choose
from lamc.loops.rank import LoopCount
from lamc.loops.work import check_work
from lamc.mechanics.arrangement import Arrangement
from lamc.mechanics.arranging import arrange
from lamc.mechanics.survey import Survey, can_survey, survey_design
from lamc.mechanics.tangents import Columns
from lamc.mechanism.plan import plan
from lamc.records.design import Design
from lamc.records.effect import Effect
from lamc.records.inputs import NO_INPUTS, Input
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.records.scene_values import with_values
from lamc.run.input_digest import common_digest, input_digest
from lamc.run.kept_programs import (
    PLAIN,
    Extras,
    KeptDesign,
    design_of_structure,
    keep_design,
    keep_opened,
    keep_structure,
    kept_design,
    numbers_of,
    opened_entry,
    structure_alias,
)
from lamc.run.model import DesignNumbers
from lamc.run.remaking import Recipe
from lamc.run.scene_loops import loops_of_scene
from lamc.run.scene_numbers import scene_numbers, scene_program
from lamc.run.simulator import Simulator
from lamc.symbolic.staging import DrawnKey

if TYPE_CHECKING:
    from lamc.codegen.emit import SourceTree
    from lamc.mechanics.equations import Equations
    from lamc.symbolic.program import Program

logger = logging.getLogger("lamc")


def effects_of(mechanism: Mechanism, scene: Scene) -> tuple[Effect, ...]:
    """The effects that act, in the order of their names."""
    return tuple(choice.effect for choice in choose(mechanism, scene) if choice.effect is not None)


def equations_of(
    mechanism: Mechanism,
    effects: tuple[Effect, ...],
    times: Times | None = None,
    loops: LoopCount | None = None,
    inputs: Mapping[str, Input] = NO_INPUTS,
) -> "Equations":
    """plan and derive. loops: what the mechanism's loops come to; None: counted here. inputs: of the scene."""
    from lamc.mechanics.derive import derive

    times = times or Times()
    with times.stage("plan"):
        tree = plan(mechanism)
    with times.stage("derive"):
        return derive(tree, effects, loops, inputs)


def sources_of(
    equations: "Equations",
    times: Times | None = None,
    *,
    energy_balance: bool = False,
    columns: Columns | None = None,
    pullbacks: bool = False,
    precision: str = "double",
) -> "tuple[Program, SourceTree]":
    """lower and emit. energy_balance: with the power of every effect; columns: with derivatives by these; pullbacks:
    with those of weighted sums; precision: "double" or "float"."""
    from lamc.codegen.emit import emit
    from lamc.mechanics.lower import lower

    times = times or Times()
    with times.stage("lower"):
        program = lower(equations, energy_balance=energy_balance, columns=columns, pullbacks=pullbacks)
    with times.stage("emit"):
        return program, emit(program, precision)


def branch_sources(
    before: "tuple[Program, SourceTree]", equations: "Equations", times: Times, *, precision: str
) -> "tuple[Program, SourceTree]":
    """emit, of equations whose loops have another rank than those that the program `before` was lowered from."""
    from lamc.codegen.emit import emit
    from lamc.mechanics.lower import on_branch

    with times.stage("emit"):
        program, tree = before
        taken = on_branch(program, equations)
        return taken, emit(taken, precision, like=tree)


@dataclass(frozen=True)
class _Stages:
    """Equations and sources of a scene, made when they are asked for."""

    equations: "Callable[[], Equations]"
    sources: "Callable[[Extras], tuple[Program, SourceTree]]"


def compile(  # noqa: A001  the public name is lamc.compile
    design: Design | Mechanism,
    scene: Scene | None = None,
    options: CompileOptions | None = None,
    times: Times | None = None,
    cache: Cache | None = None,
    progress: Observer | bool | None = None,
) -> Simulator:
    """A simulator of `design` in `scene` (None: the design's own, else what the design asks for).

    cache: where compiled modules are kept; None: the user's own.
    progress: called with the name of each stage as it begins; True: a bar, in notebooks too.

    Raises DesignError and its leaves for what cannot be simulated, BuildError without a working compiler or cache.
    """
    _check_arguments(design, scene, options, times)
    options = options or CompileOptions()
    times = times or Times()
    with times.told(progress):
        if isinstance(design, Design):
            with times.stage("split"):
                mechanism = split(design)
        else:
            mechanism = design
        scene = scene or mechanism.scene or Scene()
        with located_at(scene.places):
            made = _compiled(
                with_values(mechanism, scene), scene, options, times, cache or Cache(cache_root())
            )
    logger.info("%r is compiled%s", made, ", from the cache" if times.from_cache else "")
    return made


def _compiled(
    mechanism: Mechanism,
    scene: Scene,
    options: CompileOptions,
    times: Times,
    cache: Cache,
    loops: LoopCount | None = None,
    before: "_Stages | None" = None,
) -> Simulator:
    """loops: what the mechanism's loops come to; None: counted, if it has any. before: the stages of the same scene
    with loops of another rank."""
    check_work(mechanism, large=options.large)
    effects = effects_of(mechanism, scene)

    @remembered
    def arranged() -> Arrangement:
        return arrange(plan(mechanism), effects)

    common = None if cache.passing else common_digest(mechanism, effects)
    if loops is None and len(mechanism.joints) > sum(not body.fixed for body in mechanism.bodies):
        with times.stage("plan"):
            loops = loops_of_scene(mechanism, arranged(), effects, scene, cache, common)
    compiler = cache.once(
        ("compiler", options.compiler, options.flags),
        lambda: find_compiler(options.compiler, flags=options.flags),
    )

    @remembered
    def equations() -> "Equations":
        if before is not None and loops is not None:
            return before.equations().on_branch(loops)
        return equations_of(mechanism, effects, times, loops, scene.inputs)

    @remembered
    def sources(extras: Extras) -> "tuple[Program, SourceTree]":
        if before is not None and extras == PLAIN:
            return branch_sources(before.sources(extras), equations(), times, precision=options.precision)
        return sources_of(
            equations(),
            times,
            energy_balance=extras.energy_balance,
            columns=extras.columns,
            pullbacks=extras.pullbacks,
            precision=options.precision,
        )

    @remembered
    def surveyed() -> Survey | None:
        arrangement = arranged()
        with times.stage("numbers"):
            return (
                survey_design(arrangement, effects, loops, scene.inputs) if can_survey(arrangement) else None
            )

    def module(extras: Extras = PLAIN) -> tuple[Module, DesignNumbers]:
        return keyed_module(extras)[:2]

    def keyed_module(extras: Extras) -> tuple[Module, DesignNumbers, tuple[DrawnKey, ...]]:
        """The module, and the numbers of the design; with columns, the keys of those of the drawing too."""
        made, numbers, keys = as_drawn(extras)
        return made, scene_numbers(made, numbers, scene.parameters), keys

    def as_drawn(extras: Extras) -> tuple[Module, DesignNumbers, tuple[DrawnKey, ...]]:
        maker = find_machine_compiler(options) if extras.is_of_machine else compiler
        alias = None  # of this design alone
        if common is not None:
            inputs = (mechanism, effects, loops, maker, options, scene.inputs)
            alias = input_digest(*inputs, extras=str(extras), common=common)
        with times.stage("load from cache"):
            known = kept_design(cache, alias) if alias else None
            found = opened_entry(cache, known.entry) if known else None
        if known is not None and found is not None:
            times.from_cache = True
            return found, known.numbers, known.keys
        survey = surveyed()
        if survey is not None:
            of = structure_alias(survey.structure, maker, options, extras)
            with times.stage("load from cache"):
                drawn = design_of_structure(cache, of, survey)
            if drawn is not None:
                times.from_cache = True
                if alias:
                    keep_design(cache, alias, drawn[1])
                return drawn[0], drawn[1].numbers, drawn[1].keys
        program, tree = sources(extras)
        from lamc.codegen.build import build

        if extras.lanes:
            from lamc.codegen.emit_lanes import emit_lanes

            tree = emit_lanes(program, tree, options.precision)
        if extras.columns is not None:
            from lamc.codegen.emit_tangents import emit_tangents

            tree = emit_tangents(program, tree)
        if extras.pullbacks:
            from lamc.codegen.emit_pullbacks import emit_pullbacks

            tree = emit_pullbacks(program, tree)
        with times.stage("compile"):
            entry, made, times.from_cache = build(tree, program.structure, maker, options, cache)
        keep_opened(cache, entry, made)
        known = KeptDesign(entry, numbers_of(program), tuple(number.key for number in program.geometry))
        if alias:
            keep_design(cache, alias, known)
        if survey is not None:
            keep_structure(cache, of, entry, program)
        return made, known.numbers, known.keys

    simulator = Simulator(
        mechanism,
        scene,
        effects,
        equations,
        lambda: scene_program(sources(PLAIN)[0], scene.parameters),
        *module(),
        loops,
        lambda: module(Extras(energy_balance=True)),
        Recipe(mechanism, scene, options, cache),
        lambda: module(Extras(lanes=True)),
        lambda columns: keyed_module(Extras(columns=columns)),
        lambda: keyed_module(Extras(pullbacks=True)),
    )
    stages = (
        None if arranged().yields else _Stages(equations, sources)
    )  # where loops yield, equations count them
    return _on_branch(simulator, mechanism, options, times, cache, stages)


def _on_branch(
    simulator: Simulator,
    mechanism: Mechanism,
    options: CompileOptions,
    times: Times,
    cache: Cache,
    stages: "_Stages | None",
) -> Simulator:
    """The simulator with the rank of the branch that its start takes, where branches of other ranks part. Loads choose
    the branch, and they are known only now; the equations are the same."""
    if not simulator.cut_joints or simulator.loops.pushed is not None:
        return simulator
    try:
        taken, number = simulator.loops_taken()
    except DesignError:  # of a start that cannot be had, which is told when it is asked for
        return simulator
    if taken.rank == simulator.loops.rank:
        return simulator
    chosen = replace(taken, branch_ranks=(taken.rank,), pushed=number)
    return _compiled(mechanism, simulator.scene, options, times, cache, chosen, stages)


def _check_arguments(design: object, scene: object, options: object, times: object) -> None:
    """Raises DesignError or BuildError for an argument of another type."""
    if isinstance(design, str | Path):
        raise DesignError(
            f"{str(design)!r} is no design but a path; write lamc.compile(lamc.load({str(design)!r}))"
        )
    if not isinstance(design, Design | Mechanism):
        raise DesignError(
            f"the design is {shown(design)}; it must be a Design or a Mechanism, as lamc.load gives"
        )
    if not isinstance(scene, Scene | None):
        raise DesignError(f"the scene is {shown(scene)}; it must be a Scene, or None")
    if not isinstance(options, CompileOptions | None):
        raise BuildError(f"options is {shown(options)}; it must be CompileOptions(…), or None")
    if not isinstance(times, Times | None):
        raise BuildError(f"times is {shown(times)}; it must be a Times, or None")

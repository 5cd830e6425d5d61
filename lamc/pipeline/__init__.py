"""The compiler on one page: each stage takes the previous stage's record.

load → split → plan → survey → derive → lower → emit → build. The survey tells a design's numbers from its structure:
where the cache has the structure, they go to its code, and nothing after it is done. Between two calls nothing is
remembered but the cache, which keeps at hand what the designs of one study have in common, the code that is loaded from
it, and the last mechanism's tree, which follows from it alone.
"""

import logging
from dataclasses import replace
from functools import partial
from pathlib import Path

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import BuildError, DesignError, warn
from lamc.basics.places import located_at
from lamc.basics.times import Observer, Times
from lamc.codegen.cache import Cache, cache_root
from lamc.codegen.options import CompileOptions
from lamc.design.split import split
from lamc.loops.work import check_work, long_work
from lamc.pipeline.job import Job
from lamc.pipeline.modules import module_of
from lamc.pipeline.stages import effects_of, equations_of, sources_of
from lamc.records.design import Design
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.records.scene_values import with_values
from lamc.run.extended import PLAIN
from lamc.run.remaking import Recipe
from lamc.run.scene_numbers import scene_program
from lamc.run.simulator import Simulator

__all__ = ["compile", "effects_of", "equations_of", "sources_of"]

logger = logging.getLogger("lamc")


def compile(  # noqa: A001  the public name is lamc.compile
    design: Design | Mechanism,
    scene: Scene | str | None = None,
    options: CompileOptions | None = None,
    times: Times | None = None,
    cache: Cache | None = None,
    progress: Observer | bool | None = None,
) -> Simulator:
    """A simulator of `design` in `scene`, which may be the name of one of the design's (None: the design's own, else
    what the design asks for).

    cache: where compiled modules are kept; None: the user's own.
    progress: called with the name of each stage as it begins; True: a bar, in notebooks too.

    Raises DesignError and its leaves for what cannot be simulated, BuildError without a working compiler or cache.
    """
    _check_arguments(design, scene, options, times)
    options = options or CompileOptions()
    times = times or Times()
    with times.reported_to(progress):
        if isinstance(design, Design):
            with times.stage("split"):
                mechanism = split(design)
        else:
            mechanism = design
        scene = _named(mechanism, scene) if isinstance(scene, str) else scene or mechanism.scene or Scene()
        with located_at(scene.places):
            mechanism = with_values(mechanism, scene)
            check_work(mechanism, large=options.large)
            if told := long_work(mechanism):
                warn(told)
            made = _on_branch(Job(mechanism, scene, options, times, cache or Cache(cache_root())))
    logger.info("%r is compiled%s", made, ", from the cache" if times.from_cache else "")
    return made


def _on_branch(job: Job) -> Simulator:
    """The simulator with the rank of the branch that its start takes, where branches of other ranks part. Loads choose
    the branch, and they are known only when it is there; the equations are the same."""
    made = _simulator(job)
    if not made.cut_joints or made.loops.pushed is not None:
        return made
    try:
        with job.times.stage("branch"):
            taken, number = made.loops_taken()
    except DesignError:  # of a start that cannot be had, which is told when it is asked for
        return made
    if taken.rank == made.loops.rank:
        return made
    return _simulator(job.on_branch(replace(taken, branch_ranks=(taken.rank,), pushed=number)))


def _simulator(job: Job) -> Simulator:
    """What takes a while, and may never be asked for, is made then."""
    module, numbers, _ = module_of(job, PLAIN)
    return Simulator(
        job.mechanism,
        job.scene,
        job.effects,
        lambda: job.equations,
        lambda: scene_program(job.sources(PLAIN)[0], job.scene.parameters),
        module,
        numbers,
        job.loops,
        Recipe(job.mechanism, job.scene, job.options, job.cache),
        partial(module_of, job),
    )


def _named(mechanism: Mechanism, name: str) -> Scene:
    if name not in mechanism.scenes:
        raise DesignError(
            f"no scene of the design is named {name[:40]!r}; {did_you_mean(name, list(mechanism.scenes))}"
        )
    return mechanism.scenes[name]


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
    if not isinstance(scene, Scene | str | None):
        raise DesignError(f"the scene is {shown(scene)}; it must be a Scene, the name of one, or None")
    if not isinstance(options, CompileOptions | None):
        raise BuildError(f"options is {shown(options)}; it must be CompileOptions(…), or None")
    if not isinstance(times, Times | None):
        raise BuildError(f"times is {shown(times)}; it must be a Times, or None")

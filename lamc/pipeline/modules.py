"""Compiled code of a job: from the cache by the digest of its design, or by its structure, or built.

In: a `Job`, what its module offers beside the model. Out: the loaded module, and the numbers that the design gives it.
Never: derives what the cache has.
"""

from typing import TYPE_CHECKING

from lamc.codegen.module import Module
from lamc.codegen.toolchain import find_machine_compiler
from lamc.pipeline.job import Job
from lamc.run.extended import Extras
from lamc.run.input_digest import input_digest
from lamc.run.kept_programs import (
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
from lamc.run.scene_numbers import scene_numbers
from lamc.symbolic.staging import DrawnKey

if TYPE_CHECKING:
    from lamc.codegen.emit import SourceTree
    from lamc.symbolic.program import Program


def module_of(job: Job, extras: Extras) -> tuple[Module, DesignNumbers, tuple[DrawnKey, ...]]:
    """The module, the numbers of the design in its scene, and the keys of what `setup` takes of the drawing."""
    made, known = _module(job, extras)
    return made, scene_numbers(made, known.numbers, job.scene.parameters), known.keys


def _module(job: Job, extras: Extras) -> tuple[Module, KeptDesign]:
    options, cache = job.options, job.cache
    maker = find_machine_compiler(options) if extras.is_of_machine else job.compiler
    alias = None  # of this design alone
    if job.common is not None:
        inputs = (job.mechanism, job.effects, job.loops, maker, options, job.scene.inputs)
        alias = input_digest(*inputs, extras=str(extras), common=job.common)
    with job.times.stage("load from cache"):
        known = kept_design(cache, alias) if alias else None
        found = opened_entry(cache, known.entry) if known else None
    if known is not None and found is not None:
        job.times.from_cache = True
        return found, known
    survey = job.survey
    if survey is not None:
        of = structure_alias(survey.structure, maker, options, extras)
        with job.times.stage("load from cache"):
            drawn = design_of_structure(cache, of, survey)
        if drawn is not None:
            job.times.from_cache = True
            if alias:
                keep_design(cache, alias, drawn[1])
            return drawn
    from lamc.codegen.build import build

    program, tree = job.sources(extras)
    tree = _with_extras(program, tree, extras, options.precision)
    with job.times.stage("compile"):
        entry, made, job.times.from_cache = build(tree, program.structure, maker, options, cache)
    keep_opened(cache, entry, made)
    built = KeptDesign(entry, numbers_of(program), tuple(number.key for number in program.geometry))
    if alias:
        keep_design(cache, alias, built)
    if survey is not None:
        keep_structure(cache, of, entry, program)
    return made, built


def _with_extras(program: "Program", tree: "SourceTree", extras: Extras, precision: str) -> "SourceTree":
    """The C with what stands beside the model's own."""
    if extras.lanes:
        from lamc.codegen.emit_lanes import emit_lanes

        tree = emit_lanes(program, tree, precision)
    if extras.columns is not None:
        from lamc.codegen.emit_tangents import emit_tangents

        tree = emit_tangents(program, tree)
    if extras.pullbacks:
        from lamc.codegen.emit_pullbacks import emit_pullbacks

        tree = emit_pullbacks(program, tree)
    return tree

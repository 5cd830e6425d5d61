"""From what users give to a `Study`: names, units, values and measures, checked before anything runs.

In: what is varied and measured, in numbers or in text. Out: a `Study`, or RequestError and DesignError of one line. The
design is compiled once on the way, as it stands: this tells the names, and no other process need compile it.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

from lamc.basics.checks import did_you_mean, shown
from lamc.basics.errors import RequestError, warn
from lamc.codegen.options import CompileOptions
from lamc.records.mechanism import Mechanism
from lamc.records.network import listed_names
from lamc.records.scene import Scene, own_scene
from lamc.run.parameters import checked_parameters
from lamc.studies.axes import Span, Spread, axis_of
from lamc.studies.bench import Bench, RunOptions, Subject
from lamc.studies.measures import checked_measures, outputs_of
from lamc.studies.plans import Plan, given_points, grid_of, sample_words, sampled
from lamc.studies.study import Study
from lamc.studies.targets import (
    Made,
    Studied,
    check_axes,
    check_within,
    family_of,
    known_target,
    made,
    targets_of,
)

SceneGiven = Scene | str | Callable[[Mechanism], Scene] | None

AS_EVER = RunOptions()
_TAKEN = ("point", "structure", "status", "reason")  # columns of the table


def study_of(
    design: Studied | Callable[..., Made],
    vary: Mapping[str, object],
    measure: object,
    scene: SceneGiven = None,
    *,
    sample: str | None = None,
    seed: int = 0,
    points: object = None,
    run: RunOptions = AS_EVER,
    options: CompileOptions | None = None,
) -> Study:
    """The study of a design, checked: names, units, values and measures. As of `lamc.sweep`. Raises RequestError and
    DesignError; nothing has run."""
    design = family_of(design)
    if not measure:
        raise RequestError(
            "nothing is measured; name a measure, such as --measure 'max(tip.z)' (measure={…})"
        )
    scene = scene_of(design, scene)
    first = Bench(Subject(design, scene, options or CompileOptions(), RunOptions(), (), {})).simulator(())
    targets = targets_of(design, first)
    if not isinstance(vary, Mapping):
        raise RequestError(f"vary is {shown(vary)}; it must map names to ranges, {{'length': '20mm:60mm:9'}}")
    plan = _plan(vary, {name: target.unit for name, target in targets.items()}, sample, seed, points)
    chosen = tuple(known_target(name, targets) for name in plan.names)
    if not hasattr(plan, "axes"):
        for k, target in enumerate(chosen):
            spread = isinstance(vary.get(target.name), Spread | str) and sample is not None
            if not spread:
                check_within(target, float(plan.values[:, k].min()), float(plan.values[:, k].max()))
    else:
        check_axes(plan.axes, targets)
    varied = {target.name: target.unit for target in chosen}
    measures = checked_measures(measure, replace(outputs_of(first), varied=varied))
    for name in measures:
        if name in plan.names or name in _TAKEN:
            raise RequestError(f"a measure is named {name!r}, as another column of the table is; rename it")
    for name in run.parameters:
        if known_target(name, targets).kind != "parameter" or name in plan.names:
            raise RequestError(f"the parameter {name!r} is varied, or is none of the model; set it no value")
    run = replace(run, parameters=checked_parameters(run.parameters, first.parameter_units))
    subject = Subject(
        design,
        scene,
        options or CompileOptions(),
        run,
        chosen,
        measures,
    )
    return Study(subject, plan, first.mechanism.name)


def scene_of(design: Studied, scene: SceneGiven) -> Scene | Callable[[Mechanism], Scene] | None:
    """What gives the scene of each drawing: one of the design's own, by name or itself, changes with its dimensions."""
    if isinstance(scene, Scene):
        name = own_scene(made(design, {}), scene)
        if name is None:
            return scene
        scene = name or None
    return partial(named_scene, name=scene) if isinstance(scene, str) else scene


def named_scene(mechanism: Mechanism, name: str) -> Scene:
    """A scene of the design by its name."""
    if name not in mechanism.scenes:
        hint = did_you_mean(name, list(mechanism.scenes))
        raise RequestError(f"no scene of the design is named {name[:40]!r}; {hint}")
    return mechanism.scenes[name]


def _plan(
    vary: Mapping[str, object], units: Mapping[str, str], sample: str | None, seed: int, points: object
) -> Plan:
    if points is not None:
        if vary or sample is not None:
            raise RequestError("points are given one by one; leave out what else is varied, and samples")
        return given_points(points, units)
    if not vary:
        raise RequestError("nothing is varied; name a range, such as --vary length=20mm:60mm:9 (vary={…})")
    for name in vary:
        if name not in units:
            raise RequestError(
                f"nothing that can be varied is named {shown(name)}; {did_you_mean(str(name), list(units))}"
            )
    axes = {name: axis_of(name, given, units[name]) for name, given in vary.items()}
    if sample is None:
        return grid_of(axes)
    counted = [name for name, axis in axes.items() if isinstance(axis, Span) and axis.count]
    if counted:
        warn(
            f"vary {listed_names([repr(name) for name in counted])}: samples ({sample}) lie everywhere in the range, "
            "and its count says nothing; leave out the count, or the samples"
        )
    return sampled(axes, *sample_words(sample), seed)

"""Errors of a run's outputs: differences of two runs over the range that each output passes through.

In: `Result`s whose rows lie at the same times. Out: relative errors by output. Never: runs anything.
"""

import numpy as np

from lamc.records.scene import Scene
from lamc.run.outputs import Output, outputs_of, shared_ranges
from lamc.run.request import Array
from lamc.run.result import Result


def compared_outputs(result: Result, scene: Scene) -> tuple[Output, ...]:
    """The scene's outputs; where it names none, all joints, and all coordinates that effects add."""
    if scene.outputs is not None:
        return outputs_of(result, scene)
    more = result.coordinates[len(result.joints) :]
    return (
        *(Output(name, "rad", result.angle(name)) for name in result.joints),
        *(Output(each.name, each.unit, result.coordinate(each.name)) for each in more),
    )


def ranges(outputs: tuple[Output, ...], *, chosen: bool) -> dict[str, float]:
    """The scale of each output by name, in its unit, as `shared_ranges` has it."""
    own = [float(np.ptp(each.values)) if len(each.values) else 0.0 for each in outputs]
    shared = shared_ranges(outputs, own, chosen=chosen)
    return {each.name: span for each, span in zip(outputs, shared, strict=True)}


def output_errors(result: Result, truth: Result, scene: Scene) -> dict[str, float]:
    """Largest |result - truth| of each output over its scale in `truth`, by name, over the rows that both have.
    A whole turn is an error."""
    rows = common_rows(result, truth)
    exact = compared_outputs(truth, scene)
    scale = ranges(exact, chosen=scene.outputs is not None)
    found = {}
    for mine, other in zip(compared_outputs(result, scene), exact, strict=True):
        gap: Array = mine.values[:rows] - other.values[:rows]
        found[mine.name] = float(np.abs(gap).max(initial=0.0)) / scale[mine.name]
    return found


def common_rows(result: Result, other: Result) -> int:
    """How many rows at the beginning lie at the same times in both."""
    most = min(len(result.t), len(other.t))
    apart = np.flatnonzero(result.t[:most] != other.t[:most])
    return int(apart[0]) if len(apart) else most

"""The quantities that a ledger compares: outputs of a run, their ranges, and differences of two runs.

In: `Result`s on one grid of times. Out: arrays and relative errors. Never: runs anything.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from lamc.ledger.records import Output
from lamc.records.scene import Scene
from lamc.run.outputs import outputs_of, shared_ranges
from lamc.run.request import Array
from lamc.run.result import Result


@dataclass(frozen=True, eq=False)
class Scales:
    """The outputs of the reference run with the scales of their errors, and those of the rates by unit."""

    scene: Scene  # with the outputs named
    outputs: tuple[Output, ...]
    rates: Mapping[str, float]


@dataclass(frozen=True)
class Errors:
    """Relative differences of two runs: at the end, at all times, of the rates; by output at all times."""

    end: float
    path: float
    rates: float
    by_output: dict[str, float]


def scales(result: Result, scene: Scene) -> Scales:
    """The outputs of a run as `Scene.outputs` names them; without any, all joint angles, or coordinates where there is
    no joint.

    Scales are the ranges that `shared_ranges` gives.
    """
    if scene.outputs is None and not result.joints:
        scene = replace(scene, outputs=tuple(coordinate.name for coordinate in result.coordinates))
    found = outputs_of(result, scene)
    spans = [float(np.ptp(f.values)) for f in found]
    spans = shared_ranges(found, spans, chosen=scene.outputs is not None)
    outputs = tuple(
        Output(f.name, f.unit, float(f.values.min()), float(f.values.max()), span)
        for f, span in zip(found, spans, strict=True)
    )
    named = scene if scene.outputs is not None else replace(scene, outputs=tuple(f.name for f in found))
    units = np.array([rate.unit for rate in result.rates])
    ranges = np.ptp(result.u, axis=0)
    return Scales(
        named, outputs, {str(u): float(ranges[units == u].max()) or 1.0 for u in dict.fromkeys(units)}
    )


def differences(result: Result, other: Result, scale: Scales) -> Array:
    """|result - other| of the outputs over their scales, shape (m, k)."""
    columns = []
    pairs = zip(outputs_of(result, scale.scene), outputs_of(other, scale.scene), scale.outputs, strict=True)
    for mine, its, output in pairs:
        columns.append(np.abs(mine.values - its.values) / output.scale)
    return np.stack(columns, axis=1)


def errors(result: Result, other: Result, scale: Scales) -> Errors:
    """The errors of `result` if `other` is the truth; both on the same times. Rates are compared where both have the
    same ones."""
    relative = differences(result, other, scale)
    rates = 0.0
    if result.u.shape == other.u.shape:
        per_unit = np.array([scale.rates.get(rate.unit, 1.0) for rate in other.rates])
        rates = float((np.abs(result.u - other.u) / per_unit).max(initial=0.0))
    worst = relative.max(axis=0)
    return Errors(
        end=float(relative[-1].max()),
        path=float(worst.max()),
        rates=rates,
        by_output={o.name: float(v) for o, v in zip(scale.outputs, worst, strict=True)},
    )


def drift(result: Result, truth: Result) -> float | None:
    """Largest change of the energy over the largest kinetic energy of the truth; None where nothing moves."""
    kinetic = float(truth.energies["kinetic"].max(initial=0.0))
    return float(np.abs(result.energy - result.energy[0]).max()) / kinetic if kinetic > 0.0 else None

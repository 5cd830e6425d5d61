"""The quantities that a ledger compares: outputs of a run, their ranges, and differences of two runs.

In: `Result`s on one grid of times. Out: arrays and relative errors. Never: runs anything.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.errors import DesignError
from lamc.ledger.records import Output
from lamc.run.request import Array, did_you_mean
from lamc.run.result import Result

_AXES = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class Scales:
    """The outputs of the reference run with the scales of their errors, and that of the rates."""

    outputs: tuple[Output, ...]
    rate_scale: float  # rad/s

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(output.name for output in self.outputs)


@dataclass(frozen=True)
class Errors:
    """Relative differences of two runs: at the end, at all times, of the rates; by output at all times."""

    end: float
    path: float
    rates: float
    by_output: dict[str, float]


def scales(result: Result, chosen: Sequence[str] | None) -> Scales:
    """The outputs of a run by name, as `Scene.outputs` has them; None: all joint angles.

    A chosen output has its own range as its scale. Joint angles that nobody chose share the largest range of any of
    them: a hinge that hardly moves need not be known to a thousandth of that little. Raises DesignError for a name that
    is none.
    """
    names = tuple(result.joints) if chosen is None else tuple(chosen)
    found = [_series(result, name) for name in names]
    ranges = [float(np.ptp(series)) for series, _ in found]
    if chosen is None:
        ranges = [max(ranges, default=0.0)] * len(ranges)
    outputs = tuple(
        Output(name, unit, float(series.min()), float(series.max()), span or 1.0, is_angle=unit == "rad")
        for name, (series, unit), span in zip(names, found, ranges, strict=True)
    )
    rates = float(np.ptp(result.u, axis=0).max(initial=0.0)) or 1.0
    return Scales(outputs, rates)


def _series(result: Result, name: str) -> tuple[Array, str]:
    """An output over the rows of a run, shape (m,), and its unit."""
    if name in result.joints or name in result.motion.model.cuts:
        return result.angle(name), "rad"
    body, dot, axis = name.rpartition(".")
    if dot and axis in _AXES and body in result.bodies:
        return result.pose(body)[0][:, _AXES.index(axis)], "m"
    known = (*result.joints, *result.motion.model.cuts, *(f"{b}.x" for b in result.bodies))
    raise DesignError(f"the scene's outputs name {name!r}, which is none; {did_you_mean(name, known)}")


def differences(result: Result, other: Result, scale: Scales) -> Array:
    """|result - other| of the outputs over their scales, shape (m, k); angles modulo 2π."""
    columns = []
    for output in scale.outputs:
        gap = _series(result, output.name)[0] - _series(other, output.name)[0]
        if output.is_angle:
            gap = np.remainder(gap + np.pi, 2.0 * np.pi) - np.pi
        columns.append(np.abs(gap) / output.scale)
    return np.stack(columns, axis=1)


def errors(result: Result, other: Result, scale: Scales) -> Errors:
    """The errors of `result` if `other` is the truth; both on the same times."""
    relative = differences(result, other, scale)
    rates = float(np.abs(result.u - other.u).max(initial=0.0)) / scale.rate_scale
    worst = relative.max(axis=0)
    return Errors(
        end=float(relative[-1].max()),
        path=float(worst.max()),
        rates=rates,
        by_output={name: float(v) for name, v in zip(scale.names, worst, strict=True)},
    )

"""Recordings beside what a fitted model says of them, and what of it is no noise.

In: a predictor and where the search ended. Out: a `Compared` of each recording, and sentences. Never: fits.
"""

from dataclasses import dataclass

import numpy as np

from lamc.basics.numbers import shown_number
from lamc.fitting.neighbours import likeness, offset
from lamc.fitting.predictions import Predictor
from lamc.fitting.solve import Solved
from lamc.run.request import Array

_CORRELATED = 0.3  # of neighbouring rows, beyond which they are no noise, and intervals too narrow to believe
# By unit: what is less may be below what a sensor tells, or its file is rounded to
_TOLD_BY_SENSORS = {"rad": 1e-3, "rad/s": 1e-2, "m": 1e-5, "m/s": 1e-3, "": 1.0}  # "": pixels
_ROUND_OFF = 1e-12  # of a column's largest number: what varies by less stands still


def _stands_still(values: Array) -> bool:
    """Whether numbers (m,) are all one, but for round-off."""
    return bool(np.ptp(values) <= _ROUND_OFF * np.abs(values).max())


@dataclass(frozen=True, eq=False)
class Compared:
    """A recording beside what the fitted model says. t: (m,), s, of its clock; measured, predicted: (m, k), NaN: gaps;
    columns and their units."""

    name: str
    t: Array
    columns: tuple[str, ...]
    units: tuple[str, ...]
    measured: Array
    predicted: Array

    @property
    def residuals(self) -> Array:
        """Predicted less measured, (m, k)."""
        return self.predicted - self.measured

    @property
    def rms(self) -> dict[str, float]:
        """Root mean square of residuals, by column."""
        with np.errstate(invalid="ignore"):
            found = np.sqrt(np.nanmean(self.residuals**2, axis=0))
        return dict(zip(self.columns, found.tolist(), strict=True))

    def share_text(self, column: str) -> str:
        """Of the column's variance what the model leaves, in words: none where what was recorded stands still, or is at
        rest, as the model has it, and its variance that of noise."""
        k, share = self.columns.index(column), self.share[column]
        rows = np.isfinite(self.measured[:, k])
        measured, predicted = self.measured[rows, k], self.predicted[rows, k]
        stands = _stands_still(predicted) or float(np.ptp(predicted)) < self.rms[column]
        if _stands_still(measured):
            moves = shown_number(float(np.ptp(predicted)), self.units[k], 3)
            return "at rest" if stands else f"stands still, and the model moves by {moves}"
        return "at rest" if stands and not _is_alike(likeness(measured)) else f"{share:.2%}"

    @property
    def share(self) -> dict[str, float]:
        """Of each column's variance, what the model leaves."""
        found = np.nanvar(self.residuals, axis=0) + np.nanmean(self.residuals, axis=0) ** 2
        spread = np.nanvar(self.measured, axis=0)
        return {
            c: float(f / s) if s > 0.0 else float("nan")
            for c, f, s in zip(self.columns, found, spread, strict=True)
        }


def compared_of(predictor: Predictor, solved: Solved) -> tuple[Compared, ...]:
    """The recordings beside the model."""
    found = []
    for which, (run, prediction) in enumerate(
        zip(predictor.setting.runs, solved.objective.predictions(solved.inner, sloped=False), strict=True)
    ):
        signals = predictor.signals(which, predictor.setting.simulators.usual).all
        camera = run.recording.camera is not None
        units = tuple(
            ("" if camera and told.axis is not None else signals[told.base].unit) for told in run.sight.told
        )
        measured = run.measured
        predicted = np.where(np.isfinite(prediction.values), prediction.values, np.nan)
        found.append(Compared(run.name, run.times, run.sight.columns, units, measured, predicted))
    return tuple(found)


def _is_dead(compared: Compared, k: int) -> bool:
    """Whether a column stands still where the model moves by more than its sensor fails to tell."""
    predicted = compared.predicted[np.isfinite(compared.measured[:, k]), k]
    moves = float(np.ptp(predicted)) if len(predicted) else 0.0
    least = _TOLD_BY_SENSORS.get(compared.units[k], 0.0)
    return moves > least and "stands still" in compared.share_text(compared.columns[k])


def _is_alike(likeness_of: tuple[float, int] | None) -> bool:
    """Whether neighbouring rows are more alike than those of noise."""
    return likeness_of is not None and likeness_of[0] > _CORRELATED + 2.0 / np.sqrt(likeness_of[1])


def remarks(compared: tuple[Compared, ...]) -> list[str]:
    """Where residuals are no noise, and columns that stand still where the model moves."""
    found = []
    for each in compared:
        dead = [column for k, column in enumerate(each.columns) if _is_dead(each, k)]
        found += [
            f"{each.name}: {column} {each.share_text(column)}: is that sensor dead? Leave its column out"
            for column in dead
        ]
        for k, column in enumerate(each.columns):
            alike = likeness(each.residuals[:, k])
            if alike is not None and _is_alike(alike):
                found.append(
                    f"{each.name}: what is left of {column} is alike from row to row (correlation {alike[0]:.2f}): "
                    "the model misses something, and the intervals are too narrow"
                )
            # A column that says what is not so pulls the model off the others.
            size = float(np.nanmax(np.abs(each.measured[:, k]), initial=0.0))
            off = 0.0 if dead else offset(each.residuals[:, k], size)
            if off:
                found.append(
                    f"{each.name}: the model is off {column} by {shown_number(off, each.units[k], 3)} throughout: it "
                    "misses something, and the intervals are too narrow; if that is the sensor's, free its bias: "
                    f"--free {column}.bias=LOW:HIGH"
                )
    return found


def beyond_a_turn(compared: tuple[Compared, ...]) -> list[str]:
    """Angles that may be degrees, taken for radians."""
    most = {
        f"{each.name}: {column}": float(np.nanmax(np.abs(each.measured[:, k]), initial=0.0))
        for each in compared
        for k, column in enumerate(each.columns)
        if each.units[k] == "rad"
    }
    return [
        f"{name} reaches {size:.4g} rad; are these degrees?"
        for name, size in most.items()
        if size > 2.0 * np.pi
    ]

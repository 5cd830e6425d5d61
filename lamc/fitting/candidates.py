"""Which measurement would tell more: D-optimality over candidates.

In: a fit, columns that might have been recorded beside. Out: by candidate, how much smaller the region of all numbers
would be, and the error of each. Information adds up: J'J over the noise's variance, of the model linearised where the
fit ended (Atkinson, Donev & Tobias, Optimum Experimental Designs, 2007, ch. 17). Never: measures, or runs anything
anew but the recording's own run with its derivatives.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.checks import is_list, shown
from lamc.basics.errors import RequestError
from lamc.fitting.predictions import Predictor
from lamc.fitting.recorded import check_columns
from lamc.fitting.sight import sight_of
from lamc.fitting.signals import Column
from lamc.run.request import Array

if TYPE_CHECKING:
    from lamc.fitting.answer import Fit

_GUESS = 0.01  # of how much a candidate varies: noise of a kind that no recording has
_NONE = 1e-6  # of a direction: a share that is none
_LEAST = 1e-12  # of the largest information: what is not told is told by something else, or not at all


@dataclass(frozen=True, eq=False)
class Candidate:
    """name: of the column. noise: standard deviation that it is taken to have, in `unit`. shrinks: times by which the
    volume of the confidence region becomes smaller. errors: standard errors by name, as the fit has them, with it."""

    name: str
    noise: float
    unit: str
    shrinks: float
    errors: Mapping[str, float]


def candidates(
    fit: "Fit", columns: Sequence[str], markers: Mapping[str, object] | None = None
) -> tuple[Candidate, ...]:
    """The candidates, the one that tells most first. Each is taken to be recorded at the rows of the first recording,
    with the noise that the fit found for its unit, else of 1 % of how much it varies. Raises RequestError for names of
    nothing."""
    if not is_list(columns) or not len(columns) or not all(isinstance(each, str) for each in columns):
        raise RequestError(f"candidates are {shown(columns)}; give names of columns, ['h2', 'link_2.x']")
    unknowns = fit.setting.unknowns
    inner = fit.solved.inner
    objective = fit.solved.objective
    jacobian = objective.jacobian(inner, objective.predictions(inner, sloped=True)) / fit.account.noise
    known = jacobian.T @ jacobian
    found = [_candidate(fit, column, markers or {}, known, unknowns.rates(inner)) for column in columns]
    return tuple(sorted(found, key=lambda each: -each.shrinks))


def _candidate(
    fit: "Fit", column: str, markers: Mapping[str, object], known: Array, rates: Array
) -> Candidate:
    first = fit.setting.runs[0]
    values = {column: np.zeros(len(first.recording.t))}
    plain = replace(
        first.recording,
        values=values,
        camera=None,
        gain={},
        bias={},
        sigma=None,
        markers={**first.recording.markers, **markers},
    )
    run = replace(first, recording=plain, sight=sight_of(plain, first.name))
    check_columns(fit.simulator, run.sight)
    predictor = Predictor(replace(fit.setting, runs=(run,)), fit.predictor.runs)
    at = np.array([fit.values[name] for name in fit.names])
    prediction = predictor.prediction(0, at, sloped=True)
    signal = predictor.signals(0, fit.simulator).all[0]
    unit = signal.unit if isinstance(signal, Column) else "m"
    noise = _noise(fit, unit) or _GUESS * float(np.std(prediction.values)) or 1.0
    more = prediction.slopes[:, 0, :] * rates / noise
    total = known + more.T @ more
    shrinks = float(np.exp(0.5 * (_volume(total) - _volume(known))))
    return Candidate(column, noise, unit, shrinks, dict(zip(fit.names, _errors(total), strict=True)))


def _errors(information: Array) -> list[float]:
    """Standard errors (p,); infinite where a direction without information goes through a number."""
    scale = np.sqrt(np.maximum(np.diagonal(information), 1e-300))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    with np.errstate(divide="ignore", invalid="ignore"):
        kept = np.where(values > _LEAST, values, 0.0)
        parts = np.where(np.abs(vectors) > _NONE, vectors**2 / kept, 0.0)
    found: list[float] = (np.sqrt(parts.sum(axis=1)) / scale).tolist()
    return found


def _noise(fit: "Fit", unit: str) -> float | None:
    """What the fit left of columns of a unit, for each of its freedoms."""
    squares = [
        each.residuals[:, k][np.isfinite(each.residuals[:, k])] ** 2
        for each in fit.compared
        for k, own in enumerate(each.units)
        if own == unit
    ]
    if not squares:
        return None
    spent = 1.0 + len(fit.names) / fit.account.freedom  # data that numbers took
    return float(np.sqrt(spent * np.mean(np.concatenate(squares))))


def _volume(information: Array) -> float:
    """The logarithm of the determinant, in units of each number's own information, above round-off."""
    scale = np.sqrt(np.maximum(np.diagonal(information), 1e-300))
    values = np.linalg.eigvalsh(information / np.outer(scale, scale))
    return float(np.sum(np.log(np.maximum(values, _LEAST))) + 2.0 * np.sum(np.log(scale)))

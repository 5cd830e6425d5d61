"""What a fit makes small: residuals of all recordings over their noise, and of priors.

In: a predictor, weights. Out: residuals (N,) and their Jacobian (N, p) by a solver's vector. Gaps are left out. Where a
run fails there are none, and `failures` says why.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from lamc.basics.errors import DesignError, LamcError
from lamc.fitting.losses import cost_of, weighed
from lamc.fitting.predictions import Prediction, Predictor
from lamc.fitting.signals import Column
from lamc.fitting.trust import Local, local_of
from lamc.run.request import Array

NOTHING = Local(np.inf, np.zeros((0, 0)), np.zeros(0))


@dataclass(eq=False)
class Objective:
    """sigmas: by recording, (k,) each: what residuals are divided by. share: of each recording's time, from its begin,
    that is compared. failures: why runs failed, as they come."""

    predictor: Predictor
    sigmas: list[Array]
    share: float = 1.0
    failures: list[str] = field(default_factory=list)

    @cached_property
    def measured(self) -> list[Array]:
        """By recording, (m, k); NaN: not compared."""
        found = []
        for run in self.predictor.setting.runs:
            late = run.times > run.times[0] + self.share * (run.times[-1] - run.times[0])
            found.append(np.where(late[:, None], np.nan, run.measured))
        return found

    @property
    def count(self) -> int:
        """Of residuals."""
        priors = sum(u.free.prior is not None for u in self.predictor.setting.unknowns.all)
        return priors + sum(int(np.isfinite(each).sum()) for each in self.measured)

    def predictions(
        self, inner: Array, *, sloped: bool, fine: bool = False, loosely: bool = False
    ) -> list[Prediction]:
        """Of all recordings. Raises LamcError for a start that cannot be had."""
        values = self.predictor.setting.unknowns.values(inner)
        return [
            self.predictor.prediction(k, values, sloped=sloped, fine=fine, loosely=loosely)
            for k in range(len(self.sigmas))
        ]

    def tried(self, inner: Array, *, sloped: bool, loosely: bool = False) -> list[Prediction] | None:
        """The same, or None where a run fails."""
        try:
            found = self.predictions(inner, sloped=sloped, loosely=loosely)
        except DesignError as error:  # of a start, or a drawing, that cannot be
            self.failures.append(f"{self._what_was_drawn(inner)}{error.message}")
            return None
        for measured, each in zip(self.measured, found, strict=True):
            good = np.isfinite(measured)
            if each.message or not (
                np.isfinite(each.values[good]).all() and np.isfinite(each.slopes[good]).all()
            ):
                self.failures.append(each.message or "the run gives no finite numbers")
                return None
        return found

    def _what_was_drawn(self, inner: Array) -> str:
        """Which drawing was tried, if dimensions are free: it is none of the user's, whom its fault may puzzle."""
        unknowns = self.predictor.setting.unknowns
        tried = [
            f"{u.name} = {value:.6g} {u.unit}".rstrip()
            for u, value in zip(unknowns.all, unknowns.values(inner), strict=True)
            if u.kind == "dimension"
        ]
        if not tried:
            return ""
        return f"a drawing that was tried, at or next to {', '.join(tried)} (bound it by LOW:HIGH): "

    def residual(self, inner: Array, found: list[Prediction]) -> Array:
        """(N,), of predictions at a solver's vector."""
        parts = [
            ((each.values - measured) / sigma)[np.isfinite(measured)]
            for measured, each, sigma in zip(self.measured, found, self.sigmas, strict=True)
        ]
        return np.concatenate([*parts, self._priors(inner)])

    def jacobian(self, inner: Array, found: list[Prediction]) -> Array:
        """(N, p), by the solver's vector. Raises LamcError where there is none."""
        return self.jacobians(inner, found)[0]

    def jacobians(self, inner: Array, found: list[Prediction]) -> tuple[Array, Array]:
        """The same, and (N, e) by what else runs know their slopes by."""
        setting = self.predictor.setting
        rates = setting.unknowns.rates(inner)
        parts, others = [], []
        for run, measured, prediction, sigma in zip(
            setting.runs, self.measured, found, self.sigmas, strict=True
        ):
            if prediction.message:
                raise LamcError(f"{run.name} has no derivatives: {prediction.message}")
            good = np.isfinite(measured)
            parts.append((prediction.slopes / sigma[:, None])[good] * rates)
            others.append((prediction.beside / sigma[:, None])[good])
        values = setting.unknowns.values(inner)
        for k, each in enumerate(setting.unknowns.all):
            if each.free.prior is not None:
                row = np.zeros((1, len(values)))
                row[0, k] = rates[k] / each.free.prior[1]
                parts.append(row)
                others.append(np.zeros((1, others[0].shape[1])))
        return np.concatenate(parts), np.concatenate(others)

    def _priors(self, inner: Array) -> Array:
        unknowns = self.predictor.setting.unknowns
        values = unknowns.values(inner)
        return np.array(
            [
                (v - u.free.prior[0]) / u.free.prior[1]
                for u, v in zip(unknowns.all, values, strict=True)
                if u.free.prior is not None
            ]
        )


@dataclass(frozen=True, eq=False)
class Weighed:
    """An objective under a loss: the problem that a solver makes least. loosely: by runs that are good enough to walk
    by."""

    objective: Objective
    loss: str
    loosely: bool = False

    @property
    def known_to(self) -> float:
        return self.objective.predictor.runs.known_to

    @property
    def at_once(self) -> bool:
        return self.objective.predictor.at_once

    def cost(self, x: Array) -> float:
        found = self.objective.tried(x, sloped=False, loosely=self.loosely)
        return np.inf if found is None else cost_of(self.objective.residual(x, found), self.loss)

    def local(self, x: Array) -> Local:
        objective = self.objective
        found = objective.tried(x, sloped=True, loosely=self.loosely)
        if found is None:
            return NOTHING
        residual, jacobian = objective.residual(x, found), objective.jacobian(x, found)
        return local_of(cost_of(residual, self.loss), *weighed(residual, jacobian, self.loss))


def groups_of(predictor: Predictor) -> list[list[str]]:
    """For each recording and column, what its noise is shared with: columns of one unit, or of one camera."""
    setting = predictor.setting
    found = []
    for which, run in enumerate(setting.runs):
        signals = predictor.signals(which, setting.simulators.usual).all
        camera = run.recording.camera
        names = []
        for column, told in zip(run.sight.columns, run.sight.told, strict=True):
            signal = signals[told.base]
            unit = signal.unit if isinstance(signal, Column) else "m"
            if run.recording.sigma_of(column) is not None:
                names.append("")
            else:
                names.append(camera.name if camera is not None and told.axis is not None else unit)
        found.append(names)
    return found


def first_sigmas(predictor: Predictor) -> list[Array]:
    """What residuals are divided by at first: the noise that is said, else a part of how a group's columns vary."""
    groups = groups_of(predictor)
    sizes: dict[str, list[float]] = {}
    for run, names in zip(predictor.setting.runs, groups, strict=True):
        for column, name in zip(run.measured.T, names, strict=True):
            if np.isfinite(column).any():
                sizes.setdefault(name, []).append(float(np.nanstd(column)))
    usual = {name: 0.01 * (float(np.sqrt(np.mean(np.square(each)))) or 1.0) for name, each in sizes.items()}
    found = []
    for run, names in zip(predictor.setting.runs, groups, strict=True):
        sigmas = [
            run.recording.sigma_of(c) or usual.get(n, 1.0)
            for c, n in zip(run.sight.columns, names, strict=True)
        ]
        found.append(np.array(sigmas))
    return found


def residual_sigmas(predictor: Predictor, predictions: list[Prediction], sigmas: list[Array]) -> list[Array]:
    """The same, of what is left of each group."""
    groups = groups_of(predictor)
    left: dict[str, list[Array]] = {}
    for run, names, found in zip(predictor.setting.runs, groups, predictions, strict=True):
        residual = found.values - run.measured
        for column, name in zip(residual.T, names, strict=True):
            left.setdefault(name, []).append(column[np.isfinite(column)])
    usual = {}
    for name, parts in left.items():
        every = np.concatenate(parts)
        usual[name] = float(np.sqrt(np.mean(every**2))) if len(every) else 0.0
    return [
        np.array(
            [
                old if not name or not usual[name] > 0.0 else usual[name]
                for name, old in zip(names, sigma, strict=True)
            ]
        )
        for names, sigma in zip(groups, sigmas, strict=True)
    ]

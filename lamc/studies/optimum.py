"""What `lamc.optimise` gives: a `Best`, made of the trials and the optimum that was found.

In: a problem, an optimum, a verdict. Out: parameters with their units, what holds them, how far each may move. The
history as a Dataset, a CSV file, netCDF. It runs nothing but the best once more, when it is asked for.
"""

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lamc.basics.files import replacing
from lamc.run.request import Array
from lamc.run.result import Result
from lamc.studies.derivatives import STEP
from lamc.studies.problem import Problem
from lamc.studies.refinement import Optimum
from lamc.studies.space import Value
from lamc.studies.structures import Numbers, numbered
from lamc.studies.table import need_xarray
from lamc.studies.targets import Made
from lamc.studies.trier import Trier

if TYPE_CHECKING:
    import xarray

_SHARE = 0.01  # of the value, by which flatness is told


@dataclass(frozen=True, eq=False)
class Best:
    """The best that was found. Numbers are SI.

    parameters  by name; words of choices are words
    value       the goal there; values: of all goals; unit: of the first
    converged   whether it is an optimum, looked at from all sides: slopes vanish and no point beside is lower. That no
                other place far away is lower, no method can know; message tells how many starts came here
    message     why, or why not
    active      bounds and constraints that hold it: "length = 0.06, its most", "max(abs(h1)) < 60 deg"
    multipliers of what is active: how much the value falls for each unit that a constraint or bound gives way
    moves       by name, how far a parameter may move, others kept, until the value is 1 % more (or, of a value that is
                next to nothing beside what was seen, 1 % of that); inf where it is not felt in all of its range
    known_to    by name, what the last step and the noise of runs leave uncertain
    curvature   eigenvalues (n,) of the value's second derivatives over the ranges, ascending, in parts of the value's
                own size, and directions (n, n), columns, along the real parameters `names`: the first is the flattest
    units       SI, by name of parameters
    front       of several goals, what no other point betters in all of them, as a Dataset; else None
    """

    parameters: Mapping[str, Value]
    value: float
    values: tuple[float, ...]
    unit: str
    converged: bool
    message: str
    active: tuple[str, ...]
    multipliers: Mapping[str, float]
    moves: Mapping[str, float]
    known_to: Mapping[str, float]
    curvature: Array
    directions: Array
    names: tuple[str, ...]
    units: Mapping[str, str]
    constraints: Mapping[str, float]
    problem: Problem = field(repr=False)
    trier: Trier = field(repr=False)
    point: tuple[float, ...] = field(repr=False)
    method: str = ""
    interrupted: bool = False
    on_front: tuple[int, ...] | None = None

    @property
    def runs(self) -> int:
        """How many there were."""
        return len(self.problem.trials)

    @property
    def result(self) -> Result:
        """The run of the best, made once more."""
        return self.trier.result(self.point)

    @property
    def design(self) -> Made:
        """The design with the best dimensions."""
        return self.trier.design(self.point)

    @property
    def structures(self) -> Numbers:
        """(runs,): runs of one number share their equations and one compile; -1 where there are none. Slopes across a
        change of topology mean nothing."""
        return numbered({trial.index: trial.structure for trial in self.problem.trials}, self.runs)

    @property
    def history(self) -> "xarray.Dataset":
        """All runs, in their order: what was tried, goals, constraints (above zero where violated), structure (runs of
        one number share their equations; -1: none), status, reason, stage. Raises LamcError without xarray."""
        return self._dataset(range(self.runs))

    @property
    def front(self) -> "xarray.Dataset | None":
        return None if self.on_front is None else self._dataset(self.on_front)

    def _dataset(self, which: "range | tuple[int, ...]") -> "xarray.Dataset":
        trials = [self.problem.trials[k] for k in which]
        columns: dict[str, tuple[str, Any, dict[str, str]]] = {}
        for k, variable in enumerate(self.problem.space.variables):
            told = [variable.value_of(trial.point[k]) for trial in trials]
            columns[variable.name] = ("run", np.array(told), {"units": variable.unit})
        for goal, column in self._goals().items():
            columns[goal] = ("run", column[list(which)], {"units": self._unit(goal)})
        for k, constraint in enumerate(self.problem.constraints):
            values = np.array([trial.constraints[k] for trial in trials])
            columns[constraint.text] = ("run", values, {"units": constraint.measure.unit})
        columns["structure"] = ("run", self.structures[list(which)], {})
        for name in ("status", "reason", "stage"):
            columns[name] = ("run", np.array([getattr(trial, name) for trial in trials], dtype=np.str_), {})
        coords = {"run": np.array(list(which), dtype=np.int64)}
        found: xarray.Dataset = need_xarray().Dataset(columns, coords)
        return found

    def _goals(self) -> dict[str, Array]:
        return {
            goal.text: np.array([trial.goals[k] for trial in self.problem.trials])
            for k, goal in enumerate(self.problem.goals)
        }

    def _unit(self, goal: str) -> str:
        return next(each.unit for each in self.problem.goals if each.text == goal)

    def write_csv(self, path: Path) -> Path:
        """The history: a line for each run, numbers with 17 digits."""
        heads = [f"{v.name} ({v.unit})" for v in self.problem.space.variables]
        heads += [f"{goal.text} ({goal.unit})" for goal in self.problem.goals]
        heads += [f"{each.text} ({each.measure.unit})" for each in self.problem.constraints]
        with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(["run", *heads, "structure", "status", "reason", "stage"])
            for t, structure in zip(self.problem.trials, self.structures.tolist(), strict=True):
                told = self.problem.space.values_at(t.point).values()
                ended = (structure, t.status, t.reason, t.stage)
                writer.writerow([t.index, *told, *t.goals, *t.constraints, *ended])
        return path

    def write_netcdf(self, path: Path) -> Path:
        """The history as a netCDF 3 file. Raises LamcError without xarray."""
        dataset = self.history
        names = {str(name): str(name).replace("/", "÷") for name in dataset.variables if "/" in str(name)}
        for name in names:
            dataset[name].attrs["long_name"] = name
        with replacing(path) as temporary:
            dataset.rename(names).to_netcdf(temporary, engine="scipy", format="NETCDF3_64BIT")
        return path


def active_of(problem: Problem, optimum: Optimum) -> tuple[dict[str, float], tuple[str, ...]]:
    """Multipliers of what holds the optimum, in the goal's unit for a unit of each, and what it is in words."""
    rate = _per_cost(problem, optimum) * problem.size
    found: dict[str, float] = {}
    for k, edge in enumerate(problem.space.real):
        side = optimum.sides[k]
        if side and optimum.slopes is not None:
            variable = problem.space.variables[edge]
            end, word = (variable.low, "least") if side < 0 else (variable.high, "most")
            unit = "" if variable.unit == "1" else f" {variable.unit}"
            pull = float(optimum.slopes.gradient[k])
            pull += float(
                sum(
                    f * optimum.slopes.rows[c, k]
                    for f, c in zip(optimum.forces, optimum.holding, strict=True)
                )
            )
            steep = variable.slope(float(optimum.places[edge]))
            found[f"{variable.name} = {end:g}{unit}, its {word}"] = abs(pull) * rate / steep
    for force, k in zip(optimum.forces, optimum.holding, strict=True):
        found[problem.constraints[k].text] = float(force) * rate / float(problem.sizes[k])
    return found, tuple(found)


def moves_of(problem: Problem, optimum: Optimum) -> dict[str, float]:
    """How far each real parameter may move until the value is 1 % more; inf beyond its range."""
    if optimum.slopes is None:
        return {}
    trial = problem.at(optimum.places)
    value, cost = trial.goals[0], problem.cost(trial)
    rooted = problem.is_rooted(trial)
    whole = math.sqrt(problem.size) if rooted else problem.size
    more = _SHARE * (abs(value) if abs(value) > 1e-6 * whole else whole)
    rise = ((value + more) ** 2 - cost if rooted else more) / problem.size
    found = {}
    for k, edge in enumerate(problem.space.real):
        slope, bend = abs(float(optimum.slopes.gradient[k])), float(optimum.slopes.hessian[k, k])
        if not optimum.sides[k] and not optimum.holding:
            slope = 0.0
        inner = slope * slope + 2.0 * max(bend, 0.0) * rise
        scale = slope + math.sqrt(inner)
        steep = problem.space.variables[edge].slope(float(optimum.places[edge]))
        share = 2.0 * rise / scale if scale > 0.0 else math.inf
        found[problem.space.names[edge]] = share * steep if share < 1.0 else math.inf
    return found


def known_of(problem: Problem, optimum: Optimum) -> dict[str, float]:
    """What is left uncertain of each real parameter: the last step, and what the noise of slopes comes to."""
    found = {}
    for k, edge in enumerate(problem.space.real):
        variable = problem.space.variables[edge]
        steep = variable.slope(float(optimum.places[edge]))
        if optimum.slopes is None or not optimum.is_minimum:
            found[variable.name] = math.inf
        else:
            vague = optimum.slopes.noise / STEP * float(np.linalg.norm(optimum.response[k]))
            found[variable.name] = (abs(float(optimum.last[k])) + vague) * steep
        if len(optimum.flat.T) and float(np.linalg.norm(optimum.flat[k])) > 0.1:
            found[variable.name] = math.inf
    return found


def curvature_of(problem: Problem, optimum: Optimum) -> tuple[Array, Array]:
    """Eigenvalues (n,), ascending, and directions (n, n) of the cost's Hessian over the box."""
    if optimum.slopes is None or not len(problem.space.real):
        return np.zeros(0), np.zeros((0, 0))
    found, vectors = np.linalg.eigh(optimum.slopes.hessian)
    return found, vectors


def _per_cost(problem: Problem, optimum: Optimum) -> float:
    """How much the value changes for a change of the cost."""
    trial = problem.at(optimum.places)
    if not problem.is_rooted(trial):
        return 1.0
    return 1.0 / (2.0 * abs(trial.goals[0])) if abs(trial.goals[0]) > 1e-150 else math.inf

"""The work of a search at one point: from values to a row, and the residuals of its goal.

In: a `Trier`, which travels between processes, and points. Out: `Tried` rows: goals, then constraints. What a point
gives depends on nothing but the point. A point that makes no run is a row with its reason.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from lamc.basics.errors import BuildError, LamcError
from lamc.run.request import Array, Status
from lamc.run.result import Result
from lamc.studies.bench import (
    ERROR,
    FAILED,
    OK,
    REFUSED,
    UNDEFINED,
    Bench,
    Row,
    Subject,
    undefined_values,
    without_values,
)
from lamc.studies.goals import Constraint, Goal
from lamc.studies.gradient import gradient
from lamc.studies.space import Space
from lamc.studies.targets import Made, made

Words = tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Tried(Row):
    """residual: (m,), as of `Goal.of`; None where there is none."""

    residual: Array | None = None


@dataclass(frozen=True, eq=False)
class Trier:
    """subjects: by the words of choices."""

    subjects: Mapping[Words, Subject]
    space: Space
    goals: tuple[Goal, ...]
    constraints: tuple[Constraint, ...]
    _benches: dict[Words, Bench] = field(default_factory=dict)

    def __reduce__(self) -> tuple[object, ...]:
        return Trier, (dict(self.subjects), self.space, self.goals, self.constraints)

    def bench(self) -> "Trier":
        """As of `Subject`: what works on its points."""
        return self

    @property
    def width(self) -> int:
        """How many values a row has."""
        return len(self.goals) + len(self.constraints)

    def parted(self, point: tuple[float, ...]) -> tuple[Words, tuple[float, ...]]:
        """The words of a point, and its numbers."""
        both = list(zip(self.space.variables, point, strict=True))
        return (
            tuple(str(v.value_of(x)) for v, x in both if v.has_words),
            tuple(x for v, x in both if not v.has_words),
        )

    def result(self, point: tuple[float, ...]) -> Result:
        """The run of a point. Raises LamcError where there is none."""
        words, numbers = self.parted(point)
        bench = self._benches.setdefault(words, Bench(self.subjects[words]))
        return bench.result(numbers)

    def slopes(self, point: tuple[float, ...]) -> Array | None:
        """Derivatives (goals and constraints, variables) of the values of a point, by the numbers that are varied,
        SI, from its run backwards; None where there are none, as of functions of yours, and of what is no number of
        the model."""
        words, numbers = self.parted(point)
        bench = self._benches.setdefault(words, Bench(self.subjects[words]))
        targets = self.subjects[words].targets
        measures = [*(goal.measure for goal in self.goals), *(each.measure for each in self.constraints)]
        if any(target.kind == "option" for target in targets):
            return None
        found = np.zeros((len(measures), len(self.space.variables)))
        names, given = [target.name for target in targets], self.space.numbers(point)
        columns = [k for k, each in enumerate(self.space.variables) if not each.has_words]
        try:
            result = bench.result(numbers, taped=True)
            for row, measure in zip(found, measures, strict=True):
                if measure is None or measure.function is not None:
                    return None
                row[columns] = list(gradient(result, measure, names, given).values())
        except BuildError:
            raise
        except LamcError:
            return None
        return found if np.isfinite(found).all() else None

    def design(self, point: tuple[float, ...]) -> Made:
        """The design of a point."""
        words, numbers = self.parted(point)
        subject = self.subjects[words]
        own = zip(subject.targets, numbers, strict=True)
        return made(subject.design, {t.name: v for t, v in own if t.kind == "dimension"})

    def row(self, index: int, point: tuple[float, ...]) -> Tried:
        """Raises KeyboardInterrupt if the run is cancelled, and BuildError, as no other point would fare better."""
        row, residual = self._worked(index, point)
        words, numbers = self.parted(point)
        bench = self._benches.get(words)
        structure = "" if bench is None else bench.structure(numbers)
        return Tried(row.index, row.status, row.reason, row.values, structure, residual)

    def _worked(self, index: int, point: tuple[float, ...]) -> tuple[Row, Array | None]:
        try:
            result = self.result(point)
            if result.status == Status.CANCELLED:
                raise KeyboardInterrupt
            if not result.success:
                return without_values(index, FAILED, result.message, self.width), None
            given = self.space.numbers(point)
            found = [goal.of(result, given) for goal in self.goals]
            others = (each.measure.value(result, given) for each in self.constraints)
            values = (*(each[0] for each in found), *others)
        except BuildError:
            raise
        except LamcError as error:
            return without_values(index, REFUSED, error.message, self.width), None
        except Exception as error:  # of a function that the user gave; it shall not end the search
            return without_values(index, ERROR, f"{type(error).__name__}: {error}", self.width), None
        named = [
            *((goal.text, goal.times) for goal in self.goals),
            *((each.text, each.measure.times) for each in self.constraints),
        ]
        names, times = zip(*named, strict=True)
        undefined = undefined_values(names, values, times, result)
        residual = found[0][1]
        if not undefined and residual is not None and not np.isfinite(residual).all():
            undefined.append(f"{self.goals[0].text!r} has residuals that are not finite")
        residual = None if undefined else residual
        return Row(index, UNDEFINED if undefined else OK, ", ".join(undefined), values), residual


def renumbered(row: Row, index: int) -> Tried:
    """A row that was asked for under another number."""
    residual = row.residual if isinstance(row, Tried) else None
    return Tried(index, row.status, row.reason, row.values, row.structure, residual)

"""An optimisation as optimisers see it: numbers at places of the unit box, each run once and kept.

In: a space, goals, constraints, and what runs a point. Out: `Trial`s. A run that fails is a trial with its reason,
which costs more than all others; no trial is run twice, and a folder of trials is gone through without running any.
What a trial gives depends on nothing but its point. Never: decides where to go.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from threading import Thread

import numpy as np

from lamc.run.request import Array
from lamc.studies.bench import OK, Row
from lamc.studies.crew import Crew
from lamc.studies.goals import Constraint, Goal
from lamc.studies.space import Space
from lamc.studies.trier import renumbered

FEASIBLE = 1e-8  # of a constraint's own size: what is violated by less holds, as runs are not known better
_CEILING = 1e3  # of a value's own size: what trials cost that violate a constraint, or that make no run


class SpentError(Exception):
    """As many runs were made as were granted."""


@dataclass(frozen=True, eq=False)
class Trial:
    """What came of a point.

    cost        the first goal, as methods take it: its square where it is the root of squares
    violations  of constraints, each by its own size: above zero where it is violated; an equality's may be below
    residual    (m,) whose squares add up to the cost; None where none is known
    stage       what was going on
    structure   as of `Row`
    """

    index: int
    point: tuple[float, ...]
    status: str
    reason: str
    goals: tuple[float, ...]
    constraints: tuple[float, ...]
    residual: Array | None
    stage: str
    structure: str = ""

    @property
    def is_ok(self) -> bool:
        return self.status == OK


@dataclass(eq=False)
class Problem:
    """trials: all that were made, in their order."""

    space: Space
    goals: tuple[Goal, ...]
    constraints: tuple[Constraint, ...]
    work: Callable[[int, tuple[float, ...]], Row]  # a row of a number, of a point; as of `Trier.row`
    most: int  # runs
    crew: Callable[[], Crew | None] = lambda: None  # who else answers for points, once there is somebody
    found: dict[tuple[float, ...], Row] = field(default_factory=dict)  # what the crew has answered
    told: Callable[["Problem"], None] = lambda _: None
    keep: Callable[[Row], None] = lambda _: None
    known: dict[int, Row] = field(default_factory=dict)  # rows of a folder, by number
    trials: list[Trial] = field(default_factory=list)
    slopes_at: Callable[[tuple[float, ...]], Array | None] = lambda _: None  # as of `Trier.slopes`
    stage: str = ""
    size: float = 1.0  # of costs
    sizes: Array = field(init=False)  # of constraints
    _by_point: dict[tuple[float, ...], Trial] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.sizes = np.ones(len(self.constraints))

    @property
    def goal(self) -> Goal:
        return self.goals[0]

    @property
    def is_smooth_sum(self) -> bool:
        """Whether costs are sums of squares of residuals that are known."""
        return len(self.goals) == 1 and any(trial.residual is not None for trial in self.trials)

    def at(self, places: Array) -> Trial:
        """The trial at a place of the box. Raises SpentError; and BuildError, as no other would fare better."""
        point = self.space.point(places)
        found = self._by_point.get(point)
        if found is None:
            if len(self.trials) >= self.most:
                raise SpentError
            found = self._kept(point) or self._made(point)
            self.trials.append(found)
            self._by_point[point] = found
            self.told(self)
        return found

    def ahead(self, places: Iterable[Array]) -> None:
        """Lets the crew answer for places that will be asked for; without one nothing is done. Trials, and their order,
        are the same."""
        crew = self.crew()
        if crew is None:
            return
        points = dict.fromkeys(self.space.point(each) for each in places)
        new = [each for each in points if each not in self._by_point and each not in self.found]
        new = [each for k, each in enumerate(new) if not self._is_kept(len(self.trials) + k, each)]
        new = new[: max(self.most - len(self.trials), 0)]
        if len(new) > 1:
            self.found.update(zip(new, crew.rows(new), strict=True))

    def side_by_side(self, works: Sequence[Callable[["Problem"], object]]) -> None:
        """Lets the crew go through works of this problem, all at a time, each in a copy of its own; what they come to
        is not looked at, but the points that they ask for are answered when this problem is asked for them."""
        crew = self.crew()
        if crew is None or len(works) < 2:
            return
        threads = [Thread(target=_gone_through, args=(work, self._copy(crew)), daemon=True) for work in works]
        try:
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        except KeyboardInterrupt:
            crew.stop()  # which lets go of the threads
            raise

    def _copy(self, crew: Crew) -> "Problem":
        """One that asks a crew, and keeps what it answers where this one finds it."""

        def work(_index: int, point: tuple[float, ...]) -> Row:
            (self.found[point],) = crew.rows([point])
            return self.found[point]

        made = replace(self, work=work, told=lambda _: None, keep=lambda _: None, trials=list(self.trials))
        made._by_point, made.sizes = dict(self._by_point), self.sizes
        return made

    def _made(self, point: tuple[float, ...]) -> Trial:
        index = len(self.trials)
        row = renumbered(self.found.get(point) or self.work(index, point), index)
        there = self.known.get(row.index)
        if there is None or there.values[: len(point)] != point:
            self.keep(replace(row, values=(*point, *row.values)))
        return self._trial(row, point, row.residual)

    def _is_kept(self, index: int, point: tuple[float, ...]) -> bool:
        """Whether the folder has what a trial comes to; what has residuals is run again."""
        row = self.known.get(index)
        has_residual = len(self.goals) == 1 and self._has_residual()
        return row is not None and row.values[: len(point)] == point and not has_residual

    def _kept(self, point: tuple[float, ...]) -> Trial | None:
        """From the folder, where the same was tried as the same one."""
        index = len(self.trials)
        if not self._is_kept(index, point):
            return None
        row = self.known[index]
        return self._trial(replace(row, values=row.values[len(point) :]), point, None)

    def _has_residual(self) -> bool:
        return self.goal.is_squares or self.goal.function is not None

    def _trial(self, row: Row, point: tuple[float, ...], residual: Array | None) -> Trial:
        split = len(self.goals)
        return Trial(
            len(self.trials),
            point,
            row.status,
            row.reason,
            row.values[:split],
            row.values[split:],
            residual,
            self.stage,
            row.structure,
        )

    def settle_sizes(self) -> None:
        """Takes the sizes of costs and constraints from the trials that there are."""
        good = [trial for trial in self.trials if trial.is_ok]
        costs = np.array([self.cost(trial) for trial in good])
        spread = float(np.ptp(costs)) if len(costs) else 0.0
        self.size = max(spread, float(np.median(np.abs(costs))) if len(costs) else 0.0) or 1.0
        values = np.array([trial.constraints for trial in good]).reshape(len(good), len(self.constraints))
        largest = np.max(np.abs(values), axis=0, initial=0.0)
        self.sizes = np.where(largest > 0.0, largest, 1.0)

    def cost(self, trial: Trial) -> float:
        """What methods make small; NaN of a trial that is not ok."""
        if not trial.is_ok:
            return math.nan
        value = trial.goals[0]
        return value * value if self.is_rooted(trial) else value

    def is_rooted(self, trial: Trial) -> bool:
        return self.goal.is_root or (self.goal.function is not None and trial.residual is not None)

    def violations(self, trial: Trial) -> Array:
        """(constraints,), by their sizes: above zero where violated; those of equalities either way."""
        return np.array(trial.constraints) / self.sizes

    def violation(self, trial: Trial) -> float:
        """In all; 0 where every constraint holds."""
        return math.fsum(
            (abs(v) if c.is_equal else max(v, 0.0))
            for c, v in zip(self.constraints, self.violations(trial).tolist(), strict=True)
        )

    def is_feasible(self, trial: Trial) -> bool:
        return trial.is_ok and self.violation(trial) <= FEASIBLE * max(len(self.constraints), 1)

    def merit(self, trial: Trial) -> float:
        """A number to compare any two trials by, of order one: costs where constraints hold, then violations, then what
        made no run (Deb 2000, Comput. Methods Appl. Mech. Eng. 186, 311-338)."""
        if not trial.is_ok:
            return _CEILING * _CEILING
        if self.is_feasible(trial):
            return min(self.cost(trial) / self.size, _CEILING)
        return _CEILING * (1.0 + min(self.violation(trial), _CEILING / 2.0))

    def best(self) -> Trial | None:
        """The best trial that made a run; the first of equal ones."""
        good = [trial for trial in self.trials if trial.is_ok]
        return min(good, key=self.merit, default=None)

    def reasons(self) -> str:
        """Why trials made no run, the most frequent first."""
        counts = Counter((trial.status, trial.reason) for trial in self.trials if not trial.is_ok)
        return "; ".join(f"{status} ({count}): {reason}" for (status, reason), count in counts.most_common(2))


def _gone_through(work: Callable[[Problem], object], problem: Problem) -> None:
    """To its end, or to where it fails, which the problem itself will meet too."""
    with suppress(Exception):
        work(problem)

"""How a search goes: where it starts, what goes downhill from there, when it looks again.

In: a problem and a start. Out: a `Best`. It sequences methods, the last digits and the verdict; none of them is here.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from lamc.run.request import Array
from lamc.studies.derivatives import MANY
from lamc.studies.goals import Goal
from lamc.studies.optimum import Best, active_of, curvature_of, known_of, moves_of
from lamc.studies.problem import Problem, SpentError, Trial
from lamc.studies.refinement import Optimum, refined
from lamc.studies.trier import Trier
from lamc.studies.verdict import Verdict, verdict_of, verdict_of_many

METHODS: Mapping[str, bool] = {  # whether it takes whole numbers and choices
    "least-squares": False,
    "slsqp": False,
    "trust-constr": False,
    "nelder-mead": False,
    "evolution": True,
    "cma-es": True,
    "nsga2": True,
}
_LOOKED = 4  # points of a Latin hypercube for each start, of which the best are taken
_MORE = 60  # points that are tried where no run went well
_AGAIN = 4  # times that a lower point beside an optimum is gone on from
_SAME = 5e-3  # of a range: ends of two starts that are one optimum, as methods end before the last digits


def default_method(goal: Goal, *, has_levels: bool, is_subject: bool) -> str:
    """The method for a goal. is_subject: whether squares are of no use: there are constraints, or more numbers than
    Jacobians of residuals, which take a run for each, can be had for."""
    if has_levels:
        return "evolution"
    return "least-squares" if (goal.is_squares or goal.function is not None) and not is_subject else "slsqp"


@dataclass(frozen=True)
class Strategy:
    """method: of `METHODS`; starts: how many; seed: of all that is drawn."""

    method: str = "slsqp"
    starts: int = 5
    seed: int = 0

    def best(self, problem: Problem, start: Array, trier: Trier) -> Best | None:
        """The best that is found before runs are spent, or the user stops it; None if no run went well."""
        walk = _Walk(self, problem, start)
        stopped = ""
        try:
            walk.through()
        except SpentError:
            stopped = f"it was ended after {problem.most} runs; grant more, --max-runs (max_runs=…)"
        except KeyboardInterrupt:
            stopped = "interrupted"
        best = problem.best()
        if best is None:
            return None
        optimum, verdict = walk.optimum, walk.verdict
        if stopped or verdict is None:
            verdict, optimum = Verdict(False, stopped), None
        return self._optimum_of(problem, optimum, verdict, best, walk, trier)

    def _optimum_of(
        self,
        problem: Problem,
        optimum: Optimum | None,
        verdict: Verdict,
        best: Trial,
        walk: "_Walk",
        trier: Trier,
    ) -> Best:
        at = verdict.lower or (problem.at(optimum.places) if optimum is not None else best)
        if walk.front is not None and walk.chosen is not None:
            at = problem.trials[walk.chosen]
        is_known = optimum is not None and verdict.lower is None and problem.is_feasible(at)
        multipliers, active = active_of(problem, optimum) if is_known and optimum else ({}, ())
        curvature, directions = curvature_of(problem, optimum) if is_known and optimum else (np.zeros(0),) * 2
        return Best(
            parameters=problem.space.values_at(at.point),
            value=at.goals[0],
            values=at.goals,
            unit=problem.goal.unit,
            converged=verdict.converged,
            message=verdict.message,
            active=active,
            multipliers=multipliers,
            moves=moves_of(problem, optimum) if is_known and optimum else {},
            known_to=known_of(problem, optimum) if is_known and optimum else {},
            curvature=curvature,
            directions=directions,
            names=tuple(problem.space.names[k] for k in problem.space.real),
            units={each.name: each.unit for each in problem.space.variables},
            constraints={c.text: v for c, v in zip(problem.constraints, at.constraints, strict=True)},
            problem=problem,
            trier=trier,
            point=at.point,
            method=self.method,
            interrupted=verdict.message == "interrupted",
            on_front=walk.front,
        )


class _Walk:
    """What a search has come to."""

    def __init__(self, strategy: Strategy, problem: Problem, start: Array) -> None:
        self.strategy, self.problem, self.start = strategy, problem, start
        self.optimum: Optimum | None = None
        self.verdict: Verdict | None = None
        self.front: tuple[int, ...] | None = None
        self.chosen: int | None = None

    def through(self) -> None:
        """All of it. Raises SpentError, and KeyboardInterrupt."""
        problem, strategy = self.problem, self.strategy
        starts = self._starts()
        if not starts:
            return
        if strategy.method == "nsga2":
            self._along_front(starts[0])
            return
        ends = self._ends(starts)
        at = min(ends, key=lambda places: problem.merit(problem.at(places)))
        for _ in range(_AGAIN):
            self._settle(at)
            assert self.verdict is not None
            if self.verdict.lower is None:
                break
            problem.stage = "again, from a lower point beside it"
            at = self._downhill(problem.space.places(self.verdict.lower.point))
        self._say_how_many(ends)

    def _starts(self) -> list[Array]:
        """The start, and the best of a Latin hypercube; the best alone where the start makes no run."""
        from scipy.stats import qmc  # a third of a second

        problem, strategy = self.problem, self.strategy
        problem.stage = "start"
        problem.at(self.start)
        problem.stage = "look around"
        cube = qmc.LatinHypercube(len(self.start), rng=np.random.default_rng(strategy.seed))
        looked = [np.asarray(each) for each in cube.random(_LOOKED * strategy.starts)]
        problem.ahead(looked)
        for each in looked:
            problem.at(each)
        if problem.best() is None:
            looked += [np.asarray(each) for each in cube.random(_MORE)]
            problem.ahead(looked)
            for each in looked:
                problem.at(each)
        problem.settle_sizes()
        good = sorted(
            (each for each in looked if problem.at(each).is_ok),
            key=lambda each: problem.merit(problem.at(each)),
        )
        first = [self.start] if problem.at(self.start).is_ok else []
        return (first + good)[: strategy.starts] if problem.best() is not None else []

    def _ends(self, starts: list[Array]) -> list[Array]:
        """Where the method leads from each start; evolution, from one."""
        from lamc.studies.optimisers.evolution import cma_es, differential_evolution

        problem, strategy = self.problem, self.strategy
        if strategy.method in ("evolution", "cma-es"):
            problem.stage = strategy.method
            search = differential_evolution if strategy.method == "evolution" else cma_es
            best = min(starts, key=lambda each: problem.merit(problem.at(each)))
            found = search(problem, best, strategy.seed)
            problem.stage = "downhill"
            return [self._downhill(found)]
        problem.side_by_side([partial(self._downhill, start) for start in starts])
        ends = []
        for k, start in enumerate(starts):
            problem.stage = f"start {k + 1}"
            ends.append(self._downhill(start))
        return ends

    def _downhill(self, start: Array, problem: Problem | None = None) -> Array:
        """Where a method for real numbers leads; of searches in the whole box, that which suits the goal. problem:
        another than its own."""
        from lamc.studies.optimisers import local

        problem = problem or self.problem
        if not len(problem.space.real):
            return start
        method = self.strategy.method
        if METHODS[method]:
            is_subject = bool(problem.constraints) or len(problem.space.real) > MANY
            method = default_method(problem.goal, has_levels=False, is_subject=is_subject)
        ways = {
            "least-squares": local.least_squares,
            "slsqp": local.slsqp,
            "trust-constr": local.trust_constr,
            "nelder-mead": local.nelder_mead,
        }
        return ways[method](problem, start)

    def _settle(self, at: Array) -> None:
        """The last digits, and the verdict on them."""
        from lamc.studies.optimisers.local import nelder_mead

        problem = self.problem
        if len(problem.space.real) > MANY:
            self.optimum, self.verdict = None, verdict_of_many(problem, at)
            return
        problem.stage = "last digits"
        optimum = refined(problem, at)
        if not optimum.is_settled and len(problem.space.real):
            problem.stage = "last digits, without slopes"
            closer = nelder_mead(problem, optimum.places)
            if problem.merit(problem.at(closer)) < problem.merit(problem.at(optimum.places)):
                optimum = refined(problem, closer)
        problem.stage = "look beside"
        self.optimum, self.verdict = optimum, verdict_of(problem, optimum)

    def _say_how_many(self, ends: list[Array]) -> None:
        assert self.verdict is not None
        if self.optimum is None or len(ends) < 2 or self.verdict.lower is not None:
            return
        near = sum(bool(np.max(np.abs(end - self.optimum.places)) <= _SAME) for end in ends)
        told = f"{self.verdict.message}; {near} of {len(ends)} starts came to it"
        self.verdict = Verdict(self.verdict.converged, told)

    def _along_front(self, start: Array) -> None:
        from lamc.studies.optimisers.fronts import front_of, knee

        self.problem.stage = "nsga2"
        found, is_still = front_of(self.problem, start, self.strategy.seed)
        if not found:
            self.verdict = Verdict(False, "no point was found that keeps to the constraints")
            return
        self.front, self.chosen = tuple(found), knee(self.problem, found)
        told = f"a front of {len(found)} points; told is the one nearest to the least of all goals"
        moving = "" if is_still else "; it still moved when it ended: grant more runs, or take it as it is"
        self.verdict = Verdict(is_still, told + moving)

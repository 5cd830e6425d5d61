"""A plate ready to be solved, again and again.

In: a problem. Out: solutions for its loads, for other loads at the price of a re-solve, and for other laminates at the
price of new values in the same pattern. Never: formulas; the rooms below have them.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from lamc.basics.checks import Array, checked_kind, shown
from lamc.basics.errors import DesignError, LamcError
from lamc.basics.readonly import ReadOnlyDict
from lamc.plates.answers.shear_share import shear_notes
from lamc.plates.answers.solution import Solution, SolveReport
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.loads import LOADS, LoadRecord
from lamc.plates.problem import Problem, check_load, checked_kinds
from lamc.plates.solving.advice import notes
from lamc.plates.solving.idle import idle
from lamc.plates.solving.load_vectors import load_vector
from lamc.plates.solving.refine import Deformed
from lamc.plates.solving.refine import solve as refined
from lamc.plates.solving.rigid import check_balance, free_text, without_rigid
from lamc.plates.solving.system import System, system


class FactoredPlate:
    """A problem assembled; it is factored when it is first solved, and only then.

    solver  "auto" (CHOLMOD if scikit-sparse is there with a fast BLAS, else SuperLU), "cholmod", "superlu", "pardiso"
    refine  True: refined until the digits are right; False: one solution in plain double precision

    Raises DesignError where supports contradict each other, UnsupportedError for a solver that is not installed.
    """

    def __init__(self, problem: Problem, solver: str = "auto", *, refine: bool = True) -> None:
        checked_kind(problem, Problem, "the problem", "make one of a mesh and a laminate")
        self.system: System = system(problem, solver)
        self.refine = refine

    @property
    def problem(self) -> Problem:
        return self.system.problem

    def solve(self, loads: Sequence[LoadRecord] | None = None, case: str = "") -> Solution:
        """Under `loads`; None: those of the problem that act in every case. `case` is a name, which errors tell.

        Raises DesignError for a load that touches nothing, and where a piece is not held and the loads on it are not in
        balance; SimulationError where the matrix is too badly conditioned.
        """
        with _named(case):
            return self._solve(loads)

    def _solve(self, loads: Sequence[LoadRecord] | None) -> Solution:
        acting = (
            tuple(self.problem.loads)
            if loads is None
            else checked_kinds(loads, LOADS, "loads of a FactoredPlate")
        )
        if loads is not None:
            for load in acting:
                check_load(self.problem, load)
        outer = load_vector(self.problem, self.system.kernels, acting)
        check_balance(self.system.pieces, outer, self.problem.dofs)
        held = self.system.constraints
        deformed = refined(self.system, outer, held.fixed.T @ held.values, refine=self.refine)
        return self._solution(acting, outer, deformed)

    def solve_case(self, name: str) -> Solution:
        """The case of that name, with what acts in every case. Raises as `solve` does, and names the case."""
        if name not in self.problem.cases:
            known = ", ".join(map(repr, self.problem.cases)) or "none"
            raise DesignError(f"the problem has no case {shown(name)}; it has {known}")
        return self.solve((*self.problem.loads, *self.problem.cases[name]), name)

    def solve_cases(self) -> ReadOnlyDict[str, Solution]:
        """All cases of the problem by name. Raises for the first that cannot be solved; `solve_case` gives others."""
        return ReadOnlyDict({name: self.solve_case(name) for name in self.problem.cases})

    def with_laminates(self, laminate: Laminate | Mapping[str, Laminate]) -> "FactoredPlate":
        """The same plate of other laminates: values are assembled anew, in the same pattern and ordering.

        Raises DesignError where they call for another element (a membrane where there was none).
        """
        other = object.__new__(FactoredPlate)
        other.system = self.system.with_problem(self.problem.with_laminate(laminate))
        other.refine = self.refine
        return other

    def _solution(self, loads: tuple[LoadRecord, ...], outer: Array, deformed: Deformed) -> Solution:
        d = deformed.d
        for piece in self.system.pieces:
            if piece.names:
                d = without_rigid(d, piece, self.problem.dofs)
        report = SolveReport(
            self.system.solver,
            self.problem.dofs.count,
            deformed.accuracy,
            free_text(self.system.pieces),
            (
                *self.problem.remarks,
                *notes(self.problem, loads, deformed.accuracy),
                *idle(self.system, loads),
            ),
        )
        values = np.asarray(d, dtype=float)
        found = Solution(self.problem, loads, values, report, self.system, d, deformed.inner, outer)
        reported = replace(report, notes=(*report.notes, *shear_notes(found)))
        return replace(found, report=reported)


@contextmanager
def _named(case: str) -> Iterator[None]:
    """LamcErrors of the block name the case."""
    try:
        yield
    except LamcError as error:
        if not case:
            raise
        reported = type(error)(f"case {case!r}: {error.message}", error.place)
        reported.subject = error.subject
        raise reported from error


def solve(
    problem: Problem, solver: str = "auto", *, refine: bool = True
) -> Solution | ReadOnlyDict[str, Solution]:
    """The solution of `problem`; a dict of solutions by name where it has cases. See `FactoredPlate`."""
    model = FactoredPlate(problem, solver, refine=refine)
    return model.solve_cases() if problem.cases else model.solve()

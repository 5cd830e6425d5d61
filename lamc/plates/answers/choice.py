"""Which element a plate needs: with shear through the thickness, or without.

In: a problem. Out: the name of an element, and why. Never: a thickness over a span; the plate is solved without
shear, and `shear_share.py` tells what that leaves out.
"""

import math
from dataclasses import dataclass, replace

from lamc.basics.errors import DesignError
from lamc.plates.answers.model import FactoredPlate
from lamc.plates.answers.shear_share import shear_share
from lamc.plates.answers.solution import Solution
from lamc.plates.loads import Pressure
from lamc.plates.problem import Problem

THIN, THICK = "dkt", "dkmt"
# Of the deflection. Less is reported, and no reason to go without gradients and exports, which shear does without so
# far.
TAKEN = 0.02


@dataclass(frozen=True)
class Choice:
    """An element and why.

    element  a name, to be given to a `Problem`
    share    energy of shear over that of bending, as classical theory finds it: the largest of all cases; inf across a
             gap, nan where nothing tells
    why      a sentence
    """

    element: str
    share: float
    why: str


def choose_element(problem: Problem, *, waves: int = 1) -> Choice:
    """For `problem`, whatever its own element: "dkmt" where shear adds 2 % or more to the deflection of a case, else
    "dkt". Without loads that bend it, it is asked under a uniform pressure.

    waves  how many modes or buckling shapes are wanted: the squares of their waves grow as their numbers (H. Weyl), and
           so does their shear

    Raises DesignError for a mesh of quadrilaterals, and as solving does.
    """
    if problem.mesh.corner_count != 3:
        raise DesignError(
            "an element is chosen for a mesh of quadrilaterals, and the one with shear through the thickness is a "
            "triangle; mesh with triangles, or name an element"
        )
    if any(ply.gap > 0.0 for laminate in problem.laminates for ply in laminate.plies):
        return Choice(THIN, math.inf, f"element {THIN!r} was taken: nothing bears shear in a gap")
    plain = replace(problem, element=THIN)
    found = _solved(plain)
    how = ""
    if not any(_bends(solution) for solution in found):
        how = " under a uniform pressure"
        try:
            found = _solved(replace(plain, loads=[Pressure(1.0)], cases={}))
        except DesignError:  # it is free to move
            return Choice(
                THICK,
                math.nan,
                f"element {THICK!r} was taken: no load tells how the plate bends, and it suits thin ones too",
            )
    share = max(map(shear_share, found)) * max(waves, 1)
    thick = share >= TAKEN
    name, sign = (THICK, "at least") if thick else (THIN, "less than")
    return Choice(
        name,
        share,
        f"element {name!r} was taken: shear through the thickness adds about {100.0 * share:.2g} % to the "
        f"deflection{how}{' of the last shape' if waves > 1 else ''}, {sign} {100.0 * TAKEN:g} %",
    )


def _solved(problem: Problem) -> list[Solution]:
    model = FactoredPlate(problem)
    return list(model.solve_cases().values()) if problem.cases else [model.solve()]


def _bends(solution: Solution) -> bool:
    return bool(solution.problem.dofs.element.bends and solution.at_nodes("w").any())

"""What accuracy costs: one answer on finer and finer meshes, with the order that is seen and the time that it takes.

In: a problem, or a function that makes one for a cell size, and the number that is asked for. Out: a table, and the
number that it tends to. Never: solves anything by itself.

Source: L. F. Richardson, J. A. Gaunt, The deferred approach to the limit, Phil. Trans. R. Soc. A 226, 1927; observed
order from three meshes as in P. J. Roache, J. Fluids Engng 116, 1994.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeVar, overload

import numpy as np
from scipy.optimize import brentq

from lamc.basics.checks import checked_number
from lamc.basics.errors import DesignError
from lamc.plates.answers.model import solve
from lamc.plates.answers.solution import Solution
from lamc.plates.meshing.changes import refined
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.problem import Problem
from lamc.plates.solving.curves import curve_nodes
from lamc.plates.supports import BOUNDARY

Answer = TypeVar("Answer")

# What every element here has at least, in deflections, where the solution is smooth.
ORDER = 2.0
# Between these an observed order is believed; outside, the meshes are too coarse for one to show.
_CREDIBLE = (0.5, 6.0)


@dataclass(frozen=True)
class ConvergenceRow:
    """One mesh."""

    size: float  # m, as asked for; or the longest edge
    unknowns: int
    value: float
    change: float  # from the row before; nan in the first
    order: float  # seen in this row and the two before; nan where there is none to see
    seconds: float  # to mesh, assemble, solve and evaluate


@dataclass(frozen=True)
class Convergence:
    """Rows from coarse to fine.

    extrapolated  what the values tend to: the last two with the order last seen, or 2 where none was
    error         of the last value, by the same: an estimate, no bound
    note          what the error leaves out; "" for nothing that is known
    """

    rows: tuple[ConvergenceRow, ...]
    extrapolated: float
    error: float
    note: str = ""

    def __str__(self) -> str:
        head = f"{'size, m':>12} {'unknowns':>9} {'value':>16} {'change':>11} {'order':>6} {'time, s':>8}"
        lines = [
            f"{r.size:12.5g} {r.unknowns:9d} {r.value:16.9g} {_or_blank(r.change, '11.3g')} "
            f"{_or_blank(r.order, '6.2f')} {r.seconds:8.3f}"
            for r in self.rows
        ]
        lines += [f"tends to {self.extrapolated:.9g}; the last is {self.error:.2g} off"]
        return "\n".join([head, *lines, *([self.note] if self.note else [])])


@overload
def converge(
    problem: Problem | Callable[[float], Problem],
    quantity: Callable[[Solution], float],
    sizes: Sequence[float] = (),
    *,
    meshes: int = 3,
) -> Convergence: ...
@overload
def converge(
    problem: Problem | Callable[[float], Problem],
    quantity: Callable[[Answer], float],
    sizes: Sequence[float] = (),
    *,
    answer: Callable[[Problem], Answer],
    meshes: int = 3,
) -> Convergence: ...
def converge(
    problem: Problem | Callable[[float], Problem],
    quantity: Callable[[Answer], float],
    sizes: Sequence[float] = (),
    *,
    answer: Callable[[Problem], Answer] = solve,  # type: ignore[assignment]  # Answer is Solution without it
    meshes: int = 3,
) -> Convergence:
    """`quantity(answer(problem))` on several meshes, such as quantity=lambda solution: solution.deflection(x, y), or
    quantity=lambda modes: modes.omega[0] with answer=plate.modes.

    problem   a function of the cell size, called for each of `sizes`, m, descending; or one problem, which is solved
              on its own mesh and on `meshes` - 1 refinements of it
    Raises DesignError for fewer than two meshes, for sizes that do not descend, and for a value that is not finite.
    """
    note = ""
    if isinstance(problem, Problem):
        makers, note = _refinements(problem, meshes), kept_corners_text(problem)
    else:
        checked = _checked_sizes(sizes)
        makers = [(size, lambda size=size: problem(size)) for size in checked]  # type: ignore[misc]
    rows: list[ConvergenceRow] = []
    for size, make in makers:
        start = time.perf_counter()
        one = make()
        value = checked_number(quantity(answer(one)), "the quantity that convergence is asked of")
        seconds = time.perf_counter() - start
        unknowns = one.dofs.count
        before = [(r.size, r.value) for r in rows[-2:]]
        change = value - before[-1][1] if before else math.nan
        rows.append(
            ConvergenceRow(size, unknowns, value, change, observed_order([*before, (size, value)]), seconds)
        )
    (h1, v1), (h2, v2) = ((r.size, r.value) for r in rows[-2:])
    order = rows[-1].order if math.isfinite(rows[-1].order) else ORDER
    extrapolated = v2 + (v2 - v1) / ((h1 / h2) ** order - 1.0)
    return Convergence(tuple(rows), extrapolated, abs(extrapolated - v2), note)


@dataclass(frozen=True)
class QuantityError:
    """Of one number: `value` on the mesh given, `finer` on halved cells, and what both tend to with second order; in
    `note` what the error leaves out, "" for nothing that is known."""

    value: float
    finer: float
    extrapolated: float
    note: str = ""

    @property
    def error(self) -> float:
        """Of `value`, estimated."""
        return abs(self.extrapolated - self.value)


@overload
def error_of(problem: Problem, quantity: Callable[[Solution], float]) -> QuantityError: ...
@overload
def error_of(
    problem: Problem, quantity: Callable[[Answer], float], *, answer: Callable[[Problem], Answer]
) -> QuantityError: ...
def error_of(
    problem: Problem,
    quantity: Callable[[Answer], float],
    *,
    answer: Callable[[Problem], Answer] = solve,  # type: ignore[assignment]  # Answer is Solution without it
) -> QuantityError:
    """How far off `quantity(answer(problem))` is, by one more answer on halved cells: four times the unknowns.

    Raises DesignError for a value that is not finite.
    """
    found = converge(problem, quantity, answer=answer, meshes=2)
    return QuantityError(found.rows[0].value, found.rows[1].value, found.extrapolated, found.note)


def halved(problem: Problem) -> Problem:
    """The same problem on halved cells: four times as many."""
    return replace(problem, mesh=refined(problem.mesh))


def kept_corners_text(problem: Problem) -> str:
    """A sentence where the plate's outline has curves, which are polygons on the mesh and on halved cells; else ""."""
    if not len(curve_nodes(problem.places, [BOUNDARY]).nodes):
        return ""
    return (
        "the plate has curved edges, drawn as polygons of which finer cells keep the corners: the error does not know "
        "by how much these polygons differ from the curves; compare with a drawing of twice as many corners"
    )


def error_of_values(value: float, finer: float) -> QuantityError:
    """From a value on a mesh and on that of halved cells, with second order."""
    return QuantityError(value, finer, finer + (finer - value) / (2.0**ORDER - 1.0))


def observed_order(points: Sequence[tuple[float, float]]) -> float:
    """The p of v = v₀ + c hᵖ through three (h, v), h descending; nan where none between 0.5 and 6 fits."""
    if len(points) < 3:
        return math.nan
    (h1, v1), (h2, v2), (h3, v3) = points[-3:]

    def miss(p: float) -> float:
        middle, fine = (h2 / h1) ** p, (h3 / h1) ** p
        return float((v1 - v2) * (middle - fine) - (v2 - v3) * (1.0 - middle))

    if not miss(_CREDIBLE[0]) * miss(_CREDIBLE[1]) < 0.0:
        return math.nan
    return float(brentq(miss, *_CREDIBLE))


def longest_edge(mesh: Mesh) -> float:
    """Of all cells, m."""
    ends = mesh.points[mesh.edges]
    return float(np.hypot(*(ends[:, 1] - ends[:, 0]).T).max())


def _refinements(problem: Problem, meshes: int) -> list[tuple[float, Callable[[], Problem]]]:
    if meshes < 2:
        raise DesignError(f"convergence is asked for on {meshes} meshes; it takes two at least")
    size = longest_edge(problem.mesh)

    def at(level: int) -> Problem:
        mesh = problem.mesh
        for _ in range(level):
            mesh = refined(mesh)
        return replace(problem, mesh=mesh)

    return [(size / 2**level, lambda level=level: at(level)) for level in range(meshes)]  # type: ignore[misc]


def _checked_sizes(sizes: Sequence[float]) -> list[float]:
    checked = [checked_number(size, "a cell size of the convergence study") for size in sizes]
    if len(checked) < 2 or any(b >= a for a, b in pairwise(checked)) or checked[-1] <= 0.0:
        raise DesignError(
            f"the cell sizes of a convergence study are {checked}; give two or more, positive, from coarse to fine"
        )
    return checked


def _or_blank(value: float, form: str) -> str:
    return " " * int(form.split(".")[0]) if math.isnan(value) else format(value, form)

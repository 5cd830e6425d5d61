"""How far off frequencies and critical loads are: an estimate with every one, from the shape that belongs to it.

In: shapes, and what energy each stores. Out: relative errors, notes, where the error is. Never: solves; a bound.

λ of K φ = λ M φ is off by the energy of its shape's error over that of the shape (G. Strang, G. J. Fix, An Analysis of
the Finite Element Method, 1973, section 6.3), which `estimate.py` takes from recovered strains, as for a solution. That
sum has no sign: elements that are too soft in one part of the energy and too stiff in another, such as dkt where edges
are free, are better than it says, by a factor of ten at times; those that converge to another plate, such as bciz on
most meshes, are off by that besides. Measured (tests/plates/test_plate_shape_errors.py): between a third and three
times of the truth for plates held all around and for narrow strips between stiff parts.
"""

from dataclasses import dataclass

import numpy as np

from lamc.basics.checks import Array
from lamc.plates.answers.estimate import error_estimate
from lamc.plates.answers.solution import Solution, SolveReport
from lamc.plates.solving.refine import Accuracy
from lamc.plates.solving.system import System

REPORTED = 0.02  # relative error from which a note tells it: what a reader of three digits would mind
_WHOLE = SolveReport("", 0, Accuracy(1.0, 0, 0.0, 0.0), "", ())  # nothing was solved


@dataclass(frozen=True)
class ShapeError:
    """Of one shape: `energy` of its error over its own, and the region that most of it is in."""

    energy: float
    region: str


def solution_of(system: System, vector: Array) -> Solution:
    """Unknowns (N,) as what a plate does that nothing pushes: strains, moments and energy of a shape."""
    exact = vector.astype(np.longdouble)
    inner = system.inner_forces(exact)
    return Solution(system.problem, (), vector, _WHOLE, system, exact, inner, np.asarray(inner, dtype=float))


def shape_error(shape: Solution) -> ShapeError:
    """Of a shape from `solution_of`; its energy counts elastic hinges, which have no error of their own."""
    found = error_estimate(shape)
    stored = float(0.5 * shape.compliance)
    if not found.energy > 0.0:
        return ShapeError(0.0, found.worst_region)
    return ShapeError(found.energy / (found.energy + max(stored, 0.0)), found.worst_region)


def notes_of(what: str, errors: Array, regions: tuple[str, ...]) -> tuple[str, ...]:
    """A sentence for each of the numbered that may be off by more than `REPORTED`; `what` is one of them."""
    several = len(set(regions)) > 1 or any(regions)
    return tuple(
        f"{what} {k + 1} may be {100.0 * error:.2g} % off on this mesh"
        + (
            f", most of it in region {region or 'the rest'!r}: give it smaller cells"
            if several
            else ": mesh finer"
        )
        for k, (error, region) in enumerate(zip(errors, regions, strict=True))
        if error > REPORTED
    )

"""Linear buckling: by what factor membrane forces have to grow until the flat plate is no longer the only equilibrium.

In: a problem, and membrane forces: given, or those that its loads make. Out: factors and shapes. Never: what the plate
does after it has buckled; deflection before it, which is taken to be too small to matter.

(K + λ G(N)) φ = 0, with K of bending (and of stretching, where a laminate couples them) and φᵀ G(N) φ = ∫ ∇w · N ∇w dA,
tension positive. Source: J. N. Reddy, Mechanics of Laminated Composite Plates and Shells, 2nd ed. 2004, section 3.7.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sparse

from lamc.basics.brief import brief
from lamc.basics.checks import Array, checked_array, shown
from lamc.basics.errors import DesignError
from lamc.basics.once import lazy
from lamc.plates.answers.eigen import NEGLIGIBLE, pinned, stability
from lamc.plates.answers.model import FactoredPlate
from lamc.plates.answers.pencil import check_problem, pencil
from lamc.plates.answers.shape_errors import ShapeError, notes_of, shape_error, solution_of
from lamc.plates.answers.shapes import Shapes
from lamc.plates.answers.shear_share import shape_notes
from lamc.plates.answers.solution import Solution
from lamc.plates.offsets import offset_texts
from lamc.plates.problem import Problem
from lamc.plates.solving.advice import polygon_texts
from lamc.plates.solving.system import System, system

# Forces of this size, over the largest, are round-off of the solution that they come from.
_NO_FORCE = 1e-9
# Norm of what recovery changes of forces, over theirs: 0.03 for a plate that is held at one edge and pushed at another,
# on eight cells a side; 0.91 to 0.98 for forces that are all the mesh's.
_STRANGE = 0.3


@dataclass(frozen=True, eq=False)
class Buckling(Shapes):
    """Factors by which the membrane forces are multiplied, and shapes with 1 m as their largest deflection.

    factors   (k,) positive ones, ascending, then
    reversed  negative ones, descending: the loads turned round
    forces    (cells, 3) N_x, N_y, N_xy that they multiply, N/m, tension positive
    given     whether these were given, and not made by loads
    vectors   (unknowns, k + reversed), in the order of `factors`, then of `reversed`
    errors    (k + reversed,) in that order: estimate of how far off each is, relative, by `shape_errors.py`, and by
              recovered membrane forces where loads make these; found when asked for
    notes     a sentence for each factor that may be more than 2 % off
    """

    factors: Array
    reversed: Array
    forces: Array
    given: bool

    def __repr__(self) -> str:
        found = ", ".join(f"{f:.4g}" for f in self.factors[:6]) + (", …" if len(self.factors) > 6 else "")
        return brief("Buckling", "", f"factors {found}" if len(self.factors) else "no positive factor")

    @property
    def critical(self) -> float:
        """The least positive factor; inf where these forces do not buckle the plate, as far as told: see `is_open`."""
        return float(self.factors[0]) if len(self.factors) else float("inf")

    @property
    def told_to(self) -> float:
        """Factors beyond this cannot be told from round-off of those of the reversed forces; infinite without such."""
        return float(-self.reversed[0] / NEGLIGIBLE) if len(self.reversed) else float("inf")

    @property
    def is_open(self) -> bool:
        """Whether no factor was found, and one may be there, beyond `told_to`: some of the plate is pressed."""
        return not len(self.factors) and math.isfinite(self.told_to) and _can_buckle(self.forces)

    @property
    def errors(self) -> Array:
        """Of each factor, then of each of `reversed`, relative: an estimate, no bound."""
        return np.array([found.energy for found in self._found])

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader of these factors should know."""
        regions = tuple(found.region for found in self._found)
        count = len(self.factors)
        beyond = (
            f"these forces press the plate somewhere: a buckling factor above {self.told_to:.3g} may be there, which "
            f"cannot be told from round-off, as the reversed forces buckle it at {-self.reversed[0]:.3g}"
            if self.is_open
            else None
        )
        return (
            *([beyond] if beyond else []),
            *notes_of("buckling factor", self.errors[:count], regions[:count]),
            *notes_of("reversed buckling factor", self.errors[count:], regions[count:]),
            *polygon_texts(self.problem),
            *offset_texts(self.problem),
            *shape_notes("buckling factor", dict(enumerate(self._bent[:count])), 1.0),
        )

    @lazy
    def _bent(self) -> tuple[Solution, ...]:
        """The shapes as what the plate does."""
        made = system(self.problem)
        return tuple(solution_of(made, vector) for vector in self.vectors.T)

    @lazy
    def _found(self) -> tuple[ShapeError, ...]:
        made = system(self.problem)
        off = self._force_errors(made)
        shapes = [shape_error(shape) for shape in self._bent]
        return tuple(
            replace(found, energy=found.energy + part) for found, part in zip(shapes, off, strict=True)
        )

    def _force_errors(self, made: System) -> Array:
        """|φᵀ G(N* - N) φ / φᵀ G(N) φ| of every shape, with N* the recovered forces: how much λ owes to the error of
        forces that loads make. Forces that were given have none. Where recovered forces are others altogether, the mesh
        makes them, as linear membranes do of a plate that expands freely but unevenly: then it is their difference."""
        if self.given or not len(self):
            return np.zeros(len(self))
        centre = self.problem.mesh.corners.mean(axis=1)
        better = _solved(self.problem).recovered.forces(centre[:, 0], centre[:, 1])
        strange = float(np.linalg.norm(better - self.forces) / np.linalg.norm(self.forces))
        if strange > _STRANGE:
            return np.full(len(self), strange)
        used, off = (
            np.einsum("nk,nk->k", self.vectors, made.assembly.geometric(forces) @ self.vectors)
            for forces in (self.forces, better - self.forces)
        )
        return np.asarray(np.abs(off / used))


def buckling(problem: Problem, count: int = 4, *, forces: Sequence[float] | Array | None = None) -> Buckling:
    """Up to `count` factors of each sign, and none that is more than a million times the least of either: such ones
    cannot be told from round-off.

    forces  (N_x, N_y, N_xy), N/m, tension positive, uniform, or one row per cell; None: those that the problem's loads
            make in the plane, which then have to be held there, at the middle of each cell

    Raises DesignError for forces of another shape, and for a plate without membrane forces, as one that is free to
    expand has none.
    """
    wanted = _checked_count(count)
    check_problem(problem)
    acting = _membrane_forces(problem, forces)
    over = pencil(problem)
    over.require_held("buckling")
    # Rigid motion in the plane that is left does nothing to deflections: any unknowns may hold it.
    stiffness, free = pinned(over.stiffness, over.motions)
    kept = sparse.diags_array(free)
    geometric = sparse.csc_array(kept @ over.geometric(acting) @ kept)
    if not geometric.count_nonzero():
        raise DesignError(
            "the supports hold every deflection of the plate, so nothing buckles; hold less, or mesh finer"
        )
    signs = [sign for sign in (1, -1) if _can_buckle(acting * sign)]
    available = min(wanted, stiffness.shape[0])
    found = stability(stiffness, geometric, available, over.factor, signs)
    values = {1: np.empty(0), -1: np.empty(0)} | {sign: factors for sign, (factors, _) in found.items()}
    full, _ = over.normalised(np.hstack([vectors for _, vectors in found.values()]))
    return Buckling(
        problem=problem,
        vectors=full,
        factors=values[1],
        reversed=values[-1],
        forces=acting,
        given=forces is not None,
    )


def _can_buckle(forces: Array) -> bool:
    """Whether any cell is pressed in any direction: whether the lesser principal force is negative somewhere."""
    x, y, xy = forces.T
    least = 0.5 * (x + y) - np.hypot(0.5 * (x - y), xy)
    return bool((least < -_NO_FORCE * np.abs(forces).max()).any())


def _membrane_forces(problem: Problem, forces: Sequence[float] | Array | None) -> Array:
    count = len(problem.mesh.cells)
    if forces is None:
        found = _forces_of_loads(problem)
        way_out = "load it in its plane and hold it there (in Python, forces=(N_x, N_y, N_xy) can be given)"
    else:
        by_cell = hasattr(forces, "__len__") and len(forces) == count and hasattr(forces[0], "__len__")
        shape = (count, 3) if by_cell else (3,)
        found = np.broadcast_to(checked_array(forces, shape, "the membrane forces of buckling"), (count, 3))
        way_out = "give forces that are not zero"
    if not np.abs(found).max() > 0.0:
        raise DesignError(f"the plate has no membrane forces, so nothing makes it buckle; {way_out}")
    return np.array(found)


def _forces_of_loads(problem: Problem) -> Array:
    """N_x, N_y, N_xy at the middle of every cell, (m, 3), N/m."""
    if not problem.dofs.element.stretches:
        return np.zeros((len(problem.mesh.cells), 3))
    solution = _solved(problem)
    centre = problem.mesh.corners.mean(axis=1)
    found = solution.forces(centre[:, 0], centre[:, 1])
    largest = np.abs(found).max(initial=0.0)
    _check_not_free(solution, centre, largest)
    return np.where(np.abs(found) > _NO_FORCE * largest, found, 0.0)


def _solved(problem: Problem) -> Solution:
    """Under what acts in every case."""
    return FactoredPlate(problem).solve()


def _check_not_free(solution: Solution, centre: Array, largest: float) -> None:
    """Raises DesignError where forces are what round-off leaves of those that hold expansion back and those of the
    strain that it makes: both are large, and their difference is nothing."""
    cells = np.arange(len(centre), dtype=np.int32)
    restrained = np.abs(solution.expansion.at(cells, centre)[:, :3]).max(initial=0.0)
    if largest < _NO_FORCE * restrained:
        raise DesignError(
            f"the plate is free to expand: held back, it would have membrane forces of {restrained:.3g} N/m, and it "
            "has none, so there is no stress to buckle it; hold its edges in the plane (Clamped, or Support of u and "
            "v), or load it there"
        )


def _checked_count(count: object) -> int:
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
        raise DesignError(
            f"the count of buckling factors is {shown(count)}; it must be a whole number, 1 or more"
        )
    return int(count)

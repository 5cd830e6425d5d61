"""Natural frequencies and modes of a plate that vibrates freely about its flat state.

In: a problem; its supports count, its loads do not. Out: frequencies, shapes, modal masses. Never: damping, prestress.

The mass is consistent: it moves as the shape functions say, with w and, where the element has them, u and v. Rotary
inertia is left out, as thin-plate theory does. Source: K.-J. Bathe, Finite Element Procedures, 1996, chapter 11; modal
mass and effective mass as in R. W. Clough and J. Penzien, Dynamics of Structures, 1993, section 12.
"""

from dataclasses import dataclass

import numpy as np

from lamc.basics.brief import brief
from lamc.basics.checks import Array, checked_flag, shown
from lamc.basics.errors import DesignError
from lamc.basics.once import lazy
from lamc.plates.answers.eigen import rigid_basis, vibration
from lamc.plates.answers.pencil import check_problem, pencil, translations
from lamc.plates.answers.shape_errors import ShapeError, notes_of, shape_error, solution_of
from lamc.plates.answers.shapes import Shapes
from lamc.plates.answers.shear_share import shape_notes
from lamc.plates.answers.solution import Solution
from lamc.plates.offsets import offset_texts
from lamc.plates.problem import Problem
from lamc.plates.solving.advice import polygon_texts
from lamc.plates.solving.system import system


@dataclass(frozen=True, eq=False)
class PlateModes(Shapes):
    """Modes in ascending order, the rigid motions of a free plate first, with frequency zero.

    omega           (k,) rad/s
    in_plane_inertia  whether motion in the plane has mass
    rigid           names of the rigid motions that the supports leave, in the order in which they come
    modal_mass      (k,) kg: of the shapes as they are given, with 1 m as their largest displacement
    effective_mass  (k, 3) kg, along x, y and z: what of the plate's mass answers in this mode when its supports shake;
                    for all modes together the plate's, less what moves with the supports
    vectors         (unknowns, k), in the order of `problem.dofs`
    errors          (k,) estimate of how far off each of omega is, relative, by `shape_errors.py`; found when asked for
    notes           a sentence for each mode that may be more than 2 % off
    """

    omega: Array
    in_plane_inertia: bool
    rigid: tuple[str, ...]
    modal_mass: Array
    effective_mass: Array

    def __repr__(self) -> str:
        found = ", ".join(f"{f:.4g}" for f in self.frequencies[:6]) + (", …" if len(self) > 6 else "")
        return brief("PlateModes", "", f"{found} Hz" if len(self) else "none")

    @property
    def frequencies(self) -> Array:
        """Hz, shape (k,)."""
        return np.asarray(self.omega / (2.0 * np.pi))

    @property
    def errors(self) -> Array:
        """Of each of omega, relative, shape (k,): an estimate, no bound; 0 for rigid motions."""
        return 0.5 * np.array([found.energy for found in self._found])  # ω is the root of λ

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader of these frequencies should know."""
        off = notes_of("mode", self.errors, tuple(found.region for found in self._found))
        return (
            *off,
            *polygon_texts(self.problem),
            *offset_texts(self.problem),
            *shape_notes("mode", self._elastic, 0.5),
        )

    @lazy
    def _elastic(self) -> dict[int, Solution]:
        """Modes that are not rigid, by number, as what the plate does."""
        made = system(self.problem)
        pairs = enumerate(zip(self.omega, self.vectors.T, strict=True))
        return {k: solution_of(made, vector) for k, (omega, vector) in pairs if omega > 0.0}

    @lazy
    def _found(self) -> tuple[ShapeError, ...]:
        return tuple(
            shape_error(self._elastic[k]) if k in self._elastic else ShapeError(0.0, "")
            for k in range(len(self.omega))
        )


def modes(problem: Problem, count: int = 6, *, in_plane_inertia: bool = True) -> PlateModes:
    """The `count` lowest modes of `problem`, rigid motions included.

    in_plane_inertia  False: nothing that moves in the plane has mass, as in textbooks' solutions for coupled laminates

    Raises DesignError for a region without mass, and for more modes than there are unknowns with mass.
    """
    wanted = _checked_count(count)
    check_problem(problem)
    _check_mass(problem)
    over = pencil(problem)
    in_plane = checked_flag(in_plane_inertia, "in_plane_inertia of modes")
    whole = over.mass(in_plane=in_plane)
    mass = over.reduced(whole)
    heavy, which = rigid_basis(over.motions, mass)
    elastic = wanted - heavy.shape[1]
    values, vectors = np.empty(0), np.empty((mass.shape[0], 0))
    if elastic > 0:
        values, vectors = vibration(over.stiffness, mass, over.motions, elastic, over.factor)
    if len(values) < elastic:
        raise DesignError(
            f"{wanted} modes are asked for, and the mesh has unknowns for {heavy.shape[1] + len(values)}; "
            "ask for fewer, or mesh finer"
        )
    omega = np.concatenate([np.zeros(heavy.shape[1]), np.sqrt(values)])[:wanted]
    shapes = np.hstack([heavy, vectors])[:, :wanted]
    effective = np.square((over.free @ shapes).T @ (whole @ translations(problem.dofs)))
    full, scale = over.normalised(shapes)
    return PlateModes(
        problem=problem,
        vectors=full,
        omega=omega,
        in_plane_inertia=in_plane,
        rigid=tuple(over.motion_names[k] for k in which[:wanted]),
        modal_mass=np.square(scale),
        effective_mass=effective,
    )


def _checked_count(count: object) -> int:
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
        raise DesignError(f"the count of modes is {shown(count)}; it must be a whole number, 1 or more")
    return int(count)


def _check_mass(problem: Problem) -> None:
    for name, laminate in zip(problem.mesh.region_names, problem.laminates, strict=True):
        if not laminate.areal_mass > 0.0:
            where = f"region {name!r}" if name else "the plate"
            raise DesignError(
                f"the laminate of {where} has no mass, so it has no natural frequencies; give its materials a density, "
                "kg/m³"
            )

"""How an answer changes with every ply's angle, thickness and material, at the price of one more solve.

In: a solution, modes or buckling shapes, and which of their numbers is meant. Out: derivatives by name. Never:
differences of two solutions.

    K d = f,  J(d):   dJ/dp = λ · (∂f/∂p - ∂K/∂p d)  with K λ = ∂J/∂d, and what J has of p itself
    K φ = ω² M φ:     dω/dp = φ · (∂K/∂p - ω² ∂M/∂p) φ / (2 ω φ · M φ)
    (K + λ G) φ = 0:  dλ/dp = - φ · ∂K/∂p φ / φ · G φ

∂K/∂p goes by way of the sections: K is linear in A, B and D (`sensitivity.py`), and these change with a ply as its
staged and compiled derivatives say (`ply_terms.py`). Source: R. T. Haftka, Z. Gürdal, Elements of Structural
Optimization, 1992, sections 7.2 and 7.3.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import TypeAlias

import numpy as np

from lamc.basics.checks import Array, checked_array, shown
from lamc.basics.errors import DesignError, UnsupportedError
from lamc.plates.answers.buckling import Buckling
from lamc.plates.answers.modes import PlateModes
from lamc.plates.answers.pencil import is_in_plane
from lamc.plates.answers.sensitivity import by_mass, by_resultants, by_sections, by_varying, by_weight
from lamc.plates.answers.solution import Solution
from lamc.plates.elements.kernels import kernels
from lamc.plates.laminates.climate import Climate
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.laminates.ply_terms import EXPANSION, MASS, STIFFNESS
from lamc.plates.laminates.slopes import VARIABLES, laminate_terms
from lamc.plates.loads import CLIMATES, Moisture, PointLoad, SelfWeight, Temperature
from lamc.plates.problem import Problem
from lamc.plates.solving.load_vectors import load_vector

Of: TypeAlias = str | tuple[str, Sequence[float]] | tuple[str, int]

# Values closer than this, relative, are one that is repeated: which of its shapes is meant depends on the change.
_REPEATED = 1e-6


@dataclass(frozen=True, eq=False)
class _Slopes:
    """Of one number, by what the regions hand to the elements."""

    sections: Array  # (R, 6 or 18)
    resultants: Array  # (R, 3 or 6), of what expands all over a region
    mass: Array  # (R,), areal
    varying: Sequence[tuple[int, Climate, Array]] = ()  # a region, what acts where a function is 1, (3 or 6)


def gradient(
    answer: Solution | PlateModes | Buckling, of: Of = "compliance", by: Sequence[str] | None = None
) -> dict[str, float]:
    """Derivatives of one number by ply variables.

    of   of a solution: "compliance", J, as `Solution.compliance`; or ("deflection", (x, y)), m. Of modes: ("omega", k),
         rad/s. Of buckling under given forces: ("factor", k). k counts from 0
    by   names such as "ply[0].angle" or, where laminates are given by region, "hinge.ply[2].thickness", also with
         wildcards, "*.angle"; None: all. Plies count from 0, from the bottom. Units are those of `VARIABLES`:
         per degree, m, Pa, 1, kg/m³, …

    Where one laminate is given for all regions, its derivatives are summed over them.

    Raises DesignError for a number that the answer has not, for a repeated or zero frequency or factor, for a name that
    no ply variable has, and for buckling under forces of loads, which change with the plies themselves.
    """
    if not isinstance(answer, Solution | PlateModes | Buckling):
        raise DesignError(
            f"a gradient is asked of {shown(answer)}; it can be of a Solution (of cases, take one by name), of "
            "PlateModes or of Buckling"
        )
    problem = answer.problem
    if problem.dofs.element.shear:
        raise UnsupportedError(
            f"gradients of element {problem.dofs.element.name!r} are not there: its stiffness is not linear in the "
            "section; take 'dkt' where shear through the thickness matters little, or differences of two solutions"
        )
    wanted = _checked_names(problem, by)
    if isinstance(answer, PlateModes):
        slopes = _of_frequency(answer, _checked_number(of, "omega", answer.omega, answer.rigid))
    elif isinstance(answer, Buckling):
        slopes = _of_factor(answer, _checked_number(of, "factor", answer.factors, ()))
    else:
        slopes = _of_solution(answer, of)
        return _chained(problem, slopes, [climate.uniform for climate in answer.climates], wanted)
    still = [Climate(0.0, 0.0, np.zeros(len(laminate.plies))) for laminate in problem.laminates]
    return _chained(problem, slopes, still, wanted)


def _of_frequency(modes: PlateModes, k: int) -> _Slopes:
    problem = modes.problem
    element = problem.dofs.element
    omega, vector = modes.omega[k], modes.vectors[:, k]
    moving = vector if modes.in_plane_inertia else np.where(is_in_plane(problem.dofs), 0.0, vector)
    own = kernels(element)
    cells, regions = problem.dofs.of_cells, problem.mesh.regions
    count = len(problem.laminates)
    scale = 1.0 / (2.0 * omega * modes.modal_mass[k])
    shape = (count, _section_count(problem))
    stiff = by_sections(own, problem.mesh.corners, regions, vector[cells], vector[cells], shape)
    mass = by_mass(own, problem.mesh.corners, regions, moving[cells], moving[cells], count)
    return _Slopes(scale * stiff, np.zeros((count, _strain_count(problem))), -scale * omega**2 * mass)


def _of_factor(buckling: Buckling, k: int) -> _Slopes:
    """dλ = - φ · dK φ / φ · G φ, from (K + λ G) φ = 0."""
    problem = buckling.problem
    if not buckling.given:
        raise DesignError(
            "a gradient is asked of buckling under forces that loads make, which change with the plies; give these "
            "forces: plate.buckling(problem, forces=…)"
        )
    own, corners = kernels(problem.dofs.element), problem.mesh.corners
    count = len(problem.laminates)
    shape = buckling.vectors[:, k][problem.dofs.of_cells]
    entries = (count, _section_count(problem))
    stiff = by_sections(own, corners, problem.mesh.regions, shape, shape, entries)
    work = float(np.einsum("ma,mab,mb->", shape, own.geometric(corners, buckling.forces), shape))
    return _Slopes(-stiff / work, np.zeros((count, _strain_count(problem))), np.zeros(count))


def _of_solution(solution: Solution, of: Of) -> _Slopes:
    """J = target · d; where the target is the load itself, it changes with the plies as well."""
    problem = solution.problem
    for load in solution.loads:
        if isinstance(load, Temperature | Moisture) and load.has_gradient:
            raise DesignError(
                f"a gradient is asked of a solution under a {type(load).__name__} that changes through the thickness, "
                "whose derivatives by plies are not known here; leave its gradient out"
            )
    is_compliance = of == "compliance"
    own = kernels(problem.dofs.element)
    if is_compliance:
        adjoint = solution.answer_to(load_vector(problem, own, solution.loads))
    else:
        adjoint = solution.answer_to(load_vector(problem, own, [_unit_load(problem, of)]))
    cells, corners, regions = problem.dofs.of_cells, problem.mesh.corners, problem.mesh.regions
    count = len(problem.laminates)
    entries, strains = _section_count(problem), _strain_count(problem)
    stiff = by_sections(own, corners, regions, adjoint[cells], solution.values[cells], (count, entries))
    loaded = adjoint + solution.values if is_compliance else adjoint
    resultants, mass = np.zeros((count, strains)), np.zeros(count)
    varying: list[tuple[int, Climate, Array]] = []
    if any(isinstance(load, CLIMATES) for load in solution.loads):
        resultants = by_resultants(own, corners, regions, loaded[cells], (count, strains))
        for region, climate in enumerate(solution.climates):
            for part in climate.varying:
                acting = by_varying(own, corners, regions == region, loaded[cells], part.factor)
                varying.append((region, part.unit, acting))
    weights = [load.acceleration for load in solution.loads if isinstance(load, SelfWeight)]
    if weights:
        mass = by_weight(own, corners, regions, loaded[cells], np.sum(weights, axis=0), count)
    return _Slopes(-stiff, resultants, mass, varying)


def _unit_load(problem: Problem, of: Of) -> PointLoad:
    """Whose work is the number that is asked for: 1 N upwards at the point of ("deflection", (x, y))."""
    if not (isinstance(of, tuple) and len(of) == 2 and of[0] == "deflection"):
        raise DesignError(
            f"a gradient of a solution is asked of {shown(of)}; it can be of 'compliance' or ('deflection', (x, y))"
        )
    at = checked_array(of[1], (2,), "the point of a gradient of the deflection")
    problem.places.cells_under(at[None, :], "the point of a gradient of the deflection")
    return PointLoad(tuple(at.tolist()), 1.0)


def _section_count(problem: Problem) -> int:
    element = problem.dofs.element
    return 18 if element.bends and element.stretches else 6


def _strain_count(problem: Problem) -> int:
    element = problem.dofs.element
    return 3 * (element.bends + element.stretches)


def _chained(
    problem: Problem, slopes: _Slopes, states: Sequence[Climate], wanted: Iterable[str]
) -> dict[str, float]:
    """From regions to plies."""
    element = problem.dofs.element
    both = element.bends and element.stretches
    section = STIFFNESS if both else slice(12, 18) if element.bends else slice(0, 6)
    expansion = EXPANSION if both else slice(21, 24) if element.bends else slice(18, 21)
    result = dict.fromkeys(wanted, 0.0)
    for region, (laminate, state) in enumerate(zip(problem.laminates, states, strict=True)):
        weights = np.zeros(25)
        weights[section] = slopes.sections[region]
        weights[expansion] = slopes.resultants[region]
        weights[MASS] = slopes.mass[region]
        pairs = [(weights, laminate_terms(laminate, state))]
        for where, unit, acting in slopes.varying:
            if where == region:
                own = np.zeros(25)
                own[expansion] = acting
                pairs.append((own, laminate_terms(laminate, unit)))
        for name, ply, variable in _variables(problem, region, laminate):
            if name in result:
                result[name] += sum(float(w @ terms.slopes[variable][ply]) for w, terms in pairs)
    return result


def _variables(problem: Problem, region: int, laminate: Laminate) -> Iterator[tuple[str, int, str]]:
    """Name, ply and variable of all that the laminate of a region has."""
    own = problem.mesh.region_names[region]
    prefix = f"{own}." if own and not isinstance(problem.laminate, Laminate) else ""
    for ply in range(len(laminate.plies)):
        for variable in VARIABLES:
            yield f"{prefix}ply[{ply}].{variable}", ply, variable


def _checked_names(problem: Problem, by: Sequence[str] | None) -> list[str]:
    """The names meant by `by`, in the order of the plies."""
    known = [
        name
        for region, laminate in enumerate(problem.laminates)
        for name, _, _ in _variables(problem, region, laminate)
    ]
    if by is None:
        return list(dict.fromkeys(known))
    if isinstance(by, str):
        by = (by,)
    if not hasattr(by, "__iter__"):
        raise DesignError(f"the ply variables of a gradient are {shown(by)}; give a list of names")
    chosen: set[str] = set()
    for pattern in by:
        # Brackets are part of the names, not of the pattern.
        escaped = pattern.replace("[", "[[]") if isinstance(pattern, str) else ""
        found = {name for name in known if fnmatchcase(name, escaped)}
        if not found:
            raise DesignError(
                f"no ply variable is named {shown(pattern)}; there are {', '.join(known[:3])}, …, {known[-1]}: plies "
                "count from 0, from the bottom"
            )
        chosen |= found
    return [name for name in dict.fromkeys(known) if name in chosen]


def _checked_number(of: Of, name: str, values: Array, rigid: Sequence[str]) -> int:
    """The k of (name, k), of `values`."""
    if not (isinstance(of, tuple) and len(of) == 2 and of[0] == name):
        raise DesignError(f"a gradient of these values is asked of {shown(of)}; it can be of ({name!r}, k)")
    k = of[1]
    if isinstance(k, bool) or not isinstance(k, int | np.integer) or not 0 <= k < len(values):
        raise DesignError(
            f"a gradient is asked of {name} {shown(k)}; there are {len(values)}, counted from 0"
        )
    if k < len(rigid):
        raise DesignError(
            f"mode {k} is a rigid motion ({rigid[k]}): its frequency is zero whatever the plies are"
        )
    for other in (k - 1, k + 1):
        if 0 <= other < len(values) and abs(values[other] - values[k]) < _REPEATED * values[k]:
            raise DesignError(
                f"{name} {min(k, other)} and {max(k, other)} are one value, {values[k]:.9g}; a repeated one has no "
                "derivative, as it parts in a way that depends on the change: take the gradient of another"
            )
    return int(k)

"""The work of `lamc plate`: from what a file says to all that is told of it.

In: a `PlateFile` and how to solve it. Out: a `PlateReport`. Never: files, words.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import shapely
import shapely.ops
from shapely.geometry import Point

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError, DesignErrors, LamcError, about
from lamc.basics.times import Times
from lamc.plates.answers.buckling import Buckling, buckling
from lamc.plates.answers.convergence import error_of_values, kept_corners_text
from lamc.plates.answers.corner_fields import CornerFields, Extreme, corner_fields, extremes
from lamc.plates.answers.estimate import error_estimate
from lamc.plates.answers.failure import first_failure
from lamc.plates.answers.model import FactoredPlate
from lamc.plates.answers.modes import PlateModes, modes
from lamc.plates.answers.shape_pairs import halved_buckling, halved_modes
from lamc.plates.answers.solution import Solution
from lamc.plates.elements.kernels import kernels
from lamc.plates.problem import Problem
from lamc.readers.plates.problem_make import halved_problem_of, problem_of
from lamc.readers.plates.problem_records import Output, PlateFile
from lamc.readers.plates.problem_schema import VALUES
from lamc.report.plate_records import (
    MODES,
    CaseReport,
    Halved,
    PlateReport,
    Printed,
    ShapeReport,
    buckling_key,
)

_XY = ("x", "y", "xy")
_NOTHING = 1e-11  # of the largest value of a field: less is round-off


def answers(
    file: PlateFile, source: str, size: float | None, solver: str, times: Times, *, two_meshes: bool = False
) -> PlateReport:
    """Meshes, solves every case, estimates errors; modes and buckling where the file asks for them.

    Cases, modes or buckling loads that cannot be found are no reason to keep the rest back: the report has their
    errors. two_meshes: every case, modes and buckling once more on halved cells, for the error of outputs, frequencies
    and factors.

    Raises LamcError as the mesher, `Problem` and `FactoredPlate` do, and where no case can be solved.
    """
    with times.stage("mesh"):
        file = file.drawn_for(size)
        origins = file.origins
        problem = problem_of(file, size=size, solver=solver)
    with times.stage("element"):
        kernels(problem.dofs.element)
    with times.stage("assemble"), origins.located():
        model = FactoredPlate(problem, solver)
    errors: list[LamcError] = []
    solved: dict[str, Solution] = {}
    for name in problem.cases or [""]:
        with times.stage("solve"), _kept(errors), origins.located():
            solved[name] = model.solve_case(name) if name else model.solve()
    if not solved:
        several = [error for error in errors if isinstance(error, DesignError)]
        raise DesignErrors(several) if len(several) == len(errors) > 1 else errors[0]
    failed = tuple(name for name in problem.cases if name not in solved)
    with times.stage("estimate"), origins.located():
        cases = [_case(name, solution, file) for name, solution in solved.items()]
    finer = None
    if two_meshes:
        with times.stage("halved cells"), _kept(errors), origins.located():
            finer = halved_problem_of(file, problem, size, solver)
            note = kept_corners_text(problem) if file.drawn_for(size, 2) is file else ""
            cases = _with_halved(cases, FactoredPlate(finer, solver), note)
    found = None
    if file.modes:
        with times.stage("modes"), _kept(errors), origins.located("modes"):
            found = modes(problem, file.modes)
    buckled: dict[str, Buckling] = {}
    for name in solved if file.buckling else ():
        with times.stage("buckling"), _kept(errors), origins.located("buckling"):
            buckled[name] = buckling(_of_case(problem, name), file.buckling)
    shapes = _shape_reports(found, buckled, {note for case in cases for note in case.notes})
    if finer is not None and shapes:
        with times.stage("halved cells"), _kept(errors), origins.located():
            shapes = _halved_shapes(shapes, found, buckled, finer)
    return PlateReport(file, source, problem, cases, found, buckled, times, errors, failed, shapes)


def _shape_reports(
    found: PlateModes | None, buckled: Mapping[str, Buckling], said: Collection[str]
) -> dict[str, ShapeReport]:
    """Errors and notes by `MODES` and `buckling_key`; without notes that cases have `said`."""
    summary_data: dict[str, PlateModes | Buckling] = {} if found is None else {MODES: found}
    summary_data |= {buckling_key(name): each for name, each in buckled.items()}
    return {
        name: ShapeReport(each.errors, [n for n in each.notes if n not in said])
        for name, each in summary_data.items()
    }


def _halved_shapes(
    shapes: dict[str, ShapeReport], found: PlateModes | None, buckled: Mapping[str, Buckling], finer: Problem
) -> dict[str, ShapeReport]:
    pairs = {} if found is None else {MODES: halved_modes(found, finer)}
    pairs |= {
        buckling_key(name): halved_buckling(each, _of_case(finer, name)) for name, each in buckled.items()
    }
    return {name: replace(shape, halved=pairs[name]) for name, shape in shapes.items()}


@contextmanager
def _kept(errors: list[LamcError]) -> Iterator[None]:
    """A LamcError of the block goes to `errors`; one that says the same as another does not."""
    try:
        yield
    except LamcError as error:
        if str(error) not in map(str, errors):
            errors.append(error)


def _of_case(problem: Problem, name: str) -> Problem:
    """The problem of one case."""
    if not name:
        return problem
    return replace(problem, loads=(*problem.loads, *problem.cases[name]), cases={})


def _case(name: str, solution: Solution, file: PlateFile) -> CaseReport:
    fields = corner_fields(solution)
    found = _extremes(solution, fields)
    printed = []
    for output in file.outputs:
        with about(output):
            value = value_of(solution, output)
        largest = max((abs(end.value) for end in found.get(output.value, ("",))[1:]), default=0.0)
        kept = value if abs(value) > _NOTHING * largest else 0.0
        printed.append(Printed(output, kept, VALUES[output.value]))
    strength = first_failure(solution) if fields.tsai_wu is not None else None
    summary_data = strength.notes if strength is not None else ()
    notes = (*solution.report.notes, *_large(solution, found), *summary_data)
    return CaseReport(
        name, solution, fields, error_estimate(solution), found, tuple(printed), notes, strength
    )


def _with_halved(cases: Sequence[CaseReport], fine: FactoredPlate, note: str) -> list[CaseReport]:
    """The cases with what halved cells say of their outputs; where there are none, of the largest displacement. `note`
    tells what they do not."""
    result = []
    for case in cases:
        solution = fine.solve_case(case.name) if case.name else fine.solve()
        printed = case.printed or [_largest(case)]
        summary_data = [
            Halved(p.output, p.unit, error_of_values(p.value, value_of(solution, _on(solution, p.output))))
            for p in printed
        ]
        result.append(replace(case, halved=summary_data, notes=(*case.notes, *([note] if note else []))))
    return result


def _on(solution: Solution, output: Output) -> Output:
    """`output`; beside the plate, whose curves have other corners on a finer mesh, the nearest point of it."""
    plate, at = solution.problem.places.plate, Point(output.at)
    if plate.covers(at):
        return output
    x, y = shapely.get_coordinates(shapely.ops.nearest_points(solution.problem.places.covered, at)[0])[0]
    return replace(output, at=(float(x), float(y)))


def _largest(case: CaseReport) -> Printed:
    """The displacement that is the largest of its kind, where it is: w where the plate bends, else u or v."""
    ends = [
        (name, end) for name in ("w", "u", "v") if name in case.extremes for end in case.extremes[name][1:]
    ]
    across = [pair for pair in ends if pair[0] == "w"] or ends
    name, end = max(across, key=lambda pair: abs(pair[1].value))
    return Printed(Output(f"largest {name}", end.at, name), end.value, VALUES[name])


def _large(solution: Solution, found: Mapping[str, tuple[str, Extreme, Extreme]]) -> tuple[str, ...]:
    """A note where deflections are so large that linear theory may be wrong."""
    if "w" not in found:
        return ()
    _, low, high = found["w"]
    largest = max(abs(low.value), abs(high.value))
    thickness = max(laminate.thickness for laminate in solution.problem.laminates)
    if largest <= thickness:
        return ()
    return (
        f"the largest deflection is {largest / thickness:.3g} thicknesses: where bending also stretches the middle of "
        "the plate, as between held edges, the plate is stiffer than this linear theory says",
    )


def _extremes(solution: Solution, fields: CornerFields) -> Mapping[str, tuple[str, Extreme, Extreme]]:
    """The least and the largest of every field, by its name, with its unit."""
    mesh = solution.problem.mesh
    found: dict[str, tuple[str, Extreme, Extreme]] = {}
    for name in ("w", "u", "v"):
        if name in solution.problem.dofs.names:
            at_points = solution.at_nodes(name)[: len(mesh.points)]
            found[name] = ("m", *extremes(mesh.points, at_points))
    for letter, unit, values in (("M", "N", fields.moments), ("N", "N/m", fields.forces)):
        if values is not None:
            for k, axes in enumerate(_XY):
                found[f"{letter}_{axes}"] = (unit, *extremes(mesh.corners, values[..., k]))
    found["stress"] = ("Pa", *extremes(mesh.corners, fields.stress))
    if fields.tsai_wu is not None:
        found["Tsai-Wu"] = ("", *extremes(mesh.corners, fields.tsai_wu))
    return found


def value_of(solution: Solution, output: Output) -> float:
    """What an output asks for, SI; curvatures, moments and forces recovered, as the extremes are. Raises DesignError
    where the point is off the mesh."""
    x, y = output.at
    name, _, axes = output.value.partition("_")
    found: Array
    if output.value in ("u", "v", "w"):
        found = solution.displacement(x, y)[..., "uvw".index(output.value)]
    elif name == "w":
        found = solution.slope(x, y)[..., _XY.index(axes)]
    else:
        better = solution.recovered
        fields = {"kappa": better.curvature, "M": better.moments, "N": better.forces}
        found = fields[name](x, y)[..., _XY.index(axes)]
    return float(np.asarray(found))

"""From what a plate file says to a problem that can be solved.

In: a `PlateFile`, and another element or length of edges if one is wanted. Out: a `Mesh`, a `Problem`; or a refusal,
before meshing, where solving would take more memory than there is. Never: files.
"""

from collections.abc import Sequence
from dataclasses import replace

import shapely

from lamc.basics.errors import DesignError
from lamc.plates.answers.choice import THICK, THIN, choose_element
from lamc.plates.answers.convergence import halved
from lamc.plates.designs.inner_lines import is_strip
from lamc.plates.elements.definition import Element
from lamc.plates.elements.library import checked_element
from lamc.plates.hinge_lines import HingeLine
from lamc.plates.loads import EdgeLoad, EdgeMoment
from lamc.plates.memory import check_memory
from lamc.plates.meshing.checks import MOST_CELLS
from lamc.plates.meshing.grid import PER_SQUARE, grid
from lamc.plates.meshing.mesh import Mesh
from lamc.plates.meshing.mesher import expected_cells, mesh
from lamc.plates.problem import Problem
from lamc.plates.solving.solvers import checked_solver
from lamc.plates.supports import Where
from lamc.readers.plates.follow import to_follow
from lamc.readers.plates.problem_records import CELLS_ALONG, Geometry, PlateFile

AUTO = "auto"
MOST = (
    250_000  # cells of a plate file's mesh: made and checked in some ten seconds; in Python there may be more
)
MOST_LOOKS = 10_000_000  # places times cells, some µs each
# Of the cells that are expected, so many there are at least: 0.5 beside small holes to 0.95 in large squares, measured
# on meshes of more than 5000.
_SURE = 0.5


def mesh_of(
    geometry: Geometry,
    size: float | None = None,
    hinges: Sequence[HingeLine] = (),
    *,
    along: Sequence[Where] = (),
    element: Element | str = "dkt",
    solver: str = "auto",
) -> Mesh:
    """The mesh, which without a grid follows `hinges` and the places `along` which something holds or acts; `size`, m,
    in place of the grid's and the file's. Raises DesignError as the mesher does, and where there is no memory to solve
    so many cells of `element` by `solver`."""
    element, solver = checked_element(element), checked_solver(solver)
    x0, y0, x1, y1 = geometry.outline.bounds
    shapes = {name: region.polygon for name, region in geometry.regions.items()}
    if geometry.grid is not None:
        a, b = x1 - x0, y1 - y0
        cells = geometry.grid if size is None else (_steps(a, size), _steps(b, size))
        check_memory(element, cells[0] * cells[1] * PER_SQUARE[geometry.pattern], solver)
        return grid(a, b, *cells, geometry.pattern, origin=(x0, y0), regions=shapes, limit=MOST)
    general = size or geometry.size or max(x1 - x0, y1 - y0) / CELLS_ALONG
    share = (
        1.0 if size is None or geometry.size is None else size / geometry.size
    )  # regions stay as fine beside it
    sizes = {n: share * region.size for n, region in geometry.regions.items() if region.size is not None}
    sizes = {n: min(own, general) if is_strip(n) else own for n, own in sizes.items()}
    within = [shapely.intersection(hinge.where, geometry.outline) for hinge in hinges]
    lines = [line for part in within for line in shapely.get_parts(part) if line.length > 0.0]
    drawn = [*geometry.follow, *lines]
    followed = [*drawn, *to_follow(along, geometry.outline, [*shapes.values(), *drawn])]
    expected = expected_cells(geometry.outline, general, regions=shapes, sizes=sizes, follow=followed)
    if expected < MOST_CELLS:  # the mesher refuses more
        check_memory(element, int(_SURE * expected), solver, least=True)
    return mesh(geometry.outline, general, regions=shapes, sizes=sizes, follow=followed, limit=MOST)


def problem_of(
    file: PlateFile, element: str | None = None, size: float | None = None, solver: str = "auto"
) -> Problem:
    """Meshed, and ready to be solved; circles have as many corners as the mesh's edges call for. Element "auto" is
    chosen by `choose_element`, and told among the notes.

    Raises DesignError as `mesh_of` and `Problem` do, with the place in the file."""
    return _meshed(file.drawn_for(size), element, size, solver)


def halved_problem_of(
    file: PlateFile, problem: Problem, size: float | None = None, solver: str = "auto"
) -> Problem:
    """That of `problem_of`, `problem`, on cells of half the size: each cut in four, but where the file has circles a
    new mesh, whose circles have twice the corners. Raises as `problem_of` does."""
    fine = file.drawn_for(size, 2)
    if fine is file:
        return halved(problem)
    general = file.size_of(size)
    share = 1.0 if size is None or file.geometry.size is None else size / file.geometry.size
    regions = {
        name: replace(region, size=None if region.size is None else region.size * share)
        for name, region in fine.geometry.regions.items()
    }
    coarse = replace(fine, geometry=replace(fine.geometry, size=general, regions=regions))
    return _meshed(coarse, problem.dofs.element.name, 0.5 * general, solver)


def _check_looks(file: PlateFile, cells: int) -> None:
    """Raises DesignError where supports, loads and hinges are too many for a mesh of so many cells."""
    count = len(file.supports) + len(file.hinges) + sum(map(len, file.cases.values()))
    if count * cells > MOST_LOOKS:
        raise DesignError(
            f"{count} supports, loads and hinges are looked for among {cells} cells; the product must not be above "
            f"{MOST_LOOKS}: take a larger size of edges, or join places"
        )


def _meshed(file: PlateFile, element: str | None, size: float | None, solver: str) -> Problem:
    wanted = (element or file.element).strip().lower()
    first = THICK if wanted == AUTO else wanted
    with file.origins.located("geometry" if size is None else ""):
        made = mesh_of(file.geometry, size, file.hinges, along=_places_of(file), element=first, solver=solver)
    with file.origins.located("geometry"):
        _check_looks(file, len(made.cells))
    with file.origins.located():
        if wanted != AUTO:
            return _problem(file, made, wanted)
        plain = _problem(file, made, THIN)
        choice = choose_element(plain, waves=max(file.modes, file.buckling))
        return replace(plain, element=choice.element, remarks=(choice.why,))


def _places_of(file: PlateFile) -> list[Where]:
    """Where supports hold and where loads act along edges."""
    loads = [load for case in file.cases.values() for load in case]
    acting = [load.where for load in loads if isinstance(load, EdgeLoad | EdgeMoment)]
    return [*(support.where for support in file.supports), *acting]


def _problem(file: PlateFile, made: Mesh, element: str | None) -> Problem:
    own = {name: region.laminate for name, region in file.geometry.regions.items()}
    laminates = {name: own.get(name) or file.laminate for name in made.region_names}
    cases = dict(file.cases)
    single = cases.pop("") if list(cases) == [""] else ()
    return Problem(
        made,
        {name: laminate for name, laminate in laminates.items() if laminate is not None},
        element=element or file.element,
        supports=file.supports,
        loads=single,
        cases=cases,
        hinges=file.hinges,
        foundations=file.foundations,
    )


def _steps(length: float, size: float) -> int:
    return max(1, round(length / size))

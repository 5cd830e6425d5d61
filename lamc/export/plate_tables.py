"""A plate problem as tables of numbers: all that exported C knows of mesh, supports and loads.

In: a problem that is held. Out: cells in the order in which lamc sums them, what each unknown of the mesh is in terms
of the free ones, the pattern of their matrix, springs, loads, an ordering in which the matrix has a short profile, and
the cells near every place. Never: stiffness of laminates, C text.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from lamc.basics.checks import Array
from lamc.basics.errors import ExportError, about
from lamc.export.plate_climate import ClimateTables, climate_tables
from lamc.export.plate_points import PointTables, point_tables
from lamc.export.plate_profile import check_cells, check_profile, profile_of
from lamc.plates.loads import CLIMATES, LoadRecord, SelfWeight
from lamc.plates.meshing.mesh import Integers
from lamc.plates.problem import Problem
from lamc.plates.solving.load_vectors import load_vector
from lamc.plates.solving.springs import with_added
from lamc.plates.solving.system import System, system

HELD, ABSENT, OBLIQUE = -1, -2, -3  # what is no row of the matrix


@dataclass(frozen=True, eq=False)
class Rows:
    """Sparse rows: entries of row i are those from begins[i] to begins[i + 1]."""

    begins: Integers
    columns: Integers
    factors: Array


@dataclass(frozen=True, eq=False)
class SpringTables:
    """Points of quadrature along lines that resist turning: the slope across the line is rows @ free unknowns + offset.

    length  m, of line that a point stands for
    group   (k,): which stiffness is meant
    """

    rows: Rows
    offset: Array
    length: Array
    group: Integers
    names: tuple[str, ...]  # of the groups
    stiffness: tuple[float, ...]  # N·m per rad and m of line, of the groups


@dataclass(frozen=True, eq=False)
class PlateTables:
    """Everything about a problem but its laminates.

    points     (points, 2), m, of the mesh
    cells      (m, corners), rows of `points`, in the order in which matrices are summed
    unknowns   (m, d), of the mesh, in the element's order
    regions    (m,)
    shares     (N): unknowns of the mesh from free ones
    fixed      (N,), what is prescribed beside
    begins, columns  pattern of the matrix of the free unknowns, both triangles, row by row
    nodes      (nodes, 2), m
    node_rows  (nodes, 6): row of the matrix of each of u, v, w, w_x, w_y, w_xy; or HELD, ABSENT, OBLIQUE
    node_unknowns  (nodes, 6), of the mesh; -1: the node has none
    loads      (cases, f), of what does not depend on laminates; `gravity` (cases, regions, f) per kg/m²
    climate    what makes laminates expand, which is not in the loads
    near       cells near every place
    condition  of the matrix, scaled to a diagonal near one
    order      (f,): rows in the order of the factorisation; `profile` (f + 1,): where each begins in it
    """

    points: Array
    cells: Integers
    unknowns: Integers
    regions: Integers
    shares: Rows
    fixed: Array
    begins: Integers
    columns: Integers
    springs: SpringTables
    nodes: Array
    node_rows: Integers
    node_unknowns: Integers
    cases: tuple[str, ...]
    loads: Array
    gravity: Array
    climate: ClimateTables
    near: PointTables
    order: Integers
    profile: Integers
    condition: float


def plate_tables(problem: Problem, *, lossy: bool) -> PlateTables:
    """Tables of `problem`. Raises ExportError for a plate that is not held, is too large, or has loads that C does not
    have (`climate_tables`); the latter are left out where `lossy`."""
    check_cells(problem)
    for foundation in problem.foundations:
        with about(foundation):
            raise ExportError(
                f"the plate lies on {foundation.text}, which exported C does not have; solve it here, or leave the "
                "foundation out"
            )
    cases = {name: (*problem.loads, *own) for name, own in (dict(problem.cases) or {"": ()}).items()}
    climate = climate_tables(problem, cases, lossy=lossy)
    made = system(problem)
    _check_held(made)
    free = sp.csr_array(made.constraints.free)
    free.sort_indices()
    if free.shape[1] == 0:
        raise ExportError("the supports hold every unknown of the plate; there is nothing to solve for")
    fixed = np.asarray(made.constraints.fixed.T @ made.constraints.values)
    matrix = pattern_of(made)
    order, profile = profile_of(matrix)
    check_profile(problem, int(profile[-1]))
    loads, gravity = _loads(made, free, cases.values())
    kept = made.assembly.order
    unknown_rows = _rows_of_unknowns(free)
    table = problem.dofs.table
    return PlateTables(
        points=problem.mesh.points,
        cells=problem.mesh.cells[kept],
        unknowns=problem.dofs.of_cells[kept],
        regions=problem.mesh.regions[kept],
        shares=Rows(free.indptr, free.indices, free.data),
        fixed=fixed,
        begins=matrix.indptr,
        columns=matrix.indices,
        springs=_springs(made, free, fixed),
        nodes=problem.dofs.points,
        node_rows=np.where(table >= 0, unknown_rows[table], ABSENT).astype(np.int32),
        node_unknowns=table,
        cases=tuple(cases),
        loads=loads,
        gravity=gravity,
        climate=climate,
        near=point_tables(problem, kept),
        order=order,
        profile=profile.astype(np.int32),
        condition=made.condition,
    )


def pattern_of(made: System) -> sp.csc_array:
    """The matrix of the free unknowns, for its pattern; symmetric, so by rows as by columns."""
    full = made.stiffness
    matrix = made.pattern.reduction(full).matrix(full.data)
    return with_added(matrix, made.hinge_springs.over(made.constraints.free))


def _check_held(made: System) -> None:
    loose = [name for piece in made.pieces for name in piece.names]
    if loose:
        raise ExportError(
            f"the plate is not held: nothing prevents that it {loose[0]}; exported C solves plates whose supports hold "
            "them: add a support"
        )


def _rows_of_unknowns(free: sp.csr_array) -> Integers:
    """Per unknown of the mesh its row, where it is one, (N,)."""
    entries = np.diff(free.indptr)
    rows = np.full(free.shape[0], HELD, dtype=np.int32)
    rows[entries > 0] = OBLIQUE
    single = np.flatnonzero(entries == 1)
    alone = single[free.data[free.indptr[single]] == 1.0]
    rows[alone] = free.indices[free.indptr[alone]]
    return rows


def _springs(made: System, free: sp.csr_array, fixed: Array) -> SpringTables:
    problem = made.problem
    rows, offsets, lengths, groups = [], [], [], []
    names: list[str] = []
    stiffness: list[float] = []
    for springs, records in ((made.springs, problem.supports), (made.hinge_springs, problem.hinges)):
        for owner in np.unique(springs.owners).tolist():
            value = float(getattr(records[owner], "stiffness"))  # noqa: B009  records of two kinds
            if value == 0.0:
                continue
            own = np.flatnonzero(springs.owners == owner)
            rows.append(sp.csr_array(springs.rotations[own] @ free))
            offsets.append(springs.rotations[own] @ fixed)
            lengths.append(springs.stiffness[own] / value)
            groups.append(np.full(len(own), len(names)))
            names.append(_spring_name(records[owner], owner, is_hinge=springs is made.hinge_springs))
            stiffness.append(value)
    if not rows:
        none = np.zeros(0)
        whole = np.zeros(0, dtype=np.int32)
        empty = Rows(np.zeros(1, dtype=np.int32), whole, none)
        return SpringTables(empty, none, none, whole, (), ())
    stacked = sp.csr_array(sp.vstack(rows))
    stacked.sort_indices()
    return SpringTables(
        Rows(stacked.indptr, stacked.indices, stacked.data),
        np.concatenate(offsets),
        np.concatenate(lengths),
        np.concatenate(groups).astype(np.int32),
        tuple(names),
        tuple(stiffness),
    )


def _spring_name(record: object, owner: int, *, is_hinge: bool) -> str:
    kind = "hinge line" if is_hinge else "support"
    return str(getattr(record, "name", "") or f"{kind} {owner + 1}")


def _loads(made: System, free: sp.csr_array, cases: Iterable[Sequence[LoadRecord]]) -> tuple[Array, Array]:
    """Of every case, what does not depend on laminates, and what weight does per kg/m²."""
    constant, gravity = [], []
    for acting in cases:
        kept = [load for load in acting if not isinstance(load, CLIMATES)]
        weights = [load for load in kept if isinstance(load, SelfWeight)]
        others = [load for load in kept if not isinstance(load, SelfWeight)]
        constant.append(free.T @ load_vector(made.problem, made.kernels, others))
        gravity.append([free.T @ vector for vector in _gravity(made, weights)])
    return np.array(constant), np.array(gravity)


def _gravity(made: System, loads: Sequence[LoadRecord]) -> list[Array]:
    """Forces on the unknowns (N,) of each region, per kg/m² of its laminate."""
    problem = made.problem
    mesh, element = problem.mesh, problem.dofs.element
    total = np.sum(
        [load.acceleration for load in loads if isinstance(load, SelfWeight)] or [(0.0,) * 3], axis=0
    )
    components = [*total[:2]] * element.stretches + [total[2]] * element.bends
    found = []
    for region in range(len(mesh.region_names)):
        here = (mesh.regions == region)[:, None] * np.ones(mesh.corner_count)
        intensity = np.stack([here * g for g in components], axis=1)
        vectors = made.kernels.load(mesh.corners, intensity)
        numbers = problem.dofs.of_cells.ravel()
        found.append(np.asarray(np.bincount(numbers, vectors.ravel(), problem.dofs.count), dtype=float))
    return found

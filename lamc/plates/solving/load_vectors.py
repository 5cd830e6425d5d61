"""From loads to forces on the unknowns, by the shape functions of the element.

In: a problem, kernels, loads. Out: vectors (N,): the work of the loads per unit of each unknown. Never: supports.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError, about
from lamc.plates.edge_parts import EdgeParts, edge_parts_on
from lamc.plates.elements.definition import CORNERS
from lamc.plates.elements.kernels import ElementKernels
from lamc.plates.functions import values_at
from lamc.plates.loads import CLIMATES, EdgeLoad, EdgeMoment, LoadRecord, PointLoad, Pressure, SelfWeight
from lamc.plates.meshing.mesh import Integers
from lamc.plates.problem import Problem
from lamc.plates.solving.cell_points import cell_points
from lamc.plates.solving.expansion import Expansion

_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(
    4
)  # exact to degree 7: a cubic deflection and a cubic load


def load_vector(problem: Problem, kernels: ElementKernels, loads: Sequence[LoadRecord]) -> Array:
    """All `loads` together, shape (N,): N for displacements, N·m for slopes.

    Raises DesignError for a point load outside the plate, a moment along an inner line, a function that fails.
    """
    total = np.zeros(problem.dofs.count)
    intensities = []
    for load in loads:
        with about(load):
            if isinstance(load, Pressure) and callable(load.intensity):
                _add_varying(total, problem, kernels, load)
            elif isinstance(load, Pressure | SelfWeight):
                intensities.append(_intensity(problem, load))
            elif isinstance(load, PointLoad):
                _add_point(total, problem, kernels, load)
            elif isinstance(load, EdgeLoad | EdgeMoment):
                _add_edges(total, problem, kernels, load)
    if intensities:
        _add(total, problem.dofs.of_cells, kernels.load(problem.mesh.corners, sum(intensities)))
    if any(isinstance(load, CLIMATES) for load in loads):
        _add(total, problem.dofs.of_cells, Expansion(problem, loads).forces(kernels))
    return total


def _add(total: Array, numbers: Integers, values: Array) -> None:
    total += np.bincount(numbers.ravel(), values.ravel(), len(total))


def _fields(problem: Problem, force: Any) -> list[Any]:
    """Of the components x, y, z those that the element has."""
    chosen = problem.dofs.element
    return [*force[:2]] * chosen.stretches + [force[2]] * chosen.bends


def _intensity(problem: Problem, load: Pressure | SelfWeight) -> Array:
    """Force per area of what does not vary, at the corners of the cells, shape (m, fields, c), Pa."""
    mesh = problem.mesh
    shape = mesh.cells.shape
    if isinstance(load, SelfWeight):
        mass = np.array([laminate.areal_mass for laminate in problem.laminates])[mesh.regions][:, None]
        parts = [np.broadcast_to(mass * g, shape) for g in _fields(problem, load.acceleration)]
        return np.stack(parts, axis=1)
    across = np.zeros(shape)
    across[_cells_of(problem, load)] = load.intensity  # type: ignore[assignment]  # a number
    none = np.zeros(shape)
    return np.stack(_fields(problem, (none, none, across)), axis=1)


def _cells_of(problem: Problem, load: Pressure) -> Integers:
    mesh = problem.mesh
    if load.region is None:
        return np.arange(len(mesh.cells), dtype=np.int32)
    return np.flatnonzero(mesh.regions == mesh.region_names.index(load.region)).astype(np.int32)


def _add_varying(total: Array, problem: Problem, kernels: ElementKernels, load: Pressure) -> None:
    """A pressure that is a function of the place, integrated at points of every cell."""
    chosen, cells, what = problem.dofs.element, _cells_of(problem, load), "the intensity of a Pressure"
    # Gauss's points lie inside of cells, and would not meet what is infinite at a corner.
    values_at(load.intensity, problem.mesh.points[np.unique(problem.mesh.cells[cells])], what)
    for point in cell_points(chosen.cell, problem.mesh.corners, cells):
        pressure = values_at(load.intensity, point.places, what)
        deflections = shape_functions(problem, kernels, point.cells, point.xi)[:, :, 2 * chosen.stretches]
        forces = (point.areas * pressure)[:, None] * deflections
        _add(total, problem.dofs.of_cells[point.cells], forces)


def shape_functions(problem: Problem, kernels: ElementKernels, cells: Integers, xi: Array) -> Array:
    """u, v, w, w_x, w_y of those the element has, per unit of each unknown, at `xi` (k, 2) of `cells` (k,).

    Shape (k, unknowns, fields).
    """
    count = problem.dofs.of_cells.shape[1]
    corners = np.repeat(problem.mesh.corners[cells], count, axis=0)
    unit = np.tile(np.eye(count), (len(cells), 1))
    values = kernels.displacement(corners, np.repeat(xi, count, axis=0), unit)
    return np.asarray(values).reshape(len(cells), count, -1)


def _add_point(total: Array, problem: Problem, kernels: ElementKernels, load: PointLoad) -> None:
    cells, xi = problem.places.cells_under(np.array([load.at]), "a PointLoad")
    shapes = shape_functions(problem, kernels, cells, xi)[0]
    force = np.array(_fields(problem, load.force), dtype=float)
    np.add.at(total, problem.dofs.of_cells[cells[0]], shapes[:, : len(force)] @ force)


def _add_edges(total: Array, problem: Problem, kernels: ElementKernels, load: EdgeLoad | EdgeMoment) -> None:
    """Forces along z or in the plane, or a moment about the edge, integrated along the edges of the cells."""
    what = f"the {type(load).__name__}"
    parts = edge_parts_on(problem.places, load.where, what)
    if isinstance(load, EdgeMoment):
        _check_outer(problem, load, parts.edges)
    numbers = problem.dofs.of_cells[parts.edges[:, 0]]
    for point in along_edges(problem, kernels, parts):
        if isinstance(load, EdgeMoment):
            _add(total, numbers, -load.moment * point.length[:, None] * point.across)
        else:
            force = np.array(_fields(problem, load.force), dtype=float)
            _add(total, numbers, point.length[:, None] * (point.shapes[:, :, : len(force)] @ force))


@dataclass(frozen=True, eq=False)
class EdgePoint:
    """A point of a quadrature rule on each of k edges.

    length  (k,), m: its part of the edge
    shapes  (k, unknowns, fields), as `shape_functions`
    across  (k, unknowns): the slope along the normal, out of the cell
    """

    length: Array
    shapes: Array
    across: Array


def along_edges(problem: Problem, kernels: ElementKernels, parts: EdgeParts) -> Iterator[EdgePoint]:
    """Points along `parts` that integrate a product of cubics exactly."""
    cells, local = parts.edges[:, 0], parts.edges[:, 1]
    begin, share = parts.ends[:, :1], parts.ends[:, 1:] - parts.ends[:, :1]
    natural = np.array(CORNERS[problem.dofs.element.cell], dtype=float)
    after = (local + 1) % len(natural)
    along = problem.mesh.corners[cells, after] - problem.mesh.corners[cells, local]
    length = np.linalg.norm(along, axis=1)
    for place, weight in zip(_GAUSS, _WEIGHTS, strict=True):
        xi = natural[local] + (begin + 0.5 * (1.0 + place) * share) * (natural[after] - natural[local])
        shapes = shape_functions(problem, kernels, cells, xi)
        across = np.zeros(shapes.shape[:2])
        if problem.dofs.element.bends:
            normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / length[:, None]
            across = np.einsum("kai,ki->ka", shapes[:, :, -2:], normal)
        yield EdgePoint(0.5 * weight * share[:, 0] * length, shapes, across)


def _check_outer(problem: Problem, load: EdgeMoment, edges: Integers) -> None:
    """Raises DesignError where a moment acts on an edge between two cells."""
    mesh = problem.mesh
    inner = np.flatnonzero(~problem.places.on_boundary[mesh.cell_edges[edges[:, 0], edges[:, 1]]])
    if len(inner):
        cell, edge = edges[inner[0]]
        ends = mesh.corners[cell, [edge, (edge + 1) % mesh.corner_count]]
        x, y = ends.mean(axis=0)
        raise DesignError(
            f"an EdgeMoment of {load.moment:g} N acts along an inner edge at ({x:.6g}, {y:.6g}), where both sides are "
            "plate and no normal points outwards; it must be on the boundary: for a couple inside give two lines of "
            "EdgeLoad"
        )

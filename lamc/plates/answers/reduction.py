"""A plate reduced to a few shapes: what a body that bends needs of its own finite elements.

In: a held problem, how many natural modes, and at which points or edges others push. Out: shapes with their mass and
stiffness matrices, and integrals over them by the mesh's own consistent mass. Never: large motion, damping.

The shapes are the lowest natural modes of the plate as it is held and, if wished, those that statics needs: the
deflections under a uniform acceleration along z, and under a force and two moments at each attachment. Freed of what
the modes have of them, and diagonalised among themselves, they leave the modes as they are, frequencies too, and make
the deflection under these loads that of the finite elements to round-off. They stand for all higher modes, as the
attachment modes of Craig and Chang do. Sources: R. R. Craig, C.-J. Chang, AIAA Journal 14 (1976) 1633-1635; R. H.
MacNeal, Computers & Structures 1 (1971) 581-601; A. A. Shabana, Dynamics of Multibody Systems, 4th ed. 2013, chapter 6.

Masses are those of motion along z; u and v of coupled laminates follow without inertia.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import shapely
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.basics.once import lazy
from lamc.plates.answers.modes import modes
from lamc.plates.answers.pencil import Pencil, pencil
from lamc.plates.elements.kernels import kernels
from lamc.plates.problem import Problem

_SAME = 1e-8  # share that a static shape must have of its own beside the others, to be one
_SAMPLES = 64  # along an attached edge


@dataclass(frozen=True, eq=False)
class Attachment:
    """Where another body is joined: at a point, m, by an edge of the plate, which moves as the plane nearest to it.

    edge  None: by the point of the plate nearest to it
    """

    point: tuple[float, float]
    edge: BaseGeometry | None = None


@dataclass(frozen=True, eq=False)
class Reduction:
    """Shapes φ with their largest deflection at a node 1.

    vectors       (unknowns, k), in the order of `problem.dofs`: natural modes first, ascending, then those of statics
    natural       how many are natural modes
    omega         (k,) rad/s; of the plate for natural modes, of the reduced one for the others
    mass          (k, k), kg, ∫ρ φ_k φ_l
    stiffness     (k, k), N/m
    moment        (k,), kg, ∫ρ φ_k
    first_moment  (k, 3), kg·m, ∫ρ (x, y, z) φ_k, z from the laminates' reference surface
    """

    problem: Problem
    attachments: tuple[Attachment, ...]
    vectors: Array
    natural: int
    omega: Array
    mass: Array
    stiffness: Array
    moment: Array
    first_moment: Array

    def shape_at(self, x: float, y: float) -> tuple[Array, Array]:
        """φ (k,) and its gradient (k, 2), 1/m, at a point, m; off the plate and at attachments as rigidly joined."""
        at = (float(x), float(y))
        found = self._shapes.get(at)
        if found is None:
            values = _rows(self.problem, self._attachment(*at)) @ self.vectors
            values.flags.writeable = False
            found = self._shapes[at] = (values[0], values[1:].T)
        return found

    @lazy
    def _shapes(self) -> dict[tuple[float, float], tuple[Array, Array]]:
        """Shapes by point: effects act at few points, and other cross-checks ask for them at every instant."""
        return {}

    def _attachment(self, x: float, y: float) -> Attachment:
        near = 1e-9 * self.problem.size
        for known in self.attachments:
            if np.hypot(known.point[0] - x, known.point[1] - y) <= near:
                return known
        return Attachment((x, y))


def reduce_plate(
    problem: Problem, count: int, attachments: Sequence[Attachment] = (), *, static: bool = True
) -> Reduction:
    """The `count` lowest modes of `problem`, and with `static` the shapes of statics.

    Raises DesignError as `modes` does, and where the plate is not held across.
    """
    system = pencil(problem)
    system.require_held("a plate that is reduced")
    found = modes(problem, count, in_plane_inertia=False)
    mass = system.mass(in_plane=False)
    natural = _free_part(system, found.vectors)
    y = natural
    if static:
        rigid = rigid_fields(problem)
        loads = np.column_stack([mass @ rigid[:, 0], *(_rows(problem, a).T for a in attachments)])
        y = np.hstack([natural, _statics(system, system.reduced(mass), natural, loads)])
    full, _ = system.normalised(y)
    reduced = _free_part(system, full)
    stiffness = reduced.T @ (system.stiffness @ reduced)
    modal = full.T @ (mass @ full)
    squares = np.diag(stiffness) / np.diag(modal)
    squares[: found.omega.size] = found.omega**2
    fields, heights = mass @ rigid_fields(problem), _height_mass(system)
    return Reduction(
        problem=problem,
        attachments=tuple(attachments),
        vectors=full,
        natural=count,
        omega=np.sqrt(squares),
        mass=0.5 * (modal + modal.T),
        stiffness=0.5 * (stiffness + stiffness.T),
        moment=full.T @ fields[:, 0],
        first_moment=np.column_stack([full.T @ fields[:, 1], full.T @ fields[:, 2], full.T @ heights]),
    )


def _free_part(system: Pencil, vectors: Array) -> Array:
    """Free unknowns of vectors of all; the columns of `free` are orthonormal."""
    return np.asarray(system.free.T @ vectors)


def _statics(system: Pencil, mass: Array, natural: Array, loads: Array) -> Array:
    """Free unknowns (f, s) of the static shapes of loads (N, l), orthogonal to the natural modes and to each other."""
    solve = system.factor(system.stiffness)
    shapes = np.column_stack([solve(column) for column in (system.free.T @ loads).T])
    shapes = shapes / np.sqrt(np.einsum("ij,ij->j", shapes, mass @ shapes))
    kept = natural / np.sqrt(np.einsum("ij,ij->j", natural, mass @ natural))
    own: list[Array] = []
    for shape in shapes.T:
        rest = shape
        for _ in range(2):  # once more, for what round-off left of the first
            basis = np.column_stack([kept, *own])
            rest = rest - basis @ (basis.T @ (mass @ rest))
        square = float(rest @ (mass @ rest))
        if square > _SAME**2:
            own.append(rest / np.sqrt(square))
    if not own:
        return np.zeros((len(natural), 0))
    found = np.column_stack(own)
    _, rotated = scipy.linalg.eigh(found.T @ (system.stiffness @ found), found.T @ (mass @ found))
    return np.asarray(found @ rotated)


def rigid_fields(problem: Problem) -> Array:
    """w = 1, w = x and w = y as unknowns, (N, 3)."""
    dofs = problem.dofs
    fields = np.zeros((dofs.count, 3))
    w, w_x, w_y = (dofs.of(name) for name in ("w", "w_x", "w_y"))
    there = w >= 0
    fields[w[there], 0] = 1.0
    fields[w[there], 1], fields[w[there], 2] = dofs.points[there].T
    for k, number in ((1, w_x), (2, w_y)):
        fields[number[number >= 0], k] = 1.0
    return fields


def _height_mass(system: Pencil) -> Array:
    """M w of w = 1, each region's mass times the height of its middle above the reference surface, (N,)."""
    weights = []
    for laminate in system.problem.laminates:
        middles = laminate.heights.mean(axis=1)
        weights.append(
            sum(p.material.density * p.thickness * z for p, z in zip(laminate.plies, middles, strict=True))
        )
    return np.asarray(system.system.assembly.mass(np.array(weights)) @ rigid_fields(system.problem)[:, 0])


def _rows(problem: Problem, attachment: Attachment) -> Array:
    """w, w_x and w_y at an attachment as functions of the unknowns, (3, N)."""
    at = np.array(attachment.point)
    if attachment.edge is None:
        near = at
        if not shapely.intersects_xy(problem.places.plate, *at):
            line = shapely.shortest_line(_covered(problem), shapely.Point(at))
            near = np.array(line.coords[0])
        (rows,) = _values(problem, near[None])
        return np.vstack([rows[0] + (at - near) @ rows[1:], rows[1:]])
    points, weights, along = _samples(attachment.edge)
    middle = weights @ points
    rows = _values(problem, points)
    across = np.array([-along[1], along[0]])
    place = (points - middle) @ along
    mean = np.einsum("p,pij->ij", weights, rows)
    slope_along = np.einsum("p,pi->i", weights * place, rows[:, 0]) / (weights @ place**2)
    slope_across = across @ mean[1:]
    slopes = np.outer(along, slope_along) + np.outer(across, slope_across)
    return np.vstack([mean[0] + (at - middle) @ slopes, slopes])


def edge_axes(edge: BaseGeometry) -> tuple[Array, Array]:
    """The middle of an edge, m, and its direction, (2,) each."""
    points, weights, along = _samples(edge)
    return np.asarray(weights @ points), along


def _samples(edge: BaseGeometry) -> tuple[Array, Array, Array]:
    """Points along an edge (p, 2), m, the share of its length that each stands for, and its direction."""
    parts = [part for part in shapely.get_parts(edge) if part.length > 0.0]
    whole = sum(part.length for part in parts)
    if not whole > 0.0:
        raise DesignError("an attachment's edge has no length; give the point alone")
    points, weights = [], []
    for part in parts:
        count = max(2, round(_SAMPLES * part.length / whole))
        at = (np.arange(count) + 0.5) / count
        points += [np.array(part.interpolate(s, normalized=True).coords[0]) for s in at]
        weights += [part.length / whole / count] * count
    table, share = np.array(points), np.array(weights)
    _, _, axes = np.linalg.svd(table - share @ table)
    return table, share, axes[0]


def _values(problem: Problem, points: Array) -> Array:
    """w, w_x and w_y at points (p, 2) on the plate by unknown, (p, 3, N)."""
    cells, xi = problem.places.cells_under(points, "a point of a plate that is reduced")
    element = problem.dofs.element
    of = kernels(element)
    count = of.unknown_count
    unit = np.tile(np.eye(count), (len(points), 1))
    corners = np.repeat(problem.mesh.corners[cells], count, axis=0)
    found = np.asarray(of.displacement(corners, np.repeat(xi, count, axis=0), unit))[:, -3:]
    rows = np.zeros((len(points), 3, problem.dofs.count))
    numbers = problem.dofs.of_cells[cells]
    for p in range(len(points)):
        np.add.at(rows[p].T, numbers[p], found[p * count : (p + 1) * count])
    return rows


def _covered(problem: Problem) -> BaseGeometry:
    """The area of the mesh."""
    return shapely.union_all([shapely.Polygon(corners) for corners in problem.mesh.corners])

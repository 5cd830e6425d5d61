"""What shear through the thickness would store in a plate that classical theory has solved without it.

In: a solution, and strains at the corners of its cells. Out: energies of shear and of bending. Never: a solve; a span,
which a plate with holes, supports inside or clamped edges does not have.

Equilibrium gives the shear forces, Q = div M, and their energy is ½ ∫ Qᵀ H⁻¹ Q dA: what loads do more, to first order,
were shear not held back (Castigliano's second theorem). Classical theory is silent below a length of √(D66/H), h/√10 of
one isotropic ply, in two places, and both count:

Where its moments are singular (ends of clamped edges, notches, forces at points), ∫ Q² has no bound; with shear,
moments are smooth over that length. So Q is averaged over patches of √10 √(D66/H), h of one ply: cells that are
finer tell no more than these do.

At edges that are free to turn along themselves it lets the twisting moment M_ns end as forces. With shear it falls to
zero there in a layer e^(-s/c), c = √(D/H), with the twisting stiffness D = D66 - D16²/D11 at M_n = 0, and stores
½ ∮ M_ns² / √(D H) ds more. Of a rod of b by h this is the 0.63 h/b in Saint-Venant's b h³/3 (1 - 0.63 h/b). Along the
edge M_ns is smoothed over c. An element with shear shows such a layer where its cells are finer; where they are
coarser, M_ns does not fall to zero on them, and what the formula says of it is what they miss. Source of the layer:
E. Reissner, On the theory of transverse bending of elastic plates, Int. J. Solids Structures 12, 1976.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import spsolve

from lamc.basics.checks import Array
from lamc.plates.dofs import edge_nodes
from lamc.plates.elements.definition import CORNERS
from lamc.plates.laminates.laminate import Laminate
from lamc.plates.loads import EdgeMoment
from lamc.plates.meshing.mesh import Integers

if TYPE_CHECKING:
    from lamc.plates.answers.solution import Solution
    from lamc.plates.meshing.mesh import Mesh

# How much of the slope along an edge is free, over that across it, in squares: 1 where both are, tan² of half a turn
# where a curve of chords is held, which `supports.py` takes for a corner from 80° on.
_FREE = math.tan(math.radians(40.0)) ** 2


@dataclass(frozen=True)
class ShearEnergy:
    """Of one solution.

    inside  J, of shear forces
    along   J, of layers along free edges
    layer   m, how wide these are, and
    cells   m, how long the edges of cells there are; both in the mean over the energy, 0 without layers
    bent    J, of what bends, and of springs of hinges and elastic ground, which deflect with it
    """

    inside: float
    along: float
    layer: float
    cells: float
    bent: float

    @property
    def missed(self) -> float:
        """Of layers over bending, what an element with shear has left out on these cells; the part of `along` is
        measured, from 0.8 on cells four times as long as a layer is wide to 0.3 on half as long ones."""
        if not (self.along > 0.0 and self.bent > 0.0):
            return 0.0
        return self.along / self.bent * self.cells / (self.cells + self.layer)

    @property
    def share(self) -> float:
        """Of shear over bending; 0 where nothing bends."""
        return (self.inside + self.along) / self.bent if self.bent > 0.0 else 0.0


@dataclass(frozen=True, eq=False)
class _Edges:
    """cell (b,); corners (b, 2), of the cell, and nodes (b, 2) at the ends; along (b, 2), of length 1; hinged (b,):
    whether the plate may rotate about the edge, so that M_n is given."""

    cell: Integers
    corners: Integers
    nodes: Integers
    along: Array
    hinged: NDArray[np.bool_]


def shear_energy(solution: "Solution", strains: Array, *, layers_only: bool = False) -> ShearEnergy:
    """From `strains` at the corners of cells, (m, c, 3 or 6). layers_only: nothing inside, which an element with shear
    has."""
    problem = solution.problem
    mesh, stretches = problem.mesh, problem.dofs.element.stretches
    laws = [_laws(laminate, stretches) for laminate in problem.laminates]
    law, neutral, softness = (np.array(part)[mesh.regions] for part in zip(*laws, strict=True))
    cells = np.arange(len(mesh.cells), dtype=np.int32)
    free = [solution.expansion.at(cells, mesh.corners[:, k])[:, -3:] for k in range(mesh.corner_count)]
    moments = np.einsum("mij,mcj->mci", law, strains) - np.stack(free, axis=1)
    curvature = strains[..., -3:]
    bent = 0.5 * float(np.einsum("m,mci,mij,mcj->", mesh.areas, curvature, neutral, curvature))
    inside = 0.0 if layers_only else _inside(mesh, moments, neutral, softness)
    layers = _along_edges(solution, moments, neutral, softness)
    return ShearEnergy(inside, *layers, bent / mesh.corner_count + solution.spring_energy)


def neutral_bending(laminate: Laminate) -> Array:
    """D about the neutral surface, (3, 3)."""
    return np.asarray(laminate.D - laminate.B @ np.linalg.solve(laminate.A, laminate.B))


def _laws(laminate: Laminate, stretches: bool) -> tuple[Array, Array, Array]:
    """Moments by strains (3, 3 or 6), bending about the neutral surface (3, 3), H⁻¹."""
    law = np.concatenate([laminate.B, laminate.D], axis=1) if stretches else laminate.D
    return np.asarray(law), neutral_bending(laminate), np.asarray(np.linalg.inv(laminate.H), dtype=float)


def _inside(mesh: "Mesh", moments: Array, neutral: Array, softness: Array) -> float:
    """½ ∫ Qᵀ H⁻¹ Q dA of averages of Q, J."""
    slopes = np.einsum("mca,mci->mai", _gradients(mesh), moments)
    Q = np.stack([slopes[:, 0, 0] + slopes[:, 1, 2], slopes[:, 0, 2] + slopes[:, 1, 1]], axis=1)
    # Means over all directions of the laminate, so that the patches do not depend on the axes.
    twisting = neutral[:, 0, 0] + neutral[:, 1, 1] - 2.0 * neutral[:, 0, 1] + 4.0 * neutral[:, 2, 2]
    yielding = 0.5 * (softness[:, 0, 0] + softness[:, 1, 1])
    patch = _patches(mesh, np.sqrt(10.0 * twisting / 8.0 * yielding))
    area = np.bincount(patch, mesh.areas)
    mean = np.stack([np.bincount(patch, mesh.areas * Q[:, i]) / area for i in (0, 1)], axis=1)[patch]
    return 0.5 * float(np.einsum("m,mi,mij,mj->", mesh.areas, mean, softness, mean))


def _patches(mesh: "Mesh", width: Array) -> Integers:
    """Numbers (m,) of patches: cells of one region that hang together within one box of `width` (m,), m."""
    centre = mesh.corners.mean(axis=1)
    box = np.floor((centre - centre.min(axis=0)) / width[:, None])
    key = np.column_stack([box, mesh.regions])
    edges = mesh.cell_edges.ravel()
    order = np.argsort(edges, kind="stable")
    cell = order // mesh.corner_count
    beside = edges[order[1:]] == edges[order[:-1]]
    a, b = cell[:-1][beside], cell[1:][beside]
    same = (key[a] == key[b]).all(axis=1)
    count = len(mesh.cells)
    graph = sparse.coo_array((np.ones(int(same.sum())), (a[same], b[same])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1])


def _along_edges(
    solution: "Solution", moments: Array, neutral: Array, softness: Array
) -> tuple[float, float, float]:
    """½ ∮ M_ns² / √(D H) ds of the layers, J; their width and the length of edges in the mean over it, m. M_ns is
    smoothed by s - c² s'' = M_ns along each line of free edges."""
    mesh = solution.problem.mesh
    edges = _free_edges(solution)
    cell, ends, along = edges.cell, edges.corners, edges.along
    if not len(cell):
        return 0.0, 0.0, 0.0
    tx, ty = along.T
    nx, ny = ty, -tx
    twist = np.stack([nx * tx, ny * ty, nx * ty + ny * tx], axis=1)  # M_ns of M
    bend = np.stack([nx * nx, ny * ny, 2.0 * nx * ny], axis=1)  # M_n of M
    D11, D16, D66 = (
        np.einsum("bi,bij,bj->b", first, neutral[cell], second)
        for first, second in ((bend, bend), (bend, twist), (twist, twist))
    )
    share = np.where(edges.hinged, D16 / D11, 0.0)
    stiff = D66 - share * D16
    soft = np.einsum("bi,bij,bj->b", along, softness[cell], along)
    found = moments[cell[:, None], ends]
    twisting = np.einsum("bei,bi->be", found, twist)
    if not any(isinstance(load, EdgeMoment) for load in solution.loads):
        # M_n is zero there, and what a mesh has of it is an error of the curvature across, which is in M_ns too.
        twisting -= share[:, None] * np.einsum("bei,bi->be", found, bend)
    twisting *= (soft / stiff)[:, None] ** 0.25
    length = np.hypot(*(mesh.corners[cell, ends[:, 1]] - mesh.corners[cell, ends[:, 0]]).T)
    matrix, right = _smoothing(edges.nodes, length, stiff * soft, twisting)
    weight = length * np.sum(twisting**2, axis=1)
    weight /= max(float(weight.sum()), np.finfo(float).tiny)
    energy = 0.5 * float(right @ spsolve(matrix, right))
    return energy, float(weight @ np.sqrt(stiff * soft)), float(weight @ length)


def _smoothing(
    nodes: Integers, length: Array, square: Array, values: Array
) -> tuple[sparse.csc_array, Array]:
    """Of s - c² s'' = values along edges between `nodes` (b, 2), with `square` c² (b,), m², and values at their ends
    (b, 2), linear between: the matrix of the unknowns at nodes, and the right side."""
    _, index = np.unique(nodes, return_inverse=True)
    index = index.reshape(nodes.shape)
    mass = (length / 6.0)[:, None, None] * (1.0 + np.eye(2))
    bent = (square / length)[:, None, None] * (2.0 * np.eye(2) - 1.0)
    right = np.zeros(int(index.max()) + 1)
    np.add.at(right, index, np.einsum("bij,bj->bi", mass, values))
    rows, columns = np.repeat(index, 2, axis=1).ravel(), np.tile(index, 2).ravel()
    matrix = sparse.coo_array(((mass + bent).ravel(), (rows, columns)), shape=(len(right), len(right)))
    return sparse.csc_array(matrix), right


def _free_edges(solution: "Solution") -> _Edges:
    """Edges of the boundary that turn freely along themselves, at one end at least. None do of an element without
    slopes at its corners."""
    dofs, mesh = solution.problem.dofs, solution.problem.mesh
    cell, edge = mesh.boundary_edges.T
    local = np.array([(on[0], on[-1]) for on in edge_nodes(dofs.element)])
    nodes = dofs.of_nodes[cell[:, None], local[edge]]
    corners = np.stack([edge, (edge + 1) % mesh.corner_count], axis=1)
    along = mesh.corners[cell, corners[:, 1]] - mesh.corners[cell, corners[:, 0]]
    along /= np.hypot(*along.T)[:, None]
    by_x, by_y = dofs.of("w_x")[nodes].ravel(), dofs.of("w_y")[nodes].ravel()
    if (by_x < 0).any() or (by_y < 0).any():
        none = np.zeros(0, dtype=np.int32)
        return _Edges(none, corners[:0], nodes[:0], along[:0], np.zeros(0, dtype=bool))
    tx, ty = np.repeat(along, 2, axis=0).T
    free = solution.free_unknowns
    X, Y = free[by_x], free[by_y]
    same, across = (
        np.asarray((sparse.diags_array(a) @ X + sparse.diags_array(b) @ Y).power(2).sum(axis=1)).ravel()
        for a, b in ((tx, ty), (ty, -tx))
    )
    tiny = np.finfo(float).eps
    loose = np.any((same > np.maximum(_FREE * across, tiny)).reshape(nodes.shape), axis=1)
    rotations = np.any((across > tiny).reshape(nodes.shape), axis=1)
    return _Edges(cell[loose], corners[loose], nodes[loose], along[loose], rotations[loose])


def _gradients(mesh: "Mesh") -> Array:
    """At the centres of cells, of the functions that are 1 at one corner and linear or bilinear between, (m, c, 2),
    1/m."""
    if mesh.corner_count == 3:
        natural = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    else:
        natural = 0.25 * np.array(CORNERS["square"], dtype=float)
    jacobian = np.einsum("ca,mci->mai", natural, mesh.corners)  # rows by ξ and η
    return np.asarray(np.linalg.solve(jacobian[:, None], natural[None, :, :, None])[..., 0])

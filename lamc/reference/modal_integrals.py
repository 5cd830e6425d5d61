"""Mass and stiffness of a body's shapes, integrated by the reference elements, beside those that the equations have.

In: an effect that lets bodies bend. Out: comparisons. The integrals here owe nothing to the compiled elements nor to
the eigenproblem that the shapes come from. The shapes themselves are given, their values at points among them.
"""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lamc.mechanics.arranging import arrange
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism
from lamc.reference.check_report import Comparison, Largest
from lamc.reference.kinematics import Array
from lamc.reference.plate_elements import ReferenceElement
from lamc.reference.plate_layout import CORNERS, Layout

if TYPE_CHECKING:
    from lamc.plates.answers.reduction import Reduction
    from lamc.plates.laminates.laminate import Laminate

_ENTRIES = np.triu_indices(3)
LIMIT = 1e-12  # of sums in which nothing cancels
ROUND_OFF = 2.2e-16  # a unit in the last place, of the sum of sizes where much cancels
_REASON = "quadrature against exact integrals; round-off of a sum over cells, times what cancels in it"
_CROSS_CHECKS = ("equations", "quadrature")


def modal_integrals(mechanism: Mechanism, effects: Iterable[Any]) -> list[Comparison]:
    """Of each body that an effect `flexible_links` bends: G, K, s and X of its record. Nothing without such a body.

    Differences are relative to the diagonals. Strains of a fine mesh are left-overs of deflections: what their sizes
    sum up to, times round-off, is the limit for K.
    """
    effects, tree = tuple(effects), plan(mechanism)
    bending = next((effect for effect in effects if effect.name == "flexible_links"), None)
    if bending is None:
        return []
    records = {record.body: record for record in arrange(tree, effects).flexible}
    found: list[Comparison] = []
    for body, plate, reduced in bending.reductions(tree):
        record, about = records[body], np.array([0.0, 0.0, plate.height]) - mechanism.body(body).com
        G, K, moments, sizes = _integrals(reduced, about)
        lost = 0.0
        for title, own, other in (("modal mass", G, record.mass), ("modal stiffness", K, record.stiffness)):
            diagonal = np.sqrt(np.diag(own))
            scale = np.outer(diagonal, diagonal)
            if title == "modal stiffness":
                lost = ROUND_OFF * float((sizes / scale).max())
            found.append(_compared(title, body, other / scale, own / scale, max(LIMIT, lost)))
        weights = np.sqrt(record.mass.diagonal() * mechanism.body(body).mass)[:, None]
        arms = np.array([1.0, *(3 * [mechanism.size])])
        both = (np.column_stack([record.moment, record.first_moment]), moments)
        ours, theirs = (each / (weights * arms) for each in both)
        found.append(_compared("modal moments", body, ours, theirs, LIMIT))
    return found


def _compared(title: str, body: str, found: Array, expected: Array, limit: float) -> Comparison:
    modes = tuple(f"{body}.mode_{k + 1}" for k in range(len(found)))
    largest = Largest(modes, _CROSS_CHECKS)
    largest.add(found, expected, "", 1.0)
    return largest.comparison(title, limit, _REASON)


def _integrals(reduction: "Reduction", about: Array) -> tuple[Array, Array, Array, Array]:
    """G (k, k), kg; K (k, k), N/m; s, kg, beside X, kg·m, (k, 4); and the sums of sizes of K, (k, k), N/m.

    about: from the point that X is about to the reference surface at x = y = 0, (3,), m
    """
    problem = reduction.problem
    element, corners = ReferenceElement(problem.dofs.element.name), problem.mesh.corners
    own, cells = element.element, problem.mesh.regions
    laminates: Sequence[Laminate] = problem.laminates
    shapes = reduction.vectors[problem.dofs.of_cells]  # (m, n, k)
    bent = shapes * np.array([name not in ("u", "v") for name in own.dofs])[None, :, None]
    thin = np.array([sum(p.material.density * p.thickness for p in each.plies) for each in laminates])
    lifted = np.array([_lifted(each) for each in laminates])
    mass, high = (element.mass(corners, values[cells]) for values in (thin, lifted))
    rigid = _rigid(own, corners)
    fields = np.concatenate([mass @ rigid, (high @ rigid[:, :, :1])], axis=2)  # of 1, x, y and z
    parts = [[each.A, each.B, each.D] if own.stretches else [each.D] for each in laminates]
    sections = np.array([np.concatenate([part[_ENTRIES] for part in each]) for each in parts])[cells]
    pulls = np.stack(
        [element.force(corners, sections, shapes[:, :, k]) for k in range(shapes.shape[2])], axis=2
    )
    moved = np.eye(4)
    moved[0, 1:] = about
    moments = np.tensordot(bent, fields, axes=([0, 1], [0, 1])) @ moved
    G, K = (np.tensordot(a, b, axes=([0, 1], [0, 1])) for a, b in ((bent, mass @ bent), (shapes, pulls)))
    sizes = np.abs(element.stiffness(corners, sections)) @ np.abs(shapes)
    return G, K, moments, np.tensordot(np.abs(shapes), sizes, axes=([0, 1], [0, 1]))


def _rigid(own: Layout, corners: Array) -> Array:
    """w = 1, x and y as unknowns of the cells, (m, n, 3)."""
    fields = np.zeros((len(corners), len(own.dofs), 3))
    row = 0
    for node in own.nodes:
        for name in node.dofs:
            if name == "w":
                at = corners[:, CORNERS[own.cell].index(node.at)]
                fields[:, row] = np.column_stack([np.ones(len(at)), at])
            elif name in ("w_x", "w_y"):
                fields[:, row, 1 + ("w_x", "w_y").index(name)] = 1.0
            row += 1
    return fields


def _lifted(laminate: "Laminate") -> float:
    """∫ρ z dz, kg/m, from the reference surface."""
    middles = laminate.heights.mean(axis=1)
    return float(
        sum(p.material.density * p.thickness * z for p, z in zip(laminate.plies, middles, strict=True))
    )

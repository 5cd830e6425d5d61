"""Stiffness and what else comes from an element's strains: forces, prestress, and the strains themselves.

In: a staged cell. Out: staged outputs, and points of quadrature where a sum over them is left to the caller. Never:
inertia, loads on the surface.
"""

from collections.abc import Sequence
from typing import TypeAlias

from lamc.plates.elements.affine import forces_of_amounts, stiffness_of_amounts
from lamc.plates.elements.cell import Cell
from lamc.plates.elements.factor import plain
from lamc.plates.elements.polynomials import inner
from lamc.plates.elements.quadrature import Point, square_points
from lamc.plates.elements.sums import lower_triangle, weighted_sum
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, reciprocal

# Sums over points of more operations than this are left to a loop: compilers take long over long straight code.
_MAX_STRAIGHT = 3000

Found: TypeAlias = tuple[list[Scalar], tuple[Point, ...]]


def stiffness(cell: Cell) -> Found:
    """Lower triangle by rows."""
    chain = cell.chain
    with cell.store.section("stiffness against these amounts", source="K = ∫ B^T S B dA"):
        found, points = _stiffness(cell)
    with cell.store.section("stiffness against the unknowns", source="W^T K W"):
        return lower_triangle(chain.matrix(found)), points


def _stiffness(cell: Cell) -> tuple[list[list[Scalar]], tuple[Point, ...]]:
    if cell.element.is_affine:
        return stiffness_of_amounts(cell.strains, cell.frame, cell.section, cell.element.cell), ()
    points = square_points(cell.element.degree)
    count = len(cell.strains[0].part.basis)
    if 3 * count * count * len(points) > _MAX_STRAIGHT:
        return _stiffness_at(cell, *cell.natural), points
    total: list[list[Scalar]] = [[0] * count for _ in range(count)]
    for point in points:
        found = _stiffness_at(cell, *point)
        total = [[s + a for s, a in zip(*rows, strict=True)] for rows in zip(total, found, strict=True)]
    return total, ()


def force(cell: Cell) -> Found:
    """Per unknown."""
    amounts = cell.amounts
    with cell.store.section("forces on these amounts, from strains", source="∫ B^T S ε dA"):
        found, points = _force(cell, amounts)
    with cell.store.section("forces on the unknowns"):
        return cell.chain.forces(found), points


def _force(cell: Cell, amounts: Sequence[Scalar]) -> tuple[list[Scalar], tuple[Point, ...]]:
    if cell.element.is_affine:
        return forces_of_amounts(cell.strains, cell.frame, cell.section, amounts, cell.element.cell), ()
    points = square_points(cell.element.degree)
    if 12 * len(amounts) * len(points) > _MAX_STRAIGHT:
        return _force_at(cell, amounts, *cell.natural), points
    total: list[Scalar] = [0] * len(amounts)
    for point in points:
        total = [s + f for s, f in zip(total, _force_at(cell, amounts, *point), strict=True)]
    return total, ()


def _rows_at(cell: Cell, xi: Scalar, eta: Scalar) -> list[list[Scalar]]:
    """determinant · B of a membrane for its amounts at a point, (3, amounts)."""
    (strain_,) = cell.strains
    rotation = [[cell.varying(entry, xi, eta) for entry in row] for row in strain_.rows]
    natural = [[cell.value(p, xi, eta) for p in rows] for rows in strain_.part.basis]
    return [[weighted_sum(zip(row, values, strict=True)) for values in natural] for row in rotation]


def _section_at(cell: Cell, xi: Scalar, eta: Scalar, weight: Scalar) -> list[list[Scalar]]:
    """The section times weight / determinant at a point."""
    factor = weight * reciprocal(cell.varying(cell.frame.determinant, xi, eta))
    return [[factor * entry for entry in row] for row in cell.section]


def _stiffness_at(cell: Cell, xi: Scalar, eta: Scalar, weight: Scalar) -> list[list[Scalar]]:
    B = _rows_at(cell, xi, eta)
    S = _section_at(cell, xi, eta, weight)
    count = len(B[0])
    SB = [[weighted_sum((B[b][m], S[a][b]) for b in range(3)) for m in range(count)] for a in range(3)]
    result: list[list[Scalar]] = [[0] * count for _ in range(count)]
    for m in range(count):
        for n in range(m + 1):
            result[m][n] = result[n][m] = weighted_sum((B[a][m], SB[a][n]) for a in range(3))
    return result


def _force_at(cell: Cell, amounts: Sequence[Scalar], xi: Scalar, eta: Scalar, weight: Scalar) -> list[Scalar]:
    B = _rows_at(cell, xi, eta)
    strains = [weighted_sum(zip(row, amounts, strict=True)) for row in B]
    stress = [weighted_sum(zip(row, strains, strict=True)) for row in _section_at(cell, xi, eta, weight)]
    return [weighted_sum((B[a][m], stress[a]) for a in range(3)) for m in range(len(amounts))]


def prestress(cell: Cell) -> list[Scalar]:
    """Per unknown, from membrane forces and moments that are the same all over the cell; none of shear."""
    parts = cell.strains[:-1] if cell.element.shear else cell.strains
    resultants = cell.symbols("r", Space.RESULTANT, 3 * len(parts))
    result: list[Scalar] = []
    for k, strain_ in enumerate(parts):
        own = resultants[3 * k : 3 * k + 3]
        if strain_.power > 1:
            divisor = reciprocal(cell.varying(cell.frame.determinant, 0, 0))
            own = [divisor * r for r in own]
        for rows in strain_.part.basis:
            terms = []
            for r, p in enumerate(rows):
                shared: dict[Scalar, list[tuple[Scalar, Scalar]]] = {}
                for a in range(3):
                    for q, factor in strain_.rows[a][r]:
                        c = inner(p, q, cell.element.cell)
                        if c:
                            shared.setdefault(plain(c), []).append((factor, own[a]))
                terms += [(c, weighted_sum(parts)) for c, parts in shared.items()]
            result.append(weighted_sum(terms))
    result += [0] * sum(len(strain_.part.basis) for strain_ in cell.strains[len(parts) :])
    return cell.chain.forces(result)


def strain(cell: Cell) -> list[Scalar]:
    """Membrane strain, then curvature, at ξ, η."""
    return _at_point(cell)[: 3 * cell.element.stretches + 3 * cell.element.bends]


def shear(cell: Cell) -> list[Scalar]:
    """γ_x and γ_y through the thickness at ξ, η."""
    return _at_point(cell)[-2:]


def _at_point(cell: Cell) -> list[Scalar]:
    """All strains at ξ, η."""
    xi, eta, _ = cell.natural
    divisor = reciprocal(cell.varying(cell.frame.determinant, xi, eta))
    result: list[Scalar] = []
    at = 0
    for strain_ in cell.strains:
        amounts = cell.amounts[at : at + len(strain_.part.basis)]
        at += len(amounts)
        natural = [
            weighted_sum(
                (cell.value(rows[r], xi, eta), amount)
                for rows, amount in zip(strain_.part.basis, amounts, strict=True)
            )
            for r in range(len(strain_.rows[0]))
        ]
        for row in strain_.rows:
            rotated = weighted_sum((cell.varying(e, xi, eta), n) for e, n in zip(row, natural, strict=True))
            result.append(divisor**strain_.power * rotated)
    return result

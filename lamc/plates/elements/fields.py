"""What comes from an element's displacements: mass, loads, geometric stiffness, and displacements at a point.

In: a staged cell. Out: staged outputs, all integrated exactly. Never: strains or sections.
"""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from lamc.plates.elements.affine import moments
from lamc.plates.elements.cell import Cell
from lamc.plates.elements.cell_map import Varying, constant, scaled
from lamc.plates.elements.factor import factored, gradient, plain, value
from lamc.plates.elements.polynomials import Polynomial, hats, inner, product
from lamc.plates.elements.strains import Chain, Part, slopes_part
from lamc.plates.elements.sums import lower_triangle, weighted_sum
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, reciprocal


def mass(cell: Cell) -> list[Scalar]:
    """Lower triangle by rows."""
    count = len(cell.element.dofs)
    (rho,) = cell.symbols("rho", Space.AREAL_MASS, 1)
    weights = scaled(cell.frame.determinant, rho)
    total: list[list[Scalar]] = [[0] * count for _ in range(count)]
    for name in cell.element.fields:
        part = _field(cell, name)
        functions = [rows[0] for rows in part.basis]
        found = [[_integrated(product(p, q), weights, cell) for q in functions] for p in functions]
        own = part.chain.matrix(found)
        total = [[s + m for s, m in zip(*rows, strict=True)] for rows in zip(total, own, strict=True)]
    return lower_triangle(total)


def load(cell: Cell) -> list[Scalar]:
    """Per unknown, from forces per area at the corners, field after field."""
    fields, corners = cell.element.fields, cell.element.corner_count
    intensity = cell.symbols("p", Space.INTENSITY, len(fields) * corners)
    total: list[Scalar] = [0] * len(cell.element.dofs)
    for k, name in enumerate(fields):
        part = _field(cell, name)
        own = intensity[k * corners : (k + 1) * corners]
        found: list[Scalar] = [0] * len(part.basis)
        for between, factor in cell.frame.determinant:
            areal = [factor * p for p in own]
            for a, rows in enumerate(part.basis):
                shares = [
                    plain(inner(product(rows[0], hat), between, cell.element.cell))
                    for hat in hats(cell.element.cell)
                ]
                found[a] = found[a] + weighted_sum(zip(shares, areal, strict=True))
        total = [s + f for s, f in zip(total, part.chain.forces(found), strict=True)]
    return total


def geometric(cell: Cell) -> list[Scalar]:
    """Lower triangle by rows."""
    nx, ny, nxy = (
        cell.store.symbol(n, Space.MEMBRANE_FORCE, k) for k, n in enumerate(("N_x", "N_y", "N_xy"))
    )
    determinant = constant(cell.frame.determinant)
    part = _gradient(cell) if cell.element.shear else _slopes(cell)
    tension: list[list[Scalar]] = [[nx, nxy], [nxy, ny]]
    if cell.element.slopes and not cell.element.shear:
        natural = [[determinant * n for n in row] for row in tension]
    else:
        rotation = [[constant(entry) for entry in rows] for rows in (cell.frame.by_x, cell.frame.by_y)]
        shared = [[reciprocal(determinant) * n for n in row] for row in tension]
        half = [
            [weighted_sum((rotation[b][s], shared[a][b]) for b in range(2)) for s in range(2)]
            for a in range(2)
        ]
        low = weighted_sum((rotation[a][1], half[a][0]) for a in range(2))
        natural = [
            [weighted_sum((rotation[a][0], half[a][0]) for a in range(2)), low],
            [low, weighted_sum((rotation[a][1], half[a][1]) for a in range(2))],
        ]
    count = len(part.basis)
    terms: list[list[dict[tuple[int, int], Fraction]]] = [[{} for _ in range(count)] for _ in range(count)]
    for (a, b, r, s), c in moments(part.basis, part.basis, cell.element.cell).items():
        entry = terms[a][b]
        key = (min(r, s), max(r, s))
        entry[key] = entry.get(key, Fraction(0)) + c
    found = [
        [weighted_sum((plain(c), natural[r][s]) for (r, s), c in sorted(entry.items())) for entry in row]
        for row in terms
    ]
    return lower_triangle(part.chain.matrix(found))


def displacement(cell: Cell) -> list[Scalar]:
    """u, v, then w, w_x, w_y, at ξ, η."""
    xi, eta, _ = cell.natural
    result: list[Scalar] = []
    for name in cell.element.fields:
        part = _field(cell, name)
        result += _at(cell, part, part.chain.amounts(cell.unknowns), xi, eta)
    if cell.element.bends:
        part = _slopes(cell)
        natural = _at(cell, part, part.chain.amounts(cell.unknowns), xi, eta)
        if not cell.element.slopes:
            divisor = reciprocal(constant(cell.frame.determinant))
            rotations = [[constant(entry) for entry in rows] for rows in (cell.frame.by_x, cell.frame.by_y)]
            natural = [divisor * weighted_sum(zip(rotation, natural, strict=True)) for rotation in rotations]
        result += natural
    return result


def _at(cell: Cell, part: Part, amounts: Sequence[Scalar], xi: Scalar, eta: Scalar) -> list[Scalar]:
    return [
        weighted_sum(
            (cell.value(rows[r], xi, eta), amount) for rows, amount in zip(part.basis, amounts, strict=True)
        )
        for r in range(len(part.basis[0]))
    ]


def _field(cell: Cell, name: str) -> Part:
    functions = getattr(cell.element, name)
    found = factored(cell.geometry, [(f,) for f in functions], value)
    return Part(found.basis, Chain((found.weights,), (len(cell.element.dofs),)))


def _slopes(cell: Cell) -> Part:
    """By ξ and η, or w_x and w_y where they have shape functions of their own; without the bows of edges where these
    are shared with shear, so that no section is asked for."""
    if cell.element.shear:
        edges = cell.element.corner_count
        slopes, amounts = cell.element.slopes, cell.element.amounts[:-edges]
        straight = replace(
            cell.element, slopes=tuple(part[:-edges] for part in slopes), amounts=amounts, shear=False
        )
        return slopes_part(straight, cell.geometry, gradient_of_slopes=False)
    if cell.element.slopes:
        return slopes_part(cell.element, cell.geometry, gradient_of_slopes=False)
    return _gradient(cell)


def _gradient(cell: Cell) -> Part:
    """Of w, by ξ and η."""
    found = factored(cell.geometry, [(f,) for f in cell.element.w], gradient)
    return Part(found.basis, Chain((found.weights,), (len(cell.element.dofs),)))


def _integrated(polynomial: Polynomial, weights: Varying, cell: Cell) -> Scalar:
    return weighted_sum((plain(inner(polynomial, p, cell.element.cell)), f) for p, f in weights)

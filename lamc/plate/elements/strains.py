"""Strains of an element by amounts that vanish in rigid motion, and the stiffness against these amounts.

In: shape functions, factored. Out: per part (membrane, bending) a basis of strains, the chain of weights from unknowns
to amounts, and the map from natural derivatives to strains. Never: loads or inertia.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import gcd, lcm

import sympy as sp

from lamc.mechanics.staging import Scalar, reciprocal
from lamc.mechanics.sympy_view import from_sympy
from lamc.plate.elements.definition import Element
from lamc.plate.elements.factor import Geometry, Rows, factored, gradient, hessian, plain, value
from lamc.plate.elements.frame import Frame, Varying, bending_rows, constant, stretching_rows
from lamc.plate.elements.polynomials import inner, monomial_integral
from lamc.plate.elements.sums import Sparse, applied, applied_transposed, congruence, weighted_sum


@dataclass(frozen=True)
class Chain:
    """Weights one after the other: basis amounts = first · (second · … unknowns)."""

    links: tuple[Sparse, ...]
    widths: tuple[int, ...]  # columns of each link

    def amounts(self, unknowns: Sequence[Scalar]) -> list[Scalar]:
        values = list(unknowns)
        for link in reversed(self.links):
            values = applied(link, values)
        return values

    def forces(self, values: Sequence[Scalar]) -> list[Scalar]:
        """The transposed map: from what works on the amounts to what works on the unknowns."""
        result = list(values)
        for link, width in zip(self.links, self.widths, strict=True):
            result = applied_transposed(link, result, width)
        return result

    def matrix(self, values: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
        result = [list(row) for row in values]
        for link, width in zip(self.links, self.widths, strict=True):
            result = congruence(result, link, width)
        return result


@dataclass(frozen=True)
class Part:
    """Some rows of one field: Σ_m basis_m · amount_m."""

    basis: tuple[Rows, ...]
    chain: Chain


@dataclass(frozen=True)
class Strain:
    """One of membrane and bending: 3 strains = rows · natural derivatives / determinant^power."""

    part: Part
    rows: tuple[tuple[Varying, ...], ...]
    power: int


def membrane(element: Element, geometry: Geometry, frame: Frame) -> Strain:
    found = factored(geometry, list(zip(element.u, element.v, strict=True)), gradient)
    chain = Chain((found.weights,), (len(element.dofs),))
    return Strain(Part(found.basis, chain), stretching_rows(frame, 1), 1)


def bending(element: Element, geometry: Geometry, frame: Frame) -> Strain:
    if element.slopes:
        return Strain(slopes_part(element, geometry, gradient_of_slopes=True), stretching_rows(frame, -1), 1)
    found = factored(geometry, [(w,) for w in element.w], hessian)
    return Strain(Part(found.basis, Chain((found.weights,), (len(element.dofs),))), bending_rows(frame), 2)


def slopes_part(element: Element, geometry: Geometry, *, gradient_of_slopes: bool) -> Part:
    """w_x and w_y, or their natural derivatives, where they have shape functions of their own."""
    found = factored(
        geometry, list(zip(*element.slopes, strict=True)), gradient if gradient_of_slopes else value
    )
    count = len(element.dofs)
    if not element.amounts:
        return Part(found.basis, Chain((found.weights,), (count,)))
    outer = _amounts(element, geometry)
    return Part(found.basis, Chain((found.weights, outer), (len(outer), count)))


def _amounts(element: Element, geometry: Geometry) -> Sparse:
    """Weights of the unknowns in each of `element.amounts`."""
    unknowns = element.unknowns
    rows: list[dict[int, Scalar]] = []
    for amount in element.amounts:
        weights = [sp.diff(amount, unknown) for unknown in unknowns]
        rows.append(
            {
                j: from_sympy(weight, geometry.known, geometry.store)
                for j, weight in enumerate(weights)
                if weight != 0
            }
        )
    return rows


def joined(strains: Sequence[Strain]) -> Chain:
    """The chain of several parts, one after the other, each padded to the same number of links."""
    depth = max(len(strain.part.chain.links) for strain in strains)
    links: list[Sparse] = []
    widths: list[int] = []
    for level in range(depth):
        rows: list[dict[int, Scalar]] = []
        width = 0
        for strain in strains:
            chain = strain.part.chain
            missing = depth - len(chain.links)
            if level < missing:
                count = len(strain.part.basis)
                rows += [{width + k: 1} for k in range(count)]
                width += count
            else:
                link = chain.links[level - missing]
                last = level == depth - 1
                rows += [{(0 if last else width) + j: w for j, w in row.items()} for row in link]
                own = chain.widths[level - missing]
                width = own if last else width + own
        links.append(rows)
        widths.append(width)
    return Chain(tuple(links), tuple(widths))


def moments(
    first: Sequence[Rows], second: Sequence[Rows], cell: str
) -> dict[tuple[int, int, int, int], Fraction]:
    """∫ first_a row r · second_b row s over the natural cell, by (a, b, r, s); zeros left out."""
    result = {}
    for a, rows in enumerate(first):
        for b, others in enumerate(second):
            for r, p in enumerate(rows):
                for s, q in enumerate(others):
                    c = inner(p, q, cell)
                    if c:
                        result[a, b, r, s] = c
    return result


def common_measure(numbers: Sequence[Fraction]) -> Fraction:
    """The largest number of which all are whole multiples."""
    if not numbers:
        return Fraction(1)
    denominator = lcm(*(c.denominator for c in numbers))
    return Fraction(gcd(*(int(c * denominator) for c in numbers)), denominator)


def affine_force(
    strains: Sequence[Strain],
    frame: Frame,
    section: Sequence[Sequence[Scalar]],
    amounts: Sequence[Scalar],
    cell: str,
) -> list[Scalar]:
    """∫ Bᵀ S ε dA by amount, where the frame does not vary: exact, with ε in plate axes before S sees it.

    Strain and stress are polynomials in ξ and η, held by their coefficients. The natural section of `affine_stiffness`
    would be cheaper, but in a thin cell its entries cancel.
    """
    determinant = constant(frame.determinant)
    powers = sorted({key for strain in strains for rows in strain.part.basis for p in rows for key in p})
    turns = [[[constant(entry) for entry in row] for row in strain.rows] for strain in strains]
    own, at = [], 0
    for strain in strains:
        own.append(amounts[at : at + len(strain.part.basis)])
        at += len(strain.part.basis)
    stress: dict[tuple[int, int], list[Scalar]] = {}
    for key in powers:
        strain_: list[Scalar] = []
        for strain, turn, values in zip(strains, turns, own, strict=True):
            natural = [
                weighted_sum(
                    (plain(rows[r].get(key, Fraction(0))), v)
                    for rows, v in zip(strain.part.basis, values, strict=True)
                )
                for r in range(len(turn[0]))
            ]
            divisor = reciprocal(determinant) ** strain.power
            strain_ += [divisor * weighted_sum(zip(row, natural, strict=True)) for row in turn]
        stress[key] = [weighted_sum(zip(row, strain_, strict=True)) for row in section]
    result: list[Scalar] = []
    for k, (strain, turn) in enumerate(zip(strains, turns, strict=True)):
        scale = determinant * reciprocal(determinant) ** strain.power
        works: dict[tuple[int, int], list[Scalar]] = {}
        for key in powers:  # the stress's inner product with this monomial, turned to natural derivatives
            gathered = [
                scale
                * weighted_sum(
                    (plain(monomial_integral(key[0] + i, key[1] + j, cell)), stress[i, j][3 * k + a])
                    for i, j in powers
                )
                for a in range(3)
            ]
            works[key] = [
                weighted_sum((turn[a][r], gathered[a]) for a in range(3)) for r in range(len(turn[0]))
            ]
        result += [
            weighted_sum((plain(c), works[key][r]) for r, p in enumerate(rows) for key, c in p.items())
            for rows in strain.part.basis
        ]
    return result


def affine_stiffness(
    strains: Sequence[Strain], frame: Frame, section: Sequence[Sequence[Scalar]], cell: str
) -> list[list[Scalar]]:
    """∫ Bᵀ S B dA against the amounts of all parts, where the frame does not vary: exact.

    S is turned to natural derivatives once; products of the basis functions are integrated as rationals.
    """
    determinant = constant(frame.determinant)
    turns = [[[constant(entry) for entry in row] for row in strain.rows] for strain in strains]
    offsets = [sum(len(strain.part.basis) for strain in strains[:k]) for k in range(len(strains) + 1)]
    result: list[list[Scalar]] = [[0] * offsets[-1] for _ in range(offsets[-1])]
    for i, first in enumerate(strains):
        for j, second in enumerate(strains[: i + 1]):
            found = moments(first.part.basis, second.part.basis, cell)
            measure = common_measure(list(found.values()))
            scale = plain(measure) * reciprocal(determinant) ** (first.power + second.power - 1)
            block = [[scale * section[3 * i + a][3 * j + b] for b in range(3)] for a in range(3)]
            natural = _turned(block, turns[i], turns[j])
            terms: dict[tuple[int, int], list[tuple[Scalar, Scalar]]] = {}
            for (a, b, r, s), c in found.items():
                if i != j or a >= b:
                    terms.setdefault((a, b), []).append((plain(c / measure), natural[r][s]))
            for (a, b), parts in terms.items():
                row, column = offsets[i] + a, offsets[j] + b
                result[row][column] = result[column][row] = weighted_sum(_merged(parts))
    return result


def _merged(terms: Sequence[tuple[Scalar, Scalar]]) -> list[tuple[Scalar, Scalar]]:
    """One term per value: S_rs and S_sr are the same."""
    factors: dict[Scalar, Scalar] = {}
    for factor, value_ in terms:
        factors[value_] = factors.get(value_, 0) + factor
    return [(factor, value_) for value_, factor in factors.items() if factor != 0]


def _turned(
    block: Sequence[Sequence[Scalar]], left: Sequence[Sequence[Scalar]], right: Sequence[Sequence[Scalar]]
) -> list[list[Scalar]]:
    """leftᵀ · block · right; left and right are (3, natural derivatives)."""
    half = [
        [weighted_sum((right[b][s], row[b]) for b in range(3)) for s in range(len(right[0]))] for row in block
    ]
    if left is not right:
        return [
            [weighted_sum((left[a][r], half[a][s]) for a in range(3)) for s in range(len(right[0]))]
            for r in range(len(left[0]))
        ]
    count = len(left[0])
    result: list[list[Scalar]] = [[0] * count for _ in range(count)]
    for r in range(count):
        for s in range(r + 1):
            result[r][s] = result[s][r] = weighted_sum((left[a][r], half[a][s]) for a in range(3))
    return result

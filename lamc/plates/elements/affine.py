"""Stiffness and forces of cells whose ξ and η are linear in x and y: exact, without points of quadrature.

In: strains in factors, a frame that does not vary, a staged section. Out: staged stiffness against the amounts of the
strains, or forces on them. Never: unknowns.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import gcd, lcm
from typing import TypeAlias

from lamc.plates.elements.cell_map import CellMap, constant
from lamc.plates.elements.factor import Rows, plain
from lamc.plates.elements.polynomials import inner, monomial_integral
from lamc.plates.elements.strains import Strain
from lamc.plates.elements.sums import weighted_sum
from lamc.symbolic.scalars import Scalar, reciprocal

Powers: TypeAlias = tuple[int, int]  # of ξ and η


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


def stiffness_of_amounts(
    strains: Sequence[Strain], frame: CellMap, section: Sequence[Sequence[Scalar]], cell: str
) -> list[list[Scalar]]:
    """∫ Bᵀ S B dA against the amounts of all parts, where the frame does not vary: exact.

    S is turned to natural derivatives once; products of the basis functions are integrated as rationals.
    """
    determinant = constant(frame.determinant)
    rotations = [[[constant(entry) for entry in row] for row in strain.rows] for strain in strains]
    offsets = [sum(len(strain.part.basis) for strain in strains[:k]) for k in range(len(strains) + 1)]
    first_row = [sum(len(strain.rows) for strain in strains[:k]) for k in range(len(strains))]
    result: list[list[Scalar]] = [[0] * offsets[-1] for _ in range(offsets[-1])]
    for i, first in enumerate(strains):
        for j, second in enumerate(strains[: i + 1]):
            found = moments(first.part.basis, second.part.basis, cell)
            measure = common_measure(list(found.values()))
            scale = plain(measure) * reciprocal(determinant) ** (first.power + second.power - 1)
            block = [
                [scale * section[first_row[i] + a][first_row[j] + b] for b in range(len(second.rows))]
                for a in range(len(first.rows))
            ]
            natural = _rotated(block, rotations[i], rotations[j])
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


def _rotated(
    block: Sequence[Sequence[Scalar]], left: Sequence[Sequence[Scalar]], right: Sequence[Sequence[Scalar]]
) -> list[list[Scalar]]:
    """leftᵀ · block · right; left and right are (strains, natural derivatives)."""
    half = [
        [weighted_sum((right[b][s], entry) for b, entry in enumerate(row)) for s in range(len(right[0]))]
        for row in block
    ]
    if left is not right:
        return [
            [weighted_sum((left[a][r], row[s]) for a, row in enumerate(half)) for s in range(len(right[0]))]
            for r in range(len(left[0]))
        ]
    count = len(left[0])
    result: list[list[Scalar]] = [[0] * count for _ in range(count)]
    for r in range(count):
        for s in range(r + 1):
            result[r][s] = result[s][r] = weighted_sum((left[a][r], row[s]) for a, row in enumerate(half))
    return result


def forces_of_amounts(
    strains: Sequence[Strain],
    frame: CellMap,
    section: Sequence[Sequence[Scalar]],
    amounts: Sequence[Scalar],
    cell: str,
) -> list[Scalar]:
    """∫ Bᵀ S ε dA on the amounts of all parts, where the frame does not vary: exact, with ε in plate axes before S sees
    it.

    Strain and stress are polynomials in ξ and η, held by their coefficients. The stiffness of `stiffness_of_amounts`
    would do as well, but in a thin cell its entries cancel: at 1:1000 that takes seven digits more.
    """
    determinant = constant(frame.determinant)
    powers = sorted({key for strain in strains for rows in strain.part.basis for p in rows for key in p})
    stress = _stress(strains, determinant, section, amounts, powers)
    result: list[Scalar] = []
    first_row = 0
    for strain in strains:
        rotation = [[constant(entry) for entry in row] for row in strain.rows]
        scale = determinant * reciprocal(determinant) ** strain.power
        works: dict[Powers, list[Scalar]] = {}
        for i, j in powers:  # the stress's inner product with this monomial, turned to natural derivatives
            shares = [plain(monomial_integral(i + m, j + n, cell)) for m, n in powers]
            own = [
                scale * weighted_sum(zip(shares, (stress[key][first_row + a] for key in powers), strict=True))
                for a in range(len(rotation))
            ]
            works[i, j] = [
                weighted_sum((rotation[a][r], force) for a, force in enumerate(own))
                for r in range(len(rotation[0]))
            ]
        result += [
            weighted_sum((plain(c), works[key][r]) for r, p in enumerate(rows) for key, c in p.items())
            for rows in strain.part.basis
        ]
        first_row += len(rotation)
    return result


def _stress(
    strains: Sequence[Strain],
    determinant: Scalar,
    section: Sequence[Sequence[Scalar]],
    amounts: Sequence[Scalar],
    powers: Sequence[Powers],
) -> Mapping[Powers, list[Scalar]]:
    """Coefficients of membrane forces and moments."""
    stress: dict[Powers, list[Scalar]] = {}
    for key in powers:
        total: list[Scalar] = []
        at = 0
        for strain in strains:
            basis = strain.part.basis
            values = amounts[at : at + len(basis)]
            at += len(basis)
            natural = [
                weighted_sum(
                    (plain(rows[r].get(key, Fraction(0))), v) for rows, v in zip(basis, values, strict=True)
                )
                for r in range(len(strain.rows[0]))
            ]
            divisor = reciprocal(determinant) ** strain.power
            rotation = [[constant(entry) for entry in row] for row in strain.rows]
            total += [divisor * weighted_sum(zip(row, natural, strict=True)) for row in rotation]
        stress[key] = [weighted_sum(zip(row, total, strict=True)) for row in section]
    return stress

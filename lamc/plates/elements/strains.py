"""Strains of an element by amounts that vanish in rigid motion.

In: shape functions, factored. Out: per part (membrane, bending) a basis of strains, the chain of weights from unknowns
to amounts, and the map from natural derivatives to strains. Never: loads or inertia.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from lamc.mechanics.sympy_view import from_sympy
from lamc.plates.elements.cell_map import CellMap, Varying, bending_rows, stretching_rows
from lamc.plates.elements.definition import Element
from lamc.plates.elements.factor import Geometry, Rows, factored, gradient, hessian, value
from lamc.plates.elements.sums import Sparse, applied, applied_transposed, congruence
from lamc.symbolic.scalars import Scalar


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


def membrane(element: Element, geometry: Geometry, frame: CellMap) -> Strain:
    found = factored(geometry, list(zip(element.u, element.v, strict=True)), gradient)
    chain = Chain((found.weights,), (len(element.dofs),))
    return Strain(Part(found.basis, chain), stretching_rows(frame, 1), 1)


def bending(element: Element, geometry: Geometry, frame: CellMap) -> Strain:
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

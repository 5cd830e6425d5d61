"""The staged inputs of one cell, and what all functions of its element share.

In: an element. Out: symbols for coordinates, section, loads and unknowns; frame and strains. Never: integrals.
"""

from collections.abc import Sequence
from functools import cached_property

from lamc.plates.elements.cell_map import CellMap, Varying, constant, frame
from lamc.plates.elements.definition import Element
from lamc.plates.elements.factor import Geometry, plain
from lamc.plates.elements.polynomials import Polynomial
from lamc.plates.elements.sheared import sheared
from lamc.plates.elements.strains import Chain, Strain, bending, joined, membrane
from lamc.plates.elements.sums import weighted_sum
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar, reciprocal
from lamc.symbolic.staging import Store

_INDICES = ("11", "12", "16", "22", "26", "66")
_ENTRIES = ((0, 1, 2), (1, 3, 4), (2, 4, 5))  # where a symmetric 3 × 3 finds its unique entries


class Cell:
    """One cell of `element`, with a store of its own."""

    def __init__(self, element: Element) -> None:
        self.element = element
        self.store = Store()
        names = [f"{axis}{k + 1}" for k in range(element.corner_count) for axis in "xy"]
        flat = [self.store.symbol(name, Space.CORNER, k) for k, name in enumerate(names)]
        self.corners: Sequence[tuple[Scalar, Scalar]] = list(zip(flat[::2], flat[1::2], strict=True))
        with self.store.section("sides of the cell, and what shape functions take from them"):
            self.frame: CellMap = frame(element, self.corners)
            self.geometry = Geometry(element, self.store, self.corners)
            if element.is_affine:
                reciprocal(
                    constant(self.frame.determinant)
                ) ** 3  # made here, so that it is shown with the sides

    @cached_property
    def strains(self) -> tuple[Strain, ...]:
        """Of the membrane if it stretches, then of bending if it bends, then of shear through the thickness."""
        parts = (self.element, self.geometry, self.frame)
        with self.store.section("weights of the unknowns in amounts that rigid motion leaves at zero"):
            found = (membrane(*parts),) if self.element.stretches else ()
            if self.element.shear:
                return (*found, *sheared(self))
            return (*found, bending(*parts)) if self.element.bends else found

    @cached_property
    def chain(self) -> Chain:
        """From the unknowns to the amounts of all strains."""
        return joined(self.strains)

    @cached_property
    def amounts(self) -> list[Scalar]:
        """Of all strains, from the unknowns."""
        with self.store.section("amounts that rigid motion leaves at zero"):
            return self.chain.amounts(self.unknowns)

    @cached_property
    def unknowns(self) -> list[Scalar]:
        return [self.store.symbol(s.name, Space.UNKNOWN, k) for k, s in enumerate(self.element.unknowns)]

    @cached_property
    def natural(self) -> tuple[Scalar, Scalar, Scalar]:
        """ξ, η, and the weight of a point of quadrature."""
        xi, eta, weight = (
            self.store.symbol(name, Space.NATURAL, k) for k, name in enumerate(("xi", "eta", "weight"))
        )
        return xi, eta, weight

    @cached_property
    def section(self) -> list[list[Scalar]]:
        """The section's stiffness, (3, 3), or (6, 6) of A, B, D; two rows and columns of H more if it has shear."""
        plane = self._plane
        if not self.element.shear:
            return plane
        a, b, c = self.shear
        count = len(plane)
        return [[*row, 0, 0] for row in plane] + [[*[0] * count, a, b], [*[0] * count, b, c]]

    @cached_property
    def shear(self) -> list[Scalar]:
        """H: its entries 11, 12, 22."""
        first = self._plane_count
        return [
            self.store.symbol("H" + at, Space.SECTION, first + k) for k, at in enumerate(("11", "12", "22"))
        ]

    @cached_property
    def neutral(self) -> list[Scalar]:
        """D about the neutral surface: D - B A⁻¹ B, its six entries."""
        first = self._plane_count + 3
        return [self.store.symbol("N" + at, Space.SECTION, first + k) for k, at in enumerate(_INDICES)]

    @property
    def _plane_count(self) -> int:
        return 18 if self.element.stretches and self.element.bends else 6

    @cached_property
    def _plane(self) -> list[list[Scalar]]:
        """Of membrane and bending."""
        names = [n for n, there in (("A", self.element.stretches), ("D", self.element.bends)) if there]
        if len(names) == 1:
            return self._block(names[0], 0)
        A, B, D = (self._block(name, 6 * k) for k, name in enumerate("ABD"))
        return [[*a, *b] for a, b in zip(A, B, strict=True)] + [[*b, *d] for b, d in zip(B, D, strict=True)]

    def _block(self, name: str, offset: int) -> list[list[Scalar]]:
        unique = [self.store.symbol(name + at, Space.SECTION, offset + k) for k, at in enumerate(_INDICES)]
        return [[unique[k] for k in row] for row in _ENTRIES]

    def symbols(self, name: str, space: Space, count: int) -> list[Scalar]:
        """A vector of inputs: name1, name2, …"""
        return [self.store.symbol(f"{name}{k + 1}", space, k) for k in range(count)]

    def value(self, polynomial: Polynomial, xi: Scalar, eta: Scalar) -> Scalar:
        """Of a polynomial at a point."""
        return weighted_sum((plain(c), xi**i * eta**j) for (i, j), c in polynomial.items())

    def varying(self, varying: Varying, xi: Scalar, eta: Scalar) -> Scalar:
        """Of something in the frame at a point."""
        total: Scalar = 0
        for polynomial, factor in varying:
            total = total + self.value(polynomial, xi, eta) * factor
        return total

"""From an element's shape functions to staged expressions of all that a finite element program asks of it.

In: an `Element`. Out: `ElementEquations`: one store, and functions by name. Never: text, numbers of a mesh, a global
`simplify` or `cse`.

functions, by name; x are the corners' coordinates, d the unknowns, matrices are lower triangles by rows:
  stiffness     ∫ Bᵀ S B dA
  mass          ∫ ρ (u² + v² + w²) dA, consistent, kg
  geometric     ∫ ∇wᵀ N ∇w dA; only where it bends
  load          ∫ (u, v, w) · p dA, with p linear between the corners
  prestress     ∫ Bᵀ r dA
  strain        membrane strain, then curvature, at (ξ, η)
  displacement  u, v if it stretches, w, w_x, w_y if it bends, at (ξ, η)
  force         ∫ Bᵀ S B d dA from the strain: what rigid motion leaves is round-off of d, not of the stiffness
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from lamc.allocation import collector_paused
from lamc.codegen.program import Space
from lamc.mechanics.staging import Scalar, Store
from lamc.plate.elements.cell import Cell
from lamc.plate.elements.checks import check_element
from lamc.plate.elements.definition import Element
from lamc.plate.elements.fields import displacement, geometric, load, mass
from lamc.plate.elements.quadrature import Point
from lamc.plate.elements.stiffness import force, prestress, stiffness, strain


@dataclass(frozen=True)
class ElementFunction:
    """One function of an element.

    points  empty: `outputs` are the answer. Else the answer is the sum of `outputs` over these (ξ, η, weight), which
            the function reads as the three slots of Space.NATURAL
    """

    name: str
    purpose: str  # what it gives, with units
    reads: tuple[Space, ...]
    outputs: tuple[Scalar, ...]
    points: tuple[Point, ...] = ()


@dataclass(frozen=True, eq=False)
class ElementEquations:
    """Everything that is derived of an element; all outputs are values of `store`."""

    element: Element
    store: Store
    functions: Mapping[str, ElementFunction]


@collector_paused
def derive(element: Element) -> ElementEquations:
    """The functions of `element`. Raises DesignError for shape functions that are none; see `checks.py`."""
    check_element(element)
    cell = Cell(element)
    strains = "N/m, then N" if element.stretches and element.bends else "N/m" if element.stretches else "N"
    functions = [
        _function(
            "stiffness",
            "stiffness, lower triangle by rows",
            (Space.CORNER, Space.SECTION),
            stiffness(cell),
        ),
        _function(
            "mass", "mass, lower triangle by rows, kg", (Space.CORNER, Space.AREAL_MASS), (mass(cell), ())
        ),
        _function("load", "forces of a load", (Space.CORNER, Space.INTENSITY), (load(cell), ())),
        _function(
            "prestress",
            f"forces of resultants, {strains}",
            (Space.CORNER, Space.RESULTANT),
            (prestress(cell), ()),
        ),
        _function(
            "strain", "strains at a point", (Space.CORNER, Space.NATURAL, Space.UNKNOWN), (strain(cell), ())
        ),
        _function(
            "displacement",
            "displacements and slopes at a point",
            (Space.CORNER, Space.NATURAL, Space.UNKNOWN),
            (displacement(cell), ()),
        ),
        _function(
            "force",
            "forces of the stiffness, by way of strains",
            (Space.CORNER, Space.SECTION, Space.UNKNOWN),
            force(cell),
        ),
    ]
    if element.bends:
        functions.append(
            _function(
                "geometric",
                "stiffness of membrane forces, lower triangle by rows",
                (Space.CORNER, Space.MEMBRANE_FORCE),
                (geometric(cell), ()),
            )
        )
    return ElementEquations(element, cell.store, MappingProxyType({f.name: f for f in functions}))


def _function(
    name: str, purpose: str, reads: tuple[Space, ...], found: tuple[Sequence[Scalar], tuple[Point, ...]]
) -> ElementFunction:
    outputs, points = found
    if points:
        reads = (*reads, Space.NATURAL)
    return ElementFunction(name, purpose, reads, tuple(outputs), points)

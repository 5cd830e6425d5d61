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
  strain_in_section, prestress_in_section, shear_in_section
                of elements with shear through the thickness: the same, and (γ_x, γ_y), by the section too
  force         ∫ Bᵀ S B d dA from the strain: what rigid motion leaves is round-off of d, not of the stiffness
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from lamc.plates.elements.cell import Cell
from lamc.plates.elements.checks import check_element
from lamc.plates.elements.definition import Element
from lamc.plates.elements.fields import displacement, geometric, load, mass
from lamc.plates.elements.quadrature import Point
from lamc.plates.elements.stiffness import force, prestress, shear, stiffness, strain
from lamc.symbolic.allocation import collector_paused
from lamc.symbolic.program import Space
from lamc.symbolic.scalars import Scalar
from lamc.symbolic.staging import Store

Staged: TypeAlias = list[Scalar] | tuple[list[Scalar], tuple[Point, ...]]
_AT_A_POINT = (Space.CORNER, Space.NATURAL, Space.UNKNOWN)


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


# name, what it gives, what it reads, how it is staged, the equation it comes from
_FUNCTIONS: tuple[tuple[str, str, tuple[Space, ...], Callable[[Cell], Staged], str], ...] = (
    (
        "stiffness",
        "stiffness, lower triangle by rows, N/m for displacements",
        (Space.CORNER, Space.SECTION),
        stiffness,
        "∫ B^T S B dA",
    ),
    (
        "mass",
        "consistent mass, lower triangle by rows, kg for displacements",
        (Space.CORNER, Space.AREAL_MASS),
        mass,
        "∫ ρ (u² + v² + w²) dA",
    ),
    ("load", "forces of a load, N for displacements", (Space.CORNER, Space.INTENSITY), load, "∫ N p dA"),
    (
        "prestress",
        "forces of membrane forces and moments, N for displacements",
        (Space.CORNER, Space.RESULTANT),
        prestress,
        "∫ B^T r dA",
    ),
    ("strain", "strains at a point, then curvatures, 1/m", _AT_A_POINT, strain, "B d"),
    ("displacement", "displacements at a point, m, then slopes", _AT_A_POINT, displacement, "N d"),
    (
        "force",
        "forces of the stiffness by way of strains, N for displacements",
        (Space.CORNER, Space.SECTION, Space.UNKNOWN),
        force,
        "∫ B^T S B d dA",
    ),
    (
        "geometric",
        "stiffness of membrane forces, lower triangle by rows, N/m for displacements",
        (Space.CORNER, Space.MEMBRANE_FORCE),
        geometric,
        "∫ ∇w^T N ∇w dA",
    ),
)


def _with_shear() -> Iterator[tuple[str, str, tuple[Space, ...], Callable[[Cell], Staged], str]]:
    """Of elements with shear: what goes by strains asks for the section, which has a share in them."""
    for name, purpose, reads, staged, equation in _FUNCTIONS:
        if name in ("strain", "prestress"):
            yield f"{name}_in_section", purpose, (reads[0], Space.SECTION, *reads[1:]), staged, equation
        else:
            yield name, purpose, reads, staged, equation
    reads = (_AT_A_POINT[0], Space.SECTION, *_AT_A_POINT[1:])
    yield "shear_in_section", "shear strains through the thickness at a point", reads, shear, "∇w - slopes"


@collector_paused
def derive(element: Element) -> ElementEquations:
    """The functions of `element`. Raises DesignError for shape functions that are none; see `checks.py`."""
    check_element(element)
    cell = Cell(element)
    functions = {}
    for name, purpose, reads, staged, equation in _with_shear() if element.shear else _FUNCTIONS:
        if name == "geometric" and not element.bends:
            continue
        with cell.store.section(name, source=equation):
            found = staged(cell)
        outputs, points = found if isinstance(found, tuple) else (found, ())
        functions[name] = ElementFunction(
            name, purpose, (*reads, Space.NATURAL) if points else reads, tuple(outputs), points
        )
    return ElementEquations(element, cell.store, MappingProxyType(functions))

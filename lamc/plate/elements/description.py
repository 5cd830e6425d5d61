"""An element in words and formulas: nodes, shape functions, strains, integration and operation counts.

In: an element. Out: text. Never: files or terminals.
"""

from collections.abc import Iterator, Sequence

import sympy as sp

from lamc.codegen.program import Operations
from lamc.mechanics.staging import Level
from lamc.mechanics.statements import count_operations
from lamc.plate.elements.definition import SQUARE, Element
from lamc.plate.elements.derive import ElementEquations, derive

_STRETCHING = "(ε_x, ε_y, γ_xy) = (u_x, v_y, u_y + v_x)"
_BENDING = "κ = -(w_xx, w_yy, 2 w_xy)"
_SLOPES = "κ = -(∂w_x/∂x, ∂w_y/∂y, ∂w_x/∂y + ∂w_y/∂x), by the slopes' own shape functions"


def operations(equations: ElementEquations) -> dict[str, Operations]:
    """Of every function, by name; of one that is summed over points, those of one point."""
    return {
        name: count_operations(equations.store, function.outputs, Level.NUMBER)
        for name, function in equations.functions.items()
    }


def describe(element: Element) -> str:
    """Lines of plain text about `element`: nodes, unknowns, shape functions, strains, integration, operations."""
    equations = derive(element)
    return "\n".join((*_heading(element), *_formulas(element), *_integration(element), *_counts(equations)))


def _heading(element: Element) -> Iterator[str]:
    what = (
        "bends and stretches"
        if element.bends and element.stretches
        else "bends"
        if element.bends
        else "stretches"
    )
    yield f"{element.name}: {element.cell} that {what}, {len(element.nodes)} nodes, {len(element.dofs)} unknowns"
    if element.source:
        yield f"source: {element.source}"
    natural = "ξ, η in [-1, 1]" if element.cell == SQUARE else "L1 = 1 - ξ - η, L2 = ξ, L3 = η"
    yield ""
    yield f"Nodes, {natural}"
    for number, node in enumerate(element.nodes, start=1):
        yield f"  {number:>2}  ({node.at[0]}, {node.at[1]})  {', '.join(node.dofs)}"


def _formulas(element: Element) -> Iterator[str]:
    if element.geometry:
        yield ""
        yield "Geometry, x21 = x2 - x1 and so on"
        for symbol, expr in element.geometry.items():
            yield f"  {symbol} = {_text(expr)}"
    for field in element.fields:
        yield from _functions(f"Shape functions of {field}", element.unknowns, getattr(element, field))
    if element.amounts:
        yield ""
        yield "Amounts that the slopes are written in"
        for number, amount in enumerate(element.amounts, start=1):
            yield f"  a{number} = {_text(amount)}"
    names = [sp.Symbol(f"a{k}") for k in range(1, len(element.amounts) + 1)] or list(element.unknowns)
    for field, functions in zip(("w_x", "w_y"), element.slopes, strict=False):
        yield from _functions(f"Shape functions of {field}", names, functions)
    yield ""
    yield "Strains"
    if element.stretches:
        yield f"  {_STRETCHING}"
    if element.bends:
        yield f"  {_SLOPES if element.slopes else _BENDING}"


def _functions(title: str, names: Sequence[sp.Symbol], functions: Sequence[sp.Expr]) -> Iterator[str]:
    yield ""
    yield title
    for name, function in zip(names, functions, strict=True):
        if function != 0:
            yield f"  {name!s:<6} {_text(function)}"


def _text(expr: sp.Expr) -> str:
    return str(expr).replace("**", "^").replace("xi", "ξ").replace("eta", "η")


def _integration(element: Element) -> Iterator[str]:
    yield ""
    yield "Integration"
    if element.is_affine:
        cells = "" if element.cell != SQUARE else ", for rectangles with sides along x and y"
        yield f"  exact: polynomials in ξ and η, integrated term by term{cells}"
        return
    count = element.degree // 2 + 1
    yield f"  stiffness by {count} × {count} Gauss points, exact in parallelograms; all others exact"


def _counts(equations: ElementEquations) -> Iterator[str]:
    yield ""
    yield "Operations (+ - * and reciprocals)"
    for name, counted in operations(equations).items():
        function = equations.functions[name]
        times = f" at each of {len(function.points)} points" if function.points else ""
        yield f"  {name:<13}{counted.flops:>6}{times}  {function.purpose}"

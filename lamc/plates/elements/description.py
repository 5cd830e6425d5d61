"""An element in words and formulas: nodes, shape functions, strains, integration and operation counts.

In: an element. Out: text. Never: files or terminals.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import sympy as sp

from lamc.mechanics.sympy_view import expression
from lamc.plates.elements.cell import Cell
from lamc.plates.elements.checks import missing_strains
from lamc.plates.elements.definition import L1, SQUARE, TRIANGLE, Element, eta, xi
from lamc.plates.elements.derive import ElementEquations, derive
from lamc.plates.elements.library import checked_element
from lamc.plates.elements.polynomials import Polynomial
from lamc.symbolic.program import Operations
from lamc.symbolic.scalars import Value
from lamc.symbolic.staging import Level
from lamc.symbolic.statements import count_operations

_STRETCHING_ROWS = ("u_ξ", "u_η", "v_ξ", "v_η")
_BENDING_ROWS = ("w_ξξ", "w_ηη", "w_ξη")
_SLOPE_ROWS = ("w_x,ξ", "w_x,η", "w_y,ξ", "w_y,η")
_STRETCHING = "(u_x, v_y, u_y + v_x)"
_BENDING = "-(w_xx, w_yy, 2 w_xy)"
_SLOPES = "-(∂w_x/∂x, ∂w_y/∂y, ∂w_x/∂y + ∂w_y/∂x)"


def operations(equations: ElementEquations) -> dict[str, Operations]:
    """Of every function, by name; of one that is summed over points, those of one point."""
    return {
        name: count_operations(equations.store, function.outputs, Level.NUMBER)
        for name, function in equations.functions.items()
    }


def describe(element: Element | str) -> str:
    """Lines of plain text about `element`, or the one of that name: nodes, unknowns, shape functions, strains,
    integration, operations."""
    element = checked_element(element)
    equations = derive(element)
    return "\n".join(
        (
            *_heading(element),
            *_formulas(element),
            *_strains(element),
            *_integration(element),
            *_counts(equations),
        )
    )


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
            yield f"  {symbol} = {_text(element, expr)}"
    for field in element.fields:
        only = ", which loads and mass use" if field == "w" and element.slopes else ""
        yield from _functions(
            element, f"Shape functions of {field}{only}", element.unknowns, getattr(element, field)
        )
    if element.amounts:
        yield ""
        yield "Amounts that the slopes are written in"
        for number, amount in enumerate(element.amounts, start=1):
            yield f"  a{number} = {_text(element, amount)}"
    names = [sp.Symbol(f"a{k}") for k in range(1, len(element.amounts) + 1)] or list(element.unknowns)
    for field, functions in zip(("w_x", "w_y"), element.slopes, strict=False):
        yield from _functions(element, f"Shape functions of {field}", names, functions)


def _strains(element: Element) -> Iterator[str]:
    """B in its factors: amounts of the unknowns, natural derivatives of these, and the turn to x and y."""
    if element.shear:
        yield from _strains(replace(element, shear=False))
        yield ""
        yield "Of the last three amounts, the bows of edges, slopes take the part 1 / (1 + φ) and shear the rest:"
        yield "  γ along an edge = bow φ / (1 + φ) / length, linear inside with these along all three;"
        yield "  φ = 12 D_s / (H_s length²), of bending and shear along the edge"
        return
    cell = Cell(element)
    named = {
        value.index: value.sign * sp.Symbol(name, real=True)
        for name, value in cell.geometry.known.items()
        if isinstance(value, Value)
    }
    amounts = [sp.Symbol(f"a{k}") for k in range(1, len(element.amounts) + 1)] or list(element.unknowns)
    count = 0
    for strain in cell.strains:
        bends = strain is cell.strains[-1] and element.bends
        rows = _SLOPE_ROWS if bends and element.slopes else _BENDING_ROWS if bends else _STRETCHING_ROWS
        law = _SLOPES if bends and element.slopes else _BENDING if bends else _STRETCHING
        names = amounts if bends and element.slopes else list(element.unknowns)
        yield ""
        yield f"Strains {law}, of amounts that rigid motion leaves at zero"
        own = [sp.Symbol(f"e{count + k}") for k in range(1, len(strain.part.basis) + 1)]
        count += len(own)
        for symbol, weights in zip(own, strain.part.chain.links[0], strict=True):
            total = sum(expression(w, named) * names[j] for j, w in weights.items())
            yield f"  {symbol!s:<4} = {_text(element, total)}"
        for r, name in enumerate(rows):
            total = sum(
                symbol * _polynomial(basis[r]) for symbol, basis in zip(own, strain.part.basis, strict=True)
            )
            yield f"  {name:<6} = {_text(element, total)}"


def _polynomial(polynomial: Polynomial) -> sp.Expr:
    return sp.Add(
        *(sp.Rational(c.numerator, c.denominator) * xi**i * eta**j for (i, j), c in polynomial.items())
    )


def _functions(
    element: Element, title: str, names: Sequence[sp.Symbol], functions: Sequence[sp.Expr]
) -> Iterator[str]:
    yield ""
    yield title
    for name, function in zip(names, functions, strict=True):
        if function != 0:
            yield f"  {name!s:<6} {_text(element, function)}"


def _text(element: Element, expr: sp.Expr) -> str:
    if element.cell == TRIANGLE:
        expr = expr.xreplace({L1: sp.Symbol("L1")}).xreplace({xi: sp.Symbol("L2"), eta: sp.Symbol("L3")})
    return str(expr).replace("**", "^").replace("xi", "ξ").replace("eta", "η")


def _integration(element: Element) -> Iterator[str]:
    yield ""
    yield "Integration and convergence"
    missing = missing_strains(element)
    if missing:
        yield f"  {', '.join(missing)} cannot be constant over a cell: the element does not converge"
    if element.is_affine:
        cells = "" if element.cell != SQUARE else ", for rectangles with sides along x and y"
        yield f"  exact: polynomials in ξ and η, integrated term by term{cells}"
        return
    count = element.degree // 2 + 1
    yield f"  stiffness by {count} × {count} Gauss points, exact in parallelograms; all others exact"


def _counts(equations: ElementEquations) -> Iterator[str]:
    yield ""
    yield "Operations (+ - * and reciprocals)"
    counts = operations(equations)
    width = max(13, *(len(name) + 1 for name in counts))
    for name, counted in counts.items():
        function = equations.functions[name]
        times = f" at each of {len(function.points)} points" if function.points else ""
        yield f"  {name:<{width}}{counted.flops:>6}{times}  {function.purpose}"

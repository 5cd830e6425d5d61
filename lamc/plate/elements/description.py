"""An element in words and formulas: nodes, shape functions, strains, integration and operation counts.

In: an element. Out: text. Never: files or terminals.
"""

from lamc.mechanics.staging import Level
from lamc.mechanics.statements import count_operations
from lamc.plate.elements.definition import Element
from lamc.plate.elements.derive import derive


def describe(element: Element) -> str:
    """Several lines of plain text about `element`, its operation counts last."""
    equations = derive(element)
    lines = [f"{element.name}: {element.cell}, {len(element.nodes)} nodes, {len(element.dofs)} unknowns"]
    if element.source:
        lines.append(f"source: {element.source}")
    for function in equations.functions.values():
        flops = count_operations(equations.store, function.outputs, Level.NUMBER).flops
        lines.append(f"{function.name:<14}{flops:>6} operations  {function.purpose}")
    return "\n".join(lines)

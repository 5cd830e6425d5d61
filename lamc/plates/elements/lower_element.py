"""`lower_element`: from the equations of a finite element to an ElementProgram.

Goes in: staged values per function. Comes out: straight-line functions. No sympy, no text, no file.
"""

import hashlib
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING

from lamc.codegen.lowering import Lowering, canonical
from lamc.symbolic.allocation import collector_paused
from lamc.symbolic.program import ElementProgram
from lamc.symbolic.staging import Level

if TYPE_CHECKING:
    from lamc.plates.elements.derive import ElementEquations


@collector_paused
def lower_element(equations: "ElementEquations") -> ElementProgram:
    """The program of `equations`. Fractions stay fractions: forces are also computed in long double."""
    element, store = equations.element, equations.store
    functions = [
        Lowering(store, Level.NUMBER, {}, exact=True).function(f.name, f.purpose, f.reads, f.outputs)
        for f in equations.functions.values()
    ]
    program = ElementProgram(
        name=element.name,
        nodes=tuple(tuple(node.dofs) for node in element.nodes),
        corner_count=element.corner_count,
        fields=element.fields,
        functions=MappingProxyType({f.name: f for f in functions}),
        points=MappingProxyType({f.name: f.points for f in equations.functions.values() if f.points}),
        source=element.source,
        shear=element.shear,
    )
    text = hashlib.sha256()
    facts = (program.nodes, program.corner_count, program.fields, program.source, dict(program.points))
    text.update(repr((program.name, *facts, *("shear",) * program.shear)).encode())
    for function in functions:
        for line in canonical(function):
            text.update(f"{line}\n".encode())
    return replace(program, digest=text.hexdigest())

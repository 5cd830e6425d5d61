"""Lays out one function as C text: in one block when it is short, as kernels and loops when it is long.

Goes in: a Function. Comes out: lines. The template adds signatures and indentation, and nothing else.
"""

from lamc.codegen.layout_long import Long
from lamc.codegen.names import comment
from lamc.codegen.pieces import SHORT_INDEX, CFunction, heading, operand_name, output_lines, unused
from lamc.codegen.printer import ShapePrinter
from lamc.codegen.sine_cosine import SHARING, batches, calls
from lamc.symbolic.program import Function, Operand

# Statements in one block. What runs at every step is straight code as long as that is quicker than kernels (40
# parallel hinges: nearly twice as quick); gcc then takes about a second. What runs once per row compiles quickly.
MAX_BLOCK = 400
MAX_BLOCK_AT_EVERY_STEP = 1500
AT_EVERY_STEP = (
    "acceleration",
    "dynamics",
    "system",
    "closure",
    "constraints",
    "residual",
    "momenta",
    "motion_pullback",
    "tangents",
    "directional_tangents",
)


def arrange(
    function: Function, printer: ShapePrinter, fields: list[str], number: str = "double", limit: int = 0
) -> CFunction:
    """`function` as lines of C; `fields` are the members of the parameter struct, `number` the C type of values.

    limit: statements in one block; 0: as many as suit a simulator.
    """
    limit = limit or (MAX_BLOCK_AT_EVERY_STEP if function.name in AT_EVERY_STEP else MAX_BLOCK)
    if len(function.statements) <= limit:
        return _block(function, printer, fields, number)
    return Long(function, printer, fields, number).arranged()


def _block(function: Function, printer: ShapePrinter, fields: list[str], number: str) -> CFunction:
    def name(operand: Operand) -> str:
        return operand_name(operand, fields, number)

    lines: list[str] = []
    section = -1
    for statement in batches(function.statements) if number in SHARING else function.statements:
        first = statement[0][0] if isinstance(statement, tuple) else statement
        if first.section != section:
            section = first.section
            lines += heading(function, section)
        if isinstance(statement, tuple):
            lines += calls(statement, name, number)
            continue
        text = printer.text(statement.shape, statement.operands, name)
        lines.append(f"const {number} z{statement.target.index} = {text};")
    used = {operand.space for s in function.statements for operand in s.operands}
    used |= {operand.space for _, operand in function.outputs}
    return CFunction(
        name=function.name,
        purpose=comment(function.purpose),
        reads=tuple(space.value for space in function.reads),
        operations=function.operations,
        routines=(),
        tables=(),
        index_type=SHORT_INDEX,
        literals=(),
        crossing_count=0,
        body=(*lines, *output_lines(function, name, number)),
        unused=unused(function, used),
    )

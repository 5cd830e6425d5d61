"""Lays out one function as C: statements with their comments, in one block or in chunks.

gcc's time grows faster than linearly in the length of one straight block (213 s for 11 000 lines at -O2). Above
MAX_BLOCK statements the function becomes a row of small functions; values that cross from one to another pass
through an array. The cut costs a load and a store per crossing value and nothing else.
"""

from collections.abc import Callable
from dataclasses import dataclass

from lamc.codegen.names import comment
from lamc.codegen.printer import ShapePrinter, literal
from lamc.codegen.program import Function, Operand, Operations, Space

MAX_BLOCK = 1000  # statements in one C function
CHUNK = 500  # statements per part, where there are parts


@dataclass(frozen=True)
class CFunction:
    """Text of one function for the template."""

    name: str
    purpose: str
    reads: tuple[str, ...]  # argument names in use
    operations: Operations
    parts: tuple[tuple[str, ...], ...]  # lines of each part; one part: the body itself
    crossing_count: int
    outputs: tuple[str, ...]  # lines


def arrange(function: Function, printer: ShapePrinter, fields: list[str]) -> CFunction:
    """`function` as lines of C; `fields` are the members of the parameter struct."""
    count = len(function.statements)
    size = CHUNK if count > MAX_BLOCK else max(count, 1)
    part_of = [position // size for position in range(count)]
    crossing = _crossing(function, part_of)

    def outside(operand: Operand) -> str:
        return _name(operand, fields)

    parts: list[tuple[str, ...]] = []
    for part in range(max(part_of, default=0) + 1):
        parts.append(tuple(_part(function, part, part_of, crossing, printer, outside)))
    split = len(parts) > 1

    def final(operand: Operand) -> str:
        return f"x[{crossing[operand.index]}]" if split and operand.space is Space.LOCAL else outside(operand)

    outputs = [
        f"out[{k}] = {'-' if sign < 0 else ''}{final(operand)};" for k, (sign, operand) in enumerate(function.outputs)
    ]
    return CFunction(
        name=function.name,
        purpose=comment(function.purpose),
        reads=_reads(function),
        operations=function.operations,
        parts=tuple(parts),
        crossing_count=len(crossing) if split else 0,
        outputs=tuple(outputs),
    )


def _reads(function: Function) -> tuple[str, ...]:
    spaces = {operand.space for s in function.statements for operand in s.operands}
    spaces |= {operand.space for _, operand in function.outputs}
    return tuple(space.value for space in Space if space in spaces and space not in (Space.LOCAL, Space.NUMBER))


def _crossing(function: Function, part_of: list[int]) -> dict[int, int]:
    """Local → place in the array, for locals read in another part or by the outputs."""
    crossing: dict[int, int] = {}
    for position, statement in enumerate(function.statements):
        for operand in statement.operands:
            if operand.space is Space.LOCAL and part_of[operand.index] != part_of[position]:
                crossing.setdefault(operand.index, len(crossing))
    for _, operand in function.outputs:
        if operand.space is Space.LOCAL:
            crossing.setdefault(operand.index, len(crossing))
    return crossing


def _part(
    function: Function,
    part: int,
    part_of: list[int],
    crossing: dict[int, int],
    printer: ShapePrinter,
    outside: Callable[[Operand], str],
) -> list[str]:
    lines: list[str] = []
    single = not part_of or part_of[-1] == 0
    section = -1

    def name(operand: Operand) -> str:
        if operand.space is Space.LOCAL and part_of[operand.index] != part:
            return f"x[{crossing[operand.index]}]"
        return outside(operand)

    for position, statement in enumerate(function.statements):
        if part_of[position] != part:
            continue
        if statement.section != section:
            section = statement.section
            lines += _heading(function, section)
        index = statement.target.index
        lines.append(f"const double z{index} = {printer.text(statement.shape, statement.operands, name)};")
        if not single and index in crossing:
            lines.append(f"x[{crossing[index]}] = z{index};")
    return lines


def _heading(function: Function, section: int) -> list[str]:
    entry = function.sections[section]
    origin = f" [{entry.effect}]" if entry.effect else ""
    source = f" ({entry.source})" if entry.source else ""
    return [f"/* {comment(entry.title + source + origin)} */"]


def _name(operand: Operand, fields: list[str]) -> str:
    match operand.space:
        case Space.NUMBER:
            return literal(operand.value)
        case Space.PARAMETER:
            return f"p->{fields[operand.index]}"
        case Space.TIME:
            return "t"
        case Space.LOCAL:
            return f"z{operand.index}"
        case _:
            return f"{operand.space.value}[{operand.index}]"

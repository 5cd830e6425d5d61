"""Pieces of C text that short and long functions share: names of operands, outputs, headings, and the records that the
templates read.

Goes in: operands and sections of a Function. Comes out: strings. Nothing here knows where a statement stands.
"""

from collections.abc import Callable
from dataclasses import dataclass

from lamc.codegen.names import comment
from lamc.codegen.printer import LANES, REAL, literal
from lamc.symbolic.program import Function, Operand, Operations, Space

SHORT_INDEX, LONG_INDEX, MAX_SHORT_INDEX = "unsigned short", "unsigned int", 65535  # C promises no more


@dataclass(frozen=True)
class CRoutine:
    """A static function of its own: a kernel, or a part of what does not repeat."""

    name: str
    is_kernel: bool
    lines: tuple[str, ...]
    unused: tuple[str, ...]  # arguments it does not read

    @property
    def reads_numbers(self) -> bool:
        """Whether it looks up a number that differs from link to link, `CFunction.literals`."""
        return self.is_kernel and any("number[i[" in line for line in self.lines)


@dataclass(frozen=True)
class CTable:
    """Rows of indices: one per call of a kernel, or (output, source) pairs."""

    name: str
    rows: tuple[str, ...]
    width: int


@dataclass(frozen=True)
class CFunction:
    """Text of one function for the template."""

    name: str
    purpose: str
    reads: tuple[str, ...]  # letters of its arguments
    operations: Operations
    routines: tuple[CRoutine, ...]
    tables: tuple[CTable, ...]
    index_type: str  # C type of the entries of all tables
    literals: tuple[str, ...]  # numbers that differ from link to link
    crossing_count: int  # values that pass between routines; 0: there are none, all is in the body
    body: tuple[str, ...]
    unused: tuple[str, ...]  # arguments that the body does not read


def output_lines(function: Function, name: Callable[[Operand], str], number: str) -> list[str]:
    """The assignments at the end of a function."""
    return [
        f"out[{k}] = {'-' if sign < 0 else ''}{assigned(name(operand), operand.space, number)};"
        for k, (sign, operand) in enumerate(function.outputs)
    ]


def assigned(text: str, space: Space, number: str) -> str:
    """C for what is stored; where values are no doubles, EACH(…) makes one of a number."""
    is_other = space is Space.NUMBER and number not in ("double", "float", REAL)
    return f"EACH({text})" if is_other and not text.startswith("EACH(") else text


def unused(function: Function, used: set[Space]) -> tuple[str, ...]:
    """Arguments of the function that lie in none of the spaces `used`."""
    return tuple(space.value for space in function.reads if space not in used)


def heading(function: Function, section: int) -> list[str]:
    """The comment over a run of statements: what, from which equation, for which effect; none where nothing is
    reported."""
    entry = function.sections[section]
    if not entry.title:
        return []
    source = f" ({entry.source})" if entry.source else ""
    effect = f" [{entry.effect}]" if entry.effect else ""
    return [f"/* {comment(entry.title + source + effect)} */"]


def operand_name(operand: Operand, fields: list[str], number: str = "double") -> str:
    """C for a slot or a number; in "float" all that is not computed there is brought to it."""
    if number == "float" and operand.space is not Space.LOCAL:
        return f"(float){operand_name(operand, fields)}"
    match operand.space:
        case Space.NUMBER:
            text = literal(operand.value, number)
            return (
                f"EACH({text})" if number == LANES else text
            )  # functions of two take no vector and a number
        case Space.PARAMETER:
            return f"p->{fields[operand.index]}"
        case Space.TIME:
            return "t"
        case _:
            return (
                f"{operand.space.value}[{operand.index}]"
                if operand.space is not Space.LOCAL
                else f"z{operand.index}"
            )


def array_name(space: Space, number: str) -> str:
    """C for the array of a space."""
    match space:
        case Space.LOCAL:
            return "x"
        case Space.PARAMETER:
            real = REAL if number == REAL else "double"
            return f"((const {real} *)(const void *)p)"
        case Space.NUMBER:
            return "number"
        case _:
            return str(space.value)

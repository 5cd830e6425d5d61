"""Lays out a long function: kernels and loops for what repeats, parts for what does not.

Goes in: a Function that is too long for one block. Comes out: its routines, tables and the body that calls them.
"""

from collections.abc import Iterable
from fractions import Fraction
from functools import cached_property

from lamc.codegen.dispatch import dispatch
from lamc.codegen.names import comment
from lamc.codegen.pieces import (
    LONG_INDEX,
    MAX_SHORT_INDEX,
    SHORT_INDEX,
    CFunction,
    CRoutine,
    CTable,
    array_name,
    assigned,
    heading,
    operand_name,
    output_lines,
    unused,
)
from lamc.codegen.printer import ShapePrinter, literal
from lamc.codegen.segments import External, KernelClass, Layout, Local, Segment, lay_out
from lamc.codegen.sine_cosine import SHARING, batches, call, calls, sine_cosine_pairs
from lamc.symbolic.program import Function, Operand, Space, Statement

PART = 250  # statements in one part of what does not repeat in a long function
MAX_PERIOD = 4  # like links in turns: signs that alternate from link to link make two classes of one
MAX_PLAIN_OUTPUTS = 64  # more outputs than this are copied by loops
# More loops than this are one loop over a table of what comes when: what gcc reads does not grow with them then,
# nor does its time (a sheet of 16 x 16 facets has 1300 loops)
MAX_LOOPS = 24


class Long:
    """One long function: kernels for what repeats, parts for what does not, and a body that calls them in order.

    Values that cross lie in x. A kernel gets a row of indices: first where its results go, then one per external
    operand, into x, c, q, u, the parameters as an array, or the table of numbers.
    """

    def __init__(self, function: Function, printer: ShapePrinter, fields: list[str], number: str) -> None:
        self.function = function
        self.number = number
        self.printer = printer
        self.fields = fields
        self.layout: Layout = lay_out(function)
        self.literals: dict[float | Fraction, int] = {}
        self.routines: list[CRoutine] = []
        self.rows: list[list[str]] = [[] for _ in self.layout.classes]
        self.more_tables: list[CTable] = []
        self.body: list[str] = []
        self._pending: list[Segment] = []

    def arranged(self) -> CFunction:
        for number, kernel in enumerate(self.layout.classes):
            self.routines.append(self._kernel(number, kernel))
        if self._loop_count() > MAX_LOOPS:
            self._dispatch()
        else:
            self._write_loops()
        function = self.function
        self.body += self._copies()
        return CFunction(
            name=function.name,
            purpose=comment(function.purpose),
            reads=tuple(space.value for space in function.reads),
            operations=function.operations,
            routines=tuple(self.routines),
            tables=(
                *(
                    CTable(f"{function.name}_index_{i}", tuple(rows), rows[0].count(",") + 1)
                    for i, rows in enumerate(self.rows)
                ),
                *self.more_tables,
            ),
            index_type=self._index_type(),
            literals=tuple(literal(v, self.number) for v in self.literals),
            crossing_count=self.layout.size,
            body=tuple(self.body),
            unused=(),  # every argument is handed on to the routines
        )

    def _loop_count(self) -> int:
        """How many times in a row another class, or what has none, comes next; turns of a few classes count once."""
        class_of = self.layout.class_of
        position, count = 0, 0
        while position < len(class_of):
            position += self._turns(position)[0] if class_of[position] is not None else 1
            count += 1
        return count

    def _write_loops(self) -> None:
        position = 0
        while position < len(self.layout.segments):
            if self.layout.class_of[position] is None:
                self._write_out(self.layout.segments[position])
                position += 1
            else:
                self._finish_part()
                position += self._loop(position)
        self._finish_part()

    def _dispatch(self) -> None:
        """Kernels and parts by a table of which comes when."""
        function, class_of = self.function, self.layout.class_of
        kernels, cases = len(self.rows), list[int]()
        for position, segment in enumerate(self.layout.segments):
            number = class_of[position]
            if number is None:
                self._pending.append(segment)
                last = position + 1 == len(class_of) or class_of[position + 1] is not None
                if last or sum(s.stop - s.start for s in self._pending) >= PART:
                    cases.append(kernels + len(self.body))
                    self._finish_part()
            else:
                self.rows[number].append(self._row(segment, self.layout.classes[number]))
                cases.append(number)
        arguments = ", ".join(s.value for s in function.reads)
        calls = [f"{function.name}_kernel_{i}({arguments}, *next_{i}++, x);" for i in range(kernels)]
        table, lines = dispatch(f"{function.name}_order", [*calls, *self.body], cases)
        self.more_tables.append(table)
        rows = [
            f"const {self._index_type()} (*next_{i})[{rows[0].count(',') + 1}] = {function.name}_index_{i};"
            for i, rows in enumerate(self.rows)
        ]
        self.body = [*rows, *lines]

    def _index_type(self) -> str:
        return SHORT_INDEX if self._largest_index() <= MAX_SHORT_INDEX else LONG_INDEX

    def _largest_index(self) -> int:
        """No table holds more than this."""
        return max(self.layout.size, len(self.literals), self._largest_operand)

    @cached_property
    def _largest_operand(self) -> int:
        outputs = [operand.index for _, operand in self.function.outputs]
        used = (operand.index for statement in self.function.statements for operand in statement.operands)
        return max(len(outputs), max(outputs, default=0), max(used, default=0))

    def _outside(self, operand: Operand) -> str:
        if operand.space is Space.LOCAL:
            return f"x[{self.layout.place[operand.index]}]"
        return operand_name(operand, self.fields, self.number)

    def _kernel(self, number: int, kernel: KernelClass) -> CRoutine:
        lines = heading(self.function, kernel.section)
        spaces: dict[int, Space] = {}
        for _, operands in kernel.pattern:
            for operand in operands:
                if isinstance(operand, External) and operand.space is not Space.TIME:
                    spaces[operand.slot] = operand.space
        for slot, space in sorted(spaces.items()):
            read = assigned(f"{array_name(space, self.number)}[i[{slot + 1}]]", space, self.number)
            lines.append(f"const {self.number} e{slot} = {read};")
        found = sine_cosine_pairs(kernel.pattern) if self.number in SHARING else {}
        for position, (shape, operands) in enumerate(kernel.pattern):
            pair = found.get(position)
            if pair is not None:
                if position == pair.first:
                    lines += call(
                        _kernel_operand(operands[0]), f"z{pair.sine}", f"z{pair.cosine}", self.number
                    )
                continue
            stand_ins = tuple(Operand(Space.LOCAL, k) for k in range(len(operands)))
            names = [_kernel_operand(o) for o in operands]
            text = self.printer.text(shape, stand_ins, lambda o, names=names: names[o.index])  # type: ignore[misc]
            lines.append(f"const {self.number} z{position} = {text};")
        lines += [f"x[i[0] + {k}] = z{position};" for k, position in enumerate(kernel.stored)]
        used = {o.space for _, operands in kernel.pattern for o in operands if isinstance(o, External)}
        return CRoutine(
            f"{self.function.name}_kernel_{number}", True, tuple(lines), unused(self.function, used)
        )

    def _turns(self, start: int) -> tuple[int, int]:
        """How many segments from `start` on are of one class, or of a few classes in turns; how many classes."""
        class_of = self.layout.class_of
        period, count = 1, 1
        for candidate in range(1, MAX_PERIOD + 1):
            head = class_of[start : start + candidate]
            if None in head or len(set(head)) < len(head):
                break
            repeats = 1
            while class_of[start + repeats * candidate : start + (repeats + 1) * candidate] == head:
                repeats += 1
            if repeats > 1 and repeats * candidate > period * count:
                period, count = candidate, repeats
        return period * count, period

    def _loop(self, start: int) -> int:
        """A loop over the segments from `start` whose classes repeat; returns how many segments it covers."""
        class_of = self.layout.class_of
        covered, period = self._turns(start)
        calls: list[str] = []
        arguments = ", ".join(s.value for s in self.function.reads)
        for number in class_of[start : start + period]:
            assert number is not None
            first = len(self.rows[number])
            row = f"k + {first}" if first else "k"
            name = self.function.name
            calls.append(f"  {name}_kernel_{number}({arguments}, {name}_index_{number}[{row}], x);")
        for position in range(start, start + covered):
            number = class_of[position]
            assert number is not None
            self.rows[number].append(self._row(self.layout.segments[position], self.layout.classes[number]))
        self.body += [f"for (int k = 0; k < {covered // period}; ++k) {{", *calls, "}"]
        return covered

    def _copies(self) -> list[str]:
        """The outputs; where there are many, by loops over tables of (output, source)."""
        outputs = self.function.outputs
        if len(outputs) <= MAX_PLAIN_OUTPUTS:
            return output_lines(self.function, self._outside, self.number)
        groups: dict[tuple[Space, int], list[str]] = {}
        for k, (sign, operand) in enumerate(outputs):
            groups.setdefault((operand.space, sign), []).append(f"{k}, {self._index(operand)}")
        lines: list[str] = []
        for (space, sign), rows in sorted(groups.items(), key=lambda g: (g[0][0].value, -g[0][1])):
            name = f"{self.function.name}_outputs_{len(self.more_tables)}"
            self.more_tables.append(CTable(name, tuple(rows), 2))
            array = (
                f"{self.function.name}_number" if space is Space.NUMBER else array_name(space, self.number)
            )
            minus = "-" if sign < 0 else ""
            source = assigned(f"{array}[{name}[k][1]]", space, self.number)
            lines += [
                f"for (int k = 0; k < {len(rows)}; ++k) {{",
                f"  out[{name}[k][0]] = {minus}{source};",
                "}",
            ]
        return lines

    def _index(self, operand: Operand) -> int:
        """Where an operand lies in its array."""
        match operand.space:
            case Space.LOCAL:
                return self.layout.place[operand.index]
            case Space.NUMBER:
                return self.literals.setdefault(operand.value, len(self.literals))
            case _:
                return operand.index

    def _row(self, segment: Segment, kernel: KernelClass) -> str:
        first = self.layout.place[segment.start + kernel.stored[0]] if kernel.stored else 0
        return ", ".join(map(str, [first, *(self._index(operand) for operand in segment.externals)]))

    def _write_out(self, segment: Segment) -> None:
        self._pending.append(segment)
        if sum(s.stop - s.start for s in self._pending) >= PART:
            self._finish_part()

    def _finish_part(self) -> None:
        """What was collected becomes a routine of its own, called here."""
        if not self._pending:
            return
        statements = [s for g in self._pending for s in self.function.statements[g.start : g.stop]]
        name = f"{self.function.name}_part_{sum(not r.is_kernel for r in self.routines)}"
        lines = list(self._part_lines(statements, self._pending[0].start))
        used = {operand.space for s in statements for operand in s.operands}
        self.routines.append(CRoutine(name, False, tuple(lines), unused(self.function, used)))
        arguments = ", ".join(s.value for s in self.function.reads)
        self.body.append(f"{name}({arguments}, x);")
        self._pending = []

    def _part_lines(self, statements: list[Statement], start: int) -> Iterable[str]:
        section = -1

        def name(operand: Operand) -> str:
            if operand.space is Space.LOCAL and operand.index >= start:
                return f"z{operand.index}"
            return self._outside(operand)

        for statement in batches(statements) if self.number in SHARING else statements:
            first = statement[0][0] if isinstance(statement, tuple) else statement
            if first.section != section:
                section = first.section
                yield from heading(self.function, section)
            if isinstance(statement, tuple):
                yield from calls(statement, name, self.number)
                made = [half.target.index for pair in statement for half in pair]
            else:
                text = self.printer.text(statement.shape, statement.operands, name)
                made = [statement.target.index]
                yield f"const {self.number} z{made[0]} = {text};"
            yield from (f"x[{self.layout.place[k]}] = z{k};" for k in made if k in self.layout.place)


def _kernel_operand(operand: Local | External) -> str:
    if isinstance(operand, Local):
        return f"z{operand.position}"
    return "t" if operand.space is Space.TIME else f"e{operand.slot}"

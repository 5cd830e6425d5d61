"""`emit`: from a Program to C text. Layout stands in `templates/`; everything here is strings, numbers, records.

Comes out: a SourceTree with the model's header and source, the runtime it stands on, and the declarations that
cffi reads, taken from those same headers. The same program gives the same bytes on every run and machine.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import accumulate
from pathlib import Path
from types import MappingProxyType
from typing import Any

import jinja2

from lamc.basics._version import __version__
from lamc.basics.resources import data_dir
from lamc.codegen.layout import arrange
from lamc.codegen.names import comment, identifier, identifiers, string_literal
from lamc.codegen.printer import REAL, ShapePrinter, literal
from lamc.codegen.recording import Recording, recording_context
from lamc.codegen.sine_cosine import CALLS
from lamc.symbolic.allocation import collector_paused
from lamc.symbolic.pattern import Pattern
from lamc.symbolic.piecewise import Piecewise
from lamc.symbolic.program import Coordinate, Program

_DECLARATIONS = re.compile(
    r"/\* lamc: declarations begin \*/\n(.*?)/\* lamc: declarations end \*/", re.DOTALL
)

_NUMBERS = re.compile(r"^static const \w+ parameter_defaults\[\] = \{\n.*?^\};\n", re.DOTALL | re.MULTILINE)

_AT_PRECISION = (
    "acceleration",
    "system",
    "dynamics",
    "residual",
    "momenta",
)  # closure must be exact, and the rest costs little

_SEAM = "\x1e"  # between pieces of a model's C while it is rendered: no name or text has control characters
EXAMPLE = "main.c"  # shows how to call the model, and is not compiled
IN_A_LINE = 20  # numbers of a table
GEOMETRY = "geometry"  # member of the struct of parameters that holds the numbers of the drawing


@dataclass(frozen=True)
class SourceTree:
    """Files by name, all in one flat folder; `compiled` are the ones a library needs; main.c is the example."""

    prefix: str
    files: Mapping[str, str]
    compiled: tuple[str, ...]
    declarations: str  # for cffi
    shared: tuple[str, ...]  # names of the files that are the same for everything of this kind
    kind: str = "model"  # of lamc_model, lamc_element: what the library offers
    beside: tuple[str, ...] = ()  # units compiled beside the model's own
    machine: tuple[str, ...] = ()  # the same, for this very machine; none: all is for any of its kind
    functions: tuple[object, ...] = field(default=(), repr=False, compare=False)  # as they were laid out
    # Of a model's C: the comment at its head, what it includes, each of its functions, and what stands behind
    pieces: tuple[str, ...] = field(default=(), repr=False, compare=False)


@dataclass(frozen=True)
class CLookUp:
    """A piecewise polynomial as text."""

    number: int
    count: int  # of breaks
    width: int  # coefficients in a row
    breaks: tuple[str, ...]
    rows: tuple[str, ...]


@dataclass(frozen=True)
class CParameter:
    """One member of the parameter struct."""

    field: str
    literal: str
    name: str
    unit: str
    meaning: str
    default: str


@collector_paused
def emit(
    program: Program,
    precision: str = "double",
    prefix: str = "",
    number: str = "double",
    recording: Recording | None = None,
    like: SourceTree | None = None,
) -> SourceTree:
    """C of `program`, accelerations in "double" or "float". Raises EmitError where an operation has no C form.

    prefix: of the model's names and of its files; empty: from the name of the program
    number: type of all numbers; REAL where they may become float
    recording: what its inputs follow over time; None: whoever runs it brings that
    like: what was emitted at the same precision of a program with the same functions, which are not laid out again
    """
    runtime = _runtime()
    prefix = prefix or identifier(program.name, taken=[Path(name).stem for name in runtime])
    functions = like.functions if like is not None else _laid_out(program, precision, number)
    context = _context(program, prefix, number, functions)
    context["recording"] = recording_context(recording, number) if recording is not None else None
    context["seam"] = _SEAM
    pieces = environment().get_template("model.c.j2").render(context).split(_SEAM)
    files = {
        f"{prefix}.h": environment().get_template("model.h.j2").render(context),
        f"{prefix}.c": "".join(pieces),
        EXAMPLE: environment().get_template("main.c.j2").render(context),
        **runtime,
    }
    compiled = (f"{prefix}.c", *(name for name in sorted(runtime) if name.endswith(".c")))
    # Those of the model's own functions are C users' alone: what Python calls is the same for every model.
    declarations = declarations_of(runtime["lamc_real.h"] + runtime["lamc.h"])
    return SourceTree(
        prefix,
        MappingProxyType(files),
        compiled,
        declarations,
        tuple(sorted(runtime)),
        functions=functions,
        pieces=tuple(pieces),
    )


def without_numbers(text: str) -> str:
    """C of a model without the numbers of its design, which many designs of one structure share."""
    return _NUMBERS.sub("", text)


def declarations_of(header: str) -> str:
    """What stands between the two marks of a header."""
    return "".join(_DECLARATIONS.findall(header))


@cache
def _runtime() -> Mapping[str, str]:
    """The runtime's files, flat; read once."""
    root = data_dir("runtime_c")
    paths = sorted([*(root / "include").glob("*.h"), *(root / "src").glob("*.[ch]")])
    return {path.name: path.read_text(encoding="utf-8") for path in paths}


@cache
def environment() -> jinja2.Environment:
    """The templates, strictly: a name that is not there is an error."""
    return jinja2.Environment(
        loader=jinja2.FileSystemLoader(data_dir("templates")),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )


def _fields(program: Program) -> list[str]:
    """Of the struct of parameters, in C: a name each, then places of the numbers of the drawing."""
    names = identifiers([p.name for p in program.parameters], taken=[GEOMETRY])
    return [*names, *(f"{GEOMETRY}[{place}]" for place in range(len(program.geometry)))]


def _laid_out(program: Program, precision: str, number: str) -> tuple[Any, ...]:
    fields = _fields(program)
    printer, single = ShapePrinter(own_trig=True, number=number), ShapePrinter(single=True)
    return tuple(
        arrange(f, single, fields, "float")
        if precision == "float" and f.name in _AT_PRECISION
        else arrange(f, printer, fields, number)
        for f in program.functions.values()
    )


def _context(program: Program, prefix: str, number: str, functions: Sequence[Any]) -> dict[str, object]:
    parameters = [
        CParameter(
            f,
            string_literal(p.name),
            comment(p.name),
            comment(p.unit),
            comment(p.meaning),
            literal(p.default, number),
        )
        for f, p in zip(_fields(program), program.parameters, strict=False)
    ]
    return {
        "version": __version__,
        "title": comment(program.name),
        "name": string_literal(program.name),
        "prefix": prefix,
        "real": number,
        "guard": f"{prefix.upper()}_H",
        "structure": program.structure,
        "notes": [comment(n) for n in program.notes],
        "joints": [comment(j) for j in program.joints],
        "other_coordinates": other_entries(program, program.coordinates),
        "other_rates": other_entries(program, program.rates),
        "powers": [comment(p) for p in program.powers],
        "pattern": pattern_tables(program.pattern),
        "planned": 0 if program.pattern is None else len(program.pattern.plan),
        "cuts": [comment(j) for j in program.cuts],
        "geometry": [literal(each.value, number) for each in program.geometry],
        "start": [literal(x) for x in program.drawn],
        "bodies": [comment(b) for b in program.bodies],
        "energies": [comment(e) for e in program.energies],
        "parameters": parameters,
        "constant_count": max(1, program.constant_count),
        "strings": {
            # C has no empty arrays: where there is nothing to name, one empty name stands.
            "joint_names": [string_literal(j) for j in program.joints] or ['""'],
            **_coordinate_strings(program),
            "body_names": [string_literal(b) for b in program.bodies] or ['""'],
            "parameter_names": [p.literal for p in parameters] or ['""'],
            "parameter_units": [string_literal(p.unit) for p in program.parameters] or ['""'],
            **({"guard_names": [string_literal(g.name) for g in program.guards]} if program.guards else {}),
            **({"power_names": [string_literal(p) for p in program.powers]} if program.powers else {}),
            **({"series_names": [string_literal(s.name) for s in program.series]} if program.series else {}),
            "energy_names": [string_literal(e) for e in program.energies] or ['""'],
        },
        "counts": counts(program),
        "guard_modes": [g.mode for g in program.guards],
        "clock_guards": [c.guard for c in program.clocks],
        "clock_ticks": [c.tick for c in program.clocks],
        "held": [slot for c in program.clocks for slot in c.held],
        "held_clocks": [k for k, c in enumerate(program.clocks) for _ in c.held],
        "series_orders": [each.order for each in program.series],
        "jacobian_cost": literal(program.jacobian_cost, number),
        "present": sorted(program.functions),
        "tables": look_ups(program, number),
        "functions": functions,
        "has_trig": any(
            text in line
            for f in functions
            for lines in (f.body, *(routine.lines for routine in f.routines))
            for line in lines
            for text in CALLS
        ),
    }


def other_entries(program: Program, entries: Sequence[Coordinate]) -> list[tuple[int, str]]:
    """Number, and name with unit, of the coordinates or rates beyond those of joints."""
    texts = [f"{comment(entry.name)}, {comment(entry.unit)}" for entry in entries]
    return list(enumerate(texts))[len(program.joints) :]


def look_ups(program: Program, number: str = "double") -> list[CLookUp]:
    """The tables of a program as text."""
    return [_look_up(k, table, number) for k, table in program.tables.items()]


def _look_up(k: int, table: Piecewise, number: str) -> CLookUp:
    def text(value: float) -> str:
        return f"LAMC_R({value!r})" if number == REAL else repr(value)

    rows = tuple(", ".join(map(text, row)) for row in table.pieces)
    return CLookUp(k, len(table.breaks), table.degree + 1, tuple(map(text, table.breaks)), rows)


def pattern_tables(pattern: Pattern | None) -> dict[str, list[str]]:
    """The tables of a `lamc_pattern`, as lines; empty for a tree."""
    if pattern is None:
        return {}
    plan = pattern.plan
    tables: dict[str, list[int]] = {
        "row_start": _starts(pattern.rows),
        "column": [j for row in pattern.rows for j in row],
    }
    if plan:
        taken = [step.row for step in plan]
        tables["step_row"] = [*taken, *sorted(set(range(len(pattern.rows))) - set(taken))]
        tables["update_start"] = _starts([step.updates for step in plan])
        tables["update"] = [k for step in plan for k in step.updates]
        tables["left_start"] = _starts([step.left for step in plan])
        tables["left"] = [j for step in plan for j in step.left]
    return {name: _lines(numbers or [0]) for name, numbers in tables.items()}  # C has no empty arrays


def _starts(rows: Sequence[Sequence[int]]) -> list[int]:
    return [0, *accumulate(map(len, rows))]


def _lines(numbers: Sequence[int]) -> list[str]:
    return [", ".join(map(str, numbers[k : k + IN_A_LINE])) + "," for k in range(0, len(numbers), IN_A_LINE)]


def _coordinate_strings(program: Program) -> dict[str, list[str]]:
    """Tables of names and units where there are more coordinates than joints; else those of joints serve."""
    if len(program.coordinates) == len(program.joints):
        return {}
    return {
        f"{what}_{part}s": [string_literal(getattr(entry, part)) for entry in entries]
        for what, entries in (("coordinate", program.coordinates), ("rate", program.rates))
        for part in ("name", "unit")
    }


def counts(program: Program) -> dict[str, int]:
    """How many there are of what templates size arrays by."""
    return {
        "joints": len(program.joints),
        "coordinates": len(program.coordinates),
        "rates": len(program.rates),
        "jacobian_columns": len(program.coordinates) + len(program.rates) + 1,
        "powers": len(program.powers),
        "cuts": len(program.cuts),
        "closure": program.closure_count,
        "entries": 0 if program.pattern is None else program.pattern.entry_count,
        "rank": program.rank,
        "bodies": len(program.bodies),
        "parameters": len(program.parameters),
        "geometry": len(program.geometry),
        "inputs": max(1, len(program.inputs)),
        "constants": program.constant_count,
        "energies": len(program.energies),
        "guards": len(program.guards),
        "tables": len(program.tables),
        "series": len(program.series),
    }

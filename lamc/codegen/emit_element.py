"""`emit_element`: from an ElementProgram to C text. Layout stands in `templates/element*.j2`.

Comes out: a SourceTree with the element's header, its equations, the loops over cells, and what all elements share. The
same program gives the same bytes on every run and machine.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

from lamc.basics._version import __version__
from lamc.basics.resources import data_dir
from lamc.codegen.emit import SourceTree, declarations_of, environment
from lamc.codegen.layout import arrange
from lamc.codegen.names import comment, identifier, string_literal
from lamc.codegen.printer import ShapePrinter, literal
from lamc.symbolic.allocation import collector_paused
from lamc.symbolic.program import ElementProgram, Function, Space

LANES = 2  # cells at once: what all 64-bit processors have registers for; four took half as long again
MAX_BLOCK = 3000  # statements
MATRICES = ("stiffness", "mass", "geometric")
EXTENDED = ("force",)
IN_SECTION = ("strain_in_section", "prestress_in_section", "shear_in_section")

# what a space is called and holds, per cell
_ARGUMENTS = {
    Space.CORNER: ("corners", "x and y of the corners, m"),
    Space.SECTION: ("sections", "unique entries of the section's stiffness"),
    Space.AREAL_MASS: ("areal_mass", "kg/m^2"),
    Space.MEMBRANE_FORCE: ("forces", "N_x, N_y, N_xy, N/m, tension positive"),
    Space.INTENSITY: ("intensity", "forces per area at the corners, N/m^2, field by field"),
    Space.RESULTANT: ("resultants", "membrane forces, N/m, then moments, N"),
    Space.NATURAL: ("at", "xi and eta of a point"),
    Space.UNKNOWN: ("unknowns", "of the element, node by node"),
}


@dataclass(frozen=True)
class CArgument:
    """An input of a function: the letter in equations, the name outside, and how many numbers a cell has."""

    letter: str
    name: str
    size: int


@dataclass(frozen=True)
class CBatch:
    """A function over many cells.

    points  rows of a table over which the function called {name}_at is summed; none: the function is called {name}
    """

    name: str
    purpose: str
    arguments: tuple[CArgument, ...]
    shapes: str
    count: int  # numbers that the equations give for a cell
    is_matrix: bool
    points: tuple[str, ...]


@collector_paused
def emit_element(program: ElementProgram) -> SourceTree:
    """C of `program`. Raises EmitError where an operation has no C form."""
    shared = _shared()
    prefix = identifier(program.name, taken=[Path(name).stem for name in shared])
    context = _context(program, prefix)
    files = {
        f"{prefix}{ending}": environment().get_template(f"element{ending}.j2").render(context)
        for ending in (".h", ".c", "_equations.h")
    }
    compiled = (f"{prefix}.c", *(name for name in sorted(shared) if name.endswith(".c")))
    declarations = declarations_of(shared["lamc_plate.h"]) + declarations_of(files[f"{prefix}.h"])
    return SourceTree(
        prefix,
        MappingProxyType({**files, **shared}),
        compiled,
        declarations,
        shared=tuple(sorted(shared)),
        kind="element",
    )


@cache
def _shared() -> Mapping[str, str]:
    """What all elements share; read once."""
    paths = sorted((data_dir("runtime_c") / "plate").glob("*.[ch]"))
    return {path.name: path.read_text(encoding="utf-8") for path in paths}


def _context(program: ElementProgram, prefix: str) -> dict[str, object]:
    printer = ShapePrinter()
    functions = program.functions
    batches = {name: _batch(program, functions[name]) for name in functions}
    counts = {
        "corner": program.corner_count,
        "node": len(program.nodes),
        "unknown": program.unknown_count,
        "section": program.section_count,
        "strain": program.strain_count,
        "field": len(program.fields),
        "value": len(program.fields) + 2 * ("w" in program.fields),
    }
    return {
        "version": __version__,
        "title": comment(program.name),
        "source": comment(program.source),
        "name": string_literal(program.name),
        "prefix": prefix,
        "guard": f"{prefix.upper()}_H",
        "digest": program.digest,
        "nodes": [f"{k}  {', '.join(names)}" for k, names in enumerate(program.nodes)],
        "inputs": [
            f"{space.value:4} ({program.size(space)})  {meaning}"
            for space, (_, meaning) in _ARGUMENTS.items()
            if any(space in program.inputs(name) for name in functions)
        ],
        "counts": counts,
        "sizes": {
            "lanes": 8 * LANES,  # bytes
            "xy": 2 * counts["corner"],
            "node_pairs": counts["node"] ** 2,
            "matrix": counts["unknown"] ** 2,
        },
        "lanes": LANES,
        "has_calls": any(f.operations.calls for f in functions.values()),
        "has_matrix": any(name in functions for name in MATRICES),
        "functions": [arrange(f, printer, [], "real", MAX_BLOCK) for f in functions.values()],
        "batch_of": batches,
        "batches": list(batches.values()),
        "extended": [batches[name] for name in EXTENDED if name in batches],
        "assembled": [batches[name] for name in MATRICES if name in batches],
        "unknown_nodes": [k for k, node in enumerate(program.nodes) for _ in node],
        "unknown_places": [i for node in program.nodes for i in range(len(node))],
        "scatter": _scatter([len(node) for node in program.nodes]),
        "members": _members(prefix, functions),
    }


def _batch(program: ElementProgram, function: Function) -> CBatch:
    arguments = tuple(
        CArgument(s.value, _ARGUMENTS[s][0], program.size(s)) for s in program.inputs(function.name)
    )
    is_matrix = function.name in MATRICES
    count, d = len(function.outputs), program.unknown_count
    inputs = ", ".join(f"{a.name} (m, {a.size})" for a in arguments)
    return CBatch(
        name=function.name,
        purpose=comment(function.purpose),
        arguments=arguments,
        shapes=f"{inputs} -> out (m, {f'{d}, {d}' if is_matrix else count})",
        count=count,
        is_matrix=is_matrix,
        points=tuple(", ".join(map(literal, p)) for p in program.points.get(function.name, ())),
    )


def _scatter(sizes: list[int]) -> list[str]:
    """Lines that add a lower triangle to the columns of a sparse matrix: blocks of nodes, all entries in full."""
    first = [sum(sizes[:k]) for k in range(len(sizes))]
    lines = []
    for b, columns in enumerate(sizes):
        lines += [f"begin = a->begins[node[{b}]];", f"length = a->begins[node[{b}] + 1] - begin;"]
        for j in range(columns):
            lines.append(f"column = values + begin + {j} * length;" if j else "column = values + begin;")
            for a, rows in enumerate(sizes):
                for i in range(rows):
                    low, high = sorted((first[a] + i, first[b] + j))
                    place = high * (high + 1) // 2 + low
                    lines.append(f"column[to[{len(sizes) * b + a}] + {i}] += triangle[LANES * {place}];")
    return lines


def _members(prefix: str, functions: Mapping[str, Function]) -> list[str]:
    """The functions in the order of lamc_element."""
    order = (*MATRICES, "load", "prestress", "strain", "displacement", "force")
    members = [f"{prefix}_{name}" if name in functions else "NULL" for name in order]
    members += [f"{prefix}_{name}_extended" if name in functions else "NULL" for name in EXTENDED]
    members += [
        f"{prefix}_assemble_{name}" if name in functions else "NULL" for name in (*MATRICES, *EXTENDED)
    ]
    members += [f"{prefix}_assemble_{name}_extended" for name in EXTENDED]
    return members + [f"{prefix}_{name}" if name in functions else "NULL" for name in IN_SECTION]

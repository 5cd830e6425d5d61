"""`emit_tangents`: what runs a model with the derivatives of its states, beside the model's C.

In: a Program with columns and the SourceTree that `emit` made of it. Out: a SourceTree of both. The derivatives
themselves are functions of the model; here they get a name by which the runtime finds them. Never: changes a byte of
the model's C.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from types import MappingProxyType
from typing import Any

from lamc.basics._version import __version__
from lamc.basics.resources import data_dir
from lamc.codegen.emit import SourceTree, counts, declarations_of, environment, look_ups
from lamc.codegen.emit_lanes import has_small_loops
from lamc.codegen.layout import arrange
from lamc.codegen.names import comment
from lamc.codegen.pieces import CFunction
from lamc.codegen.printer import LANES, ShapePrinter
from lamc.symbolic.program import Operand, Program, Space

# In one block of lanes: beyond so many gcc takes seconds, and the machine's cache of instructions is too small.
MAX_STATEMENTS = 4000


def emit_tangents(program: Program, tree: SourceTree) -> SourceTree:
    """`tree` with the runtime of sensitivities and the table of its derivatives."""
    rows, factors = _rows(program), _factors(program)
    context = {
        "version": __version__,
        "title": comment(program.name),
        "structure": program.structure,
        "prefix": tree.prefix,
        "columns": [comment(name) for name in program.columns],
        "present": sorted(program.functions),
        "rows": rows,
        "factors": factors,
        "has_terms": bool(factors) or any(row["states"] or row["columns"] for row in rows),
        "components": sorted({j for row in rows for j, _ in row["states"]}),
        "state_columns": _state_columns(program),
        "side_by_side": _side_by_side(program),
        "given": _given(program),
        "real": "double",
        "tables": look_ups(program),
        "loops": counts(program) if has_small_loops(program) else {},
    }
    unit = f"{tree.prefix}_tangents.c"
    text = environment().get_template("tangents.c.j2").render(context)
    files = {**tree.files, **_runtime(), unit: text}
    return replace(
        tree,
        files=MappingProxyType(files),
        declarations=tree.declarations + declarations_of(files["lamc_sensitivity.h"]),
        machine=("sensitivity.c", unit),
    )


def _rows(program: Program) -> list[dict[str, Any]]:
    """What is not zero of the derivatives of residuals, by row: places in the array, by states and by columns."""
    n, k = _state_columns(program), len(program.columns)
    across = n + k + sum(len(clock.held) for clock in program.clocks)
    outputs = program.functions["tangents"].outputs
    rows: list[dict[str, Any]] = []
    for i in range(len(program.rates) + program.closure_count):
        places = [(j, i * across + j) for j in range(n + k) if _counts(outputs[i * across + j])]
        is_closure = i >= len(program.rates)
        rows.append(
            {
                "target": "goals" if is_closure else "rows",
                "sign": "+" if is_closure else "-",
                "index": i - len(program.rates) if is_closure else i,
                "states": [(j, at) for j, at in places if j < n],
                "columns": [(j - n, at) for j, at in places if j >= n],
            }
        )
    return rows


def _factors(program: Program) -> list[dict[str, Any]]:
    """The places of L's entries that are not zero, by row, and of 1 / D; of a tree whose accelerations are plain."""
    if "acceleration" not in program.functions:
        return []
    outputs, count = program.functions["tangents"].outputs, len(program.rates)
    first = len(outputs) - count * (count + 1) // 2
    rows: list[dict[str, Any]] = []
    for k in range(count):
        begin = first + k * (k + 1) // 2
        rows.append(
            {
                "index": k,
                "lower": [(i, begin + i) for i in range(k) if _counts(outputs[begin + i])],
                "inverse": begin + k,
            }
        )
    return rows


def _counts(output: tuple[int, Operand]) -> bool:
    """True if it is not zero, whatever the numbers."""
    return output[1].space is not Space.NUMBER or output[1].value != 0


def _state_columns(program: Program) -> int:
    """Of the residuals: none, where their derivatives by q and u are had along a direction."""
    if "directional_tangents" in program.functions:
        return 0
    return len(program.coordinates) + len(program.rates)


def _side_by_side(program: Program) -> dict[str, CFunction]:
    """By name, the functions that are written for several lanes too: of stages, and of directions."""
    chosen = [f for name, f in program.functions.items() if name == "directional_tangents"]
    tangents = program.functions["tangents"]
    changes = program.clocks or program.series or "rates" in program.functions  # what a lane knows nothing of
    if not changes and len(tangents.statements) <= MAX_STATEMENTS:
        chosen.append(tangents)
    printer = ShapePrinter(number=LANES)
    return {function.name: arrange(function, printer, [], LANES, MAX_STATEMENTS) for function in chosen}


def _given(program: Program) -> dict[str, str]:
    """Where what the derivatives read lies among the numbers of places, by its letter in C."""
    nq, nu = len(program.coordinates), len(program.rates)
    return {
        "c": "(const lanes *)constants",
        "t": "at[0]",
        "q": "at + 1",
        "u": f"at + {1 + nq}",
        "a": f"at + {1 + nq + nu}",
        "l": f"at + {1 + nq + 2 * nu}",
        "w": "(const lanes *)along",
    }


@cache
def _runtime() -> Mapping[str, str]:
    """The files of `runtime_c/sensitivity`, and the numbers of lanes, flat; read once."""
    root = data_dir("runtime_c")
    paths = [*sorted((root / "sensitivity").glob("*.[ch]")), root / "ensemble" / "lane_numbers.h"]
    return {path.name: path.read_text(encoding="utf-8") for path in paths}

"""`emit_lanes`: a model's C once more, for several runs side by side, with what runs ensembles.

In: a Program and the SourceTree that `emit` made of it. Out: a SourceTree of both; what makes a library of it beside a
model's own flags. Never: changes a byte of the model's C; orders operations otherwise than `emit` does.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from types import MappingProxyType

from lamc.basics._version import __version__
from lamc.basics.resources import data_dir
from lamc.codegen.emit import (
    SourceTree,
    counts,
    declarations_of,
    environment,
    look_ups,
    pattern_tables,
)
from lamc.codegen.layout import arrange
from lamc.codegen.names import comment, identifiers
from lamc.codegen.options import MOST_RATES_IN_LOOPS, why_alone
from lamc.codegen.printer import LANES, ShapePrinter
from lamc.symbolic.allocation import collector_paused
from lamc.symbolic.program import Program

# Statements in one block. Tables of indices cost lanes more than a model (24 hinges in space, 2551 statements: 13.3 ns
# per hinge by kernels, 8.3 straight on); gcc takes four seconds for them.
MAX_BLOCK = 4000
EVALUATED = ("rates", "acceleration", "system")  # what makes dy/dt of a tree
CLOSED = ("rates", "dynamics", "system", "closure")  # and of small loops, with what closes them


@collector_paused
def emit_lanes(program: Program, tree: SourceTree, precision: str = "double") -> SourceTree:
    """`tree` with the C of lanes beside it. Raises EmitError where an operation has no C form."""
    large = bool(program.cuts) and not has_small_loops(program)
    reason = why_alone(large_loops=large, moves=bool(program.rates), precision=precision)
    fields = identifiers(p.name for p in program.parameters)  # only `setup` reads them, which has no lanes
    printer = ShapePrinter(number=LANES)
    evaluated = CLOSED if program.cuts else EVALUATED
    functions = [program.functions[name] for name in evaluated if name in program.functions]
    context = {
        "version": __version__,
        "title": comment(program.name),
        "structure": program.structure,
        "prefix": tree.prefix,
        "real": "double",
        "reason": reason,
        "present": [f.name for f in functions],
        "counts": counts(program),
        "pattern": {} if reason else pattern_tables(program.pattern),
        "tables": look_ups(program),
        "functions": [] if reason else [arrange(f, printer, fields, LANES, MAX_BLOCK) for f in functions],
    }
    text = environment().get_template("lanes.c.j2").render(context)
    files = {**tree.files, **_ensemble_files(), f"{tree.prefix}_lanes.c": text}
    return replace(
        tree,
        files=MappingProxyType(files),
        declarations=tree.declarations + declarations_of(files["lamc_ensemble.h"]),
        kind="model",
        beside=("ensemble.c",),
        machine=(f"{tree.prefix}_lanes.c",),
    )


def has_small_loops(program: Program) -> bool:
    """Whether J is eliminated as one array, each pivot being the largest that is left: by `lane_loops.h` too."""
    pattern = program.pattern
    is_dense = pattern is not None and not pattern.plan and "dynamics" in program.functions
    return (
        is_dense and 0 < len(program.rates) <= MOST_RATES_IN_LOOPS and 0 < program.rank <= len(program.rates)
    )


@cache
def _ensemble_files() -> Mapping[str, str]:
    """The files of `runtime_c/ensemble`, flat; read once."""
    paths = sorted((data_dir("runtime_c") / "ensemble").glob("*.[ch]"))
    return {path.name: path.read_text(encoding="utf-8") for path in paths}

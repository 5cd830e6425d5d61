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
from lamc.codegen.emit import SourceTree, declarations_of, environment, look_ups
from lamc.codegen.layout import arrange
from lamc.codegen.names import comment, identifiers
from lamc.codegen.options import why_alone
from lamc.codegen.printer import LANES, ShapePrinter
from lamc.symbolic.allocation import collector_paused
from lamc.symbolic.program import Program

# Statements in one block. Tables of indices cost lanes more than a model (24 hinges in space, 2551 statements: 13.3 ns
# per hinge by kernels, 8.3 straight on); gcc takes four seconds for them.
MAX_BLOCK = 4000
EVALUATED = ("rates", "acceleration", "system")  # what makes dy/dt of a tree


@collector_paused
def emit_lanes(program: Program, tree: SourceTree, precision: str = "double") -> SourceTree:
    """`tree` with the C of lanes beside it. Raises EmitError where an operation has no C form."""
    reason = why_alone(loops=bool(program.cuts), moves=bool(program.rates), precision=precision)
    fields = identifiers(p.name for p in program.parameters)  # only `setup` reads them, which has no lanes
    printer = ShapePrinter(number=LANES)
    functions = [program.functions[name] for name in EVALUATED if name in program.functions]
    context = {
        "version": __version__,
        "title": comment(program.name),
        "structure": program.structure,
        "prefix": tree.prefix,
        "real": "double",
        "reason": reason,
        "present": [f.name for f in functions],
        "counts": {
            "coordinates": len(program.coordinates),
            "rates": len(program.rates),
            "constants": program.constant_count,
        },
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


@cache
def _ensemble_files() -> Mapping[str, str]:
    """The files of `runtime_c/ensemble`, flat; read once."""
    paths = sorted((data_dir("runtime_c") / "ensemble").glob("*.[ch]"))
    return {path.name: path.read_text(encoding="utf-8") for path in paths}

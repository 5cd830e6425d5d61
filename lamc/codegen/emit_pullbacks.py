"""`emit_pullbacks`: what takes gradients of a model's runs, beside the model's C.

In: a Program with pullbacks and the SourceTree that `emit` made of it. Out: a SourceTree of both. The pullbacks are
functions of the model; here they get a name by which the runtime finds them. Never: changes a byte of the model's C.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from types import MappingProxyType

from lamc.basics._version import __version__
from lamc.basics.resources import data_dir
from lamc.codegen.emit import SourceTree, declarations_of, environment
from lamc.codegen.names import comment
from lamc.symbolic.program import Program


def emit_pullbacks(program: Program, tree: SourceTree) -> SourceTree:
    """`tree` with the runtime of gradients and the table of its pullbacks."""
    context = {
        "version": __version__,
        "title": comment(program.name),
        "structure": program.structure,
        "prefix": tree.prefix,
        "present": sorted(program.functions),
        "sources": program.source_count,
    }
    unit = f"{tree.prefix}_pullbacks.c"
    text = environment().get_template("pullbacks.c.j2").render(context)
    files = {**tree.files, **_runtime(), unit: text}
    return replace(
        tree,
        files=MappingProxyType(files),
        declarations=tree.declarations + declarations_of(files["lamc_adjoint.h"]),
        machine=("tape.c", "adjoint.c", unit),
    )


@cache
def _runtime() -> Mapping[str, str]:
    """The files of `runtime_c/adjoint`, and of `runtime_c/sensitivity` what they share; read once."""
    root = data_dir("runtime_c")
    paths = [*sorted((root / "adjoint").glob("*.[ch]")), root / "sensitivity" / "tableau.h"]
    return {path.name: path.read_text(encoding="utf-8") for path in paths}

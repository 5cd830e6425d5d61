"""`emit_tangents`: what runs a model with the derivatives of its states, beside the model's C.

In: a Program with columns and the SourceTree that `emit` made of it. Out: a SourceTree of both. The derivatives
themselves are functions of the model; here they get a name by which the runtime finds them. Never: changes a byte of
the model's C.
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


def emit_tangents(program: Program, tree: SourceTree) -> SourceTree:
    """`tree` with the runtime of sensitivities and the table of its derivatives."""
    context = {
        "version": __version__,
        "title": comment(program.name),
        "structure": program.structure,
        "prefix": tree.prefix,
        "columns": [comment(name) for name in program.columns],
        "present": sorted(program.functions),
    }
    unit = f"{tree.prefix}_tangents.c"
    text = environment().get_template("tangents.c.j2").render(context)
    files = {**tree.files, **_runtime(), unit: text}
    return replace(
        tree,
        files=MappingProxyType(files),
        declarations=tree.declarations + declarations_of(files["lamc_sensitivity.h"]),
        beside=(unit,),
        machine=("sensitivity.c",),
    )


@cache
def _runtime() -> Mapping[str, str]:
    """The files of `runtime_c/sensitivity`, flat; read once."""
    paths = sorted((data_dir("runtime_c") / "sensitivity").glob("*.[ch]"))
    return {path.name: path.read_text(encoding="utf-8") for path in paths}

"""`emit_ply`: from the lowered function of a ply to C text. Layout stands in `templates/laminate.*.j2`.

Comes out: a SourceTree that `build` takes like that of a model. The same function gives the same bytes.
"""

import hashlib
from collections.abc import Sequence
from types import MappingProxyType

from lamc.basics._version import __version__
from lamc.basics.resources import data_dir
from lamc.codegen.emit import SourceTree, declarations_of, environment
from lamc.codegen.layout import arrange
from lamc.codegen.lowering import canonical
from lamc.codegen.names import comment
from lamc.codegen.printer import ShapePrinter
from lamc.symbolic.program import Function, Space

PREFIX = "laminate"


def digest_of(function: Function) -> str:
    """Of everything in the function."""
    return hashlib.sha256("\n".join(canonical(function)).encode()).hexdigest()


def emit_ply(function: Function, numbers: Sequence[str], terms: Sequence[str]) -> SourceTree:
    """C of `function`, which reads Space.PLY, in the order of `numbers`, and gives `terms` and their derivatives."""
    context = {
        "version": __version__,
        "digest": digest_of(function),
        "numbers": comment(", ".join(numbers)),
        "terms": comment(", ".join(terms)),
        "number_count": len(numbers),
        "term_count": len(terms),
        "output_count": len(function.outputs),
        "letter": Space.PLY.value,
        "function": arrange(function, ShapePrinter(own_trig=True), []),
    }
    files = {
        f"{PREFIX}.{end}": environment().get_template(f"laminate.{end}.j2").render(context) for end in "hc"
    }
    declarations = declarations_of(files[f"{PREFIX}.h"])
    root = data_dir("runtime_c")
    shared = {
        path.name: path.read_text(encoding="utf-8")
        for path in (root / "include" / "lamc_real.h", *sorted((root / "src").glob("trig*.h")))
    }
    every = MappingProxyType({**files, **shared})
    return SourceTree(PREFIX, every, (f"{PREFIX}.c",), declarations, tuple(sorted(shared)), "ply")

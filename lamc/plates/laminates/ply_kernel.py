"""The staged function of one ply, compiled, to be called for all plies of a laminate at once.

In: the equations of `ply_terms.py`. Out: a function of arrays. Never: derives anything; knows laminates.
"""

from collections.abc import Callable
from functools import cache
from typing import TypeAlias

import numpy as np

from lamc.basics.checks import Array
from lamc.codegen.build import build
from lamc.codegen.cache import Cache, cache_root
from lamc.codegen.emit_ply import digest_of, emit_ply
from lamc.codegen.lowering import Lowering
from lamc.codegen.options import CompileOptions
from lamc.codegen.toolchain import find_compiler
from lamc.plates.laminates.ply_terms import PLY_NUMBERS, TERMS, ply_equations
from lamc.symbolic.program import Function, Space
from lamc.symbolic.staging import Level

PlyKernel: TypeAlias = Callable[[Array], tuple[Array, Array]]  # (p, 10) → (p, 25), (p, 25, 10)


@cache
def ply_kernel() -> PlyKernel:
    """Terms of each ply and their derivatives, compiled and cached as simulators are.

    Raises BuildError without a working compiler or cache.
    """
    function, options = ply_function(), CompileOptions()
    tree = emit_ply(function, PLY_NUMBERS, TERMS)
    compiler = find_compiler(options.compiler)
    _, module, _ = build(tree, digest_of(function), compiler, options, Cache(cache_root()))
    lib, ffi = module.lib, module.ffi

    def call(numbers: Array) -> tuple[Array, Array]:
        rows = np.ascontiguousarray(numbers, dtype=np.float64)
        flat = np.empty((len(rows), len(function.outputs)))
        # Through the library each time: without it, what it points to would be unloaded.
        lib.lamc_this_ply().terms(
            len(rows), ffi.from_buffer("double[]", rows), ffi.from_buffer("double[]", flat)
        )
        return split(flat)

    return call


@cache
def ply_function() -> Function:
    """Terms of a ply, then their derivatives, one term after the other."""
    equations = ply_equations()
    outputs = [*equations.values, *(slope for row in equations.slopes for slope in row)]
    return Lowering(equations.store, Level.NUMBER, {}).function(
        "ply_terms",
        "terms of a ply, then the derivatives of each by the ply's numbers",
        (Space.PLY,),
        outputs,
    )


def split(outputs: Array) -> tuple[Array, Array]:
    """Outputs of `ply_function` for several plies, (p, 275), as terms (p, 25) and derivatives (p, 25, 10)."""
    count = len(TERMS)
    return outputs[:, :count], outputs[:, count:].reshape(-1, count, len(PLY_NUMBERS))

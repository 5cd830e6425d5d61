"""From an element to its program and its compiled module: derive → lower → emit → build, by way of the cache.

In: an `Element`. Out: an `ElementProgram`, or a `Module` and the C side's `lamc_element`. Never: cells, arrays.
"""

import hashlib
from collections.abc import Sequence
from functools import cache

from lamc.basics._version import __version__
from lamc.basics.resources import data_dir, own_stamps, stamps
from lamc.codegen.build import build
from lamc.codegen.cache import Cache, cache_root
from lamc.codegen.emit_element import emit_element
from lamc.codegen.module import Module, load_module
from lamc.codegen.options import CompileOptions
from lamc.codegen.toolchain import find_compiler
from lamc.plates.elements.definition import Element
from lamc.plates.elements.lower_element import lower_element
from lamc.symbolic.program import ElementProgram


def element_program(element: Element) -> ElementProgram:
    """The equations of `element`, lowered. Raises DesignError for shape functions that are none."""
    from lamc.plates.elements.derive import derive  # sympy: a compile from the cache does without

    return lower_element(derive(element))


def element_module(element: Element, options: CompileOptions | None = None) -> Module:
    """The compiled element. Nothing is derived when the cache has it.

    Raises DesignError for shape functions that are none, BuildError without a working compiler or cache.
    """
    options = options or CompileOptions()
    compiler = find_compiler(options.compiler, flags=options.flags)
    store = Cache(cache_root())
    alias = alias_of(element, compiler.identity, options.flags)
    key = store.recall(alias)
    folder = store.find(key) if key else None
    if folder is not None:
        return load_module(folder)
    program = element_program(element)
    key, module, _ = build(emit_element(program), program.digest, compiler, options, store)
    store.remember(alias, key)
    return module


def alias_of(element: Element, compiler: str, flags: Sequence[str]) -> str:
    """Digest of all that the compiled module follows from; it lets a compile skip the derivation."""
    parts = ("element", __version__, _own_sources(), compiler, *flags, element.written)
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


@cache
def _own_sources() -> str:
    """Names, sizes and times of the files that shape the C, so that work on lamc itself never meets stale code."""
    shaping = ("basics", "symbolic", "codegen", "mechanics", "plates/elements")
    return own_stamps(*shaping) + stamps([data_dir("templates"), data_dir("runtime_c") / "plate"])

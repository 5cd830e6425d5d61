"""Whether a compiler for WebAssembly is here, and the mark of tests that need one."""

import pytest

from lamc.basics.errors import BuildError
from lamc.export.wasm_module import find_wasm_tools


def has_wasm_tools() -> bool:
    try:
        find_wasm_tools()
    except BuildError:
        return False
    return True


needs_wasm = pytest.mark.skipif(
    not has_wasm_tools(), reason="no compiler for wasm32: neither ziglang nor clang with wasm-ld"
)

"""Loads a compiled module from its entry in the cache. Imports nothing that only building needs."""

import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lamc.codegen.cache import facts
from lamc.errors import BuildError

LIBRARY = "model.so"
BINDING = "binding.py"
SOURCES = "source"


@dataclass(frozen=True)
class Module:
    """A loaded simulator: cffi's `ffi` and `lib`, and where it came from."""

    ffi: Any
    lib: Any
    source_dir: Path
    compiler: str
    flags: tuple[str, ...]


def load_module(folder: Path) -> Module:
    """Opens an entry of the cache that was found intact. Raises BuildError if the library does not load."""
    name = f"_lamc_binding_{folder.name}"
    try:
        spec = importlib.util.spec_from_file_location(name, folder / BINDING)
        assert spec is not None
        assert spec.loader is not None
        binding = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(binding)
        lib = binding.ffi.dlopen(str(folder / LIBRARY))
    except (OSError, ImportError, SyntaxError) as error:
        raise BuildError(
            f"the compiled module in {folder} does not load: {error}; delete it and run again"
        ) from error
    noted = facts(folder)
    return Module(binding.ffi, lib, folder / SOURCES, noted["compiler"], tuple(noted["flags"].split()))

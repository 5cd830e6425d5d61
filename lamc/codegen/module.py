"""Loads a compiled module from its entry in the cache. Imports nothing that only building needs, and writes nothing.

*Invariant*: an entry stays as it was built, so its binding is executed from its text. To Python's import it would be a
module like any other, whose bytecode is put beside it: a file that the entry's manifest does not know.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lamc.basics.errors import BuildError
from lamc.codegen.cache import facts

LIBRARY = "model.so"
BINDING = "binding.py"
SOURCES = "source"


@dataclass(frozen=True, eq=False)
class Module:
    """A loaded simulator: cffi's `ffi` and `lib`, and where it came from."""

    ffi: Any
    lib: Any
    source_dir: Path
    compiler: str
    flags: tuple[str, ...]


def load_module(folder: Path) -> Module:
    """Opens an entry of the cache that was found intact. Raises BuildError if the library does not load.

    The binding is cffi's own text of the declarations; names of a design are in it as identifiers only. It is executed
    here, and not imported, since Python would write beside it, and an entry that changed is none.
    """
    try:
        path = folder / BINDING
        names: dict[str, Any] = {"__name__": f"_lamc_binding_{folder.name}"}
        # No user's file: lamc wrote it, and `Cache.find` saw that nobody else may write here and that nothing changed.
        exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), names)
        ffi = names["ffi"]
        lib = ffi.dlopen(str(folder / LIBRARY))
    except (OSError, ImportError, SyntaxError, KeyError) as error:
        raise BuildError(
            f"the compiled module in {folder} does not load: {error}; delete it and run again"
        ) from error
    noted = facts(folder)
    return Module(ffi, lib, folder / SOURCES, noted["compiler"], tuple(noted["flags"].split()))

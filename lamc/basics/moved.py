"""Old names of modules: they still give what they held, and warn with the new name.

In: the old and the new name of a module. Out: a module's `__getattr__`. It warns once for each place of use.
"""

import warnings
from collections.abc import Callable
from importlib import import_module
from typing import Any


def moved(old: str, new: str) -> Callable[[str], Any]:
    """`__getattr__` of the module `old`, what it held being in `new` now; `lamc` itself where that has the name."""

    def get(name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(f"module {old!r} has no attribute {name!r}")
        there = "lamc" if name in import_module("lamc").__all__ else new
        value = getattr(import_module(there), name)
        warnings.warn(f"{old}.{name} is {there}.{name} now", DeprecationWarning, stacklevel=2)
        return value

    return get

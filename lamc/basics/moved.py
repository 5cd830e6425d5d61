"""Old names: they still give what they held, and warn with the new name.

In: old and new names, of a module or of what is in one. Out: a module's `__getattr__`. It warns once for each place of
use.
"""

import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def moved(old: str, new: str) -> Callable[[str], Any]:
    """`__getattr__` of the module `old`, what it held being in `new` now; `lamc` itself where that has the name."""

    def get(name: str) -> Any:
        if name.startswith("__"):
            raise _unknown(old, name)
        there = "lamc" if name in import_module("lamc").__all__ else new
        return _found(f"{old}.{name}", there, name)

    return get


def renamed(module: str, names: Mapping[str, str]) -> Callable[[str], Any]:
    """`__getattr__` of `module`: old name → new one with its module, as in "lamc.plate.SelfWeight"."""

    def get(name: str) -> Any:
        if name not in names:
            raise _unknown(module, name)
        return _found(f"{module}.{name}", *names[name].rsplit(".", 1))

    return get


def superseded(old: str, new: str) -> None:
    """Warns, where the caller's caller stands, that `old` is called `new` now."""
    warnings.warn(f"{old} is {new} now", DeprecationWarning, stacklevel=3)


def _found(old: str, there: str, name: str) -> Any:
    value = getattr(import_module(there), name)
    warnings.warn(f"{old} is {there}.{name} now", DeprecationWarning, stacklevel=3)
    return value


def _unknown(module: str, name: str) -> AttributeError:
    return AttributeError(
        f"module {module!r} has no attribute {name!r}", name=name, obj=import_module(module)
    )

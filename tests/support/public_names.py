"""What the doors of lamc show, with type hints resolved: also those that only a type checker reads."""

import ast
import sys
import typing
from collections.abc import Iterator, Mapping
from functools import cache, cached_property
from importlib import import_module
from inspect import getattr_static, isclass, isfunction, unwrap
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np

import lamc
from lamc import plate
from lamc.basics.once import lazy
from lamc.mechanics import frames, kane
from lamc.plates import records

DOORS = (lamc, plate, records, frames, kane)


def exposed(*doors: ModuleType) -> list[tuple[str, typing.Any]]:
    """Public names of modules: those of `__all__`, or without it those that the module itself defines."""
    return [(f"{door.__name__}.{name}", getattr(door, name)) for door in doors for name in _names(door)]


def _names(door: ModuleType) -> list[str]:
    own = (n for n, thing in vars(door).items() if getattr(thing, "__module__", "") == door.__name__)
    return getattr(door, "__all__", None) or [name for name in own if not name.startswith("_")]


def signatures() -> Iterator[tuple[str, Mapping[str, typing.Any]]]:
    """(name, hints) of every public function, class and member of a class behind the doors."""
    for name, thing in exposed(*DOORS):
        if isclass(thing):
            yield name, _fields(thing)
            for member in dir(thing):
                function = _function(getattr_static(thing, member))
                if function is not None and (
                    not member.startswith("_") or member in ("__init__", "__call__")
                ):
                    yield f"{name}.{member}", _hints(function)
        elif isfunction(thing):
            yield name, _hints(unwrap(thing))


def _function(member: typing.Any) -> typing.Any:
    """What a method, a property or the like calls, if that is code of lamc with annotations; else None."""
    if isinstance(member, staticmethod | classmethod):
        member = member.__func__
    elif isinstance(member, property):
        member = member.fget
    elif isinstance(member, cached_property):
        member = member.func
    elif isinstance(member, lazy):
        member = member._function
    found = unwrap(member) if callable(member) else None
    return found if isfunction(found) and found.__module__.startswith("lamc.") else None


def _fields(kind: type) -> dict[str, typing.Any]:
    found: dict[str, typing.Any] = {}
    for each in kind.__mro__:
        if each.__module__.startswith("lamc."):
            own = {
                n: hint for n, hint in vars(each).get("__annotations__", {}).items() if not n.startswith("_")
            }
            found = _hints(SimpleNamespace(__annotations__=own, __module__=each.__module__)) | found
    return found


def _hints(thing: typing.Any) -> dict[str, typing.Any]:
    names = {**vars(sys.modules[thing.__module__]), **_checked_only(thing.__module__)}
    return typing.get_type_hints(thing, names, names)


@cache
def _checked_only(module: str) -> dict[str, typing.Any]:
    """What a module imports for a type checker only."""
    text = Path(str(sys.modules[module].__file__)).read_text(encoding="utf-8")
    found: dict[str, typing.Any] = {}
    for block in ast.parse(text).body:
        if isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING":
            for line in block.body:
                if isinstance(line, ast.ImportFrom):
                    source = import_module(str(line.module))
                    found |= {each.asname or each.name: getattr(source, each.name) for each in line.names}
                elif isinstance(line, ast.Import):
                    found |= {each.asname or each.name: import_module(each.name) for each in line.names}
    return found


def has_any(hint: typing.Any) -> bool:
    """Whether `Any` stands in a hint; the shape and the precision of an array may be any, its kind of number not."""
    origin, inner = typing.get_origin(hint), typing.get_args(hint)
    if hint is typing.Any:
        return True
    if origin is np.ndarray:
        return has_any(inner[1])
    if origin is np.floating or getattr(origin, "__module__", "").startswith(
        "numpy._"
    ):  # `ArrayLike` is numpy's
        return False
    return any(has_any(part) for part in (hint if isinstance(hint, list) else inner))

"""The digest of all that a compiled module follows from, so that a compile from the cache derives nothing.

Goes in: mechanism, effects, loops, compiler, options, inputs. Comes out: a digest, or None where there is no telling.
It reads no file but for the names, sizes and times of lamc's own sources.
"""

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any

from lamc._version import __version__
from lamc.codegen.toolchain import Compiler
from lamc.effects.base import Effect
from lamc.effects.registry import EFFECTS
from lamc.inputs import NO_INPUTS, Input
from lamc.loops.rank import LoopCount
from lamc.mechanism.records import Mechanism
from lamc.options import CompileOptions
from lamc.resources import data_dir, stamps
from lamc.scene import Scene


class _NoTellingError(Exception):
    """A value whose text does not tell all of it."""


def input_digest(
    mechanism: Mechanism,
    effects: tuple[Effect, ...],
    loops: LoopCount | None,
    compiler: Compiler,
    options: CompileOptions,
    inputs: Mapping[str, Input] = NO_INPUTS,
    *,
    books: bool = False,
) -> str | None:
    """None if an effect is not lamc's own, as it may change between two runs under the same name, or holds a function.

    books: whether the module tells powers.
    """
    if any(type(effect) not in EFFECTS for effect in effects):
        return None
    closure = f"{loops.rank} {loops.accepted_gap!r}" if loops is not None else ""
    parts = (compiler.identity, *options.flags, mechanism.name, closure)
    words = (*parts, "with books" if books else "without books")
    return _digest(words, mechanism, effects, inputs.items())


def loops_digest(mechanism: Mechanism, effects: tuple[Effect, ...], scene: Scene) -> str | None:
    """Of all that the count of loops follows from: where joints lie, which effects arrange them anew, and how the scene
    starts, as large mechanisms are looked at there too. None as for `input_digest`."""
    if any(type(effect) not in EFFECTS for effect in effects):
        return None
    start = (scene.angles, scene.rates, scene.branch, scene.closure_tolerance)
    return _digest(("loops",), mechanism, effects, start)


def _digest(
    words: Iterable[str], mechanism: Mechanism, effects: tuple[Effect, ...], more: Iterable[object]
) -> str | None:
    text = hashlib.sha256()
    for part in (__version__, _own_sources(), *words):
        text.update(part.encode())
        text.update(b"\0")
    drawn: tuple[Any, ...] = ()
    if mechanism.design is not None and any(hasattr(effect, "arrange") for effect in effects):
        # Coordinates that effects add may follow from what bodies and hinges are made of.
        design = mechanism.design
        drawn = (design.layers, design.hinges, design.fixed, design.body_names)
    try:
        for piece in _pieces((*mechanism.bodies, *mechanism.joints, *effects, *drawn, *more)):
            text.update(piece)
            text.update(b"\0")
    except _NoTellingError:
        return None
    return text.hexdigest()


def _pieces(value: Any) -> Iterator[bytes]:
    """Everything that a value holds, in a fixed order: fields of records, items of mappings and sequences, numbers of
    arrays and geometries to the last bit."""
    if is_dataclass(value) and not isinstance(value, type):
        yield type(value).__name__.encode()
        for entry in fields(value):
            yield entry.name.encode()
            yield from _pieces(getattr(value, entry.name))
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield repr(key).encode()
            yield from _pieces(item)
    elif isinstance(value, tuple | list):
        yield str(len(value)).encode()
        for item in value:
            yield from _pieces(item)
    elif hasattr(value, "tobytes"):
        yield repr((value.shape, str(value.dtype))).encode()
        yield value.tobytes()
    elif hasattr(value, "wkb"):
        yield value.wkb
    elif callable(value):
        raise _NoTellingError
    else:
        yield repr(value).encode()


@cache
def _own_sources() -> str:
    """Names, sizes and times of the files that shape the C, so that work on lamc itself never meets stale code."""
    package = Path(__file__).parent
    folders = [
        package / name
        for name in ("mechanism", "loops", "mechanics", "effects", "codegen", "plate", "design")
    ]
    folders += sorted(
        path.parent for path in (package / "plate").glob("*/__init__.py")
    )  # reduce flexible bodies
    folders += [data_dir("templates"), data_dir("runtime_c") / "include", data_dir("runtime_c") / "src"]
    return stamps(folders)

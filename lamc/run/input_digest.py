"""The digest of all that a compiled module follows from, so that a compile from the cache derives nothing.

Goes in: mechanism, effects, loops, compiler, options, inputs. Comes out: a digest, or None where there is no telling.
It reads no file but for the names, sizes and times of lamc's own sources.
"""

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

import shapely

from lamc.basics._version import __version__
from lamc.basics.resources import data_dir, own_stamps, stamps
from lamc.codegen.options import CompileOptions
from lamc.codegen.toolchain import Compiler
from lamc.effects.registry import EFFECTS
from lamc.loops.rank import LoopCount
from lamc.records.effect import Effect, overrides
from lamc.records.inputs import NO_INPUTS, Input
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene


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
    extras: str = "",
    common: bytes | None = None,
) -> str | None:
    """None if an effect is not lamc's own, as it may change between two runs under the same name, or holds a function.

    extras  what the module offers beside the model
    common  `common_digest` of mechanism and effects, from a caller who has it; None: it is made here
    """
    closure = f"{loops.rank} {loops.accepted_gap!r} {loops.position!r}" if loops is not None else ""
    parts = (compiler.identity, *options.flags, mechanism.name, closure)
    # A series is data that runs bring: only that there is one shapes the C.
    told = [
        (name, each.default, each.unit, each.meaning, each.series is None) for name, each in inputs.items()
    ]
    return _digest((*parts, extras), common or common_digest(mechanism, effects), told)


def loops_digest(
    mechanism: Mechanism, effects: tuple[Effect, ...], scene: Scene, *, common: bytes | None = None
) -> str | None:
    """Of all that the count of loops follows from: where joints lie, which effects arrange them anew, and how the scene
    starts, as large mechanisms are looked at there too. None, and `common`, as for `input_digest`."""
    start = (scene.angles, scene.rates, scene.branch, scene.closure_tolerance)
    return _digest(("loops",), common or common_digest(mechanism, effects), start)


def common_digest(mechanism: Mechanism, effects: tuple[Effect, ...]) -> bytes | None:
    """Of mechanism and effects, which all other digests follow from; None as for `input_digest`."""
    if any(type(effect) not in EFFECTS for effect in effects):
        return None
    drawn: tuple[Any, ...] = ()
    if mechanism.design is not None and any(overrides(effect, "arrange") for effect in effects):
        # Coordinates that effects add may follow from what bodies and hinges are made of.
        design = mechanism.design
        drawn = (design.layers, design.hinges, design.fixed, design.body_names)
    try:
        told = (*mechanism.bodies, *mechanism.joints, mechanism.facet_creases, *effects, *drawn)
        return _hash(_pieces(told)).digest()
    except _NoTellingError:
        return None


def _digest(texts: Iterable[str], common: bytes | None, more: Iterable[object]) -> str | None:
    if common is None:
        return None
    reported = [part.encode() for part in (__version__, own_sources(), *texts)]
    try:
        return _hash([*reported, common, *_pieces(tuple(more))]).hexdigest()
    except _NoTellingError:
        return None


def _hash(pieces: Iterable[bytes]) -> "hashlib._Hash":
    return hashlib.sha256(b"\0".join(pieces))


def _pieces(value: Any) -> list[bytes]:
    """Everything that a value holds, in a fixed order: fields of records, items of mappings and sequences, numbers of
    arrays and geometries to the last bit."""
    pieces: list[bytes] = []
    geometries: list[tuple[int, Any]] = []
    _gather(value, pieces, geometries)
    # All at once: one call for each would be half of the digest of a mechanism of many plates.
    for (at, _), reported in zip(geometries, shapely.to_wkb([shape for _, shape in geometries]), strict=True):
        pieces[at] = reported
    return pieces


def _gather(value: Any, pieces: list[bytes], geometries: list[tuple[int, Any]]) -> None:
    """Appends what a value holds; geometries are left open, and told with their place in `pieces`."""
    kind, names = _kind(type(value))  # type: ignore[arg-type]  # to mypy a type is not hashable
    if kind == "other":
        pieces.append(repr(value).encode())
    elif kind == "record":
        pieces.append(type(value).__name__.encode())
        for name, reported in names:
            pieces.append(reported)
            _gather(getattr(value, name), pieces, geometries)
    elif kind == "mapping":
        for key, item in value.items():
            pieces.append(repr(key).encode())
            _gather(item, pieces, geometries)
    elif kind == "sequence":
        pieces.append(str(len(value)).encode())
        for item in value:
            _gather(item, pieces, geometries)
    elif kind == "array":
        pieces += [repr((value.shape, str(value.dtype))).encode(), value.tobytes()]
    elif kind == "geometry":
        geometries.append((len(pieces), value))
        pieces.append(b"")
    else:
        raise _NoTellingError


@cache
def _kind(of: type) -> tuple[str, tuple[tuple[str, bytes], ...]]:
    """How values of a type are reported; of records also the fields, with their names in bytes."""
    if is_dataclass(of):
        return "record", tuple((entry.name, entry.name.encode()) for entry in fields(of))
    for kind, holds in (
        ("mapping", issubclass(of, Mapping)),
        ("sequence", issubclass(of, tuple | list)),
        ("array", hasattr(of, "tobytes")),
        ("geometry", issubclass(of, shapely.Geometry)),
        ("function", any("__call__" in vars(base) for base in of.__mro__)),  # as `callable` of a value
    ):
        if holds:
            return kind, ()
    return "other", ()


@cache
def own_sources() -> str:
    """Names, sizes and times of the files that shape the C, so that work on lamc itself never meets stale code."""
    shaping = (
        "basics",
        "symbolic",
        "codegen",
        "records",
        "mechanism",
        "design",
        "loops",
        "mechanics",
        "plates",
        "effects",
    )
    data = [
        data_dir("templates"),
        *(data_dir("runtime_c") / part for part in ("include", "src", "ensemble", "sensitivity", "adjoint")),
    ]
    return own_stamps(*shaping) + stamps(data)

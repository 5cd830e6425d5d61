"""The compiled mesher: `runtime_c/mesher`, built once for a compiler and kept in the cache.

In: points, segments between them, and how large cells shall be. Out: points and cells. Never: polygons, units, regions
by name.
"""

import hashlib
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lamc.basics._version import __version__
from lamc.basics.checks import Array
from lamc.basics.errors import DesignError
from lamc.basics.resources import data_dir
from lamc.codegen.options import CompileOptions

Integers = NDArray[np.int32]

LEAST_ANGLE = np.radians(
    29.0
)  # asked of the refinement; proven up to 26°, and reached up to 33° on real outlines
_SMOOTHING = 3  # passes; later ones change the angles by less than a degree
_DONE, _FULL, _CROSSING, _DOUBLE = 0, 1, 2, 3


@dataclass(frozen=True, eq=False)
class Lines:
    """What is to be meshed, in coordinates of order one."""

    points: Array  # (n, 2); the first four are a box far around
    sizes: Array  # (n,), wanted length of edges
    segment_of: Integers  # (n,), the given segment that a point lies on; -1: a corner
    segments: Integers  # (s, 2), parts of given segments, between any points
    segment_ends: Integers  # (given segments, 2), corners


@dataclass(frozen=True, eq=False)
class Triangulation:
    """All points, those of `Lines` first, and the cells of the regions."""

    points: Array  # (n, 2)
    segment_of: Integers  # (n,), the given segment that a point lies on; -1: a corner; -2: none
    cells: Integers  # (m, 3)
    regions: Integers  # (m,)


class Full(Exception):  # noqa: N818  not an error by itself: the caller decides
    """More cells than there is room for."""


def triangulate(
    lines: Lines,
    regions_at: Callable[[Array], Integers],
    region_sizes: Array,
    grading: float,
    least: float,
    capacity: int,
) -> Triangulation:
    """Triangles with all of `lines` as edges.

    regions_at    region of each of (k, 2) points, -1 for outside
    region_sizes  (r,), wanted length of edges
    least         part of the wanted length below which no edge is made for the sake of angles
    capacity      cells to make room for

    Raises Full, BuildError, and DesignError where segments cross.
    """
    ffi, lib = _library()
    count = len(lines.points)
    room = max(capacity, 4 * count) + 64
    stack = 9 * min(room, 8 * count + 4096)
    arrays: dict[str, NDArray[Any]] = {
        "points": np.empty((room // 2 + 64, 2)),
        "sizes": np.empty(room // 2 + 64),
        "segment_of": np.empty(room // 2 + 64, np.int32),
        "cell_at": np.empty(room // 2 + 64, np.int32),
        **{name: np.empty((room, 3), np.int32) for name in ("corners", "neighbours")},
        **{name: np.empty(room, np.int32) for name in ("regions", "marks", "queue")},
        "flags": np.empty(room, np.uint8),
        "stack": np.empty(stack, np.int32),
    }
    arrays["points"][:count], arrays["sizes"][:count] = lines.points, lines.sizes
    arrays["segment_of"][:count] = lines.segment_of
    mesher = ffi.new("lamc_mesher *")
    mesher.point_capacity, mesher.cell_capacity, mesher.stack_capacity = room // 2 + 64, room, stack
    mesher.point_count = count
    for name, array in arrays.items():
        setattr(mesher, name, _pointer(ffi, array))
    segments = np.ascontiguousarray(lines.segments, dtype=np.int32)
    _check(lib.lamc_mesher_triangulate(mesher, _pointer(ffi, segments), len(segments)), mesher, lines)

    pieces = arrays["regions"][: mesher.cell_count]
    corners = arrays["points"][arrays["corners"][: mesher.cell_count]]
    pieces[:] = regions_at(_places(pieces, corners))[pieces]
    ends = np.ascontiguousarray(lines.segment_ends, dtype=np.int32)
    sizes, floors = np.array(region_sizes, dtype=float), least * np.asarray(region_sizes, dtype=float)
    rules = ffi.new("lamc_mesher_rules *")
    rules.region_count, rules.region_sizes, rules.region_floors = (
        len(sizes),
        _pointer(ffi, sizes),
        _pointer(ffi, floors),
    )
    rules.segment_ends, rules.grading, rules.least_angle = _pointer(ffi, ends), grading, LEAST_ANGLE
    _check(lib.lamc_mesher_refine(mesher, rules), mesher, lines)
    _check(lib.lamc_mesher_smooth(mesher, _SMOOTHING), mesher, lines)
    regions = arrays["regions"][: mesher.cell_count]
    kept = regions >= 0
    return Triangulation(
        arrays["points"][: mesher.point_count].copy(),
        arrays["segment_of"][: mesher.point_count].copy(),
        arrays["corners"][: mesher.cell_count][kept],
        regions[kept],
    )


def _pointer(ffi: Any, array: NDArray[Any]) -> Any:
    kind = {"f": "double *", "i": "int32_t *", "u": "uint8_t *"}[array.dtype.kind]
    return ffi.cast(kind, array.ctypes.data)


def _places(pieces: Integers, corners: Array) -> Array:
    """A point well inside each piece: the middle of its largest cell."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    order = np.lexsort((-(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]), pieces))
    _, first = np.unique(pieces[order], return_index=True)
    return np.asarray(corners[order[first]].mean(axis=1))


def _check(status: int, mesher: Any, lines: Lines) -> None:
    if status == _DONE:
        return
    if status == _FULL:
        raise Full
    at = lines.points[mesher.failed]
    if status == _CROSSING:
        at = lines.points[lines.segments[mesher.failed]].mean(axis=0)
    raise MesherError(at)


class MesherError(DesignError):
    """The lines cross at `at`, in the mesher's coordinates."""

    def __init__(self, at: Array) -> None:
        self.at = at
        super().__init__("lines cross")


@lru_cache(maxsize=1)
def _library() -> tuple[Any, Any]:
    """cffi's `ffi` and `lib`. Raises BuildError."""
    from lamc.codegen.cache import Cache, cache_root
    from lamc.codegen.module import load_module
    from lamc.codegen.toolchain import find_compiler

    root = data_dir("runtime_c") / "mesher"
    files = {path.name: path.read_text(encoding="utf-8") for path in sorted(root.glob("*.[ch]"))}
    options, cache = CompileOptions(), Cache(cache_root())
    compiler = find_compiler(None)
    parts = ["mesher", __version__, compiler.identity, *options.flags, sys.implementation.cache_tag or ""]
    digest = hashlib.sha256("\0".join([*parts, *files, *files.values()]).encode()).hexdigest()
    folder = cache.find(f"mesher-{digest}")
    if folder is None:
        noted = {
            "compiler": " ".join(compiler.command),
            "flags": " ".join(options.flags),
            "lamc": __version__,
        }
        folder = cache.put(f"mesher-{digest}", _maker(files, options), noted)
    module = load_module(folder)
    return module.ffi, module.lib


def _maker(files: dict[str, str], options: CompileOptions) -> Callable[[Path], None]:
    import cffi
    from cffi import recompiler

    from lamc.codegen.emit import declarations_of
    from lamc.codegen.module import BINDING, LIBRARY, SOURCES
    from lamc.codegen.toolchain import find_compiler, make_library

    def make(folder: Path) -> None:
        source = folder / SOURCES
        source.mkdir()
        for name, text in files.items():
            (source / name).write_text(text, encoding="utf-8", newline="\n")
        units = [f"{SOURCES}/{name}" for name in files if name.endswith(".c")]
        make_library(find_compiler(None), options.flags, units, LIBRARY, folder)
        binding = cffi.FFI()
        binding.cdef(declarations_of(files["mesher.h"]))
        binding.set_source("binding", None)
        recompiler.make_py_source(binding, "binding", str(folder / BINDING))

    return make

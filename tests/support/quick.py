"""Compiles the models of tests quickly: two thirds of what tests of models cost is the C compiler's optimiser.

The generated C keeps to IEEE arithmetic without contraction, so its bits do not depend on the level; tests of exports
hold that with two compilers at three levels (`test_compilers_agree_to_the_last_bit`). The runtime of the session's
cache, the shorter elements of plates and the mesher are compiled once per run and do most of the arithmetic: they keep
theirs.
The runtime of other caches, those of tests of the cache and of ledgers, is compiled once by each process and copied:
twenty calls of the compiler that give the same bytes. `pytest --as-shipped` compiles everything as users get it.
"""

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import cache
from pathlib import Path
from typing import Any, BinaryIO

import pytest

import lamc
from lamc.codegen import build, toolchain
from lamc.export import fmu, wheel

KEPT = frozenset({"_this_element.c", "_this_ply.c"})  # entries of plates' modules (`lamc.codegen.build`)
LONG = 30_000  # bytes of an element's C: a second of the optimiser and more, and no test solves large meshes with it
LEVEL = "-O0"  # gcc 12, the C of four hinges: 0.13 s; 0.34 s with -O1, 0.52 s with -O2

# The same for a process: a program begins with this, and has a cache of its own.
QUICKLY = """
from lamc.codegen import build, toolchain
def _quickly(make):
    def quick(compiler, flags, *others):
        return make(compiler, ["-O0" if f in ("-O1", "-O2") else f for f in flags], *others)
    return quick
build.make_objects, build.make_library = _quickly(toolchain.make_objects), _quickly(toolchain.make_library)
"""


def tries(count: int) -> int:
    """How many examples hypothesis tries of a test: a fifth in `make test`."""
    from hypothesis import settings

    return max(3, count // 5) if settings.get_current_profile_name() == "quick" else count


def with_runtime(cache: Path, shared: Path) -> Path:
    """`cache`, which a process will have for itself, with the runtime of the session's cache: twenty calls of the
    compiler that are no matter of its test."""
    from tests.support.mechanisms import chain

    cache.mkdir(mode=0o700, exist_ok=True)
    if not any(shared.glob("runtime-*")):
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("LAMC_CACHE_DIR", str(shared))
            lamc.compile(chain(1, "parallel", seed=1))
    for entry in sorted(shared.glob("runtime-*")):
        shutil.copytree(entry, cache / entry.name)
    return cache


def quickly(flags: Sequence[str]) -> tuple[str, ...]:
    """The flags, optimising nothing."""
    return tuple(LEVEL if flag in ("-O1", "-O2") else flag for flag in flags)


def _is_long(folder: Path) -> bool:
    """Whether an element whose entry is made in `folder` has long C."""
    return max(path.stat().st_size for path in (folder / build.SOURCES).glob("*.c")) > LONG


@cache
def _linker(program: str) -> tuple[str, ...]:
    """GNU's quicker linker, where gcc has it: 0.02 s for a model; 0.04 s with the other."""
    is_gcc = "gcc" in Path(program).resolve().name
    return ("-fuse-ld=gold",) if is_gcc and shutil.which("ld.gold") else ()


@contextmanager
def unpainted_figures() -> Iterator[None]:
    """Within it, figures are composed, and neither laid out nor painted, which takes up to a second each; their files
    are no pictures."""

    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    def savefig(_figure: object, target: BinaryIO | str, **_settings: object) -> None:
        with open(target, "wb") if isinstance(target, str) else nullcontext(target) as stream:
            stream.write(b"\x89PNG\r\n\x1a\n")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", savefig)
        patch.setattr(ConstrainedLayoutEngine, "execute", lambda _engine, _figure: None)
        yield


@contextmanager
def quick_compilation(shared: Path | None = None) -> Iterator[None]:
    """Within it, models, FMUs and wheels are compiled without optimisation, and so is the runtime, but for that of
    the cache `shared`, which most runs are made with."""

    def make(
        compiler: toolchain.Compiler, flags: Sequence[str], units: Sequence[str], *others: Any, **named: Any
    ) -> None:
        flags = quickly(flags) if KEPT.isdisjoint(units) or _is_long(others[1]) else flags
        toolchain.make_library(compiler, flags, units, *others, **named)

    known: dict[tuple[str, ...], list[bytes]] = {}

    def objects(
        compiler: toolchain.Compiler, flags: Sequence[str], units: Sequence[str], folder: Path
    ) -> list[Path]:
        if units[0].startswith(f"{build.SOURCES}/"):  # a model's own, beside it: lanes, derivatives
            return toolchain.make_objects(compiler, quickly(flags), units, folder)
        if folder.parent == shared:  # an entry is made in its cache's folder
            return toolchain.make_objects(compiler, flags, units, folder)
        texts = [path.read_text(encoding="utf-8") for path in sorted(folder.iterdir())]
        key = (compiler.identity, *flags, *units, *texts)
        if key not in known:
            made = toolchain.make_objects(compiler, quickly(flags), units, folder)
            known[key] = [path.read_bytes() for path in made]
            return made
        paths = [folder / f"{Path(unit).stem}.o" for unit in units]
        for path, content in zip(paths, known[key], strict=True):
            path.write_bytes(content)
        return paths

    def linked_quickly(compiler: toolchain.Compiler, flags: Sequence[str], *others: Any) -> None:
        make(compiler, (*flags, *_linker(compiler.command[0])), *others)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build, "make_objects", objects)
        patch.setattr(build, "make_library", linked_quickly)
        for module in (fmu, wheel):
            patch.setattr(module, "make_library", make)
        yield

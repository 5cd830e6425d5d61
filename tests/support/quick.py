"""Compiles the models of tests quickly: two thirds of what tests of models cost is the C compiler's optimiser.

The generated C keeps to IEEE arithmetic without contraction, so its bits do not depend on the level; tests of exports
hold that with two compilers at three levels (`test_compilers_agree_to_the_last_bit`). The runtime of the session's
cache, the elements of plates and the mesher are compiled once per run and do most of the arithmetic: they keep theirs.
`pytest --as-shipped` compiles everything as users get it.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from _pytest.mark.structures import ParameterSet

from lamc.codegen import build, toolchain
from lamc.export import fmu, wheel

KEPT = frozenset({"_this_element.c", "_this_ply.c"})  # entries of plates' modules (`lamc.codegen.build`)
LEVEL = "-O0"  # gcc 12, the C of four hinges: 0.13 s; 0.34 s with -O1, 0.52 s with -O2


def slow_but(quick: Collection[object], values: Iterable[object]) -> list[ParameterSet]:
    """Parameters of a test of one argument: all but `quick` are among the slow ones."""
    return [pytest.param(value, marks=[] if value in quick else [pytest.mark.slow]) for value in values]


def quickly(flags: Sequence[str]) -> tuple[str, ...]:
    """The flags, optimising nothing."""
    return tuple(LEVEL if flag == "-O2" else flag for flag in flags)


@contextmanager
def quick_compilation(shared: Path | None = None) -> Iterator[None]:
    """Within it, models, FMUs and wheels are compiled without optimisation, and so is the runtime, but for that of
    the cache `shared`, which most runs are made with."""

    def make(
        compiler: toolchain.Compiler, flags: Sequence[str], units: Sequence[str], *others: Any, **named: Any
    ) -> None:
        flags = quickly(flags) if KEPT.isdisjoint(units) else flags
        toolchain.make_library(compiler, flags, units, *others, **named)

    def objects(
        compiler: toolchain.Compiler, flags: Sequence[str], units: Sequence[str], folder: Path
    ) -> list[Path]:
        own = folder.parent == shared  # an entry is made in its cache's folder
        return toolchain.make_objects(compiler, flags if own else quickly(flags), units, folder)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build, "make_objects", objects)
        for module in (build, fmu, wheel):
            patch.setattr(module, "make_library", make)
        yield

"""C of links that are too unlike to become kernels, such as long cycles around holes: their steps become kernels."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.codegen import build as building
from lamc.codegen.build import build
from lamc.codegen.cache import Cache
from lamc.codegen.emit import SourceTree, emit
from lamc.codegen.options import CompileOptions
from lamc.codegen.segments import lay_out
from lamc.codegen.toolchain import find_compiler
from lamc.pipeline.stages import effects_of, equations_of, sources_of
from lamc.records.mechanism import Mechanism
from lamc.records.scene import Scene
from lamc.reference.check import check
from lamc.symbolic.program import Program
from tests.support import fold_corpus
from tests.support.ctools import needs_cc

CREASES = 40
SEED = 20261128


def ring(folder: Path) -> Mechanism:
    """Flat facets around a hole, creases of the same length between them, none like another: one cycle."""
    turns = 2.0 * np.pi * (np.arange(CREASES) + 0.5 * np.random.default_rng(SEED).random(CREASES)) / CREASES
    corners = [(r * np.cos(a + 0.1 * (r > 10.0)), r * np.sin(a)) for r in (10.0, 30.0) for a in turns]
    data = fold_corpus._started(corners, "mm")
    for k in range(CREASES):
        for start in (0, CREASES):
            fold_corpus._edge(data, start + k, start + (k + 1) % CREASES, "B")
        fold_corpus._edge(data, k, CREASES + k, "MV"[k % 2])
    made = lamc.load(
        fold_corpus.write(folder / "ring.fold", data), card=lamc.Card(), crease=1e-3, facets="rigid"
    )
    assert isinstance(made, Mechanism)
    return made


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Program, SourceTree]:
    mechanism = ring(tmp_path_factory.mktemp("ring"))
    return sources_of(equations_of(mechanism, effects_of(mechanism, Scene())))


@pytest.mark.slow
def test_steps_around_a_long_cycle_become_kernels(made: tuple[Program, SourceTree]) -> None:
    """Of 40 creases around a hole no two cycles are alike, as there is one. Most of it is the same again and again; the
    first steps, which have zeros, and what is done once are written out. Of larger holes gcc takes seconds for all."""
    program, _ = made
    function = program.functions["closure"]
    layout = lay_out(function)
    written = sum(
        segment.stop - segment.start
        for segment, kernel in zip(layout.segments, layout.class_of, strict=True)
        if kernel is None
    )
    assert written < 0.25 * len(function.statements)


@pytest.mark.slow
@needs_cc
def test_its_c_agrees_with_independent_cross_checks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At some states, and as far along a run as the others come in a second."""
    monkeypatch.setattr(sys.modules[check.__module__], "SECONDS", 1.0)
    report = check(lamc.compile(ring(tmp_path)), states=4, t_end=0.01)
    assert report.passed, str(report)


@pytest.mark.slow
@needs_cc
def test_no_name_is_taken_for_c_where_functions_stand_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A sheet is called what its user likes, and its C begins with that in a comment."""
    monkeypatch.setattr(building, "LARGE", 1000)
    named = replace(ring(tmp_path), name='the #include "/etc/hostname" sheet */')
    sim = lamc.compile(named, cache=Cache(tmp_path / "cache"))
    assert sim.run(1e-3).success


@pytest.mark.slow
@needs_cc
def test_functions_are_compiled_once_for_branches_of_two_ranks(
    made: tuple[Program, SourceTree], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A large model is compiled in parts. What its loops come to is none of its functions'."""
    monkeypatch.setattr(building, "LARGE", 1000)
    program, tree = made
    cache, compiler, options = Cache(tmp_path), find_compiler(None), CompileOptions()
    of_rank = replace(program, rank=program.rank - 1, structure="another")
    keys = set()
    for each, source in ((program, tree), (of_rank, emit(of_rank, like=tree))):
        key, module, _ = build(source, each.structure, compiler, options, cache)
        assert module.lib.lamc_this_model().rank == each.rank
        keys.add(key)
    assert len(keys) == 2
    kept = [path.name for path in tmp_path.iterdir() if path.name.startswith("functions-")]
    assert len([name for name in kept if not name.endswith(".note")]) == 1

"""The count of loops is kept: the same to the last bit, counted again where anything that it follows from differs."""

from dataclasses import replace
from pathlib import Path

import pytest

import lamc
from lamc.codegen.cache import Cache
from lamc.examples import path
from lamc.loops.kept import kept_loops
from lamc.loops.misfit import Misfit
from lamc.loops.rank import Found, LoopCount
from lamc.loops.starts import Starter
from lamc.run import scene_loops
from tests.support.ctools import needs_cc

COUNT = LoopCount(
    1,
    6,
    3,
    1,
    (1.25, 0.1, 1e-17),
    Misfit(3, 1.1e-7, "h4"),
    1e-6,
    start=Found((("h1", 0.1),), ("h1", "h2"), (0.1, -0.1)),
)


def test_a_kept_count_is_the_count_to_the_last_bit(tmp_path: Path) -> None:
    cache = Cache(tmp_path / "cache")
    assert kept_loops("a" * 64, cache, lambda: COUNT) == COUNT
    assert kept_loops("a" * 64, cache, lambda: pytest.fail("counted again")) == COUNT
    assert kept_loops(None, cache, lambda: COUNT) is COUNT


@pytest.mark.parametrize("spoil", [b"", b"x", b"\xff", None])
def test_a_damaged_note_is_counted_again(tmp_path: Path, spoil: bytes | None) -> None:
    cache = Cache(tmp_path / "cache")
    kept_loops("a" * 64, cache, lambda: COUNT)
    (note,) = cache.root.glob("*.note")
    note.write_bytes(note.read_bytes().replace(b'"rank": 3', b'"rank": 4') if spoil is None else spoil)
    assert kept_loops("a" * 64, cache, lambda: COUNT) == COUNT


def test_a_cache_that_cannot_be_written_costs_a_count_only(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert kept_loops("a" * 64, Cache(tmp_path / "file" / "cache"), lambda: COUNT) == COUNT


@needs_cc
def test_a_warm_start_counts_no_loops(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache, design = Cache(tmp_path / "cache"), lamc.load(path("four_bar"))
    counted = []
    loops_of = scene_loops.loops_of
    monkeypatch.setattr(scene_loops, "loops_of", lambda *given: counted.append(1) or loops_of(*given))
    first = lamc.compile(design, cache=cache).loops
    assert lamc.compile(design, cache=cache).loops == first
    assert len(counted) == 1
    assert design.scene is not None
    lamc.compile(design, replace(design.scene, closure_tolerance=1e-5), cache=cache)
    assert len(counted) == 2


@needs_cc
def test_the_position_of_a_start_is_looked_for_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The search takes most of the time of a start. Angles of another scene are looked for anew."""
    searched = []
    search = Starter._position
    monkeypatch.setattr(Starter, "_position", lambda *given: searched.append(1) or search(*given))
    cache, design = Cache(tmp_path / "cache"), lamc.load(path("four_bar"))
    start = lamc.compile(design, cache=cache).start
    assert len(searched) == 1
    assert lamc.compile(design, cache=cache).start == pytest.approx(start, abs=0.0)
    assert len(searched) == 1
    assert design.scene is not None
    other = lamc.compile(design, replace(design.scene, angles={"arm": 0.25}), cache=cache)
    assert other.start[other.joints.index("arm")] == 0.25
    assert len(searched) > 1

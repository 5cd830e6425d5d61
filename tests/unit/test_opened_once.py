"""A module that is at hand is not verified and opened again for another drawing of its topology."""

import pickle
from pathlib import Path

import pytest

import lamc
from lamc.codegen.cache import Cache
from lamc.examples import path
from lamc.pipeline import job
from lamc.records.design import Design
from lamc.run import kept_programs
from tests.support.ctools import needs_cc


@needs_cc
def test_what_was_compiled_just_now_serves_other_drawings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = []
    load = kept_programs.load_module
    monkeypatch.setattr(kept_programs, "load_module", lambda folder: opened.append(1) or load(folder))
    design = lamc.load(path("four_bar"))
    assert isinstance(design, Design)
    first = lamc.compile(design, cache=Cache(tmp_path / "cache"))
    for length in (0.047, 0.05):
        other = first.with_design(design.with_parameters(link_length=length))
        assert other.structure == first.structure
    assert not opened


@needs_cc
def test_what_drawings_have_in_common_is_looked_for_once_and_stays_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Compiled code and compiler of a simulator serve those made of it, as long as they are of its structure; another
    process looks for both itself."""
    looked = []
    find, known = job.find_compiler, kept_programs.kept_structure
    monkeypatch.setattr(job, "find_compiler", lambda *a, **k: looked.append("cc") or find(*a, **k))
    monkeypatch.setattr(kept_programs, "kept_structure", lambda *a: looked.append("structure") or known(*a))
    design = lamc.load(path("four_bar"))
    assert isinstance(design, Design)
    sim = lamc.compile(design, cache=Cache(tmp_path / "cache"))
    looked.clear()
    for length in (0.047, 0.05, 0.052):
        sim = sim.with_design(design.with_parameters(link_length=length))
    assert looked == ["cc", "structure"]
    again = pickle.loads(pickle.dumps(sim))
    assert again.model.digest == sim.model.digest
    assert looked[2:] == ["cc", "structure"]

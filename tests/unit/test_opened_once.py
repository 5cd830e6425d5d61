"""A module that is at hand is not verified and opened again for another drawing of its topology."""

from pathlib import Path

import pytest

import lamc
from lamc.codegen.cache import Cache
from lamc.examples import path
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

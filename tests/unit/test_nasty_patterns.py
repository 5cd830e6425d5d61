"""Crease patterns as other programs write them: each is a sheet, or is refused with what, where and the way out."""

import warnings
from pathlib import Path

import pytest

import lamc
from lamc.basics.errors import DesignError, DesignWarning
from lamc.records.mechanism import Mechanism
from tests.support.nasty_corpus import fold_file, svg_file
from tests.support.quick import tries

FILES = [make(seed) for seed in range(tries(30)) for make in (fold_file, svg_file)]


@pytest.mark.slow
def test_patterns_of_other_programs_are_sheets(tmp_path: Path) -> None:
    refused = []
    for name, text in FILES:
        (tmp_path / name).write_text(text)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DesignWarning)
            try:
                sheet = lamc.load(tmp_path / name)
            except DesignError as error:
                refused.append((name, str(error)))
                continue
        assert isinstance(sheet, Mechanism), name
        assert sheet.joints, name
    assert refused == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_patterns_of_other_programs_run(tmp_path: Path, seed: int) -> None:
    name, text = svg_file(seed)
    (tmp_path / name).write_text(text)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        result = lamc.compile(lamc.load(tmp_path / name)).run(0.01, rtol=1e-5, max_steps=3000)
    assert result.success, result.message

"""What is too much work is refused by what is counted, before it is done, with the way out; the largest models are
compiled with less optimisation, and keep their bits."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

import lamc
from lamc.basics.errors import DesignError, DesignWarning
from lamc.cli import main
from lamc.codegen import build
from lamc.commands.inputs import Source
from lamc.loops import work
from lamc.readers import fold_faces
from lamc.records.card import SheetOptions
from lamc.records.mechanism import Mechanism
from tests.support import fold_corpus, hostile_corpus, large_corpus
from tests.support.ctools import needs_cc

CARD = lamc.Card(thickness="0.3 mm", density="700 kg/m^3")


def miura(folder: Path, size: int = 3) -> Path:
    return fold_corpus.write(folder / "miura.fold", large_corpus.miura(size, size))


def loaded(file: Path, **options: Any) -> Mechanism:
    made = lamc.load(file, card=CARD, crease=1e-3, units="mm", **options)
    assert isinstance(made, Mechanism)
    return made


# 3 x 3 facets have 12 creases and 4 vertices: 24 equations, and 4 rates free where they are flat.
ENOUGH = work.Limits(hinges=12, closing=24, numbers=48)


@pytest.mark.parametrize("limit", ["hinges", "closing", "numbers"])
def test_loops_of_too_much_work_are_refused_with_their_numbers(limit: str, tmp_path: Path) -> None:
    sheet = loaded(miura(tmp_path))
    less = ENOUGH._replace(**{limit: getattr(ENOUGH, limit) - 1})
    with pytest.raises(DesignError, match=r"12 hinges.* 24 closing equations, and 4 rates.*--large"):
        work.check_work(sheet, less)
    work.check_work(sheet, less, large=True)


def test_limits_are_passed_by_one_more_only(tmp_path: Path) -> None:
    work.check_work(loaded(miura(tmp_path)), ENOUGH)


@needs_cc
def test_loops_that_take_long_are_told_and_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sheet = loaded(miura(tmp_path))
    monkeypatch.setattr(work, "SOON", ENOUGH._replace(closing=23))
    with pytest.warns(
        DesignWarning, match="12 hinges, .* with more than 12, 23 and 4 it takes minutes until"
    ):
        assert lamc.compile(sheet).cut_joints


def test_a_chain_has_no_closing_equations_and_any_number_of_hinges(tmp_path: Path) -> None:
    work.check_work(loaded(hostile_corpus.strip(tmp_path, 12)), ENOUGH._replace(hinges=8))


@pytest.mark.filterwarnings("ignore::lamc.basics.errors.DesignWarning")
@pytest.mark.parametrize("kind", ["fold", "svg"])
def test_a_sheet_of_too_many_facets_is_refused_unless_it_is_meant(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = miura(tmp_path) if kind == "fold" else hostile_corpus.crossed_grid(tmp_path, 2)
    monkeypatch.setattr(fold_faces, "MOST_FACETS", 8)
    with pytest.raises(DesignError, match=rf"{file.name}.*9 facets; of more than 8 .*--large"):
        loaded(file)
    assert len(loaded(file, large=True).bodies) == 9


def test_a_sheet_of_too_many_edges_is_refused_before_facets_are_looked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fold_faces, "MOST_FACETS", 7)
    with pytest.raises(DesignError, match="24 edges; of more than 21 "):
        loaded(miura(tmp_path))


def test_the_option_says_that_it_is_meant(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], unpainted: None
) -> None:
    """`split` writes what it has and leaves the loops uncounted."""
    monkeypatch.setattr(work, "MOST", ENOUGH._replace(hinges=11))
    monkeypatch.setattr("lamc.commands.split.SOON", ENOUGH._replace(hinges=11))
    with pytest.raises(DesignError, match="12 hinges"):
        lamc.compile(loaded(miura(tmp_path)))
    assert Source(sheet=SheetOptions(large=True)).options.large
    words = ["split", str(miura(tmp_path)), "--out", str(tmp_path / "out")]
    assert main.main(words, standalone_mode=False) == 0
    assert "the loops were not counted: the mechanism has 12 hinges" in capsys.readouterr().out
    assert main.main([*words, "--large"], standalone_mode=False) == 0
    assert "not counted" not in capsys.readouterr().out


@pytest.mark.slow
@needs_cc
def test_a_large_model_is_compiled_with_less_and_keeps_its_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sheet, flags = loaded(miura(tmp_path)), list[list[str]]()
    make = build.make_library

    def made(compiler: Any, given: Any, *others: Any) -> None:
        flags.append([flag for flag in given if flag.startswith("-O")])
        make(compiler, given, *others)

    monkeypatch.setattr(build, "make_library", made)
    udot = []
    for limit in (10**9, 10):
        monkeypatch.setattr(build, "LARGE", limit)
        monkeypatch.setenv("LAMC_CACHE_DIR", str(tmp_path / str(limit)))
        simulator = lamc.compile(sheet)
        q, u = np.split(simulator.start, 2)
        udot.append(simulator.acceleration(q, u))
    assert flags == [["-O2"], ["-O1"]]
    assert np.array_equal(udot[0], udot[1])


@pytest.mark.parametrize(("most", "found"), [(10**9, 12), (7, 8)])
def test_crossings_are_found_some_at_a_time(most: int, found: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """3 lines across 4: each of the one with each of the other; with a limit, no more than the query that passes it."""
    monkeypatch.setattr(fold_faces, "AT_ONCE", 14)  # two lines at a time
    level = [[(0.0, y), (5.0, y)] for y in (1.0, 2.0, 3.0)]
    upright = [[(x, 0.0), (x, 5.0)] for x in (1.0, 2.0, 3.0, 4.0)]
    first, second = fold_faces.crossing_pairs(shapely.linestrings([*level, *upright]), most)
    every = [(a, b) for a in range(3) for b in range(3, 7)]
    assert sorted(zip(first.tolist(), second.tolist(), strict=True)) == every[:found]

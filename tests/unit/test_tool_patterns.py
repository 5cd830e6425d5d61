"""Crease patterns with the habits of particular tools: each is the sheet that is meant, or is told why it is none."""

import json
import warnings
from pathlib import Path

import pytest

import lamc
from lamc.basics.errors import DesignError, DesignWarning
from lamc.records.mechanism import Mechanism
from tests.support.ctools import needs_cc
from tests.support.tool_corpus import FILES, nothing_folds, own_corners, three_at_an_edge


def loaded(folder: Path, file: tuple[str, bytes]) -> tuple[Mechanism, list[str]]:
    name, content = file
    (folder / name).write_bytes(content)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", DesignWarning)
        sheet = lamc.load(folder / name)
    assert isinstance(sheet, Mechanism)
    return sheet, [str(each.message) for each in told]


@pytest.mark.parametrize("name", FILES)
def test_a_pattern_has_the_facets_and_creases_that_are_drawn(name: str, tmp_path: Path) -> None:
    make, bodies, hinges = FILES[name]
    sheet, _ = loaded(tmp_path, make())
    assert (len(sheet.bodies), len(sheet.joints)) == (bodies, hinges)
    assert sum(body.fixed for body in sheet.bodies) == 1


@needs_cc
@pytest.mark.parametrize("name", ["own corners", "folded mesh", "simulator"])
@pytest.mark.quick("own corners", "folded mesh")
def test_such_a_pattern_runs(name: str, tmp_path: Path) -> None:
    sheet, _ = loaded(tmp_path, FILES[name][0]())
    result = lamc.compile(sheet).run(1e-3, rtol=1e-6, max_steps=3000)
    assert result.success, result.message


def test_facets_with_corners_of_their_own_are_joined_and_that_is_told(tmp_path: Path) -> None:
    _, told = loaded(tmp_path, own_corners())
    assert any("17 in all) lie where others do" in note for note in told)


def test_rims_side_by_side_are_not_joined(tmp_path: Path) -> None:
    """Two strips with a slit between them, whose lips are drawn at one place."""
    points = [[x, y] for y in (0, 20, 20, 40) for x in (0, 20, 40)]
    rings = [[0, 1, 4, 3], [1, 2, 5, 4], [6, 7, 10, 9], [7, 8, 11, 10]]
    edges = [[a, b] for ring in rings for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)]
    edges = [list(pair) for pair in dict.fromkeys((min(e), max(e)) for e in edges)]
    kinds = ["M" if pair in ([1, 4], [7, 10]) else "B" for pair in edges]
    data = {
        "vertices_coords": points,
        "edges_vertices": edges,
        "edges_assignment": kinds,
        "faces_vertices": rings,
    }
    sheet, told = loaded(tmp_path, ("slit.fold", json.dumps(data).encode()))
    assert len(sheet.joints) == 2
    assert not any("lie where others do" in note for note in told)
    assert any("falls into 2 pieces" in note for note in told)


def test_a_sheet_that_nothing_folds_is_told_and_bends_where_it_may(tmp_path: Path) -> None:
    sheet, told = loaded(tmp_path, nothing_folds())
    assert not sheet.joints
    (note,) = [note for note in told if "nothing folds" in note]
    assert "(12 in all) flat (F)" in note
    assert "--facets bend" in note
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DesignWarning)
        assert lamc.load(tmp_path / "sheet.fold", facets="bend").joints  # type: ignore[union-attr]


def test_three_facets_at_an_edge_are_refused_with_their_place(tmp_path: Path) -> None:
    with pytest.raises(
        DesignError, match=r"the edge from vertex 1 to 4 has 3 faces, 0, 1, 2: an edge joins two"
    ):
        loaded(tmp_path, three_at_an_edge())

"""Flaps outside all loops turn by themselves: the ways out of the flat position are those of the sheet without them."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.loops.branches import find_branches
from lamc.loops.geometry import LoopGeometry
from lamc.loops.rank import count_loops
from lamc.loops.surveys import Survey
from lamc.loops.tangents import MOST_FREE
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism
from tests.support import fold_corpus

pytestmark = pytest.mark.filterwarnings("ignore::lamc.DesignWarning")


def sheet(folder: Path, data: fold_corpus.Data) -> Mechanism:
    made = lamc.load(
        fold_corpus.write(folder / "sheet.fold", data), card=lamc.Card(), crease=1e-3, facets="rigid"
    )
    assert isinstance(made, Mechanism)
    return made


@pytest.mark.quick("3-5", "3-1", others="campaign")
@pytest.mark.parametrize(
    ("side", "every"), [(3, 1), (3, 5), (5, 1), (7, 4), (7, 1)]
)  # of few joints and many, of few free rates and many
def test_flaps_add_their_freedoms_and_nothing_else(tmp_path: Path, side: int, every: int) -> None:
    """Newton's method led to flaps alone, beside which all forms fade: 7 x 7 facets with 28 flaps had rank 84."""
    data, flaps = fold_corpus.with_flaps(fold_corpus.miura(side, side), every)
    plain = count_loops(plan(sheet(tmp_path, fold_corpus.miura(side, side))))
    flapped = sheet(tmp_path, data)
    found = count_loops(plan(flapped))
    assert (found.rank, found.freedoms) == (plain.rank, plain.freedoms + flaps)
    assert min(found.branch_ranks) >= min(plain.branch_ranks)
    # No way is one of flaps alone: on each of them something else folds.
    geometry = LoopGeometry(plan(flapped))
    inner = np.array(
        [any(joint in cycle.joints for cycle in geometry.cycles) for joint in range(len(geometry.names))]
    )
    assert np.count_nonzero(~inner) == flaps
    for branch in find_branches(geometry, np.zeros(len(geometry.names))):
        assert np.abs(branch.row(geometry.names)[inner]).max() == pytest.approx(1.0)


@pytest.mark.quick("3-12", others="campaign")
@pytest.mark.parametrize(("side", "every"), [(3, 12), (3, 1), (7, 7), (7, 1)])
def test_a_rounded_sheet_with_flaps_folds_as_the_exact_one_does(
    tmp_path: Path, side: int, every: int
) -> None:
    """Rounding leaves no exact way but that of the flaps, which was taken for all: 3 x 3 facets had rank 8, not 11."""
    data, flaps = fold_corpus.with_flaps(fold_corpus.miura(side, side), every)
    exact = count_loops(plan(sheet(tmp_path, data)))
    turn = np.array([[np.cos(0.6), np.sin(0.6)], [-np.sin(0.6), np.cos(0.6)]])
    corners = np.array(data["vertices_coords"], dtype=float) @ turn  # so that they are no round numbers
    assert flaps
    for decimals in (6, 4):
        rounded = count_loops(
            plan(sheet(tmp_path, data | {"vertices_coords": np.round(corners, decimals).tolist()}))
        )
        assert rounded.misfit is not None
        assert rounded.accepted_gap > 0.0
        assert (rounded.rank, rounded.freedoms) == (exact.rank, exact.freedoms)


@pytest.mark.parametrize(
    ("is_singular", "told"),
    [
        (True, "none of the ways that were tried goes on.*--facets bend"),
        (False, "no branches are looked for"),
    ],
)
def test_a_sheet_of_many_free_rates_without_a_way_is_refused_with_one_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_singular: bool, told: str
) -> None:
    """As a pattern of hundreds of slits that rounding holds: it had been run as if its six flaps were all of it."""
    made = plan(sheet(tmp_path, fold_corpus.miura(4, 4)))
    nothing = Survey([], is_singular, MOST_FREE + 1)
    monkeypatch.setattr("lamc.loops.rank.survey", lambda *given: nothing)
    with pytest.raises(lamc.DesignError, match=told):
        count_loops(made)

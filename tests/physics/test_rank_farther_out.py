"""Ranks of large sheets of few digits, which near flat look as if some equations of theirs were a misfit."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.loops.branches import find_branches
from lamc.loops.geometry import geometry_of
from lamc.loops.linear import DENSE
from lamc.loops.rank import count_loops
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism
from tests.support import fold_corpus

SIDE = 8  # facets; of fewer hinges than DENSE the misfit is measured over half a turn anyway
TURN = math.radians(33.0)
DECIMALS = 3  # of a millimetre, on a sheet of 300: six digits


def sheet(folder: Path, *, decimals: int | None) -> Mechanism:
    """A Miura sheet, turned in its plane so that its corners are no round numbers, rounded or not."""
    data = json.loads(json.dumps(fold_corpus.miura(SIDE, SIDE)))
    c, s = math.cos(TURN), math.sin(TURN)
    corners = np.array(data["vertices_coords"], dtype=float) @ np.array([[c, s], [-s, c]])
    data["vertices_coords"] = (corners if decimals is None else np.round(corners, decimals)).tolist()
    made = lamc.load(
        fold_corpus.write(folder / "sheet.fold", data), card=lamc.Card(), crease=1e-3, facets="rigid"
    )
    assert isinstance(made, Mechanism)
    return made


@pytest.mark.slow
def test_a_sheet_of_six_digits_has_the_rank_of_the_exact_one(tmp_path: Path) -> None:
    """By the first steps it had two freedoms: one is of the second order there, and tears farther out. No way has more
    freedoms than the exact drawing's ways have."""
    exact, rounded = (count_loops(plan(sheet(tmp_path, decimals=d))) for d in (None, DECIMALS))
    assert exact.misfit is None
    assert rounded.misfit is not None
    assert rounded.accepted_gap > 0.0
    assert len(sheet(tmp_path, decimals=None).joints) > DENSE
    assert (rounded.rank, rounded.freedoms) == (exact.rank, exact.freedoms) == (111, 1)
    # The misfit is of the drawing's rounding, half a micrometre at each corner, which some dozen add up to.
    assert rounded.misfit.gap < 1e-5
    geometry = geometry_of(plan(sheet(tmp_path, decimals=DECIMALS)))
    ways = find_branches(geometry, np.zeros(len(geometry.names)), rounded.fit)
    assert len(rounded.branch_ranks) == len(ways)
    assert min(rounded.branch_ranks) >= min(exact.branch_ranks)

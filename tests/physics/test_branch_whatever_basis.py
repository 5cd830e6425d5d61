"""The branch of a large sheet is the same, whichever basis there is of the rates that are free in its flat position.

A decomposition gives one or another, by its round-off or by what iteration begins from. Physics knows of none.
"""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.loops import geometry, linear
from lamc.loops.branches import find_branches
from lamc.loops.geometry import LoopGeometry
from lamc.loops.linear import DENSE
from lamc.loops.rank import count_at
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Array, Mechanism
from tests.support import fold_corpus, large_corpus


def branch(loops: LoopGeometry) -> tuple[int, Array]:
    """The rank and the first branch, where loads ask all creases to fold, one more than the other."""
    flat = np.zeros(len(loops.names))
    rank = count_at(loops, flat).rank
    asked = np.random.default_rng(3).normal(size=len(flat))
    found = find_branches(loops, flat, lead=lambda angles: asked, rank=rank)
    return rank, found[0].row(loops.names)


@pytest.mark.parametrize("columns", [4, 5])
def test_another_basis_gives_the_same_branch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    path = fold_corpus.write(tmp_path / "sheet.fold", large_corpus.waterbomb(columns, 4))
    made = lamc.load(path, card=lamc.Card(), crease=1e-3, facets="rigid")
    assert isinstance(made, Mechanism)
    assert len(made.joints) > DENSE
    found = []
    for seed in (linear.SEED, 1, 2):
        monkeypatch.setattr(linear, "SEED", seed)
        monkeypatch.setattr(geometry, "_lately", {})  # nothing is known from the last time
        found.append(branch(LoopGeometry(plan(made))))
    for rank, rates in found[1:]:
        assert rank == found[0][0]
        # Round-off of the basis, 1e-10, which some dozen rounds of Newton's method and of an ascent add to
        assert rates == pytest.approx(found[0][1], abs=1e-6)

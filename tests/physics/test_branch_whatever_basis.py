"""The branch of a large sheet is the same, whichever basis there is of the rates that are free in its flat position.

A decomposition gives one or another, by its round-off or by what iteration begins from. Physics knows of none.
"""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.loops import branches as branches_module
from lamc.loops import geometry, linear
from lamc.loops.branches import Lead, clear_of, find_branches, moved_out
from lamc.loops.geometry import LoopGeometry
from lamc.loops.linear import DENSE, EXACT, Linear
from lamc.loops.rank import count_at
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Array, Mechanism
from tests.support import fold_corpus, large_corpus


def branch(loops: LoopGeometry) -> tuple[int, Array]:
    """The rank and the first branch, where loads ask all creases to fold, one more than the other."""
    flat = np.zeros(len(loops.names))
    rank = count_at(loops, flat).rank
    asked = np.random.default_rng(3).normal(size=len(flat))
    found = find_branches(loops, flat, lead=Lead(lambda angles: asked), rank=rank)
    return rank, found[0].row(loops.names)


@pytest.mark.slow
@pytest.mark.ci("4")
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


@pytest.mark.quick("4", others="campaign")
@pytest.mark.parametrize("side", [4, 7])
def test_all_branches_are_the_same_in_another_basis(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, side: int
) -> None:
    """Of a Miura sheet of 24 joints, whose basis a dense decomposition gives, and of 84; and so are their numbers."""
    path = fold_corpus.write(tmp_path / "sheet.fold", fold_corpus.miura(side, side))
    made = lamc.load(path, card=lamc.Card(), crease=1e-3, facets="rigid")
    assert isinstance(made, Mechanism)
    assert len(made.joints) == 2 * side * (side - 1)
    free = Linear.free
    found = []
    for seed in (None, 1, 2):
        monkeypatch.setattr(geometry, "_lately", {})

        def turned(self: Linear, cutoff: float = EXACT, seed: int | None = seed) -> Array:
            rows = free(self, cutoff)
            if seed is None:
                return rows
            random = np.random.default_rng(seed).normal(size=(len(rows), len(rows)))
            return np.asarray(np.linalg.qr(random)[0] @ rows)

        monkeypatch.setattr(Linear, "free", turned)
        loops = LoopGeometry(plan(made))
        branches = find_branches(loops, np.zeros(len(loops.names)))
        found.append([each.row(loops.names) for each in branches])
    assert len(found[0]) > 5
    for others in found[1:]:
        assert len(others) == len(found[0])
        for one, other in zip(found[0], others, strict=True):
            # Newton's method leaves some units of round-off of each basis; double zeros have half the digits.
            assert other == pytest.approx(one, abs=1e-6)


def test_a_place_clear_of_a_singular_position_is_known_by_where_it_was_asked_from(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And what comes out is the caller's own, whatever becomes of what was given."""
    path = fold_corpus.write(tmp_path / "sheet.fold", fold_corpus.hypar(6))
    made = lamc.load(path, card=lamc.Card(), crease=1e-3, facets="rigid")
    assert isinstance(made, Mechanism)
    loops = LoopGeometry(plan(made))
    flat = np.zeros(len(loops.names))
    ways = [each.row(loops.names) for each in find_branches(loops, flat)[:2]]
    places = [moved_out(loops, flat, way) for way in ways]
    monkeypatch.setattr(branches_module, "FAINT", 1.0)
    clear = []
    for place in places:
        assert place is not None
        clear.append(clear_of(loops, flat, place))
    assert np.abs(clear[0] - clear[1]).max() > 1e-3
    for faint in (1.0, 1e-9):  # gone on from, and clear at once
        monkeypatch.setattr(branches_module, "FAINT", faint)
        monkeypatch.setattr(geometry, "_lately", {})
        given = places[0].copy()  # type: ignore[union-attr]
        first = clear_of(loops, flat, given)
        given[:], known = 7.0, first.copy()
        first[:] = 7.0
        assert clear_of(loops, flat, places[0]) == pytest.approx(known, abs=0.0)  # type: ignore[arg-type]

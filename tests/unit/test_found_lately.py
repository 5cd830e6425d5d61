"""What was found of loops is known of others that are drawn alike, and is not looked for again."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.loops import branches, closing
from lamc.loops.geometry import LATELY, MOST_FOUND, LoopGeometry, geometry_of
from lamc.loops.linear import DENSE, Linear
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism
from tests.support import fold_corpus
from tests.support.ctools import needs_cc


def miura(folder: Path, columns: int = 3, rows: int = 3, **options: Any) -> Mechanism:
    path = fold_corpus.write(folder / "sheet.fold", fold_corpus.miura(columns, rows))
    made = lamc.load(path, card=options.pop("card", lamc.Card()), crease=1e-3, **options)
    assert isinstance(made, Mechanism)
    return made


def test_loops_drawn_alike_share_it_whatever_their_bodies_weigh(tmp_path: Path) -> None:
    light, heavy = miura(tmp_path), miura(tmp_path, card=lamc.Card(density="900 kg/m^3"))
    other = miura(tmp_path, 4, 3)
    first, second, third = (geometry_of(plan(mechanism)) for mechanism in (light, heavy, other))
    asked: list[str] = []

    def answer(name: str) -> Any:
        return lambda: (asked.append(name), name)[1]

    assert first.lately("question", answer("light")) == "light"
    assert second.lately("question", answer("heavy")) == "light"
    assert third.lately("question", answer("other")) == "other"
    assert asked == ["light", "other"]
    assert first.lately("another", answer("second")) == "second"


def test_only_so_much_is_kept(tmp_path: Path) -> None:
    geometry = geometry_of(plan(miura(tmp_path, 2, 3)))
    for number in range(MOST_FOUND + 1):
        assert geometry.lately(("kept", number), lambda: 1) == 1
    assert geometry.lately(("kept", 0), lambda: 2) == 2  # forgotten
    assert geometry.lately(("kept", MOST_FOUND), lambda: 2) == 1
    for columns in range(2, 2 + LATELY):
        geometry_of(plan(miura(tmp_path, columns, 4))).lately("one", lambda: 1)
    assert geometry.lately(("kept", MOST_FOUND), lambda: 3) == 3


@needs_cc
def test_branches_are_looked_for_once_from_file_to_start(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reading asks whether the sheet folds, compiling what its loops come to, starting where they lead."""
    calls: list[bytes] = []
    usual = branches.spherical

    def counted(tangents: Any, *given: Any) -> Any:
        calls.append(tangents.basis.tobytes())
        return usual(tangents, *given)

    monkeypatch.setattr(branches, "spherical", counted)
    sim = lamc.compile(miura(tmp_path, 3, 5))
    assert sim.branches
    assert sim.start.any()
    assert len(calls) == 1


def test_what_creeps_is_left_where_it_is_close_enough() -> None:
    """Of large matrices directions of 1e-6 of the strongest are damped, so that a residual along them halves in a
    hundred steps. A place that is as good as it has to be is not brought closer; one that is not is left open after
    three steps that bring next to nothing, as sixty would not close it."""
    count = DENSE + 4
    sizes = np.append(np.ones(count - 1), 1e-6)
    goal = np.append(np.zeros(count - 1), 5e-10)
    asked = 0

    class Creeping:
        def closure(self, angles: Any) -> Any:
            nonlocal asked
            asked += 1
            from scipy import sparse

            return sizes * angles - goal, Linear(sparse.diags_array(sizes).tocsr())

    creeping: LoopGeometry = Creeping()  # type: ignore[assignment]
    for enough, steps in ((1e-9, 1), (closing.CLOSED, closing.CREEPS)):
        asked = 0
        _, error = closing.settle(creeping, np.zeros(count), cutoff=5e-7, enough=enough)
        assert closing.CLOSED < error <= 5e-10
        assert asked == 1 + steps

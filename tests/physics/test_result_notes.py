"""What a result of loops says of itself: steps near singular positions are counted and told."""

import dataclasses
import json
import types
from pathlib import Path
from typing import Any

import numpy as np

import lamc
from lamc import examples
from lamc.loops.branches import find_branches
from lamc.loops.geometry import LoopGeometry
from lamc.loops.linear import DENSE, EXACT
from lamc.loops.walks import walk
from lamc.mechanism.plan import plan
from lamc.run import doubts
from lamc.run.doubts import notes
from tests.physics.test_loops import simulator
from tests.support import fold_corpus, large_corpus


def test_equations_let_go_near_a_singular_position_are_reported(shared: Path) -> None:
    """A passage lets none go: accelerations there are those of places around."""
    cases: dict[str, Any] = {
        c["id"]: c for c in json.loads((shared / "reference" / "dynamics.json").read_text())["cases"]
    }
    sim = simulator(cases["nfourbar2"])
    passing = sim.run(t_end=10.0, max_step=1e-3)
    assert passing.stats.singular_steps == 0
    assert not any("equations of the loops fade" in note for note in passing.notes)
    counted = dataclasses.replace(passing, stats=dataclasses.replace(passing.stats, singular_steps=3))
    assert any("3 of" in note and "equations of the loops fade" in note for note in notes(counted))


def test_a_tree_has_no_notes() -> None:
    sim = lamc.compile(lamc.load(examples.path("pendulum.cad")))
    assert sim.run(t_end=0.1).notes == ()


def test_a_run_that_leaves_the_motion_whose_rank_it_took_says_so() -> None:
    """A vertex of four creases has three equations; the result is told that the run took two, as if it had begun along
    a line."""
    sim = lamc.compile(lamc.load(examples.path("vertex")))
    result = sim.run(t_end=0.1)
    assert result.notes == ()
    model = types.SimpleNamespace(**{**vars(result.motion.model), "rank": 2})
    motion = types.SimpleNamespace(model=model, closures=result.motion.closures, gap=result.motion.gap)
    (note,) = notes(dataclasses.replace(result, motion=motion))  # type: ignore[arg-type]
    assert "3 independent equations at some of the 5 rows" in note
    assert "run took 2, as at its start" in note


def test_the_rank_of_a_large_closure_is_told_as_a_dense_decomposition_tells_it(tmp_path: Path) -> None:
    """Of more than 60 hinges without a decomposition of all; flat, a little folded, and folded."""
    path = fold_corpus.write(tmp_path / "sheet.fold", large_corpus.waterbomb(3, 3))
    made = lamc.load(path, card=lamc.Card(), crease=1e-3, facets="rigid")
    assert isinstance(made, lamc.Mechanism)
    loops = LoopGeometry(plan(made))
    flat = np.zeros(len(loops.names))
    assert len(flat) > DENSE
    way = find_branches(loops, flat)[0].row(loops.names)
    places = [flat, *(place.angles for place in walk(loops, flat, way, EXACT, 3))]
    assert len(places) == 4
    for place in places:
        jacobian = loops.closure(place)[1].matrix.toarray()
        values = np.linalg.svd(jacobian, compute_uv=False)
        found = doubts._taken_apart(jacobian)
        assert found.rank(doubts._INDEPENDENT) == np.count_nonzero(values > doubts._INDEPENDENT * values[0])

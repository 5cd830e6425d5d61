"""What a result of loops says of itself: steps near singular positions are counted and told."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import lamc
from lamc import examples
from lamc.run.doubts import notes
from tests.physics.test_loops import simulator


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

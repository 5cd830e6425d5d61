"""What a result of loops says of itself: steps near singular positions are counted and told."""

import json
from pathlib import Path
from typing import Any

import lamc
from lamc import examples
from tests.physics.test_loops import simulator


def test_equations_let_go_near_a_singular_position_are_reported(shared: Path) -> None:
    cases: dict[str, Any] = {
        c["id"]: c for c in json.loads((shared / "reference" / "dynamics.json").read_text())["cases"]
    }
    sim = simulator(cases["nfourbar2"])
    passing = sim.run(t_end=10.0, max_step=1e-3)
    assert passing.stats.singular_steps > 0
    assert any("equations of the loops fade" in note for note in passing.notes)
    calm = sim.run(t_end=1e-3)
    assert calm.stats.singular_steps == 0
    assert not any("equations of the loops fade" in note for note in calm.notes)


def test_a_tree_has_no_notes() -> None:
    sim = lamc.compile(lamc.load(examples.path("pendulum.cad")))
    assert sim.run(t_end=0.1).notes == ()

"""The staged equations as sympy objects give the accelerations of the C, with loops too; and `bench` measures both."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.codegen.options import CompileOptions
from lamc.ledger.bench import lambdified, measure
from lamc.reference.staged import StagedValues
from lamc.report.bench import bench_table
from tests.support.closed_mechanisms import closed_mechanism
from tests.support.ctools import needs_cc
from tests.support.mechanisms import ALL_PASSIVE, chain, from_reference

pytestmark = needs_cc


@pytest.mark.parametrize(
    "mechanism",
    [
        chain(3, "space", seed=4),
        closed_mechanism("bennett", 3).mechanism,
        closed_mechanism("several", 2).mechanism,
    ],
    ids=lambda m: m.name,
)
@pytest.mark.quick("chain3", others="campaign")
def test_staged_equations_give_the_accelerations_of_the_c(mechanism: lamc.Mechanism) -> None:
    sim = lamc.compile(mechanism, lamc.Scene(effects=ALL_PASSIVE))
    start = sim.run(0.1, rtol=1e-10, atol=1e-12, t_eval=[0.1])  # away from where it is drawn, and closed
    q, u = start.q[0], start.u[0]
    values = StagedValues(sim.equations)
    parameters = [p.default for p in sim.equations.parameters]
    found = values.acceleration(np.array(lambdified(sim.equations)(0.1, q, u, parameters), dtype=float))
    expected = sim.acceleration(q, u, 0.1)
    # round-off of some 1e3 operations, times the square of the closure's condition, here below 10
    assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()


@pytest.mark.slow
def test_bench_measures_loops_and_names_the_peer_that_cannot(shared: Path) -> None:
    cases: list[Any] = json.loads((shared / "reference" / "dynamics.json").read_text(encoding="utf-8"))[
        "cases"
    ]
    mechanism, scene = from_reference(next(c for c in cases if c["id"] == "vertex4_flatfoldable")["spec"])
    bench = measure(mechanism, scene, CompileOptions(), lambda _: None)
    assert [row.name for row in bench.rows][-2:] == ["interpreter", "generated C"]
    assert all(row.evaluation > 3 * bench.rows[-1].evaluation for row in bench.rows[:-1])
    assert [row.extrapolated for row in bench.rows] == [True, True, True, False]
    assert "KanesMethod" in bench_table(bench)

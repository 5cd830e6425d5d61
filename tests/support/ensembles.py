"""What tests of ensembles have in common: instances beside runs by themselves, and values that differ."""

from typing import Any

import numpy as np

from lamc.run.simulator import Simulator


def assert_alike(sim: Simulator, many: Any, parameters: dict[str, Any], **how: Any) -> None:
    """Every instance is `Simulator.run` with its parameters: rows, end, steps and events, without a tolerance."""
    for k in range(len(many)):
        values = {name: float(v[k]) for name, v in parameters.items()}
        one = sim.run(parameters=values, t_eval=many.t, **how)
        assert int(many.status[k]) == int(one.status), k
        rows = len(one.t) if one.success else int(np.isfinite(many.q[k]).all(axis=1).sum())
        assert np.isnan(many.q[k, rows:]).all()
        assert many.q[k, :rows].tobytes() == one.q[:rows].tobytes(), k
        assert many.u[k, :rows].tobytes() == one.u[:rows].tobytes(), k
        assert (many.stats.evaluations[k], many.stats.accepted[k], many.stats.rejected[k]) == (
            one.stats.evaluations,
            one.stats.accepted,
            one.stats.rejected,
        )
        assert many.stats.events[k] == len(one.events)
        assert many.stats.integrators[k] == one.stats.integrator.split(", ")[-1]


def assert_beside(many: Any) -> None:
    """Instances of loops ran side by side, where the machine has vectors of four numbers or eight."""
    assert many.stats.lanes in (4, 8) or "too few for loops" in many.stats.why_alone


def spread(sim: Simulator, count: int, seed: int) -> dict[str, Any]:
    """Values of all parameters around their defaults, zeros as they are."""
    rng = np.random.default_rng(seed)
    return {
        name: value * rng.uniform(0.9, 1.1, count)
        for name, value in sim.parameters.items()
        if not name.endswith(("restitution", "_limit"))
    }

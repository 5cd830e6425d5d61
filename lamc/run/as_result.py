"""Positions that no run came through, as a `Result`: for what is known of results, such as quantities and pictures.

In: a simulator, a motion, rows of states at times. Out: a `Result` whose message says what it is of.
"""

from typing import TYPE_CHECKING

import numpy as np

from lamc.run.model import Motion
from lamc.run.request import Array, Status
from lamc.run.result import Result
from lamc.run.run_record import RunStats

if TYPE_CHECKING:
    from lamc.run.simulator import Simulator


def as_result(simulator: "Simulator", motion: Motion, t: Array, rows: Array, message: str) -> Result:
    """t (m,), s; rows (m, nq + nu)."""
    provenance, marks = simulator._circumstances(motion)
    nq = len(motion.model.coordinates)
    stats = RunStats(
        integrator="none",
        rtol=0.0,
        atol=0.0,
        steps=0,
        accepted=0,
        rejected=None,
        evaluations=0,
        last_step=0.0,
        wall_time=0.0,
        real_time_factor=0.0,
    )
    return Result(
        t=np.array(t, dtype=float),
        q=rows[:, :nq].copy(),
        u=rows[:, nq:].copy(),
        status=Status.REACHED_END,
        message=message,
        stats=stats,
        provenance=provenance,
        mechanism=simulator.mechanism,
        motion=motion,
        marks=marks,
        outputs=tuple(simulator.scene.outputs or ()),
    )

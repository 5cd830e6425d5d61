"""Starts of mechanisms in which a bushing holds one cut hinge, and equations another."""

from collections.abc import Mapping
from dataclasses import replace
from importlib.resources import as_file, files

import numpy as np
import pytest

import lamc
from lamc import Scene, TwistCompliance
from lamc.mechanism.plan import plan
from tests.support.ctools import needs_cc

pytestmark = needs_cc


def two_loops(angle: float, others: Mapping[str, float]) -> tuple[lamc.Simulator, str]:
    """With one of its two cut hinges compliant, which starts at `angle` (rad); and the name of that hinge."""
    with as_file(files("lamc.examples") / "two_loops.yaml") as path:
        mechanism = replace(lamc.split(lamc.load(path)), scene=None)
    held = plan(mechanism).cuts[0].joint.name
    film = TwistCompliance((held,), length=14e-3, width=2e-3, thickness=25e-6, E=2.5e9, nu=0.34)
    return lamc.compile(mechanism, Scene(effects=(film,), angles={**others, held: angle})), held


def test_an_angle_of_the_hinge_that_a_bushing_holds_is_had() -> None:
    sim, held = two_loops(0.2, {})
    assert len(sim.cut_joints) == 1  # the other one
    result = sim.run(t_end=0.0, t_eval=[0.0])
    assert result.angle(held)[0] == pytest.approx(0.2, abs=1e-9)  # rad: both loops close there, rigid or not
    assert np.abs(sim.closure(sim.start[: len(sim.coordinates)])[0]).max() <= 1e-11


def test_one_that_rigid_loops_cannot_have_is_refused() -> None:
    with pytest.raises(lamc.DesignError, match="no position closes the loops with the angles given"):
        two_loops(1.0, {"arm_1": 0.5, "arm_1_step": 0.5})

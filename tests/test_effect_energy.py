"""Which effects keep the energy of a run: what they say of themselves is what runs show."""

import numpy as np
import pytest

import lamc
from lamc.effects.base import Effect, conserves
from lamc.scene import Scene
from tests.ctools import needs_cc
from tests.every_effect import SAMPLES, mechanism

pytestmark = needs_cc

CASES: dict[str, Effect] = dict(SAMPLES) | {
    "elastic stops": lamc.JointLimits(stiffness=30.0),
    "elastic impacts": lamc.JointLimits(restitution=1.0),
    "dull impacts": lamc.JointLimits(restitution=0.5),
    "stops of a scene that says nothing": lamc.JointLimits(),
    "undamped spring": lamc.Spring("ground", (0.0, 0.0, 0.5), "b", (2.0, 0.0, 0.0), 4.0, 0.3),
    "bender under a constant voltage": lamc.PiezoBender(
        "a",
        (0.1, 0.0, 0.0),
        "b",
        (1.2, 0.0, 0.0),
        (0, 0, 1),
        1.0,
        SAMPLES["piezo_bender"].laminate,
        (1, -1),
        9.0,  # type: ignore[attr-defined]
    ),
}


@pytest.mark.parametrize("case", sorted(CASES))
def test_effects_that_say_so_keep_the_energy_and_the_others_do_not(case: str) -> None:
    effect = CASES[case]
    scene = Scene(effects=(effect,), angles={"h1": 0.9, "h2": -0.8}, rates={"h1": 2.0, "h2": -1.5})
    result = lamc.compile(mechanism(), scene).run(t_end=1.5, rtol=1e-10, atol=1e-12)
    change = float(np.abs(result.energy - result.energy[0]).max() / result.energies["kinetic"].max())
    if conserves(effect, result.energies):
        assert change < 1e-7  # rtol times some hundred steps, of the energy that there is
    else:
        assert change > 1e-5  # a hundred times what integration leaves

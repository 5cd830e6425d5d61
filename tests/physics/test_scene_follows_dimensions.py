"""A scene of the design changes with its dimensions: by its name, itself, or as the default."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lamc
from lamc.readers.load import load_text
from lamc.records.design import Design
from lamc.records.scene import own_scene
from tests.support.ctools import needs_cc

pytestmark = needs_cc

FLAP = """
name: flap
units: mm
parameters: {a0: 20 deg}
materials:
  card: {density: 700, E1: 3 GPa, E2: 3 GPa, poisson: 0.3, rigid: true}
  film: {density: 1420, E1: 2.5 GPa, E2: 2.5 GPa, poisson: 0.34, flexible: true}
layers:
  - {name: low, material: card, thickness: 0.5}
  - {name: film, material: film, thickness: 0.05}
shapes: [{rect: [0, 0, 60, 12]}]
hinges: [{name: fold, line: [[10, 0], [10, 12]], layer: film, gap: 1, stiffness: 1e-3, damping: 1e-6}]
fixed: [{rect: [0, 0, 5, 12]}]
scene: {angles: {fold: a0}}
scenes: {twice: {angles: {fold: 2*a0}}, same: {angles: {fold: 20 deg}}}
"""


@pytest.fixture(scope="module")
def flap() -> Design:
    made = load_text(FLAP, "flap.yaml")
    assert isinstance(made, Design)
    return made


def scenes(design: Design) -> list[tuple[Any, float]]:
    """Each with the derivative of the start by a0."""
    again = load_text(FLAP, "flap.yaml")
    return [
        (None, 1.0),
        (design.scene, 1.0),
        ("twice", 2.0),
        (design.scenes["twice"], 2.0),
        (again.scenes["twice"], 2.0),  # of another reading of the file
        (lamc.Scene(angles={"fold": 0.3}), 0.0),
        (design.scenes["same"], 0.0),  # which says as much as the default one, as it is drawn
        (replace(design.scenes["twice"], angles={"fold": 0.3}), 0.0),  # of its places, and another
        ("same", 0.0),
    ]


@pytest.mark.parametrize("k", range(9))
def test_studies_and_derivatives_follow(flap: Design, k: int) -> None:
    """A scene that was given itself kept the numbers of the first drawing, without a word."""
    scene, slope = scenes(flap)[k]
    table = lamc.sweep(flap, vary={"a0": [0.3, 0.4]}, measure="fold[0]", scene=scene, t_end=0.01)
    found = table["fold[0]"].values
    assert found[1] - found[0] == pytest.approx(0.1 * slope, abs=1e-12)
    simulator = lamc.compile(flap, scene)
    run = simulator.run(0.01, t_eval=[0.0, 0.01], sensitivities=["a0"])
    assert run.sensitivity("fold", "a0")[0] == pytest.approx(slope, abs=1e-8)  # differences of starts
    other = simulator.with_design(flap.with_parameters(a0=0.5))
    assert other.start[0] - simulator.start[0] == pytest.approx(slope * (0.5 - np.radians(20.0)), abs=1e-12)


def test_a_scene_made_by_hand_is_none_of_the_design(flap: Design) -> None:
    assert flap.scene is not None
    by_hand = lamc.Scene(angles=dict(flap.scene.angles))
    assert by_hand == flap.scene
    assert own_scene(flap, by_hand) is None
    assert own_scene(flap, flap.scene) == ""
    assert own_scene(flap, flap.scenes["twice"]) == "twice"


def test_a_fit_follows(flap: Design) -> None:
    truth = flap.with_parameters(a0="0.3 rad")
    run = lamc.compile(truth, truth.scenes["twice"]).run(0.2, t_eval=np.linspace(0.0, 0.2, 41))
    recording = lamc.Recording(run.t, {"fold": run.angle("fold")})
    found = lamc.fit(flap, recording, {"a0": (0.1, 0.6)}, flap.scenes["twice"])
    assert found.values["a0"] == pytest.approx(0.3, rel=1e-6)


def test_a_scene_that_there_is_not_is_told_with_what_there_is(flap: Design) -> None:
    with pytest.raises(
        lamc.DesignError, match=r"no scene of the design is named 'twcie'; did you mean 'twice'\?"
    ):
        lamc.compile(flap, "twcie")

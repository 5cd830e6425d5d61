"""Designs, mechanisms and plates on Matplotlib axes."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import lamc
from lamc import plate
from lamc.examples import path as example
from lamc.loops.posed import posed


@pytest.fixture(scope="module")
def four_bar() -> lamc.Design:
    return lamc.load(example("four_bar"))


@pytest.fixture(scope="module")
def solution() -> plate.Solution:
    sheet = plate.Laminate([plate.Ply(plate.Material.isotropic(210e9, 0.3, 7800), 1e-3)])
    held = [plate.Clamped("boundary")]
    problem = plate.Problem(plate.grid(0.1, 0.05, 8, 4), sheet, supports=held, loads=[plate.Pressure(1e3)])
    return plate.solve(problem)


@pytest.mark.parametrize("name", ["four_bar", "pendulum", "sarrus"])
def test_bodies_are_posed_as_a_run_starts(name: str) -> None:
    """By numbers beside the compiled model's, closed loops too."""
    mechanism = lamc.split(lamc.load(example(name)))
    first = mechanism.joints[0].name
    start = lamc.compile(mechanism, lamc.Scene(effects=(lamc.Gravity(),), angles={first: 0.3})).run(0.0)
    centres, rotations = posed(mechanism, {first: 0.3})
    for k, body in enumerate(mechanism.bodies):
        com, rotation = start.pose(body.name)
        assert centres[k] == pytest.approx(
            com[0], abs=1e-9 * mechanism.size
        )  # loops close to 1e-12 of the size
        assert rotations[k] == pytest.approx(rotation[0], abs=1e-9)


def test_a_design_draws_its_layers_and_hinge_lines(four_bar: lamc.Design) -> None:
    axis = Figure().subplots()
    assert four_bar.draw(axes=axis) is axis
    assert {"arm", "link", "arm_shelf", "link_shelf"} <= {text.get_text() for text in axis.texts}


@pytest.mark.parametrize("suffix", [".png", ".pdf"])
def test_a_mechanism_is_drawn_at_angles(four_bar: lamc.Design, tmp_path: Path, suffix: str) -> None:
    mechanism = lamc.split(four_bar)
    drawn = mechanism.draw(path=tmp_path / f"flat{suffix}", size=200)
    folded = mechanism.draw({"arm": 0.9}, path=tmp_path / f"folded{suffix}", camera="front", size=200)
    pictures = [np.asarray(axis.images[0].get_array()) for axis in (drawn, folded)]
    assert pictures[0].shape != pictures[1].shape or (pictures[0] != pictures[1]).any()
    with pytest.raises(lamc.DesignError, match="did you mean 'arm'"):
        mechanism.draw({"armm": 0.9})


@pytest.mark.parametrize("name", ["w", "w_x", "M_x", "M_xy", "stress"])
def test_a_field_of_a_plate_is_drawn_on_axes(solution: plate.Solution, name: str) -> None:
    axis = Figure().subplots()
    assert solution.plot(name, axes=axis) is axis
    assert axis.get_title()


def test_fields_that_there_are_not_are_named(solution: plate.Solution) -> None:
    with pytest.raises(lamc.RequestError, match="did you mean 'M_x'"):
        solution.plot("Mx")
    with pytest.raises(lamc.RequestError, match="no field 'u'"):  # it does not stretch
        solution.plot("u")


def test_a_plate_is_drawn_into_a_file(solution: plate.Solution, tmp_path: Path) -> None:
    solution.plot(path=tmp_path / "w.svg")
    assert (tmp_path / "w.svg").stat().st_size > 5000

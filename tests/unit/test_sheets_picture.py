"""Pictures of devices of several sheets: a panel for each, names beside the drawing."""

from pathlib import Path

import numpy as np
import pytest

import lamc
from lamc.design.split import split_steps
from lamc.examples import path as example
from lamc.report.leaders import _apart
from lamc.report.sheets_picture import sheets_of
from lamc.report.split_picture import draw_split


@pytest.mark.parametrize(("name", "sheets"), [("pendulum", 1), ("four_bar", 2), ("six_bar", 3)])
def test_a_sheet_is_what_hinges_run_through_together(name: str, sheets: int) -> None:
    steps = split_steps(lamc.load(example(name)))
    found = sheets_of(steps)
    assert len(found) == sheets
    assert found == sorted(found)
    for hinge in steps.hinges:
        assert sum(set(hinge.layers) <= set(sheet) for sheet in found) == 1


@pytest.mark.usefixtures("painted")
def test_every_sheet_names_its_bodies_and_hinges_and_every_layer_is_seen(tmp_path: Path) -> None:
    steps = split_steps(lamc.load(example("six_bar")))
    draw_split(steps, tmp_path / "split.svg")
    text = (tmp_path / "split.svg").read_text(encoding="utf-8")
    for name in (*(hinge.name for hinge in steps.hinges), *(layer.name for layer in steps.design.layers)):
        assert f"<!-- {name}" in text or f"<!--  {name}" in text  # Matplotlib tells each text in a comment
    assert text.count("<!-- scoop -->") == 4  # it is in three sheets, and in the legend


@pytest.mark.parametrize("seed", range(5))
def test_names_beside_a_drawing_never_overlap(seed: int) -> None:
    random = np.random.default_rng(seed)
    needed = random.uniform(10.0, 40.0, 12)
    width = 1.1 * float(needed.sum())
    wanted = np.sort(random.uniform(0.0, width, 12))
    places = _apart(wanted, needed, width)
    ends = np.column_stack([places - needed / 2, places + needed / 2])
    assert (ends[1:, 0] >= ends[:-1, 1] - 1e-9).all()  # round-off of sums of a dozen widths
    assert ends.min() >= -1e-9
    assert ends.max() <= width + 1e-9

"""Planes in pictures: where an effect asks for one, a sheet with the shadows of the bodies lies below them."""

import math

import numpy as np
import pytest

import lamc
from lamc import Gravity, GroundContact, Scene
from lamc.records.effect import PlaneMark
from lamc.report.folded import instants
from lamc.report.planes import GRID, SHADOW, SHEET, Sheet
from lamc.report.stage import stage_of
from tests.support.ctools import needs_cc
from tests.support.mechanisms import chain


def pixels(picture: np.ndarray, colour: tuple[int, int, int]) -> int:
    return int((picture == np.array(colour, dtype=np.uint8)).all(axis=2).sum())


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)])
def test_a_sheet_is_as_large_as_what_is_above_it(normal: tuple[float, float, float]) -> None:
    points = np.random.default_rng(3).uniform(-0.2, 0.5, (40, 3))
    sheet = Sheet(PlaneMark((0.1, 0.0, 0.0), normal), points)
    n = np.array(normal)
    # All corners lie 2e-3 of the extent below the plane; the middle of the cells does too
    below = (sheet.corners - [0.1, 0.0, 0.0]) @ n
    assert np.ptp(below) < 1e-12
    assert -2e-3 * 1.3 < below[0] < 0.0
    edges = sheet.corners[[1, 3]] - sheet.corners[0]
    part = (points - sheet.corners[0]) @ edges.T / (edges**2).sum(axis=1)
    assert part.min() > 0.05  # a margin of an eighth of the extent is there on all sides
    assert part.max() < 0.95
    assert np.cross(*edges) @ n > 0.0  # anticlockwise seen from above


@needs_cc
def test_a_picture_shows_the_ground_where_an_effect_has_one() -> None:
    mechanism = chain(2, "laminate", seed=1)
    points = {"body1": [(2.0, 0.0, 0.0)]}
    ground = GroundContact(points=points, height=-3.0)
    bare = lamc.compile(mechanism, Scene((Gravity(),))).run(0.2)
    grounded = lamc.compile(mechanism, Scene((Gravity(), ground))).run(0.2)
    assert bare.marks == ()
    assert grounded.marks == (PlaneMark((0.0, 0.0, -3.0), (0.0, 0.0, 1.0)),)
    without, with_ground = (stage_of(result, result.t[:1], 240).draw(0) for result in (bare, grounded))
    assert pixels(without, SHEET) == pixels(without, SHADOW) == pixels(without, GRID) == 0
    assert pixels(with_ground, SHEET) > 0.1 * with_ground.shape[0] * with_ground.shape[1]


@needs_cc
def test_a_body_without_joints_is_shown_as_it_falls() -> None:
    stone = lamc.Body("stone", 0.1, (0.0, 0.0, 0.0), 1e-4 * np.eye(3), fixed=True)
    sim = lamc.compile(
        lamc.Mechanism((stone,), ()), Scene((Gravity(), lamc.FreeBase(position=(0.0, 0.0, 2.0))))
    )
    rows = instants(sim.run(0.5, t_eval=np.linspace(0.0, 0.5, 51)))
    assert len(rows) == 4
    assert (rows[0], rows[-1]) == (0, 50)


@needs_cc
def test_a_picture_shows_the_ground_where_the_run_had_it() -> None:
    slope = (math.sin(0.3), 0.0, math.cos(0.3))
    ground = GroundContact(points={"body0": [(1.0, 0.0, 0.0)]}, height=-3.0, normal=slope)
    sim = lamc.compile(chain(1), Scene((ground,)))
    (mark,) = sim.run(0.1, parameters={"ground_contact.height": -2.5}).marks
    assert np.array(mark.point) == pytest.approx(-2.5 * np.array(slope), rel=1e-15)

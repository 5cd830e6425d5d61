"""How long loops are brought towards closure: steps that lead nowhere end it."""

from collections.abc import Callable
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from scipy import sparse

import lamc
from lamc.design.split import split
from lamc.examples.miura import miura
from lamc.loops import closing
from lamc.loops.closing import settle
from lamc.loops.geometry import LoopGeometry
from lamc.loops.linear import DENSE, Linear
from lamc.loops.rank import count_loops
from lamc.loops.starts import Starter
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Array

MANY = DENSE + 20
Function = Callable[[Array], Array]


class Loops:
    """Equations as loops have them, each in one angle: residuals by angles, and their slopes."""

    def __init__(self, residual: Function, slope: Function) -> None:
        self.residual, self.slope, self.asked = residual, slope, 0

    def closure(self, angles: Array) -> tuple[Array, Linear]:
        self.asked += 1
        return self.residual(angles), Linear(sparse.diags_array(self.slope(angles)).tocsr())


def settled(loops: Loops, start: Array, **given: float) -> tuple[Array, float, int]:
    """The place, its error and how many steps it took."""
    place, error = settle(cast(LoopGeometry, loops), start, **given)  # type: ignore[arg-type]
    return place, error, loops.asked - 1


def test_regular_loops_close() -> None:
    loops = Loops(np.sin, np.cos)
    place, error, steps = settled(loops, np.linspace(-0.4, 0.4, MANY))
    assert error < closing.CLOSED
    assert np.abs(place).max() < closing.CLOSED
    assert steps < 6


@pytest.mark.parametrize("left", [1e-9, 5e-12])
def test_a_direction_that_is_damped_is_not_crept_along(left: float) -> None:
    """Beside slopes of one, one of 1e-8: a damped step takes a millionth of what is left along it, so that sixty of
    them end where three do."""
    slopes = np.ones(MANY)
    slopes[0] = 1e-8
    loops = Loops(lambda angles: slopes * angles, lambda angles: slopes)
    start = np.zeros(MANY)
    start[0] = left / slopes[0]
    place, error, steps = settled(loops, start)
    assert error == pytest.approx(left, rel=1e-3)
    assert closing.CREEPS <= steps < 2 * closing.CREEPS
    assert np.abs(place - start).max() < 1e-3 * abs(start[0])


def test_a_singular_place_that_each_step_comes_nearer_to_is_arrived_at() -> None:
    """Of a square each step leaves a quarter, down to where it counts as closed: that is no creeping."""

    def residual(angles: Array) -> Array:
        found = angles.copy()
        found[0] = angles[0] ** 2
        return found

    def slope(angles: Array) -> Array:
        found = np.ones(MANY)
        found[0] = 2.0 * angles[0]
        return found

    start = np.zeros(MANY)
    start[0] = 1e-2
    _, error, _ = settled(Loops(residual, slope), start)
    assert error <= closing.CLOSED


def test_a_large_sheet_that_is_hardly_folded_is_found_where_it_is(tmp_path: Path) -> None:
    """Its positions are all but double roots: steps leave 0.9 of what is open, and arrive. Miura's fold has one
    freedom, so that an angle of one crease, rad, is the largest up to the ratio of its creases' angles."""
    path = tmp_path / "miura.yaml"
    path.write_text(miura(7, 7))
    tree = plan(split(lamc.load(path)))
    count = count_loops(tree)
    for name, given in (("z1_0", 4e-5), ("z1_0", 5e-5), ("z1_0", 7e-5), ("s3_3", 2e-5)):
        geometry = LoopGeometry(tree)
        angles = Starter(geometry, count).position({name: given})
        assert np.abs(geometry.closure(angles)[0]).max() <= closing.CLOSED
        assert np.abs(angles).max() < 3.0 * given


def away(angles: Array) -> Array:
    """Newton's method goes to twice as far on the other side, and again."""
    return np.asarray(np.cbrt(angles))


def slope_of_away(angles: Array) -> Array:
    return np.asarray(1.0 / (3.0 * np.maximum(np.abs(np.cbrt(angles)), 1e-6) ** 2))


@pytest.mark.parametrize("nullity", [None, 0])
def test_loops_that_fit_badly_and_come_no_closer_are_left(nullity: int | None) -> None:
    loops = Loops(away, slope_of_away)
    start = np.full(MANY, 1e-2)
    _, error, steps = settled(loops, start, **({"cutoff": 1e-3} if nullity is None else {"nullity": nullity}))
    assert error > away(start).max()
    assert steps == 1 + closing.FRUITLESS  # the first is the shortest so far


def test_who_wants_no_place_far_away_does_not_wait_for_one() -> None:
    start = np.full(MANY, 1e-2)
    _, _, waited = settled(Loops(away, slope_of_away), start)
    _, _, steps = settled(Loops(away, slope_of_away), start, reach=0.05)
    # The first two steps lead 0.03 and 0.03 away, the third beyond.
    assert steps < waited
    assert steps <= 2 * closing.ASTRAY

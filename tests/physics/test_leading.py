"""Starts of few joints are searched by many guesses at once, and led by long steps: both come to what one guess after
another and short steps come to."""

import math

import numpy as np
import pytest

import lamc
from lamc.design.split import split
from lamc.examples import path
from lamc.loops.closing import SOLVE, settle, settle_all
from lamc.loops.geometry import LoopGeometry
from lamc.loops.leading import led_along
from lamc.loops.surveys import _among
from lamc.mechanism.plan import plan
from lamc.records.design import Design

NEAR = 1e-9  # rad: closure is met to 1e-12 of what is well conditioned
GIVEN = {"four_bar": ("arm",), "six_bar": ("arm",), "two_loops": ("arm_1", "arm_2"), "five_bar": ("left",)}


def geometry_of(name: str) -> LoopGeometry:
    design = lamc.load(path(name))
    assert isinstance(design, Design)
    return LoopGeometry(plan(split(design)))


def free_but(geometry: LoopGeometry, given: tuple[str, ...]) -> np.ndarray:
    return np.array([name not in given for name in geometry.names])


@pytest.mark.parametrize("name", sorted(set(GIVEN) - {"five_bar"}))
@pytest.mark.parametrize("angle", [-0.3, 0.05, 0.6, 1.3])
def test_long_steps_come_to_where_short_ones_come(name: str, angle: float) -> None:
    geometry = geometry_of(name)
    free = free_but(geometry, GIVEN[name])
    wanted = np.where(free, 0.0, angle)
    place, count = np.zeros(len(free)), math.ceil(abs(angle) / 5e-3)
    for step in range(1, count + 1):
        place, error = settle(geometry, np.where(free, place, wanted * step / count), free)
        if error > NEAR:  # it closes no farther
            break
    led = led_along(geometry, np.zeros(len(free)), wanted, free)
    if led is None:  # beyond where it closes, or within a step of it, as the six-bar is drawn
        assert error > NEAR or name == "six_bar"
    else:
        assert led == pytest.approx(place, abs=NEAR)
        assert np.array_equal(led[~free], wanted[~free])


def test_nothing_is_led_out_of_a_singular_position() -> None:
    """A vertex is drawn flat, where its branches part: which of them was meant, a tangent does not say."""
    geometry = geometry_of("vertex")
    free = np.arange(len(geometry.names)) > 0
    assert led_along(geometry, np.zeros(len(free)), np.where(free, 0.0, 0.5), free) is None


@pytest.mark.parametrize("name", sorted(GIVEN))
def test_guesses_at_once_come_to_where_they_come_one_by_one(name: str) -> None:
    geometry = geometry_of(name)
    free = free_but(geometry, GIVEN[name])
    guesses = 0.4 * np.random.default_rng(17).normal(size=(12, len(free)))
    places, errors = settle_all(geometry, guesses, free, SOLVE)
    for guess, place, error in zip(guesses, places, errors, strict=True):
        alone, left = settle(geometry, guess, free)
        assert (left < 1e-12) == (error < 1e-12)
        if left < 1e-12:
            assert place == pytest.approx(alone, abs=NEAR)


@pytest.mark.parametrize("name", ["four_bar", "folding_box", "waterbomb", "sarrus"])
def test_the_jacobian_of_closure_is_that_of_differences(name: str) -> None:
    """At closed angles; dense as sparse. Differences of 1e-6 rad: 1e-12 of truncation, 1e-10 of round-off."""
    geometry = geometry_of(name)
    angles, error = settle(geometry, 0.1 * np.random.default_rng(3).normal(size=len(geometry.names)))
    assert error < 1e-12
    rings, step = geometry.rings, 1e-6
    shifted = step * np.eye(len(angles))
    ahead, behind = (rings.residual(angles + sign * shifted)[0] for sign in (1.0, -1.0))
    screws = rings.residual(angles)[1]
    assert rings.dense(screws) == pytest.approx((ahead - behind).T / (2.0 * step), abs=1e-9)
    assert np.array_equal(rings.sparse(screws).toarray(), rings.dense(screws))


def test_random_motions_do_not_depend_on_the_basis_of_their_space() -> None:
    """A decomposition gives one or another basis by its round-off: ranks of nearby geometries are told alike."""
    random = np.random.default_rng(5)
    basis = np.linalg.qr(random.normal(size=(7, 3)))[0]
    other = basis @ np.linalg.qr(random.normal(size=(3, 3)))[0]
    first, second = (_among(np.random.default_rng(1), 2, each) for each in (basis, -other))
    assert first == pytest.approx(second, abs=1e-14)  # round-off of sums of seven
    assert np.linalg.matrix_rank(np.vstack([first, basis.T])) == 3

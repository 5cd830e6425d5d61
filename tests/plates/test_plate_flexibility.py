"""Flexibility between points of a plate against beams, series and itself."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from shapely.geometry import LineString

from lamc import plate
from lamc.basics.errors import DesignError

BEAM = plate.Laminate(
    [plate.Ply(plate.Material.isotropic(12.0, 0.0, 1.0), 1.0)]
)  # D = 1 N·m, no Poisson's effect
LEFT = LineString([(0, 0), (0, 1)])


def test_cantilever_gives_way_as_a_beam_does() -> None:
    """One metre wide, b = 1: w_i per N at j is s² (3 l - s) / (6 D b), with s the lesser of the two arms."""
    mesh = plate.grid(4.0, 1.0, 16, 4)
    arms = np.array([1.0, 2.5, 4.0])
    problem = plate.Problem(mesh, BEAM, supports=[plate.Clamped(LEFT)], loads=[plate.Pressure(7.0)])
    found = plate.flexibility(problem, [(x, 0.5) for x in arms])
    s, far = np.minimum.outer(arms, arms), np.maximum.outer(arms, arms)
    # A strip as wide as 1/4 of its length bends across too, and more so under the load: of order (b/L)² of the arm.
    np.testing.assert_allclose(found, s**2 * (3 * far - s) / 6, rtol=0.0, atol=0.05)
    np.testing.assert_array_equal(found, found.T)


def test_square_gives_way_in_its_middle_as_tabulated(shared: Path) -> None:
    """Timoshenko's 0.0116 P a²/D, from halved cells."""
    cases = json.loads((shared / "reference" / "plates.json").read_text(encoding="utf-8"))["cases"]
    expected = next(entry for entry in cases if entry["id"] == "ssss_point")["expected"]
    steel = plate.Laminate([plate.Ply(plate.Material.isotropic(12 * 0.91, 0.3, 1.0), 1.0)])
    values = []
    for n in (16, 32):
        mesh = plate.grid(1.0, 1.0, n, n, "criss-cross")
        problem = plate.Problem(mesh, steel, supports=[plate.SimplySupported("boundary")])
        values.append(plate.flexibility(problem, [(0.5, 0.5)])[0, 0])
    # h² log h beside h² under the load, which the extrapolation leaves.
    assert (4 * values[1] - values[0]) / 3 == pytest.approx(expected, rel=1e-3)


def test_moved_supports_do_not_count() -> None:
    mesh = plate.grid(2.0, 1.0, 4, 2)
    held = plate.Problem(mesh, BEAM, supports=[plate.Clamped(LEFT)])
    moved = plate.Problem(
        mesh, BEAM, supports=[plate.Support(LEFT, ("w",), 0.3), plate.Support(LEFT, ("w_x", "w_y"))]
    )
    points = [(2.0, 0.0), (1.0, 1.0)]
    np.testing.assert_allclose(plate.flexibility(moved, points), plate.flexibility(held, points), rtol=1e-9)


def test_bar_gives_way_along_itself() -> None:
    """Towards its end by L / (E A) = 4/12 m/N, but for the dent around the point."""
    mesh = plate.grid(4.0, 1.0, 8, 2)
    held = [plate.Clamped(LEFT), plate.Support(LEFT, ("u", "v"))]
    problem = plate.Problem(mesh, BEAM, supports=held)
    found = plate.flexibility(problem, [(2.0, 0.5), (4.0, 0.5)], (3.0, 0.0, 0.0))
    # Away from the dent the bar moves as a whole: pulled at its end, its middle moves by half of the end's way.
    assert found[0, 1] == pytest.approx(2.0 / 12.0, rel=0.01)
    assert math.isclose(found[0, 1], found[1, 0], rel_tol=1e-12)


def test_impossible_request_is_refused() -> None:
    mesh = plate.grid(1.0, 1.0, 2, 2)
    held = plate.Problem(mesh, BEAM, supports=[plate.Clamped(LEFT)])
    for request, message in (
        (lambda: plate.flexibility(held, [(0.5, 2.0)]), r"\(0.5, 2\).* outside the plate"),
        (lambda: plate.flexibility(held, [(0.5, 0.5)], (0, 0, 0)), "the direction of a flexibility is zero"),
        (lambda: plate.flexibility(plate.Problem(mesh, BEAM), [(0.5, 0.5)]), "the plate is not held"),
        (lambda: plate.flexibility(held, [(0.5, 0.5, 0.5)]), r"points of a flexibility has shape \(1, 3\)"),
    ):
        with pytest.raises(DesignError, match=message) as caught:
            request()
        assert "\n" not in str(caught.value)

"""Linear buckling against closed forms, textbook tables and a Ritz method without elements."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from shapely.geometry import LineString, Point

from lamc import plate
from tests.support.plate_ritz import buckling_factors
from tests.support.plates import assert_refused

NU = 0.3
UNIT = plate.Material.isotropic(12 * (1 - NU**2), NU, 1.0)  # D = 1 N·m at a thickness of 1 m
ISOTROPIC = plate.Laminate([plate.Ply(UNIT, 1.0)])
CFRP = plate.Material(E1=350e9, E2=7e9, nu12=0.33, G12=5e9, density=1600)
SIMPLE, CLAMPED = plate.SimplySupported("boundary"), plate.Clamped("boundary")
UNIAXIAL, SHEAR = (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def rectangle(
    a: float, n: int, *supports: Any, laminate: plate.Laminate = ISOTROPIC, **more: Any
) -> plate.Problem:
    mesh = plate.grid(a, 1.0, round(a * n), n, more.pop("pattern", "criss-cross"))
    return plate.Problem(mesh, laminate, more.pop("element", "dkt"), supports, **more)


def extrapolated(problems: list[plate.Problem], forces: Any, count: int = 1) -> np.ndarray:
    """To no cell size, from halved cells: of second order."""
    coarse, fine = (plate.buckling(problem, count, forces=forces).factors for problem in problems)
    return np.asarray((4.0 * fine - coarse) / 3.0)


@pytest.mark.parametrize(
    ("support", "name", "forces", "k", "digits"),
    [
        # N = k π² D / b², as printed by S. P. Timoshenko and J. M. Gere, Theory of Elastic Stability, 1961, sections
        # 9.2, 9.7 and 9.8; the first is exact.
        (SIMPLE, "SSSS", UNIAXIAL, 4.0, 0.0),
        (SIMPLE, "SSSS", SHEAR, 9.34, 0.02),
        (CLAMPED, "CCCC", UNIAXIAL, 10.07, 0.005),
    ],
)
def test_square_buckles_as_in_the_textbook(
    support: Any, name: str, forces: Any, k: float, digits: float
) -> None:
    found = extrapolated([rectangle(1.0, n, support) for n in (12, 24)], forces)[0] / math.pi**2
    exact = buckling_factors(1.0, 1.0, ISOTROPIC.D, name, forces)[0] / math.pi**2
    assert exact == pytest.approx(k, abs=max(digits, 1e-6))  # the reference stands where the book does
    assert found == pytest.approx(exact, rel=2e-4)  # fourth-order terms that the extrapolation leaves


@pytest.mark.parametrize("ratio", [1.0, 2.0])
def test_orthotropic_plate_buckles_as_navier_says(ratio: float) -> None:
    """N = π² (a/m)² (D11 (m/a)⁴ + 2 (D12 + 2 D66) (m n/a)² + D22 n⁴) for m half waves along the load, n across."""
    laminate = plate.Laminate([plate.Ply(CFRP, 0.1e-3, angle) for angle in (0, 90, 90, 0)])
    D = laminate.D
    m, n = np.meshgrid(np.arange(1, 8) / ratio, np.arange(1, 8))
    each = math.pi**2 / m**2 * (D[0, 0] * m**4 + 2 * (D[0, 1] + 2 * D[2, 2]) * m**2 * n**2 + D[1, 1] * n**4)
    problems = [rectangle(ratio, n, SIMPLE, laminate=laminate) for n in (10, 20)]
    found = extrapolated(problems, UNIAXIAL, 2)
    assert found == pytest.approx(np.sort(each.ravel())[:2], rel=1e-3)  # fourth-order terms remain


def test_sheared_plate_buckles_either_way_alike() -> None:
    """Its mirror image is the plate sheared the other way."""
    found = plate.buckling(rectangle(1.0, 10, SIMPLE), 3, forces=SHEAR)
    np.testing.assert_allclose(found.reversed, -found.factors, rtol=1e-8)  # round-off
    assert (np.diff(found.factors) >= 0.0).all()
    assert found.critical == found.factors[0]


def test_pulled_plate_does_not_buckle_but_turned_round_it_does() -> None:
    found = plate.buckling(rectangle(1.0, 8, SIMPLE), 2, forces=(1.0, 0.0, 0.0))
    assert len(found.factors) == 0
    assert found.critical == math.inf
    pressed = plate.buckling(rectangle(1.0, 8, SIMPLE), 2, forces=UNIAXIAL)
    np.testing.assert_allclose(found.reversed, -pressed.factors, rtol=1e-10)  # the same matrices
    assert pressed.critical == pytest.approx(4 * math.pi**2, rel=0.01)  # second order in 1/8


@pytest.mark.parametrize("cells", [1, 2, 3, 4])
def test_a_pulled_plate_of_few_cells_does_not_buckle_either(cells: int) -> None:
    """Loads that pull, held at the other end: nothing presses a mesh so coarse, and round-off is no factor. So few
    unknowns are for LAPACK, more for Lanczos."""
    clamped = plate.Clamped(LineString([(0, 0), (0, 1)]))
    pull = plate.EdgeLoad(LineString([(1, 0), (1, 1)]), (1000.0, 0.0, 0.0))
    found = plate.buckling(rectangle(1.0, cells, clamped, loads=[pull]), 3)
    assert found.critical == math.inf
    assert len(found.reversed) == 3


def test_column_buckles_at_eulers_load() -> None:
    """A wide strip without Poisson's effect, pinned at both ends: N = π² D / L²; shapes are half waves."""
    laminate = plate.Laminate([plate.Ply(plate.Material.isotropic(12.0, 0.0, 1.0), 1.0)])
    ends = [plate.SimplySupported(LineString([(x, 0), (x, 1)])) for x in (0, 4)]
    problem = rectangle(4.0, 6, *ends, laminate=laminate)
    found = plate.buckling(problem, 1, forces=UNIAXIAL)
    # Second order in half waves of 24 cells.
    assert found.critical == pytest.approx(math.pi**2 / 16, rel=2e-3)
    x = np.linspace(0.0, 4.0, 9)
    np.testing.assert_allclose(
        found.deflection(0, x, np.full(9, 0.5)), np.sin(math.pi * x / 4), rtol=0.0, atol=2e-3
    )


def test_loads_in_the_plane_press_as_the_same_forces_do() -> None:
    """An edge load on a plate that is free to spread makes N_x uniform, exactly in every element."""
    ends = [LineString([(x, 0), (x, 1)]) for x in (0, 1)]
    in_plane = [
        plate.Support(LineString([(0, 0), (0, 1)]), ("u",)),
        plate.Support(LineString([(0, 0), (1, 0)]), ("v",)),
    ]
    loads = [plate.EdgeLoad(ends[1], (-3.0, 0.0, 0.0))]
    problem = rectangle(1.0, 8, SIMPLE, *in_plane, loads=loads)
    loaded = plate.buckling(problem, 2)
    given = plate.buckling(rectangle(1.0, 8, SIMPLE), 2, forces=(-3.0, 0.0, 0.0))
    # Round-off of the solution in the plane.
    np.testing.assert_allclose(
        loaded.forces, np.tile([-3.0, 0.0, 0.0], (len(problem.mesh.cells), 1)), rtol=0.0, atol=1e-9
    )
    np.testing.assert_allclose(loaded.factors, given.factors, rtol=1e-8)


def test_heated_plate_that_cannot_spread_buckles() -> None:
    """N = -E α ΔT h / (1 - ν) in both directions; a square then buckles at 2 π² D."""
    hot = plate.Material.isotropic(12 * (1 - NU**2), NU, 1.0, alpha=1e-3)
    held = plate.Support("boundary", ("u", "v"))
    problem = rectangle(
        1.0, 12, SIMPLE, held, laminate=plate.Laminate([plate.Ply(hot, 1.0)]), loads=[plate.Temperature(5.0)]
    )
    N = hot.E1 * 1e-3 * 5.0 / (1 - NU)
    assert plate.buckling(problem, 1).critical == pytest.approx(
        2 * math.pi**2 / N, rel=5e-3
    )  # second order in 1/12


def test_coupled_plate_that_may_slide_buckles_as_if_it_were_pinned() -> None:
    """[0/90] couples bending and stretching; three pins at a corner and an edge hold its plane without a force."""
    laminate = plate.Laminate([plate.Ply(CFRP, 0.1e-3, angle) for angle in (0, 90)])
    pins = [plate.Support(Point(0, 0), ("u", "v")), plate.Support(Point(1, 0), ("v",))]
    loose = plate.buckling(rectangle(1.0, 6, SIMPLE, laminate=laminate), 2, forces=UNIAXIAL)
    held = plate.buckling(rectangle(1.0, 6, SIMPLE, *pins, laminate=laminate), 2, forces=UNIAXIAL)
    np.testing.assert_allclose(loose.factors, held.factors, rtol=1e-8)  # round-off


BAD_REQUESTS = {
    "no forces": (
        lambda: plate.buckling(rectangle(1, 2, SIMPLE)),
        "no membrane forces, .* load it in its plane",
    ),
    "zero": (lambda: plate.buckling(rectangle(1, 2, SIMPLE), forces=(0, 0, 0)), "no membrane forces"),
    "shape": (
        lambda: plate.buckling(rectangle(1, 2, SIMPLE), forces=(1, 0)),
        "forces of buckling has shape",
    ),
    "one number": (
        lambda: plate.buckling(rectangle(1, 2, SIMPLE), forces=5),  # type: ignore[arg-type]
        r"forces of buckling has shape \(\)",
    ),
    "free": (
        lambda: plate.buckling(rectangle(1, 2), forces=UNIAXIAL),
        "buckling needs a plate that is held, .*rise",
    ),
    "count": (
        lambda: plate.buckling(rectangle(1, 2, SIMPLE), 0, forces=UNIAXIAL),
        "buckling factors is 0",
    ),
}


@pytest.mark.parametrize("name", BAD_REQUESTS)
def test_impossible_request_is_refused(name: str) -> None:
    assert_refused(*BAD_REQUESTS[name])


@pytest.mark.parametrize("n", [3, 8])  # by LAPACK, and by Lanczos
def test_a_factor_that_weak_parts_hide_is_told_to_be_possible(n: int) -> None:
    """A board that is pressed beside a film that is pulled: the film, turned round, buckles at a millionth of what the
    board does. It was said that these forces do not buckle it."""
    board = plate.Laminate([plate.Ply(plate.Material.isotropic(70e9, 0.3, 1600.0), 1e-3)])
    film = plate.Laminate([plate.Ply(plate.Material.isotropic(2.5e9, 0.3, 1400.0), 12e-6)])
    mesh = plate.grid(0.1, 0.05, 2 * n, n, "criss-cross")
    at_left = mesh.corners[..., 0].mean(axis=1) < 0.05
    regions = np.where(at_left, 0, 1).astype(np.int32)
    mesh = replace(mesh, regions=regions, region_names=("board", "film"))
    seam = plate.SimplySupported(LineString([(0.05, 0.0), (0.05, 0.05)]))
    problem = plate.Problem(
        mesh, {"board": board, "film": film}, "dkt", [plate.SimplySupported("boundary"), seam]
    )
    both = plate.buckling(problem, 3, forces=np.where(at_left[:, None], [[-50.0, 0, 0]], [[5.0, 0, 0]]))
    alone = plate.buckling(problem, 3, forces=np.where(at_left[:, None], [[-50.0, 0, 0]], [[0.0, 0, 0]]))
    assert not len(both.factors)
    assert both.is_open
    assert both.told_to == pytest.approx(-1e6 * both.reversed[0])
    assert alone.critical > both.told_to
    assert not alone.is_open
    assert any("a buckling factor above" in note for note in both.notes)
    pulled = plate.buckling(problem, 3, forces=(5.0, 0.0, 0.0))
    assert pulled.critical == np.inf
    assert not pulled.is_open

"""Stiffness of a hinge's strip in all directions: textbook limits, finite elements, pieces of a strip."""

import numpy as np
import pytest
from shapely.geometry import LineString

from lamc import plate
from lamc.basics.errors import DesignError
from lamc.plate import Laminate, Material, Ply
from lamc.plates.answers.model import FactoredPlate
from lamc.plates.answers.strip_stiffness import DIRECTIONS, about, strip_stiffness
from tests.support.ctools import needs_cc

E, NU, T, L = 2.5e9, 0.34, 25e-6, 1e-3
FILM = Laminate([Ply(Material.isotropic(E, NU, 1420.0), T)])
FIBRES = Laminate([Ply(plate.material("T300/5208"), 20e-6)])
ROUND_OFF = 1e-12


def test_narrow_strip_is_the_textbook_beam() -> None:
    """L = 20 b: Euler's beam with St Venant's torsion, free to warp but at its ends, and Timoshenko's shear."""
    b = L / 20
    k, G, area = strip_stiffness(FILM, L, b), E / (2 * (1 + NU)), b * T
    assert k.angle == pytest.approx(E * b * T**3 / 12 / L, rel=ROUND_OFF)
    assert k.twist_y == pytest.approx(E * T * b**3 / 12 / L, rel=ROUND_OFF)
    assert k.slide_x == pytest.approx(E * area / L, rel=ROUND_OFF)
    for got, inertia in ((k.slide_z, T * b**3 / 12), (k.slide_y, b * T**3 / 12)):
        bending, shear = L**3 / (12 * E * inertia), L / (5 / 6 * G * area)
        # The plate's shear through the thickness is worked out with E/(1 - ν²), which leaves the 5/6 as it is.
        assert got == pytest.approx(1 / (bending + shear), rel=1e-9)
    # Ends that cannot warp hold a length of √(EΓ/GJ) each: with Γ = b³t³/144 and J = bt³/3, b √(E/G/48).
    held = b * np.sqrt(E / G / 48)
    assert k.twist_x == pytest.approx(G * b * T**3 / 3 / (L - 2 * held), rel=1e-9)


def test_long_hinge_is_a_row_of_clamped_fibres() -> None:
    """b = 100 L: in torsion each fibre across the strip shears as a clamped beam does, 12 D/L³ at z; and more by what
    twists: ∫ 2 D (1 - ν) b θ'² dx with the S of a clamped beam, θ = 3 (x/L)² - 2 (x/L)³, is 2.4 (1 - ν) D b/L."""
    b = 100 * L
    k, D = strip_stiffness(FILM, L, b), E * T**3 / 12 / (1 - NU**2)
    assert k.angle == pytest.approx(D * b / L, rel=ROUND_OFF)
    assert k.twist_x == pytest.approx(D * b**3 / L**3 * (1 + 2.4 * (1 - NU) * (L / b) ** 2), rel=1e-6)
    assert k.twist_y == pytest.approx(E * T / (1 - NU**2) * b**3 / 12 / L, rel=ROUND_OFF)
    assert k.slide_z == pytest.approx(E / (2 * (1 + NU)) * b * T / L, rel=1e-3)  # shear alone, but for (L/b)²
    assert k.twist_x > 1000 * E / (2 * (1 + NU)) * b * T**3 / 3 / L  # what free warping would leave


def prescribed(laminate: Laminate, width: float, length: float, direction: str) -> float:
    """Twice the energy of finite elements whose ends move by ∓½ of a unit of `direction`, as two rigid links do."""
    lines = np.linspace(0.0, length, max(8, round(8 * length / width)) + 1)
    mesh = plate.grid_of_lines(np.linspace(0.0, width, 13), lines)
    supports = []
    for sign, x in ((-0.5, 0.0), (0.5, width)):
        end = LineString([(x, 0.0), (x, length)])

        def arm(_: object, y: np.ndarray, sign: float = sign) -> np.ndarray:
            return sign * (y - 0.5 * length)

        across = {"angle": (sign * sign * width, sign, 0.0), "twist_x": (arm, 0.0, sign)}
        plane = {"slide_x": (sign, 0.0), "slide_z": (0.0, sign)}
        plane["twist_y"] = (lambda x, y, arm=arm: -arm(x, y), sign * (sign * width))
        across["slide_y"] = (sign, 0.0, 0.0)
        if direction in across:
            supports += [
                plate.Support(end, (n,), v)
                for n, v in zip(("w", "w_x", "w_y"), across[direction], strict=True)
            ]
        else:
            supports += [
                plate.Support(end, (n,), v) for n, v in zip(("u", "v"), plane[direction], strict=True)
            ]
    element = "dkt" if direction in ("angle", "twist_x", "slide_y") else "lst"
    problem = plate.Problem(mesh, laminate, element=element, supports=supports)
    return 2.0 * FactoredPlate(problem).solve().strain_energy


@needs_cc
@pytest.mark.parametrize("laminate", [FILM, FIBRES], ids=["film", "fibres"])
@pytest.mark.parametrize(("ratio", "limit"), [(0.2, 0.04), (1.0, 0.14), (4.0, 0.08), (12.0, 0.04)])
@pytest.mark.quick("0.2-*", "1.0-*")
def test_elements_bear_the_formulas_out(laminate: Laminate, ratio: float, limit: float) -> None:
    """They leave out what happens at the strip's free ends, within about half a width of them: ν L/b or so, most where
    the strip is square; elements of thin plates know no shear through the thickness, 1 % here at most."""
    b = ratio * L
    k = strip_stiffness(laminate, L, b)
    for direction in DIRECTIONS:
        allowed = limit + (0.02 if direction == "slide_y" else 0.0)
        assert getattr(k, direction) == pytest.approx(prescribed(laminate, L, b, direction), rel=allowed), (
            direction
        )


def test_two_halves_of_a_strip_are_the_strip() -> None:
    """Clamped fibres side by side: what couples along the line is within (L/b)² of nothing, and shear through the
    thickness, which the torsion leaves out and slide_y does not, is 12 D/(S L²) = 2.9/(1 - ν) (t/L)², 0.0027."""
    b = 200 * L
    half = strip_stiffness(FILM, L, b / 2).matrix
    both = about(half, b / 4) + about(half, -b / 4)
    whole = strip_stiffness(FILM, L, b).matrix
    assert both == pytest.approx(whole, rel=3e-3, abs=1e-9 * whole.max())


def test_a_shifted_strip_has_the_energy_of_its_own_displacements() -> None:
    rng = np.random.default_rng(3)
    matrix, along = strip_stiffness(FILM, L, 10 * L).matrix, 3e-3
    p = rng.normal(size=6)
    own = p.copy()
    own[3:] += np.cross(p[:3], [0.0, 0.0, along])
    assert p @ about(matrix, along) @ p == pytest.approx(own @ matrix @ own, rel=ROUND_OFF)


@pytest.mark.parametrize(("width", "length"), [(0.0, 1e-3), (1e-3, -1.0)])
def test_a_strip_without_size_is_refused(width: float, length: float) -> None:
    with pytest.raises(DesignError, match=r"of a hinge's strip is .* it must be positive"):
        strip_stiffness(FILM, width, length)

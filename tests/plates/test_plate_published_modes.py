"""Frequencies and buckling loads of plates in print or in closed form.

Tabulated values are exact to their digits where Levy's solution or Bessel functions give them; Ritz values are bounds
from above, and said to be. Meshes are extrapolated by O(h²).
"""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from shapely.geometry import Point

from lamc import plate
from tests.support.ctools import needs_cc
from tests.support.plate_meshes import extrapolated, held, rectangle_mesh, sheet, sides, stack

pytestmark = needs_cc

ORTHOTROPIC = stack(plate.Material(25e6, 1e6, 0.25, 0.5e6, 100.0), 0.01, 0.0, 90.0, 0.0)  # 3 kg/m²


def omega(
    mesh: plate.Mesh, laminate: plate.Laminate, supports: list[Any], count: int, element: str = "dkt"
) -> Any:
    return plate.modes(plate.Problem(mesh, laminate, element=element, supports=supports), count=count).omega


# A. W. Leissa, J. Sound Vib. 31, 1973: ω a² sqrt(ρ h / D) of squares with two opposite edges simply supported, ν = 0.3;
# from Levy's solution. Edges: left, bottom, right, top.
LEVY = {
    "SCSC": [28.9509, 54.7431, 69.3270, 94.5853],
    "SSSC": [23.6463, 51.6743, 58.6464, 86.1345],
    "SCSF": [12.6874, 33.0651, 41.7019, 63.0148],
    "SSSF": [11.6845, 27.7563, 41.1967, 59.0655],
    "SFSF": [9.6314, 16.1348, 36.7256, 38.9450],
}


@pytest.mark.parametrize("edges", sorted(LEVY))
@pytest.mark.quick("SCSC", "SFSF")
def test_squares_between_simple_supports_vibrate_as_levys_solution(edges: str) -> None:
    """Extrapolated from 16 and 32 parts a side: what is left is O(h⁴) of four waves or fewer, 5e-4."""
    found = [
        omega(plate.grid(1.0, 1.0, n, n, pattern="criss-cross"), sheet(), held(edges), 4) for n in (16, 32)
    ]
    np.testing.assert_allclose(extrapolated(*found), LEVY[edges], rtol=5e-4)


def test_an_orthotropic_rectangle_vibrates_as_in_closed_form() -> None:
    """ω² ρ = D11 α⁴ + 2 (D12 + 2 D66) α² β² + D22 β⁴ (Reddy, Mechanics of Laminated Composite Plates, section 5.7)."""
    a, b, D = 1.0, 0.7, ORTHOTROPIC.D
    m, n = np.meshgrid(np.arange(1, 8) * np.pi / a, np.arange(1, 8) * np.pi / b)
    squares = D[0, 0] * m**4 + 2 * (D[0, 1] + 2 * D[2, 2]) * (m * n) ** 2 + D[1, 1] * n**4
    expected = np.sqrt(np.sort(squares.ravel())[:5] / 3.0)
    found = [
        omega(plate.grid(a, b, k, k, pattern="criss-cross"), ORTHOTROPIC, held("SSSS", a, b), 5)
        for k in (16, 32)
    ]
    np.testing.assert_allclose(extrapolated(*found), expected, rtol=1e-3)


# Roots of the frequency equations, Bessel functions: λ² = ω R² sqrt(ρ h / D) of disks with ν = 0.3 (A. W. Leissa,
# Vibration of Plates, 1969, tables 2.1, 2.3 and 2.5)
DISKS = {
    "clamped": [10.2158, 21.2604, 21.2604, 34.8770, 34.8770, 39.7711],
    "simple": [4.9351, 13.8982, 13.8982, 25.6133, 25.6133, 29.7200],
    "free": [0.0, 0.0, 0.0, 5.3583, 5.3583, 9.0031, 12.4390, 12.4390],
}


@pytest.mark.parametrize("kind", sorted(DISKS))
def test_disks_vibrate_as_bessel_functions_say(kind: str) -> None:
    """Polygons of 128 sides, and triangles of a twentieth of the radius: 0.5 %."""
    mesh = plate.mesh(Point(0.0, 0.0).buffer(1.0, quad_segs=32), size=0.055)
    supports: dict[str, list[Any]] = {
        "clamped": [plate.Clamped("boundary")],
        "simple": [plate.SimplySupported("boundary")],
        "free": [],
    }
    found = omega(mesh, sheet(), supports[kind], len(DISKS[kind]))
    np.testing.assert_allclose(found, DISKS[kind], rtol=5e-3, atol=1e-6)


@pytest.mark.parametrize(
    ("family", "element"), [("delaunay", "dkt"), ("jittered", "specht"), ("squares", "bfs")]
)
@pytest.mark.quick("delaunay-dkt", "jittered-specht")
def test_clamped_rectangles_vibrate_as_ritz_found(family: str, element: str) -> None:
    """a/b = 1.5, ω a² sqrt(ρ h / D), from Leissa 1973: 60.772, 93.860, 148.82, 149.74; bounds from above, by 2e-3."""
    mesh = rectangle_mesh(family, 32, 1.5, 1.0)
    found = omega(mesh, sheet(), held("CCCC", 1.5, 1.0), 4, element) * 1.5**2
    np.testing.assert_allclose(found, [60.772, 93.860, 148.82, 149.74], rtol=1e-2)


# --- buckling --------------------------------------------------------------------------------------------------------


def factor(
    edges: str, forces: Any, a: float = 1.0, *, laminate: plate.Laminate | None = None, n: int = 16
) -> float:
    """Of π² D / b², of a plate a × 1 with D = 1."""

    def least(k: int) -> float:
        mesh = plate.grid(a, 1.0, round(k * a), k, pattern="criss-cross")
        problem = plate.Problem(mesh, laminate or sheet(), supports=held(edges, a, 1.0))
        given = forces(mesh) if callable(forces) else forces
        return float(plate.buckling(problem, count=1, forces=given).critical)

    return float(extrapolated(least(n), least(2 * n))) / np.pi**2


@pytest.mark.parametrize("a", [0.5, 1.0, 1.5, 3.0])
@pytest.mark.quick("0.5", "1.5")
def test_pressed_simply_supported_plates_buckle_in_whole_waves(a: float) -> None:
    """k = min over m of (m/a + a/m)²."""
    waves = min((m / a + a / m) ** 2 for m in range(1, 8))
    assert factor("SSSS", (-1.0, 0.0, 0.0), a) == pytest.approx(waves, rel=1e-3)


# S. Timoshenko and J. M. Gere, Theory of Elastic Stability, 2nd ed. 1961, chapter 9, and the tolerance of what they
# found by energy methods. Forces, aspect, k.
TABLES = [
    ("SSSS", (-1.0, -1.0, 0.0), 1.0, 2.0, 1e-3),  # both ways, exact
    ("SSSS", (0.0, 0.0, 1.0), 1.0, 9.34, 5e-3),  # shear
    ("SSSS", (0.0, 0.0, -1.0), 1.0, 9.34, 5e-3),
    ("SSSS", (0.0, 0.0, 1.0), 2.0, 6.6, 1.5e-2),  # rounded there; 6.55 by later authors
    ("CCCC", (-1.0, 0.0, 0.0), 1.0, 10.07, 3e-3),
    ("CCCC", (0.0, 0.0, 1.0), 1.0, 14.71, 1e-2),  # an upper bound by half a percent
    ("SCSC", (-1.0, 0.0, 0.0), 1.0, 7.69, 5e-3),  # the pressed edges simple, the others clamped
    ("CSCS", (-1.0, 0.0, 0.0), 1.0, 6.74, 5e-3),
]


@pytest.mark.parametrize(("edges", "forces", "a", "k", "tolerance"), TABLES)
@pytest.mark.quick("SSSS-forces0*", "SSSS-forces1*", "CCCC-forces4*", "SCSC*")
def test_plates_buckle_as_tabulated(edges: str, forces: Any, a: float, k: float, tolerance: float) -> None:
    assert factor(edges, forces, a) == pytest.approx(k, rel=tolerance)


@pytest.mark.parametrize("nu", [0.25, 0.3])
def test_a_flange_buckles_as_its_characteristic_equation_says(nu: float) -> None:
    """A square with three simple edges and a free one, w = sin μx (A sinh αy + B sin βy), M_y and V_y zero at the free
    edge (Timoshenko and Gere, article 9.4, whose table gives 1.440 for ν = 0.25 where the root is 1.434)."""
    mu = np.pi

    def free_edge(k: float) -> float:
        alpha, beta = np.sqrt(np.pi * np.sqrt(k) * mu + mu**2), np.sqrt(np.pi * np.sqrt(k) * mu - mu**2)
        moments = (alpha**2 - nu * mu**2) * np.sinh(alpha), -(beta**2 + nu * mu**2) * np.sin(beta)
        shears = (
            (alpha**3 - (2 - nu) * mu**2 * alpha) * np.cosh(alpha),
            -(beta**3 + (2 - nu) * mu**2 * beta) * np.cos(beta),
        )
        return float(moments[0] * shears[1] - moments[1] * shears[0])

    k = brentq(free_edge, 1.01, 2.0)
    assert factor("SSSF", (-1.0, 0.0, 0.0), laminate=sheet(nu=nu)) == pytest.approx(k, rel=1e-4)


def test_a_plate_bent_in_its_plane_buckles_as_tabulated() -> None:
    """N_x from pressure at one edge to as much tension at the other: k = 25.6 for a square (Timoshenko and Gere, table
    9-6)."""

    def bent(mesh: plate.Mesh) -> np.ndarray:
        y = mesh.corners.mean(axis=1)[:, 1]
        return np.stack([2.0 * y - 1.0, 0.0 * y, 0.0 * y], axis=1)

    assert factor("SSSS", bent) == pytest.approx(25.6, rel=1e-2)


def test_an_orthotropic_plate_buckles_as_in_closed_form() -> None:
    """N = π² (D11 m⁴/a⁴ + 2 (D12 + 2 D66) m²/(a b)² + D22/b⁴) a²/m² (Reddy, section 5.6)."""
    D, a = ORTHOTROPIC.D, 1.5
    waves = [
        (D[0, 0] * (m / a) ** 4 + 2 * (D[0, 1] + 2 * D[2, 2]) * (m / a) ** 2 + D[1, 1]) * (a / m) ** 2
        for m in range(1, 8)
    ]
    assert factor("SSSS", (-1.0, 0.0, 0.0), a, laminate=ORTHOTROPIC) == pytest.approx(min(waves), rel=2e-3)


def test_a_cross_ply_that_couples_buckles_softer_by_its_coupling() -> None:
    """[0/90] held so that Navier's waves fit: N = (T33 - what stretching lets go) / α², Reddy, section 5.6; from the
    frequency of the same wave, N α² = ρ ω²."""
    laminate = stack(plate.Material(25e6, 1e6, 0.25, 0.5e6, 100.0), 0.01, 0.0, 90.0)
    edge = sides()
    supports = [
        plate.SimplySupported("boundary"),
        *(plate.Support(edge[side], ("v",)) for side in ("left", "right")),
        *(plate.Support(edge[side], ("u",)) for side in ("bottom", "top")),
    ]
    mesh = plate.grid(1.0, 1.0, 24, 24, pattern="criss-cross")
    problem = plate.Problem(mesh, laminate, supports=supports)
    first = plate.modes(problem, count=1, in_plane_inertia=False).omega[0]
    critical = plate.buckling(problem, count=1, forces=(-1.0, 0.0, 0.0)).critical
    assert critical * np.pi**2 == pytest.approx(laminate.areal_mass * first**2, rel=3e-3)

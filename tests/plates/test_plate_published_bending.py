"""Deflections and moments of plates in print or in closed form: rectangles, circles, triangles, laminates, strips.

Where the expected number comes from a table, the tolerance is half a unit of its last digit or what is said beside it;
where it is a closed form, it is the discretisation error that the mesh has by its order.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from shapely.geometry import LineString, Point, Polygon

from lamc import plate
from tests.support.ctools import needs_cc
from tests.support.plate_meshes import CFRP, extrapolated, held, rectangle_mesh, sheet, sides, solved, stack

pytestmark = needs_cc

TIMOSHENKO = "S. Timoshenko and S. Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. 1959"
NU = 0.3
M, N = np.meshgrid(np.arange(1.0, 400.0), np.arange(1.0, 400.0), indexing="ij")
Coefficients = np.ndarray  # of sin(mπx/a) sin(nπy/b), (m, n)


# --- Navier's series: simply supported rectangles --------------------------------------------------------------------


def navier(D: np.ndarray, load: Coefficients, a: float, b: float) -> Callable[[Any, Any], np.ndarray]:
    """w(x, y) of an orthotropic plate (D16 = D26 = 0): article 28 and 85 of Timoshenko."""
    alpha, beta = M * np.pi / a, N * np.pi / b
    stiffness = D[0, 0] * alpha**4 + 2 * (D[0, 1] + 2 * D[2, 2]) * (alpha * beta) ** 2 + D[1, 1] * beta**4

    def w(x: float, y: float) -> float:
        return float(np.sum(load / stiffness * np.sin(alpha * x) * np.sin(beta * y)))

    return np.vectorize(w)


def odd(k: np.ndarray) -> np.ndarray:
    return k % 2


LOADS: dict[str, tuple[Callable[[float, float], Any], Callable[[float, float], Coefficients]]] = {
    "uniform": (lambda a, b: plate.Pressure(1.0), lambda a, b: 16 / (np.pi**2 * M * N) * odd(M) * odd(N)),
    "hydrostatic": (
        lambda a, b: plate.Pressure(lambda x, y: x / a),
        lambda a, b: -8 * (-1.0) ** M / (np.pi**2 * M * N) * odd(N),
    ),
    "force": (
        lambda a, b: plate.PointLoad((a / 4, b / 2), 1.0),
        lambda a, b: 4 / (a * b) * np.sin(M * np.pi / 4) * np.sin(N * np.pi / 2),
    ),
    "line": (
        lambda a, b: plate.EdgeLoad(LineString([(a / 4, 0), (a / 4, b)]), 1.0),
        lambda a, b: 8 / (a * np.pi * N) * np.sin(M * np.pi / 4) * odd(N),
    ),
}
SHEETS = {
    "isotropic": sheet(),
    "cross-ply": stack(plate.Material(25e6, 1e6, 0.25, 0.5e6, 1.0), 0.01, 0.0, 90.0, 0.0),
}


@pytest.mark.parametrize("kind", sorted(SHEETS))
@pytest.mark.parametrize("load", sorted(LOADS))
@pytest.mark.parametrize("b", [1.0, 2.0])
@pytest.mark.quick("2.0-line-*", "2.0-uniform-*", "2.0-hydrostatic-*")
def test_simply_supported_rectangles_deflect_as_naviers_series(load: str, kind: str, b: float) -> None:
    """After extrapolation of O(h²): 5e-4; under a point load the error is O(h² log h), and less is gained."""
    make, coefficients = LOADS[load]
    w = navier(SHEETS[kind].D, coefficients(1.0, b), 1.0, b)
    at = np.array([[0.5, b / 2], [0.25, b / 2], [0.75, b / 4]])

    def found(n: int) -> np.ndarray:
        mesh = plate.grid(1.0, b, n, n, pattern="criss-cross")
        return np.asarray(solved(mesh, SHEETS[kind], held("SSSS", 1.0, b), [make(1.0, b)]).deflection(*at.T))

    expected = w(*at.T)
    tolerance = 3e-3 if load == "force" else 5e-4
    np.testing.assert_allclose(
        extrapolated(found(12), found(24)), expected, rtol=0, atol=tolerance * expected.max()
    )


# TIMOSHENKO, table 8: b/a, w D / (q a⁴), M_x and M_y / (q a²) at the centre
TABLE_8 = [
    (1.0, 0.00406, 0.0479, 0.0479),
    (1.5, 0.00772, 0.0812, 0.0498),
    (2.0, 0.01013, 0.1017, 0.0464),
    (3.0, 0.01223, 0.1189, 0.0406),
]


@pytest.mark.parametrize(("b", "w", "mx", "my"), TABLE_8)
def test_simply_supported_rectangles_have_the_tabulated_moments(
    b: float, w: float, mx: float, my: float
) -> None:
    """Moments are linear in each triangle; the mean over four around the centre is good to 1 % at this size."""
    mesh = plate.grid(1.0, b, 24, round(24 * b), pattern="criss-cross")
    solution = solved(mesh, sheet(), held("SSSS", 1.0, b), [plate.Pressure(1.0)])
    assert float(solution.deflection(0.5, b / 2)) == pytest.approx(w, rel=2e-3)
    around = solution.moments(0.5 + np.array([1, 0, -1, 0]) * 1e-3, b / 2 + np.array([0, 1, 0, -1]) * 1e-3)
    np.testing.assert_allclose(around.mean(axis=0)[:2], [mx, my], rtol=1e-2)


# --- other edges -----------------------------------------------------------------------------------------------------

# TIMOSHENKO, tables 35 (uniform, clamped) and 37 (force at the centre, clamped), by b/a: w and the moment across the
# middle of the long edge, of q a⁴/D and q a², or P a²/D and P. The first of these was cut, not rounded: it is 0.0012653
# (R. L. Taylor and S. Govindjee, Int. J. Numer. Meth. Engng 59, 2004).
CLAMPED = [
    ("pressure", 1.0, 0.0012653, -0.0513),
    ("pressure", 1.2, 0.00172, -0.0639),
    ("pressure", 1.5, 0.00220, -0.0757),
    ("pressure", 2.0, 0.00254, -0.0829),
    ("force", 1.0, 0.00560, -0.1257),
    ("force", 1.2, 0.00647, -0.1490),
    ("force", 1.4, 0.00691, -0.1604),
    ("force", 2.0, 0.00722, -0.1674),
]


@pytest.mark.parametrize(("kind", "b", "w", "edge"), CLAMPED)
@pytest.mark.quick("pressure-1.2-*", "force-1.0-*")
def test_clamped_rectangles_are_as_tabulated(kind: str, b: float, w: float, edge: float) -> None:
    """Half a unit of three digits is 0.4 %; moments at a clamped edge come from linear curvatures of the triangles
    along it, O(h): extrapolated, 2 %."""
    load = plate.Pressure(1.0) if kind == "pressure" else plate.PointLoad((0.5, b / 2), 1.0)

    def found(n: int) -> np.ndarray:
        mesh = plate.grid(1.0, b, n, n, pattern="criss-cross")
        solution = solved(mesh, sheet(), held("CCCC", 1.0, b), [load])
        return np.array([float(solution.deflection(0.5, b / 2)), float(solution.moments(0.0, b / 2)[0])])

    coarse, fine = found(24), found(48)
    assert extrapolated(coarse, fine)[0] == pytest.approx(w, rel=4e-3)
    assert (2 * fine - coarse)[1] == pytest.approx(edge, rel=2e-2)


def test_mixed_edges_are_as_tabulated() -> None:
    """TIMOSHENKO, squares under uniform pressure: table 29 (SCSC), article 42 (SSSC), table 47 (SFSS, free edge's
    middle)."""
    for edges, at, expected in (
        ("SCSC", (0.5, 0.5), 0.00192),
        ("SSSC", (0.5, 0.5), 0.0028),
        ("SFSS", (0.5, 0.0), 0.01286),
    ):
        mesh = plate.grid(1.0, 1.0, 32, 32, pattern="criss-cross")
        solution = solved(mesh, sheet(), held(edges), [plate.Pressure(1.0)])
        digits = 0.5 * 10.0 ** -len(str(expected).split(".")[1])
        # the last digit, and 1e-3 of discretisation
        assert float(solution.deflection(*at)) == pytest.approx(expected, abs=digits + 1e-3 * expected)


# --- other shapes ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["hard", "soft"])
def test_a_simply_supported_disk_does_not_fall_into_the_paradox_of_polygons(kind: str) -> None:
    """w = (5 + ν) / (64 (1 + ν)) q R⁴/D. A polygon that is held straight is another plate, stiffer by a fourth in the
    limit of many sides (I. Babuška 1963); here every node of the boundary is on the circle."""
    mesh = plate.mesh(Point(0.0, 0.0).buffer(1.0, quad_segs=24), size=0.08)
    assert len(mesh.boundary_edges) == 96
    hold = plate.SimplySupported("boundary", kind=kind)
    solution = solved(mesh, sheet(), [hold], [plate.Pressure(1.0)])
    assert float(solution.deflection(0.0, 0.0)) == pytest.approx((5 + NU) / (64 * (1 + NU)), rel=5e-3)
    assert not solution.report.notes


def test_a_disk_on_a_mesh_that_splits_the_sides_of_its_polygon_is_held_on_the_circle() -> None:
    """The same disk on a finer mesh. Held along the sides it was 3 % too stiff."""
    mesh = plate.mesh(Point(0.0, 0.0).buffer(1.0, quad_segs=24), size=0.06)
    assert len(mesh.boundary_edges) == 2 * 96
    solution = solved(mesh, sheet(), [plate.SimplySupported("boundary")], [plate.Pressure(1.0)])
    assert float(solution.deflection(0.0, 0.0)) == pytest.approx((5 + NU) / (64 * (1 + NU)), rel=3e-3)
    assert not solution.report.notes
    clamped = solved(mesh, sheet(), [plate.Clamped("boundary")], [plate.Pressure(1.0)])
    # q R⁴ / 64 D; the polygon of 96 corners lies inside, by 7e-4 of the area, and w goes by the square of that
    assert float(clamped.deflection(0.0, 0.0)) == pytest.approx(1 / 64, rel=3e-3)
    assert not clamped.report.notes


def test_straight_edges_that_end_in_a_fillet_are_no_curve() -> None:
    """A stadium: straight sides are held straight, each side of a fillet is one edge of the mesh, and nothing is
    reported of polygons. Twice as fine, the fillets' sides are split, and the deflection stays."""
    outline = LineString([(0, 0), (2, 0)]).buffer(1.0, quad_segs=24)
    found = []
    for size in (0.08, 0.04):
        hold = plate.SimplySupported("boundary")
        solution = solved(plate.mesh(outline, size=size), sheet(), [hold], [plate.Pressure(1.0)])
        assert not solution.report.notes
        found.append(float(solution.deflection(1.0, 0.0)))
    assert found[0] == pytest.approx(found[1], rel=3e-3)  # as the disk


@pytest.mark.parametrize("outer", ["simple", "clamped"])
def test_an_annulus_deflects_as_in_closed_form(outer: str) -> None:
    """w = q r⁴/64 + C1 + C2 r² + C3 ln r + C4 r² ln r, held at R = 1, free at r = 0.4 (Timoshenko, article 17)."""
    inner = 0.4

    def rows(r: float) -> np.ndarray:
        """w, w', M_r and shear Q_r of the five functions; D = 1, signs turned."""
        log = np.log(r)
        w = [r**4 / 64, 1.0, r * r, log, r * r * log]
        first = [r**3 / 16, 0.0, 2 * r, 1 / r, 2 * r * log + r]
        second = [3 * r * r / 16, 0.0, 2.0, -1 / r**2, 2 * log + 3]
        moment = [s + NU * f / r for s, f in zip(second, first, strict=True)]
        shear = [r / 2, 0.0, 0.0, 0.0, 4 / r]  # d/dr of the Laplacian
        return np.array([w, first, moment, shear])

    at_outer, at_inner = rows(1.0), rows(inner)
    conditions = np.array([at_outer[0], at_outer[1 if outer == "clamped" else 2], at_inner[2], at_inner[3]])
    constants = np.linalg.solve(conditions[:, 1:], -conditions[:, 0])
    w_inner = float(at_inner[0] @ [1.0, *constants])
    ring = Point(0.0, 0.0).buffer(1.0, quad_segs=32).difference(Point(0.0, 0.0).buffer(inner, quad_segs=32))
    rim = LineString(Point(0.0, 0.0).buffer(1.0, quad_segs=32).exterior.coords)
    hold = plate.Clamped(rim) if outer == "clamped" else plate.SimplySupported(rim)
    solution = solved(plate.mesh(ring, size=0.06), sheet(), [hold], [plate.Pressure(1.0)])
    assert float(solution.deflection(inner, 0.0)) == pytest.approx(
        w_inner, rel=1e-2
    )  # polygons of 64 and 128 sides


def test_an_equilateral_triangle_deflects_as_in_closed_form() -> None:
    """Simply supported, height a: w at the centroid is q a⁴ / (972 D) (Timoshenko, article 71)."""
    corners = [(2 / 3, 0.0), (-1 / 3, 3**-0.5), (-1 / 3, -(3**-0.5))]
    solution = solved(
        plate.mesh(Polygon(corners), size=0.03),
        sheet(),
        [plate.SimplySupported("boundary")],
        [plate.Pressure(1.0)],
    )
    assert float(solution.deflection(0.0, 0.0)) == pytest.approx(1 / 972, rel=2e-3)
    # and M_x = M_y = (1 + ν) q a² / 54 there; the mean over the triangles around
    moments = solution.moments(np.linspace(-0.02, 0.02, 9), np.linspace(-0.015, 0.02, 9)).mean(axis=0)
    np.testing.assert_allclose(moments[:2], (1 + NU) / 54, rtol=2e-2)


def test_a_clamped_ellipse_deflects_as_in_closed_form() -> None:
    """w = q / (D (24/a⁴ + 24/b⁴ + 16/(a² b²))) (Timoshenko, article 71)."""
    a, b = 1.0, 0.6
    rotation = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    ellipse = Polygon(np.stack([a * np.cos(rotation), b * np.sin(rotation)], axis=1))
    solution = solved(
        plate.mesh(ellipse, size=0.04), sheet(), [plate.Clamped("boundary")], [plate.Pressure(1.0)]
    )
    expected = 1 / (24 / a**4 + 24 / b**4 + 16 / (a * b) ** 2)
    assert float(solution.deflection(0.0, 0.0)) == pytest.approx(expected, rel=3e-3)


def polygon_centre(n: int) -> float:
    """w at the centre of a simply supported regular polygon under uniform pressure, circumradius 1, D = 1.

    Marcus: -ΔM = q and -Δw = M / D, both zero on straight edges. M and w are sums of a particular solution and harmonic
    functions of the polygon's symmetry, fitted along half an edge: Trefftz's method.
    """
    waves = n * np.arange(12.0)
    y = np.tan(np.pi / n) * np.sin(np.linspace(0.0, np.pi / 2, 200))  # denser towards the corner
    r, theta = np.cos(np.pi / n) * np.hypot(1.0, y), np.arctan(y)
    harmonic = r[:, None] ** waves * np.cos(waves * theta[:, None])
    of_moment = np.linalg.lstsq(harmonic, r**2 / 4, rcond=None)[0]
    particular = r**4 / 64 - (harmonic * r[:, None] ** 2 / (4 * (waves + 1))) @ of_moment
    return float(np.linalg.lstsq(harmonic, -particular, rcond=None)[0][0])


@pytest.mark.parametrize("kind", ["hard", "soft"])
@pytest.mark.parametrize("n", [3, 4, 5, 6, 8])
@pytest.mark.quick("3-*", "6-*")
def test_simply_supported_polygons_deflect_alike_hard_and_soft(n: int, kind: str) -> None:
    """Slopes go to zero in a blunt corner as r^(π/angle - 1), slower the blunter it is, and so does the error: 2 % for
    eight corners at this size. (Both slopes held in every corner would cost 8 %.)"""
    rotation = 2 * np.pi * np.arange(n) / n
    polygon = Polygon(np.stack([np.cos(rotation), np.sin(rotation)], axis=1))
    hold = plate.SimplySupported("boundary", kind=kind)
    solution = solved(plate.mesh(polygon, size=0.04), sheet(), [hold], [plate.Pressure(1.0)])
    assert float(solution.deflection(0.0, 0.0)) == pytest.approx(
        polygon_centre(n), rel=2e-2 if n > 6 else 5e-3
    )


@pytest.mark.parametrize("kind", ["hard", "soft"])
def test_a_skew_plate_deflects_as_morley_found(kind: str) -> None:
    """Rhomb of 30°, simply supported, uniform: 0.408e-3 q a⁴/D (L. S. D. Morley, Skew Plates and Structures, 1963).

    Moments are infinite in the two blunt corners, and slopes go to zero there as r^0.2: 2 % at this size.
    """
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    rhomb = Polygon([(0, 0), (1, 0), (1 + c, s), (c, s)])
    hold = plate.SimplySupported("boundary", kind=kind)
    solution = solved(plate.mesh(rhomb, size=0.015), sheet(), [hold], [plate.Pressure(1.0)])
    assert float(solution.deflection((1 + c) / 2, s / 2)) == pytest.approx(0.408e-3, rel=2e-2)


# --- strips, laminates -----------------------------------------------------------------------------------------------


def test_an_elastic_hinge_turns_by_its_moment_over_its_stiffness() -> None:
    """A beam of ν = 0 on a hinge of stiffness k per width: P L³ / 3D + P L² / k at its end."""
    edge = sides(2.0, 0.5)
    mesh = plate.grid(2.0, 0.5, 24, 6, pattern="criss-cross")
    stiffness, force = 3.0, 1.5
    solution = solved(
        mesh, sheet(nu=0.0), [plate.Hinged(edge["left"], stiffness)], [plate.EdgeLoad(edge["right"], force)]
    )
    tip = force * 2.0**3 / 3 + force * 2.0**2 / stiffness
    np.testing.assert_allclose(solution.deflection([2.0] * 3, [0.0, 0.2, 0.5]), tip, rtol=1e-3)
    assert float(solution.slope(0.0, 0.25)[0]) == pytest.approx(force * 2.0 / stiffness, rel=1e-6)


@pytest.mark.parametrize("family", ["one-diagonal", "jittered", "delaunay"])
@pytest.mark.parametrize("angles", [(0.0, 90.0), (30.0, -30.0), (10.0, 50.0, -70.0)])
def test_a_free_laminate_under_pulls_and_moments_is_as_laminate_theory_says(
    angles: tuple[float, ...], family: str
) -> None:
    """Uniform N_x, N_y, M_x and M_y along the edges: strain and curvature are those of the stiffness' inverse, exactly,
    on any mesh, as DKT and CST pass the patch test."""
    laminate = stack(CFRP, 50e-6, *angles)
    edge = sides(10e-3, 6e-3)
    pull, moment = np.array([30.0, -10.0, 0.0]), np.array([4e-4, 1e-3, 0.0])
    loads = [
        plate.EdgeLoad(edge["right"], (pull[0], 0.0, 0.0)),
        plate.EdgeLoad(edge["left"], (-pull[0], 0.0, 0.0)),
        plate.EdgeLoad(edge["top"], (0.0, pull[1], 0.0)),
        plate.EdgeLoad(edge["bottom"], (0.0, -pull[1], 0.0)),
        *(plate.EdgeMoment(edge[side], moment[0]) for side in ("left", "right")),
        *(plate.EdgeMoment(edge[side], moment[1]) for side in ("bottom", "top")),
    ]
    mesh = rectangle_mesh(family, 5, 10e-3, 6e-3)
    solution = solved(mesh, laminate, [], loads)
    at = mesh.corners.mean(axis=1).T
    expected = np.linalg.solve(laminate.ABD, np.concatenate([pull, moment]))
    strain, curvature = solution.strain(*at), solution.curvature(*at)
    for found, values in ((strain, expected[:3]), (curvature, expected[3:])):
        np.testing.assert_allclose(
            found, np.broadcast_to(values, found.shape), rtol=0, atol=1e-9 * np.abs(values).max()
        )


def test_a_bimetal_curls_as_timoshenko_found() -> None:
    """Two layers of one ν: κ = 6 Δα ΔT (1 + m)² / (h (3 (1 + m)² + (1 + m n)(m² + 1/(m n)))), m and n the ratios of
    thickness and modulus, lower over upper (S. Timoshenko, J. Opt. Soc. Am. 11, 1925)."""
    lower = plate.Material.isotropic(E=140e9, nu=NU, density=8000, alpha=1e-6)
    upper = plate.Material.isotropic(E=100e9, nu=NU, density=8000, alpha=18e-6)
    laminate = plate.Laminate([plate.Ply(lower, 0.4e-3), plate.Ply(upper, 0.6e-3)])
    m, n, h, warmer = 0.4 / 0.6, 1.4, 1e-3, 100.0
    kappa = 6 * 17e-6 * warmer * (1 + m) ** 2 / (h * (3 * (1 + m) ** 2 + (1 + m * n) * (m * m + 1 / (m * n))))
    mesh = rectangle_mesh("delaunay", 5, 0.02, 0.02)
    solution = solved(mesh, laminate, [], [plate.Temperature(warmer)])
    found = solution.curvature(*mesh.corners.mean(axis=1).T)
    # the upper face grows longer: hollow side down, which is a positive κ, -w_xx
    np.testing.assert_allclose(found[:, :2], kappa, rtol=1e-9)


def test_weight_is_the_pressure_of_its_own_mass() -> None:
    laminate, edges = stack(CFRP, 1e-3, 0.0, 90.0, 0.0), held("CSFS", 0.3, 0.2)
    mesh = rectangle_mesh("delaunay", 8, 0.3, 0.2)
    weight = solved(mesh, laminate, edges, [plate.SelfWeight()])
    pressure = solved(mesh, laminate, edges, [plate.Pressure(-9.81 * 1600 * 3e-3)])
    np.testing.assert_allclose(
        weight.values, pressure.values, rtol=0, atol=1e-12 * np.abs(weight.values).max()
    )


def test_reactions_of_a_square_carry_its_load() -> None:
    """Half of the load on two opposite edges each, by symmetry, on a mesh that is symmetric about the centre."""
    mesh = plate.grid(1.0, 1.0, 12, 12, pattern="criss-cross")
    solution = solved(mesh, sheet(), held("SSSS"), [plate.Pressure(4.0)])
    assert sum(float(reaction.force[2]) for reaction in solution.reactions) == pytest.approx(-4.0, rel=1e-9)

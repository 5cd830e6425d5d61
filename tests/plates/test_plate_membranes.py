"""Plates that stretch: membranes against problems in print and in closed form, by every membrane element."""

import numpy as np
import pytest
from shapely.geometry import LineString, Point, box

from lamc import plate
from tests.support.ctools import needs_cc
from tests.support.plate_meshes import rectangle_mesh, sides, solved

pytestmark = needs_cc

TRIANGLES, SQUARES = ("cst", "lst"), ("q4", "q8", "q9", "q12")


def foil(E: float, nu: float) -> plate.Laminate:
    """1 m thick, so that N is stress."""
    return plate.Laminate([plate.Ply(plate.Material.isotropic(E, nu, density=1.0), 1.0)])


def cook_mesh(n: int, pattern: str) -> plate.Mesh:
    """Cook's membrane: corners (0, 0), (48, 44), (48, 60), (0, 44)."""
    unit = plate.grid(1.0, 1.0, n, n, pattern=pattern)
    x, y = unit.points.T
    return plate.Mesh(np.stack([48 * x, 44 * x + (44 - 28 * x) * y], axis=1), unit.cells)


@pytest.mark.parametrize(
    ("element", "n"), [("lst", 24), ("q4", 64), ("q8", 16), ("q9", 16), ("q12", 10), ("cst", 96)]
)
@pytest.mark.quick("q8-16", "lst-24", "cst-96")
def test_cooks_membrane_moves_as_published(element: str, n: int) -> None:
    """E = 1, ν = 1/3, shear of 1 in all along the right edge: 23.96 up at its middle (R. D. Cook, J. Struct. Div. ASCE
    100, 1974; 23.9642 from meshes of later authors). 1 %: a corner with infinite stress makes convergence slow."""
    mesh = cook_mesh(n, "squares" if element in SQUARES else "one-diagonal")
    left, right = LineString([(0, 0), (0, 44)]), LineString([(48, 44), (48, 60)])
    load = plate.EdgeLoad(right, (0.0, 1.0 / 16.0, 0.0))
    solution = solved(mesh, foil(1.0, 1 / 3), [plate.Clamped(left)], [load], element)
    assert float(solution.displacement(48.0, 52.0)[1]) == pytest.approx(23.964, rel=1e-2)


@pytest.mark.parametrize("element", TRIANGLES + SQUARES)
def test_constant_stress_passes_where_sides_are_not_parallel(element: str) -> None:
    """Pulled along x: N_x = 1 everywhere, and the width shrinks by ν."""
    if element in SQUARES:
        grid = plate.grid(2.0, 1.0, 4, 3, pattern="squares")
        x, y = grid.points.T
        bump = 0.15 * np.sin(np.pi * x / 2) * np.sin(np.pi * y)
        mesh = plate.Mesh(np.stack([x + bump, y - 0.5 * bump], axis=1), grid.cells)
    else:
        mesh = rectangle_mesh("delaunay", 5, 2.0, 1.0)
    edge = sides(2.0, 1.0)
    hold = [plate.Support(edge["left"], ("u",)), plate.Support(Point(0, 0), ("v",))]
    pull = plate.EdgeLoad(edge["right"], (1.0, 0.0, 0.0))
    solution = solved(mesh, foil(10.0, 0.25), hold, [pull], element)
    at = mesh.corners.mean(axis=1).T
    np.testing.assert_allclose(
        solution.forces(*at), np.broadcast_to([1.0, 0.0, 0.0], (len(mesh.cells), 3)), rtol=0.0, atol=1e-10
    )
    np.testing.assert_allclose(solution.displacement(2.0, 1.0)[:2], [0.2, -0.025], rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("element", ["q8", "q9", "q12", "lst"])
def test_a_beam_under_pure_bending_is_exact_for_quadratics(element: str) -> None:
    """u = κ x y, v = -κ x²/2 - ν κ y²/2 is quadratic: prescribed on the ends, it is met everywhere."""
    kappa, nu = 1e-3, 0.3
    mesh = plate.grid(
        4.0, 1.0, 3, 2, pattern="one-diagonal" if element == "lst" else "squares", origin=(0.0, -0.5)
    )
    exact_u = lambda x, y: kappa * x * y  # noqa: E731  a formula
    exact_v = lambda x, y: -kappa * (x * x + nu * y * y) / 2  # noqa: E731
    ends = LineString([(0, -0.5), (0, 0.5)]).union(LineString([(4, -0.5), (4, 0.5)]))
    supports = [plate.Support(ends, ("u",), exact_u), plate.Support(ends, ("v",), exact_v)]
    solution = solved(mesh, foil(1.0, nu), supports, [], element)
    x, y = np.meshgrid(np.linspace(0.1, 3.9, 7), np.linspace(-0.45, 0.45, 5))
    found = solution.displacement(x, y)
    np.testing.assert_allclose(found[..., 0], exact_u(x, y), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(found[..., 1], exact_v(x, y), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(solution.forces(x, y)[..., 0], kappa * y, rtol=0.0, atol=1e-12)


def test_a_hole_concentrates_stress_as_published() -> None:
    """A strip with a hole of a tenth of its width: 3.035 times the stress far away (Peterson's Stress Concentration
    Factors, chart 4.1, after Howland 1930). 2 %: the polygon has 64 sides, and strains are linear in each triangle."""
    width, radius = 10.0, 0.5
    hole = Point(0.0, 0.0).buffer(radius, quad_segs=16)
    near = Point(0.0, 0.0).buffer(2.0, quad_segs=8).difference(hole)
    quarter = box(0.0, 0.0, 10.0, width / 2)
    mesh = plate.mesh(
        quarter.difference(hole), size=0.8, regions={"near": near.intersection(quarter)}, sizes={"near": 0.06}
    )
    supports = [
        plate.Support(LineString([(0, radius), (0, width / 2)]), ("u",)),
        plate.Support(LineString([(radius, 0), (10, 0)]), ("v",)),
    ]
    pull = plate.EdgeLoad(LineString([(10, 0), (10, width / 2)]), (1.0, 0.0, 0.0))
    laminate = foil(1.0, 0.3)
    solution = solved(mesh, dict.fromkeys(mesh.region_names, laminate), supports, [pull], "lst")
    assert float(solution.forces(0.0, radius)[0]) == pytest.approx(3.035, rel=2e-2)

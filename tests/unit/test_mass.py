"""Mass properties against closed forms, invariances and plain numeric quadrature."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import affinity
from shapely.geometry import Point, Polygon, box

from lamc.basics.errors import DesignError
from lamc.design.mass import body_properties, moments_of, polygon_moments
from lamc.records.mechanism import Slab
from tests.support.quick import tries

# Sums of a few terms of like size, each rounded once: some ulp.
ROUND_OFF = 1e-13


def plate(polygon: Polygon, bottom: float = 0.0, top: float = 0.002) -> Slab:
    return Slab(polygon, bottom, top)


def close(actual: object, expected: object, tolerance: float, scale: float) -> None:
    np.testing.assert_allclose(actual, expected, rtol=0.0, atol=tolerance * scale)  # type: ignore[arg-type]


def test_rectangle_is_the_textbook_cuboid() -> None:
    a, b, t, rho = 0.3, 0.07, 0.004, 1600.0
    mass, com, inertia = body_properties([(plate(box(1.0, -2.0, 1.0 + a, -2.0 + b), 0.01, 0.01 + t), rho)])
    m = rho * a * b * t
    assert mass == pytest.approx(m, rel=1e-12)
    close(com, [1.0 + a / 2, -2.0 + b / 2, 0.01 + t / 2], ROUND_OFF, 2.0)
    expected = m / 12 * np.diag([b * b + t * t, a * a + t * t, a * a + b * b])
    close(inertia, expected, 1e-12, expected.max())


def test_right_triangle_has_its_closed_form_moments() -> None:
    b, h = 0.6, 0.2
    moments = polygon_moments(Polygon([(0, 0), (b, 0), (0, h)]))
    assert moments.area == pytest.approx(b * h / 2, rel=1e-15)
    close([moments.x, moments.y], [b / 3, h / 3], ROUND_OFF, b)
    close(
        [moments.xx, moments.yy, moments.xy],
        [h * b**3 / 36, b * h**3 / 36, -(b**2) * h**2 / 72],
        ROUND_OFF,
        b**4,
    )


def regular(radius: float, n: int) -> Polygon:
    angles = 2 * math.pi * np.arange(n) / n
    return Polygon(np.column_stack([radius * np.cos(angles), radius * np.sin(angles)]))


def regular_moments(radius: float, n: int) -> tuple[float, float]:
    """Area and ∫x² dA of a regular n-gon, closed form."""
    area = n / 2 * radius**2 * math.sin(2 * math.pi / n)
    return area, area * radius**2 / 24 * (4 + 2 * math.cos(2 * math.pi / n))


@pytest.mark.parametrize("n", [6, 1000])
def test_annulus_is_the_difference_of_two_regular_polygons(n: int) -> None:
    outer, inner = regular(0.05, n), regular(0.03, n)
    moments = polygon_moments(Polygon(outer.exterior.coords, [inner.exterior.coords]))
    (area_o, xx_o), (area_i, xx_i) = regular_moments(0.05, n), regular_moments(0.03, n)
    assert moments.area == pytest.approx(area_o - area_i, rel=1e-12)
    close([moments.xx, moments.yy, moments.xy], [xx_o - xx_i, xx_o - xx_i, 0.0], 1e-12, xx_o)


def test_a_polygon_of_many_sides_tends_to_the_disc() -> None:
    moments = polygon_moments(regular(1.0, 200_000))
    # The n-gon's area falls short of the disc's by (2π/n)²/6 relatively: 1.6e-10 here.
    assert moments.area == pytest.approx(math.pi, rel=1e-9)
    assert moments.xx == pytest.approx(math.pi / 4, rel=1e-9)


@pytest.mark.parametrize("distance", [1.0, 1e3, 1e6])
def test_distance_from_the_origin_costs_no_digits(distance: float) -> None:
    # Coordinates are multiples of 2^-20 m, so that the shifted polygon is exactly the same one.
    unit = 2.0**-20
    shape = Polygon([(0, 0), (1000 * unit, 0), (900 * unit, 30 * unit), (20 * unit, 70 * unit)])
    near = body_properties([(plate(shape), 1200.0)])
    far = body_properties([(plate(affinity.translate(shape, distance, -distance)), 1200.0)])
    assert far[0] == pytest.approx(near[0], rel=1e-12)
    close(far[1] - near[1], [distance, -distance, 0.0], 1e-15, distance)
    # The box's middle is itself a multiple of 2^-21: the last bits differ by an ulp or two at most.
    close(far[2], near[2], 1e-12, np.abs(near[2]).max())


def test_ring_direction_and_start_do_not_matter() -> None:
    outer = [(0.0, 0.0), (0.3, 0.01), (0.31, 0.2), (-0.05, 0.17)]
    hole = [(0.1, 0.05), (0.2, 0.05), (0.15, 0.12)]
    first = polygon_moments(Polygon(outer, [hole]))
    second = polygon_moments(Polygon(outer[2:] + outer[:2], [hole[::-1]]))
    third = polygon_moments(Polygon(outer[::-1], [hole]))
    assert first == second == third


star = st.lists(st.floats(0.2, 1.0), min_size=3, max_size=12)


def star_polygon(radii: Sequence[float]) -> Polygon:
    angles = 2 * math.pi * np.arange(len(radii)) / len(radii)
    return Polygon(np.column_stack([np.cos(angles), np.sin(angles)]) * np.array(radii)[:, None])


@settings(max_examples=tries(60), deadline=None)
@given(star, star, st.floats(-3, 3), st.floats(-5, 5), st.floats(-5, 5))
def test_inertia_turns_and_shifts_with_the_body(
    low: list[float], high: list[float], turn: float, x: float, y: float
) -> None:
    polygons = [star_polygon(low), affinity.translate(star_polygon(high), 0.4, 0.1)]

    def build(shapes: Sequence[Polygon]) -> list[tuple[Slab, float]]:
        return [(Slab(shapes[0], 0.0, 0.1), 700.0), (Slab(shapes[1], 0.1, 0.4), 300.0)]

    mass, com, inertia = body_properties(build(polygons))
    moved = [affinity.translate(affinity.rotate(p, turn, (0, 0), use_radians=True), x, y) for p in polygons]
    mass2, com2, inertia2 = body_properties(build(moved))
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    assert mass2 == pytest.approx(mass, rel=1e-12)
    close(com2, rotation @ com + [x, y, 0.0], 1e-13, 10.0)
    # Rotated coordinates are rounded at 1e-16 of a position of size 10.
    close(inertia2, rotation @ inertia @ rotation.T, 1e-13, 10 * np.abs(inertia).max())


@settings(max_examples=tries(40), deadline=None)
@given(star, st.floats(0.1, 0.9), st.randoms())
def test_parts_add_up_to_the_whole(radii: list[float], cut: float, random: object) -> None:
    """Cutting a plate in two, sideways and through its thickness, leaves mass, centre and inertia alone."""
    shape = star_polygon(radii)
    whole = body_properties([(Slab(shape, 0.0, 0.3), 5.0)])
    left = shape.intersection(box(-2, -2, cut - 0.5, 2))
    right = shape.intersection(box(cut - 0.5, -2, 2, 2))
    pieces = [p for half in (left, right) for p in getattr(half, "geoms", [half]) if p.area > 0]
    plates = [(Slab(p, a, b), 5.0) for p in pieces for a, b in ((0.0, 0.3 * cut), (0.3 * cut, 0.3))]
    random.shuffle(plates)  # type: ignore[attr-defined]
    parts = body_properties(plates)
    assert parts[0] == pytest.approx(whole[0], rel=1e-12)
    close(parts[1], whole[1], 1e-13, 1.0)
    close(parts[2], whole[2], 1e-12, np.abs(whole[2]).max())


def test_moments_agree_with_midpoint_quadrature() -> None:
    shape = Polygon(
        [(0, 0), (1, 0.1), (0.9, 1), (0.4, 0.5), (0.05, 0.9)], [[(0.5, 0.2), (0.7, 0.2), (0.6, 0.4)]]
    )
    n = 600
    grid = (np.arange(n) + 0.5) / n
    x, y = np.meshgrid(grid, grid)

    inside = shapely.contains_xy(shape, x.ravel(), y.ravel())
    x, y = x.ravel()[inside], y.ravel()[inside]
    cell = 1.0 / n**2
    m = polygon_moments(shape)
    # Cells on the outline are all in or all out: an error of about one part in n^1.5.
    assert m.area == pytest.approx(len(x) * cell, rel=1e-3)
    close([m.x, m.y], [x.mean(), y.mean()], 1e-3, 1.0)
    dx, dy = x - x.mean(), y - y.mean()
    close([m.xx, m.yy, m.xy], np.array([dx @ dx, dy @ dy, dx @ dy]) * cell, 1e-3, m.area)


def test_a_body_without_density_has_a_centre_of_volume() -> None:
    mass, com, inertia = body_properties([(plate(box(0, 0, 2, 4)), 0.0)])
    assert mass == 0.0
    assert com.tolist() == [1.0, 2.0, 0.001]
    assert not inertia.any()


@pytest.mark.parametrize(
    ("plates", "fragment"),
    [
        ([], "no plates"),
        ([(Slab(box(0, 0, 1, 1), 1.0, 1.0), 1.0)], "top must lie above"),
        ([(Slab(box(0, 0, 1, 1), 0.0, math.nan), 1.0)], "top must lie above"),
        ([(plate(box(0, 0, 1, 1)), -1.0)], "density -1.0"),
        ([(plate(box(0, 0, 1, 1)), math.nan)], "density nan"),
        ([(plate(Polygon()), 1.0)], "empty polygon"),
        ([(plate(Polygon([(0, 0), (1, 1), (2, 2)])), 1.0)], "no area"),
        ([(plate(Polygon([(0, 0), (1, 0), (math.inf, 2)])), 1.0)], "not finite"),
    ],
)
def test_impossible_plates_are_refused(plates: list[tuple[Slab, float]], fragment: str) -> None:
    with pytest.raises(DesignError, match=fragment):
        body_properties(plates)


def test_a_disc_with_a_hole_off_centre_leans_away_from_it() -> None:
    disc, hole = regular(1.0, 64), affinity.translate(regular(0.25, 64), 0.5, 0.0)
    m = polygon_moments(Polygon(disc.exterior.coords, [hole.exterior.coords]))
    area_d, area_h = disc.area, hole.area
    assert m.x == pytest.approx(-0.5 * area_h / (area_d - area_h), rel=1e-12)
    assert not Polygon(disc.exterior.coords, [hole.exterior.coords]).contains(Point(0.5, 0.0))


def test_moments_at_once_are_those_of_each_polygon() -> None:
    """To the last bit, so that a body's mass does not depend on which others are weighed with it."""
    holes = [[(1.1, 1.1), (1.1, 1.9), (1.9, 1.5)]]
    shapes = [
        Polygon([(0, 0), (3, 0.1), (2.7, 2.9), (0.2, 3.1)], holes),
        box(0.1, 0.2, 0.3, 1e3),
        regular(1.0, 33),
    ]
    together = moments_of(shapes)
    assert together == [polygon_moments(shape) for shape in shapes]
    assert together[::-1] == moments_of(shapes[::-1])

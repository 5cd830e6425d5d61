"""Any polygon is filled exactly, with good angles, the sizes asked for, and the same mesh every time."""

import hashlib
import itertools
import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, assume, example, given, note, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from shapely.affinity import rotate, scale, translate
from shapely.geometry import LineString, MultiPolygon, Point, Polygon, box

from lamc import plate
from lamc.basics.errors import DesignError, LamcError
from lamc.plates.meshing.mesh import Mesh
from lamc.readers.load import load
from lamc.records.design import Design
from tests.support.quick import tries

# Areas of thousands of triangles, each with round-off of a few parts in 1e16, added up.
EXACT = 1e-12
FEW = settings(max_examples=tries(40), deadline=None, suppress_health_check=[HealthCheck.too_slow])
LINKS = {
    "left": box(0, 0, 10e-3, 5e-3),
    "hinge": box(10e-3, 0, 10.1e-3, 5e-3),
    "right": box(10.1e-3, 0, 20.1e-3, 5e-3),
}
FOLDED = box(0, 0, 20.1e-3, 5e-3)
PLATE = box(0, 0, 1, 1).difference(Point(0.3, 0.4).buffer(0.1)).difference(Point(0.7, 0.6).buffer(0.15))


def angles(mesh: Mesh) -> np.ndarray:
    """Of all cells, degrees, shape (m, 3)."""
    ahead = np.roll(mesh.corners, -1, axis=1) - mesh.corners
    behind = np.roll(mesh.corners, 1, axis=1) - mesh.corners
    cross = ahead[..., 0] * behind[..., 1] - ahead[..., 1] * behind[..., 0]
    return np.degrees(np.arctan2(cross, np.sum(ahead * behind, axis=2)))


def edge_lengths(mesh: Mesh) -> np.ndarray:
    ends = mesh.points[mesh.edges]
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)


def check_fills(mesh: Mesh, polygon: Polygon | MultiPolygon, slack: float) -> None:
    """Area, border and topology of `mesh` are those of the polygon; points on the border to within `slack`, m."""
    assert mesh.areas.min() > 0.0
    assert mesh.areas.sum() == pytest.approx(polygon.area, rel=EXACT)
    cell, side = mesh.boundary_edges.T
    ends = mesh.points[np.stack([mesh.cells[cell, side], mesh.cells[cell, (side + 1) % 3]], axis=1)]
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(polygon.length, rel=EXACT)
    middles = shapely.points(ends.mean(axis=1))
    assert shapely.distance(polygon.boundary, middles).max() <= slack
    given_corners = shapely.get_coordinates(polygon)
    to_corner = cKDTree(mesh.points).query(given_corners)[0]
    nearest_two = cKDTree(np.unique(given_corners, axis=0)).query(given_corners, 2)[0][:, 1]
    assert to_corner.max() <= 2e-9 * max(nearest_two.max(), np.ptp(given_corners, axis=0).max())
    assert (to_corner[nearest_two > 1e-8] == 0.0).all()  # nearer ones may have become one
    pieces = list(polygon.geoms) if isinstance(polygon, MultiPolygon) else [polygon]
    euler = len(mesh.points) - len(mesh.edges) + len(mesh.cells)
    assert euler == sum(1 - len(piece.interiors) for piece in pieces)


@pytest.mark.parametrize("size", [0.5, 0.1, 0.02])
@pytest.mark.parametrize("name", ["square", "holes", "ell", "two pieces"])
def test_plates_are_filled_with_good_triangles(name: str, size: float) -> None:
    polygon = {
        "square": box(0, 0, 1, 1),
        "holes": PLATE,
        "ell": box(0, 0, 1, 1).difference(box(0.5, 0.5, 2, 2)),
        "two pieces": MultiPolygon([box(0, 0, 1, 1), box(1.1, 0, 2, 1)]),
    }[name]
    mesh = plate.mesh(polygon, size)
    check_fills(mesh, polygon, 1e-15)  # half a unit in the last place of points on slanted segments
    assert mesh.region_names == ("",)
    assert angles(mesh).min() > 25.0
    assert edge_lengths(mesh).max() < 1.6 * size
    if name == "square":
        assert 0.8 * size < edge_lengths(mesh).mean() < size


def test_a_hinge_strip_between_links_is_fine_and_conforms() -> None:
    mesh = plate.mesh(FOLDED, 1e-3, regions=LINKS, sizes={"hinge": 50e-6})
    check_fills(mesh, FOLDED, 1e-17)
    assert mesh.region_names == ("left", "hinge", "right")
    for index, area in enumerate(LINKS.values()):
        assert mesh.areas[mesh.regions == index].sum() == pytest.approx(area.area, rel=EXACT)
        inside = shapely.points(mesh.corners[mesh.regions == index].mean(axis=1))
        assert shapely.contains(area, inside).all()
    assert angles(mesh).min() > 25.0
    used = np.unique(mesh.cell_edges[mesh.regions == 1])
    assert edge_lengths(mesh)[used].max() < 1.6 * 50e-6
    assert edge_lengths(mesh).max() > 0.8e-3  # grown again away from the strip
    assert len(mesh.cells) < 5000  # all at the strip's size: 80 000


def test_a_hinge_strip_without_a_size_of_its_own_is_still_well_shaped() -> None:
    mesh = plate.mesh(FOLDED, 1e-3, regions=LINKS)
    check_fills(mesh, FOLDED, 1e-17)
    assert angles(mesh).min() > 25.0
    assert len(mesh.cells) < 2000


def test_rest_of_the_plate_is_a_region_without_name() -> None:
    patch = Point(0.5, 0.5).buffer(0.2)
    mesh = plate.mesh(box(0, 0, 1, 1), 0.1, regions={"patch": patch}, sizes={"": 0.2, "patch": 0.02})
    assert mesh.region_names == ("", "patch")
    assert mesh.areas[mesh.regions == 1].sum() == pytest.approx(patch.area, rel=EXACT)
    rim = mesh.points[np.unique(mesh.cells[mesh.regions == 0])]
    assert len(rim) < len(mesh.points)
    assert edge_lengths(mesh).max() > 0.15


def test_borders_that_differ_by_round_off_become_one() -> None:
    third = 1.0 / 3.0
    left = box(0, 0, third, 1)
    right = box(third + 1e-13, 0.25, 1, 0.75)  # its corners lie on the left one's side, but for round-off
    mesh = plate.mesh(box(0, 0, 1, 1), 0.1, regions={"left": left, "right": right})
    assert edge_lengths(mesh).min() > 0.02
    assert mesh.areas[mesh.regions == 2].sum() == pytest.approx(right.area, rel=1e-12)
    assert angles(mesh).min() > 25.0


def test_sharp_corners_keep_their_angle_and_spoil_no_other() -> None:
    needle = Polygon([(0, 0), (1, 0), (1, 0.05)])
    mesh = plate.mesh(needle, 0.05)
    check_fills(mesh, needle, 1e-16)
    sharp = math.degrees(math.atan(0.05))
    assert np.sum(angles(mesh) < 0.99 * sharp) == 0
    away = mesh.corners.mean(axis=1)[:, 0] > 0.3
    assert np.degrees(np.pi / 180 * angles(mesh)[away]).min() > 20.0


def test_short_segments_are_kept_and_sizes_grow_from_them() -> None:
    notched = Polygon([(0, 0), (0.5, 0), (0.5, 1e-4), (0.5001, 1e-4), (0.5001, 0), (1, 0), (1, 1), (0, 1)])
    mesh = plate.mesh(notched, 0.1)
    check_fills(mesh, notched, 1e-16)
    assert angles(mesh).min() > 25.0
    assert len(mesh.cells) < 3000
    fine = plate.mesh(notched, 0.1, grading=0.1)
    assert len(fine.cells) > len(mesh.cells)


def test_every_layer_of_a_popupcad_drawing_is_meshed(shared: Path) -> None:
    design = load(shared / "designs" / "popupcad" / "pendulum.cad")
    assert isinstance(design, Design)
    for layer in design.layers:
        low_x, _, high_x, _ = layer.geometry.bounds
        mesh = plate.mesh(layer.geometry, (high_x - low_x) / 40.0)
        check_fills(mesh, layer.geometry, 1e-15 * high_x)
        assert angles(mesh).min() > 25.0


def digest(mesh: Mesh) -> str:
    return hashlib.sha256(mesh.points.tobytes() + mesh.cells.tobytes() + mesh.regions.tobytes()).hexdigest()


def test_the_same_polygon_gives_the_same_mesh() -> None:
    first = plate.mesh(FOLDED, 1e-3, regions=LINKS, sizes={"hinge": 50e-6})
    again = plate.mesh(FOLDED, 1e-3, regions=dict(LINKS), sizes={"hinge": 50e-6})
    assert digest(first) == digest(again)


@pytest.mark.parametrize("power", [-20, 13])
def test_a_scaled_polygon_gives_the_scaled_mesh(power: int) -> None:
    factor = 2.0**power  # so that scaling is exact
    large = scale(PLATE, factor, factor, origin=(0, 0))
    one, other = plate.mesh(PLATE, 0.1), plate.mesh(large, 0.1 * factor)
    assert np.array_equal(one.cells, other.cells)
    assert np.array_equal(one.points * factor, other.points)


def test_far_from_the_origin_the_mesh_is_as_good() -> None:
    far = translate(PLATE, 2.0**20, -(2.0**20))
    mesh = plate.mesh(far, 0.1)
    assert angles(mesh).min() > 25.0
    assert mesh.areas.sum() == pytest.approx(PLATE.area, rel=1e-9)  # coordinates have lost six digits


BOW_TIE = Polygon([(0, 0), (1, 1), (1, 0), (0, 1)])
BAD: Mapping[str, tuple[dict[str, object], str]] = {
    "bow tie": ({"polygon": BOW_TIE}, r"Self-intersection\[0\.5 0\.5\]"),
    "empty": ({"polygon": Polygon()}, "polygon of a mesh is empty"),
    "line": ({"polygon": LineString([(0, 0), (1, 1)])}, "must be a shapely Polygon"),
    "text": ({"polygon": "square"}, "'square'; it must be a shapely Polygon"),
    "not finite": ({"polygon": Polygon([(0, 0), (1, 0), (1, float("inf"))])}, "not finite"),
    "flat": ({"polygon": Polygon([(0, 0), (1, 0), (2, 0)])}, "not a simple polygon"),
    "slit": (
        {"polygon": Polygon([(0, 0), (1, 0), (1, 1), (0.5, 1), (0.5, 0.5), (0.5, 1), (0, 1)])},
        "not a simple",
    ),
    "touching pieces": (
        {"polygon": MultiPolygon([box(0, 0, 1, 1), box(1, 1, 2, 2)])},
        r"single point \(1, 1\) m",
    ),
    "neck": (
        {"polygon": box(0, 0, 1, 1).difference(Polygon([(0.5, 0), (0.75, 0.5), (0.25, 0.5)])), "regions": {}},
        r"single point \(0\.5, 0\) m",
    ),
    "size zero": ({"size": 0.0}, "size of a mesh is 0 m"),
    "size negative": ({"size": -1.0}, "size of a mesh is -1 m"),
    "size nan": ({"size": math.nan}, "size of a mesh is nan"),
    "size text": ({"size": "fine"}, "size of a mesh is 'fine'"),
    "tiny size": ({"size": 1e-6}, r"about 3e\+12 triangles, .* GiB .* limit is 5000000"),
    "region size": ({"sizes": {"r": 0.0}}, "size of region 'r' is 0 m"),
    "unknown region": ({"sizes": {"q": 0.1}}, "'q', which is no region; regions are '', 'r'"),
    "outside": ({"regions": {"r": box(0.5, 0, 1.5, 1)}}, r"'r' reaches outside .* with 0\.5 m² of its 1 m²"),
    "overlap": (
        {"regions": {"r": box(0, 0, 0.6, 1), "s": box(0.5, 0, 1, 1)}},
        r"'r' and 's' overlap with 0\.1 m² around \(0\.55, 0\.5\)",
    ),
    "region crossed": ({"regions": {"r": BOW_TIE}}, "region 'r' is not a simple polygon"),
    "region name": ({"regions": {"": box(0, 0, 0.5, 1)}}, "name ''"),
    "regions list": ({"regions": [box(0, 0, 0.5, 1)]}, "give a polygon by name"),
    "grading": ({"grading": 5.0}, "grading of a mesh is 5"),
    "far away": ({"polygon": box(1e12, 0, 1e12 + 1, 1), "regions": {}}, r"lies 1e\+12 m from the origin"),
    "a line": ({"polygon": box(0, 0, 1, 1e-11), "regions": {}}, "thinner than 1e-09 of its length"),
    "limit": ({"size": 0.01, "limit": 1000}, r"about 3\.8e\+04 triangles.* limit is 1000"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_meshed_is_refused_with_the_reason(case: str) -> None:
    changed, message = BAD[case]
    arguments = {"polygon": box(0, 0, 1, 1), "size": 0.1, "regions": {"r": box(0, 0, 0.5, 1)}, **changed}
    with pytest.raises(DesignError, match=message):
        plate.mesh(**arguments)  # type: ignore[arg-type]


@st.composite
def stars(draw: st.DrawFn) -> Polygon:
    """Star-shaped outlines of 3 to 40 corners at any radius from 0.05 to 1, with round or square holes."""
    count = draw(st.integers(3, 40))
    radii = np.array(draw(st.lists(st.floats(0.05, 1.0), min_size=count, max_size=count)))
    rotation = 2.0 * np.pi * (np.arange(count) + draw(st.floats(0.0, 1.0))) / count
    outline = Polygon(np.stack([radii * np.cos(rotation), radii * np.sin(rotation)], axis=1))
    for _ in range(draw(st.integers(0, 3))):
        at = (draw(st.floats(-0.5, 0.5)), draw(st.floats(-0.5, 0.5)))
        radius = draw(st.floats(1e-3, 0.2))
        hole = (
            Point(at).buffer(radius, quad_segs=4)
            if draw(st.booleans())
            else box(-radius, -radius, radius, radius)
        )
        outline = outline.difference(rotate(hole, draw(st.floats(0, 90))))
    return outline


def least_given_angle(polygon: Polygon | MultiPolygon) -> float:
    """Between two segments of the outline at a corner, degrees, inside or out."""
    least = 180.0
    for piece in polygon.geoms if isinstance(polygon, MultiPolygon) else [polygon]:
        for ring in (piece.exterior, *piece.interiors):
            points = shapely.get_coordinates(ring)[:-1]
            ahead, behind = np.roll(points, -1, axis=0) - points, np.roll(points, 1, axis=0) - points
            cross = np.abs(ahead[:, 0] * behind[:, 1] - ahead[:, 1] * behind[:, 0])
            least = min(least, np.degrees(np.arctan2(cross, np.sum(ahead * behind, axis=1))).min())
    return float(least)


def smallest_feature(polygon: Polygon | MultiPolygon) -> float:
    """Shortest segment of the outline, or distance between two that do not meet, m."""
    points = shapely.get_coordinates(shapely.node(polygon.boundary))
    lines = shapely.linestrings(np.stack([points[:-1], points[1:]], axis=1))
    lines = lines[shapely.covered_by(lines, polygon.boundary.buffer(1e-9))]
    gaps = shapely.distance(lines[:, None], lines)
    return float(min(shapely.length(lines).min(), gaps[gaps > 0.0].min(initial=np.inf)))


def least_promised(corner: float) -> float:
    """Degrees. Beside a corner of less than 60° of the outline, two fifths of it. A kindred algorithm is proven to
    leave arcsin(√3/2 sin(corner / 2)), a tenth more: J. R. Shewchuk, Mesh generation for domains with small angles,
    16th Symposium on Computational Geometry (2000)."""
    return min(25.0, 0.4 * corner)


@FEW
@given(polygon=stars(), size=st.sampled_from([0.5, 0.1, 0.03]))
def test_any_star_with_holes_is_filled(polygon: Polygon, size: float) -> None:
    assume(polygon.area > 1e-3)
    note(shapely.to_wkt(polygon, rounding_precision=-1))
    try:
        mesh = plate.mesh(polygon, size)
    except DesignError as error:
        assert "touch at the single point" in str(error)  # noqa: PT017  the one thing that a star may do
        return
    check_fills(mesh, polygon, 1e-15)
    if smallest_feature(polygon) > 1e-3 * size:
        assert angles(mesh).min() > least_promised(least_given_angle(polygon))


@FEW
@given(polygon=stars(), cuts=st.lists(st.integers(-900, 900), min_size=1, max_size=4))
@example(polygon=box(-1, -1, 1, 1), cuts=[0, 1])
def test_regions_of_any_star_keep_their_area(polygon: Polygon, cuts: list[int]) -> None:
    assume(polygon.area > 1e-3)
    lines = [-2.0, *(cut / 1000 for cut in sorted(set(cuts))), 2.0]
    regions = {
        f"r{k}": polygon.intersection(box(a, -2, b, 2)) for k, (a, b) in enumerate(itertools.pairwise(lines))
    }
    regions = {n: r for n, r in regions.items() if isinstance(r, Polygon | MultiPolygon) and r.area > 1e-9}
    try:
        mesh = plate.mesh(polygon, 0.2, regions=regions)
    except LamcError as error:
        assert "touch at the single point" in str(error)  # noqa: PT017
        return
    for index, name in enumerate(mesh.region_names):
        if name:
            # Corners where cuts meet the outline are rounded to the last place, and so is the area; a plain sum of
            # thousands of cells would add a round-off of its own.
            area = math.fsum(mesh.areas[mesh.regions == index])
            assert area == pytest.approx(regions[name].area, abs=1e-14)


def on_edges(mesh: Mesh, line: LineString, within: float = 1e-12) -> float:
    """Length of the mesh's edges that lie on the line, within so many m of it, m."""
    return float(edge_lengths(mesh)[_lie_on(mesh, line, within)].sum())


def _lie_on(mesh: Mesh, line: LineString, within: float) -> np.ndarray:
    ends = mesh.points[mesh.edges]
    near = shapely.distance(line, shapely.linestrings(ends)) < within
    near &= shapely.distance(line, shapely.points(ends.mean(axis=1))) < within
    return near & (shapely.distance(line, shapely.points(ends)) < within).all(axis=1)


def uncovered(mesh: Mesh, line: LineString, within: float) -> float:
    """Length of a straight line along which no edge lies on it, within so many m, m."""
    ends = mesh.points[mesh.edges][_lie_on(mesh, line, within)]
    reached = missed = 0.0
    for start, end in sorted(np.sort(shapely.line_locate_point(line, shapely.points(ends)), axis=1).tolist()):
        missed += max(0.0, start - reached)
        reached = max(reached, end)
    return missed + max(0.0, line.length - reached)


def test_edges_follow_lines_and_corners_lie_on_points() -> None:
    regions = {"low": box(0, 0, 1, 0.4), "high": box(0, 0.4, 1, 1)}
    rib = LineString([(0.1, 0.1), (0.9, 0.77)])  # crosses the border of the regions and the next line
    seam = LineString([(0.0, 0.9), (0.8, 0.2)])
    points = [Point(0.3, 0.7), Point(0.31, 0.7), Point(0.5, 0.4)]
    mesh = plate.mesh(box(0, 0, 1, 1), 0.1, regions=regions, sizes={"low": 0.05}, follow=[rib, seam, *points])
    check_fills(mesh, box(0, 0, 1, 1), 1e-15)
    for line in (rib, seam):
        assert on_edges(mesh, line) == pytest.approx(line.length, rel=EXACT)
    for point in points:
        assert np.linalg.norm(mesh.points - point.coords[0], axis=1).min() == 0.0
    assert angles(mesh).min() > 25.0
    for name, area in regions.items():
        cells = mesh.regions == mesh.region_names.index(name)
        assert mesh.areas[cells].sum() == pytest.approx(area.area, rel=EXACT)


def test_what_a_mesh_cannot_follow_is_refused() -> None:
    square = box(0, 0, 1, 1)
    with pytest.raises(DesignError, match=r"LineString .* outside the polygon at \(1, 0\.5\)"):
        plate.mesh(square, 0.1, follow=[LineString([(0.5, 0.5), (1.5, 0.5)])])
    with pytest.raises(DesignError, match=r"Point .* outside the polygon at \(2, 0\)"):
        plate.mesh(square, 0.1, follow=[Point(2, 0)])
    with pytest.raises(DesignError, match="cannot follow <POLYGON"):
        plate.mesh(square, 0.1, follow=[box(0, 0, 0.5, 0.5)])


@FEW
@given(polygon=stars(), ends=st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=16))
def test_any_lines_inside_any_star_become_edges(polygon: Polygon, ends: list[float]) -> None:
    assume(polygon.area > 1e-3)
    rounded = np.round(ends, 3)[: len(ends) // 4 * 4].reshape(-1, 2, 2)
    inside = [LineString(pair).intersection(polygon) for pair in rounded.tolist() if pair[0] != pair[1]]
    lines = [part for part in inside if isinstance(part, LineString) and part.length > 1e-2]
    try:
        mesh = plate.mesh(polygon, 0.2, follow=lines)
    except DesignError as error:
        assert "touch at the single point" in str(error)  # noqa: PT017
        return
    assert mesh.areas.sum() == pytest.approx(polygon.area, rel=EXACT)
    for line in lines:
        # Its ends were rounded to the outline, and corners as near as 1e-9 of the extent, 2.9 m at most, are taken for
        # one, which moves an edge by as much. An edge beside it that is as short lies within that too.
        assert uncovered(mesh, line, within=3e-9) < 1e-8


STRIP = box(0, 0, 10e-3, 2e-3)
PIECES = {  # outlines with many equal lengths, where round-off decides ties
    "strip": ({"polygon": STRIP, "size": 0.5e-3}, {}),
    "folded": ({"polygon": FOLDED, "size": 1e-3}, {"regions": LINKS, "sizes": {"hinge": 50e-6}}),
    "moved, with ribs": (
        {"polygon": translate(STRIP, 0.013, -0.007), "size": 0.3e-3},
        {"follow": [LineString([(0.014, -0.007), (0.019, -0.005)]), Point(0.0215, -0.0063)]},
    ),
}


@pytest.mark.parametrize("unit", [1e-3, 3.0, 10.0, 1e3, 1e6])
@pytest.mark.parametrize("name", PIECES)
def test_the_unit_of_length_does_not_change_the_mesh(name: str, unit: float) -> None:
    (first, more), scaled = PIECES[name], partial(scale, xfact=unit, yfact=unit, origin=(0, 0))
    expected = plate.mesh(**first, **more)
    mesh = plate.mesh(
        scaled(first["polygon"]),
        first["size"] * unit,
        regions={key: scaled(value) for key, value in more.get("regions", {}).items()},
        sizes={key: value * unit for key, value in more.get("sizes", {}).items()},
        follow=[scaled(value) for value in more.get("follow", [])],
    )
    assert np.array_equal(mesh.cells, expected.cells)
    assert np.array_equal(mesh.regions, expected.regions)
    # round-off of coordinates, which are up to 0.03 on plates of 0.01
    np.testing.assert_allclose(mesh.points / unit, expected.points, rtol=0, atol=1e-16)


@pytest.mark.parametrize("name", PIECES)
def test_corners_are_kept_to_the_last_digit(name: str) -> None:
    first, more = PIECES[name]
    outlines = [first["polygon"], *more.get("regions", {}).values(), *more.get("follow", [])]
    points = set(map(tuple, plate.mesh(**first, **more).points.tolist()))
    assert {tuple(corner) for corner in shapely.get_coordinates(outlines).tolist()} <= points


def test_the_unit_of_length_does_not_change_an_answer() -> None:
    def tip(unit: float) -> float:  # over the unit; forces stay, so moduli and pressures are per square of it
        cloth = plate.Material(
            E1=350e9 / unit**2, E2=7e9 / unit**2, nu12=0.33, G12=5e9 / unit**2, density=1600.0
        )
        laminate = plate.Laminate([plate.Ply(cloth, 50e-6 * unit, angle) for angle in (45.0, 22.5, 45.0)])
        length, width = 10e-3 * unit, 2e-3 * unit
        held = [plate.Clamped(LineString([(0, 0), (0, width)]))]
        mesh = plate.mesh(box(0, 0, length, width), 0.5e-3 * unit)
        problem = plate.Problem(mesh, laminate, supports=held, loads=[plate.Pressure(1.0 / unit**2)])
        return float(plate.solve(problem).deflection(length, 0.5 * width)) / unit

    expected = tip(1.0)
    for unit in (1e-3, 3.0, 1e3, 1e6):
        assert abs(tip(unit) / expected - 1.0) < 1e-8  # digits of a solution at a condition of 1e8


def test_narrow_plates_are_counted_before_they_are_meshed() -> None:
    with pytest.raises(DesignError, match=r"about 1\.2e\+07 triangles.* limit is 5000000"):
        plate.mesh(box(0, 0, 1e4, 1e-3), 1.0)  # cells of 1 m would be fifty


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("size", [1e-12, 1e-30, 1e-200])
def test_hopeless_sizes_are_counted_without_overflow(size: float) -> None:
    with pytest.raises(DesignError, match=r"triangles.* limit is 5000000"):
        plate.mesh(box(0, 0, 1, 1), size)


def test_a_raised_limit_still_asks_for_memory() -> None:
    with pytest.raises(DesignError, match=r"about 3e\+12 triangles.*; .* GiB are free: take a larger size"):
        plate.mesh(box(0, 0, 1, 1), 1e-6, limit=10**15)

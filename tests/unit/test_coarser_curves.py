"""Curved creases of many corners: fewer, where facets that bend would be too many; told, and lines do not cross."""

import warnings
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

import lamc
from lamc.basics.errors import DesignWarning
from lamc.readers.drawings.coarser import coarser, curves_of
from lamc.records.mechanism import Array, Mechanism
from tests.support.quick import tries

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">'
RIM = '<rect x="0" y="0" width="100" height="100" fill="none" stroke="black"/>'


def ring(count: int, radius: float = 1.0, x: float = 0.0) -> Array:
    turns = 2.0 * np.pi * np.arange(count) / count
    return np.column_stack([x + radius * np.cos(turns), radius * np.sin(turns)])


def edges_of_ring(first: int, count: int) -> list[tuple[int, int]]:
    return [(first + k, first + (k + 1) % count) for k in range(count)]


def loaded(folder: Path, *shapes: str, large: bool = False) -> tuple[Mechanism, list[str]]:
    file = folder / "sheet.svg"
    file.write_text(HEAD + RIM + "".join(shapes) + "</svg>")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", DesignWarning)
        found = lamc.load(file, large=large)
    assert isinstance(found, Mechanism)
    return found, [str(each.message) for each in told]


def waves(count: int) -> list[str]:
    """Cubic curves from rim to rim, mountains and valleys by turns."""
    return [
        f'<path d="M0 {y:g} C 30 {y - 25:g} 60 {y + 25:g} 100 {y:g}" fill="none" stroke="{"red" if k % 2 else "blue"}" '
        'stroke-opacity="0.5"/>'
        for k, y in enumerate(np.linspace(20.0, 80.0, count))
    ]


def test_a_circle_keeps_what_its_tolerance_asks_for() -> None:
    """A chord over an angle 2a is off by 1 - cos(a)."""
    points = ring(400)
    edges = edges_of_ring(0, 400)
    curves = curves_of(points, edges, ["all"] * 400)
    assert sum(len(curve.corners) - 1 for curve in curves) == 400
    left = coarser(points, curves, 0.01)
    corners = points[sorted({v for edge, _ in left for v in edge})]
    lines = shapely.LinearRing(points[[a for (a, _) in edges]])
    polygon = shapely.Polygon(corners[np.argsort(np.arctan2(corners[:, 1], corners[:, 0]))])
    assert shapely.hausdorff_distance(polygon.exterior, lines, densify=0.01) <= 0.01
    widest = 2.0 * np.arccos(1.0 - 0.01)
    # At most twice the least there can be.
    assert 2.0 * np.pi / widest <= len(corners) <= 4.0 * np.pi / widest


def test_what_lines_are_for_and_where_they_meet_stays() -> None:
    points = np.column_stack([np.arange(7.0), [0.0, 1e-3, 0.0, 1e-3, 0.0, 1e-3, 0.0]])
    points = np.vstack([points, [4.0, 5.0]])
    edges = [*pairwise(range(7)), (4, 7)]
    alike = ["mountain", "mountain", "valley", "valley", "valley", "valley", "valley"]
    left = coarser(points, curves_of(points, edges, alike), 0.1)
    assert sorted(edge for edge, _ in left) == [(0, 2), (2, 4), (4, 6), (4, 7)]
    assert {edge: alike[of] for edge, of in left}[(0, 2)] == "mountain"


@settings(max_examples=tries(50), deadline=None)
@given(apart=st.floats(1e-3, 0.5), tolerance=st.floats(1e-3, 1.0), count=st.integers(8, 60))
def test_rings_beside_and_within_one_another_never_cross(apart: float, tolerance: float, count: int) -> None:
    """One around another and one beside it, nearer than the tolerance: they stay rings, and none crosses another."""
    rings = [ring(count), ring(count, 1.0 + apart), ring(count, 1.0, 2.0 + 2.0 * apart)]
    points = np.vstack(rings)
    starts = count * np.arange(3)
    edges = [
        e for start, each in zip(starts, rings, strict=True) for e in edges_of_ring(int(start), len(each))
    ]
    left = coarser(points, curves_of(points, edges, [0] * len(edges)), tolerance)
    lines = shapely.linestrings(points[np.array([edge for edge, _ in left])])
    first, second = shapely.STRtree(lines).query(lines, predicate="crosses")
    assert len(first) == len(second) == 0
    assert len({edge for edge, _ in left}) == len(left)
    degrees = np.bincount(np.array([edge for edge, _ in left]).ravel())
    assert set(degrees.tolist()) <= {0, 2}


def test_what_lies_within_a_curve_stays_within_it() -> None:
    """A small ring beside the rim of a large one, which an octagon would leave out without crossing it: amid a side of
    it, 0.924 from its middle, by 0.03."""
    away = 0.965 * np.exp(1j * np.pi / 8.0)
    points = np.vstack([ring(200), ring(12, 0.01) + np.array([away.real, away.imag])])
    edges = [*edges_of_ring(0, 200), *edges_of_ring(200, 12)]
    left = coarser(points, curves_of(points, edges, [0] * len(edges)), 0.9)
    rings = shapely.polygonize([shapely.LineString(points[list(edge)]) for edge, _ in left])
    small, *_, large = sorted(rings.geoms, key=lambda each: each.area)
    assert shapely.Polygon(large.exterior).contains(small)


def test_a_corner_on_the_chord_keeps_a_curve_off_it() -> None:
    """A shallow arc over two lines in one line: its chord would run along both, through the corner between them."""
    turns = np.linspace(0.0, np.pi, 21)
    points = np.vstack([np.column_stack([-np.cos(turns), 0.1 * np.sin(turns)]), [[0.0, 0.0], [0.0, -1.0]]])
    edges = [*pairwise(range(21)), (0, 21), (20, 21), (21, 22)]
    left = [edge for edge, _ in coarser(points, curves_of(points, edges, [0] * len(edges)), 0.2)]
    assert (0, 20) not in left
    assert {(0, 21), (20, 21), (21, 22)} < set(left)
    assert len(left) < len(edges)  # it has fewer corners all the same


@pytest.mark.slow
def test_a_sheet_of_curved_creases_has_fewer_corners_and_says_so(tmp_path: Path) -> None:
    sheet, told = loaded(tmp_path, *waves(6))
    note = next(note for note in told if "its curves have" in note)
    after, before = (
        int(note.split(word)[1].split()[0].rstrip(",")) for word in ("curves have", "corners of")
    )
    assert after <= 100 < before
    assert len(sheet.joints) < 3 * after  # a triangulation has 3 n - 3 - k edges, k of them on the rim
    area = sum(slab.polygon.area for body in sheet.bodies for slab in body.outline)
    assert area == pytest.approx(0.01, rel=1e-9)  # all of the sheet is still there
    whole, told = loaded(tmp_path, *waves(6), large=True)
    assert not any("its curves have" in note for note in told)
    assert len(whole.joints) > 2 * len(sheet.joints)


@pytest.mark.slow
def test_few_corners_and_straight_creases_stay_as_they_are(tmp_path: Path) -> None:
    _, told = loaded(tmp_path, *waves(1))
    assert not any("its curves have" in note for note in told)
    fine = "".join(f"{50 + 20 * x:.6f},{50 + 20 * y:.6f} " for x, y in ring(300))
    hole = f'<polygon points="{fine}" fill="none" stroke="black"/>'
    crease = '<polyline points="0,10 40,10 100,10" fill="none" stroke="blue" stroke-opacity="0.5"/>'
    sheet, told = loaded(tmp_path, hole, crease)
    assert not any("its curves have" in note for note in told)  # nothing bends: an outline costs nothing
    assert len(sheet.joints) == 1

"""Drawn material of a laminate: per layer, areas and the lines and points that have none.

In: shapely geometry in metres. Out: the same, combined layer by layer. popupCAD computes with lines too (a
hinge line is drawn, grown to a strip and cut out), which is why a sheet is more than its areas.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import shapely
from shapely.geometry import (
    GeometryCollection,
    LineString,
    MultiLineString,
    MultiPoint,
    MultiPolygon,
    Point,
    Polygon,
)
from shapely.geometry.base import BaseGeometry

from lamc.design.shapes import areas
from lamc.design.work import Account


@dataclass(frozen=True)
class Sheet:
    """What one layer holds."""

    areas: MultiPolygon = field(default_factory=MultiPolygon)
    lines: MultiLineString = field(default_factory=MultiLineString)
    points: MultiPoint = field(default_factory=MultiPoint)


def sheet_of(geometry: Sequence[BaseGeometry], account: Account) -> Sheet:
    """A sheet of drawn shapes, joined. Raises DesignError, as all here, where the file's overlays are too much work."""
    account.overlay(geometry, "the shapes")
    polygons = [g for g in geometry if g.geom_type == "Polygon"]
    lines = [g for g in geometry if isinstance(g, LineString)]
    points = [g for g in geometry if isinstance(g, Point)]
    return Sheet(
        areas(shapely.union_all(polygons)),
        _lines(shapely.union_all(lines)),
        _points(shapely.union_all(points)),
    )


def union(a: Sheet, b: Sheet) -> Sheet:
    return Sheet(areas(a.areas | b.areas), _lines(a.lines | b.lines), _points(a.points | b.points))


def difference(a: Sheet, b: Sheet) -> Sheet:
    """What is in `a` and not in `b`; a line takes away no area."""
    lines = _lines(a.lines - b.areas) - b.lines
    points = _points(a.points - b.areas) - b.lines - b.points
    return Sheet(areas(a.areas - b.areas), _lines(lines), _points(points))


def intersection(a: Sheet, b: Sheet) -> Sheet:
    """What is in both; a line within an area stays a line."""
    lines = shapely.union_all([a.lines & b.lines, a.lines & b.areas, b.lines & a.areas])
    points = shapely.union_all(
        [p & other for p, s in ((a.points, b), (b.points, a)) for other in parts_of(s)]
    )
    return Sheet(areas(a.areas & b.areas), _lines(lines), _points(points))


def symmetric_difference(a: Sheet, b: Sheet) -> Sheet:
    return union(difference(a, b), difference(b, a))


def grown(sheet: Sheet, distance: float, segments: int, account: Account) -> Sheet:
    """Everything within `distance` (m) of the sheet; a negative distance shrinks areas, and lines are gone.

    segments  of the polygon that stands for a quarter circle
    """
    for part in parts_of(sheet):
        account.growth(part, distance, "sides of what is grown or shrunk")
    parts = [shapely.buffer(part, distance, quad_segs=segments) for part in parts_of(sheet)]
    account.overlay(parts, "what has grown")
    return Sheet(areas(shapely.union_all(parts)))


def simplified(sheet: Sheet, tolerance: float, account: Account) -> Sheet:
    """The sheet without corners that lie within `tolerance` (m) of what is left; nothing comes to cross anything."""
    account.overlay(parts_of(sheet), "outlines")
    together = shapely.simplify(GeometryCollection(parts_of(sheet)), tolerance, preserve_topology=True)
    return Sheet(
        areas(shapely.union_all([g for g in _simple(together) if isinstance(g, Polygon)])),
        _lines(together),
        _points(together),
    )


def combined(name: str, a: Sheet, b: Sheet, account: Account) -> Sheet:
    """The sheets by the function of that name in COMBINE."""
    account.overlay([*parts_of(a), *parts_of(b)], f"the outlines of the {name}")
    return COMBINE[name](a, b)


COMBINE: dict[str, Callable[[Sheet, Sheet], Sheet]] = {
    "union": union,
    "intersection": intersection,
    "difference": difference,
    "symmetric_difference": symmetric_difference,
}


def parts_of(sheet: Sheet) -> tuple[BaseGeometry, ...]:
    return (sheet.areas, sheet.lines, sheet.points)


def _lines(geometry: BaseGeometry) -> MultiLineString:
    return MultiLineString([g for g in _simple(geometry) if isinstance(g, LineString) and not g.is_empty])


def _points(geometry: BaseGeometry) -> MultiPoint:
    return MultiPoint([g for g in _simple(geometry) if isinstance(g, Point) and not g.is_empty])


def _simple(geometry: BaseGeometry) -> list[BaseGeometry]:
    """The parts of a geometry, collections taken apart."""
    if isinstance(geometry, GeometryCollection | MultiPolygon | MultiLineString | MultiPoint):
        return [part for item in geometry.geoms for part in _simple(item)]
    return [geometry]

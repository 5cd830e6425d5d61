"""Drawn material of a laminate: per layer, areas and the lines and points that have none.

In: shapely geometry in metres. Out: the same, combined layer by layer. popupCAD computes with lines too (a
hinge line is drawn, grown to a strip and cut out), which is why a sheet is more than its areas.
"""

from collections.abc import Callable
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


@dataclass(frozen=True)
class Sheet:
    """What one layer holds."""

    areas: MultiPolygon = field(default_factory=MultiPolygon)
    lines: MultiLineString = field(default_factory=MultiLineString)
    points: MultiPoint = field(default_factory=MultiPoint)


def sheet_of(geometry: list[BaseGeometry]) -> Sheet:
    """A sheet of drawn shapes, joined."""
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
    points = shapely.union_all([p & other for p, s in ((a.points, b), (b.points, a)) for other in _parts(s)])
    return Sheet(areas(a.areas & b.areas), _lines(lines), _points(points))


def symmetric_difference(a: Sheet, b: Sheet) -> Sheet:
    return union(difference(a, b), difference(b, a))


def grown(sheet: Sheet, distance: float, segments: int) -> Sheet:
    """Everything within `distance` (m) of the sheet; a negative distance shrinks areas, and lines are gone.

    segments  of the polygon that stands for a quarter circle
    """
    parts = [shapely.buffer(part, distance, quad_segs=segments) for part in _parts(sheet)]
    return Sheet(areas(shapely.union_all(parts)))


def simplified(sheet: Sheet, tolerance: float) -> Sheet:
    """The sheet without corners that lie within `tolerance` (m) of what is left; nothing comes to cross anything."""
    together = shapely.simplify(GeometryCollection(_parts(sheet)), tolerance, preserve_topology=True)
    return Sheet(
        areas(shapely.union_all([g for g in _simple(together) if isinstance(g, Polygon)])),
        _lines(together),
        _points(together),
    )


COMBINE: dict[str, Callable[[Sheet, Sheet], Sheet]] = {
    "union": union,
    "intersection": intersection,
    "difference": difference,
    "symmetric_difference": symmetric_difference,
}


def _parts(sheet: Sheet) -> tuple[BaseGeometry, ...]:
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

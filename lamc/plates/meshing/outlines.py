"""Outlines as a user gives them, made ready for a mesher.

In: shapely polygons, lines and points. Out: the same, checked against each other, and the paths that they are made of.
Never: sizes of cells along them, which are `linework.py`'s.
"""

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np
import shapely
from shapely.geometry import MultiLineString, MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.checks import Array, checked_name, shown
from lamc.basics.errors import DesignError
from lamc.plates.meshing.checks import FARTHEST, place
from lamc.plates.meshing.linework import BORDER, FREE, REGION, Path

Area: TypeAlias = Polygon | MultiPolygon

TOLERANCE = 1e-9  # of the extent: corners this near to each other, or to a segment, are meant to be the same

_FOLLOWED = ("LineString", "LinearRing", "MultiLineString", "Point", "MultiPoint")


def check_area(area: object, what: str) -> None:
    """Raises DesignError unless it is a simple polygon, or several."""
    if not isinstance(area, Polygon | MultiPolygon):
        raise DesignError(f"{what} is {shown(area)}; it must be a shapely Polygon or MultiPolygon, in m")
    if area.is_empty:
        raise DesignError(f"{what} is empty; it must have an area")
    if not (np.abs(shapely.get_coordinates(area)) < FARTHEST).all():
        raise DesignError(f"{what} has coordinates that are not finite, or not below {FARTHEST:g} m")
    if not area.is_valid:
        raise DesignError(
            f"{what} is not a simple polygon: {shapely.is_valid_reason(area)} (m); its rings must not cross or touch "
            "along a line: correct the outline there, or try shapely.make_valid"
        )


def extent_of(area: Area) -> float:
    """The longer side of its box, m."""
    low_x, low_y, high_x, high_y = area.bounds
    return float(max(high_x - low_x, high_y - low_y))


def _rings(area: Area) -> list[Array]:
    pieces = area.geoms if isinstance(area, MultiPolygon) else [area]
    return [shapely.get_coordinates(r) for piece in pieces for r in (piece.exterior, *piece.interiors)]


def checked_regions(polygon: Area, regions: Mapping[str, Area]) -> dict[str, Area]:
    """Regions in their order. What round-off makes them overlap or reach outside is let pass."""
    if not isinstance(regions, Mapping):
        raise DesignError(f"the regions of a mesh are {shown(regions)}; give a polygon by name")
    named = dict(regions)
    slack = TOLERANCE * extent_of(polygon)
    for name, area in named.items():
        checked_name(name, "a region")
        check_area(area, f"region {name!r}")
        outside = area.difference(polygon)
        if outside.area > slack * area.length:
            at = np.array(outside.representative_point().coords[0])
            raise DesignError(
                f"region {name!r} reaches outside the polygon with {outside.area:.6g} m² of its {area.area:.6g} m², "
                f"around {place(at)}: cut it at the polygon's border"
            )
    if not named:
        return named
    areas = list(named.values())
    first, second = shapely.STRtree(areas).query(areas, predicate="intersects")
    for one, other in sorted((int(i), int(j)) for i, j in zip(first, second, strict=True) if i < j):
        common = areas[one].intersection(areas[other])
        if common.area > slack * (areas[one].length + areas[other].length):
            names = list(named)
            at = np.array(common.representative_point().coords[0])
            raise DesignError(
                f"regions {names[one]!r} and {names[other]!r} overlap with {common.area:.6g} m² around {place(at)}; "
                "a triangle has one region: cut one of them at the other"
            )
    return named


def checked_followed(polygon: Area, follow: Sequence[BaseGeometry]) -> list[BaseGeometry]:
    """Lines and points, one by one."""
    every = [follow] if isinstance(follow, BaseGeometry) else list(follow)
    around = polygon.buffer(TOLERANCE * extent_of(polygon)) if every else polygon
    parts: list[BaseGeometry] = []
    for given in every:
        if not isinstance(given, BaseGeometry) or given.is_empty or given.geom_type not in _FOLLOWED:
            raise DesignError(
                f"a mesh cannot follow {shown(given)}; give shapely lines and points, and areas as regions"
            )
        beyond = given.difference(around)
        if not beyond.is_empty:
            at = np.array(beyond.representative_point().coords[0])
            raise DesignError(
                f"a {given.geom_type} that a mesh shall follow reaches outside the polygon at {place(at)}: cut it at "
                "the polygon's border"
            )
        parts += getattr(given, "geoms", [given])
    return parts


def paths_of(
    polygon: Area, regions: Mapping[str, Area], wanted: Array, followed: Sequence[BaseGeometry]
) -> list[Path]:
    """Rings of the plate and of its regions, what is followed inside each, and where that meets them or itself."""
    paths = [Path(ring, BORDER, wanted[0]) for ring in _rings(polygon)]
    for area, size in zip(regions.values(), wanted[1:], strict=True):
        paths += [Path(ring, REGION, size) for ring in _rings(area)]
    rest = list(followed)
    for area, size in zip(regions.values(), wanted[1:], strict=True):
        paths += [Path(points, FREE, size) for part in rest for points in _chains(part.intersection(area))]
        rest = [part.difference(area) for part in rest]
    paths += [Path(points, FREE, wanted[0]) for part in rest for points in _chains(part)]
    if followed:
        crossings = shapely.node(MultiLineString([path.points for path in paths if len(path.points) > 1]))
        paths += [Path(point[None], FREE, wanted.max()) for point in shapely.get_coordinates(crossings)]
    return paths


def _chains(part: BaseGeometry) -> list[Array]:
    """Coordinates of each line or point of an intersection."""
    pieces = getattr(part, "geoms", [part])
    return [shapely.get_coordinates(piece) for piece in pieces if not piece.is_empty]

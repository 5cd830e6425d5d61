"""Holes and slits: the geometry that turns a drawn laminate into loose pieces.

In: a checked design and its hinges. Out: per layer, what is removed and what is left. It knows nothing about
bodies, names or masses.

A line is grown with round caps, by its width for holes and a tenth of that for slits (popupCAD's number;
Aukes and Wood, Figure 1). Round caps, not flat ones: a flat cap stops exactly at the line's end, so that a
plate's edge 1e-18 m beyond it would leave a bridge, lines drawn end to end would not overlap, and creases
that meet in a vertex would open it unevenly. With round caps whatever lies within the distance of the line is
removed, whichever way the line runs. Where a line ends on an edge or in a hole the cap removes nothing, and
masses are those of straight slits, exactly.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely import STRtree
from shapely.geometry import GeometryCollection, MultiPolygon
from shapely.geometry.base import BaseGeometry

from lamc.basics.errors import Place
from lamc.basics.groups import root, unite
from lamc.design.steps import Hinge
from lamc.design.work import Geometries, check_overlaps, meetings_of
from lamc.records.design import Layer

SLIT = 0.1  # half width of a slit, in hinge widths
_NOTHING, _EMPTY = GeometryCollection(), MultiPolygon()
_COLLECTION = 4  # GEOS: types from here on have parts
_ARC_SEGMENTS = 8  # per quarter circle: a cap falls short of the round one by half a per cent of its radius


def strips_of(hinges: Sequence[Hinge]) -> Geometries:
    """The hinge lines grown by their widths."""
    strips: Geometries = shapely.buffer(
        [h.line for h in hinges], [h.properties.width for h in hinges], quad_segs=_ARC_SEGMENTS
    )
    return strips


def holes_per_layer(
    hinges: Sequence[Hinge], count: int, place: Place | None = None
) -> tuple[MultiPolygon, ...]:
    """Per layer, where the strips of two hinge lines that both run through the layer overlap.

    Raises DesignError, at the place, where too many do."""
    strips = strips_of(hinges)
    pairs = meetings_of(strips, place)
    if not len(pairs):
        return (_EMPTY,) * count
    overlaps: Geometries = shapely.intersection(strips[pairs[:, 0]], strips[pairs[:, 1]])
    check_overlaps(overlaps, place)
    shared = [set(hinges[a].layers) & set(hinges[b].layers) for a, b in pairs.tolist()]
    runs = [tuple(k for k, each in enumerate(shared) if layer in each) for layer in range(count)]
    return _joined(overlaps, runs)


def slits_per_layer(hinges: Sequence[Hinge], count: int) -> tuple[MultiPolygon, ...]:
    """Per layer, the lines of the hinges that run through it, grown by a tenth of their widths."""
    grown = shapely.buffer(
        [h.line for h in hinges], [SLIT * h.properties.width for h in hinges], quad_segs=_ARC_SEGMENTS
    )
    runs = [tuple(k for k, h in enumerate(hinges) if layer in h.layers) for layer in range(count)]
    return _joined(grown, runs)


def _joined(parts: Geometries, runs: Sequence[tuple[int, ...]]) -> tuple[MultiPolygon, ...]:
    """Per layer the union of the parts that it has; layers that have the same ones share it."""
    unique = list(dict.fromkeys(runs))
    joined = as_multipolygons([_union(parts[np.array(run, dtype=np.int64)]) for run in unique])
    made = dict(zip(unique, joined, strict=True))
    return tuple(made[run] for run in runs)


def _union(parts: Geometries) -> BaseGeometry:
    """The union of areas, cluster by cluster of those that meet: in a sheet, holes vertex by vertex."""
    clusters = _clusters(parts)
    if not clusters:
        return _NOTHING
    joined: list[BaseGeometry] = []
    for size in sorted({len(each) for each in clusters}):
        alike = np.array([each for each in clusters if len(each) == size])
        joined.extend(shapely.union_all(parts[alike], axis=1))
    return shapely.geometrycollections(joined)


def _clusters(parts: Geometries) -> list[list[int]]:
    """Indices of areas by cluster: boxes about areas of different clusters have no point in common."""
    head = list(range(len(parts)))
    first, second = STRtree(parts).query(parts)
    for a, b in zip(first.tolist(), second.tolist(), strict=True):
        if a < b:
            unite(head, a, b)
    clusters: dict[int, list[int]] = {}
    for index in range(len(parts)):
        clusters.setdefault(root(head, index), []).append(index)
    return list(clusters.values())


def cut_layers(
    layers: Sequence[Layer], holes: Sequence[MultiPolygon], slits: Sequence[MultiPolygon]
) -> tuple[MultiPolygon, ...]:
    """What is left of each layer, polygons in an order that depends on geometry alone; layers that are drawn and cut
    alike share it."""
    given = [(layer.geometry, h, s) for layer, h, s in zip(layers, holes, slits, strict=True)]
    keys = [tuple(map(id, each)) for each in given]
    unique = dict(zip(keys, given, strict=True))
    drawn, hole, slit = (np.array(each, dtype=object) for each in zip(*unique.values(), strict=True))
    left = shapely.difference(shapely.normalize(drawn), shapely.union(hole, slit))
    made = dict(zip(unique, as_multipolygons(left), strict=True))
    return tuple(made[key] for key in keys)


def as_multipolygon(geometry: BaseGeometry) -> MultiPolygon:
    """The polygons in any geometry, normalised and sorted; lines and points hold no material and drop out."""
    return as_multipolygons([geometry])[0]


def as_multipolygons(geometries: Sequence[BaseGeometry]) -> list[MultiPolygon]:
    """The same of each."""
    normal = shapely.normalize(np.array(geometries, dtype=object))
    parts, owner = shapely.get_parts(normal, return_index=True)
    while (shapely.get_type_id(parts) >= _COLLECTION).any():
        parts, part = shapely.get_parts(parts, return_index=True)
        owner = owner[part]
    areas = shapely.area(parts)
    solid = areas > 0.0
    polygons, areas, owner = parts[solid], areas[solid], owner[solid]
    order = np.lexsort([areas, *shapely.bounds(polygons).T[::-1], owner])
    made = np.full(len(normal), _EMPTY, dtype=object)
    shapely.multipolygons(polygons[order], indices=owner[order], out=made)
    return list(made)


def material_size(layers: Sequence[Layer]) -> float:
    """Diagonal of the box around all layers, m."""
    bounds = shapely.bounds([layer.geometry for layer in layers])
    bounds = bounds[~np.isnan(bounds[:, 0])]  # of those that are not empty
    low, high = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    return float(np.linalg.norm(high - low))

"""Bodies: which pieces of which layers hang together, and which of them the world holds.

In: the material left in each layer after cutting, and the fixed regions. Out: groups of pieces. Pieces of
neighbouring layers hang together where they overlap with positive area; touching along an edge is no bond.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import shapely
from shapely import STRtree
from shapely.geometry import MultiPolygon, Polygon

from lamc.basics.groups import root, unite
from lamc.records.mechanism import Array

# An overlap below this fraction of the design's size squared is round-off: two layers cut along the same line
# overlap by its length times 1e-16 of the coordinates, at most about 1e-15; a real bond is far larger.
OVERLAP = 1e-12
# Half width of the window of a first look at an overlap, in units of the root of the area looked for.
WINDOW = 100.0
MANY = 500  # corners of two outlines: the overlay of fewer takes no longer than the look

Geometries = npt.NDArray[np.object_]
_NONE = np.zeros((2, 0), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Group:
    """Pieces that hang together: their polygons in each layer, and whether the world holds them."""

    polygons: tuple[tuple[Polygon, ...], ...]
    fixed: bool

    @property
    def area(self) -> float:
        """m², of the layer where the group is largest."""
        areas = iter(shapely.area([p for layer in self.polygons for p in layer]).tolist())
        return max(math.fsum(next(areas) for _ in layer) for layer in self.polygons)

    @property
    def at(self) -> tuple[float, float]:
        """A point inside its largest polygon, m."""
        point = largest([p for layer in self.polygons for p in layer]).representative_point()
        return float(point.x), float(point.y)


def largest(polygons: Sequence[Polygon]) -> Polygon:
    """The polygon of the largest area, the first of those alike."""
    return max(polygons, key=lambda polygon: float(polygon.area))


def find_groups(cut: Sequence[MultiPolygon], fixed: Sequence[MultiPolygon], size: float) -> tuple[Group, ...]:
    """Groups of pieces, ordered by their first piece from the bottom layer up.

    cut, fixed  per layer; size  of the design, m, the scale for `OVERLAP`
    """
    alike = {id(layer): list(layer.geoms) for layer in cut}
    pieces = [alike[id(layer)] for layer in cut]
    starts = np.concatenate([[0], np.cumsum([len(p) for p in pieces])])
    threshold = OVERLAP * size * size
    parent = list(range(int(starts[-1])))
    held_by = [list(region.geoms) for region in fixed]
    found = overlapping([*pairwise(pieces), *zip(pieces, held_by, strict=True)], threshold)
    for layer, pairs in enumerate(found[: len(pieces) - 1]):
        for low, high in pairs:
            unite(parent, int(starts[layer]) + low, int(starts[layer + 1]) + high)
    held: set[int] = set()
    for layer, pairs in enumerate(found[len(pieces) - 1 :]):
        held |= {root(parent, int(starts[layer]) + index) for index, _ in pairs}
    members: dict[int, list[list[Polygon]]] = {}
    for layer, polygons in enumerate(pieces):
        for index, polygon in enumerate(polygons):
            head = root(parent, int(starts[layer]) + index)
            members.setdefault(head, [[] for _ in pieces])[layer].append(polygon)
    return tuple(
        Group(tuple(tuple(layer) for layer in polygons), head in held) for head, polygons in members.items()
    )


def overlapping(
    sets: Sequence[tuple[Sequence[Polygon], Sequence[Polygon]]], threshold: float
) -> list[list[tuple[int, int]]]:
    """For each two sets of polygons, pairs (i, j), sorted, such that first[i] and second[j] share more than `threshold`
    of area, m²."""
    arrays = [tuple(np.array(each, dtype=object) for each in both) for both in sets]
    met = [STRtree(b).query(a, predicate="intersects") if len(a) and len(b) else _NONE for a, b in arrays]
    first = np.concatenate([a[i] for (a, _), (i, _) in zip(arrays, met, strict=True)])
    second = np.concatenate([b[j] for (_, b), (_, j) in zip(arrays, met, strict=True)])
    # Layers are mostly drawn alike: equality is cheap, and saves the overlay of large outlines.
    bonded = shapely.equals_exact(first, second, 0.0) & (shapely.area(first) > threshold)
    corners = shapely.get_num_coordinates(first) + shapely.get_num_coordinates(second)
    for step, least in ((_overlap_near_middle, MANY), (_overlap, 0)):
        rest = np.flatnonzero(~bonded & (corners > least))
        if len(rest):
            bonded[rest] = step(first[rest], second[rest], threshold) > threshold
    ends = np.cumsum([pairs.shape[1] for pairs in met])[:-1]
    return [
        sorted(map(tuple, pairs[:, kept].T.tolist()))
        for pairs, kept in zip(met, np.split(bonded, ends), strict=True)
    ]


def _overlap_near_middle(a: Geometries, b: Geometries, threshold: float) -> Array:
    """Shared area (m²) in a window about an interior point of each a[k]: a lower bound of the whole.

    Outlines of 10^6 vertices that nearly coincide take half a minute to overlay; inside, one look is enough.
    """
    points = shapely.point_on_surface(a)
    inside = shapely.contains_xy(b, shapely.get_x(points), shapely.get_y(points))
    window = shapely.envelope(shapely.buffer(points, WINDOW * math.sqrt(threshold)))
    areas = np.zeros(len(a))
    near_a = shapely.intersection(a[inside], window[inside])
    near_b = shapely.intersection(b[inside], window[inside])
    areas[inside] = shapely.area(shapely.intersection(near_a, near_b))
    return areas


def _overlap(a: Geometries, b: Geometries, _threshold: float) -> Array:
    """Shared area of each pair, m²."""
    areas: Array = shapely.area(shapely.intersection(a, b))
    return areas

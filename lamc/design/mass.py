"""Mass, centre of mass and inertia of a body made of flat plates, from exact polygon moments.

In: plates (polygon with holes, between two heights, m) with a density (kg/m³) each. Out: mass (kg), centre of
mass (m) and inertia about it (kg·m²), world axes. It never meshes, samples or approximates: the moments of a
polygon are sums over its edges (Green's theorem), and the thickness integrates in closed form.

Every ring is taken relative to the polygon's own centroid before it is squared, so a plate a kilometre from
the origin keeps the digits that its coordinates carry, and sums are rounded once (`math.fsum`), so the order
of vertices and plates does not matter.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Array, Slab

Integers = NDArray[np.integer]


@dataclass(frozen=True)
class PolygonMoments:
    """Area, centroid and second moments about the centroid: xx = ∫x² dA, yy = ∫y² dA, xy = ∫xy dA."""

    area: float  # m²
    x: float  # m
    y: float  # m
    xx: float  # m⁴
    yy: float  # m⁴
    xy: float  # m⁴


def polygon_moments(polygon: Polygon) -> PolygonMoments:
    """Moments of a polygon with holes, whatever the direction of its rings; exact up to rounding.

    Raises DesignError for a polygon that is empty, has no area, or has a coordinate that is not finite.
    """
    return moments_of([polygon])[0]


def moments_of(polygons: Sequence[Polygon]) -> list[PolygonMoments]:
    """`polygon_moments` of each, at once."""
    shapes = np.array(polygons, dtype=object)
    if shapely.is_empty(shapes).any():
        raise DesignError("a plate has an empty polygon; draw it or leave the plate out")
    rings, owner = shapely.get_rings(shapes, return_index=True)  # of each polygon the exterior first
    points, ring = shapely.get_coordinates(rings, return_index=True)
    if not np.isfinite(points).all():
        raise DesignError("a plate's polygon has a coordinate that is not finite")
    first = np.searchsorted(ring, np.arange(len(rings)))
    outer = np.searchsorted(owner, np.arange(len(shapes)))
    low, high = (extreme.reduceat(points, first)[outer] for extreme in (np.minimum, np.maximum))
    origin = low + (high - low) / 2
    local, mine = points - origin[owner[ring]], np.append(outer, len(rings)).tolist()
    edges = _Edges(local, ring, outer)
    areas, firsts = edges.areas(), edges.firsts()
    area = [math.fsum(areas[i:j]) for i, j in pairwise(mine)]
    for (x, y), each in zip(origin.tolist(), area, strict=True):
        if not each > 0.0:
            raise DesignError(f"a plate's polygon near ({x:g}, {y:g}) m has no area; it must enclose some")
    sums = [[math.fsum(each[i:j]) for each in firsts] for i, j in pairwise(mine)]
    shift = np.array(sums) / np.array(area)[:, None]
    seconds = _Edges(local - shift[owner[ring]], ring, outer).seconds()
    about = [[math.fsum(each[i:j]) for each in seconds] for i, j in pairwise(mine)]
    centroids = (origin + shift).tolist()
    return [PolygonMoments(a, *c, *s) for a, c, s in zip(area, centroids, about, strict=True)]


def body_properties(plates: Sequence[tuple[Slab, float]]) -> tuple[float, Array, Array]:
    """Mass (kg), centre of mass (3,) m and inertia about it (3, 3) kg·m², world axes, of a body.

    plates  (plate, density in kg/m³), at least one

    A body without mass (density zero throughout) has its centre of volume for a centre, and no inertia.
    Raises DesignError for no plates, a plate without area or thickness, and a density that is negative or
    not finite.
    """
    return properties_of([plates])[0]


def properties_of(bodies: Sequence[Sequence[tuple[Slab, float]]]) -> list[tuple[float, Array, Array]]:
    """`body_properties` of each, at once."""
    if not all(bodies):
        raise DesignError("a body has no plates, so it has no mass; give it at least one")
    # Layers that are cut alike share their polygons.
    shapes = {id(plate.polygon): plate.polygon for plates in bodies for plate, _ in plates}
    known = dict(zip(shapes, moments_of(list(shapes.values())), strict=True)) if shapes else {}
    return [_properties(plates, [known[id(plate.polygon)] for plate, _ in plates]) for plates in bodies]


def _properties(
    plates: Sequence[tuple[Slab, float]], moments: Sequence[PolygonMoments]
) -> tuple[float, Array, Array]:
    """`body_properties` by the moments of the plates' polygons."""
    heights = [_thickness(plate) for plate, _ in plates]
    densities = [_checked_density(density) for _, density in plates]
    volumes = [m.area * t for m, t in zip(moments, heights, strict=True)]
    masses = [d * v for d, v in zip(densities, volumes, strict=True)]
    mass = math.fsum(masses)
    centres = np.array(
        [
            (m.x, m.y, plate.z_bottom + t / 2)
            for m, t, (plate, _) in zip(moments, heights, plates, strict=True)
        ]
    )
    com = _weighted_mean(centres, masses if mass > 0.0 else volumes)
    own = [_plate_inertia(m, d, t) for m, d, t in zip(moments, densities, heights, strict=True)]
    terms = np.array(own) + np.array(masses)[:, None, None] * _shift_inertias(centres - com)
    inertia = np.array([math.fsum(each) for each in terms.reshape(-1, 9).T.tolist()]).reshape(3, 3)
    return mass, com, inertia


class _Edges:
    """The edges of closed rings, signed so that the exteriors count positive and holes negative.

    points (n, 2), m; ring (n,): that each is of, ascending; outer: numbers of the rings that are exteriors
    """

    def __init__(self, points: Array, ring: Integers, outer: Integers) -> None:
        inside = ring[1:] == ring[:-1]
        self.a, self.b, ring = points[:-1][inside], points[1:][inside], ring[1:][inside]
        cross = self.a[:, 0] * self.b[:, 1] - self.b[:, 0] * self.a[:, 1]
        count = int(ring[-1]) + 1
        self.bounds = list(pairwise(np.searchsorted(ring, np.arange(count + 1)).tolist()))
        signs = np.full(count, -1.0)
        signs[outer] = 1.0
        signs[[each < 0.0 for each in self._sums(cross)]] *= -1.0
        self.cross = cross * signs[ring]

    def areas(self) -> list[float]:
        """Of each ring."""
        return [each / 2 for each in self._sums(self.cross)]

    def firsts(self) -> tuple[list[float], ...]:
        """First moments in x and in y, of each ring."""
        moments = ((self.a + self.b) * self.cross[:, None]).T
        return tuple([each / 6 for each in self._sums(moment)] for moment in moments)

    def seconds(self) -> tuple[list[float], ...]:
        """Second moments xx, yy and xy, of each ring."""
        a, b, cross = self.a, self.b, self.cross
        # Written symmetrically in a and b, so that a ring run backwards rounds alike.
        x, y = ((a * a + b * b + a * b) * cross[:, None]).T
        mixed = (a[:, 0] * b[:, 1] + b[:, 0] * a[:, 1]) + 2 * (a[:, 0] * a[:, 1] + b[:, 0] * b[:, 1])
        parts = ((x, 12), (y, 12), (mixed * cross, 24))
        return tuple([each / by for each in self._sums(part)] for part, by in parts)

    def _sums(self, values: Array) -> list[float]:
        """Of each ring's edges, rounded once."""
        listed = values.tolist()
        return [math.fsum(listed[i:j]) for i, j in self.bounds]


def _thickness(plate: Slab) -> float:
    thickness = plate.z_top - plate.z_bottom
    if not (thickness > 0.0 and math.isfinite(thickness)):
        raise DesignError(
            f"a plate runs from z = {plate.z_bottom:g} m to {plate.z_top:g} m; "
            "its top must lie above its bottom"
        )
    return thickness


def _checked_density(density: float) -> float:
    if not (density >= 0.0 and math.isfinite(density)):
        raise DesignError(f"a plate has density {density!r} kg/m³; it must be finite and at least 0")
    return density


def _weighted_mean(points: Array, weights: Sequence[float]) -> Array:
    """Mean of points (n, 3), formed about their first so that distance from the origin costs no digits."""
    total = math.fsum(weights)
    offsets = (points - points[0]).T.tolist()
    moment = [math.fsum(w * r for w, r in zip(weights, offset, strict=True)) for offset in offsets]
    mean: Array = points[0] + np.array(moment) / total
    return mean


def _plate_inertia(m: PolygonMoments, density: float, thickness: float) -> list[list[float]]:
    """Inertia of one plate about its own centre of mass, world axes, kg·m²."""
    rho = density * thickness
    bend = density * m.area * thickness**3 / 12
    return [
        [rho * m.yy + bend, -rho * m.xy, 0.0],
        [-rho * m.xy, rho * m.xx + bend, 0.0],
        [0.0, 0.0, rho * (m.xx + m.yy)],
    ]


def _shift_inertias(d: Array) -> Array:
    """Inertia of unit point masses at `d` (n, 3): d·d 1 - d dᵀ (the parallel-axis theorem)."""
    squares = np.array([each @ each for each in d])
    return np.asarray(squares[:, None, None] * np.eye(3) - d[:, :, None] * d[:, None, :])

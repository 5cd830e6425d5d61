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

import numpy as np
from shapely.geometry import Polygon

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Array, Slab


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
    if polygon.is_empty:
        raise DesignError("a plate has an empty polygon; draw it or leave the plate out")
    rings = [
        np.array(ring.coords, dtype=np.float64)[:, :2] for ring in (polygon.exterior, *polygon.interiors)
    ]
    outer = rings[0]
    if not all(np.isfinite(ring).all() for ring in rings):
        raise DesignError("a plate's polygon has a coordinate that is not finite")
    origin = outer.min(axis=0) + np.ptp(outer, axis=0) / 2
    edges = [_Edges(ring - origin, sign) for ring, sign in zip(rings, _signs(len(rings)), strict=True)]
    area = math.fsum(e.area() for e in edges)
    if not area > 0.0:
        x, y = origin
        raise DesignError(f"a plate's polygon near ({x:g}, {y:g}) m has no area; it must enclose some")
    shift = np.array([math.fsum(e.first(axis) for e in edges) for axis in (0, 1)]) / area
    centred = [
        _Edges(ring - origin - shift, sign) for ring, sign in zip(rings, _signs(len(rings)), strict=True)
    ]
    xx, yy, xy = (math.fsum(parts) for parts in zip(*(e.second() for e in centred), strict=True))
    centroid = origin + shift
    return PolygonMoments(area, float(centroid[0]), float(centroid[1]), xx, yy, xy)


def body_properties(plates: Sequence[tuple[Slab, float]]) -> tuple[float, Array, Array]:
    """Mass (kg), centre of mass (3,) m and inertia about it (3, 3) kg·m², world axes, of a body.

    plates  (plate, density in kg/m³), at least one

    A body without mass (density zero throughout) has its centre of volume for a centre, and no inertia.
    Raises DesignError for no plates, a plate without area or thickness, and a density that is negative or
    not finite.
    """
    if not plates:
        raise DesignError("a body has no plates, so it has no mass; give it at least one")
    # Layers that are cut alike share their polygons.
    shapes = {id(plate.polygon): plate.polygon for plate, _ in plates}
    known = {key: polygon_moments(shape) for key, shape in shapes.items()}
    moments = [known[id(plate.polygon)] for plate, _ in plates]
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
    terms = [
        _plate_inertia(m, d, t) + w * _shift_inertia(c - com)
        for m, d, t, w, c in zip(moments, densities, heights, masses, centres, strict=True)
    ]
    inertia = np.array([[math.fsum(term[i, j] for term in terms) for j in range(3)] for i in range(3)])
    return mass, com, inertia


class _Edges:
    """The edges of one closed ring, signed so that the exterior counts positive and a hole negative."""

    def __init__(self, ring: Array, sign: float) -> None:
        self.a, self.b = ring[:-1], ring[1:]
        cross = self.a[:, 0] * self.b[:, 1] - self.b[:, 0] * self.a[:, 1]
        self.cross = cross * (sign if math.fsum(cross.tolist()) >= 0.0 else -sign)

    def area(self) -> float:
        return math.fsum(self.cross.tolist()) / 2

    def first(self, axis: int) -> float:
        return math.fsum(((self.a[:, axis] + self.b[:, axis]) * self.cross).tolist()) / 6

    def second(self) -> tuple[float, float, float]:
        a, b, cross = self.a, self.b, self.cross
        # Written symmetrically in a and b, so that a ring run backwards rounds alike.
        squares = (a * a + b * b + a * b) * cross[:, None]
        mixed = (a[:, 0] * b[:, 1] + b[:, 0] * a[:, 1]) + 2 * (a[:, 0] * a[:, 1] + b[:, 0] * b[:, 1])
        x, y = squares.T.tolist()
        return math.fsum(x) / 12, math.fsum(y) / 12, math.fsum((mixed * cross).tolist()) / 24


def _signs(count: int) -> tuple[float, ...]:
    return (1.0, *([-1.0] * (count - 1)))


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
    offsets = points - points[0]
    moment = [math.fsum(w * r for w, r in zip(weights, offsets[:, axis], strict=True)) for axis in range(3)]
    mean: Array = points[0] + np.array(moment) / total
    return mean


def _plate_inertia(m: PolygonMoments, density: float, thickness: float) -> Array:
    """Inertia of one plate about its own centre of mass, world axes, kg·m²."""
    rho = density * thickness
    bend = density * m.area * thickness**3 / 12
    return np.array(
        [
            [rho * m.yy + bend, -rho * m.xy, 0.0],
            [-rho * m.xy, rho * m.xx + bend, 0.0],
            [0.0, 0.0, rho * (m.xx + m.yy)],
        ]
    )


def _shift_inertia(d: Array) -> Array:
    """Inertia of a unit point mass at `d`: d·d 1 - d dᵀ (the parallel-axis theorem)."""
    shifted: Array = float(d @ d) * np.eye(3) - np.outer(d, d)
    return shifted

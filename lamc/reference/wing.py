"""Air around a flat wing in numbers: pushes on its strips, and the air that goes with it.

In: an effect's own numbers and the motion of points of the wing. Out: a lift and three drags per strip, by speed and
angle of attack, and masses that feel motion along the normal only. The outline is cut edge by edge here. With the
effect this shares what its text states: where strips and drags lie (Gauss's rule) and how forces fade at rest.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Mechanism
from lamc.reference.point_loads import BodyState, Push

Array = npt.NDArray[np.float64]
_CHORD_POINTS = 3


@dataclass(frozen=True)
class FluidMass:
    """Kinetic energy ½ mass (n · v)², where n rides on the body and v is what `moving` of it has against the wind.

    moving  (4,): a point, m, and 1, or a direction and 0, as drawn
    normal  n, (3,), as drawn
    mass    kg for a point, kg·m² for a direction
    wind    (3,), m/s, world, of the air; a direction knows none
    """

    effect: str
    body: str
    moving: Array
    normal: Array
    mass: float
    wind: Array


@dataclass(frozen=True)
class Strip:
    """Across the wing's span; points as drawn, m."""

    axis: Array  # where the line crosses the chord
    edge: float  # m, from there to the leading edge
    chord: float  # m
    width: float  # m


@dataclass(frozen=True)
class WingInAir:
    """chord (to the leading edge), span and normal: unit vectors as drawn; numbers as in the effect's text."""

    told: Any
    chord: Array
    span: Array
    normal: Array
    strips: tuple[Strip, ...]
    lift_point: float
    wind: Array

    effect = ""  # what it stores is the fluid's kinetic energy, which the cross-check counts

    def stored(self, t: float, place: BodyState) -> float:
        return 0.0

    def pushes(self, t: float, place: BodyState) -> list[Push]:
        found = []
        for strip in self.strips:
            found.append(self._lift(strip, place))
            for point, weight in zip(*np.polynomial.legendre.leggauss(_CHORD_POINTS), strict=True):
                found.append(
                    self._drag(strip, strip.edge - 0.5 * strip.chord * (1.0 + point), 0.5 * weight, place)
                )
        return found

    def _drag(self, strip: Strip, ahead: float, share: float, place: BodyState) -> Push:
        """½ ρ c U² (C_0 cos² α + C_90 sin² α) against the velocity, of a share of the strip."""
        point = strip.axis + ahead * self.chord
        speed, attack, faded, (chord, _) = self._met(point, place)
        of = self.told.drag_edge_on * math.cos(attack) ** 2 + self.told.drag_broadside * math.sin(attack) ** 2
        size = 0.5 * self.told.air_density * strip.chord * strip.width * share * of * speed * speed * faded
        across = place.direction(self.told.body, self.normal)
        return Push(self.told.body, point, size * (math.sin(attack) * across - math.cos(attack) * chord))

    def _lift(self, strip: Strip, place: BodyState) -> Push:
        """½ ρ c U² A sin 2α by the angle at the pitch axis, and ρ c² U ω k (0.75 - x0); across the velocity where lift
        acts."""
        told, c = self.told, strip.chord
        speed, attack, faded, _ = self._met(strip.axis, place)
        risen = [
            self._velocity(point, place) @ place.direction(told.body, self.normal)
            for point in (strip.axis, strip.axis + self.chord)
        ]
        nose_up = float(risen[1] - risen[0])  # rad/s: of two points 1 m apart
        circulation = 0.5 * c * told.lift * speed * math.sin(2.0 * attack) * faded
        circulation += told.rotation * (0.75 - strip.edge / c) * c * c * nose_up
        point = strip.axis + (strip.edge - self.lift_point * c) * self.chord
        there, angle, _, (chord, normal) = self._met(point, place)
        size = told.air_density * strip.width * circulation * there
        return Push(told.body, point, size * (math.sin(angle) * chord + math.cos(angle) * normal))

    def _met(self, point: Array, place: BodyState) -> tuple[float, float, float, tuple[Array, Array]]:
        """Speed against the air across the span, m/s, angle of attack, rad, how far forces have faded there, and the
        directions of chord and normal in the world."""
        chord, normal = (place.direction(self.told.body, d) for d in (self.chord, self.normal))
        velocity = self._velocity(point, place)
        along, rising = float(velocity @ chord), float(velocity @ normal)
        speed = math.hypot(along, rising)
        return (
            speed,
            math.atan2(-rising, along),
            speed / math.hypot(speed, self.told.rest_speed),
            (chord, normal),
        )

    def _velocity(self, point: Array, place: BodyState) -> Array:
        return place.point(self.told.body, point)[1] - self.wind

    @property
    def fluid(self) -> tuple[FluidMass, ...]:
        """Of each strip: π ρ c²/4 per span at mid-chord, along the normal, and π ρ c⁴/128 about it: there the chord's
        tip moves along the normal. None where the effect leaves it out."""
        if not self.told.added_mass:
            return ()
        found, density = [], math.pi * self.told.air_density
        for s in self.strips:
            middle = s.axis + (s.edge - 0.5 * s.chord) * self.chord
            for moving, mass, wind in (
                ((*middle, 1.0), density * s.chord**2 / 4.0 * s.width, self.wind),
                ((*self.chord, 0.0), density * s.chord**4 / 128.0 * s.width, np.zeros(3)),
            ):
                at = np.array(moving)
                found.append(FluidMass("blade_element_drag", self.told.body, at, self.normal, mass, wind))
        return tuple(found)


def wing_in_air(mechanism: Mechanism, effect: Any) -> WingInAir:
    """Raises DesignError for a body that the mechanism does not have."""
    if effect.body not in {body.name for body in mechanism.bodies}:
        raise DesignError(f"the scene puts a wing on body {effect.body!r}, which the mechanism does not have")
    body = mechanism.body(effect.body)
    if effect.outline is not None:
        rings, height = [np.array(effect.outline)], float(body.com[2])
    else:
        rings = [np.array(plate.polygon.exterior.coords)[:-1] for plate in body.outline]
        faces = [z for plate in body.outline for z in (plate.z_bottom, plate.z_top)]
        height = 0.5 * (min(faces) + max(faces))
    if effect.line is not None:
        first, second = np.array(effect.line)
    else:
        (joint,) = (j for j in mechanism.joints if effect.body in (j.parent, j.child))
        first, second = joint.point[:2], (joint.point + joint.axis)[:2]
    along = (second - first) / np.linalg.norm(second - first)
    ahead = np.array([along[1], -along[0]])
    if effect.leading is not None:
        ahead = ahead if ahead @ effect.leading > 0.0 else -ahead
    elif _area_before(rings, first, ahead) > _area_before(rings, first, -ahead):
        ahead = -ahead
    span = np.array([-ahead[1], ahead[0]])
    strips = []
    reach = np.concatenate([(ring - first) @ span for ring in rings])
    low, high = float(reach.min()), float(reach.max())
    for unit, weight in zip(*np.polynomial.legendre.leggauss(effect.strips), strict=True):
        at = 0.5 * (low + high + (high - low) * unit)
        edges = _crossed([(ring - first) @ np.column_stack([span, ahead]) for ring in rings], at)
        if edges is not None:
            axis = np.array([*(first + at * span), height])
            strips.append(Strip(axis, edges[1], edges[1] - edges[0], 0.5 * (high - low) * weight))
    place = effect.lift_point
    if place is None:
        # Munk's moment of the added mass stands for the rest of the way to the quarter chord.
        place = 0.5 if effect.added_mass or not effect.lift else 0.5 - 0.25 * math.pi / effect.lift
    return WingInAir(
        effect,
        np.array([*ahead, 0.0]),
        np.array([*span, 0.0]),
        np.array([0.0, 0.0, 1.0]),
        tuple(strips),
        float(place),
        np.zeros(3) if effect.wind is None else np.array(effect.wind),
    )


def _crossed(rings: list[Array], at: float) -> tuple[float, float] | None:
    """Rearmost and foremost place where edges of rings, in axes of span and chord, cross a line across the span."""
    found = []
    for ring in rings:
        for (x0, y0), (x1, y1) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            if (x0 - at) * (x1 - at) <= 0.0 and x0 != x1:
                found.append(float(y0 + (at - x0) / (x1 - x0) * (y1 - y0)))
    return (min(found), max(found)) if len(found) > 1 and max(found) > min(found) else None


def _area_before(rings: list[Array], first: Array, ahead: Array) -> float:
    """m², of the rings together, on that side of a line through `first`."""
    size = 4.0 * max(float(np.abs(ring - first).max()) for ring in rings)
    span = np.array([-ahead[1], ahead[0]])
    side = shapely.Polygon(
        [first + a * size * span + b * size * ahead for a, b in ((-1, 0), (1, 0), (1, 1), (-1, 1))]
    )
    return float(shapely.union_all([shapely.Polygon(ring) for ring in rings]).intersection(side).area)

"""What the air does to a flat wing: quasi-steady lift and drag of strips across its span, and the air's mass.

Goes in: a body, the density of the air and coefficients of the wing. Comes out: one force and one moment on the body,
and added inertia. The air remembers nothing: no wake, no delay, and strips do not know of each other.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from pydantic import Field
from shapely.geometry import Polygon

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError, about
from lamc.basics.fields import Flag, Name, Vector, Whole
from lamc.basics.quantity_fields import Unit
from lamc.effects.registered import RegisteredEffect
from lamc.effects.strips import Corners, Strip, Wing, gauss, wing
from lamc.mechanics.added_inertia import AddedInertia
from lamc.mechanics.arranging import Arranging
from lamc.mechanics.loads import Loads
from lamc.records.mechanism import Mechanism
from lamc.symbolic.algebra import ZERO, Matrix3, Vector3, add, dot, scale
from lamc.symbolic.scalars import Scalar, call

AIR = 1.2  # kg/m³, at 20 °C at sea level
MOST_STRIPS = 64
CHORD_POINTS = 3  # for drag: exact broadside; 3 % too much where the wing turns about mid-chord
_COEFFICIENTS = {  # field: its meaning
    "lift": "greatest lift coefficient, at 45 degrees",
    "drag_edge_on": "drag coefficient of the wing edge-on",
    "drag_broadside": "drag coefficient of the wing broadside",
    "rotation": "circulation of a wing that pitches, over (0.75 - x0) c^2 rate",
}


@dataclass(frozen=True)
class BladeElementDrag(RegisteredEffect):
    """Lift, drag and added mass of a flat wing, by strips across its span.

    A strip of chord c that meets the air at speed U and angle of attack α has, per span,

        drag   ½ ρ c U² (C_0 cos² α + C_90 sin² α)              against the velocity
        lift   ½ ρ c U² (A sin 2α) + ρ c² U ω k (0.75 - x0)     across it; ω is the pitch rate, nose up
        mass   π ρ c²/4 at mid-chord along the normal, and π ρ c⁴/128 about it

    with x0 the place of the pitch axis, as a fraction of the chord from the leading edge. Velocity along the span does
    nothing. The coefficients are those of Whitney & Wood 2010. From 0 to 90 degrees the fits of Dickinson, Lehmann &
    Sane 1999 differ from them by 0.10 in lift and 0.21 in drag at most; their sin(2.13 α - 7.2°) has no symmetry, and
    no limit as a wing comes to rest. Here U² sin 2α = 2 v_n v_c, so that no angle is computed, and what is left of U is
    smooth at rest by `rest_speed`. With drag_edge_on = 0 and lift = drag_broadside / 2 the force is along the normal,
    as on a sharp flat plate.

    Drag is taken at three places of each chord with the velocity there, so that a wing that only pitches is damped too.
    The angle of lift is that at the pitch axis; lift stands across the velocity where it acts, and does no work. So the
    air only takes energy, whatever the coefficients and the motion, but for what wind brings.

    Lift acts at mid-chord, where theory has it: the added mass turns a wing that moves askew broadside (Munk's moment),
    which amounts to lift at the quarter chord for lift = π, and brings the centre of pressure to 0.11, 0.20 and 0.50 of
    the chord at 0, 45 and 90 degrees for the coefficients here; 0.05, 0.26 and 0.46 were measured (Dickson, Straw &
    Dickinson 2006). Without added mass, lift acts at 0.5 - π / (4 lift), for the same at small angles.

    The rotation k is π in theory (Sane & Dickinson 2002: C_rot = π (0.75 - x0)). It stands across the velocity, with
    suction at the leading edge, which a sharp edge does not bear where a wing turns over: there it doubles the lift of
    a hovering wing. Whitney & Wood 2010 leave it out, and their wings agree.

    Several wings may act in one scene.
    """

    body: Annotated[Name, Field(description="the wing: a rigid one that moves")]
    air_density: Annotated[float, Unit("kg/m^3", "ρ", ge=0.0)] = AIR
    strips: Annotated[
        Whole, Field(ge=1, le=MOST_STRIPS, description="how many; at Gauss points of the span")
    ] = 8
    lift: Annotated[float, Unit("1", "A", ge=0.0)] = 1.8
    drag_edge_on: Annotated[float, Unit("1", "C_0", ge=0.0)] = 0.4
    drag_broadside: Annotated[float, Unit("1", "C_90", ge=0.0)] = 3.4
    rotation: Annotated[float, Unit("1", "k")] = 0.0
    lift_point: Annotated[
        float | None,
        Unit(
            "1", "where lift acts, as a fraction of the chord from the leading edge; left out: as said above"
        ),
    ] = None
    added_mass: Annotated[Flag, Field(description="false leaves the mass of the air out")] = True
    wind: Annotated[Vector | None, Unit("m/s", "velocity of the air, world; left out: it rests")] = None
    line: Annotated[
        Corners | None,
        Unit(
            "m",
            "two points, x and y as drawn, of the line that the wing pitches about; left out: its only hinge",
        ),
    ] = None
    leading: Annotated[
        tuple[float, float] | None,
        Unit(
            "1",
            "direction towards the leading edge, x and y as drawn; left out: the side of the line with less area",
        ),
    ] = None
    outline: Annotated[
        Corners | None, Unit("m", "corners of the wing, x and y as drawn; left out: the outline of the body")
    ] = None
    rest_speed: Annotated[
        float,
        Unit(
            "m/s",
            "far below it forces fade faster than U²; they lack 1/2 (rest_speed / U)² at speed U",
            gt=0.0,
        ),
    ] = 1e-4

    name: ClassVar[str] = "blade_element_drag"
    summary: ClassVar[str] = "Air around flat wings"
    example: ClassVar[str] = "blade_element_drag: {body: wing, strips: 12}"
    source: ClassVar[str] = (
        "CL = A sin 2a, CD = C0 cos^2 a + C90 sin^2 a, Whitney & Wood 2010; rotation, Sane & Dickinson 2002"
    )
    repeatable: ClassVar[bool] = True
    conservative: ClassVar[bool] = False
    absent: ClassVar[str] = "no air is called for"

    def __post_init__(self) -> None:
        super().__post_init__()
        what = f"of the wing {self.body!r}"
        with about(("leading",)):
            if self.leading is not None and not 0.0 < math.hypot(*self.leading) < math.inf:
                raise DesignError(f"leading {what} is {list(self.leading)}; it must have a direction")
        with about(("line",)):
            if self.line is not None and (len(self.line) != 2 or self.line[0] == self.line[1]):
                raise DesignError(f"line {what} is {shown(self.line)}; give two points that differ")
        with about(("outline",)):
            if self.outline is not None and (len(self.outline) < 3 or not Polygon(self.outline).is_valid):
                raise DesignError(
                    f"outline {what} is no polygon: give three corners or more, in order, of sides that do not cross"
                )

    def claims(self) -> tuple[str, ...]:
        return (f"air around body {self.body!r}",)

    def arrange(self, arranging: Arranging) -> None:
        """Added mass asks for the general form of the equations."""
        if self.added_mass:
            arranging.inverse_dynamics()

    def contribute(self, loads: Loads) -> None:
        flat = self.wing(loads.mechanism)
        with loads.drawing():  # strips are drawn with the wing
            self._act(loads, flat)

    def _act(self, loads: Loads, flat: Wing) -> None:
        index = loads.link_of(self.body)
        if self.body not in loads.moving_bodies:
            raise DesignError(f"the wing {self.body!r} does not move; name a body that does")
        if index in loads.kinematics.flexible:
            raise DesignError(
                f"the wing {self.body!r} is flexible, and strips are those of a rigid one: leave out flexible_links "
                "for it, or blade_element_drag"
            )
        density = self._parameter(loads, "density", self.air_density, "kg/m³", "density of the air")
        rotation = loads.rotation(self.body)
        axes = [_rotated(rotation, axis) for axis in flat.axes]
        linear, spin = loads.velocity(self.body, flat.origin), loads.angular_velocity(self.body)
        own = _Motion(_components(axes, linear), _components(axes, spin))
        wind = _components(axes, self._wind(loads)) if self.wind is not None else ZERO
        met = _Motion(add(own.velocity, scale(-1, wind)), own.spin)
        force, moment = _Air(self, loads, flat, met).wrench(loads, flat.strips)
        force, moment = scale(density, force), scale(density, moment)
        if self.added_mass:
            matrix = flat.added_mass(1.0)
            turn = np.kron(np.eye(2), np.array(flat.axes))  # wing from drawn axes, of both halves
            drawn = turn.T @ matrix @ turn
            loads.added_inertia(self.body, flat.origin, [[density * float(v) for v in row] for row in drawn])
            if self.wind is not None:
                entrained = _moved_by_wind(matrix.tolist(), own, met)
                force, moment = (
                    add(a, scale(density, b)) for a, b in zip((force, moment), entrained, strict=True)
                )
        loads.force(self.body, flat.origin, _composed(axes, force))
        loads.moment(self.body, _composed(axes, moment))

    def wing(self, mechanism: Mechanism) -> Wing:
        """Where the strips are and how long their chords. Raises DesignError for a body that is no wing."""
        return wing(mechanism, self.body, self.strips, self.line, self.leading, self.outline)

    @property
    def default_lift_point(self) -> float:
        """Where lift acts if nothing is said, as a fraction of the chord from the leading edge."""
        if self.added_mass or self.lift == 0.0:
            return 0.5
        return 0.5 - math.pi / (4.0 * self.lift)

    def _parameter(self, loads: Loads, field: str, value: float, unit: str, meaning: str) -> Scalar:
        return loads.parameter(f"{self.body}.air.{field}", value, unit, meaning)

    def _wind(self, loads: Loads) -> Vector3:
        x, y, z = (
            self._parameter(loads, f"wind_{axis}", value, "m/s", f"velocity of the air along {axis}")
            for axis, value in zip("xyz", self.wind or (), strict=True)
        )
        return (x, y, z)


class _Motion(NamedTuple):
    """Of the wing at its origin: velocity, m/s, and angular velocity, rad/s; components chord, span, normal."""

    velocity: Vector3
    spin: Vector3


class _Air:
    """Lift and drag of the strips, per density of the air."""

    def __init__(self, effect: BladeElementDrag, loads: Loads, flat: Wing, motion: _Motion) -> None:
        self.motion = motion

        def parameter(field: str, value: float, unit: str, meaning: str) -> Scalar:
            return loads.parameter(f"{effect.body}.air.{field}", value, unit, meaning)

        self.lift, self.edge_on, self.broadside, self.rotation = (
            parameter(field, getattr(effect, field), "1", meaning) for field, meaning in _COEFFICIENTS.items()
        )
        point = effect.default_lift_point if effect.lift_point is None else effect.lift_point
        self.lift_point = parameter(
            "lift_point", point, "1", "where lift acts, in chords from the leading edge"
        )
        rest = parameter("rest_speed", effect.rest_speed, "m/s", "below which forces fade")
        self.rest = rest * rest

    def wrench(self, loads: Loads, strips: Sequence[Strip]) -> tuple[Vector3, Vector3]:
        """Force and moment about the origin, components chord, span, normal; N and N·m per kg/m³."""
        force, moment = ZERO, ZERO
        for strip in loads.each(strips):
            for place, ahead, up in (self._lift(strip), *self._drags(strip)):
                force = add(force, (ahead, 0, up))
                moment = add(moment, (strip.along * up, -(place * up), -strip.along * ahead))
        return force, moment

    def _lift(self, strip: Strip) -> tuple[Scalar, Scalar, Scalar]:
        """Chordwise place, force ahead and force up. Circulation times velocity, across it (Kutta and Joukowski)."""
        ahead, rising = self._velocity(strip, 0.0)
        translation = self.lift * (ahead * rising) / self._speed(ahead, rising)
        pitching = self.rotation * ((0.75 - strip.axis) * strip.chord * self.motion.spin[1])
        circulation = -strip.chord * strip.width * (translation + pitching)
        place = strip.leading - strip.chord * self.lift_point
        _, rising = self._velocity(strip, place)
        return place, -(circulation * rising), circulation * ahead

    def _drags(self, strip: Strip) -> list[tuple[Scalar, Scalar, Scalar]]:
        """The same of drag, at Gauss points of the chord."""
        found: list[tuple[Scalar, Scalar, Scalar]] = []
        for point, weight in zip(*gauss(CHORD_POINTS), strict=True):
            place = strip.place(0.5 - 0.5 * point)
            ahead, rising = self._velocity(strip, place)
            squared = self.edge_on * (ahead * ahead) + self.broadside * (rising * rising)
            size = -0.25 * weight * strip.chord * strip.width * (squared / self._speed(ahead, rising))
            found.append((place, size * ahead, size * rising))
        return found

    def _velocity(self, strip: Strip, place: Scalar) -> tuple[Scalar, Scalar]:
        """Along the chord and along the normal, m/s, at a chordwise place, m, of a strip."""
        (ahead, _, rising), (roll, pitch, yaw) = self.motion
        return ahead - strip.along * yaw, rising + strip.along * roll - place * pitch

    def _speed(self, ahead: Scalar, rising: Scalar) -> Scalar:
        return call("sqrt", ahead * ahead + rising * rising + self.rest)


def _moved_by_wind(matrix: list[list[float]], own: _Motion, met: _Motion) -> tuple[Vector3, Vector3]:
    """What added mass in a steady wind does beyond added mass in air at rest, per density of the air.

    In axes that go with the wind, air rests and accelerations are the same; only velocities differ.
    """
    fluid = AddedInertia("", 0, ZERO, tuple(tuple(row) for row in matrix))
    in_wind = fluid.wrench(met.velocity, met.spin, ZERO, ZERO)
    at_rest = fluid.wrench(own.velocity, own.spin, ZERO, ZERO)
    force, moment = (add(scale(-1, a), b) for a, b in zip(in_wind, at_rest, strict=True))
    return force, moment


def _rotated(rotation: Matrix3, vector: Vector3) -> Vector3:
    x, y, z = (dot(row, vector) for row in rotation)
    return (x, y, z)


def _components(axes: Sequence[Vector3], vector: Vector3) -> Vector3:
    x, y, z = (dot(axis, vector) for axis in axes)
    return (x, y, z)


def _composed(axes: Sequence[Vector3], components: Vector3) -> Vector3:
    result = ZERO
    for axis, component in zip(axes, components, strict=True):
        result = add(result, scale(component, axis))
    return result

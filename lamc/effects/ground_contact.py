"""Contact with a ground plane: Hunt and Crossley's normal force at points of the bodies, and Coulomb friction.

Goes in: a plane, points, and constants of the contact. Comes out: forces at the points, the energy stored in the
ground, one switch per point. Points do not know of each other, and the ground has no edge.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from lamc.basics.errors import DesignError, about
from lamc.basics.fields import Names, Vector, Whole
from lamc.basics.quantity_fields import Unit
from lamc.effects.contact_points import ContactPoint, Point, check_points, contact_points
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.loads import Loads
from lamc.records.effect import PlaneMark
from lamc.records.mechanism import Array, Mechanism
from lamc.symbolic.algebra import Vector3, add, dot, scale
from lamc.symbolic.scalars import Scalar, call, power

if TYPE_CHECKING:
    from lamc.effects.engine_loads import EngineLoads

STANDARD_GRAVITY = 9.81  # m/s², for a ground of which the scene does not say how stiff it is
SINKING = 1e-3  # of the size: how deep all the weight presses one point into the ground
SLIP = 1e-3  # of the speed sqrt(g size): where friction has reached 0.7 of its strength
MAX_CORNERS = 8  # on each face of a body, unless the scene says otherwise
SHARPNESS = 0.05  # of the clamp that keeps the ground from pulling; see `_push`
STICTION_PEAK = 5.0  # slip speeds at which friction is strongest where its static coefficient is larger


@dataclass(frozen=True)
class GroundContact(RegisteredEffect):
    """A plane that pushes on the points of bodies that are below it, and rubs on those that slide.

    With the depth d of a point and the speed v at which it goes deeper, the ground pushes with
    F = k dⁿ (1 + 3/2 c v), and never pulls: where the law would, as a point leaves at more than 2 / (3 c), the bracket
    goes to nothing smoothly, by 0.035 at most above the law. A blow at a small speed v is returned with the
    restitution 1 - c v.
    Friction is μ F s / sqrt(s² + slip_speed²) against the sliding velocity s, which is smooth: a body at rest on a
    slope creeps, by slip_speed x / sqrt(1 - x²) where x is the tangent of the slope over μ. Integrators stop where
    points touch and leave.
    """

    friction: Annotated[float, Unit("1", "μ, of sliding", ge=0.0)] = 0.5
    static_friction: Annotated[
        float | None,
        Unit(
            "1",
            "the largest coefficient, of what begins to slide; left out: as when sliding. It is reached, within 2 % of "
            "μ, at five times the slip speed",
            ge=0.0,
        ),
    ] = None
    slip_speed: Annotated[
        float | None,
        Unit(
            "m/s",
            "left out: 1e-3 sqrt(g size), where size is the diagonal of the box around all contact points",
            gt=0.0,
        ),
    ] = None
    stiffness: Annotated[
        float | None,
        Unit(
            "1",
            "k, N/m^n; left out: the weight of all that moves, on one point, sinks in by 1e-3 of the size",
            gt=0.0,
        ),
    ] = None
    damping: Annotated[float | None, Unit("s/m", "c; left out: 1 / sqrt(g size)", ge=0.0)] = None
    exponent: Annotated[float, Unit("1", "n: 1.5 (Hertz: round on flat), or 1")] = 1.5
    height: Annotated[
        float,
        Unit(
            "m", "of the plane along its normal, from the world's origin; the bottom of a drawing lies at 0"
        ),
    ] = 0.0
    normal: Annotated[Vector, Unit("1", "out of the ground, world axes; made a unit vector")] = (
        0.0,
        0.0,
        1.0,
    )
    bodies: Annotated[
        Names | None,
        Field(
            description="names of those whose corners can touch; left out: all that move and have an outline, or where "
            "points are listed, none. Corners are those of the hull of the lowest and of the highest face"
        ),
    ] = None
    points: Annotated[
        Mapping[str, tuple[Point, ...]] | Literal["drawn"] | None,
        Unit("m", "further points by body, as drawn; or 'drawn': the contact points of the drawing"),
    ] = None
    corners: Annotated[
        Whole,
        Field(
            ge=3,
            description="at most that many on each face of a body; those go whose loss takes the least area",
        ),
    ] = MAX_CORNERS

    name: ClassVar[str] = "ground_contact"
    summary: ClassVar[str] = "Contact with the ground"
    example: ClassVar[str] = "ground_contact: {friction: 0.4, height: -5 mm}"
    conservative: ClassVar[bool] = False
    source: ClassVar[str] = (
        "F = k d^n (1 + 3/2 c v), Hunt & Crossley 1975; friction mu F s / sqrt(s^2 + vs^2)"
    )
    absent: ClassVar[str] = "no ground is called for"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.exponent not in (1.0, 1.5):
            with about(("exponent",)):
                raise DesignError(
                    f"the exponent of ground contact is {self.exponent:g}; it must be 1.5, as of round on flat, or 1"
                )
        if self.static_friction is not None and self.static_friction < self.friction:
            with about(("static_friction",)):
                raise DesignError(
                    f"the static_friction of ground contact is {self.static_friction:g}, below its friction of "
                    f"{self.friction:g}; what begins to slide is held at least as much as what slides"
                )
        length = math.hypot(*self.normal)
        if not 0.0 < length < math.inf:
            with about(("normal",)):
                raise DesignError(
                    f"the normal of the ground is {list(self.normal)}; it must have a direction and a length"
                )
        if abs(length - 1.0) >= 1e-15:
            object.__setattr__(self, "normal", tuple(x / length for x in self.normal))
        with about(("points",)):
            check_points(self.points)

    def contribute(self, loads: Loads) -> None:
        points = contact_points(loads.mechanism, loads.moving_bodies, self.bodies, self.points, self.corners)
        ground = _Ground(self, loads, points)
        counts: dict[str, int] = {}
        for each in loads.each(points):
            counts[each.body] = counts.get(each.body, 0) + 1
            ground.act(each.body, each.point, f"contact {counts[each.body]} of {each.body}")

    def carry_over(self, engine: "EngineLoads") -> None:
        """The same plane, points and friction; how the ground yields is an engine's own."""
        points = contact_points(
            engine.mechanism, engine.moving_bodies, self.bodies, self.points, self.corners
        )
        weight = _weight(engine.mechanism, engine.moving_bodies)
        stiffness, damping, _ = _constants(self, _size(engine.mechanism, points), weight)
        law = stiffness, self.exponent, damping
        engine.add_ground(points, (self.normal, self.height), self.friction, law, weight)
        if self.static_friction is not None:
            engine.lose("the static friction of the ground (its sliding friction stays)")

    def check_poses(
        self, mechanism: Mechanism, poses: Mapping[str, tuple[Array, Array]], parameters: Mapping[str, float]
    ) -> None:
        """Refuses a start so deep in the ground that it would fling all that moves higher than its own size, and a
        static friction of the run below its friction."""
        self._check_static(parameters)
        points = contact_points(mechanism, tuple(poses), self.bodies, self.points, self.corners)
        coms = {body.name: body.com for body in mechanism.bodies}
        height, stiffness = (parameters[f"{self.name}.{field}"] for field in ("height", "stiffness"))
        placed = [poses[p.body][0] + poses[p.body][1] @ (np.array(p.point) - coms[p.body]) for p in points]
        depths = [max(height - float(np.dot(self.normal, point)), 0.0) for point in placed]
        with np.errstate(over="ignore"):  # what overflows is deep enough
            stored = float(np.sum(stiffness * np.power(depths, self.exponent + 1.0))) / (self.exponent + 1.0)
        thrown = stored / _weight(mechanism, tuple(poses))
        size = _size(mechanism, points)
        if thrown > size:
            deepest = max(depths)
            body = points[depths.index(deepest)].body
            raise DesignError(
                f"at the start a point of body {body!r} is {deepest * 1e3:.3g} mm deep in the ground, which would "
                f"fling all that moves {thrown / size:.3g} times its size high: start it higher, or lower the ground "
                f"from its height of {height * 1e3:.4g} mm"
            )

    def _check_static(self, parameters: Mapping[str, float]) -> None:
        sliding, static = (parameters.get(f"{self.name}.{f}") for f in ("friction", "static_friction"))
        if sliding is not None and static is not None and static < sliding:
            raise DesignError(
                f"parameter '{self.name}.static_friction' is {static:g}, below '{self.name}.friction' of {sliding:g}; "
                "what begins to slide is held at least as much as what slides: change both"
            )

    def marks(self, parameters: Mapping[str, float]) -> tuple[PlaneMark, ...]:
        """The ground."""
        height = parameters.get(f"{self.name}.height", self.height)
        x, y, z = (height * n for n in self.normal)
        return (PlaneMark((x, y, z), self.normal),)


class _Ground:
    """The constants of one contact as parameters, and what they come to at a point."""

    def __init__(self, effect: GroundContact, loads: Loads, points: Sequence[ContactPoint]) -> None:
        self.loads = loads
        self.normal: Vector3 = effect.normal
        self.exponent = effect.exponent
        size = _size(loads.mechanism, points)
        weight = _weight(loads.mechanism, loads.moving_bodies)
        stiffness, damping, slip = _constants(effect, size, weight)

        def parameter(field: str, value: float, unit: str, meaning: str) -> Scalar:
            return loads.parameter(f"{effect.name}.{field}", value, unit, meaning)

        unit = "N/m^1.5" if effect.exponent == 1.5 else "N/m"
        self.height = parameter("height", effect.height, "m", "of the ground along its normal")
        self.stiffness = parameter("stiffness", stiffness, unit, "force over depth to the exponent")
        self.damping = parameter("damping", damping, "s/m", "loss of restitution per speed of impact")
        self.friction = parameter("friction", effect.friction, "1", "coefficient of friction of what slides")
        self.slip = parameter("slip_speed", slip, "m/s", "at which friction has 0.7 of its strength")
        self.extra: Scalar | None = None  # of the static coefficient above that of sliding
        if effect.static_friction is not None:
            static = parameter(
                "static_friction",
                effect.static_friction,
                "1",
                "coefficient of friction of what begins to slide",
            )
            self.extra = static - self.friction

    def act(self, body: str, point: Point, title: str) -> None:
        """Forces and stored energy at one point."""
        loads = self.loads
        velocity = loads.velocity(body, point)
        rising = dot(self.normal, velocity)
        depth = self.height - dot(self.normal, loads.position(body, point))
        touching = loads.switch(title, depth)
        # Beyond the switch the depth is positive but for round-off and for trial states of a step, where a root of a
        # negative number would end the run.
        deep = call("max", depth, 0.0)
        spring = touching * (self.stiffness * (deep if self.exponent == 1.0 else power(deep, 1.5)))
        loads.stored_energy(spring * deep * (1.0 / (self.exponent + 1.0)))
        push = spring * _push(1.0 - 1.5 * (self.damping * rising))
        sliding = add(velocity, scale(-rising, self.normal))
        rub = push * self._rub(sliding)
        loads.force(body, point, add(scale(push, self.normal), scale(-rub, sliding)))

    def _rub(self, sliding: Vector3) -> Scalar:
        """Friction over the pushing force and the sliding velocity, s/m."""
        squared = dot(sliding, sliding)
        steady = self.friction / call("sqrt", squared + self.slip * self.slip)
        if self.extra is None:
            return steady
        # A bump that is 1 at x = 1, where x is the speed over that of the peak: (2 x / (1 + x²))³
        peak = STICTION_PEAK * self.slip
        part = 1.0 / (1.0 + squared / (peak * peak))
        return steady + (8.0 * self.extra / (peak * peak * peak)) * (squared * power(part, 3))


def _size(mechanism: Mechanism, points: Sequence[ContactPoint]) -> float:
    """Diagonal of the box around the points as drawn, m; of the mechanism where they are one point."""
    extent = np.ptp([each.point for each in points], axis=0)
    return float(np.linalg.norm(extent)) or mechanism.size


def _weight(mechanism: Mechanism, moving: Sequence[str]) -> float:
    """Of all that moves, N, on the surface of the earth."""
    return STANDARD_GRAVITY * math.fsum(body.mass for body in mechanism.bodies if body.name in moving)


def _constants(effect: GroundContact, size: float, weight: float) -> tuple[float, float, float]:
    """Stiffness, N/mⁿ, damping, s/m, and slip speed, m/s: as said, or as suits the mechanism."""
    speed = math.sqrt(STANDARD_GRAVITY * size)
    defaults = (weight / (SINKING * size) ** effect.exponent, 1.0 / speed, SLIP * speed)
    said = (effect.stiffness, effect.damping, effect.slip_speed)
    stiffness, damping, slip = (d if s is None else s for s, d in zip(said, defaults, strict=True))
    return stiffness, damping, slip


def _push(w: Scalar) -> Scalar:
    """w where it is positive, and nearly nothing where it is not; smooth, rising, and 1 at w = 1.

    It is s log(1 + exp(w / s)) in the form that does not overflow; with s = 0.05 that differs from w by 1e-10 from
    w = 1 on. The force is thus the law's, up to speeds of leaving near 2 / (3 c), where the law turns to a pull.
    """
    return _soft(w) / _soft(1.0)


def _soft(w: Scalar) -> Scalar:
    return call("max", w, 0.0) + SHARPNESS * call("log", 1.0 + call("exp", abs(w) / -SHARPNESS))

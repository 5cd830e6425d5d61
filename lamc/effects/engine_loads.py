"""`EngineLoads`: what the effects of a scene come to in other engines.

In: calls from `Effect.carry_over`, one effect after the other. Out: records of hinges, springs, torques and the ground,
and what was lost. Never: knows an effect or an engine by name.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from lamc.basics.errors import DesignError, about
from lamc.records.effect import claims_of, overrides
from lamc.records.mechanism import Mechanism
from lamc.records.network import listed_names

if TYPE_CHECKING:
    from lamc.effects.contact_points import ContactPoint
    from lamc.records.effect import Effect

Vector = tuple[float, float, float]
FAR = 1e3  # rad, the limit on a side that has none


@dataclass(frozen=True)
class Stop:
    """Limits of a hinge, rad; None on a side that has none. Torque beyond: stiffness, N·m/rad, damping, N·m·s/rad."""

    lower: float | None
    upper: float | None
    stiffness: float
    damping: float

    @property
    def range(self) -> tuple[float, float]:
        """Both limits, rad, for formats that want two."""
        return (-FAR if self.lower is None else self.lower), (FAR if self.upper is None else self.upper)


@dataclass(frozen=True)
class HingeLoads:
    """What acts on one hinge, on the child about the joint's axis.

    torque = -stiffness (angle - rest_angle) - damping rate + constant + per_angle angle + per_rate rate + drive

    drive    an expression in t (s), angle (rad), rate (rad/s) and inputs of the scene that whoever runs the engine has
             to evaluate; or None
    outside  whether a torque comes from outside as well
    """

    stiffness: float = 0.0  # N·m/rad
    rest_angle: float = 0.0  # rad
    damping: float = 0.0  # N·m·s/rad
    constant: float = 0.0  # N·m
    per_angle: float = 0.0  # N·m/rad
    per_rate: float = 0.0  # N·m·s/rad
    drive: str | None = None
    outside: bool = False
    stop: Stop | None = None

    @property
    def has_torque(self) -> bool:
        """Whether something beside spring, damper and stop acts."""
        linear = bool(self.constant or self.per_angle or self.per_rate)
        return linear or self.drive is not None or self.outside


@dataclass(frozen=True)
class PointSpring:
    """A spring between drawn points, m, world axes, of two bodies, by their names in the design."""

    body_a: str
    point_a: Vector
    body_b: str
    point_b: Vector
    stiffness: float  # N/m
    rest_length: float  # m
    damping: float  # N·s/m


@dataclass(frozen=True)
class GroundPlane:
    """A plane at `height`, m, along its unit normal, that pushes on points of bodies.

    stiffness, exponent, damping  of a point d deep: F = k dⁿ (1 + 3/2 c v); N/mⁿ and s/m
    weight    N, of all that moves, on the surface of the earth
    """

    points: "tuple[ContactPoint, ...]"
    normal: Vector
    height: float
    friction: float
    stiffness: float
    exponent: float
    damping: float
    weight: float


@dataclass(frozen=True)
class Loss:
    """Something that another engine has no place for, in words, and the effect that asked for it, if one did."""

    what: str
    effect: "Effect | None" = None


@dataclass
class EngineLoads:
    """Collects; `carried` is the way to have it filled.

    claims  what one effect of the scene has for itself → that effect's name, as in `Loads`
    lost    what other engines have no place for
    """

    mechanism: Mechanism
    moving_bodies: Sequence[str]
    claims: Mapping[str, str]
    gravity: Vector = (0.0, 0.0, 0.0)  # m/s²
    hinges: dict[str, HingeLoads] = field(default_factory=dict)
    springs: list[PointSpring] = field(default_factory=list)
    ground: GroundPlane | None = None
    lost: list[Loss] = field(default_factory=list)
    effect: "Effect | None" = None  # whose turn it is

    def of(self, joint: str) -> HingeLoads:
        """What acts on the joint so far. Raises DesignError if it is not there."""
        names = [each.name for each in self.mechanism.joints]
        if joint not in names:
            raise DesignError(f"no joint is named {joint!r}; the joints are {listed_names(sorted(names))}")
        return self.hinges.get(joint, HingeLoads())

    def hinge_spring(self, joint: str, stiffness: float) -> None:
        """A linear spring, N·m/rad; it rests as drawn, unless `hinge_rest` says otherwise."""
        self.hinges[joint] = replace(self.of(joint), stiffness=stiffness)

    def hinge_rest(self, joint: str, stiffness: float, angle: float) -> None:
        """The torque stiffness·angle, N·m, which is what moves the rest of a spring to `angle`, rad."""
        before = self.of(joint)
        if before.stiffness == stiffness:
            self.hinges[joint] = replace(before, rest_angle=angle)
        else:
            self.hinge_torque(joint, stiffness * angle)

    def hinge_damper(self, joint: str, damping: float) -> None:
        """A viscous damper, N·m·s/rad."""
        self.hinges[joint] = replace(self.of(joint), damping=damping)

    def hinge_stop(
        self, joint: str, lower: float | None, upper: float | None, stiffness: float, damping: float
    ) -> None:
        """Limits of the angle; see `Stop`."""
        self.hinges[joint] = replace(self.of(joint), stop=Stop(lower, upper, stiffness, damping))

    def hinge_torque(
        self, joint: str, constant: float, per_angle: float = 0.0, per_rate: float = 0.0
    ) -> None:
        """A torque that is linear in angle and rate: N·m, N·m/rad, N·m·s/rad."""
        before = self.of(joint)
        self.hinges[joint] = replace(
            before,
            constant=before.constant + constant,
            per_angle=before.per_angle + per_angle,
            per_rate=before.per_rate + per_rate,
        )

    def hinge_drive(self, joint: str, text: str) -> None:
        """A torque, N·m, by an expression in t, angle and rate, which engines do not read."""
        self.hinges[joint] = replace(self.of(joint), drive=text)

    def hinge_outside(self, joint: str) -> None:
        """A torque that comes from outside while the engine runs."""
        self.hinges[joint] = replace(self.of(joint), outside=True)

    def add_spring(
        self,
        end_a: tuple[str, Vector],
        end_b: tuple[str, Vector],
        stiffness: float,
        rest_length: float,
        damping: float,
    ) -> None:
        """A spring between two points, each with its body; see `PointSpring`. Raises DesignError for a body that is not
        there."""
        links = {
            body.name: "" if body.fixed else body.name for body in self.mechanism.bodies
        }  # the fixed are one
        for name, _ in (end_a, end_b):
            if name not in links:
                raise DesignError(f"no body is named {name!r}; the bodies are {listed_names(sorted(links))}")
        if links[end_a[0]] == links[end_b[0]]:
            self.lose(
                f"the spring between {end_a[0]!r} and {end_b[0]!r}, one rigid body, on which it acts on nothing"
            )
            return
        self.springs.append(PointSpring(*end_a, *end_b, stiffness, rest_length, damping))

    def add_ground(
        self,
        points: "tuple[ContactPoint, ...]",
        plane: tuple[Vector, float],
        friction: float,
        law: tuple[float, float, float],
        weight: float,
    ) -> None:
        """The ground: its plane (normal, height) and its law (stiffness, exponent, damping); see `GroundPlane`."""
        self.ground = GroundPlane(points, *plane, friction, *law, weight)

    def lose(self, what: str) -> None:
        """Something that other engines have no place for."""
        self.lost.append(Loss(what, self.effect))


def carried(mechanism: Mechanism, effects: "Sequence[Effect]", moving_bodies: Sequence[str]) -> EngineLoads:
    """What `effects` come to elsewhere; those without `carry_over` are lost."""
    claims = {claim: effect.name for effect in effects for claim in claims_of(effect)}
    engine = EngineLoads(mechanism, tuple(moving_bodies), claims)
    for effect in effects:
        engine.effect = effect
        with about(effect):
            if overrides(effect, "carry_over"):
                effect.carry_over(engine)
            else:
                engine.lose(f"{effect.name} ({effect.summary})")
    return engine

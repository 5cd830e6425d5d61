"""Effects of the hinges themselves, with values from the joints: stiffness, rest angle, damping (eq. 15-17)."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.loads import Hinge, Loads
from lamc.records.effect import Effect
from lamc.records.mechanism import Joint, Mechanism
from lamc.symbolic.scalars import Scalar

if TYPE_CHECKING:
    from lamc.effects.engine_loads import EngineLoads


def stiffness_claim(joint: str) -> str:
    """What an effect says that gives a hinge its restoring torque: HingeStiffness and RestAngle then leave it out."""
    return f"stiffness of hinge {joint!r}"


def _sprung(loads: Loads) -> Iterator[Hinge]:
    """Hinges with a stiffness that no other effect has taken over."""
    return (
        h for h in loads.hinges() if h.joint.stiffness and stiffness_claim(h.joint.name) not in loads.claims
    )


def _sprung_elsewhere(engine: "EngineLoads") -> Iterator[Joint]:
    """As `_sprung`, for other engines."""
    return (
        j for j in engine.mechanism.joints if j.stiffness and stiffness_claim(j.name) not in engine.claims
    )


def _stiffness(loads: Loads, hinge: Hinge) -> Scalar:
    name = f"{hinge.joint.name}.stiffness"
    return loads.parameter(name, hinge.joint.stiffness, "N·m/rad", "torsional stiffness of the hinge")


@dataclass(frozen=True)
class HingeStiffness(RegisteredEffect):
    """Torque -k q on every hinge with a stiffness; the energy is ½ k q².

    Hinges whose stiffness another effect of the scene claims, such as NonlinearStiffness, are left to that one.
    """

    name: ClassVar[str] = "hinge_stiffness"
    summary: ClassVar[str] = "Hinge stiffness"
    example: ClassVar[str] = "hinge_stiffness:"
    source: ClassVar[str] = "T = -k q, eq. 15"

    def contribute(self, loads: Loads) -> None:
        for hinge in _sprung(loads):
            k = _stiffness(loads, hinge)
            loads.hinge_torque(hinge.joint.name, -(k * hinge.angle))
            loads.stored_energy(0.5 * (k * (hinge.angle * hinge.angle)))

    def carry_over(self, engine: "EngineLoads") -> None:
        """The same springs."""
        for joint in _sprung_elsewhere(engine):
            engine.hinge_spring(joint.name, joint.stiffness)

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[Effect | None, str]:
        count = sum(1 for j in mechanism.joints if j.stiffness)
        return (
            (cls(), f"{count} {'hinge has a stiffness' if count == 1 else 'hinges have a stiffness'}")
            if count
            else (None, "no hinge has a stiffness")
        )


@dataclass(frozen=True)
class RestAngle(RegisteredEffect):
    """Torque +k q₀ on every hinge with a rest angle, which moves the spring's rest from the drawn angle to q₀.

    Its energy, k q₀ (½ q₀ - q), makes the sum with HingeStiffness ½ k (q - q₀)². It acts where HingeStiffness does.
    """

    name: ClassVar[str] = "rest_angle"
    summary: ClassVar[str] = "Rest angle of the hinges"
    example: ClassVar[str] = "rest_angle:"
    source: ClassVar[str] = "T = k q0, eq. 15"

    def contribute(self, loads: Loads) -> None:
        for hinge in _sprung(loads):
            name, value = hinge.joint.name, hinge.joint.rest_angle
            if value:
                k = _stiffness(loads, hinge)
                rest = loads.parameter(f"{name}.rest_angle", value, "rad", "angle at which the hinge rests")
                loads.hinge_torque(name, k * rest)
                loads.stored_energy(k * rest * (0.5 * rest - hinge.angle))

    def carry_over(self, engine: "EngineLoads") -> None:
        """The same springs' rest."""
        for joint in _sprung_elsewhere(engine):
            if joint.rest_angle:
                engine.hinge_rest(joint.name, joint.stiffness, joint.rest_angle)

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[Effect | None, str]:
        count = sum(1 for j in mechanism.joints if j.stiffness and j.rest_angle)
        return (
            (cls(), f"{count} {'hinge rests at an angle' if count == 1 else 'hinges rest at an angle'}")
            if count
            else (None, "every hinge rests as drawn")
        )


@dataclass(frozen=True)
class HingeDamping(RegisteredEffect):
    """Torque -c q̇ on every hinge with a damping."""

    name: ClassVar[str] = "hinge_damping"
    summary: ClassVar[str] = "Hinge damping"
    example: ClassVar[str] = "hinge_damping:"
    source: ClassVar[str] = "T = -c u, eq. 16"

    def contribute(self, loads: Loads) -> None:
        for hinge in loads.hinges():
            name, value = hinge.joint.name, hinge.joint.damping
            if value:
                c = loads.parameter(f"{name}.damping", value, "N·m·s/rad", "viscous damping of the hinge")
                loads.hinge_torque(name, -(c * hinge.rate))

    def carry_over(self, engine: "EngineLoads") -> None:
        """The same dampers."""
        for joint in engine.mechanism.joints:
            if joint.damping:
                engine.hinge_damper(joint.name, joint.damping)

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[Effect | None, str]:
        count = sum(1 for j in mechanism.joints if j.damping)
        return (
            (cls(), f"{count} {'hinge is damped' if count == 1 else 'hinges are damped'}")
            if count
            else (None, "no hinge is damped")
        )

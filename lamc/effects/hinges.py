"""Effects of the hinges themselves, with values from the joints: stiffness, rest angle, damping (eq. 15-17)."""

from dataclasses import dataclass
from typing import ClassVar, Self

from lamc.effects.base import Effect
from lamc.errors import DesignError
from lamc.mechanics.loads import Loads
from lamc.mechanism.records import Mechanism


def _no_value(kind: str, value: object, where: str) -> None:
    if value not in (None, True, {}):
        raise DesignError(f"{where}: {kind} takes no value, since its values come from the joints; it has {value!r}")


@dataclass(frozen=True)
class HingeStiffness:
    """Torque -k q on every hinge with a stiffness; the energy is ½ k q²."""

    name: ClassVar[str] = "hinge_stiffness"
    summary: ClassVar[str] = "Hinge stiffness"
    source: ClassVar[str] = "T = -k q, eq. 15"

    def contribute(self, loads: Loads) -> None:
        for name in loads.joints:
            stiffness = loads.mechanism.joint(name).stiffness
            if stiffness:
                k = loads.parameter(f"{name}.stiffness", stiffness, "N·m/rad", "torsional stiffness of the hinge")
                q = loads.angle(name)
                loads.hinge_torque(name, -(k * q))
                loads.stored_energy(0.5 * (k * (q * q)))

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[Effect | None, str]:
        count = sum(1 for j in mechanism.joints if j.stiffness)
        return (cls(), f"{count} hinges have a stiffness") if count else (None, "no hinge has a stiffness")

    @classmethod
    def from_data(cls, value: object, where: str) -> Self:
        """From a scene file: takes no value."""
        _no_value("hinge_stiffness", value, where)
        return cls()


@dataclass(frozen=True)
class RestAngle:
    """Torque +k q₀ on every hinge with a rest angle, which moves the spring's rest from the drawn angle to q₀.

    Its energy, k q₀ (½ q₀ - q), makes the sum with HingeStiffness ½ k (q - q₀)².
    """

    name: ClassVar[str] = "rest_angle"
    summary: ClassVar[str] = "Rest angle of the hinges"
    source: ClassVar[str] = "T = k q0, eq. 15"

    def contribute(self, loads: Loads) -> None:
        for name in loads.joints:
            joint = loads.mechanism.joint(name)
            if joint.stiffness and joint.rest_angle:
                k = loads.parameter(f"{name}.stiffness", joint.stiffness, "N·m/rad", "torsional stiffness of the hinge")
                rest = loads.parameter(f"{name}.rest_angle", joint.rest_angle, "rad", "angle at which the hinge rests")
                loads.hinge_torque(name, k * rest)
                loads.stored_energy(k * rest * (0.5 * rest - loads.angle(name)))

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[Effect | None, str]:
        count = sum(1 for j in mechanism.joints if j.stiffness and j.rest_angle)
        return (cls(), f"{count} hinges rest at an angle") if count else (None, "every hinge rests as drawn")

    @classmethod
    def from_data(cls, value: object, where: str) -> Self:
        """From a scene file: takes no value."""
        _no_value("rest_angle", value, where)
        return cls()


@dataclass(frozen=True)
class HingeDamping:
    """Torque -c q̇ on every hinge with a damping."""

    name: ClassVar[str] = "hinge_damping"
    summary: ClassVar[str] = "Hinge damping"
    source: ClassVar[str] = "T = -c u, eq. 16"

    def contribute(self, loads: Loads) -> None:
        for name in loads.joints:
            damping = loads.mechanism.joint(name).damping
            if damping:
                c = loads.parameter(f"{name}.damping", damping, "N·m·s/rad", "viscous damping of the hinge")
                loads.hinge_torque(name, -(c * loads.rate(name)))

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[Effect | None, str]:
        count = sum(1 for j in mechanism.joints if j.damping)
        return (cls(), f"{count} hinges are damped") if count else (None, "no hinge is damped")

    @classmethod
    def from_data(cls, value: object, where: str) -> Self:
        """From a scene file: takes no value."""
        _no_value("hinge_damping", value, where)
        return cls()

"""Gravity: a uniform field that accelerates all mass alike."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

from lamc.basics.fields import Vector
from lamc.basics.quantity_fields import Unit
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.loads import Loads
from lamc.records.effect import Effect
from lamc.records.mechanism import Mechanism

if TYPE_CHECKING:
    from lamc.effects.engine_loads import EngineLoads

STANDARD = (0.0, 0.0, -9.81)  # m/s², the value of popupCAD and of the paper


@dataclass(frozen=True)
class Gravity(RegisteredEffect):
    """Field strength, m/s², world axes. Components that are zero are left out of the equations."""

    acceleration: Annotated[Vector, Unit("m/s^2", "of what falls, along world x, y and z")] = STANDARD

    name: ClassVar[str] = "gravity"
    summary: ClassVar[str] = "Gravity"
    example: ClassVar[str] = "gravity: [0, 0, -9.81]"
    source: ClassVar[str] = "F = m g, eq. 18"
    shorthand: ClassVar[str] = "acceleration"

    def contribute(self, loads: Loads) -> None:
        components = [
            loads.parameter(
                f"gravity.{axis}", value, "m/s²", f"gravitational acceleration along world {axis}"
            )
            if value
            else 0
            for axis, value in zip("xyz", self.acceleration, strict=True)
        ]
        loads.uniform_field(components)

    def carry_over(self, engine: "EngineLoads") -> None:
        """The same field."""
        engine.gravity = self.acceleration

    @classmethod
    def default_for(cls, mechanism: Mechanism) -> tuple[Effect | None, str]:
        return cls(), "-9.81 m/s² along z unless a scene says otherwise"

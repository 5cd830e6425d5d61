"""Torques on hinges, constant or given by expressions in time and in the hinge's own angle and rate."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, ClassVar

from lamc.basics.quantity_fields import Unit
from lamc.effects.drives import Drive, checked_drive
from lamc.effects.external_torque import constant_claim, is_outside
from lamc.effects.linear_drive import linear_drive
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.loads import Loads
from lamc.symbolic.expression import stage

if TYPE_CHECKING:
    from lamc.effects.engine_loads import EngineLoads


@dataclass(frozen=True)
class Torque(RegisteredEffect):
    """Torques by joint name, N·m, on the child about the joint's axis.

    A number is a parameter of the simulator; a string is an expression in t (s), angle (rad) and rate (rad/s), and in
    inputs of the scene. Raises ExpressionError when it is made with an expression outside the language.
    """

    torques: Annotated[Mapping[str, float | str], Unit("N*m", "by joint name, on the child")] = field(
        default_factory=dict
    )

    name: ClassVar[str] = "torque"
    summary: ClassVar[str] = "Applied hinge torques"
    example: ClassVar[str] = "torque: {knee: 0.1 N*mm, hip: 1e-4*sin(2*pi*5*t) - 1e-6*rate}"
    source: ClassVar[str] = "eq. 17"
    shorthand: ClassVar[str] = "torques"
    absent: ClassVar[str] = "no torque is called for"

    def __post_init__(self) -> None:
        super().__post_init__()
        for drive in self.drives():
            checked_drive(drive)

    def contribute(self, loads: Loads) -> None:
        for joint, torque in self.torques.items():
            if isinstance(torque, str):
                hinge = loads.hinge(joint)
                names = {"t": loads.time, "angle": hinge.angle, "rate": hinge.rate, **loads.inputs}
                loads.hinge_torque(joint, stage(torque, names))
            else:
                loads.hinge(joint)
                applied = loads.parameter(
                    f"{joint}.torque",
                    torque,
                    "N·m",
                    "applied torque",
                    is_input=is_outside(joint, loads.claims),
                )
                loads.hinge_torque(joint, applied)

    def claims(self) -> tuple[str, ...]:
        return tuple(
            constant_claim(joint) for joint, value in self.torques.items() if not isinstance(value, str)
        )

    def carry_over(self, engine: "EngineLoads") -> None:
        """The same torques; expressions that are not linear are left to whoever runs the engine."""
        for joint, torque in self.torques.items():
            linear = linear_drive(torque) if isinstance(torque, str) else (torque, 0.0, 0.0)
            if linear is not None:
                engine.hinge_torque(joint, *linear)
            else:
                engine.hinge_drive(joint, str(torque))

    def drives(self) -> tuple[Drive, ...]:
        """The torques that are expressions."""
        return tuple(_drive(joint, text) for joint, text in self.torques.items() if isinstance(text, str))


def _drive(joint: str, text: str) -> Drive:
    return Drive(f"the torque of joint {joint!r}", text, joint, field=("torques", joint))

"""Torques on hinges, constant or given by expressions in time and in the hinge's own angle and rate."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from lamc.basics.checks import shown
from lamc.basics.errors import DesignError
from lamc.basics.readonly import ReadOnlyDict
from lamc.effects.data import is_measured, quantity, refusal
from lamc.effects.drives import Drive, checked_drive
from lamc.effects.external_torque import constant_claim, is_outside
from lamc.effects.linear_drive import linear_drive
from lamc.effects.registered import RegisteredEffect
from lamc.mechanics.loads import Loads
from lamc.records.mechanism import checked_name, checked_number
from lamc.symbolic.expression import stage

if TYPE_CHECKING:
    from lamc.effects.engine_loads import EngineLoads


@dataclass(frozen=True)
class Torque(RegisteredEffect):
    """Torques by joint name, N·m, on the child about the joint's axis.

    A number is a parameter of the simulator; a string is an expression in t (s), angle (rad) and rate (rad/s), and in
    inputs of the scene. Raises ExpressionError when it is made with an expression outside the language.
    """

    torques: Mapping[str, float | str] = field(default_factory=dict)

    name: ClassVar[str] = "torque"
    summary: ClassVar[str] = "Applied hinge torques"
    source: ClassVar[str] = "eq. 17"
    shorthand: ClassVar[str] = "torques"
    units: ClassVar[Mapping[str, str]] = {"torques": "N*m"}
    absent: ClassVar[str] = "no torque is called for"

    def __post_init__(self) -> None:
        if not isinstance(self.torques, Mapping):
            raise DesignError(f"torques are {self.torques!r}; give a mapping from joint name to torque")
        checked: dict[str, float | str] = {}
        for joint, torque in sorted(self.torques.items(), key=lambda item: str(item[0])):
            checked_name(joint, "the joint of a torque")
            if isinstance(torque, str):
                checked[joint] = checked_drive(_drive(joint, torque)).text
            else:
                checked[joint] = checked_number(torque, f"the torque of joint {joint!r}")
        object.__setattr__(self, "torques", ReadOnlyDict(checked))

    def __hash__(self) -> int:
        return hash(tuple(self.torques.items()))

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

    @classmethod
    def from_data(cls, value: object, where: str) -> "Torque":
        """From a scene file: a map from joint name to a number (N·m, or with its unit) or an expression."""
        if not isinstance(value, Mapping):
            raise refusal(where, f"torque is {shown(value)}; give a mapping such as {{h1: 0.02}}")
        torques = {}
        for joint, torque in value.items():
            if isinstance(torque, str) and is_measured(torque):
                torques[str(joint)] = quantity(torque, cls.units["torques"], where, str(joint))
            else:
                torques[str(joint)] = torque
        return cls(torques)


def _drive(joint: str, text: str) -> Drive:
    return Drive(f"the torque of joint {joint!r}", text, joint)

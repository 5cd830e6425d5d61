"""Servos as numbers: the torque of one at an angle and a rate, from its data.

An independent reading, written as clipping where the compiler has events. Plain numbers; nothing is imported from the
effect.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Joint
from lamc.reference.expression import Formula, Values, parse


def place(effect: Any, joints: Sequence[Joint]) -> int:
    """Index of the joint that it acts on. Raises DesignError where there is none of that name."""
    names = [joint.name for joint in joints]
    if effect.joint not in names:
        raise DesignError(
            f"the scene puts a servo on joint {effect.joint!r}, which the mechanism does not have"
        )
    return names.index(effect.joint)


def servo(effect: Any) -> Formula:
    """Torque of a servo, N·m."""
    command = parse(effect.command) if isinstance(effect.command, str) else lambda _: float(effect.command)

    def torque(values: Values) -> float:
        error, rate = command(values) - values["angle"], values["rate"]
        if abs(error) <= effect.dead_band:
            error = 0.0
        else:
            error -= np.sign(error) * effect.dead_band
        asked = effect.stiffness * error - effect.damping * rate
        if effect.stall_torque is None:
            return float(asked)
        induced = 0.0 if effect.no_load_speed is None else rate / effect.no_load_speed
        share = np.clip(asked / effect.stall_torque + induced, -1.0, 1.0)  # of the supply
        return float(effect.stall_torque * (share - induced))

    return torque


@dataclass(frozen=True)
class LooseGear:
    """A gear with play: its coordinate is the joint's name with ".gear".

    motor  torque on the gear, by its own angle and rate
    """

    joint: str
    place: int  # of the joint
    inertia: float  # kg·m²
    half: float  # rad, of the play
    stiffness: float  # N·m/rad
    damping: float  # N·m·s/rad
    motor: Formula

    def push(self, ahead: float, opening: float) -> float:
        """Torque on the joint, N·m, and back on the gear, which is ahead by that."""
        if abs(ahead) <= self.half:
            return 0.0
        return float(self.stiffness * (ahead - np.copysign(self.half, ahead)) + self.damping * opening)

    def energy(self, ahead: float, rate: float) -> float:
        """Of the flanks and of the gear's turning, J."""
        pressed = max(abs(ahead) - self.half, 0.0)
        return 0.5 * self.stiffness * pressed**2 + 0.5 * self.inertia * rate**2


def loose_gear(effect: Any, joints: Sequence[Joint]) -> LooseGear:
    return LooseGear(
        effect.joint,
        place(effect, joints),
        effect.gear_inertia,
        0.5 * effect.backlash,
        effect.gear_stiffness,
        effect.gear_damping,
        servo(effect),
    )

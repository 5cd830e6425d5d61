"""Servos as numbers: the torque of one at an angle and a rate, from its data.

An independent reading, written as clipping where the compiler has events. Plain numbers; nothing is imported from the
effect.
"""

from collections.abc import Sequence
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

"""Angles held against the limits of their joints.

In: a mechanism and angles by joint name. Out: what lies outside, in words. Never: knows an effect, or moves anything.
"""

from collections.abc import Mapping

from lamc.records.mechanism import Mechanism

# rad: a start on its limit counts as inside, also where closing a loop has rounded it.
ROUNDING = 1e-9


def outside_limits(mechanism: Mechanism, angles: Mapping[str, float]) -> tuple[str, ...]:
    """One phrase for each joint whose angle (rad) lies outside its limits; joints without limits have none."""
    reported = []
    for joint in mechanism.joints:
        lower, upper = joint.limits
        angle = angles.get(joint.name, 0.0)
        if joint.is_limited and not lower - ROUNDING <= angle <= upper + ROUNDING:
            reported.append(
                f"joint {joint.name!r} starts at {angle:.4g} rad, outside its limits ({lower:.4g}, {upper:.4g})"
            )
    return tuple(reported)

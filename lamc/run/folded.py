"""Whether the fold of a sheet is over: it lies folded flat, or its facets have gone through one another.

In: a mechanism, the names of its joints in the order of a state. Out: a question to ask of states. Never: knows of
contact; goes by angles alone.
"""

from collections.abc import Callable, Sequence

import numpy as np

from lamc.records.mechanism import Array, Mechanism

NEAR = np.radians(1.0)  # of 0 or a half turn: nearer, loops that pass through it take steps without end
# Beyond a half turn. A facet on a crease of its own that rests at 180°, damped as sheets are, swings 16 % of it beyond,
# 29°, and comes back.
THROUGH = np.radians(30.0)
_PARALLEL = 1e-6  # sine of the angle between axes, as drawn


def fold_over(mechanism: Mechanism, joints: Sequence[str]) -> Callable[[Array], str] | None:
    """Tells of a state why the fold of a sheet is over, empty where it is not: all hinges are within `NEAR` of 0, or of
    half turns and beyond; or one is `THROUGH` beyond a half turn. None where that is no sheet's end: without plates at
    all hinges, or with axes that are all parallel, as of planar linkages, which pass such positions in the middle of
    their motion."""
    has_plates = {body.name: bool(body.outline) for body in mechanism.bodies}
    hinges = mechanism.joints
    if {joint.name for joint in hinges} != set(joints):
        return None
    if not all(has_plates[joint.parent] and has_plates[joint.child] for joint in hinges):
        return None
    axes = np.array([joint.axis for joint in hinges]).reshape(-1, 3)
    if not len(axes) or np.abs(np.cross(axes, axes[0])).max() <= _PARALLEL:
        return None
    count = len(joints)

    def over(state: Array) -> str:
        angles = np.abs(state[:count])
        is_folded = angles >= np.pi - NEAR
        if is_folded.any() and (is_folded | (angles <= NEAR)).all():
            return "it is folded flat: all hinges are at 0°, or at ±180° and beyond, to 1°"
        farthest = int(np.argmax(angles))
        if angles[farthest] <= np.pi + THROUGH:
            return ""
        return f"hinge {joints[farthest]!r} is 30° beyond ±180°: facets have gone through one another"

    return over

"""Angles of a folded sheet made to fit: corners of a file are rounded, and loops of creases close exactly.

In: a flat mechanism, and angles as measured in the file. Out: the nearest angles at which all loops close. Never: moves
them by more than rounding without a note.
"""

from collections.abc import Mapping

import numpy as np

from lamc.basics.threads import on_one_thread
from lamc.loops.closing import settle
from lamc.loops.geometry import LoopGeometry
from lamc.mechanism.plan import plan
from lamc.records.mechanism import Mechanism

_CLOSED = 1e-9  # rad, and of the size: a start of all angles is held to about this
# Of the root of the gap: loops near a singular place close a gap g within about its root, as a quadratic does, others
# within g times a few. What is moved farther went along a motion that corners rounded otherwise would not have, and the
# place it comes to has nothing to do with the file's.
_NEAR = 3.0
_TOLD = 1e-2  # rad: coordinates of four digits leave less


@on_one_thread
def fitted(mechanism: Mechanism, angles: Mapping[str, float], notes: list[str]) -> dict[str, float]:
    """Angles by joint, rad; as they are where there is no loop, or where none is near."""
    if len(mechanism.joints) <= sum(not body.fixed for body in mechanism.bodies):
        return dict(angles)
    geometry = LoopGeometry(plan(mechanism))
    measured = np.array([angles.get(name, 0.0) for name in geometry.names])
    found, error = settle(geometry, measured)
    if error > _CLOSED:
        return dict(angles)  # the start says what resists
    moved = np.abs(found - measured)
    worst = int(moved.argmax())
    gap = float(np.abs(geometry.closure(measured)[0]).max(initial=0.0))
    if moved[worst] > _NEAR * np.sqrt(gap):
        return dict(angles)
    if moved[worst] > _TOLD:
        notes.append(
            f"the folded sheet closes about its vertices only with other angles, by {np.degrees(moved[worst]):.2g} "
            f"degrees at {geometry.names[worst]!r}; it starts with those"
        )
    return dict(zip(geometry.names, found.tolist(), strict=True))

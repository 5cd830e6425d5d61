"""What to mind of an equilibrium.

In: where a search ended, and what resists there. Out: lines for people. Never: searches.
"""

import math

import numpy as np

from lamc.records.mechanism import Mechanism
from lamc.records.network import listed_names
from lamc.run.balance import Search
from lamc.run.request import Array
from lamc.run.stability import Resistance

_CLOSE_TO_FADED = 1e-3  # of the strongest equation of the loops
_SOFTEST = 1e-9  # of the largest stiffness: a position is known less well by as much
_FLAT = math.pi + 1e-6  # rad: a fold that lies flat on itself is not beyond


def notes_of(
    mechanism: Mechanism, q: Array, ended: Search, found: Resistance, *, has_time: bool
) -> tuple[str, ...]:
    """The lines. q: (nq,), with what follows from poses."""
    notes, stand = [], ended.stand
    if has_time:
        notes.append(f"loads are those at t = {stand.rest.t:g} s, held still")
    if not np.any(np.abs(found.stiffness) > 0.0) and len(found.stiffness):
        notes.append("no load depends on the position: every position nearby is as good")
    elif found.kind == "neutral":
        notes.append("what is not held stays where the start had it")
    if ended.way == "descended":
        notes.append("found by descent: others may lie nearer to the start")
    if stand.weakest < _CLOSE_TO_FADED:
        notes.append(
            f"an equation of the loops has faded to {stand.weakest:.1e} of the strongest: the position is near a "
            "singular one, or a mechanism of very many loops is soft"
        )
    sizes = np.abs(np.linalg.eigvals(found.stiffness)) if len(found.stiffness) else np.ones(1)
    if found.kind != "neutral" and sizes.min() < _SOFTEST * sizes.max():
        notes.append(
            f"the softest direction has {sizes.min() / sizes.max():.1e} of the largest stiffness over inertia"
        )
    return (*notes, *_out_of_bounds(mechanism, q, ended))


def _out_of_bounds(mechanism: Mechanism, q: Array, ended: Search) -> tuple[str, ...]:
    """Joints beyond limits that nothing holds them to, and folds that went through themselves."""
    model = ended.stand.rest.motion.model
    names = [c.name for c in model.coordinates]
    angles = {j.name: float(q[names.index(j.name)]) for j in mechanism.joints if j.name in names}
    held = {name.rpartition(".")[0] for name in model.parameters if name.endswith("_limit")}
    free = {name: angle for name, angle in angles.items() if name not in held}
    notes = []
    for joint in mechanism.joints:
        lower, upper = joint.limits
        if joint.is_limited and joint.name in free and not lower <= free[joint.name] <= upper:
            notes.append(
                f"joint {joint.name!r} rests at {free[joint.name]:.4g} rad, outside its limits ({lower:.4g}, "
                f"{upper:.4g}), and the scene does not hold it to them: add joint_limits"
            )
    plated = {body.name for body in mechanism.bodies if body.outline}
    through = [
        joint.name
        for joint in mechanism.joints
        if abs(free.get(joint.name, 0.0)) > _FLAT and {joint.parent, joint.child} <= plated
    ]
    if through:
        notes.append(f"{listed_names(through)}: beyond ±180°, where the two faces of a fold meet")
    return tuple(notes)

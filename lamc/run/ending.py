"""How a run ended, for people: what happened, when, at which joint or loop, and the way out.

In: a `Trajectory` and the motion that it is of. Out: one line. Never: decides how a run ends.
"""

from collections.abc import Callable

import numpy as np

from lamc.loops.geometry import LoopGeometry
from lamc.loops.misfit import length, widest_gap
from lamc.loops.rank import LoopCount
from lamc.loops.texts import MAY_BEND
from lamc.records.mechanism import Array
from lamc.run.model import Motion
from lamc.run.request import Request, Status, Trajectory


def message(
    trajectory: Trajectory, request: Request, motion: Motion, gap_at: Callable[[Array], str] | None = None
) -> str:
    """One line about the end of the run. gap_at: how far loops are open at angles (n,), rad, in words."""
    at = f"at t = {trajectory.t_reached:.9g} s"
    status = trajectory.status
    if status == Status.REACHED_END:
        return f"the end was reached {at}"
    if status == Status.FOLDED:
        return f"ended {at} of {request.t_end:g} s: {trajectory.note}"
    if status == Status.STEP_LIMIT and trajectory.note:
        way_out = "raise max_work (of lamc run, --t-end), or loosen rtol"
        return f"stopped {at} of {request.t_end:g} s: {trajectory.note}; {way_out}"
    text = {
        Status.STEP_UNDERFLOW: f"stopped {at}: no step is short enough there; the motion is singular, or a torque "
        "grows without bound",
        Status.NOT_FINITE: f"stopped {at}: the accelerations beyond are not finite (NaN or infinity), however short "
        "the step; look at the torques and parameters",
        Status.STEP_LIMIT: f"stopped {at} of {request.t_end:g} s: {request.max_steps} steps were tried; raise "
        "max_steps or loosen rtol",
        Status.CLOSURE_LOST: f"stopped {at}: a loop came apart, no position nearby closes it; look at forces and rates",
        Status.RANK_LOST: f"stopped {at}: the motion stays at a singular position, where forces do not determine "
        "which branch it takes; start on a branch (Scene(branch=…)) or change what holds it there",
        Status.EVENTS_PILE_UP: f"stopped {at}: impacts follow each other ever faster (Zeno); let the limit give way "
        "with JointLimits(stiffness=…, damping=…) where a joint comes to rest on it",
        Status.CANCELLED: f"cancelled {at} of {request.t_end:g} s; what was computed is kept",
        Status.FAILED: f"stopped {at}: the integrator failed",
    }[status]
    gap = ""
    if status == Status.CLOSURE_LOST and gap_at is not None and len(trajectory.q):
        gap = gap_at(trajectory.q[-1, : len(motion.model.joints)])
    notes = [note for note in (_concerned(trajectory, motion), gap, trajectory.note) if note]
    return f"{text} ({'; '.join(notes)})" if notes and status < 0 else text


def _concerned(trajectory: Trajectory, motion: Motion) -> str:
    """The joint or loop that the end is about; empty where there is none."""
    model = motion.model
    match trajectory.status:
        case Status.STEP_UNDERFLOW | Status.NOT_FINITE if len(trajectory.u) and len(model.rates):
            rates = np.abs(trajectory.u[-1])
            fastest = int(np.argmax(rates))
            what = "joint" if fastest < len(model.joints) else "coordinate"
            rate = model.rates[fastest]
            return f"the fastest {what} is {rate.name!r}, at {rates[fastest]:.3g} {rate.unit}"
        case Status.CLOSURE_LOST | Status.RANK_LOST:
            loops = ", ".join(repr(name) for name in model.cuts[:4])
            more = f" and {len(model.cuts) - 4} more" if len(model.cuts) > 4 else ""
            return f"loop closed by {loops}{more}"
        case Status.EVENTS_PILE_UP if trajectory.events:
            return f"at {model.guards[trajectory.events[-1][1]]}"
    return ""


def gap_text(geometry: LoopGeometry, count: LoopCount, angles: Array) -> str:
    """Where loops are open at angles (n,), rad, of all joints in the order of `geometry.names`, and how far; why, where
    the drawing closes only nearly."""
    at, gap = widest_gap(geometry, angles)
    text = f"open by {length(gap)} there, most around {at} as drawn"
    if count.misfit is None or count.misfit.gap < 1e-9 * geometry.size:
        return text
    return (
        f"{text}; the drawing closes only within {length(count.misfit.gap)}, which grows towards positions like this "
        f"one: draw it with more digits; {MAY_BEND}"
    )

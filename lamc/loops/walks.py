"""Small steps along a motion of the loops: where it leads, and how well they close there.

In: a `LoopGeometry`, a position, a direction. Out: `LoopPosition`s. Never: decides on a rank.
"""

from dataclasses import dataclass

import numpy as np

from lamc.loops.closing import CLOSED, SOLVE, STILL, settle
from lamc.loops.geometry import LoopGeometry
from lamc.loops.linear import DENSE, EXACT
from lamc.records.mechanism import Array

STEPS = (0.1, 0.02, 4e-3)  # rad, of the joint that turns most; shorter where the first step is too long
BENT = 0.7  # of a step: what is farther from the tangent is another motion
TURNED = 0.5  # of a tangent: less of it is left where the motion does not go on
GAP = 10.0  # between singular values: wider ones may part a misfit's from others
CREEPING = (
    1e-6  # rad: shorter steps of many loops that fit badly change a gap by a hundredth of what is allowed
)
APART = 0.05  # rad, or of lengths: loops farther apart do not fit badly, they do not fit


@dataclass(frozen=True, eq=False)
class LoopPosition:
    """A position. angles (n,), rad; error: largest residual of closure, rad or parts of lengths; weak (k,): the
    smallest singular values of the closure matrix there, of the largest, ascending."""

    angles: Array
    error: float
    weak: Array

    @property
    def is_closed(self) -> bool:
        return self.error <= CLOSED

    def clearness(self, nullity: int) -> float:
        """The least of the singular values but for the first `nullity` ones."""
        return float(self.weak[nullity]) if nullity < len(self.weak) else 1.0

    def gaps(self, most: float) -> list[int]:
        """After how many singular values there are wide gaps, below `most` or at it; ascending."""
        known = self.weak
        count = min(int((known < most).sum()), len(known) - 1)
        return [k for k in range(1, count + 1) if known[k] > GAP * max(known[k - 1], EXACT)]

    def lesser(self, most: float) -> int:
        """How many singular values are below the widest gap of those below `most`, round-off among them."""
        known = self.weak
        least, count = int((known <= EXACT).sum()), min(int((known < most).sum()), len(known) - 1)
        ratios = [(known[k] / known[k - 1], k) for k in range(least + 1, count + 1)]
        return max(ratios)[1] if ratios else least


def walk(
    geometry: LoopGeometry,
    start: Array,
    tangent: Array,
    cutoff: float,
    count: int,
    nullity: int | None = None,
) -> list[LoopPosition]:
    """At most `count` places from `start` (n,) along `tangent` (n,), without the start; none where no motion goes on.

    cutoff   singular values below it, of the largest, hold nothing: with a coarse one, loops that fit badly stay open
    nullity  how many of the weakest hold nothing, instead
    """
    best: list[LoopPosition] = []
    for step in STEPS:
        places = _walk(geometry, start, tangent, cutoff, count, step, nullity)
        best = places if len(places) > len(best) else best
        if len(best) >= min(count, 2):
            break
    return best


def _walk(
    geometry: LoopGeometry,
    angles: Array,
    tangent: Array,
    cutoff: float,
    count: int,
    step: float,
    nullity: int | None,
) -> list[LoopPosition]:
    places: list[LoopPosition] = []
    open_most = CLOSED if cutoff <= EXACT and nullity is None else APART
    across = None if nullity is None else nullity - 1  # with the joint that leads held
    still = STILL if open_most == CLOSED or len(angles) <= DENSE else CREEPING
    linear = geometry.linear(angles)
    for _ in range(count):
        lead = int(np.argmax(np.abs(tangent)))
        ahead = tangent * (step / abs(tangent[lead]))
        free = np.arange(len(angles)) != lead
        reach = BENT * step
        following, error = settle(
            geometry, angles + ahead, free, max(cutoff, SOLVE), across, still=still, reach=reach
        )
        if error > open_most or np.abs(following - angles - ahead).max() > reach:
            break
        linear = geometry.linear(following).after(linear)
        motions = linear.free(max(cutoff, EXACT)) if nullity is None else linear.weak[1][:nullity]
        if not len(motions):  # it closes here, and goes no farther
            break
        places.append(LoopPosition(following, error, linear.weak[0]))
        tangent = motions.T @ (motions @ ahead)
        if np.linalg.norm(tangent) < TURNED * np.linalg.norm(ahead):
            break
        angles = following
    return places

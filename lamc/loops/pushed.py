"""Which way out of a singular start loads choose: the branch on which they do most work.

In: a position, its branches, and what loads do along rates, as a function. Out: the number of a branch. Never: knows
what loads there are.

From rest a force p along a branch of inertia I does the work (p t)² / (2 I) in a time t: the first order goes by
p / √I. Where p vanishes at the singular position and grows with the way s from it, the motion grows as
exp(√(p / (I s)) t): the second order goes by p / (I s), and what it does is nothing against a first order.
"""

import math
from collections.abc import Callable, Sequence

from lamc.loops.branches import Branch, moved_out
from lamc.loops.geometry import LoopGeometry
from lamc.loops.tangents import EXACTLY, Fit
from lamc.records.mechanism import Array

SECOND = 1e-2  # of the second order: less is no first order, but what the third leaves, some thousandths
EQUAL = (
    1e-4  # of the most: what differs by less is a tie; mirror images differ by round-off near singular, 1e-7
)

Push = Callable[
    [Array, Array], tuple[float, float]
]  # of angles (n,) and rates τ (n,): power f·τ, W, and τ·M τ, 2 J


def pushed_branch(
    geometry: LoopGeometry, angles: Array, branches: Sequence[Branch], push: Push, fit: Fit = EXACTLY
) -> int | None:
    """The number of the branch to take from a singular position `angles` (n,) at rest, negative for its opposite way.

    The one on which loads do most work, to the first order, or to the second where the first vanishes on all; of equal
    ones the first. None where there is none to choose.
    """
    orders = [_orders(geometry, angles, branch.row(geometry.names), push, fit) for branch in branches]
    first = [way * p for p, _ in orders for way in (1.0, -1.0)]
    second = [p for _, both in orders for p in both]
    works = first if any(first) else second
    known = [abs(work) for work in works if math.isfinite(work)]
    most = max(works, default=0.0) - EQUAL * max(known, default=0.0)
    taken = next((k for k, work in enumerate(works) if work >= most), None)
    return None if taken is None else (taken // 2 + 1) * (1 if taken % 2 == 0 else -1)


def _orders(
    geometry: LoopGeometry, angles: Array, way: Array, push: Push, fit: Fit
) -> tuple[float, tuple[float, float]]:
    """What loads do a little along a branch: the first order, and the second there and along its opposite, minus
    infinity where it has no opposite."""
    forth, back = moved_out(geometry, angles, way, fit), moved_out(geometry, angles, -way, fit)
    if forth is None:  # loops that fit badly may close on one side only
        assert back is not None, "a branch was followed when it was found"
        behind, inertia = push(back, -way)
        return (0.0, (0.0, 0.0)) if not inertia > 0.0 else (0.0, (-math.inf, behind / inertia))
    ahead, inertia = push(forth, way)
    if not inertia > 0.0:
        return 0.0, (0.0, 0.0)
    if back is None:
        return 0.0, (ahead / inertia, -math.inf)
    behind, _ = push(back, -way)
    first, second = 0.5 * (ahead - behind), 0.5 * (ahead + behind)
    if abs(first) <= SECOND * abs(second):
        first = 0.0
    return first / math.sqrt(inertia), (second / inertia, second / inertia)

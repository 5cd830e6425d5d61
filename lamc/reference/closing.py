"""States for comparisons: of trees anywhere, of loops on closure.

In: the Newton-Euler cross-check, which knows the geometry. Out: random states, and states brought to closure by
Gauss-Newton. It shares no code with the starts of a run and uses no compiled function.
"""

import math
from collections.abc import Callable

import numpy as np

from lamc.reference.constrained import split
from lamc.reference.kinematics import Array
from lamc.reference.newton_euler import NewtonEuler

Acceleration = Callable[[Array, Array, float], Array]
State = tuple[float, Array, Array]  # t s, q rad, u rad/s

CLOSED = 1e-13  # of the size: round-off of positions
WELL_CONDITIONED = (
    100.0  # largest over least singular value; beyond, a state tells of round-off, not of equations
)
STEP, PARTS = 0.4, 4  # rad, from one random place of loops to the next, and in how many parts
_ROUNDS = 40
_TRIES = 3  # steps per state that is wanted
_LONGEST = 0.5  # rad, one step


def settled(
    cross_check: NewtonEuler, q: Array, u: Array, rounds: int = _ROUNDS, rank: int | None = None
) -> tuple[Array, Array, float]:
    """The closed position near q, the rates of u that keep it closed, and the gap before the last step, m.

    rank: of the closure, where it is known; off closure it seems to be larger where equations are redundant.

    The gap is infinite where a hinge is closed but for its axes, which run against each other: no equation tells.
    """
    q, gap = np.array(q, dtype=np.float64), math.inf
    for _ in range(rounds):
        closed = cross_check.closed(q)
        residual, parts = closed.residual(), split(closed.jacobian(), rank)
        before, gap = gap, float(np.abs(residual).max(initial=0.0))
        if gap <= 1e-2 * CLOSED * cross_check.size or (
            gap <= CLOSED * cross_check.size and gap > 0.5 * before
        ):
            break
        step = parts.least(-residual)
        q += step * min(1.0, _LONGEST / max(float(np.abs(step).max(initial=0.0)), 1e-300))
    rotated = any(parent.directions[2] @ child.directions[2] < 0.0 for parent, child in closed.sides)
    return q, parts.free @ (parts.free.T @ u), math.inf if rotated else gap


def random_states(cross_check: NewtonEuler, start: Array, count: int, t_end: float, seed: int) -> list[State]:
    """States with angles within ±π and rates large enough for forces of motion to matter.

    With loops: closed ones on a random walk from the closed angles `start` (n,), away from singular positions. A walk,
    because loops may close in other ways, rigid ones among them, that no motion reaches; by small parts, because a
    long step may come down on one of those. They may be fewer than `count`, and none where the loops cannot move.
    """
    rng = np.random.default_rng(seed)
    n = len(cross_check.joints)
    if not cross_check.cuts:
        return [_moving(cross_check, rng, t_end, rng.uniform(-np.pi, np.pi, n)) for _ in range(count)]
    places: list[Array] = []
    place = start
    for _ in range(_TRIES * count):
        free = split(cross_check.gaps(place)[1]).free
        if len(places) == count or not free.size:
            break
        step = free @ rng.normal(size=free.shape[1])
        following = _walked(cross_check, place, STEP * step / np.linalg.norm(step))
        if following is not None:
            place = following
            places.append(place)
    conditions = [cross_check.condition(q) for q in places]
    full = max((rank for rank, _ in conditions), default=0)
    regular = [
        q
        for q, (rank, condition) in zip(places, conditions, strict=True)
        if rank == full and condition <= WELL_CONDITIONED
    ]
    return [_moving(cross_check, rng, t_end, q) for q in regular]


def _walked(cross_check: NewtonEuler, place: Array, step: Array) -> Array | None:
    """The closed place that a step (n,), rad, leads to from `place`; None where a part of it does not come about."""
    for _ in range(PARTS):
        guess = place + step / PARTS
        place, _, gap = settled(cross_check, guess, np.zeros(len(step)))
        if gap > CLOSED * cross_check.size or np.linalg.norm(place - guess) > np.linalg.norm(step) / PARTS:
            return None
        free = split(cross_check.gaps(place)[1]).free
        step = free @ (free.T @ step)
    return place


def on_closure(cross_check: NewtonEuler, acceleration: Acceleration, rank: int) -> Acceleration:
    """`acceleration`, taken at the closed state nearest to one that is off closure; rank: of the closure.

    Stages of an integrator's step are: redundant equations then count as independent ones, and lock the mechanism.
    """
    if not cross_check.cuts:
        return acceleration

    def closed(q: Array, u: Array, t: float) -> Array:
        if np.isfinite(q).all() and np.isfinite(u).all():
            q, u, _ = settled(cross_check, q, u, 2, rank)  # a stage is near, and its gap is squared twice
            return acceleration(q, u, t)
        return np.full(len(q), np.nan)

    return closed


def nudged(cross_check: NewtonEuler, start: Array, amount: float) -> Array:
    """The state `start` (2n,) moved by `amount`, rad, along every free direction; with loops it stays closed."""
    n = len(cross_check.joints)
    if not cross_check.cuts:
        moved: Array = start + np.repeat([amount, 0.0], n)
        return moved
    free = split(cross_check.gaps(start[:n])[1]).free
    q, u, _ = settled(cross_check, start[:n] + amount * free.sum(axis=1), start[n:])
    return np.concatenate([q, u])


def _moving(cross_check: NewtonEuler, rng: np.random.Generator, t_end: float, q: Array) -> State:
    """`q` at a random time with random rates, which keep loops closed."""
    n = len(q)
    t = float(rng.uniform(0.0, t_end))
    size = float(np.abs(cross_check.acceleration(q, np.zeros(n), t)).max(initial=0.0))
    pace = max(1.0, math.sqrt(size)) if math.isfinite(size) else 1.0
    u = rng.uniform(-pace, pace, n)
    if cross_check.cuts:
        free = split(cross_check.gaps(q)[1]).free
        u = free @ (free.T @ u)
    return t, q, u

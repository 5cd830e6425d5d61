"""Where forces balance: the search for it, from a closed position at rest.

In: a `Stand`. Out: a `Search`: the position where it ended, and how. Never: judges what it found.

Two ways. `nearest` looks for a zero of the accelerations along the closed positions by Newton's method within a trust
region (Levenberg and Marquardt; J. Nocedal and S. J. Wright, Numerical Optimization, 2006, ch. 10), so that it comes to
stable and unstable equilibria alike, to that which lies next. `descended` goes where the loads push, as a body does in
a thick fluid, by Newton's steps with the sizes of the stiffnesses in place of themselves; it comes to stable ones only.
"""

from dataclasses import dataclass

import numpy as np

from lamc.run.at_rest import Stand
from lamc.run.request import Array

STEPS = 200  # to the nearest, at most
DOWN = 1000  # of descent, at most: a chain of 30 links that falls from a line takes some hundreds
LONGEST = 0.2  # rad, or of the size: of a step; the farther, the less the next equilibrium is the nearest
SHORTEST = 1e-10  # likewise: of the trust region; below, the search goes nowhere
AT_HAND = 1e-7  # likewise: a Newton step this short ends within round-off, as the next is about its square
STILL = 1e-12  # of the accelerations that a radian away are had: what is left over in a balance
DEPENDENT = 1e-11  # of the largest stiffness: directions that the position does not resist
FAR = 25.0  # rad, or of the size: four turns; who went farther down is pushed on and on
_DOUBTFUL = 1e-8  # likewise, where derivatives are differences
_ASIDE = 1e-3  # of the trust region: a step aside from where nothing pushes, though nothing holds
_TURNED = 0.3  # of the push at the beginning of a step that may be there at its end, turned round


@dataclass(frozen=True, eq=False)
class Search:
    """Where a search ended. step: the last Newton step, rad, or of the size: how well the position is known.
    way: "nearest" or "descended". is_balanced: no load is left."""

    stand: Stand
    is_balanced: bool
    steps: int
    step: float
    way: str


def search(start: Stand, *, stable: bool) -> Search:
    """The next equilibrium, or where the search ended; stable: by descent only. Where the nearest way ends without one,
    descent goes on from the start."""
    if stable:
        return _finished(descended(start))
    found = nearest(start, "nearest")
    if found.is_balanced:
        return found
    other = _finished(descended(start))
    is_on_its_way = other.steps >= DOWN or went_far(start, other.stand)
    return other if other.is_balanced or is_on_its_way else found


def nearest(stand: Stand, way: str) -> Search:
    """By Newton's method in a trust region."""
    radius, size = LONGEST, float(stand.push @ stand.push)
    for count in range(STEPS):
        newton = _step(stand, 0.0)
        if stand.reach(newton) <= AT_HAND:
            return _polished(stand, count, way)
        damped = _damped(stand, radius)
        trial, length = stand.moved(damped), stand.reach(damped)
        left = stand.push + stand.response @ damped
        promised = size - float(left @ left)
        reached = float(trial.push @ trial.push) if trial is not None else np.inf
        if trial is None or size - reached < 1e-4 * promised or promised <= 0.0:
            radius = 0.25 * min(length, radius)
            if radius < SHORTEST:
                break
            continue
        if size - reached > 0.75 * promised:
            radius = min(2.0 * max(radius, length), LONGEST)
        stand, size = trial, reached
    return Search(stand, is_balanced(stand), count + 1, stand.reach(_step(stand, 0.0)), way)


def descended(stand: Stand) -> tuple[Stand, int]:
    """Where loads push it to; and the steps that took."""
    radius, count, start = LONGEST, 0, stand
    for count in range(1, DOWN + 1):
        step, is_stable = _downhill(stand, radius)
        if is_stable and stand.reach(step) <= AT_HAND:
            break
        trial = stand.moved(step)
        while trial is None or _is_turned(stand, trial):
            step, radius = 0.5 * step, 0.5 * min(stand.reach(step), radius)
            if radius < SHORTEST:
                return stand, count
            trial = stand.moved(step)
        radius, stand = min(2.0 * radius, LONGEST), trial
        if went_far(start, stand):
            break
    return stand, count


def went_far(start: Stand, stand: Stand) -> bool:
    """Whether it is out of all reach."""
    rest = start.rest
    lengths = np.array([c.unit == "m" for c in rest.motion.model.coordinates], dtype=bool)
    away = np.abs(stand.q - start.q) / np.where(lengths, rest.size or 1.0, 1.0)
    return bool(away.max(initial=0.0) > FAR)


def _downhill(stand: Stand, radius: float) -> tuple[Array, bool]:
    """The step (k,) where loads push, with no part longer than the radius, and whether stiffness resists everywhere."""
    stiffnesses, axes = np.linalg.eigh(-0.5 * (stand.response + stand.response.T))
    axes = axes * np.where(axes[np.abs(axes).argmax(axis=0), np.arange(len(stiffnesses))] < 0.0, -1.0, 1.0)
    along = axes.T @ stand.push
    limits = np.array([radius / stand.reach(axis) for axis in axes.T])
    # Right on a maximum or a saddle nothing pushes; a little to the side loads do.
    aside = _ASIDE * limits
    along = np.where(
        (stiffnesses < 0.0) & (np.abs(along) < -stiffnesses * aside), -stiffnesses * aside, along
    )
    least = DEPENDENT * np.abs(stiffnesses).max(initial=0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = np.nan_to_num(along / np.maximum(np.abs(stiffnesses), least), posinf=np.inf, neginf=-np.inf)
    return axes @ np.clip(parts, -limits, limits), bool(np.all(stiffnesses >= -least))


def is_balanced(stand: Stand) -> bool:
    """Whether no load is left, but for round-off."""
    step = _step(stand, 0.0)
    left = stand.push + stand.response @ step  # what no step takes away
    a_radian_away = (
        float(np.linalg.norm(stand.response) * np.linalg.norm(stand.factor, 2)) if len(left) else 0.0
    )
    return bool(np.linalg.norm(left) <= STILL * a_radian_away and stand.reach(step) <= AT_HAND)


def _finished(found: tuple[Stand, int]) -> Search:
    """What descent comes to, to the last digit."""
    stand, count = found
    last = nearest(stand, "descended")
    return Search(last.stand, last.is_balanced, count + last.steps, last.step, last.way)


def _polished(stand: Stand, count: int, way: str) -> Search:
    """By full Newton steps, as long as they shrink."""
    length = stand.reach(_step(stand, 0.0))
    for _ in range(4):
        trial = stand.moved(_step(stand, 0.0))
        if trial is None:
            break
        shorter = trial.reach(_step(trial, 0.0))
        if shorter >= length:
            break
        stand, length = trial, shorter
    return Search(stand, is_balanced(stand), count + 1, length, way)


def _is_turned(stand: Stand, trial: Stand) -> bool:
    """Whether a step went far beyond where the loads along it balance."""
    going = trial.q - stand.q
    before = stand.factor @ stand.push
    after = trial.factor @ trial.push
    along = np.linalg.lstsq(stand.flow, going, rcond=None)[0]
    along_there = np.linalg.lstsq(trial.flow, going, rcond=None)[0]
    return float(after @ along_there) < -_TURNED * float(before @ along)


def _step(stand: Stand, damping: float) -> Array:
    """The Newton step (k,) in the axes of `push`, or the damped one; zero along what the position does not resist."""
    left, values, right = np.linalg.svd(-stand.response)
    along = left.T @ stand.push
    largest = values.max(initial=0.0)
    kept = values > (DEPENDENT if stand.rest.is_exact else _DOUBTFUL) * largest
    shares = np.divide(values, values**2 + damping, out=np.zeros_like(values), where=kept)
    return np.asarray(right.T @ (shares * along))


def _damped(stand: Stand, radius: float) -> Array:
    """The step with the least damping that stays within the radius."""
    step = _step(stand, 0.0)
    if stand.reach(step) <= radius:
        return step
    values = np.linalg.svd(stand.response, compute_uv=False)
    low, high = 1e-16 * values[0] ** 2, values[0] ** 2
    while stand.reach(_step(stand, high)) > radius:
        high *= 100.0
    for _ in range(40):  # to a tenth in the logarithm, which is plenty
        middle = np.sqrt(low * high)
        low, high = (middle, high) if stand.reach(_step(stand, middle)) > radius else (low, middle)
        if high < 1.1 * low:
            break
    return _step(stand, high)

"""Starts of mechanisms with loops: states that close.

In: a `Motion` and what a scene asks of the start. Out: states y = [q, u] on closure. It uses the compiled
closure and nothing of the derivation, and never integrates.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from lamc.errors import DesignError
from lamc.run.request import Array

if TYPE_CHECKING:
    from lamc.run.model import Motion

CLOSED = 1e-12  # of the mechanism's size: a few hundred units of round-off
TRIES = 12  # random places from which to look for a nearest closed position
MAX_ITERATIONS = 60
SPREAD = 0.4  # rad, of the random places


def closure(motion: "Motion", q: Array) -> tuple[Array, Array]:
    """Residuals φ (m,), m, and Jacobian J (m, n), m/rad, at angles q (n,)."""
    n, m = len(q), motion.model.closure_count
    flat = motion.closures(np.concatenate([q, np.zeros(n)]).reshape(1, -1))[0]
    return flat[:m], flat[m:].reshape(m, n)


def _close(motion: "Motion", q: Array, free: Array) -> tuple[Array, float]:
    """Gauss-Newton on the free angles. Returns the place reached and its gap, m."""
    q = q.copy()
    gap = np.inf
    for _ in range(MAX_ITERATIONS):
        residual, jacobian = closure(motion, q)
        gap = float(np.abs(residual).max(initial=0.0))
        if gap <= 1e-2 * CLOSED * motion.model.size or not free.any():
            break
        step = np.linalg.lstsq(jacobian[:, free], -residual, rcond=1e-9)[0]
        longest = float(np.abs(step).max(initial=0.0))
        q[free] += step * min(1.0, 0.5 / longest) if longest > 0 else 0.0
        if longest < 1e-15:
            break
    return q, float(np.abs(closure(motion, q)[0]).max(initial=0.0))


def closed_start(motion: "Motion", angles: Mapping[str, float], rates: Mapping[str, float]) -> Array:
    """The state (2n,) nearest to the given angles (others: zero) and rates that closes all loops.

    Raises DesignError where no position with these angles closes, or no motion has these rates.
    """
    model = motion.model
    n = len(model.joints)
    wanted = np.zeros(n)
    given = np.array([name in angles for name in model.joints])
    for name, value in angles.items():
        if name in model.joints:
            wanted[model.joints.index(name)] = value
    cut_angles = {model.cuts.index(k): v for k, v in angles.items() if k in model.cuts}
    q = _position(motion, wanted, ~given, cut_angles, angles)
    return np.concatenate([q, _rates(motion, q, rates)])


def _position(
    motion: "Motion", wanted: Array, free: Array, cut_angles: Mapping[int, float], angles: Mapping[str, float]
) -> Array:
    model = motion.model
    random = np.random.default_rng(20260102)
    best_gap, found = np.inf, []
    for attempt in range(TRIES):
        guess = wanted + (random.normal(0.0, SPREAD, len(wanted)) * free if attempt else 0.0)
        q, gap = _close_with_cuts(motion, guess, free, cut_angles)
        best_gap = min(best_gap, gap)
        if gap <= CLOSED * model.size:
            found.append(q)
            if attempt == 0:
                break
    if not found:
        names = ", ".join(f"{k} = {v:g}" for k, v in sorted(angles.items())) or "none"
        raise DesignError(
            f"no position closes the loops with the angles given ({names} rad); the nearest comes within "
            f"{best_gap:.3g} m; give fewer angles, or others"
        )
    return min(found, key=lambda q: float(np.abs(q - wanted).sum()))


def _close_with_cuts(
    motion: "Motion", q: Array, free: Array, cut_angles: Mapping[int, float]
) -> tuple[Array, float]:
    """As `_close`, with given angles of cut joints as further equations, rad times the size."""
    if not cut_angles:
        return _close(motion, q, free)
    n, size = len(q), motion.model.size
    q = q.copy()
    gap = np.inf
    for _ in range(MAX_ITERATIONS):
        residual, jacobian = closure(motion, q)
        rows = np.concatenate([np.tile(q, (n, 1)), np.eye(n)], axis=1)
        cuts = motion.cut_states(rows)
        count = len(motion.model.cuts)
        for index, value in cut_angles.items():
            off = float(np.remainder(cuts[0, index] - value + np.pi, 2 * np.pi) - np.pi)
            residual = np.concatenate([residual, np.array([size * off])])
            jacobian = np.vstack([jacobian, size * cuts[:, count + index]])
        gap = float(np.abs(residual).max())
        if gap <= 1e-2 * CLOSED * size or not free.any():
            break
        step = np.linalg.lstsq(jacobian[:, free], -residual, rcond=1e-9)[0]
        longest = float(np.abs(step).max(initial=0.0))
        q[free] += step * min(1.0, 0.5 / longest) if longest > 0 else 0.0
    return q, gap


def _rates(motion: "Motion", q: Array, rates: Mapping[str, float]) -> Array:
    """Rates with J u = 0 and the given ones; of these the smallest."""
    model = motion.model
    n = len(q)
    rows: list[Array] = [closure(motion, q)[1]]
    goals: list[Array] = [np.zeros(model.closure_count)]
    cut_rates = motion.cut_states(np.concatenate([np.tile(q, (n, 1)), np.eye(n)], axis=1))[
        :, len(model.cuts) :
    ]
    for name, value in rates.items():
        if name in model.joints:
            rows.append(np.eye(n)[[model.joints.index(name)]] * model.size)
        else:
            rows.append(cut_rates[:, [model.cuts.index(name)]].T * model.size)
        goals.append(np.array([value * model.size]))
    matrix, goal = np.vstack(rows), np.concatenate(goals)
    u = np.asarray(np.linalg.lstsq(matrix, goal, rcond=1e-9)[0], dtype=np.float64)
    off = float(np.abs(matrix @ u - goal).max(initial=0.0))
    if off > 1e-8 * max(1e-300, float(np.abs(goal).max(initial=0.0))):
        names = ", ".join(f"{k} = {v:g}" for k, v in sorted(rates.items()))
        raise DesignError(
            f"no motion of the loops has the rates given ({names} rad/s): the nearest misses them by "
            f"{off / model.size:.3g} rad/s; give one rate per degree of freedom"
        )
    return u

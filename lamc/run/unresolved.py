"""Modes that a run does not excite, and that its steps are too long for.

In: a motion, how long its steps were. Out: how long they may be for derivatives; a sentence. The error of a state
bounds steps by what moves. A mode that stands still bounds none of them, and derivatives by its start or its
parameters move all the same: over steps beyond the stability of an explicit method they grow by powers of ten, and an
L-stable one damps them away. Modes are those of small motion about where the run begins. Never: changes a state.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from lamc.run.at_rest import Rest, Stand
from lamc.run.methods import IMPLICIT
from lamc.run.model import Motion
from lamc.run.request import Array

# Of the shortest time constant, 1/|eigenvalue|: an explicit step of order 8 misses exp(0.3 i) by 5e-11 and its rows
# within by 1e-9, Radau's of order 5 by 1e-6
_PART = 0.3
# Steps times an eigenvalue: explicit methods are stable to 3 or 6, so that a mode that moves keeps them below; beyond 2
# an implicit one follows no oscillation.
_UNSTABLE, _UNFOLLOWED = 10.0, 2.0
_STILL = 1e-6  # rad within the run: nothing moves
_MOST_STEPS = 200_000  # that derivatives may ask for; some seconds


@dataclass(frozen=True)
class Steps:
    """What a run took. integrators: all of them; longest: s; span: s."""

    integrators: Sequence[str]
    longest: float
    span: float


def longest_step(t: Array, entries: npt.NDArray[np.int64]) -> float:
    """s, at least: of rows at times t (m,), before each of which so many steps ended."""
    if len(t) < 2:
        return 0.0
    first = np.flatnonzero(np.diff(entries, prepend=-1))
    starts, counts = t[first], entries[first]
    between = np.diff(starts) / np.maximum(np.diff(counts), 1)
    return float(max(between.max(initial=0.0), t[-1] - starts[-1]))


def short_enough(motion: Motion, y0: Array, t: float, size: float, steps: Steps) -> tuple[float, bool]:
    """The longest step, s, that derivatives bear, infinite where all modes are followed; and whether so many steps may
    be taken. y0: (nq + nu,), where the run begins, at t, s; size: m, of the mechanism.

    An implicit method rightly passes over what fast modes would do, unless nothing moves at all: then none is followed;
    else the slowest oscillation is to be.
    """
    nq = len(motion.model.coordinates)
    stand = Rest(motion, t, size).stand(np.ascontiguousarray(y0[:nq]))
    rates = np.zeros(0) if stand is None else _rates(stand)
    if not len(rates):
        return math.inf, True
    fast, limit = rates, _UNSTABLE
    if set(steps.integrators) & {*IMPLICIT}:
        limit = _UNFOLLOWED
        rates = rates[(np.abs(rates.imag) > np.abs(rates.real)) & (np.abs(rates) * steps.span > 1.0)]
        if not len(rates):
            return math.inf, True
        assert stand is not None
        moves = max(
            float(np.abs(stand.udot).max()) * steps.span**2, float(np.abs(y0[nq:]).max()) * steps.span
        )
        fast = rates if moves < _STILL else rates[[np.argmin(np.abs(rates))]]
    if steps.longest * float(np.abs(fast).max()) <= limit:
        return math.inf, True
    longest = _PART / float(np.abs(fast).max())
    return longest, steps.span <= _MOST_STEPS * longest


def told(longest: float, integrator: str) -> str:
    """That derivatives may be off, and the way out."""
    return (
        f"steps of {integrator} are too long for derivatives of modes that do not move here, and errors of the state "
        f"bound none of them: max_step={longest:.2g} does"
    )


def _rates(stand: Stand) -> npt.NDArray[np.complex128]:
    """Eigenvalues of small motion, 1/s, but for zero; none where forces are not finite."""
    by_q, by_u = stand.derivatives
    k = len(by_q)
    matrix = np.block([[np.zeros((k, k)), np.eye(k)], [by_q, by_u]])
    if not k or not np.isfinite(matrix).all():
        return np.zeros(0, dtype=np.complex128)
    found: npt.NDArray[np.complex128] = np.linalg.eigvals(matrix).astype(np.complex128)
    return found[np.abs(found) > 0.0]

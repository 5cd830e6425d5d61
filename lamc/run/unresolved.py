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

from lamc.run.at_rest import Rest
from lamc.run.methods import IMPLICIT
from lamc.run.model import Motion
from lamc.run.request import Array

# Of the shortest time constant, 1/|eigenvalue|: an explicit step of order 8 misses exp(0.3 i) by 5e-11 and its rows
# within by 1e-9, Radau's of order 5 by 1e-6
_PART = 0.3
# Steps times an eigenvalue: explicit methods are stable to 3 or 6; beyond 2 an implicit one follows no oscillation.
_UNSTABLE, _UNFOLLOWED = 10.0, 2.0
_SEEN = 100.0  # times the tolerance of the state: what moves so much bounds steps by its error, also once it decays
_MOST_STEPS = 200_000  # that derivatives may ask for; some seconds
_OF_ALLOWED = 0.9  # of the steps that a run may take: the state's error may ask for shorter ones in places


@dataclass(frozen=True)
class Steps:
    """What a run took. integrators: all of them; longest: s; span: that was asked for, s; tolerance: of states, rad."""

    integrators: Sequence[str]
    longest: float
    span: float
    tolerance: float

    @property
    def are_implicit(self) -> bool:
        return bool(set(self.integrators) & {*IMPLICIT})


def longest_step(t_start: float, t: Array, entries: npt.NDArray[np.int64]) -> float:
    """s, at least: of a run from t_start and rows at times t (m,), before each of which so many steps ended."""
    if not len(t):
        return 0.0
    times, counts = np.concatenate([[t_start], t]), np.concatenate([[0], entries])
    first = np.flatnonzero(np.diff(counts, prepend=-1))
    between = np.diff(times[first]) / np.maximum(np.diff(counts[first]), 1)
    return float(max(between.max(initial=0.0), times[-1] - times[first[-1]]))


class Modes:
    """Of small motion about where a run begins, those that it does not move.

    rates  eigenvalues, 1/s; none where forces are not finite
    nothing_moves  whether they are all there are
    """

    def __init__(self, motion: Motion, y0: Array, t: float, size: float, tolerance: float) -> None:
        """y0: (nq + nu,), at t, s; size: m, of the mechanism; tolerance: rad."""
        nq = len(motion.model.coordinates)
        self.rates, self.nothing_moves = np.zeros(0, dtype=np.complex128), False
        stand = Rest(motion, t, size).stand(np.ascontiguousarray(y0[:nq]))
        if stand is None or not len(stand.push):
            return
        by_q, by_u = stand.derivatives
        k = len(by_q)
        matrix = np.block([[np.zeros((k, k)), np.eye(k)], [by_q, by_u]])
        if not np.isfinite(matrix).all():
            return
        rates, shapes = np.linalg.eig(matrix)
        begun = motion.accelerations(np.array([t]), np.ascontiguousarray(y0)[None, :])[0]
        change = stand.tangent.T @ np.stack([y0[nq:], begun], axis=1)  # (k, 2): of positions and of rates
        if not np.isfinite(change).all():
            return
        parts = np.linalg.lstsq(shapes, change.T.ravel().astype(complex), rcond=None)[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            moves = np.abs(parts) * np.abs(shapes[:k]).max(axis=0) / np.abs(rates)
        still = (np.abs(rates) > 0.0) & (moves <= _SEEN * tolerance)
        self.rates = rates[still].astype(np.complex128)
        self.nothing_moves = bool(np.all(moves[np.abs(rates) > 0.0] <= _SEEN * tolerance))

    @property
    def oscillations(self) -> npt.NDArray[np.complex128]:
        """Those that are not over within a period: what an implicit method passes over of others is not there."""
        found: npt.NDArray[np.complex128] = self.rates[np.abs(self.rates.imag) > np.abs(self.rates.real)]
        return found

    def bear(self, steps: Steps) -> float:
        """The longest step, s, that derivatives bear; infinite where these were short enough. An implicit method
        rightly passes over what stiff modes would do beside those that move: it is looked at where nothing does."""
        if steps.are_implicit and not self.nothing_moves and math.isfinite(steps.longest):
            return math.inf
        rates, limit = (self.oscillations, _UNFOLLOWED) if steps.are_implicit else (self.rates, _UNSTABLE)
        fastest = float(np.abs(rates).max(initial=0.0))
        is_followed = steps.longest * fastest <= limit or fastest * steps.span <= 1.0
        return math.inf if is_followed else _PART / fastest


def is_affordable(longest: float, span: float, most: int) -> bool:
    """Whether a run of a span, s, may take steps of that length, of at most so many."""
    return span <= min(_MOST_STEPS, _OF_ALLOWED * most) * longest


def unresolved_note(longest: float, integrator: str) -> str:
    """That derivatives may be off, and the way out."""
    return (
        f"steps of {integrator} are too long for derivatives of modes that do not move here, and errors of the state "
        f"bound none of them: max_step={longest:.2g} does"
    )

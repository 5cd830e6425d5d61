"""Steps of a run that begins at rest, in balance, and of which derivatives are asked.

In: a motion, where it begins. Out: how long steps may be for derivatives. The error of a state that does not move is
zero, and lets steps grow beyond all bounds; derivatives by starts and parameters move all the same, and need steps that
are short beside the time constants about the balance. Never: says anything of a run that moves.
"""

import math

import numpy as np

from lamc.run.at_rest import Rest
from lamc.run.model import Motion
from lamc.run.request import Array

# Of the shortest time constant, 1/|eigenvalue|: an explicit step of order 8 misses exp(0.3 i) by 5e-11 and its rows
# within by 1e-9, Radau's of order 5 by 1e-6
_PART = 0.3
_STILL = 1e-12  # rad/s


def longest_step(
    motion: Motion, y0: Array, span: tuple[float, float], tolerance: float, size: float
) -> float:
    """s; infinite where the run does not begin at rest.

    y0    (nq + nu,), where it begins; span: from when to when, s
    tolerance  rad: what moves by less is at rest; size: m, of the mechanism
    """
    nq = len(motion.model.coordinates)
    if not span[1] > span[0] or np.abs(y0[nq:]).max(initial=0.0) > _STILL:
        return math.inf
    stand = Rest(motion, span[0], size).stand(np.ascontiguousarray(y0[:nq]))
    if stand is None:
        return math.inf
    by_q, by_u = stand.derivatives
    k = len(by_q)
    matrix = np.block([[np.zeros((k, k)), np.eye(k)], [by_q, by_u]])
    if not k or not np.isfinite(matrix).all():
        return math.inf
    rates = np.abs(np.linalg.eigvals(matrix))
    moves = (
        float(np.abs(stand.udot).max()) / max(float(rates.min()), 1.0 / (span[1] - span[0])) ** 2
    )  # rad, about
    if rates.max() == 0.0 or moves > tolerance:
        return math.inf
    return _PART / float(rates.max())

"""What loads do along rates of the hinges, from rest: by it a singular start chooses its branch.

In: a motion, and how the hinges' angles make a state. Out: a function for `lamc.loops.pushed`. Never: integrates.
"""

import numpy as np

from lamc.loops.branches import Lead
from lamc.loops.pushed import Push
from lamc.mechanics.arrangement import Arrangement
from lamc.run.model import Motion
from lamc.run.request import Array


def push_of(motion: Motion, arrangement: Arrangement) -> Push:
    """Of closed angles (n,), rad, and rates τ (n,) of all joints: the power f·τ of all loads at rest, W, and τ·M τ, J.

    f·τ is τ·M u̇ with the accelerations from rest, to which what holds the loops adds nothing; that is half the
    difference of the kinetic energies at the rates τ + u̇ and τ - u̇. A floating base stays behind."""
    nq, nu = len(motion.model.coordinates), len(motion.model.rates)

    def push(angles: Array, rates: Array) -> tuple[float, float]:
        y = np.zeros((4, nq + nu))
        y[:, :nq] = arrangement.start(angles.tolist(), rates.tolist())[0]
        udot = motion.accelerations(np.zeros(1), y[:1])[0]
        size = float(np.abs(udot).max()) or 1.0
        y[1:, nq : nq + len(rates)] = rates
        y[2:, nq:] += np.outer([1.0, -1.0], udot / size)
        _, along, faster, slower = motion.energies(np.zeros(4), y)[:, 0].tolist()
        return size * 0.5 * (faster - slower), 2.0 * along

    return push


def lead_of(motion: Motion, arrangement: Arrangement) -> Lead:
    """Of closed angles (n,), rad: the accelerations (n,) of the joints from rest there, which hold the loops to first
    order."""
    nq, nu = len(motion.model.coordinates), len(motion.model.rates)

    def lead(angles: Array) -> Array:
        y = np.zeros((1, nq + nu))
        y[0, :nq] = arrangement.start(angles.tolist(), [0.0] * len(angles))[0]
        return np.asarray(motion.accelerations(np.zeros(1), y)[0, : len(angles)])

    return lead

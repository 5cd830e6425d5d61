"""What loads do along rates of the hinges, from rest: by it a singular start chooses its branch.

In: a motion, and how the hinges' angles make a state. Out: a function for `lamc.loops.pushed`. Never: integrates.
"""

import numpy as np

from lamc.loops.branches import Lead
from lamc.loops.pushed import Push
from lamc.mechanics.arrangement import Arrangement
from lamc.run.model import Motion
from lamc.run.request import Array

STEP = 1e-3  # rad


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
    """As `push_of`, of many rates at once; and the accelerations of the joints."""
    nq, nu = len(motion.model.coordinates), len(motion.model.rates)

    def states(angles: Array, rates: Array) -> Array:
        """(k, nq + nu): at angles (n,), with rates (k, nu)."""
        y = np.zeros((len(rates), nq + nu))
        y[:, :nq] = arrangement.start(angles.tolist(), [0.0] * len(angles))[0]
        y[:, nq:] = rates
        return y

    def accelerations(angles: Array) -> Array:
        return np.asarray(motion.accelerations(np.zeros(1), states(angles, np.zeros((1, nu))))[0])

    def asked(angles: Array) -> Array:
        return np.asarray(accelerations(angles)[: len(angles)])

    def kinetic(angles: Array, rates: Array) -> Array:
        return np.asarray(motion.energies(np.zeros(len(rates)), states(angles, rates))[:, 0])

    def work(angles: Array, rows: Array) -> tuple[Array, Array, Array]:
        rates = np.zeros((len(rows), nu))
        rates[:, : rows.shape[1]] = rows
        udot = accelerations(angles)
        size = float(np.abs(udot).max()) or 1.0
        pull = 0.5 * size * (kinetic(angles, rates + udot / size) - kinetic(angles, rates - udot / size))
        first, second = np.triu_indices(len(rows), 1)
        alone = kinetic(angles, rates)
        inertia = np.diag(2.0 * alone)
        mixed = kinetic(angles, rates[first] + rates[second]) - alone[first] - alone[second]
        inertia[first, second] = inertia[second, first] = mixed
        return pull, inertia, np.abs(rows) @ single_forces(angles)

    def single_forces(angles: Array) -> Array:
        """(n,), N·m: sizes of what each potential does at each joint alone; nought where nothing is known of one."""
        steps = np.concatenate([np.eye(len(angles)), -np.eye(len(angles))]) * STEP
        y = np.zeros((len(steps), nq + nu))
        for k, step in enumerate(steps):
            y[k, :nq] = arrangement.start((angles + step).tolist(), [0.0] * len(angles))[0]
        ahead, behind = np.split(motion.energies(np.zeros(len(steps)), y)[:, 1:], 2)
        return np.asarray(np.nan_to_num(np.abs(ahead - behind)).sum(axis=1) / (2.0 * STEP))

    return Lead(asked, work)

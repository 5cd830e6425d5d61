"""What loads do along rates of the hinges, from rest: by it a singular start chooses its branch.

In: a motion, and how the hinges' angles make a state. Out: functions for `lamc.loops.pushed` and `branches`. Never:
integrates.
"""

import numpy as np

from lamc.loops.branches import Lead
from lamc.loops.pushed import Push
from lamc.mechanics.arrangement import Arrangement, FloatingBase
from lamc.run.model import Motion
from lamc.run.request import Array

STEP = 1e-3  # rad


def push_of(motion: Motion, arrangement: Arrangement) -> Push:
    """Of closed angles (n,), rad, and rates τ (n,) of all joints: the power f·τ of all loads at rest, W, and τ·M τ, J;
    see `_AtRest.work`."""

    def push(angles: Array, rates: Array) -> tuple[float, float]:
        power, inertia = _AtRest(motion, arrangement, angles).work(rates[None])
        return float(power[0]), float(inertia[0, 0])

    return push


def lead_of(motion: Motion, arrangement: Arrangement) -> Lead:
    """As `push_of`, of many rates at once; and the accelerations of the joints."""

    def asked(angles: Array) -> Array:
        return _AtRest(motion, arrangement, angles).accelerations[: len(angles)]

    def work(angles: Array, rows: Array) -> tuple[Array, Array, Array]:
        at = _AtRest(motion, arrangement, angles)
        return *at.work(rows), np.abs(rows) @ at.single_forces()

    return Lead(asked, work)


class _AtRest:
    """A motion at rest at closed angles (n,), rad."""

    def __init__(self, motion: Motion, arrangement: Arrangement, angles: Array) -> None:
        self.motion, self.arrangement, self.angles = motion, arrangement, angles
        rates = [rate.name for rate in motion.model.rates]
        self.count = len(rates)
        floats = isinstance(arrangement.base, FloatingBase)
        self.base = [
            k for k, name in enumerate(rates) if floats and k >= len(angles) and name.startswith("base.")
        ]
        self.place = self._place(angles)
        start = self._states(np.zeros((1, self.count)))
        self.accelerations = np.asarray(motion.accelerations(np.zeros(1), start)[0])

    def work(self, rows: Array) -> tuple[Array, Array]:
        """Along rates (k, n) of all joints: the power of all loads (k,), W, and inertia (k, k), J.

        The power is τ·M u̇ with the accelerations from rest, to which what holds the loops adds nothing; that is half
        the difference of the kinetic energies at the rates τ + u̇ and τ - u̇. A base that floats goes with each motion
        as nothing holds it: what is left when its own part is eliminated (Schur's complement), so that it is no matter
        which facet is called the base, nor how all of it falls. What else has rates of its own is still."""
        k, of_base = len(rows), len(self.base)
        rates = np.zeros((k + of_base, self.count))
        rates[:k, : rows.shape[1]] = rows
        rates[k + np.arange(of_base), self.base] = 1.0
        size = float(np.abs(self.accelerations).max()) or 1.0
        way = self.accelerations / size
        power = 0.5 * size * (self._kinetic(rates + way) - self._kinetic(rates - way))
        first, second = np.triu_indices(len(rates), 1)
        alone = self._kinetic(rates)
        inertia = np.diag(2.0 * alone)
        mixed = self._kinetic(rates[first] + rates[second]) - alone[first] - alone[second]
        inertia[first, second] = inertia[second, first] = mixed
        if not of_base:
            return power, inertia
        along = np.linalg.lstsq(inertia[k:, k:], np.column_stack([inertia[k:, :k], power[k:]]), rcond=None)[0]
        coupled = inertia[:k, k:] @ along
        return power[:k] - coupled[:, -1], inertia[:k, :k] - coupled[:, :-1]

    def single_forces(self) -> Array:
        """(n,), N·m: sizes of what each potential does at each joint alone; nought where nothing is known of one."""
        steps = np.concatenate([np.eye(len(self.angles)), -np.eye(len(self.angles))]) * STEP
        y = self._states(np.zeros((len(steps), self.count)))
        y[:, : len(self.place)] = [self._place(self.angles + step) for step in steps]
        ahead, behind = np.split(self.motion.energies(np.zeros(len(steps)), y)[:, 1:], 2)
        return np.asarray(np.nan_to_num(np.abs(ahead - behind)).sum(axis=1) / (2.0 * STEP))

    def _place(self, angles: Array) -> Array:
        """Coordinates (nq,) at angles (n,)."""
        return np.array(self.arrangement.start(angles.tolist(), [0.0] * len(angles))[0])

    def _states(self, rates: Array) -> Array:
        """(k, nq + nu), with rates (k, nu)."""
        return np.hstack([np.tile(self.place, (len(rates), 1)), rates])

    def _kinetic(self, rates: Array) -> Array:
        """(k,), J, at rates (k, nu)."""
        return np.asarray(self.motion.energies(np.zeros(len(rates)), self._states(rates))[:, 0])

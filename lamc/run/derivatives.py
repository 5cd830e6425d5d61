"""Derivatives of what a result tells, from the derivatives of its states.

In: a result, derivatives of its states by names. Out: derivatives of any output, since when there are none, and since
when they tell no finite change. Never: integrates, knows how the derivatives were found.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from lamc.basics.checks import did_you_mean
from lamc.records.mechanism import Mechanism
from lamc.run.model import Motion
from lamc.run.request import Array

if TYPE_CHECKING:
    from lamc.run.result import Result

ANGLES, RATES = "angles.", "rates."  # what names of a start begin with
HORIZON = (
    1e-2  # of a range: what a run at its tolerance may be off before its derivatives are of another motion
)


@dataclass(frozen=True)
class NoDerivative:
    """From t, s, on there are no derivatives. reason: why, in words."""

    t: float
    reason: str


@dataclass(frozen=True, eq=False)
class Shifted:
    """The same device with another value, and its part in a difference."""

    weight: float
    mechanism: Mechanism
    motion: Motion


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """Derivatives of the states of a run.

    names   p of them
    values  (m, nq + nu, p): of coordinates, then rates, at each row, by each name, in SI units; NaN where there are
            none
    lost    since when there are none; None: there are everywhere
    sizes   (p,): of the numbers themselves, SI; 1 where one is zero
    """

    names: tuple[str, ...]
    values: Array
    lost: NoDerivative | None = None
    sizes: tuple[float, ...] = ()
    _shifted: Callable[[str], tuple[Shifted, ...]] | None = field(default=None, repr=False)

    def of(self, result: "Result", output: str, name: str) -> Array:
        """d output / d name at the rows, shape (m,), SI. Raises KeyError for names that are not there."""
        if name not in self.names:
            raise KeyError(f"the run was not differentiated by {name!r}; {did_you_mean(name, self.names)}")
        column = self.values[:, :, self.names.index(name)]
        nq = result.q.shape[1]
        if output in result.joints:
            return column[:, result.joints.index(output)]
        known = [c.name for c in result.coordinates]
        if output in known:
            return column[:, known.index(output)]
        joint = output.removesuffix(".rate")
        if joint in result.joints and joint != output:
            return column[:, nq + result.joints.index(joint)]
        return self._along(result, output, column) + self._beside(result, output, name)

    def horizon(self, result: "Result") -> tuple[float, str] | None:
        """Since when, s, and by which name, a change of a number by the tolerance of the run moves the state by more
        than a hundredth of its range: in chaotic motion, where derivatives tell no finite change. None: nowhere."""
        # What moves by less than atol / rtol is not known to a part of itself: at rest all changes are large.
        range_of = np.maximum(np.ptp(result.y, axis=1), result.stats.atol / result.stats.rtol)
        reach = HORIZON * range_of[None, :, None] / result.stats.rtol
        moved = np.abs(self.values) * np.array(self.sizes or (1.0,) * len(self.names))
        beyond = np.any(moved > np.where(reach > 0.0, reach, np.inf), axis=1)  # (m, p)
        rows = np.flatnonzero(beyond.any(axis=1))
        if not len(rows):
            return None
        return float(result.t[rows[0]]), self.names[int(np.argmax(beyond[rows[0]]))]

    def _along(self, result: "Result", output: str, column: Array) -> Array:
        """Of an output as a function of the state, by differences along the column, a hundredth of a radian at most."""
        reach = 1e-2 / np.maximum(np.nanmax(np.abs(column), axis=1, initial=0.0), 1e-300)
        moved = reach[:, None] * column
        nq, total = result.q.shape[1], np.zeros(len(result.t))
        for place, weight in zip((-3, -2, -1, 1, 2, 3), (-1, 9, -45, 45, -9, 1), strict=True):
            at = replace(
                result,
                q=result.q + place * moved[:, :nq],
                u=result.u + place * moved[:, nq:],
                sensitivities=None,
            )
            total += weight / 60.0 * at.quantity(output).values
        return np.where(np.isfinite(reach), total / reach, 0.0)

    def _beside(self, result: "Result", output: str, name: str) -> Array:
        """Of an output at a given state: points of bodies and loads follow from dimensions and parameters too."""
        if self._shifted is None or name.startswith((ANGLES, RATES)):
            return np.zeros(len(result.t))
        total = np.zeros(len(result.t))
        for each in self._shifted(name):
            at = replace(result, mechanism=each.mechanism, motion=each.motion, sensitivities=None)
            total += each.weight * at.quantity(output).values
        return total

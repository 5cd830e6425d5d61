"""Derivatives of a run by one of scipy's integrators, from step to step.

In: a motion with derivatives, the steps that scipy took. Out: derivatives of the states at its rows. Never: sways a
step.

Over each step the derivative is that of the motion from the very state where scipy began it, by an integrator of lamc's
own at the tolerances of the run, and derivatives of steps are chained. What scipy makes of a step differs from that
motion by the error that it allows, and so do derivatives. Switches within a step are met where they are, though scipy
goes over them. One that falls between two steps, where one ends before it and the next begins behind it, would be
missed: there derivatives end.
"""

from dataclasses import replace

import numpy as np

from lamc.run import native
from lamc.run.model import Motion
from lamc.run.request import BETWEEN_STEPS, UNFOLLOWED, Array, Request, Status, Trajectory

_IMPLICIT = ("Radau", "BDF", "LSODA")


class Variation:
    """lost: as of `Trajectory`."""

    def __init__(self, motion: Motion, request: Request, method: str) -> None:
        assert request.along is not None
        self._motion, self._request = motion, replace(request, progress=None)
        self._how = "radau5" if method in _IMPLICIT else "dop853"
        self._along = request.along
        self._modes: tuple[float, ...] | None = None  # of guards where the last step ended
        times = request.t_eval
        at_start = times is None or (len(times) > 0 and times[0] == 0.0)
        self._rows = [np.repeat(self._along.start[None], 1 if at_start else 0, axis=0)]
        self.lost: tuple[float, int, int] | None = None

    def of_rows(self, count: int) -> Array:
        """Derivatives of the states at the first `count` rows, (count, nq + nu, k); NaN where there are none."""
        found = np.full((count, *self._along.start.shape), np.nan)
        if self._request.t_end == 0.0 or not len(self._request.y0):  # nothing moves
            found[:] = self._along.start
            return found
        known = np.concatenate(self._rows)[:count]
        found[: len(known)] = known
        return found

    def after(self, t_old: float, y_old: Array, t: float, times: Array) -> None:
        """Goes over a step from a state, with rows at times within it, ascending. Raises KeyboardInterrupt."""
        if self.lost is None:
            found = self._over(t_old, y_old, t, times)
            if found is not None:
                self._rows.append(found)
                return
        self._rows.append(np.full((len(times), *self._along.start.shape), np.nan))

    def _over(self, t_old: float, y_old: Array, t: float, times: Array) -> Array | None:
        asked = np.append(times, t) if not len(times) or times[-1] < t else times
        request = replace(self._request, t_start=t_old, y0=y_old, t_end=t, t_eval=asked, along=self._along)
        _, found = native.integrate(self._motion, request, self._how)
        if found.status == Status.CANCELLED:
            raise KeyboardInterrupt
        if not self._is_good(t_old, found):
            return None
        assert found.along is not None
        self._along = replace(self._along, start=np.ascontiguousarray(found.along[-1]))
        self._modes = found.modes[1]
        return found.along[: len(times)]

    def _is_good(self, t_old: float, found: Trajectory) -> bool:
        if self._modes not in (None, found.modes[0]):
            self.lost = (t_old, BETWEEN_STEPS, -1)
        elif found.status != Status.REACHED_END:
            self.lost = (t_old, UNFOLLOWED, -1)
        else:
            self.lost = found.lost
        return self.lost is None

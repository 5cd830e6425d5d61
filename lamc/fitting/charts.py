"""States of a mechanism by as many numbers as it has freedoms: a start of a piece that loops leave free to choose.

In: a motion, a closed state. Out: a `Chart`: independent coordinates and their rates, from which the others follow so
that all loops are closed, positions by Newton's method from the chart's own state on, rates by one linear solve. A tree
has all of them. Raises DesignError where no closed state is found, as beyond the mechanism's reach.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.basics.errors import DesignError
from lamc.run.model import Motion
from lamc.run.request import Array

_STRIDE = 0.1  # rad, that independent coordinates move at once: Newton's method then stays on its branch
_STRIDES = 100
_NEWTON = 12  # steps; four are usual
_CLOSED = 1e-12  # rad, of a step: closed as well as the runtime closes
_NEARLY = 1e-9  # rad: of a position that is nearly singular, where round-off leaves more
_RANK = 1e-9  # of the largest singular value
_STEP = 1e-5  # rad: two points miss 1e-10 of how rates follow from positions
_PREFERRED = 10.0  # times the length of a direction: what was recorded is chosen where it can be


@dataclass(frozen=True, eq=False)
class Chart:
    """near: (n,), a closed state. free: places of the independent coordinates, ascending."""

    near: Array
    free: tuple[int, ...]

    @staticmethod
    def around(motion: Motion, y: Array, preferred: Sequence[int] = ()) -> "Chart":
        """The chart around a closed state (n,), of preferred coordinates where these are independent."""
        nu = len(y) // 2
        if not motion.model.cuts:
            return Chart(y, tuple(range(nu)))
        from scipy.linalg import qr  # `import lamc` does without it

        rank = motion.model.rank
        _, jacobian = _closure(motion, y[:nu])
        _, _, rows = np.linalg.svd(jacobian)
        directions = rows[rank:]  # (f, nu)
        weights = np.ones(nu)
        weights[list(preferred)] = _PREFERRED
        _, _, order = qr(directions * weights, pivoting=True, mode="economic")
        return Chart(y, tuple(sorted(int(k) for k in order[: nu - rank])))

    @property
    def places(self) -> list[int]:
        """Of the chart's numbers in the state, (2f,)."""
        nu = len(self.near) // 2
        return [*self.free, *(nu + k for k in self.free)]

    def state(self, motion: Motion, x: Array) -> Array:
        """The closed state (n,) of independent coordinates and rates x (2f,)."""
        if self._is_whole:
            return np.array(x)
        nu, f, free = len(self.near) // 2, len(self.free), list(self.free)
        q = self.near[:nu].copy()
        way = x[:f] - q[free]
        strides = int(np.ceil(np.max(np.abs(way), initial=0.0) / _STRIDE)) or 1
        if not strides <= _STRIDES:
            raise DesignError("a piece would begin many turns from where it was")
        for k in range(strides):
            there = self.near[:nu][free] + way * (k + 1) / strides
            q = q + self._follow(motion, q) @ (there - q[free])
            q[free] = there
            q = self._closed(motion, q)
        return np.concatenate([q, self._follow(motion, q) @ x[f:]])

    def slopes(self, motion: Motion, y: Array) -> Array:
        """Derivatives (n, 2f) of the closed state y (n,) by the chart's numbers."""
        nu, f = len(y) // 2, len(self.free)
        if self._is_whole:
            return np.eye(2 * nu)
        q, rates = y[:nu], y[nu:][list(self.free)]
        follow = self._follow(motion, q)
        found = np.zeros((2 * nu, 2 * f))
        found[:nu, :f] = found[nu:, f:] = follow
        for k, along in enumerate(follow.T):
            ahead, behind = (self._follow(motion, q + way * _STEP * along) for way in (1.0, -1.0))
            found[nu:, k] = (ahead - behind) @ rates / (2.0 * _STEP)
        return found

    @property
    def _is_whole(self) -> bool:
        return 2 * len(self.free) == len(self.near)

    def _follow(self, motion: Motion, q: Array) -> Array:
        """How all rates (nu,) follow from the independent ones (f,): (nu, f)."""
        _, jacobian = _closure(motion, q)
        free = list(self.free)
        others = [k for k in range(len(q)) if k not in self.free]
        found = np.zeros((len(q), len(free)))
        found[free] = np.eye(len(free))
        found[others] = -np.linalg.lstsq(jacobian[:, others], jacobian[:, free], rcond=_RANK)[0]
        return found

    def _closed(self, motion: Motion, q: Array) -> Array:
        """Positions (nq,) with the same independent coordinates, in which loops are closed."""
        others = [k for k in range(len(q)) if k not in self.free]
        length = np.inf
        for _ in range(_NEWTON):
            gap, jacobian = _closure(motion, q)
            step = np.linalg.lstsq(jacobian[:, others], gap, rcond=_RANK)[0]
            length = float(np.max(np.abs(step), initial=0.0))
            if not length < 1.0:
                break
            q = q.copy()
            q[others] -= step
            if length <= _CLOSED:
                return q
        if length <= _NEARLY:
            return q
        raise DesignError("a piece would begin where the loops do not close")


def _closure(motion: Motion, q: Array) -> tuple[Array, Array]:
    """Gaps (m,) of the loops and their derivatives (m, nu)."""
    nu, count = len(q), motion.model.closure_count
    found = motion.closures(np.concatenate([q, np.zeros(nu)])[None, :])[0]
    return found[:count], found[count:].reshape(count, nu)

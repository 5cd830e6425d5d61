"""M u̇ = f + Jᵀ λ under J u̇ + γ = 0, by numpy, where the equations may be redundant.

In: M, f, J, γ as numbers. Out: u̇ and how well the equations determine it. The forces λ are never formed: u̇ is split
into what the equations fix and what they leave free (null space of J by singular values), and the free part follows
from the projection of M u̇ = f. Redundant equations then need no choice among them.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

# Singular values below this part of the largest are those of redundant equations, whose rows differ by how far the
# state is off closure; above it is geometry.
RANK_TOLERANCE = 1e-7


@dataclass(frozen=True)
class Split:
    """J = U diag(s) Vᵀ at its rank r: fixed directions (n, r), free ones (n, n - r), values (r,), left (m, r)."""

    left: Array
    values: Array
    fixed: Array
    free: Array

    @property
    def rank(self) -> int:
        return len(self.values)

    @property
    def condition(self) -> float:
        """Largest over least singular value; 1 where nothing is constrained."""
        return float(self.values[0] / self.values[-1]) if len(self.values) else 1.0

    def least(self, goal: Array) -> Array:
        """The shortest x (n,) with J x = goal (m,), in the least-squares sense."""
        x: Array = self.fixed @ ((self.left.T @ goal) / self.values)
        return x


def split(jacobian: Array, most: int | None = None) -> Split:
    """The directions that J (m, n) fixes and leaves free; `most`: a rank that is known, from above."""
    if not jacobian.any():
        n = jacobian.shape[1]
        return Split(np.zeros((len(jacobian), 0)), np.zeros(0), np.zeros((n, 0)), np.eye(n))
    left, values, right = np.linalg.svd(jacobian)
    rank = int((values > RANK_TOLERANCE * values[0])[:most].sum())
    return Split(left[:, :rank], values[:rank], right[:rank].T, right[rank:].T)


def constrained(mass: Array, force: Array, jacobian: Array, bias: Array) -> Array:
    """u̇, shape (n,), rad/s², of M (n, n), f (n,), J (m, n) and γ (m,). NaN where any of them is not finite."""
    if not all(np.isfinite(a).all() for a in (mass, force, jacobian, bias)):
        return np.full(len(force), np.nan)
    parts = split(jacobian)
    held = parts.least(-bias)
    free = parts.free
    moved = np.linalg.solve(free.T @ mass @ free, free.T @ (force - mass @ held))
    result: Array = held + free @ moved
    return result

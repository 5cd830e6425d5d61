"""What the loops of a mechanism come to: equations, rank, freedoms.

In: a `Tree`. Out: a `LoopCount`. It looks at generic closed positions, never at the drawn one alone, which is often
flat and of smaller rank; and never at masses, forces or a scene's start.
"""

from dataclasses import dataclass

import numpy as np

from lamc.loops.geometry import LoopGeometry
from lamc.mechanism.records import Array
from lamc.mechanism.tree import Tree

CLOSED = 1e-12  # rad, and of the size: a few hundred units of round-off
RANK_TOLERANCE = 1e-7  # relative to the largest singular value; drift and drawings lie below, geometry above
TRIES = 12  # random places from which to look for generic closed positions
ENOUGH = 3  # generic positions that agree; what is not generic has no volume
MAX_ITERATIONS = 60
LONGEST_STEP = 0.5  # rad
SPREAD = 0.4  # rad, of the random places


@dataclass(frozen=True)
class LoopCount:
    """What the loops of a mechanism come to, counted as in the field: six equations for each, all joints unknown.

    singular_values  of the closure matrix at a generic closed position, descending; rotations in rad, lengths in
                     units of the mechanism's size, displacements at the middle of its hinges
    """

    loops: int
    equations: int
    rank: int
    freedoms: int
    singular_values: tuple[float, ...] = ()

    @property
    def redundant(self) -> int:
        return self.equations - self.rank

    @property
    def closure_rank(self) -> int:
        """Rank of the equations without the angles of the cut joints, which are no coordinates of the motion."""
        return self.rank - self.loops


def count_loops(tree: Tree) -> LoopCount:
    """The count for `tree`: the largest rank at closed positions found from random places. Deterministic."""
    if not tree.cuts:
        return LoopCount(0, 0, 0, len(tree.links))
    geometry = LoopGeometry(tree)
    count = len(geometry.names)
    random = np.random.default_rng(20260101)
    best = _singular_values(geometry, np.zeros(count))
    found: list[int] = []
    for _ in range(TRIES):
        angles, error = close(geometry, random.normal(0.0, SPREAD, count))
        if error <= CLOSED:
            values = _singular_values(geometry, angles)
            found.append(_rank(values))
            best = max(best, values, key=_rank)
            if found.count(max(found)) == ENOUGH:
                break
    rank = _rank(best)
    return LoopCount(
        geometry.loops, 6 * geometry.loops, rank, count - rank, tuple(float(value) for value in best)
    )


def close(geometry: LoopGeometry, angles: Array) -> tuple[Array, float]:
    """Gauss-Newton from `angles` (n,). Returns the place reached and its largest residual, rad or units."""
    angles = angles.copy()
    residual, jacobian = geometry.closure(angles)
    for _ in range(MAX_ITERATIONS):
        if np.abs(residual).max() <= 1e-2 * CLOSED:
            break
        step = np.linalg.lstsq(jacobian, -residual, rcond=1e-9)[0]
        longest = float(np.abs(step).max(initial=0.0))
        if longest < 1e-15:
            break
        angles += step * min(1.0, LONGEST_STEP / longest)
        residual, jacobian = geometry.closure(angles)
    return angles, float(np.abs(residual).max())


def _singular_values(geometry: LoopGeometry, angles: Array) -> Array:
    return np.asarray(np.linalg.svd(geometry.jacobian(angles), compute_uv=False))


def _rank(values: Array) -> int:
    return int((values > RANK_TOLERANCE * values[0]).sum())

"""How badly loops fit: the gap that stays open along the motion that they nearly allow, and the hinge to align.

In: a `LoopGeometry`, a position at which its loops nearly close, and the rank that they have but for the misfit.
Out: a `Misfit`. Never: decides whether it is accepted.
"""

import math
from dataclasses import dataclass

import numpy as np

from lamc.loops.closing import SMALL, directions
from lamc.loops.geometry import LoopGeometry
from lamc.records.mechanism import Array

STEP = 0.1  # rad, of the joint that turns most
STEPS = 32  # each way: half a turn of that joint
WALKS = 2  # motions that are walked along, each both ways
APART = 0.05  # rad, or of the size: loops farther apart do not fit badly, they do not fit
ROUNDS = 6  # Gauss-Newton rounds after each step; two are the rule


@dataclass(frozen=True)
class Misfit:
    """Loops that close only nearly.

    rank   of the closure but for the misfit
    gap    m, the largest found over the motion that this rank allows; as `LoopGeometry.gaps`
    cut    the cut hinge that it was found at
    """

    rank: int
    gap: float  # m
    cut: str

    @property
    def text(self) -> str:
        return f"the loop closed by hinge {self.cut!r} closes only within {length(self.gap)} over its motion"


def measure_misfit(geometry: LoopGeometry, angles: Array, rank: int) -> Misfit | None:
    """Walks both ways along motions that `rank` allows from `angles` (n,), closing as well as can be.

    None where loops come apart on the way: then the rank is no misfit's, but too low.
    """
    _, vectors = directions(geometry, angles)
    worst = geometry.gaps(angles)
    for tangent in vectors[rank:][-WALKS:]:
        for way in (1.0, -1.0):
            gaps = _walk(geometry, angles, way * tangent, rank)
            if gaps is None:
                return None
            worst = np.maximum(worst, gaps)
    cut = int(np.argmax(worst))
    if worst[cut] > APART * geometry.size:
        return None
    return Misfit(rank, float(worst[cut]), geometry.names[geometry.tree_count + cut])


def _walk(geometry: LoopGeometry, angles: Array, tangent: Array, rank: int) -> Array | None:
    """Largest gaps (loops,), m, until half a turn or a singular position; None where loops come apart."""
    worst = np.zeros(geometry.loops)
    for _ in range(STEPS):
        angles = angles + tangent * (STEP / np.abs(tangent).max())
        for _ in range(ROUNDS):
            residual, jacobian = geometry.closure(angles)
            # By the normal equations: a third of the time, and the directions kept are well above their round-off.
            squares, vectors = np.linalg.eigh(jacobian.T @ jacobian)
            squares, across = squares[::-1][:rank], vectors[:, ::-1][:, :rank]
            if squares[-1] < SMALL**2 * squares[0]:
                return worst
            step = -across @ ((across.T @ (jacobian.T @ residual)) / squares)
            angles = angles + step
            if np.abs(step).max() < 1e-9:
                break
        if np.abs(residual).max() > APART:
            return None
        worst = np.maximum(worst, geometry.gaps(angles))
        tangent = tangent - across @ (across.T @ tangent)
    return worst


def length(value: float) -> str:
    """A length, m, in the unit that suits it, to two digits and not rounded down."""
    for scale, unit in ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm")):
        if value >= 0.1 * scale:
            return f"{rounded_up(value / scale):g} {unit}"
    return f"{rounded_up(value / 1e-9):g} nm"


def rounded_up(value: float) -> float:
    """`value` > 0 to two digits, upwards, so that what is reported as a limit is none too small."""
    exponent = math.floor(math.log10(value)) - 1
    return float(f"{math.ceil(value / 10.0**exponent * (1.0 - 1e-12))}e{exponent}")

"""How badly loops fit: the gap that stays open along the motion that they nearly allow, and where it is.

In: a `LoopGeometry`, places along a motion at which its loops nearly close. Out: a `Misfit`. Never: decides whether it
is accepted.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamc.loops.geometry import LoopGeometry
from lamc.loops.walks import LoopPosition
from lamc.records.mechanism import Array


@dataclass(frozen=True)
class Misfit:
    """Loops that close only nearly.

    rank   of the closure but for the misfit
    gap    m, the largest found over the motion that this rank allows; as `LoopGeometry.gaps`
    cut    the cut hinge that it was found at
    place  (3,), m, world, as drawn: the middle of the loop that is farthest from closing, such as a vertex
    farther  m, the gap half a radian farther along this motion, where it was looked at and is more than is allowed
    """

    rank: int
    gap: float  # m
    cut: str
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)  # m
    farther: float = 0.0  # m

    @property
    def text(self) -> str:
        return (
            f"the loop closed by hinge {self.cut!r} closes only within {length(self.gap)} over its motion, and fits "
            f"worst around {_millimetres(self.place)}"
        )


def measure_misfit(geometry: LoopGeometry, places: Sequence[LoopPosition], rank: int) -> Misfit:
    """The largest gap at the places of a walk that `rank` allows."""
    gaps = np.array([geometry.gaps(place.angles) for place in places])
    row, cut = (int(k) for k in np.unravel_index(np.argmax(gaps), gaps.shape))
    name = geometry.names[geometry.tree_count + cut]
    return Misfit(rank, float(gaps[row, cut]), name, _worst_place(geometry, places[row].angles))


def widest_gap(geometry: LoopGeometry, angles: Array) -> tuple[str, float]:
    """Where a loop is open most at some angles (n,), rad, and the widest gap, m."""
    return _millimetres(_worst_place(geometry, angles)), float(geometry.gaps(angles).max())


def _worst_place(geometry: LoopGeometry, angles: Array) -> tuple[float, float, float]:
    left = np.abs(geometry.rings.residual(angles)[0]).reshape(-1, 6).max(axis=1)
    x, y, z = geometry.cycles[int(np.argmax(left))].centre.tolist()
    return x, y, z


def _millimetres(place: tuple[float, float, float]) -> str:
    return f"({', '.join(f'{round(1e3 * x, 3) + 0.0:g}' for x in place)}) mm"


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

"""How much work the loops of a mechanism are, counted before any of it is done.

In: a `Mechanism`. Out: nothing, or the numbers, their limits and the way out. Never: counts a rank; looks at a clock,
so that a mechanism is taken or refused alike on every machine.
"""

from dataclasses import dataclass
from typing import NamedTuple, Self

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Mechanism


class Limits(NamedTuple):
    """Hinges; closing equations, six for each loop; hinges times rates that may be free, as a flat start is looked at
    by so many numbers."""

    hinges: int
    closing: int
    numbers: int


# Processor time from the file to results and pictures, from an empty cache, by `python -m benchmarks.large_drawings`
# (a core that adds 10^7 numbers in Python in 0.9 s; others take 0.6 of it): Yoshimura, Kresling and grid sheets of 736
# hinges, 16 x 16, 21 to 23 s; a grid of 1160, 20 x 20, 33; a flat Miura sheet of 32 x 32 facets, 1984 and 5766 closing
# equations, 39. Stages and progress are shown all along, and a run whose length nobody gives ends (run/defaults.py).
# Grids of 20 x 20 and of 21 x 21 squares with diagonals have 513 000 and 624 000 numbers, and take 24 and 26 s where a
# core adds the 10^7 numbers in 0.5 s; the Miura sheet has 0.1 million.
SOON = Limits(hinges=3000, closing=6000, numbers=640_000)
# Beyond that it takes one to three minutes, which is told. Grids of 31 x 31, 36 x 36 and 39 x 39 squares with diagonals
# have 2.9, 5.2 and 7.2 million numbers, and take 53, 95 and 134 s on a core that adds the 10^7 numbers in 0.5 s.
MOST = Limits(hinges=5000, closing=12_000, numbers=7_500_000)


@dataclass(frozen=True)
class Work:
    """Of a mechanism: its hinges and loops, and the rates that may be free where it is flat."""

    hinges: int
    loops: int

    @classmethod
    def of(cls, mechanism: Mechanism) -> Self:
        hinges = len(mechanism.joints)
        return cls(hinges, max(0, hinges - sum(not body.fixed for body in mechanism.bodies)))

    @property
    def free(self) -> int:
        """Of flat vertices, which have two equations that count; folded ones have three."""
        return max(0, self.hinges - 2 * self.loops)

    def is_within(self, limits: Limits) -> bool:
        """Trees always are: they take no survey."""
        within = self.hinges <= limits.hinges and 6 * self.loops <= limits.closing
        return not self.loops or (within and self.free <= limits.numbers // max(1, self.hinges))

    def text(self, limits: Limits) -> str:
        """What it has, and what is the matter with more than the limits."""
        return (
            f"the mechanism has {self.hinges} hinges, its loops have {6 * self.loops} closing equations, and "
            f"{self.free} rates are free where it is flat; with more than {limits.hinges}, {limits.closing} and "
            f"{limits.numbers // max(1, self.hinges)} it takes minutes until it runs"
        )


def check_work(mechanism: Mechanism, limits: Limits | None = None, *, large: bool = False) -> None:
    """Raises DesignError for loops that take minutes to survey, to derive and to compile, unless that is meant.
    limits: `MOST` where not given."""
    limits = limits or MOST
    work = Work.of(mechanism)
    if not large and not work.is_within(limits):
        raise DesignError(
            f"{work.text(limits)}: take a part of it, mark creases that do not fold as flat, or say that it is meant "
            "(--large, lamc.CompileOptions(large=True))"
        )


def long_work(mechanism: Mechanism) -> str:
    """What to tell of loops that take longer than `SOON`; empty of others."""
    work = Work.of(mechanism)
    return "" if work.is_within(SOON) else work.text(SOON)

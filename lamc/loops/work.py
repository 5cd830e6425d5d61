"""How much work the loops of a mechanism are, counted before any of it is done.

In: a `Mechanism`. Out: nothing, or a DesignError with the numbers, their limits and the way out. Never: counts a rank;
looks at a clock, so that a mechanism is taken or refused alike on every machine.
"""

from lamc.basics.errors import DesignError
from lamc.records.mechanism import Mechanism

# Processor time from the file to results and pictures, from an empty cache, by `python -m benchmarks.large_drawings`
# (a core that adds 10^7 numbers in Python in 0.9 s; others take 0.6 of it): Yoshimura, Kresling and grid sheets of 736
# hinges, 16 x 16, 21 to 23 s; a grid of 1160, 20 x 20, 33; a flat Miura sheet of 32 x 32 facets, 1984 and 5766 closing
# equations, 39. Stages and progress are shown all along, and a run whose length nobody gives ends (run/defaults.py).
MOST_HINGES = 3000
MOST_CLOSING = 6000  # six for each loop
# Hinges times rates that may be free: a flat start is looked at by as many numbers. A sheet of 31 x 31 squares with
# diagonals has 2.9 million, which take two minutes to decompose; those of 20 x 20 and of 21 x 21 have 513 000 and
# 624 000, and take 24 and 26 s where a core adds the 10^7 numbers in 0.5 s; the Miura sheet has 0.1 million.
MOST_NUMBERS = 640_000


def check_work(mechanism: Mechanism, *, large: bool = False) -> None:
    """Raises DesignError for loops that take minutes to survey, to derive and to compile, unless that is meant."""
    hinges = len(mechanism.joints)
    loops = max(0, hinges - sum(not body.fixed for body in mechanism.bodies))
    free = max(0, hinges - 2 * loops)  # of a flat vertex; a folded one takes a third
    most_free = MOST_NUMBERS // max(1, hinges)
    if large or not loops or (hinges <= MOST_HINGES and 6 * loops <= MOST_CLOSING and free <= most_free):
        return
    raise DesignError(
        f"the mechanism has {hinges} hinges, its loops have {6 * loops} closing equations, and {free} rates are free "
        f"where it is flat; with more than {MOST_HINGES}, {MOST_CLOSING} and {most_free} it takes minutes until it "
        "runs: take a part of it, mark creases that do not fold as flat, or say that it is meant (--large, "
        "lamc.CompileOptions(large=True))"
    )

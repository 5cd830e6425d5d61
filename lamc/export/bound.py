"""The most that a step of fixed length can cost, counted: for programs that must be done in time.

In: a program. Out: operations (+ - * / and square roots) and calls of functions. Comparisons, absolute values and moves
are not counted. The counts follow the loops of `runtime_c/src/`: `fixed.c`, `loops.c`, `system.c`, `guards.c` and
`cholesky.h`; `tests/test_export_bound.py` counts what really happens, and it is never more.
"""

from collections import Counter
from dataclasses import dataclass

from lamc.codegen.program import Program

ITERATIONS = 8  # at most, of bringing a state back to closure: MAX_ITERATIONS of loops.c
STAGES = 4  # of the classical Runge-Kutta method


@dataclass(frozen=True)
class Bound:
    """`operations` with those of the linear algebra; `calls` of sin, cos and the like."""

    operations: int
    calls: int


def spins(program: Program) -> tuple[int, ...]:
    """Which rates are those of a body that turns freely, beside the joints."""
    first = len(program.joints)
    return tuple(i for i, rate in enumerate(program.rates) if i >= first and rate.unit == "rad/s")


@dataclass(frozen=True)
class _Sizes:
    """Of the linear algebra: rates, coordinates, equations of loops, and how many of them are taken."""

    n: int
    nq: int
    m: int
    rank: int

    @property
    def cholesky(self) -> int:
        return sum(2 * k + 2 for i in range(self.n) for k in range(i + 1)) + self.n

    @property
    def lower(self) -> int:
        return self.n * (self.n + 1)

    @property
    def upper(self) -> int:
        return self.n * self.n

    def decompose(self, *, by_mass: bool) -> int:
        """Gram-Schmidt with pivots: norms of what is left, a root, a test, a division, and parts taken away."""
        taken = sum(
            2 * self.n * (self.m - k) + 2 + self.n + 4 * self.n * (self.m - k - 1) for k in range(self.rank)
        )
        return taken + (self.m * self.lower if by_mass else 0)

    @property
    def take(self) -> int:
        """Where equations fade: by mass, plainly, by mass, plainly, by mass."""
        return 3 * self.decompose(by_mass=True) + 2 * self.decompose(by_mass=False)

    @property
    def impose(self) -> int:
        return sum(2 + 2 * k for k in range(self.rank)) + self.rank * (4 * self.n + 1)

    @property
    def solve(self) -> int:
        return self.lower + self.impose + self.upper

    @property
    def settle(self) -> int:
        """Positions in ITERATIONS, then rates."""
        iteration = self.impose + self.upper + self.nq + 1 + self.take + 1
        rates = self.n + sum(2 * k for k in range(self.n)) + self.impose + self.upper + self.n
        return self.cholesky + self.take + ITERATIONS * (iteration + 1) + 2 + rates

    @property
    def bounce(self) -> int:
        """An impact: the gradient in the metric, its parts along the loops, the jump."""
        return self.lower + self.rank * 4 * self.n + 2 * self.n + 2 * self.n + 3 + self.upper + 2 * self.n


def step_bound(program: Program) -> Bound:
    """What `step_fixed` takes at most.

    Near a singular position every evaluation settles the loops first and evaluates twice; the end of the step settles
    them once more. At its end each guard may bring about one impact, after which all guards are looked at again.
    """
    n, m = len(program.rates), program.closure_count
    sizes = _Sizes(n, len(program.coordinates), m, min(program.rank, n))
    times: Counter[str] = Counter({"rates": STAGES})
    # Of the method itself; of the time, its length, 0.5 h and h / 6; in single precision, whether all is finite; and
    # how far each joint and the base turned
    inner = 15 * (len(program.coordinates) + n) + 24 + len(program.joints)
    inner += 2 * len(spins(program)) + (1 if spins(program) else 0)
    if program.cuts:
        settles = STAGES + 1
        times += Counter(
            dynamics=2 * STAGES,
            system=settles,
            closure=settles * (1 + ITERATIONS),
            rates=settles * ITERATIONS,
        )
        inner += 2 * STAGES * (sizes.cholesky + sizes.take) + STAGES * sizes.solve + settles * sizes.settle
    elif "acceleration" in program.functions:
        times["acceleration"] = STAGES
    else:
        times["system"] = STAGES
        inner += STAGES * (sizes.cholesky + sizes.lower + sizes.upper)
    if program.guards:
        count = len(program.guards)
        times += Counter(guards=2 + count, impacts=count)  # before a first step they are looked at, too
        mass = next(
            name for name in ("dynamics", "inertia", "system", "acceleration") if name in program.functions
        )
        times[mass] += count
        inner += count * (sizes.cholesky + (sizes.take if program.cuts else 0) + sizes.bounce + n)
    counted = [
        (count, program.functions[name].operations)
        for name, count in times.items()
        if name in program.functions
    ]
    return Bound(inner + sum(k * o.flops for k, o in counted), sum(k * o.calls for k, o in counted))

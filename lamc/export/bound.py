"""The most that a step of fixed length can cost, counted: for programs that must be done in time.

In: a program. Out: operations (+ - * / and square roots) and calls of functions. Comparisons, absolute values and moves
are not counted. The counts follow the loops of `runtime_c/src/`: `fixed.c`, `stiff.c` with what it calls, `loops.c`,
`system.c`, `guards.c` and `cholesky.h`; `tests/export/test_export_bound.py` counts what really happens, and it is
never more.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from lamc.export.options import ExportOptions
from lamc.run.methods import METHODS
from lamc.symbolic.pattern import Pattern, PlanStep
from lamc.symbolic.program import Program

ROUNDS = (
    6  # at most, of looking for an order of elimination: lamc_sparse_find, by tenths down to what is let go
)
ITERATIONS = 8  # at most, of bringing a state back to closure: MAX_ITERATIONS of loops.c
TRIES, EACH = (
    3,
    6,
)  # of places around a passage of a singular position, and how many each has: solve_around of loops.c
PLACES = TRIES * EACH
COUNTED = 12  # of the work of loops: lamc_loop_count_take and what counts beside it, for one elimination
RUNGE_KUTTA_STAGES, RODAS_STAGES = 4, int(METHODS["rodas5p"].least_evaluations)


@dataclass(frozen=True)
class Bound:
    """`operations` with those of the linear algebra; `calls` of sin, cos and the like."""

    operations: int
    calls: int


def spins(program: Program) -> tuple[int, ...]:
    """Which rates are those of a body that turns freely, beside the joints."""
    first = len(program.joints)
    return tuple(i for i, rate in enumerate(program.rates) if i >= first and rate.unit == "rad/s")


def _cholesky(n: int) -> int:
    return sum(2 * k + 2 for i in range(n) for k in range(i + 1)) + n


@dataclass(frozen=True)
class _Sizes:
    """Of the linear algebra: rates, coordinates, equations of loops, how many of them are taken at most, and the rates
    that have a mass of their own."""

    n: int
    nq: int
    m: int
    rank: int
    massive: tuple[int, ...]
    pattern: Pattern | None
    has_mass: bool  # written down; else functions of the model apply it

    @property
    def entries(self) -> int:
        """Of J."""
        return 0 if self.pattern is None else self.pattern.entry_count

    @property
    def plan(self) -> tuple[PlanStep, ...]:
        return () if self.pattern is None else self.pattern.plan

    @property
    def cholesky(self) -> int:
        return _cholesky(self.n)

    @property
    def most_free(self) -> int:
        """Directions that may be free: at a flat position fewer equations hold, and no fewer than none."""
        return self.n

    @property
    def lower(self) -> int:
        return self.n * (self.n + 1)

    @property
    def upper(self) -> int:
        return self.n * self.n

    @property
    def normalise(self) -> int:
        """Rows of J, and what stands beside them, to entries of one."""
        return 2 + self.entries + 5 * self.m

    @property
    def take(self) -> int:
        """J eliminated, and what the equations leave free, with its mass."""
        return self.order + self.rank + 1 + self._most(self._reduce) + COUNTED

    @property
    def order(self) -> int:
        """J eliminated."""
        return self._planned + self._found if self.plan else self._pivoted

    @property
    def look(self) -> int:
        """A little ahead of a passage, in large loops: a place, and what of its equations fades."""
        return 2 + 2 * self.n + self.normalise + self.order + 2 * self.m + COUNTED if self.plan else 0

    @property
    def _pivoted(self) -> int:
        """With complete pivoting."""
        n = self.n
        return sum(2 + max(self.m - k - 1, 0) * (1 + 2 * (n - k - 1)) for k in range(self.rank))

    @property
    def _planned(self) -> int:
        """By the plan, whose last pivot may turn out too small."""
        left = [len(step.left) for step in self.plan]
        return sum(3 + sum(2 * left[k] for k in step.updates) for step in self.plan)

    @property
    def _found(self) -> int:
        """Rows that wait are looked at once in each round, each freed of all steps."""
        row = sum(2 * (self.n - k) for k in range(self.rank))
        return ROUNDS * (self.m * row + 1) + 2 * self.rank

    def _most(self, counted: Callable[[int], int]) -> int:
        """Of `counted` by the number of equations that are taken: at a singular position it is below the rank."""
        return max(counted(taken) for taken in range(self.rank + 1))

    def _reduce(self, taken: int) -> int:
        free = self.n - taken
        return free * (taken * taken + taken + self.momenta + (free + 1) * self.n) + _cholesky(free)

    @property
    def prepare(self) -> int:
        return self.normalise + self.take

    @property
    def momenta(self) -> int:
        return sum(1 + 4 * i for i in self.massive) if self.has_mass else 0

    def along(self, taken: int) -> int:
        """The free part of a force, or rates from it."""
        free = self.n - taken
        return free * (2 * self.n + free + 1)

    @property
    def solve(self) -> int:
        solved = self._most(lambda taken: 2 * taken * taken + taken + 2 * self.along(taken))
        return solved + self.momenta + 2 * self.n

    @property
    def around(self) -> int:
        """A place beside a passage, and its part of the mean."""
        return 2 + 2 * self.nq + self.prepare + self.solve + 2 * self.n

    @property
    def openness(self) -> int:
        return 1 + 7 * self.m

    @property
    def settle(self) -> int:
        """Positions in ITERATIONS, then rates."""
        iteration = self.solve + self.nq + 1 + self.prepare + self.openness + 1
        rates = 2 * self.entries + self.solve + self.n
        return self.prepare + self.openness + ITERATIONS * iteration + 1 + rates

    @property
    def bounce(self) -> int:
        """An impact: the gradient in the metric, its part that loops leave free, the jump."""
        metric = 2 * self.along(0) if self.m else self.lower + self.upper
        return metric + 2 * self.n + 2 * self.n + 3 + 2 * self.n

    @property
    def find_lambda(self) -> int:
        return self.momenta + self.n + self.rank * (2 * self.rank + 1) + 2 * self.n * self.rank + self.m


@dataclass(frozen=True)
class _Work:
    """How often functions of the model are called, and operations beside them."""

    times: Counter[str]
    inner: int = 0

    def __add__(self, other: "_Work") -> "_Work":
        return _Work(self.times + other.times, self.inner + other.inner)


def step_bound(program: Program, options: ExportOptions) -> Bound:
    """What `step_fixed` takes at most.

    Near a singular position every evaluation asks in vain at PLACES closed places around it, settles the loops there
    and evaluates once more; the end of the step settles them again. At its end each guard may bring about one impact,
    after which all guards are looked at again.
    """
    sizes = _Sizes(
        n=len(program.rates),
        nq=len(program.coordinates),
        m=program.closure_count,
        rank=min(program.rank, len(program.rates)),
        massive=tuple(i for i, rate in enumerate(program.rates) if rate.name not in program.cuts),
        pattern=program.pattern,
        has_mass="residual" not in program.functions,
    )
    work = _stiff_step(program, sizes) if options.is_stiff else _explicit_step(program, sizes)
    work += _settling(sizes, 1) if program.cuts else _Work(Counter())
    work += _meeting(program, sizes)
    work += _telling(program)
    counted = [
        (count, program.functions[name].operations)
        for name, count in work.times.items()
        if name in program.functions
    ]
    return Bound(work.inner + sum(k * o.flops for k, o in counted), sum(k * o.calls for k, o in counted))


def _telling(program: Program) -> _Work:
    """What is done with the end of a step: how far each joint and the base turned, the time, and in single precision
    whether all is finite."""
    spinning = len(spins(program))
    return _Work(Counter(), 24 + len(program.joints) + 2 * spinning + (1 if spinning else 0))


def _accelerations(program: Program, sizes: _Sizes, count: int) -> _Work:
    if program.cuts:
        inner = count * (2 * sizes.prepare + 1 + sizes.solve + PLACES * sizes.around + TRIES * sizes.look)
        looks = count * TRIES if sizes.plan else 0
        times = Counter(rates=count * PLACES, closure=looks) + _prepared(sizes, count * (2 + PLACES))
        solved = Counter(residual=count * (1 + PLACES))
        return _Work(times + solved, inner) + _settling(sizes, count * (1 + PLACES))
    if "acceleration" in program.functions:
        return _Work(Counter(acceleration=count))
    return _Work(Counter(system=count), count * (sizes.cholesky + sizes.lower + sizes.upper))


def _settling(sizes: _Sizes, count: int) -> _Work:
    times = Counter(system=count, closure=count * (1 + ITERATIONS), rates=count * ITERATIONS)
    applied = count * ((1 + ITERATIONS) * sizes.most_free + ITERATIONS + 1)
    return _Work(times + Counter(momenta=applied), count * sizes.settle)


def _prepared(sizes: _Sizes, count: int) -> Counter[str]:
    """What is asked of the model at a place: M, f, J and γ, or J and γ, and M along each free direction."""
    return Counter(dynamics=count, constraints=count, momenta=count * sizes.most_free)


def _meeting(program: Program, sizes: _Sizes) -> _Work:
    """Guards: before a first step they are looked at, too."""
    count = len(program.guards)
    if not count:
        return _Work(Counter())
    inner = count * ((sizes.prepare if program.cuts else sizes.cholesky) + sizes.bounce + sizes.n)
    times = Counter(guards=3 + count, impacts=count)
    rates = _rates_of_guards(program, sizes)
    if program.cuts:
        return _Work(times + _prepared(sizes, count), inner) + rates
    mass = next(name for name in ("inertia", "system", "acceleration") if name in program.functions)
    return _Work(times + Counter({mass: count}), inner) + rates


def _rates_of_guards(program: Program, sizes: _Sizes) -> _Work:
    """Of guards that depend on rates: accelerations at both looks, and another look before and after impacts."""
    if "guard_changes" not in program.functions:
        return _Work(Counter())
    times = Counter(guard_changes=2, guards=2)
    return _Work(times, 4 * len(program.guards)) + _accelerations(program, sizes, 2)


def _explicit_step(program: Program, sizes: _Sizes) -> _Work:
    """Stages of the classical Runge-Kutta method, their sums, and whether the first slopes are finite."""
    work = _accelerations(program, sizes, RUNGE_KUTTA_STAGES)
    return work + _Work(Counter(rates=RUNGE_KUTTA_STAGES), 16 * (sizes.nq + sizes.n) + 1)


def _stiff_step(program: Program, sizes: _Sizes) -> _Work:
    """Stages of Rodas5P: sums, evaluations, and a linear system of the size of u where q̇ is u, else of q and u."""
    size, has_structure = sizes.nq + sizes.n, "rates" not in program.functions
    k = sizes.n if has_structure else size
    fill = 2 * k * k + 2 * k if has_structure else k
    factors = sum(row * (1 + 2 * row) for row in range(k)) + k
    solve = 2 * k * (k - 1) + k + (k * (2 + 2 * k) + 2 * k if has_structure else 0)
    inner = 2 + fill + factors
    for stage in range(RODAS_STAGES):
        sums = 2 * min(stage, 5) + 1 if stage < 6 else 1  # of the argument; the last two stages have one term
        inner += size * (sums + 2 * stage + 2) + 3 * k + solve + (2 if stage else 0)
    inner += (
        7 * size + 4
    )  # the new state, whether it is finite, and the norm of an error that is not looked at
    work = _Work(Counter(rates=RODAS_STAGES), inner)
    return work + _accelerations(program, sizes, RODAS_STAGES) + _jacobian(program, sizes)


def _jacobian(program: Program, sizes: _Sizes) -> _Work:
    """`linearise.c`: by the residuals, or by differences where their derivatives would be too long."""
    columns = sizes.nq + sizes.n + 1
    if "jacobian" not in program.functions:
        work = _accelerations(program, sizes, columns + 1)
        work += _Work(Counter(), columns * (3 + 3 * sizes.n))
        if "rates" in program.functions:
            work += _Work(Counter(rates=columns), (columns - 1) * (3 + 3 * sizes.nq))
        return work
    work = _accelerations(program, sizes, 1) + _Work(Counter(jacobian=1))
    if program.cuts:
        told = (1 + PLACES) * sizes.find_lambda + PLACES * 2 * sizes.m
        times = Counter(residual=1 + PLACES, momenta=columns)
        return work + _Work(times, columns * (sizes.m + sizes.solve) + told)
    work += _Work(Counter(), columns * (sizes.lower + sizes.upper))
    return work + _Work(Counter(inertia=1), sizes.cholesky) if "inertia" in program.functions else work

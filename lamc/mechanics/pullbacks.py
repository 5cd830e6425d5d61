"""Derivatives of weighted sums of what the equations give, for gradients of runs whatever the number of parameters.

Goes in: Equations. Comes out: jobs of a program, each of which takes weights and gives the derivatives of the
weighted sum by q, u and the sources: all values that depend on parameters only and that the functions read. What
parameters make of the sources is a job of its own, once for a run. With loops, and where the runtime solves M u̇ = f,
it is the residuals r = M u̇ - f - Jᵀλ and c = J u̇ + γ that are weighed, as in `tangents`; an acceleration that is
written down is weighed itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, cast

from lamc.basics.errors import RequestError
from lamc.mechanics.equations import Equations
from lamc.mechanics.linearise import loaded_residuals, second_derivative
from lamc.mechanics.tangents import drifts_of
from lamc.symbolic.program import Space
from lamc.symbolic.reverse import cotangents
from lamc.symbolic.scalars import Scalar, Value
from lamc.symbolic.staging import DrawnKey, Level
from lamc.symbolic.statements import count_operations

if TYPE_CHECKING:
    from lamc.mechanics.derive import Problem

MAX_FLOPS = 400_000  # of one evaluation: gcc takes some 20 s for so many
_STATE = (Space.CONSTANT, Space.TIME, Space.ANGLE, Space.RATE)
Job = tuple[tuple[str, str, tuple[Space, ...]], Sequence[Scalar]]

MOTION = (
    "motion_pullback",
    "derivatives of weighted accelerations, or residuals, by q, u and sources",
    (*_STATE, Space.ACCELERATION, Space.MULTIPLIER, Space.WEIGHT),
)
CLOSURE = (
    "closure_pullback",
    "derivatives of weighted residuals of the loops and of their rates by q, u and sources",
    (Space.CONSTANT, Space.ANGLE, Space.RATE, Space.WEIGHT),
)
GUARDS = (
    "guard_pullback",
    "derivatives of weighted guards by q, u, t and sources",
    (*_STATE, Space.WEIGHT),
)
POSES = ("pose_pullback", "derivatives of weighted poses by q, u and sources", (*_STATE, Space.WEIGHT))
ENERGY = (
    "energy_pullback",
    "derivatives of weighted energies by q, u and sources",
    (*_STATE, Space.WEIGHT),
)
SAMPLES = (
    "sample_pullback",
    "derivatives of weighted periods of the clocks, and of samples, by q, u and sources",
    (*_STATE, Space.WEIGHT),
)
IMPACTS = (
    "impact_pullback",
    "derivatives of weighted restitutions and directions of impacts, less z M x, and of mu J z + eta J x",
    (*_STATE, Space.WEIGHT),
)
SETUP = (
    "setup_pullback",
    "derivatives of weighted sources by parameters, then by numbers of the drawing",
    (Space.CONSTANT, Space.WEIGHT),
)


@dataclass
class Pullbacks:
    """jobs: all but what parameters make of the sources. sources: nodes of the store, ascending; behind them all have
    what clocks hold, as by `held`."""

    equations: Equations
    jobs: list[Job] = field(default_factory=list)
    sources: tuple[int, ...] = ()
    held: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        equations = self.equations
        found = [_motion(equations)]
        if equations.closure is not None:
            found.append(_closure(equations))
        if equations.guards:
            found.append(_weighed(equations, GUARDS, [terms.guard.value for terms in equations.guards]))
        found += _events(equations)
        found.append(_weighed(equations, POSES, equations.poses))
        found.append(_weighed(equations, ENERGY, list(equations.energies.values())))
        store = equations.store
        self.sources = tuple(
            sorted({i for _, ends in found for i in ends if store.levels[i] == Level.PARAMETER})
        )
        clocks = [terms.guard.clock for terms in equations.guards if terms.guard.clock is not None]
        self.held = tuple(symbol.index for clock in clocks for symbol in clock.held)
        self.jobs = [(job, self._outputs(job[0], ends)) for job, ends in found]
        values = [value for _, outputs in self.jobs[:2] for value in outputs]
        flops = count_operations(store, values, Level.PARAMETER).flops
        if flops > MAX_FLOPS:
            raise RequestError(
                f"a gradient of {equations.tree.mechanism.name!r}, which has {len(equations.rates)} rates, would take "
                f"{flops} operations an evaluation, more than {MAX_FLOPS}; take differences of runs instead"
            )

    def _outputs(self, name: str, ends: dict[int, Scalar]) -> list[Scalar]:
        equations = self.equations
        state = [*_symbols(equations, "q"), *_symbols(equations, "u")]
        values = [ends.get(symbol.index, 0) for symbol in state]
        if name in (GUARDS[0], IMPACTS[0]):
            values.append(_by_time(equations, ends))
        return [*values, *(ends.get(index, 0) for index in (*self.sources, *self.held))]

    def setup(self, drawn: Sequence[DrawnKey]) -> Job:
        """What parameters and numbers of the drawing, in this order, make of the sources."""
        store, equations = self.equations.store, self.equations
        weights = _weights(equations, len(self.sources))
        values = [Value(store, index, 1) for index in self.sources]
        with store.section("Sources by parameters", source="for gradients of a run"):
            ends = cotangents(store, values, weights, Level.NUMBER)
        own = [
            store.symbol(each.name, Space.PARAMETER, k).index for k, each in enumerate(equations.parameters)
        ]
        return SETUP, [ends.get(index, 0) for index in (*own, *(store.drawn[key] for key in drawn))]


def _symbols(equations: Equations, letter: str) -> list[Value]:
    space = {"q": Space.ANGLE, "u": Space.RATE, "udot": Space.ACCELERATION}[letter]
    entries = equations.coordinates if letter == "q" else equations.rates
    return [equations.store.symbol(f"{letter}_{c.name}", space, i) for i, c in enumerate(entries)]


def _weights(equations: Equations, count: int) -> list[Value]:
    return [equations.store.symbol(f"weight_{k}", Space.WEIGHT, k) for k in range(count)]


def _by_time(equations: Equations, ends: dict[int, Scalar]) -> Scalar:
    """By the time, with what follows a series."""
    store = equations.store
    total = ends.get(store.symbol("t", Space.TIME, 0).index, 0)
    for index, flow in store.flows.items():
        total = total + ends.get(index, 0) * Value(store, flow, 1)
    return total


def _weighed(
    equations: Equations, job: tuple[str, str, tuple[Space, ...]], values: Sequence[Scalar]
) -> tuple[tuple[str, str, tuple[Space, ...]], dict[int, Scalar]]:
    store = equations.store
    with store.section(f"{job[0].replace('_', ' ').capitalize()}", source="for gradients of a run"):
        return job, cotangents(store, values, _weights(equations, len(values)), Level.PARAMETER)


def _motion(equations: Equations) -> tuple[tuple[str, str, tuple[Space, ...]], dict[int, Scalar]]:
    flow = equations.coordinate_rates or ()
    if equations.closure is None and equations.is_plain:
        return _weighed(equations, MOTION, [*equations.acceleration, *flow])
    udot = _symbols(equations, "udot")
    residuals = equations.problem.residual(udot)
    if equations.closure is not None:
        residuals = [*loaded_residuals(equations, residuals), *second_derivative(equations, udot)]
    return _weighed(equations, MOTION, [*(-each for each in residuals), *flow])


def _closure(equations: Equations) -> tuple[tuple[str, str, tuple[Space, ...]], dict[int, Scalar]]:
    assert equations.closure is not None
    values = [*equations.closure.residual, *drifts_of(equations, _symbols(equations, "u"))]
    return _weighed(equations, CLOSURE, values)


def _events(equations: Equations) -> list[tuple[tuple[str, str, tuple[Space, ...]], dict[int, Scalar]]]:
    """Samples of clocks, and impacts, where there are any."""
    terms = equations.guards
    found = []
    clocks = [each.guard.clock for each in terms if each.guard.clock is not None]
    if clocks:
        samples = [value for clock in clocks for value in clock.held.values()]
        found.append(_weighed(equations, SAMPLES, [*(clock.period for clock in clocks), *samples]))
    if any(each.guard.restitution is not None for each in terms):
        nothing = (0,) * len(equations.rates)
        values = [0 if each.guard.restitution is None else each.guard.restitution for each in terms]
        values += [value for each in terms for value in each.gradient or nothing]
        found.append(_weighed(equations, IMPACTS, [*values, _balance_of_impact(equations, len(values))]))
    return found


def _balance_of_impact(equations: Equations, first: int) -> Scalar:
    """What a change of M and J makes of an impact's balance: less z M x, and mu J z + eta J x, whose factors stand
    behind the first weights and one that is one."""
    store, n = equations.store, len(equations.rates)
    count = 0 if equations.closure is None else len(equations.closure.jacobian)
    weights = _weights(equations, first + 1 + 2 * n + 2 * count)[first + 1 :]
    z, x, mu, eta = (weights[a:b] for a, b in pairwise((0, n, 2 * n, 2 * n + count, 2 * n + 2 * count)))
    with store.section("Balance of impacts", source="-z M x + mu J z + eta J x"):
        if equations.is_recursive:
            total: Scalar = 0
            for a, momentum in zip(z, cast("Problem", equations.problem).momenta(x), strict=True):
                total = total - a * momentum
        else:
            total = 0
            for (i, j), entry in sorted(equations.inertia.items()):
                pair = z[i] * x[j] if i == j else z[i] * x[j] + z[j] * x[i]
                total = total - entry * pair
        for k, row in enumerate(equations.closure.jacobian if equations.closure is not None else ()):
            for j, entry in row:
                total = total + entry * (mu[k] * z[j] + eta[k] * x[j])
    return total
